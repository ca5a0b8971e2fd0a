"""The seam of one component: it grows leaf by leaf, gets shorter, and is mirrored if that costs little."""

from __future__ import annotations

import numpy as np

from ..._runtime import advance
from ..._types import FloatArray, IntArray
from ...surface import Submesh
from ..cut_graphs import (
    ClosedSurface,
    Cost,
    expected,
    join_terminals,
    log_scale,
    move_branch_points,
    open_handles,
    prune_branches,
)
from . import constants
from .symmetry import Mirror, mirrored

Grown = tuple[IntArray, IntArray]  # a seam, and its leaves


def seam_of_clusters(coarse: ClosedSurface, trade: float, holes: bool, gain: float | None) -> Grown:
    """The seam of clusters of nodes; no edge if the cost falls by less than `gain`."""
    trade *= constants.CLUSTER_TRADE_FACTOR
    seam, leaves = grown_seam(coarse, trade, holes)
    seam = if_it_pays(coarse, shorter_seam(coarse, seam, trade)[0], trade, gain)
    return seam, np.intersect1d(leaves, coarse.graph.ends[seam])


def grown_seam(closed: ClosedSurface, trade: float, holes: bool) -> Grown:
    """Edges to cut `closed` along."""
    none = np.zeros(0, dtype=np.int64)
    seam, leaves = open_handles(closed) if closed.graph.genus else none, none
    seam = move_branch_points(closed.graph, seam, closed.graph.length_of)
    if not holes:
        seam = join_terminals(closed.graph, seam)
    if not closed.graph.n_holes and not len(seam):
        seam, leaves = _slit(closed)
    if trade > 0:
        seam, grown = with_branches(closed, seam, trade)
        leaves = np.append(leaves, grown)
    return seam, leaves


def shorter_seam(closed: ClosedSurface, seam: IntArray, trade: float) -> tuple[IntArray, Cost]:
    """The seam with its branch points moved, and the cost of seams; a hidden one without idle branches."""
    known: dict[bytes, float] = {}  # one seam is compared with several others

    def cost(seam: IntArray) -> float:
        key = seam.tobytes()
        if key not in known:
            known[key] = seam_cost(closed, seam, trade)
        return known[key]

    if closed.hides:
        seam = prune_branches(closed.graph, seam, cost)
    return move_branch_points(closed.graph, seam, cost), cost


def symmetric_seam(
    component: Submesh, closed: ClosedSurface, seam: IntArray, trade: float, holes: bool
) -> IntArray:
    """A seam that is its own mirror image, if there is a mirror and it costs little more; else the seam."""
    known = mirrored(component, closed)
    if known is None:
        return seam
    surface, mirror = known
    other = join_terminals(surface.graph, seam[:0]) if not holes else seam[:0]
    if not closed.graph.n_holes:
        other = _slit(surface, mirror)[0]
    other = with_branches(surface, other, trade, mirror)[0]
    if surface.hides:
        other = prune_branches(
            surface.graph, other, lambda seam: seam_cost(surface, seam, trade), mirror.image
        )
    most = seam_cost(closed, seam, trade) + constants.SYMMETRY_COST
    return other if seam_cost(closed, other, trade) < most else seam


def _slit(closed: ClosedSurface, mirror: Mirror | None = None) -> Grown:
    """A path that opens a sphere, between the two points that would shrink most; and these points.

    With a mirror, it leads from one of them to its image, or lies in the plane.
    """
    extra = closed.curvature - 4 * np.pi * closed.area / closed.area.sum()
    start = int(np.argmin(log_scale(closed, np.array([0]), extra) / closed.node_hiding))
    end = int(np.argmin(log_scale(closed, np.array([start]), closed.curvature) / closed.node_hiding))
    if mirror is not None:
        start, end = mirror.pair(start, end)
    distance, before, _ = closed.graph.shortest_paths(np.array([start]))
    path = closed.graph.path_edges(before, [end])
    if len(path) == 1:  # a single edge opens nothing
        distance[[start, end]] = np.inf
        path = np.append(path, closed.graph.path_edges(before, [int(np.argmin(distance))]))
    return path, np.array([start, end])


def with_branches(closed: ClosedSurface, seam: IntArray, trade: float, mirror: Mirror | None = None) -> Grown:
    """Add branches one by one, or with mirror images; return the seam of least cost, and its leaves."""
    leaves: list[int] = []
    best, least, in_vain, in_best = seam, np.inf, 0, 0
    for _ in range(constants.MAX_LEAVES):
        if 1 + closed.graph.length_of(seam) / closed.size / trade >= least:  # no stretch is less than 1
            break
        fixed = closed.graph.boundary_nodes(seam)
        stretch, scale = expected(closed, fixed)
        cost = stretch + closed.graph.length_of(seam) / closed.size / trade
        advance("seams", 0.1)
        in_vain = 0 if cost < least else in_vain + 1
        if in_vain == 0:
            best, least, in_best = seam, cost, len(leaves)
        if in_vain == constants.MAX_LEAVES_IN_VAIN or not scale.any():
            break
        far, before, _ = closed.graph.shortest_paths(fixed)
        leaf = int(np.argmax(gain_of_leaves(closed, fixed, scale, far)))
        way = closed.graph.path_edges(before, [leaf])
        seam = np.append(seam, way) if mirror is None else mirror.with_both(closed.graph, seam, leaf, way)
        leaves.append(leaf)
    return best, np.array(leaves[:in_best], dtype=np.int64)


def gain_of_leaves(closed: ClosedSurface, fixed: IntArray, scale: FloatArray, far: FloatArray) -> FloatArray:
    """What a branch to each node would save, (n,), from the log scale that is `expected`.

    A conformal map shrinks tips: a branch helps most where u is farthest from zero. A branch lets w of an
    isometric map be something else at its node. How fast the integral of w^2 then falls is the solution of
    L x = w; many small bumps stretch that map, so it is compared by how `far` the node is from the seam.
    """
    if not closed.isometric:
        return np.abs(scale) / closed.node_hiding
    slope = closed.laplacian.dirichlet.solve(fixed, closed.area / closed.area.sum() * scale)
    return np.divide(np.abs(slope) / closed.node_hiding, far, out=np.zeros(len(far)), where=far > 0)


def if_it_pays(closed: ClosedSurface, seam: IntArray, trade: float, gain: float | None) -> IntArray:
    """A seam, or no edge if the cost falls by less than `gain`."""
    if gain is not None and seam_cost(closed, seam[:0], trade) - seam_cost(closed, seam, trade) < gain:
        return seam[:0]
    return seam


def seam_cost(closed: ClosedSurface, seam: IntArray, trade: float) -> float:
    """The expected L2 stretch plus the length over `trade`."""
    length = closed.graph.length_of(seam) / closed.size
    return length if trade == 0 else expected(closed, closed.graph.boundary_nodes(seam))[0] + length / trade
