"""Where a direction in space points on each piece: what turns pieces upright, and the arrows of the grain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from shapely import LineString, polygons, unary_union

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..surface import complex_positions, mapped_direction
from .constants import AGREEING, ARROW_HALF, ARROW_SHRINKAGE, LEAST_GRAIN, SAME_DIRECTION
from .joined_pieces import CutSurface, narrowest_turns_of


@dataclass(frozen=True, eq=False)
class PieceDirections:
    """Where a direction in space points on each piece in the plane.

    Attributes
    ----------
    towards : (#pieces,) complex128
        Of length one. Where the direction points nowhere, it is along the piece.
    known : (#pieces,) bool
        Whether it points anywhere.
    is_mean : (#pieces,) bool
        Whether it turns all the time, as on a cone, and this is the mean.
    across : (#pieces,) complex128
        The long side of the rectangle around the piece, along most of its outline.
    """

    towards: ComplexArray
    known: BoolArray
    is_mean: BoolArray
    across: ComplexArray

    @property
    def upright_turn(self) -> ComplexArray:
        """The turn of each piece by which the direction points up; all alike, so that they have one grain.

        A single piece whose faces agree has most of its outline upright, too. Where no piece tells what is
        up, they lie across, as drawings of plates do.
        """
        if len(self.towards) > 1 or not self.known.any() or self.is_mean.any():
            return self.towards.conj() * (1j if self.known.any() else 1)
        quarters = self.across.conj() * [1, 1j, -1, -1j]
        return quarters[[np.argmax((self.towards * quarters).imag)]]


def directions_of(cut: CutSurface, direction: FloatArray) -> PieceDirections:
    """Where a unit direction in space points on each piece.

    Where most of a piece agrees, as the sides of a box in a row, it is that direction; else the mean. Where
    it points nowhere, it is along the piece, to where the coordinates in space grow.
    """
    z = complex_positions(cut.flat)
    along, area = mapped_direction(cut.surface, z, cut.F, direction)
    aside, _ = mapped_direction(cut.surface, z, cut.F, np.ones(3))
    piece = cut.piece
    of = piece[cut.F[:, 0]]
    long_sides = _long_sides(cut, piece)
    found = np.empty(int(piece.max()) + 1, dtype=np.complex128)
    known, is_mean = np.empty((2, len(found)), dtype=bool)
    for i, faces in enumerate(_rows_of_each(of)):
        whole = area[faces].sum()
        mean = complex((along[faces] * area[faces]).sum() / whole)
        chosen, largest = _agreed(along[faces], area[faces], mean)
        is_mean[i] = largest < AGREEING / 2
        known[i] = abs(chosen) >= LEAST_GRAIN * whole
        if not known[i]:
            to = complex((aside[faces] * area[faces]).sum())
            chosen = long_sides[i] if (to * long_sides[i].conj()).real >= 0 else -long_sides[i]
        found[i] = chosen / abs(chosen)
    return PieceDirections(found, known, is_mean, long_sides)


def arrows_of(
    cut: CutSurface, loops: tuple[IntArray, ...], piece: IntArray, directions: ComplexArray
) -> FloatArray:
    """Tail and head of each piece's arrow, (#pieces, 2, 2), by its direction in the plane.

    `loops` are the outlines, and `piece` the piece of each vertex.
    """
    found = []
    for i, faces in enumerate(_rows_of_each(piece[cut.F[:, 0]])):
        points = cut.flat[piece == i]
        rim = np.concatenate([cut.flat[loop] for loop in loops if piece[loop[0]] == i])
        along = np.array([directions[i].real, directions[i].imag])
        found.append(_longest_arrow(cut.flat[cut.F[faces]], rim, points, along))
    return np.array(found)


def _rows_of_each(of: IntArray) -> list[IntArray]:
    """The rows of each number."""
    order = np.argsort(of, kind="stable")
    return np.split(order, np.searchsorted(of[order], np.arange(1, int(of.max()) + 1)))


def _long_sides(cut: CutSurface, piece: IntArray) -> ComplexArray:
    """The long side of the rectangle around each piece, along most of its outline, or else the least one."""
    z, loops = complex_positions(cut.flat), cut.topology.loops
    found = narrowest_turns_of(z, piece).conj()
    side = np.concatenate([z[np.roll(loop, -1)] - z[loop] for loop in loops])
    of = np.repeat([piece[loop[0]] for loop in loops], [len(loop) for loop in loops])
    for i, rows in enumerate(_rows_of_each(of)):
        length = np.abs(side[rows])
        quarters = (side[rows] / np.maximum(length, np.finfo(float).tiny)) ** 4  # as long in all four
        group, shares = _alike(quarters, length)
        if not shares.max(initial=0) >= AGREEING:
            continue
        best = group == shares.argmax()
        turn = complex((quarters[best] @ length[best]) ** 0.25)
        turned = z[piece == i] * np.conj(turn)
        found[i] = turn * (1 if np.ptp(turned.real) >= np.ptp(turned.imag) else 1j) / abs(turn)
    return found


def _alike(directions: ComplexArray, weight: FloatArray) -> tuple[IntArray, FloatArray]:
    """Which directions are one, as numbers; and the share that each number has of the weight."""
    angle = np.angle(directions)
    order = np.argsort(angle, kind="stable")
    group = np.empty(len(order), dtype=np.int64)
    group[order] = np.cumsum(np.append(True, np.diff(angle[order]) > SAME_DIRECTION)) - 1
    if angle[order[-1]] - angle[order[0]] > 2 * np.pi - SAME_DIRECTION:  # both ends are one way
        group[group == group[order[-1]]] = 0
    return group, np.bincount(group, weight) / max(float(weight.sum()), np.finfo(float).tiny)


def _agreed(along: ComplexArray, area: FloatArray, mean: complex) -> tuple[complex, float]:
    """The sum over the largest part that points one way, or over all, if none is large; and its share.

    Of equal parts it is the one nearest to the mean. Each face counts with its area, and with how far the
    direction lies in it.
    """
    weight = area * np.abs(along)
    group, shares = _alike(along, weight)
    sums = np.bincount(group, (along * area).real) + 1j * np.bincount(group, (along * area).imag)
    large = np.flatnonzero(shares >= AGREEING / 2)  # six at most
    towards = sums / np.maximum(np.abs(sums), np.finfo(float).tiny)
    # around a tube that lies, one half points up and one down: the piece agrees on neither
    against = (np.abs(towards[large, None] + towards) < SAME_DIRECTION) @ shares
    net = shares[large] - against
    most = (net > SAME_DIRECTION) & (net >= net.max(initial=0) - SAME_DIRECTION)
    # a net of which a quarter points up and a quarter aside has no mean that is a direction of its edges
    large = large[most & (net >= (AGREEING if (net >= AGREEING).any() else AGREEING / 2))]
    if not len(large):
        return mean * float(area.sum()), float(shares.max())
    best = large[np.argmax((sums[large] * np.conj(mean)).real)]
    return complex(sums[best]), float(shares.max())


def _longest_arrow(
    triangles: FloatArray, rim: FloatArray, points: FloatArray, along: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Tail and head of an arrow of this direction within a piece, about a point far from its outline."""
    centres = triangles.mean(axis=1)
    room, _ = cKDTree(rim).query(centres)
    at, inside = centres[np.argmax(room)], unary_union(polygons(triangles))
    half = ARROW_HALF * np.ptp(points @ along)
    while half > room.max() and not inside.contains(LineString((at - half * along, at + half * along))):
        half *= ARROW_SHRINKAGE
    return at - half * along, at + half * along
