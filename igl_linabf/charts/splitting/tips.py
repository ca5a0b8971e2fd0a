"""Find seams to the tips of limbs that a map shrinks."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..._types import FloatArray, IntArray
from ...measures import Change, measure_change
from ...surface import Submesh, connected_labels
from ..cut_graphs import ClosedSurface
from ..features import CreasedSurface

TIP_STRETCH = 1.2  # minimum L2 stretch of a map for which seams to shrunk tips are sought
TIP_AREA_SHARE = 1 / 16  # maximum ratio of a face's area in the map to its area in space, at a shrunk tip
MIN_TIP_GAIN = 0.008  # minimum net gain of seams to tips: decrease of the L2 stretch minus price


@dataclass(frozen=True, eq=False)
class MapDistortion:
    """The distortion of a piece by its map, measured on first access."""

    piece: Submesh
    uv: FloatArray

    @cached_property
    def triangle_changes(self) -> Change:
        return measure_change(self.piece, self.uv)

    @cached_property
    def stretch(self) -> float:
        """The L2 stretch of the piece by its map."""
        return float(np.sqrt(self.triangle_changes.area_weighted_mean(self.triangle_changes.squared_stretch)))


def find_tips(F: IntArray, n: int, changed: Change, shrunk: float) -> tuple[IntArray, FloatArray]:
    """Find tips, where faces shrink below the factor `shrunk`; return a face, (#T,), and the stretch of each.

    The stretch of a tip is its contribution to the squared L2 stretch of the map, minus 1. The tips are
    sorted by stretch, largest first.
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


def measure_size_and_stretch(changed: Change) -> tuple[float, float]:
    """Return the square root of a surface's area, and the squared L2 stretch of its map."""
    return float(np.sqrt(changed.double_area.sum() / 2)), changed.area_weighted_mean(changed.squared_stretch)


def choose_worthwhile_seams(price: FloatArray, saved: FloatArray, total: float) -> tuple[IntArray, float]:
    """Choose the seams to tips that save more stretch than they cost; also return the total net gain.

    Seam k decreases the squared L2 stretch of the map, `total`, by `saved[k]`. Prices are in units of L2
    stretch.
    """
    left, chosen = total, list[int]()
    for k in range(len(price)):
        less = max(left - saved[k], 1.0)  # an isometric map has a squared L2 stretch of 1
        if np.sqrt(left) - np.sqrt(less) > price[k] > 0:
            chosen.append(k)
            left = less
    gain = float(np.sqrt(total) - np.sqrt(left) - price[chosen].sum())
    return np.array(chosen, dtype=np.int64), gain


def find_seams_to_tips(piece: Submesh, changed: Change, trade: float, hidden: FloatArray | None) -> IntArray:
    """Return the edges of seams from the boundary to shrunk tips, if the saved stretch is worth the seams.

    Edges are pairs of input vertices. `changed` is the distortion of the map. A seam that ends at a
    tip is assumed to restore the size of the faces there.
    """
    none = np.zeros((0, 2), dtype=np.int64)
    size, total = measure_size_and_stretch(changed)
    if trade == 0 or not TIP_STRETCH**2 < total < np.inf:
        return none
    faces, saved = find_tips(piece.F, len(piece.V), changed, TIP_AREA_SHARE)
    if not saved.sum() / (np.sqrt(total) + 1) >= MIN_TIP_GAIN:  # not worth it, even if seams cost nothing
        return none
    leaves = np.where(piece.topology.is_interior[piece.F[faces]], piece.F[faces], -1).max(axis=1)
    is_inside, closed, unit = (
        leaves >= 0,
        ClosedSurface.from_creased_surface(CreasedSurface(piece, hidden)),
        size * trade,
    )
    holes, nodes = np.arange(closed.graph.n_holes), closed.node[leaves[is_inside]]
    # no seam is worth more than the L2 stretch of the whole map minus 1
    distance, before, _ = closed.graph.find_shortest_paths(holes, limit=(np.sqrt(total) - 1) * unit)
    chosen, gain = choose_worthwhile_seams(distance[nodes] / unit, saved[is_inside], total)
    if gain < MIN_TIP_GAIN:
        return none
    return piece.vertices[closed.edges[closed.graph.find_edges_on_paths(before, nodes[chosen])]]
