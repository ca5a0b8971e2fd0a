"""Find the seam of one component: grow it branch by branch, then shorten it."""

from __future__ import annotations

import numpy as np

from ..._runtime import advance
from ..._types import FloatArray, IntArray
from ..cut_graphs import (
    ClosedSurface,
    join_terminals,
    move_branch_points,
    open_handles,
    predict_stretch,
    prune_branches,
    solve_log_scale,
)
from . import constants

# Minimum net gain for which a disk is cut, as a seam length in square roots of the area.
DISK_GAIN = 0.3

SeamAndTips = tuple[IntArray, IntArray]  # the edges of a seam, and the nodes at the tips of its branches


def grow_seam(closed: ClosedSurface, trade: float, keep_holes: bool) -> SeamAndTips:
    """Return the edges along which a closed surface is cut, and the nodes at the tips of the branches."""
    none = np.zeros(0, dtype=np.int64)
    seam, leaves = open_handles(closed) if closed.graph.genus else none, none
    seam = move_branch_points(closed.graph, seam, closed.graph.measure_length)
    if not keep_holes:
        seam = join_terminals(closed.graph, seam)
    if not closed.graph.n_holes and not len(seam):
        seam, leaves = _find_slit(closed)
    if trade > 0:
        seam, grown = add_branches(closed, seam, trade)
        leaves = np.append(leaves, grown)
    return seam, leaves


def shorten_seam(closed: ClosedSurface, seam: IntArray, trade: float) -> IntArray:
    """Shorten a seam by moving its branch points; if edges are hidden, first prune branches."""
    known: dict[bytes, float] = {}  # costs of the seams evaluated so far

    def measure_cost(seam: IntArray) -> float:
        key = seam.tobytes()
        if key not in known:
            known[key] = compute_seam_cost(closed, seam, trade)
        return known[key]

    if closed.has_hidden_edges:
        seam = prune_branches(closed.graph, seam, measure_cost)
    return move_branch_points(closed.graph, seam, measure_cost)


def _find_slit(closed: ClosedSurface) -> SeamAndTips:
    """Return a path that opens a sphere, from one of the points that a map would shrink most to another."""
    extra = closed.curvature - 4 * np.pi * closed.area / closed.area.sum()
    start = int(np.argmin(solve_log_scale(closed, np.array([0]), extra) / closed.hiding_at_nodes))
    end = int(
        np.argmin(solve_log_scale(closed, np.array([start]), closed.curvature) / closed.hiding_at_nodes)
    )
    distance, before, _ = closed.graph.find_shortest_paths(np.array([start]))
    path = closed.graph.find_edges_on_paths(before, [end])
    if len(path) == 1:  # a cut along a single edge does not open a sphere
        distance[[start, end]] = np.inf
        path = np.append(path, closed.graph.find_edges_on_paths(before, [int(np.argmin(distance))]))
    return path, np.array([start, end])


def add_branches(closed: ClosedSurface, seam: IntArray, trade: float) -> SeamAndTips:
    """Add branches one by one; return the seam of least cost and the tips of its branches."""
    leaves: list[int] = []
    best, least, in_vain, in_best = seam, np.inf, 0, 0
    for _ in range(constants.MAX_BRANCHES):
        if 1 + closed.graph.measure_length(seam) / closed.size / trade >= least:  # lower bound of the cost
            break
        fixed = closed.graph.find_boundary_nodes(seam)
        stretch, scale = predict_stretch(closed, fixed)
        cost = stretch + closed.graph.measure_length(seam) / closed.size / trade
        advance("seams", 0.1)
        in_vain = 0 if cost < least else in_vain + 1
        if in_vain == 0:
            best, least, in_best = seam, cost, len(leaves)
        if in_vain == constants.MAX_IDLE_BRANCHES or not scale.any():
            break
        far, before, _ = closed.graph.find_shortest_paths(fixed)
        leaf = int(np.argmax(estimate_branch_gains(closed, fixed, scale, far)))
        seam = np.append(seam, closed.graph.find_edges_on_paths(before, [leaf]))
        leaves.append(leaf)
    return best, np.array(leaves[:in_best], dtype=np.int64)


def estimate_branch_gains(
    closed: ClosedSurface, fixed: IntArray, scale: FloatArray, far: FloatArray
) -> FloatArray:
    """Estimate how much stretch a branch from the seam to each node would save, (n,).

    `scale` comes from `predict_stretch`. For a conformal map it is the log scale, and a branch saves most
    where the log scale is farthest from zero. For an isometric map it is the strain trace w, and a branch
    removes the constraint L w = -K at its node, where L is the Laplacian and K the curvature. The integral of
    w^2 then decreases at a rate proportional to the solution x of L x = w. Because an isometric map is
    stretched by many small bumps, x is divided by the distance `far` of the node from the seam.
    """
    if not closed.isometric:
        return np.abs(scale) / closed.hiding_at_nodes
    slope = closed.laplacian.dirichlet_solver.solve(fixed, closed.area / closed.area.sum() * scale)
    return np.divide(np.abs(slope) / closed.hiding_at_nodes, far, out=np.zeros(len(far)), where=far > 0)


def keep_seam_if_worth(closed: ClosedSurface, seam: IntArray, trade: float) -> IntArray:
    """Return the seam if it saves at least `DISK_GAIN` compared with an uncut surface, otherwise no edges."""
    gain = compute_seam_cost(closed, seam[:0], trade) - compute_seam_cost(closed, seam, trade)
    return seam if gain >= DISK_GAIN / trade else seam[:0]


def compute_seam_cost(closed: ClosedSurface, seam: IntArray, trade: float) -> float:
    """Return the expected cost of a seam: L2 stretch minus 1, plus the seam's price divided by `trade`."""
    length = closed.graph.measure_length(seam) / closed.size
    if trade == 0:
        return length
    return predict_stretch(closed, closed.graph.find_boundary_nodes(seam))[0] - 1 + length / trade
