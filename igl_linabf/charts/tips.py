"""Seams to the tips that a map shrinks.

`find_seams` expects the stretch from a linear equation. At the end of a finger, where a few coarse faces
turn by half a sphere, a map shrinks far more than that. A short seam to such a tip may be worth its length.
"""

import numpy as np
from scipy.spatial import cKDTree

from .._types import FloatArray, IntArray
from ..measures import change_of
from ..surface import Submesh, connected_labels
from .cut_graph import CREASE_DISCOUNT, closed_surface
from .visibility import HIDING

SHRUNK = 1 / 16  # of the area that a face at a tip has in the map, at most


def seams_to_tips(piece: Submesh, uv: FloatArray, trade: float, hidden: FloatArray | None) -> IntArray:
    """Edges, by the caller's vertices, from the boundary to tips that are worth it: L2 stretch for length.

    Cut to a tip, its faces are taken to keep their size.
    """
    changed = change_of(piece, uv)
    area = changed.double_area / changed.double_area.sum()
    grown = changed.log_area_ratio
    small = np.flatnonzero(grown < np.log(SHRUNK))
    squared = area * changed.squared_stretch
    total = float(squared.sum())
    if trade == 0 or not len(small) or not np.isfinite(total):
        return np.zeros((0, 2), dtype=np.int64)
    F = piece.F[small]
    label = connected_labels(np.concatenate((F[:, :2], F[:, 1:])), len(piece.V))[F[:, 0]]
    saved = {
        tip: float((squared[small] - area[small])[label == tip].sum()) for tip in np.unique(label).tolist()
    }
    faces = {tip: piece.F[small[label == tip][np.argmin(grown[small[label == tip]])]] for tip in saved}
    # in space the boundary is no farther than on the surface, and a map of stretch 1 has none to save
    price = (1 - CREASE_DISCOUNT) / (1.0 if hidden is None else HIDING) / trade
    rim = cKDTree(piece.V[np.concatenate(piece.topology.loops)])
    size = float(np.sqrt(changed.double_area.sum() / 2))
    near = {tip: price * float(rim.query(piece.V[face])[0].min()) / size for tip, face in faces.items()}
    worth = sorted((tip for tip in saved if saved[tip] / 2 > near[tip]), key=lambda tip: -saved[tip])
    if not worth:
        return np.zeros((0, 2), dtype=np.int64)
    surface = closed_surface(piece, hidden)
    distance, before, _ = surface.search(np.arange(surface.holes))
    leaves: list[int] = []
    for tip in worth:
        leaf = int(surface.node[faces[tip]].max())  # nodes of loops come first
        left = max(total - saved[tip], 1.0)  # which is a map without stretch
        if np.sqrt(total) - np.sqrt(left) > distance[leaf] / size / trade > 0:
            leaves.append(leaf)
            total = left
    return piece.vertices[surface.edges[surface.paths(before, leaves)]]
