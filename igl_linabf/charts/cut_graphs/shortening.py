"""Seams made shorter: each arc straightened, and each branch point moved."""

from itertools import pairwise

import numpy as np

from ..._core import lengths, meeting, ways_towards
from ..._types import BoolArray, IntArray
from .branches import (
    ArcArrays,
    arc_from,
    arcs_of,
    lengths_at,
    longest,
    move_in_groups,
    replace_steps,
    steps_of,
)
from .closed_surface import ClosedSurface
from .constants import MAX_MOVED_ARCS, MIN_KEPT_PART, STRICTLY_SHORTER


class _Corridor:
    """The nodes that a seam may pass when it moves, and the edges between them.

    `index` is the place of each node of the surface among those of the corridor.
    """

    def __init__(self, closed: ClosedSurface, near: BoolArray, seam: IntArray) -> None:
        self.graph = graph = closed.graph
        _, cycles, sizes = self._pieces = graph.pieces_of(seam)
        self.is_tree = not cycles  # the seam then opens the same whichever way its arcs go
        self.has_parts = len(sizes) > 1  # arcs that stay in their places leave as many
        self._nodes = np.flatnonzero(near)
        self.index = np.full(graph.n, -1)
        self.index[self._nodes] = np.arange(len(self._nodes))
        adjacency, edge = graph.adjacency
        matrix = adjacency.copy()
        matrix.data = edge
        self._matrix = matrix[self._nodes][:, self._nodes]
        self.length = graph.length
        self._matrix.data = self.length[self._matrix.data]
        self._position = graph.position[self._nodes]
        in_space = near & (np.arange(graph.n) >= graph.n_holes)  # a hole is in no one place
        inside = np.flatnonzero(in_space[graph.ends[:, 0]] & in_space[graph.ends[:, 1]])
        straight = lengths(graph.position, graph.ends[inside])
        self._share = float(np.min(self.length[inside] / straight, initial=1.0, where=straight > 0))

    def opens(self, moved: IntArray) -> bool:
        """Whether a seam that has moved still opens what it opened, and no part has become small."""
        number, cycles, sizes = self._pieces
        *new, parts = self.graph.pieces_of(moved)
        same = new == [number, cycles] and len(parts) == len(sizes)
        return same and bool((parts >= MIN_KEPT_PART * sizes).all())

    def in_place(self, node: int, old: int, new: int, on: BoolArray) -> bool:
        """Whether two edges at a node lie between the same edges of the rest of the seam, a mask.

        What is cut along it then has the node on the same boundary, whichever of the two an arc begins with.
        Arcs that do so at both ends, and pass no other arc, open the same.
        """
        if self.is_tree or old == new:
            return True
        faces, (matrix, edge) = self.graph.faces, self.graph.adjacency
        around = np.append(edge[matrix.indptr[node] : matrix.indptr[node + 1]], (old, new))
        reached, waiting = set[int](faces[old].tolist()), True
        sides = faces[around[~on[around]]].tolist()
        while waiting:
            waiting = False
            for a, b in sides:
                if (a in reached) != (b in reached):
                    reached |= {a, b}
                    waiting = True
        return int(faces[new, 0]) in reached

    def length_of(self, edges: IntArray) -> float:
        return float(self.length[edges].sum())

    def blocked_at(self, nodes: IntArray) -> BoolArray:
        """A mask of the corridor's nodes: no path passes these."""
        blocked = np.zeros(len(self._nodes), dtype=bool)
        blocked[self.index[nodes]] = True
        return blocked

    def shortest_path(self, source: int, target: int, blocked: BoolArray, limit: float) -> IntArray:
        """The nodes of the shortest path from the target back to the source, if it is within `limit`.

        The two are given by their places in the corridor. Of a longer path, the target alone.
        """
        is_open, matrix = ~blocked, self._matrix
        is_open[source] = True
        aim = self._position[[target] if self._nodes[target] >= self.graph.n_holes else []]
        rest = self._position, aim, self._share, limit * (1 + 1e-9)
        _, before = ways_towards(matrix.indptr, matrix.indices, matrix.data, source, is_open, *rest)
        nodes, at = [target], int(before[target])
        while at >= 0:
            nodes.append(at)
            at = int(before[at])
        return np.asarray(self._nodes[nodes])

    def steiner_tree(self, tips: IntArray, blocked: BoolArray, limit: float) -> list[IntArray]:
        """The paths to three nodes, given by their places, from where they are shortest in total.

        They are empty if the total is over the limit.
        """
        matrix, terminals = self._matrix, (tips[:1], tips[1:2], tips[2:])
        nodes, start = meeting(matrix.indptr, matrix.indices, matrix.data, terminals, ~blocked, limit)
        return [self._nodes[nodes[i:j]] for i, j in pairwise(start.tolist())]


