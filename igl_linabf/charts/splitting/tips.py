"""Seams to the tips that a map shrinks."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..._types import FloatArray, IntArray
from ...measures import Change, measure_change
from ...surface import Submesh, connected_labels
from ..cut_graphs import ClosedSurface
from ..features import CreasedSurface

TIP_STRETCH = 1.2  # L2 stretch of a map from which seams to its tips are sought
TIP_AREA_SHARE = 1 / 16  # share of its area that a face at a shrunk tip has in the map
MIN_TIP_GAIN = 0.008  # L2 stretch that seams to tips save beyond their price


@dataclass(frozen=True, eq=False)
class MapMeasure:
    """What a map does to a piece, measured when it is asked for."""

    piece: Submesh
    uv: FloatArray

    @cached_property
    def at_triangles(self) -> Change:
        return measure_change(self.piece, self.uv)

    @cached_property
    def stretch(self) -> float:
        """In L2."""
        return float(np.sqrt(self.at_triangles.mean(self.at_triangles.squared_stretch)))


def find_tips(F: IntArray, n: int, changed: Change, shrunk: float) -> tuple[IntArray, FloatArray]:
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
    return float(np.sqrt(changed.double_area.sum() / 2)), changed.mean(changed.squared_stretch)


def seams_worth(price: FloatArray, saved: FloatArray, total: float) -> tuple[IntArray, float]:
    """Choose the seams to tips that save more stretch than they cost; also return their total gain.

    A seam saves its part of the squared L2 stretch, which is `total`. Prices are in units of L2 stretch.
    """
    left, chosen = total, list[int]()
    for k in range(len(price)):
        less = max(left - saved[k], 1.0)  # which is a map without stretch
        if np.sqrt(left) - np.sqrt(less) > price[k] > 0:
            chosen.append(k)
            left = less
    gain = float(np.sqrt(total) - np.sqrt(left) - price[chosen].sum())
    return np.array(chosen, dtype=np.int64), gain


def seams_to_tips(piece: Submesh, changed: Change, trade: float, hidden: FloatArray | None) -> IntArray:
    """Edges, by the caller's vertices, from the boundary to tips that are worth it: L2 stretch for length.

    `changed` is the distortion of the map. Faces at a tip keep their size if a seam ends there.
    """
    none = np.zeros((0, 2), dtype=np.int64)
    size, total = size_and_stretch(changed)
    if trade == 0 or not TIP_STRETCH**2 < total < np.inf:
        return none
    faces, saved = find_tips(piece.F, len(piece.V), changed, TIP_AREA_SHARE)
    if not saved.sum() / (np.sqrt(total) + 1) >= MIN_TIP_GAIN:  # not even with seams for nothing
        return none
    leaves = np.where(piece.topology.interior[piece.F[faces]], piece.F[faces], -1).max(axis=1)
    is_inside, closed, unit = (
        leaves >= 0,
        ClosedSurface.of_creased(CreasedSurface(piece, hidden)),
        size * trade,
    )
    holes, nodes = np.arange(closed.graph.n_holes), closed.node[leaves[is_inside]]
    # a seam whose price is more than all stretch beyond 1 is worth nothing
    distance, before, _ = closed.graph.shortest_paths(holes, limit=(np.sqrt(total) - 1) * unit)
    chosen, gain = seams_worth(distance[nodes] / unit, saved[is_inside], total)
    if gain < MIN_TIP_GAIN:
        return none
    return piece.vertices[closed.edges[closed.graph.path_edges(before, nodes[chosen])]]
