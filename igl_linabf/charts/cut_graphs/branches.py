"""Branches of a seam: those that do not pay are cut off, and branch points moved to where it is shorter."""

from collections.abc import Callable
from itertools import pairwise
from typing import TypeVar

import numpy as np

from ..._core import arcs_between
from ..._types import FloatArray, IntArray
from . import constants
from .graph import SurfaceGraph

Item = TypeVar("Item")  # of a seam: a branch point or an arc
Cost = Callable[[IntArray], float]  # of a seam
Steps = dict[int, list[tuple[int, int]]]  # from each node: the seam's edges, and where they lead
Arc = tuple[list[int], list[int]]  # edges in a row, and the nodes from the first to the last
ArcArrays = tuple[IntArray, IntArray]  # the same as arrays
EndedArc = tuple[IntArray, int]  # edges in a row, and the node at their end


def prune_branches(graph: SurfaceGraph, seam: IntArray, cost: Cost) -> IntArray:
    """Remove the branches without which `cost` is lower, the longest ones first.

    A later branch may have taken over what a branch was grown for.
    """
    kept, steps = graph.topology_of(seam), steps_of(graph, seam)
    tips = [node for node in sorted(steps) if len(steps[node]) == 1 and node >= graph.n_holes]
    arcs = [arcs_from(graph, steps, tip)[0][0] for tip in tips]
    longest_first = np.argsort([-graph.length_of(arc) for arc in arcs], kind="stable")
    for k in longest_first[: constants.MAX_MOVED_ARCS].tolist():
        rest = graph.difference(seam, arcs[k])
        opens = len(rest) > 1 or graph.n_holes  # a single edge opens nothing
        if opens and graph.topology_of(rest) == kept and cost(rest) < cost(seam):
            seam = rest
    return seam


def lengths_at(
    graph: SurfaceGraph, arcs: list[ArcArrays], length: FloatArray, most: float = np.inf
) -> FloatArray:
    """How long the arcs that begin or end at each node are, each up to so much, by lengths of edges."""
    own = np.minimum([length[edges].sum() for edges, _ in arcs], most)
    ends = [node for _, nodes in arcs for node in (nodes[0], nodes[-1])]
    return np.bincount(ends, np.repeat(own, 2), graph.n).astype(np.float64)


def longest(items: list[Item], length: Callable[[int], float]) -> list[Item]:
    """The longest items, in their order, so many as are moved; `length` is that of the k-th one."""
    if len(items) <= constants.MAX_MOVED_ARCS:
        return items
    lengths = np.array([length(k) for k in range(len(items))])
    chosen = np.argsort(-lengths, kind="stable")[: constants.MAX_MOVED_ARCS]
    return [items[k] for k in np.sort(chosen).tolist()]


def move_in_groups(
    items: list[Item], seam: IntArray, moved: Callable[[list[Item], IntArray], IntArray | None]
) -> IntArray:
    """The seam with all items moved together; where that is not accepted, halves of them, and so on."""
    waiting = [items]
    for _ in range(constants.MAX_MOVED_GROUPS):
        if not waiting:
            break
        group = waiting.pop()
        new = moved(group, seam)
        if new is not None:
            seam = new
        elif len(group) > 1:
            waiting += [group[len(group) // 2 :], group[: len(group) // 2]]
    return seam


def arcs_of(graph: SurfaceGraph, seam: IntArray, fixed: set[int] | None = None) -> list[ArcArrays]:
    """The arcs between tips, branch points, holes and fixed nodes; loops without any are arcs, too."""
    ends = graph.ends[seam]
    joint = np.bincount(ends.ravel(), minlength=graph.n) != 2
    joint[: graph.n_holes] = True
    if fixed:
        joint[list(fixed)] = True
    edges, nodes, start = arcs_between(ends, joint)
    return [(seam[edges[i:j]], nodes[i + k : j + k + 1]) for k, (i, j) in enumerate(pairwise(start.tolist()))]


def steps_of(graph: SurfaceGraph, seam: IntArray) -> Steps:
    """From each node of the seam: its edges, and where they lead."""
    steps: Steps = {}
    for edge, (i, j) in zip(seam.tolist(), graph.ends[seam].tolist(), strict=True):
        steps.setdefault(i, []).append((edge, j))
        steps.setdefault(j, []).append((edge, i))
    return steps


def replace_steps(graph: SurfaceGraph, steps: Steps, old: IntArray, new: IntArray) -> None:
    """Change the steps along a seam to those of one with other edges."""
    for edge, (i, j) in zip(old.tolist(), graph.ends[old].tolist(), strict=True):
        for a, b in ((i, j), (j, i)):
            steps[a].remove((edge, b))
            if not steps[a]:
                del steps[a]
    for edge, (i, j) in zip(new.tolist(), graph.ends[new].tolist(), strict=True):
        steps.setdefault(i, []).append((edge, j))
        steps.setdefault(j, []).append((edge, i))


def arcs_from(graph: SurfaceGraph, steps: Steps, branch: int) -> list[EndedArc]:
    """The arcs of the seam that start at a node, and the branch point, leaf or hole where they end."""
    arcs = list[EndedArc]()
    for step in steps.get(branch, []):
        edges, nodes = arc_from(graph, steps, set(), branch, step, np.inf)
        arcs.append((np.array(edges), nodes[-1]))
    return arcs


def arc_from(
    graph: SurfaceGraph, steps: Steps, fixed: set[int], node: int, step: tuple[int, int], reach: float
) -> Arc:
    """The arc that begins with a step, up to a joint or so far."""
    (edge, at), edges, nodes, limited = step, [step[0]], [node, step[1]], reach < np.inf
    while at != node and at >= graph.n_holes and at not in fixed and len(there := steps[at]) == 2:
        if limited:
            reach -= float(graph.length[edge])
            if reach <= 0:
                break
        edge, at = there[0] if there[0][0] != edge else there[1]
        edges.append(edge)
        nodes.append(at)
    return edges, nodes
