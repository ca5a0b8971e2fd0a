"""Seams straightened, and moved into valleys nearby."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .._types import IntArray
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
    return in_groups([arcs[k] for k in longest([piece.total(arc) for arc in arcs])], seam, tried)


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
    rest = np.setdiff1d(seam, arc)
    barred = np.union1d(routes.ends[rest], np.arange(routes.holes))
    for shift in (0.0, 0.5):
        before = np.cumsum(routes.length[arc]) - routes.length[arc]
        number = (before / (STRIDE * routes.size) + shift).astype(np.int64)
        parts = np.split(arc, np.flatnonzero(np.diff(number)) + 1)
        for k, part in enumerate(parts):
            others = np.concatenate([part[:0], *parts[:k], *parts[k + 1 :]])
            parts[k] = _shortest(routes, part, np.union1d(barred, routes.ends[others]))
        arc = np.concatenate(parts)
    return np.concatenate((rest, arc))


def _shortest(routes: ClosedSurface, path: IntArray, avoid: IntArray) -> IntArray:
    """The shortest path between the ends of a path, in its order."""
    node, times = np.unique(routes.ends[path], return_counts=True)
    first = np.intersect1d(routes.ends[path[0]], node[times == 1])
    last = np.setdiff1d(node[times == 1], first)
    if len(path) < 2 or len(first) != 1 or len(last) != 1:
        return path
    length = routes.total(path)
    distance, before, _ = routes.search(last, np.setdiff1d(avoid, [first[0], last[0]]), limit=length)
    shorter = distance[first[0]] < length * SHORTER
    return routes.paths(before, first.tolist()) if shorter else path
