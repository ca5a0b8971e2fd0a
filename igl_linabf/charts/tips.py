"""Seams to the tips that a map shrinks.

`find_seams` expects the stretch from a linear equation. At the end of a finger, where a few coarse faces
turn by half a sphere, a map shrinks far more than that. A short seam to such a tip may be worth its length.
"""

import numpy as np
from scipy.spatial import cKDTree

from .._types import FloatArray, IntArray
from ..measures import Change, change_of
from ..surface import Submesh, connected_labels
from .cut_graph import CREASE_DISCOUNT, closed_surface
from .visibility import HIDING

SHRUNK = 1 / 16  # of the area that a face at a tip has in the map, at most
TIPPED = 1.2  # L2 stretch of a map from which on there may be tips that are worth a seam
WORTH = 0.008  # L2 stretch that seams have to save beyond their price: the chart is flattened again


def tips_of(F: IntArray, n: int, changed: Change, shrunk: float) -> tuple[IntArray, FloatArray]:
    """A face at each tip that a map shrinks to less than a share, (#T,); and the squared L2 stretch there.

    That is what more than 1 there adds to the whole's. The tip that adds most comes first.
    """
    area, grown = changed.double_area / changed.double_area.sum(), changed.log_area_ratio
    small = np.flatnonzero(grown < np.log(shrunk))
    corners = F[small]
    tip = connected_labels(np.concatenate((corners[:, :2], corners[:, 1:])), n)[corners[:, 0]]
    order = np.lexsort((grown[small], tip))
    first = order[np.flatnonzero(np.diff(tip[order], prepend=-1))]
    saved = np.bincount(tip, (area * (changed.squared_stretch - 1))[small])[tip[first]]
    by_saved = np.argsort(-saved, kind="stable")
    return np.asarray(small[first[by_saved]], dtype=np.int64), np.asarray(saved[by_saved], dtype=np.float64)


def size_and_stretch(changed: Change) -> tuple[float, float]:
    """The square root of a surface's area, and the squared L2 stretch of its map."""
    double_area = float(changed.double_area.sum())
    return float(np.sqrt(double_area / 2)), float(changed.double_area @ changed.squared_stretch) / double_area


def worth_a_seam(saved: FloatArray, price: FloatArray, total: float) -> IntArray:
    """Which tips are worth the price of a seam to each, in L2 stretch; `total` is the whole's, squared."""
    chosen: list[int] = []
    for k in range(len(saved)):
        left = max(total - saved[k], 1.0)  # which is a map without stretch
        if np.sqrt(total) - np.sqrt(left) > price[k] > 0:
            chosen.append(k)
            total = left
    return np.array(chosen, dtype=np.int64)


def seams_to_tips(piece: Submesh, uv: FloatArray, trade: float, hidden: FloatArray | None) -> IntArray:
    """Edges, by the caller's vertices, from the boundary to tips that are worth it: L2 stretch for length.

    Cut to a tip, its faces are taken to keep their size.
    """
    none, changed = np.zeros((0, 2), dtype=np.int64), change_of(piece, uv)
    size, total = size_and_stretch(changed)
    if trade == 0 or not TIPPED**2 < total < np.inf:
        return none
    faces, saved = tips_of(piece.F, len(piece.V), changed, SHRUNK)
    # in space the boundary is no farther than on the surface, and a map of stretch 1 has none to save
    least = (1 - CREASE_DISCOUNT) / (1.0 if hidden is None else HIDING) / size / trade
    rim = cKDTree(piece.V[np.concatenate(piece.topology.loops)])
    price = least * rim.query(piece.V[piece.F[faces]])[0].min(axis=1, initial=np.inf)
    worth = saved / 2 > price
    faces, saved, price = faces[worth], saved[worth], price[worth]
    # of sqrt(total) - sqrt(left), where left is 1 at least
    if not np.maximum(saved / (np.sqrt(total) + 1) - price, 0).sum() >= WORTH:
        return none
    surface = closed_surface(piece, hidden)
    farthest = min(np.sqrt(total) - 1, saved.max() / 2) * size * trade  # whose price is all that it can save
    distance, before, _ = surface.search(np.arange(surface.holes), limit=farthest)
    leaves = surface.node[piece.F[faces]].max(axis=1)  # nodes of loops come first
    price = distance[leaves] / size / trade
    chosen = worth_a_seam(saved, price, total)
    left = np.sqrt(max(total - saved[chosen].sum(), 1.0))
    if np.sqrt(total) - left - price[chosen].sum() < WORTH:
        return none
    return piece.vertices[surface.edges[surface.paths(before, leaves[chosen])]]
