"""Prune the branches of a seam that cost more than they save, and move its branch points and arcs."""

from collections.abc import Callable
from itertools import combinations, pairwise
from typing import TypeVar

import numpy as np

from ..._core import split_arcs
from ..._types import FloatArray, IntArray
from ...surface import connected_labels
from .constants import MAX_MOVED_ARCS, STRICTLY_SHORTER
from .graph import SeamTopology, SurfaceGraph

MAX_MOVED_GROUPS = 12  # maximum number of attempts to move a group of arcs or branch points together

Item = TypeVar("Item")  # a branch point or an arc
Cost = Callable[[IntArray], float]  # maps the edges of a seam to its cost
Steps = dict[int, list[tuple[int, int]]]  # for each node, its seam edges and the node at the end of each edge
Arc = tuple[list[int], list[int]]  # consecutive edges of a seam, and the nodes along them
ArcArrays = tuple[IntArray, IntArray]  # an `Arc` stored as two arrays
EndedArc = tuple[IntArray, int]  # consecutive edges of a seam, and the node where they end

MOVES_OF_BRANCH_POINT = 3  # maximum number of attempted moves per branch point, on average
MAX_ARCS_OF_ALL_PAIRS = 6  # up to this many arcs at a branch point, all pairs of arcs are tried
NEAREST_ARCS = 2  # with more arcs, each arc is paired with this many of the nearest arcs


def move_branch_points(graph: SurfaceGraph, seam: IntArray, cost: Cost) -> IntArray:
    """Move each branch point of a seam to where its arcs are shortest, if this lowers `cost`.

    A branch point is tried again when one of its arcs has moved. If there are more than `MAX_MOVED_ARCS`
    branch points, only the branch points with the longest arcs are moved.
    """
    kept, steps = graph.find_seam_topology(seam), list_seam_steps(graph, seam)
    waiting = [node for node in sorted(steps) if len(steps[node]) >= 3]
    if len(waiting) > MAX_MOVED_ARCS:
        at = sum_arc_lengths_at_nodes(graph, find_arcs(graph, seam), graph.length)
        waiting = select_longest(waiting, lambda k: float(at[waiting[k]]))
    for _ in range(MOVES_OF_BRANCH_POINT * len(waiting)):
        if not waiting:
            break
        branch = waiting.pop(0)
        if len(steps.get(branch, ())) >= 3:
            moved, ends = _move_branch_point(
                graph, seam, follow_arcs(graph, steps, branch), branch, kept, cost
            )
            replace_steps(graph, steps, graph.subtract_seam(seam, moved), graph.subtract_seam(moved, seam))
            seam = moved
            waiting += sorted(ends.difference(waiting))
    return seam


def prune_branches(graph: SurfaceGraph, seam: IntArray, cost: Cost) -> IntArray:
    """Remove branches, longest first, if their removal lowers `cost`.

    A branch is no longer needed if a branch that was grown later reaches the same part of the surface.
    """
    kept, steps = graph.find_seam_topology(seam), list_seam_steps(graph, seam)
    tips = [node for node in sorted(steps) if len(steps[node]) == 1 and node >= graph.n_holes]
    arcs = [follow_arcs(graph, steps, tip)[0][0] for tip in tips]
    longest_first = np.argsort([-graph.measure_length(arc) for arc in arcs], kind="stable")
    for k in longest_first[:MAX_MOVED_ARCS].tolist():
        rest = graph.subtract_seam(seam, arcs[k])
        opens = len(rest) > 1 or graph.n_holes  # a cut along a single edge does not open a closed surface
        if opens and graph.find_seam_topology(rest) == kept and cost(rest) < cost(seam):
            seam = rest
    return seam


def sum_arc_lengths_at_nodes(
    graph: SurfaceGraph, arcs: list[ArcArrays], length: FloatArray, most: float = np.inf
) -> FloatArray:
    """Return the total length of the arcs that start or end at each node.

    `length` has the lengths of all edges. Each arc counts at most `most`.
    """
    own = np.minimum([length[edges].sum() for edges, _ in arcs], most)
    ends = [node for _, nodes in arcs for node in (nodes[0], nodes[-1])]
    return np.bincount(ends, np.repeat(own, 2), graph.n).astype(np.float64)


def select_longest(items: list[Item], length: Callable[[int], float]) -> list[Item]:
    """Return the `MAX_MOVED_ARCS` longest items, longest first; `length(k)` is the length of item k."""
    if len(items) <= MAX_MOVED_ARCS:
        return items
    lengths = np.array([length(k) for k in range(len(items))])
    chosen = np.argsort(-lengths, kind="stable")[:MAX_MOVED_ARCS]
    return [items[k] for k in np.sort(chosen).tolist()]


