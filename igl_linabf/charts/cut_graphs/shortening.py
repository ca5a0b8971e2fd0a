"""Seams made shorter: straightened, moved into valleys nearby, and drawn tight around branch points."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from ..._core import lengths, meeting, ways_towards
from ..._types import BoolArray, FloatArray, IntArray
from .branches import (
    MOST_MOVED,
    Arc,
    Row,
    Steps,
    arcs_along,
    arcs_at,
    arm,
    in_groups,
    lengths_at,
    longest,
    replaced,
    steps_along,
)
from .graph import SHORTER, ClosedSurface, opened, shape

STRIDE = 0.3  # times the surface's size: points on a seam between which it is rerouted


def rerouted(piece: ClosedSurface, seam: IntArray, accepted: Callable[[IntArray], bool]) -> IntArray:
    """The seam on the shortest ways between points on it, where valleys are shorter.

    The points are `STRIDE` apart: the seam slides into a valley nearby, and stays where its leaves are. If
    not all together is accepted, halves of the arcs are tried, and so on.
    """
    routes, old = piece.with_lengths(piece.length * piece.valley), shape(piece, seam)

    def tried(arcs: list[IntArray], seam: IntArray) -> IntArray | None:
        moved = seam
        for arc in arcs:
            moved = _straightened(routes, moved, arc)
        if np.array_equal(np.sort(moved), np.sort(seam)):
            return seam
        return moved if shape(piece, moved) == old and accepted(moved) else None

    arcs = _arcs(piece, seam)
    return in_groups(longest(arcs, lambda k: piece.total(arcs[k])), seam, tried)


def _arcs(piece: ClosedSurface, seam: IntArray) -> list[IntArray]:
    """The arcs between branch points, leaves and holes, each in order."""
    degree = np.bincount(piece.ends[seam].ravel(), minlength=piece.n)
    degree[: piece.holes] = 0
    starts = np.flatnonzero((degree == 1) | (degree >= 3)).tolist()
    steps = steps_along(piece, seam)
    arcs = [(start, *arc) for start in starts for arc in arcs_at(piece, steps, start)]
    return [arc for start, arc, tip in arcs if tip > start or tip < piece.holes]  # from one of its two ends


def _straightened(routes: ClosedSurface, seam: IntArray, arc: IntArray) -> IntArray:
    """The seam with an arc on the shortest ways between points on it, then between points between these."""
    rest = routes.without(seam, arc)
    taken = np.zeros(routes.n, dtype=bool)
    taken[: routes.holes], taken[routes.ends[seam]] = True, True
    for shift in (0.0, 0.5):
        before = np.cumsum(routes.length[arc]) - routes.length[arc]
        number = (before / (STRIDE * routes.size) + shift).astype(np.int64)
        parts = np.split(arc, np.flatnonzero(np.diff(number)) + 1)
        arc = np.concatenate([_shortest(routes, part, taken) for part in parts])
    return np.concatenate((rest, arc))


def _shortest(routes: ClosedSurface, path: IntArray, taken: BoolArray) -> IntArray:
    """The shortest path between the ends of a path, in its order; nodes that are taken by others stay so."""
    if len(path) < 2:
        return path
    first, last = _end(routes, path[0], path[1]), _end(routes, path[-1], path[-2])
    if first < 0 or last < 0 or first == last:
        return path
    length, avoid = routes.total(path), taken.copy()
    avoid[routes.ends[path]] = False
    distance, before, _ = routes.search(np.array([last]), avoid, limit=length)
    if not distance[first] < length * SHORTER:
        return path
    found = routes.paths(before, [first])
    taken[routes.ends[path]] = False
    taken[routes.ends[found]] = True
    return found


def _end(routes: ClosedSurface, edge: int, following: int) -> int:
    """The node of an edge that the next one has not; -1 if it has both."""
    others = [node for node in routes.ends[edge].tolist() if node not in routes.ends[following].tolist()]
    return others[0] if others else -1


LEFT = 0.7  # of its faces is what a part keeps at least when a seam moves: two arcs around it may meet


class _Corridor:
    """The part of a closed surface's graph in which the seam may move, where valleys are shorter."""

    def __init__(self, piece: ClosedSurface, near: BoolArray, seam: IntArray) -> None:
        self.piece = piece
        self._opened = opened(piece, seam)
        self._nodes = np.flatnonzero(near)
        self._place = np.full(piece.n, -1)
        self._place[self._nodes] = np.arange(len(self._nodes))
        graph = piece.graph.copy()
        graph.data = piece.entry
        self._graph = graph[self._nodes][:, self._nodes]
        self.length = piece.length * piece.valley
        self._graph.data = self.length[self._graph.data]
        self._position = piece.position[self._nodes]
        in_space = near & (np.arange(piece.n) >= piece.holes)  # a hole is in no one place
        inside = np.flatnonzero(in_space[piece.ends[:, 0]] & in_space[piece.ends[:, 1]])
        straight = lengths(piece.position, piece.ends[inside])
        self._share = float(np.min(self.length[inside] / straight, initial=1.0, where=straight > 0))

    @property
    def is_tree(self) -> bool:
        """Whether the seam has no cycle: it then opens the same whichever way its arcs go."""
        return not self._opened[1]

    @property
    def has_parts(self) -> bool:
        """Whether the seam leaves several parts. Arcs that stay in their places leave as many."""
        return len(self._opened[2]) > 1

    def accepts(self, moved: IntArray) -> bool:
        """Whether no part has become small."""
        return not self.has_parts or self.opens(moved)

    def opens(self, moved: IntArray) -> bool:
        """Whether a seam that has moved still opens what it opened, and no part has become small."""
        number, cycles, sizes = self._opened
        *new, parts = opened(self.piece, moved)
        return new == [number, cycles] and len(parts) == len(sizes) and bool((parts >= LEFT * sizes).all())

    def in_place(self, node: int, old: int, new: int, on: BoolArray) -> bool:
        """Whether two edges at a node lie between the same edges of the rest of the seam, a mask.

        What is cut along it then has the node on the same boundary, whichever of the two an arc begins with.
        Arcs that do so at both ends, and pass no other arc, open the same.
        """
        if self.is_tree or old == new:
            return True
        graph, piece = self.piece.graph, self.piece
        around = np.append(piece.entry[graph.indptr[node] : graph.indptr[node + 1]], (old, new))
        reached, waiting = set[int](piece.faces[old].tolist()), True
        sides = piece.faces[around[~on[around]]].tolist()
        while waiting:
            waiting = False
            for a, b in sides:
                if (a in reached) != (b in reached):
                    reached |= {a, b}
                    waiting = True
        return int(piece.faces[new, 0]) in reached

    def total(self, edges: IntArray) -> float:
        """Their length, less in valleys."""
        return float(self.length[edges].sum())

    def closed_at(self, nodes: IntArray) -> BoolArray:
        """A mask of the corridor's nodes: these are not passed."""
        closed = np.zeros(len(self._nodes), dtype=bool)
        closed[self._place[nodes]] = True
        return closed

    def search(
        self, source: int, targets: IntArray, closed: BoolArray, limit: float
    ) -> tuple[FloatArray, IntArray]:
        """Distances from a node, and the nodes before, where ways on to all targets stay within `limit`.

        Nodes are given by their places.
        """
        passed, graph = ~closed, self._graph
        passed[source] = True
        at = targets[self._nodes[targets] >= self.piece.holes]
        rest = self._position, self._position[at], self._share
        return ways_towards(
            graph.indptr, graph.indices, graph.data, source, passed, *rest, limit * (1 + 1e-9)
        )

    def meeting(self, tips: IntArray, closed: BoolArray, limit: float) -> list[IntArray]:
        """The ways to three nodes, given by their places, from where they are shortest in total.

        They are empty if the total is over the limit.
        """
        graph, sets = self._graph, (tips[:1], tips[1:2], tips[2:])
        nodes, start = meeting(graph.indptr, graph.indices, graph.data, sets, ~closed, limit)
        return [self._nodes[nodes[i:j]] for i, j in pairwise(start.tolist())]

    def way(self, before: IntArray, end: int) -> list[int]:
        """The nodes from an end, by its place in the corridor, back to the source."""
        nodes: list[int] = []
        while end >= 0:
            nodes.append(end)
            end = int(before[end])
        return [int(node) for node in self._nodes[nodes]]

    def places(self, nodes: list[int] | IntArray) -> IntArray:
        return self._place[nodes]


