"""Branches of a seam: branch points move to where it is shorter, and what does not pay is cut off."""

from collections.abc import Callable, Iterator
from itertools import combinations, pairwise
from typing import TypeVar

import numpy as np

from ..._core import arcs_between
from ..._types import FloatArray, IntArray
from ...surface import connected_labels
from .constants import MOST_MOVED, NEIGHBOURS_OF_ARC, SHORTER
from .graph import SurfaceGraph

Item = TypeVar("Item")  # of a seam: a branch point or an arc
Cost = Callable[[IntArray], float]  # of a seam
Steps = dict[int, list[tuple[int, int]]]  # from each node: the seam's edges, and where they lead
Arc = tuple[IntArray, IntArray]  # edges in a row, and the nodes from the first to the last
ArcTo = tuple[IntArray, int]  # edges in a row, and the node at their end


def move_branch_points(graph: SurfaceGraph, seam: IntArray, cost: Cost) -> IntArray:
    """Move the branch points, one after another, to where their arcs are shortest, if `cost` falls.

    A branch point is tried again when an arc of it has moved. If there are very many, those of the longest
    arcs are.
    """
    topology, steps = graph.topology_of(seam), steps_of(graph, seam)
    waiting = [node for node in sorted(steps) if len(steps[node]) >= 3]
    if not waiting:
        return seam
    if len(waiting) > MOST_MOVED:
        at = lengths_at(graph, arcs_of(graph, seam), graph.length)
        waiting = longest(waiting, lambda k: float(at[waiting[k]]))
    least = cost(seam)
    while waiting:
        branch = waiting.pop(0)
        if len(steps.get(branch, ())) < 3:
            continue
        for moved, ends in _moves_of(graph, seam, arcs_from(graph, steps, branch), branch):
            if graph.topology_of(moved) == topology and (its_cost := cost(moved)) < least:
                replace_steps(graph, steps, graph.difference(seam, moved), graph.difference(moved, seam))
                seam, least = moved, its_cost
                waiting += sorted(ends.difference(waiting))
                break
    return seam


def prune_branches(
    graph: SurfaceGraph, seam: IntArray, cost: Cost, image: Callable[[IntArray], IntArray] = np.sort
) -> IntArray:
    """The seam without those branches, the longest ones first, without which `cost` is lower.

    What they were grown for, a later branch may have done as well. With a mirror, the `image` of a branch
    goes together with it.
    """
    topology, steps = graph.topology_of(seam), steps_of(graph, seam)
    tips = [node for node in sorted(steps) if len(steps[node]) == 1 and node >= graph.n_holes]
    branches = [arcs_from(graph, steps, tip)[0][0] for tip in tips]
    least = cost(seam)
    for k in np.argsort([-graph.length_of(arc) for arc in branches], kind="stable")[:MOST_MOVED].tolist():
        rest = graph.difference(graph.difference(seam, branches[k]), image(branches[k]))
        opens = len(rest) > 1 or graph.n_holes  # a single edge opens nothing
        if opens and graph.topology_of(rest) == topology and (its_cost := cost(rest)) < least:
            seam, least = rest, its_cost
    return seam


def lengths_at(graph: SurfaceGraph, arcs: list[Arc], length: FloatArray, most: float = np.inf) -> FloatArray:
    """The total length of the arcs that end at each node, (n,); no arc counts more than `most`."""
    own = np.minimum([length[edges].sum() for edges, _ in arcs], most)
    ends = [node for _, nodes in arcs for node in (nodes[0], nodes[-1])]
    return np.bincount(ends, np.repeat(own, 2), graph.n).astype(np.float64)


def longest(items: list[Item], length: Callable[[int], float]) -> list[Item]:
    """Those items that may move, in their order: of many, the longest. `length` is that of the k-th item."""
    if len(items) <= MOST_MOVED:
        return items
    lengths = np.array([length(k) for k in range(len(items))])
    return [items[k] for k in np.sort(np.argsort(-lengths, kind="stable")[:MOST_MOVED]).tolist()]


