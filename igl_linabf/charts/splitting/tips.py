"""Seams to the tips that a map shrinks: before there is one, by its expected scale, and in a given one."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from ..._core import dihedrals, lengths, nearest_sources, nodes_on_paths, shortest_pairs
from ..._types import BoolArray, FloatArray, IntArray
from ...measures import Change, change_of
from ...surface import Submesh, connected_labels
from ..cut_graphs import CREASE_DISCOUNT, MAX_LOG_SCALE, ClosedSurface, expected_stretch, seam_lengths
from ..features import HIDING, Smoothing, face_normals, hiding_factors
from . import constants


def seams_to_fine_tips(piece: ClosedSurface, seam: IntArray, u: FloatArray, trade: float) -> IntArray:
    """Edges from a seam to tips that a map would shrink, where that is worth their length.

    `u` is nearly the conformal log scale of the nodes, (n,).
    """
    none, graph = np.zeros(0, dtype=np.int64), piece.graph
    on = graph.boundary_nodes(seam)
    u = _log_scale(piece, on, u)
    stretch = expected_stretch(piece, u)
    if not stretch > constants.TIP_STRETCH:
        return none
    area = piece.area / piece.area.sum()
    scale = float(area @ np.exp(2 * u))
    shrunk = np.exp(2 * u) < constants.TIP_AREA_SHARE * scale
    tip = connected_labels(graph.ends[shrunk[graph.ends].all(axis=1)], graph.n)
    more = np.where(shrunk, area * (scale * np.exp(-2 * u) - 1), 0.0)
    saved: FloatArray = np.bincount(tip, more).astype(np.float64)
    deepest = np.flatnonzero(shrunk)[np.argsort(-u[shrunk], kind="stable")]
    leaf = np.full(len(saved), -1)
    leaf[tip[deepest]] = deepest  # the last one stays
    tips = np.flatnonzero(leaf >= 0)
    tips = tips[np.argsort(-saved[tips], kind="stable")]
    if not len(tips):
        return none
    leaf, unit = leaf[tips], piece.size * trade
    distance, before, _ = graph.shortest_paths(on, limit=(stretch - 1) * unit)
    price, total = distance[leaf] / unit, stretch**2
    chosen = worth_a_seam(saved[tips], price, total)
    left = np.sqrt(max(total - saved[tips[chosen]].sum(), 1.0))
    if stretch - left - price[chosen].sum() < constants.MIN_TIP_GAIN:
        return none
    return graph.path_edges(before, leaf[chosen])


def _log_scale(piece: ClosedSurface, on: IntArray, u: FloatArray) -> FloatArray:
    """`log_scale` with zero at the nodes `on`, by conjugate gradients from `u`, to a coarse tolerance."""
    lower, free = piece.laplacian.lower, np.ones(piece.graph.n, dtype=bool)
    free[on] = False
    diagonal = lower.data[lower.indptr[:-1]]

    def flow(x: FloatArray) -> FloatArray:
        return np.where(free, lower @ x + lower.T @ x - diagonal * x, 0.0)

    u = np.where(free, u, 0.0)
    left = np.where(free, -piece.curvature, 0.0) - flow(u)
    scaled = left / diagonal
    direction, down = scaled.copy(), np.einsum("i,i->", left, scaled)
    for _ in range(constants.MAX_LOG_SCALE_STEPS):
        across = flow(direction)
        against = np.einsum("i,i->", direction, across)
        if not against > 0:
            break
        by = down / against
        u += by * direction
        left -= by * across
        if by * max(direction.max(), -direction.min()) <= constants.LAST_LOG_SCALE_CHANGE:
            break
        scaled = left / diagonal
        last, down = down, np.einsum("i,i->", left, scaled)
        direction = scaled + down / last * direction
    return np.clip(u, -MAX_LOG_SCALE, MAX_LOG_SCALE)


@dataclass(frozen=True, eq=False)
class MapMeasure:
    """What a map does to a piece, measured when it is asked for."""

    piece: Submesh
    uv: FloatArray

    @cached_property
    def at_triangles(self) -> Change:
        return change_of(self.piece, self.uv)

    @cached_property
    def stretch(self) -> float:
        """In L2."""
        return float(np.sqrt(self.at_triangles.mean(self.at_triangles.squared_stretch)))


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
    return float(np.sqrt(changed.double_area.sum() / 2)), changed.mean(changed.squared_stretch)


def worth_a_seam(saved: FloatArray, price: FloatArray, total: float) -> IntArray:
    """The tips whose seam saves more L2 stretch than its price; `total` is the squared stretch of the map."""
    chosen: list[int] = []
    for k in range(len(saved)):
        left = max(total - saved[k], 1.0)  # which is a map without stretch
        if np.sqrt(total) - np.sqrt(left) > price[k] > 0:
            chosen.append(k)
            total = left
    return np.array(chosen, dtype=np.int64)


def seams_to_tips(piece: Submesh, changed: Change, trade: float, hidden: FloatArray | None) -> IntArray:
    """Edges, by the caller's vertices, from the boundary to tips that are worth it: L2 stretch for length.

    `changed` is what the map does to the piece. Cut to a tip, its faces are taken to keep their size.
    """
    none = np.zeros((0, 2), dtype=np.int64)
    size, total = size_and_stretch(changed)
    if trade == 0 or not constants.TIP_STRETCH**2 < total < np.inf:
        return none
    faces, saved = tips_of(piece.F, len(piece.V), changed, constants.TIP_AREA_SHARE)
    if not saved.sum() / (np.sqrt(total) + 1) >= constants.MIN_TIP_GAIN:  # not even with seams for nothing
        return none
    interior = piece.topology.interior
    leaves = np.where(interior[piece.F[faces]], piece.F[faces], -1).max(axis=1)
    # in space the boundary is no farther than on the surface, and a map of stretch 1 has none to save
    shortest = (1 - CREASE_DISCOUNT) / (1.0 if hidden is None else HIDING)
    rim = scipy.spatial.cKDTree(piece.V[np.concatenate(piece.topology.loops)])
    apart = rim.query(piece.V[piece.F[faces]])[0].min(axis=1, initial=np.inf)
    unit = size * trade  # the length whose price is 1
    worth = (saved / 2 > shortest * apart / unit) & (leaves >= 0)
    leaves, saved, apart = leaves[worth], saved[worth], apart[worth]
    # of sqrt(total) - sqrt(left), where left is 1 at least
    gains = saved / (np.sqrt(total) + 1) - shortest * apart / unit
    if not np.maximum(gains, 0).sum() >= constants.MIN_TIP_GAIN:
        return none
    farthest = np.minimum(np.sqrt(total) - 1, saved / 2) * unit  # whose price is all that each can save
    length, before = _paths_from_boundary(piece, leaves, hidden, shortest, apart, farthest)
    chosen = worth_a_seam(saved, length / unit, total)
    left = np.sqrt(max(total - saved[chosen].sum(), 1.0))
    if np.sqrt(total) - left - length[chosen].sum() / unit < constants.MIN_TIP_GAIN:
        return none
    passed = nodes_on_paths(before, leaves[chosen])
    return piece.vertices[np.column_stack((passed, before[passed]))]


def _paths_from_boundary(
    piece: Submesh,
    leaves: IntArray,
    hidden: FloatArray | None,
    shortest: float,
    apart: FloatArray,
    farthest: FloatArray,
) -> tuple[FloatArray, IntArray]:
    """The lengths of the shortest paths from the boundary to some vertices, and each vertex's predecessor.

    `apart` are the distances of these in space from the boundary. No path is shorter than `shortest` times
    its span in space: so paths are sought near the vertices first. What is longer than `farthest` may be
    given as longer still.
    """
    rim, near = np.flatnonzero(~piece.topology.interior), np.zeros(len(piece.V), dtype=bool)
    sought = np.minimum(constants.FIRST_REACH * apart, farthest)
    for leaf, reach in zip(leaves.tolist(), (sought / shortest).tolist(), strict=True):
        near |= np.linalg.norm(piece.V - piece.V[leaf], axis=1) <= reach
        if np.count_nonzero(near) > constants.MAX_SHARE_WITHIN_REACH * len(near):
            near[:] = True
            break
    while True:
        ends, length = _edges_within(piece, near, hidden)
        indptr, indices, edge = shortest_pairs(ends, length, len(piece.V))
        distance, before, _ = nearest_sources(indptr, indices, length[edge], rim, near, float(farthest.max()))
        if near.all() or ((distance[leaves] <= sought) | (sought >= farthest)).all():
            return distance[leaves], before
        near[:] = True


def _edges_within(piece: Submesh, near: BoolArray, hidden: FloatArray | None) -> tuple[IntArray, FloatArray]:
    """The edges, by their vertices, between two that are near; and their lengths for a seam."""
    topology = piece.topology
    inside = piece.cuttable_edges
    inside = inside[near[topology.edges[inside]].all(axis=1)]
    bend = dihedrals(
        piece.V, topology.corner, np.ascontiguousarray(topology.sides[:, inside]), face_normals(piece)
    )
    ends = topology.edges[inside]
    length = seam_lengths(lengths(piece.V, ends), bend)
    if hidden is not None:
        every = topology.edges[piece.cuttable_edges]
        size = float(np.sqrt(piece.measured[0].sum() / 2))
        length *= hiding_factors(piece, ends, hidden, Smoothing(piece, every, lengths(piece.V, every)), size)
    return ends, length
