"""Pair the sides of outlines that lie on the same edges of the surface, and group them into seams."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .._types import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class PatternSeam:
    """A seam of a pattern: two parts of outlines that are joined.

    Attributes
    ----------
    number : int
        Number written on both sides.
    pieces : (int, int)
    lengths : (float, float)
        Lengths of both sides in the pattern, in millimetres.
    length : float
        Length on the surface, in millimetres.
    sides : two (n, 2) float64
        Points of both sides, in the order of joining. The material is on the left of the first side.
    twisted : bool
        Whether the material is also on the left of the second side, as on a Moebius strip.
    """

    number: int
    pieces: tuple[int, int]
    lengths: tuple[float, float]
    length: float
    sides: tuple[FloatArray, FloatArray]
    twisted: bool = False

    @property
    def difference(self) -> float:
        """The length of the first side minus the length of the second side, relative to `length`."""
        return (self.lengths[0] - self.lengths[1]) / self.length


@dataclass(frozen=True, eq=False)
class OutlineSides:
    """The sides (edges) of all outlines of a pattern.

    Attributes
    ----------
    start, end : (#S,) int64
        Vertices at the ends of each side. The material is on the left of each side.
    after, before : (#S,) int64
        The next and the previous side of the same outline.
    """

    start: IntArray
    end: IntArray
    after: IntArray
    before: IntArray

    @classmethod
    def from_loops(cls, loops: tuple[IntArray, ...]) -> OutlineSides:
        """Return the sides of closed loops of vertices."""
        start, size = np.concatenate(loops), np.array([len(loop) for loop in loops])
        behind = np.cumsum(size)
        after = np.arange(1, len(start) + 1)
        after[behind - 1] = behind - size
        return cls(start, start[after], after, np.argsort(after))

    def get_vertices_along(self, run: IntArray) -> IntArray:
        """Return the vertices along consecutive sides, (n + 1,)."""
        return np.append(self.start[run], self.end[run[-1]])

    def measure_lengths(self, points: FloatArray) -> FloatArray:
        """Return the length of each side, (#S,), if the vertices are at the given points."""
        return np.asarray(np.linalg.norm(points[self.start] - points[self.end], axis=1))


@dataclass(frozen=True, eq=False)
class SeamSides:
    """The outline edges along the two copies of a seam.

    Attributes
    ----------
    one, other : (n,) int64
        Row indices into the sides of `OutlineSides`; each side of `one` is joined with that row of `other`.
    twisted : bool
        Whether both parts run along their outlines in the same direction.
    """

    one: IntArray
    other: IntArray
    twisted: bool

    @property
    def runs(self) -> tuple[IntArray, IntArray]:
        """The sides of both parts, each in the direction of its outline."""
        return self.one, self.other if self.twisted else self.other[::-1]

    def get_vertex_paths(self, sides: OutlineSides) -> tuple[IntArray, IntArray]:
        """Return the vertices along both parts, (n + 1,) each, in the order of joining."""
        one, other = map(sides.get_vertices_along, self.runs)
        return one, other if self.twisted else other[::-1]


def find_seams(sides: OutlineSides, surface: FloatArray, piece: IntArray) -> tuple[SeamSides, ...]:
    """Group the sides that are joined into seams.

    Parameters
    ----------
    sides : Sides
    surface : (#v, 3) float64
        Positions of the vertices. Copies of a vertex at a seam have the same position on the surface.
    piece : (#v,) int64
        Piece of each vertex.
    """
    partner, twisted = find_partners(sides, surface, piece)
    continued = _mark_continued_sides(sides, partner, twisted)
    return tuple(
        SeamSides(one, partner[one], bool(twisted[one[0]])) for one in _trace_runs(sides, partner, continued)
    )


def measure_seams(
    seams: tuple[SeamSides, ...], sides: OutlineSides, surface: FloatArray, flat: FloatArray, piece: IntArray
) -> tuple[PatternSeam, ...]:
    """Return the seams with their lines and lengths. The arguments are as in `find_seams`."""
    length, flat_length = sides.measure_lengths(surface), sides.measure_lengths(flat)
    measured = list[PatternSeam]()
    for seam in seams:
        one, other = seam.one, seam.other
        here, there = seam.get_vertex_paths(sides)
        measured.append(
            PatternSeam(
                number=len(measured) + 1,
                pieces=(int(piece[sides.start[one[0]]]), int(piece[sides.start[other[0]]])),
                lengths=(float(flat_length[one].sum()), float(flat_length[other].sum())),
                length=float(length[one].sum()),
                sides=(flat[here], flat[there]),
                twisted=seam.twisted,
            )
        )
    return tuple(measured)


def find_partners(sides: OutlineSides, surface: FloatArray, piece: IntArray) -> tuple[IntArray, BoolArray]:
    """Return, for each side, the partner on the same edge of the surface, or -1, and a mask of twisted pairs.

    Twisted partners have the same direction, which occurs only where a one-sided surface was cut.
    """
    _, place = np.unique(surface, axis=0, return_inverse=True)
    tail, head = place.ravel()[sides.start], place.ravel()[sides.end]
    n = int(place.max()) + 1
    own, opposite = tail * n + head, head * n + tail
    # sort the sides on an edge by piece, and pair each forward side with the next backward side
    order = np.lexsort((piece[sides.start], own))
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order)) - np.searchsorted(own[order], own[order])
    at = np.minimum(np.searchsorted(own[order], opposite) + rank, len(order) - 1)
    partner = np.where(own[order][at] == opposite, order[at], -1)
    alone = order[partner[order] < 0]  # sorted: sides with equal ends are adjacent
    same = own[alone[1:]] == own[alone[:-1]]
    pairs = np.flatnonzero(same & ~np.append(False, same[:-1]))
    one, other = alone[pairs], alone[pairs + 1]
    partner[one], partner[other] = other, one
    twisted = np.zeros(len(partner), dtype=bool)
    twisted[one] = twisted[other] = True
    return partner, twisted


def _mark_continued_sides(sides: OutlineSides, partner: IntArray, twisted: BoolArray) -> BoolArray:
    """Return a mask of the sides whose seam continues along the next side of the outline."""
    after = sides.after
    here = (partner >= 0) & (partner[after] >= 0) & (twisted == twisted[after])
    there = np.where(twisted, after[partner] == partner[after], after[partner[after]] == partner)
    return np.asarray(here & there & (partner != after))  # a seam ends where it turns back at a tip


def _trace_runs(sides: OutlineSides, partner: IntArray, continued: BoolArray) -> Iterator[IntArray]:
    """Yield, for each seam, the consecutive boundary edges along one of the two sides of the seam."""
    done = np.zeros(len(partner), dtype=bool)
    for first in np.flatnonzero(partner >= 0).tolist():
        if done[first]:
            continue
        while continued[sides.before[first]] and not done[sides.before[first]]:
            first = int(sides.before[first])
            done[first] = True
        run = [first]
        while continued[run[-1]] and sides.after[run[-1]] != first:
            run.append(int(sides.after[run[-1]]))
        done[run] = done[partner[run]] = True
        yield np.array(run)