def move_in_groups(
    items: list[Item], seam: IntArray, move: Callable[[list[Item], IntArray], IntArray | None]
) -> IntArray:
    """Move all arcs or branch points at once. If `move` rejects this, move each half, and so on.

    `move` returns the new seam, or None if it rejects the move.
    """
    waiting = [items]
    for _ in range(MAX_MOVED_GROUPS):
        if not waiting:
            break
        group = waiting.pop()
        new = move(group, seam)
        if new is not None:
            seam = new
        elif len(group) > 1:
            waiting += [group[len(group) // 2 :], group[: len(group) // 2]]
    return seam


def _move_branch_point(
    graph: SurfaceGraph, seam: IntArray, arcs: list[EndedArc], branch: int, kept: SeamTopology, cost: Cost
) -> tuple[IntArray, set[int]]:
    """Move a branch point to where its arcs are shortest in total; also return the ends of moved arcs.

    A branch point that is a hole or has more than three arcs does not move. Instead, two of its arcs may be
    joined by a new branch.
    """
    free = len(arcs) == 3 and branch >= graph.n_holes
    for chosen in [tuple(arcs)] if free else _choose_nearby_pairs(graph, arcs):
        own_arcs, own_tips = zip(*chosen, strict=True)
        own = np.concatenate(own_arcs)
        rest, length = graph.subtract_seam(seam, own), graph.measure_length(own) / STRICTLY_SHORTER
        tips = [*own_tips, *[branch] * (not free)]
        label = connected_labels(graph.ends[rest], graph.n)
        groups = label[tips]
        if len(set(groups.tolist())) == 3:
            sets, avoid = [np.flatnonzero(label == group) for group in groups], None
        else:
            sets, avoid = [np.array([tip]) for tip in tips], graph.ends[rest].ravel()
        centre, ways = graph.find_steiner_tree((sets[0], sets[1], sets[2]), avoid, length)
        moved = graph.unite_seams(rest, ways)
        shorter = graph.measure_length(moved) < graph.measure_length(seam) * STRICTLY_SHORTER
        if centre >= 0 and shorter and graph.find_seam_topology(moved) == kept and cost(moved) < cost(seam):
            return moved, {*tips, centre}
    return seam, set()


def _choose_nearby_pairs(graph: SurfaceGraph, arcs: list[EndedArc]) -> list[tuple[EndedArc, EndedArc]]:
    """Return the pairs of arcs that may share a new branch: all pairs or, if there are many, near pairs."""
    pairs = list(combinations(range(len(arcs)), 2))
    if len(arcs) > MAX_ARCS_OF_ALL_PAIRS:
        at = graph.position[[graph.ends[arc[len(arc) // 4], 1] for arc, _ in arcs]]
        apart = np.linalg.norm(at[:, None] - at, axis=2)
        nearest = np.argsort(apart, axis=1, kind="stable")[:, 1 : 1 + NEAREST_ARCS]
        near = {(min(i, j), max(i, j)) for i, row in enumerate(nearest.tolist()) for j in row}
        pairs = sorted(near, key=lambda pair: float(apart[pair]))
    return [(arcs[i], arcs[j]) for i, j in pairs]


def find_arcs(graph: SurfaceGraph, seam: IntArray, fixed: set[int] | None = None) -> list[ArcArrays]:
    """Return the arcs of a seam, which end at leaves, branch points, holes and `fixed` nodes.

    A closed loop without such nodes is a single arc.
    """
    ends = graph.ends[seam]
    joint = np.bincount(ends.ravel(), minlength=graph.n) != 2
    joint[: graph.n_holes] = True
    if fixed:
        joint[list(fixed)] = True
    edges, nodes, start = split_arcs(ends, joint)
    return [(seam[edges[i:j]], nodes[i + k : j + k + 1]) for k, (i, j) in enumerate(pairwise(start.tolist()))]


def list_seam_steps(graph: SurfaceGraph, seam: IntArray) -> Steps:
    """Return for each node of a seam the seam edges at the node, with the node at the other end."""
    steps: Steps = {}
    for edge, (i, j) in zip(seam.tolist(), graph.ends[seam].tolist(), strict=True):
        steps.setdefault(i, []).append((edge, j))
        steps.setdefault(j, []).append((edge, i))
    return steps


def replace_steps(graph: SurfaceGraph, steps: Steps, old: IntArray, new: IntArray) -> None:
    """Update `steps`, in place, after the seam edges `old` were replaced with the edges `new`."""
    for edge, (i, j) in zip(old.tolist(), graph.ends[old].tolist(), strict=True):
        for a, b in ((i, j), (j, i)):
            steps[a].remove((edge, b))
            if not steps[a]:
                del steps[a]
    for edge, (i, j) in zip(new.tolist(), graph.ends[new].tolist(), strict=True):
        steps.setdefault(i, []).append((edge, j))
        steps.setdefault(j, []).append((edge, i))


def follow_arcs(graph: SurfaceGraph, steps: Steps, branch: int) -> list[EndedArc]:
    """Return the arcs that start at a node, with the branch point, leaf or hole where they end."""
    arcs = list[EndedArc]()
    for step in steps.get(branch, []):
        edges, nodes = follow_arc(graph, steps, set(), branch, step, np.inf)
        arcs.append((np.array(edges), nodes[-1]))
    return arcs


def follow_arc(
    graph: SurfaceGraph, steps: Steps, fixed: set[int], node: int, step: tuple[int, int], reach: float
) -> Arc:
    """Return the arc that starts at `node` along `step`, truncated to a length of about `reach`."""
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