def tightened(
    piece: ClosedSurface, seam: IntArray, kept: IntArray, near: BoolArray, reach: float
) -> IntArray:
    """A seam of the same kind that is no longer, and passes the same points.

    Parameters
    ----------
    piece : ClosedSurface
    seam : (#S,) int64
        Its edges.
    kept : (#K,) int64
        Nodes that it goes on to pass.
    near : (n,) bool
        The nodes that it may pass; those of the seam are among them.
    reach : float
        How far from a branch point its three arcs may move.
    """
    corridor, fixed = _Corridor(piece, near, seam), set(kept.tolist())
    straight = _straight(corridor, seam, fixed, seam[:0])
    moved = _balanced(corridor, straight, fixed, reach)
    moved = _straight(corridor, moved, fixed, straight)
    return moved if corridor.is_tree or corridor.has_parts or corridor.opens(moved) else seam


def _straight(corridor: _Corridor, seam: IntArray, fixed: set[int], known: IntArray) -> IntArray:
    """Each arc, but those of known edges, by the shortest path that the corridor and the other arcs allow."""
    piece = corridor.piece

    def moved(arcs: list[Row], seam: IntArray) -> IntArray | None:
        closed, on, old = corridor.closed_at(piece.ends[seam]), _mask(piece, seam), seam
        for edges, nodes in arcs:
            length, places = corridor.total(edges), corridor.places(nodes)
            closed[places[1:]] = False
            _, before = corridor.search(int(places[0]), places[-1:], closed, length)
            way = corridor.way(before, int(places[-1]))
            if len(way) > 1:
                new = piece.between(np.array(way[:-1]), np.array(way[1:]))
                one = len(new) == 1 and new[0] in seam  # another arc is this edge
                on[edges] = False
                if (
                    not one
                    and corridor.total(new) < length * SHORTER
                    and corridor.in_place(nodes[0], edges[0], new[-1], on)
                    and corridor.in_place(nodes[-1], edges[-1], new[0], on)
                ):
                    seam = np.concatenate((piece.without(seam, edges), new))
                    places, edges = corridor.places(way), new
                on[edges] = True
            closed[places] = True
        return seam if seam is old or corridor.accepts(seam) else None

    new = ~_mask(piece, known)
    arcs = arcs_along(piece, seam, fixed)
    arcs = [arc for arc in arcs if arc[1][0] != arc[1][-1] and len(arc[0]) > 1 and new[arc[0]].any()]
    return in_groups(longest(arcs, lambda k: corridor.total(arcs[k][0])), seam, moved)


