"""The seam of one body: it grows branch by branch, gets shorter, and becomes symmetric."""

from __future__ import annotations

import numpy as np

from ..._runtime import advance
from ..._types import IntArray
from ...surface import Submesh
from ..cut_graphs import (
    ClosedSurface,
    expected,
    join_terminals,
    log_scale,
    move_branch_points,
    open_handles,
    prune_branches,
    slide_into_valleys,
)
from .constants import MOST_BRANCHES, MOST_IN_VAIN, TIGHTENING, WORTH_OF_SYMMETRY, WORTH_OF_VALLEYS
from .symmetry import Mirror, mirrored

SeamAndLeaves = tuple[IntArray, IntArray]  # edges, and the nodes where branches end


def coarse_seam(coarse: ClosedSurface, trade: float, holes: bool, gain: float | None) -> SeamAndLeaves:
    """The seam of clusters of nodes; no edge if the cost falls by less than `gain`."""
    trade *= TIGHTENING
    seam, leaves = grow_seam(coarse, trade, holes)
    seam = if_it_pays(coarse, shorten_seam(coarse, seam, trade), trade, gain)
    return seam, np.intersect1d(leaves, coarse.graph.ends[seam])


def fine_seam(
    component: Submesh, closed: ClosedSurface, seam: IntArray, trade: float, holes: bool
) -> IntArray:
    """A seam made shorter, moved into valleys nearby, and made symmetric where that costs little."""
    seam = shorten_seam(closed, seam, trade)
    most = seam_cost(closed, seam, trade) + WORTH_OF_VALLEYS
    seam = slide_into_valleys(closed, seam, lambda moved: seam_cost(closed, moved, trade) < most)
    if trade > 0 and not closed.graph.genus:
        seam = symmetric_seam(component, closed, seam, trade, holes)
    return seam


def grow_seam(closed: ClosedSurface, trade: float, holes: bool) -> SeamAndLeaves:
    """A seam that opens handles, joins holes, and has branches to where the map would shrink or grow."""
    graph = closed.graph
    seam = leaves = np.zeros(0, dtype=np.int64)
    if graph.genus:
        seam = move_branch_points(graph, open_handles(closed), graph.length_of)
    if not holes:
        seam = join_terminals(graph, seam)
    if not graph.n_holes and not len(seam):
        seam, leaves = _open_sphere(closed)
    if trade > 0:
        seam, more = grow_branches(closed, seam, trade)
        leaves = np.append(leaves, more)
    return seam, leaves


def shorten_seam(closed: ClosedSurface, seam: IntArray, trade: float) -> IntArray:
    """The seam with its branch points moved; if seams are to be hidden, without branches that do not pay."""

    def cost(seam: IntArray) -> float:
        return seam_cost(closed, seam, trade)

    if closed.hides:
        seam = prune_branches(closed.graph, seam, cost)
    return move_branch_points(closed.graph, seam, cost)


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
        other = _open_sphere(surface, mirror)[0]
    other = grow_branches(surface, other, trade, mirror)[0]
    if surface.hides:
        other = prune_branches(
            surface.graph, other, lambda seam: seam_cost(surface, seam, trade), mirror.image
        )
    most = seam_cost(closed, seam, trade) + WORTH_OF_SYMMETRY
    return other if seam_cost(closed, other, trade) < most else seam


def _open_sphere(closed: ClosedSurface, mirror: Mirror | None = None) -> SeamAndLeaves:
    """A path to open a sphere, between the two points that would shrink most.

    With a mirror, between one of them and its image, or in the plane.
    """
    graph = closed.graph
    extra = closed.curvature - 4 * np.pi * closed.area / closed.area.sum()
    start = int(np.argmin(log_scale(closed, np.array([0]), extra) / closed.node_hiding))
    end = int(np.argmin(log_scale(closed, np.array([start]), closed.curvature) / closed.node_hiding))
    if mirror is not None:
        start, end = mirror.pair(start, end)
    distance, before, _ = graph.shortest_paths(np.array([start]))
    path = graph.path_edges(before, [end])
    if len(path) == 1:  # a single edge opens nothing
        distance[[start, end]] = np.inf
        path = np.append(path, graph.path_edges(before, [int(np.argmin(distance))]))
    return path, np.array([start, end])


def grow_branches(
    closed: ClosedSurface, seam: IntArray, trade: float, mirror: Mirror | None = None
) -> SeamAndLeaves:
    """Add branches one by one, or with mirror images; return the seam of least cost, and its leaves."""
    graph, leaves = closed.graph, list[int]()
    best, least, in_vain, in_best = seam, np.inf, 0, 0
    for _ in range(MOST_BRANCHES):
        if 1 + graph.length_of(seam) / closed.size / trade >= least:  # no stretch is less than 1
            break
        boundary = graph.boundary_nodes(seam)
        stretch, u = expected(closed, boundary)
        cost = stretch + graph.length_of(seam) / closed.size / trade
        advance("seams", 0.1)
        in_vain = 0 if cost < least else in_vain + 1
        if in_vain == 0:
            best, least, in_best = seam, cost, len(leaves)
        leaf = int(np.argmax(np.abs(u) / closed.node_hiding))
        if in_vain == MOST_IN_VAIN or u[leaf] == 0:
            break
        _, before, _ = graph.shortest_paths(boundary)
        path = graph.path_edges(before, [leaf])
        seam = np.append(seam, path) if mirror is None else mirror.with_both(graph, seam, leaf, path)
        leaves.append(leaf)
    return best, np.array(leaves[:in_best], dtype=np.int64)


def if_it_pays(closed: ClosedSurface, seam: IntArray, trade: float, gain: float | None) -> IntArray:
    """A seam, or no edge if the cost falls by less than `gain`."""
    if gain is not None and seam_cost(closed, seam[:0], trade) - seam_cost(closed, seam, trade) < gain:
        return seam[:0]
    return seam


def seam_cost(closed: ClosedSurface, seam: IntArray, trade: float) -> float:
    """The expected L2 stretch plus the length over `trade`."""
    length = closed.graph.length_of(seam) / closed.size
    if trade == 0:
        return length
    return expected(closed, closed.graph.boundary_nodes(seam))[0] + length / trade