def move_in_groups(
    items: list[Item], seam: IntArray, move: Callable[[list[Item], IntArray], IntArray | None]
) -> IntArray:
    """The seam with all items moved together; where `move` returns None, halves of them, and so on."""
    waiting = [items]
    for _ in range(MOST_MOVED // 2):
        if not waiting:
            break
        group = waiting.pop()
        new = move(group, seam)
        if new is not None:
            seam = new
        elif len(group) > 1:
            waiting += [group[len(group) // 2 :], group[: len(group) // 2]]
    return seam


def _moves_of(
    graph: SurfaceGraph, seam: IntArray, arcs: list[ArcTo], branch: int
) -> Iterator[tuple[IntArray, set[int]]]:
    """Shorter seams: arcs at `branch` start at the point from which they are shortest. With the arcs' ends.

    If more than three arcs meet, or at a hole, two of them may share a new branch.
    """
    free = len(arcs) == 3 and branch >= graph.n_holes
    for chosen in [tuple(arcs)] if free else _nearby_pairs(graph, arcs):
        own = np.concatenate([arc for arc, _ in chosen])
        rest, length = graph.difference(seam, own), graph.length_of(own) / SHORTER
        tips = [tip for _, tip in chosen] + [branch] * (not free)
        label = connected_labels(graph.ends[rest], graph.n)
        groups = label[tips]
        if len(set(groups.tolist())) == 3:
            sets, avoid = [np.flatnonzero(label == group) for group in groups], None
        else:
            sets, avoid = [np.array([tip]) for tip in tips], graph.ends[rest].ravel()
        centre, paths = graph.steiner_tree((sets[0], sets[1], sets[2]), avoid, length)
        moved = graph.union(rest, paths)
        if centre >= 0 and graph.length_of(moved) < graph.length_of(seam) * SHORTER:
            yield moved, {*tips, centre}


def _nearby_pairs(graph: SurfaceGraph, arcs: list[ArcTo]) -> list[tuple[ArcTo, ArcTo]]:
    """Pairs of arcs at a node that may share a part of their way: each arc with those nearest to it."""
    at = graph.position[[graph.ends[arc[len(arc) // 4], 1] for arc, _ in arcs]]
    apart = np.linalg.norm(at[:, None] - at, axis=2)
    nearest = np.argsort(apart, axis=1, kind="stable")[:, 1 : 1 + NEIGHBOURS_OF_ARC].tolist()
    return [
        (arcs[i], arcs[j]) for i, j in combinations(range(len(arcs)), 2) if j in nearest[i] or i in nearest[j]
    ]


def arcs_of(graph: SurfaceGraph, seam: IntArray, fixed: set[int] | None = None) -> list[Arc]:
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
    replace_steps(graph, steps, seam[:0], seam)
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


def arcs_from(graph: SurfaceGraph, steps: Steps, start: int) -> list[ArcTo]:
    """The arcs of the seam that start at a node, and the branch point, leaf or hole where they end."""
    arcs = list[ArcTo]()
    for step in steps.get(start, []):
        edges, nodes = arc_from(graph, steps, set(), start, step, np.inf)
        arcs.append((np.array(edges), nodes[-1]))
    return arcs


def arc_from(
    graph: SurfaceGraph, steps: Steps, fixed: set[int], start: int, step: tuple[int, int], reach: float
) -> tuple[list[int], list[int]]:
    """The edges and nodes of the arc that begins with a step, up to its end or to the length `reach`."""
    (edge, at), edges, nodes, limited = step, [step[0]], [start, step[1]], reach < np.inf
    while at != start and at >= graph.n_holes and at not in fixed and len(there := steps[at]) == 2:
        if limited:
            reach -= float(graph.length[edge])
            if reach <= 0:
                break
        edge, at = there[0] if there[0][0] != edge else there[1]
        edges.append(edge)
        nodes.append(at)
    return edges, nodes