def _balanced(corridor: _Corridor, seam: IntArray, fixed: set[int], reach: float) -> IntArray:
    """Each point where three arcs meet moved to where they are shortest."""
    piece = corridor.piece

    def arms_at(steps: Steps, branch: int) -> list[Arc]:
        return [arm(piece, steps, fixed, branch, start, reach) for start in steps[branch]]

    def moved(branches: list[int], seam: IntArray) -> IntArray | None:
        on, old, changes = _mask(piece, seam), seam, list[tuple[IntArray, IntArray]]()
        for branch in branches:
            if len(steps.get(branch, ())) != 3:
                continue
            arms = arms_at(steps, branch)
            tips = [nodes[-1] for _, nodes in arms]
            if len({*tips, branch}) < 4:
                continue
            own = np.array([edge for edges, _ in arms for edge in edges])
            closed = corridor.closed_at(np.fromiter(steps, dtype=np.int64, count=len(steps)))
            for _, nodes in arms:
                closed[corridor.places(nodes[:-1])] = False
            length = corridor.total(own)
            at = corridor.places(tips)
            ways = corridor.meeting(at, closed, length * SHORTER)
            if len(ways[0]):
                parts = [piece.between(way[:-1], way[1:]) for way in ways]
                on[own] = False
                firsts = [part[0] for part in parts if len(part)]
                if all(
                    corridor.in_place(tip, edges[-1], new, on)
                    for tip, (edges, _), part in zip(tips, arms, parts, strict=True)
                    for new in (part[-1:] if len(part) else firsts)  # the centre may be a tip
                ):
                    own, old_own = np.concatenate(parts), own
                    seam = np.concatenate((piece.without(seam, old_own), own))
                    replaced(piece, steps, old_own, own)
                    changes.append((old_own, own))
                on[own] = True
        if seam is old or corridor.accepts(seam):
            return seam
        for old_own, own in reversed(changes):
            replaced(piece, steps, own, old_own)
        return None

    steps = steps_along(piece, seam)
    movable = [node for node in steps if node >= piece.holes and node not in fixed and len(steps[node]) == 3]

    if len(movable) > MOST_MOVED:
        at = lengths_at(piece, arcs_along(piece, seam, fixed), corridor.length, reach)
        movable = longest(movable, lambda k: float(at[movable[k]]))
    return in_groups(movable, seam, moved)


def _mask(piece: ClosedSurface, seam: IntArray) -> BoolArray:
    on = np.zeros(len(piece.ends), dtype=bool)
    on[seam] = True
    return on
