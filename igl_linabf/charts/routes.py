"""Seams straightened, and moved into valleys nearby."""

from collections.abc import Callable

import numpy as np

from .._types import BoolArray, IntArray
from .branches import arcs_at, in_groups, longest, steps_along
from .cut_graph import SHORTER, ClosedSurface, shape

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
