"""Which sides of the outlines belong together: the runs that lie on the same edges of the surface."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .._types import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class PatternSeam:
    """Two stretches of outline that are joined.

    Attributes
    ----------
    number : int
        As it is written on both.
    pieces : (int, int)
    lengths : (float, float)
        Of both sides in the pattern, in millimetres.
    length : float
        On the surface.
    sides : two (n, 2) float64
        Their points, in the order in which they are joined. The material is on the left of the first.
    twisted : bool
        Whether it is on the left of the second, too: that side is joined upside down, as a Moebius band's.
    """

    number: int
    pieces: tuple[int, int]
    lengths: tuple[float, float]
    length: float
    sides: tuple[FloatArray, FloatArray]
    twisted: bool = False

    @property
    def change(self) -> float:
        """How much longer the first side is than the second, as a share of the surface's length."""
        return (self.lengths[0] - self.lengths[1]) / self.length


@dataclass(frozen=True, eq=False)
class Sides:
    """The sides of all outlines.

    Attributes
    ----------
    start, end : (#S,) int64
        Vertices of each, the material on its left.
    after, before : (#S,) int64
        The next side of its outline, and the last.
    """

    start: IntArray
    end: IntArray
    after: IntArray
    before: IntArray

    @classmethod
    def of(cls, loops: tuple[IntArray, ...]) -> Sides:
        start, size = np.concatenate(loops), np.array([len(loop) for loop in loops])
        behind = np.cumsum(size)
        after = np.arange(1, len(start) + 1)
        after[behind - 1] = behind - size
        return cls(start, start[after], after, np.argsort(after))

    def lengths(self, points: FloatArray) -> FloatArray:
        """(#S,) float64, of vertices at these points."""
        return np.asarray(np.linalg.norm(points[self.start] - points[self.end], axis=1))


def seams_of(
    surface: FloatArray, flat: FloatArray, loops: tuple[IntArray, ...], piece: IntArray
) -> tuple[PatternSeam, ...]:
    """The seams of a pattern.

    Parameters
    ----------
    surface, flat : (#v, 3) and (#v, 2) float64
        Positions of the vertices. Those at a seam have copies, in one position of the surface.
    loops : tuple of (n,) int64
        The outlines, the material on their left.
    piece : (#v,) int64
        Of each vertex.
    """
    if not loops:
        return ()
    sides = Sides.of(loops)
    partner, twisted = partners_of(sides, surface, piece)
    length, flat_length = sides.lengths(surface), sides.lengths(flat)
    seams = list[PatternSeam]()
    for one in _runs(sides, partner, _continued(sides, partner, twisted)):
        other, same_way = partner[one], bool(twisted[one[0]])
        tail, head = (sides.start, sides.end) if same_way else (sides.end, sides.start)
        seams.append(
            PatternSeam(
                number=len(seams) + 1,
                pieces=(int(piece[sides.start[one[0]]]), int(piece[sides.start[other[0]]])),
                lengths=(float(flat_length[one].sum()), float(flat_length[other].sum())),
                length=float(length[one].sum()),
                sides=(
                    flat[np.append(sides.start[one], sides.end[one[-1]])],
                    flat[np.append(tail[other], head[other[-1]])],
                ),
                twisted=same_way,
            )
        )
    return tuple(seams)


def partners_of(sides: Sides, surface: FloatArray, piece: IntArray) -> tuple[IntArray, BoolArray]:
    """For each side the one on the same edge of the surface, or -1; and whether both run the same way.

    They do where a one-sided surface was cut.
    """
    _, place = np.unique(surface, axis=0, return_inverse=True)
    tail, head = place.ravel()[sides.start], place.ravel()[sides.end]
    n = int(place.max()) + 1
    own, opposite = tail * n + head, head * n + tail
    # the first of a piece goes with its first the other way around
    order = np.lexsort((piece[sides.start], own))
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order)) - np.searchsorted(own[order], own[order])
    at = np.minimum(np.searchsorted(own[order], opposite) + rank, len(order) - 1)
    partner = np.where(own[order][at] == opposite, order[at], -1)
    alone = order[partner[order] < 0]  # still in order, so that those of one direction are neighbours
    same = own[alone[1:]] == own[alone[:-1]]
    pairs = np.flatnonzero(same & ~np.append(False, same[:-1]))
    one, other = alone[pairs], alone[pairs + 1]
    partner[one], partner[other] = other, one
    twisted = np.zeros(len(partner), dtype=bool)
    twisted[one] = twisted[other] = True
    return partner, twisted


def _continued(sides: Sides, partner: IntArray, twisted: BoolArray) -> BoolArray:
    """Sides whose seam goes on along the next: also the partners of the two follow each other."""
    after = sides.after
    here = (partner >= 0) & (partner[after] >= 0) & (twisted == twisted[after])
    there = np.where(twisted, after[partner] == partner[after], after[partner[after]] == partner)
    return np.asarray(here & there & (partner != after))  # around a tip the other side begins


def _runs(sides: Sides, partner: IntArray, continued: BoolArray) -> Iterator[IntArray]:
    """The sides of each seam in order, on one of its two sides."""
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