def pull_tight(
    closed: ClosedSurface, seam: IntArray, kept: IntArray, near: BoolArray, reach: float
) -> IntArray:
    """A seam of the same topology that is no longer, and passes the same points.

    Parameters
    ----------
    closed : ClosedSurface
    seam : (#S,) int64
        Its edges.
    kept : (#K,) int64
        Nodes that it goes on to pass.
    near : (n,) bool
        The nodes that it may pass; those of the seam are among them.
    reach : float
        How far from a branch point its three arcs may move.
    """
    corridor, fixed = _Corridor(closed, near, seam), set(kept.tolist())
    straight = _straighten_arcs(corridor, seam, fixed, seam[:0])
    moved = _move_branch_points_by(corridor, straight, fixed, reach)
    moved = _straighten_arcs(corridor, moved, fixed, straight)
    return moved if corridor.is_tree or corridor.has_parts or corridor.opens(moved) else seam


def _straighten_arcs(corridor: _Corridor, seam: IntArray, fixed: set[int], known: IntArray) -> IntArray:
    """Each arc, but those of known edges, by the shortest path that the corridor and the other arcs allow."""
    graph = corridor.graph

    def move(arcs: list[ArcArrays], seam: IntArray) -> IntArray | None:
        blocked, on, old = corridor.blocked_at(graph.ends[seam]), graph.mask_of(seam), seam
        for edges, nodes in arcs:
            length, places = corridor.length_of(edges), corridor.index[nodes]
            blocked[places[1:]] = False
            path = corridor.shortest_path(int(places[0]), int(places[-1]), blocked, length)
            if len(path) > 1:
                new = graph.edges_between(path[:-1], path[1:])
                one = len(new) == 1 and new[0] in seam  # another arc is this edge
                on[edges] = False
                if (
                    not one
                    and corridor.length_of(new) < length * STRICTLY_SHORTER
                    and corridor.in_place(nodes[0], edges[0], new[-1], on)
                    and corridor.in_place(nodes[-1], edges[-1], new[0], on)
                ):
                    seam = np.concatenate((graph.difference(seam, edges), new))
                    places, edges = corridor.index[path], new
                on[edges] = True
            blocked[places] = True
        return seam if seam is old or not corridor.has_parts or corridor.opens(seam) else None

    new = ~graph.mask_of(known)
    arcs = arcs_of(graph, seam, fixed)
    arcs = [arc for arc in arcs if arc[1][0] != arc[1][-1] and len(arc[0]) > 1 and new[arc[0]].any()]
    return move_in_groups(longest(arcs, lambda k: corridor.length_of(arcs[k][0])), seam, move)


def _move_branch_points_by(corridor: _Corridor, seam: IntArray, fixed: set[int], reach: float) -> IntArray:
    """Each point where three arcs meet moved to where they are shortest."""
    graph = corridor.graph

    def move(branches: list[int], seam: IntArray) -> IntArray | None:
        on, old, changes = graph.mask_of(seam), seam, list[tuple[IntArray, IntArray]]()
        for branch in branches:
            if len(steps.get(branch, ())) != 3:
                continue
            arms = [arc_from(graph, steps, fixed, branch, step, reach) for step in steps[branch]]
            tips = [nodes[-1] for _, nodes in arms]
            if len({*tips, branch}) < 4:
                continue
            own = np.array([edge for edges, _ in arms for edge in edges])
            blocked = corridor.blocked_at(np.fromiter(steps, dtype=np.int64, count=len(steps)))
            for _, nodes in arms:
                blocked[corridor.index[nodes[:-1]]] = False
            limit = corridor.length_of(own) * STRICTLY_SHORTER
            paths = corridor.steiner_tree(corridor.index[tips], blocked, limit)
            if len(paths[0]):
                parts = [graph.edges_between(path[:-1], path[1:]) for path in paths]
                on[own] = False
                firsts = [part[0] for part in parts if len(part)]
                if all(
                    corridor.in_place(tip, edges[-1], new, on)
                    for tip, (edges, _), part in zip(tips, arms, parts, strict=True)
                    for new in (part[-1:] if len(part) else firsts)  # the centre may be a tip
                ):
                    own, old_own = np.concatenate(parts), own
                    seam = np.concatenate((graph.difference(seam, old_own), own))
                    replace_steps(graph, steps, old_own, own)
                    changes.append((old_own, own))
                on[own] = True
        if seam is old or not corridor.has_parts or corridor.opens(seam):
            return seam
        for old_own, own in reversed(changes):
            replace_steps(graph, steps, own, old_own)
        return None

    steps = steps_of(graph, seam)
    movable = [
        node for node in steps if node >= graph.n_holes and node not in fixed and len(steps[node]) == 3
    ]
    if len(movable) > MAX_MOVED_ARCS:
        at = lengths_at(graph, arcs_of(graph, seam, fixed), corridor.length, reach)
        movable = longest(movable, lambda k: float(at[movable[k]]))
    return move_in_groups(movable, seam, move)
