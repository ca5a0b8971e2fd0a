"""Project a direction in space to each piece, to rotate pieces upright and to orient grain arrows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from shapely import LineString, intersects, polygons, unary_union

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..surface import complex_positions, map_direction
from .joined_pieces import CutSurface, find_narrowest_turns, group_rows

ARROW_HALF_LENGTH = 0.3  # half the length of a grain arrow, relative to the extent of its piece
ARROW_SHRINKAGE = 0.8  # an arrow is shortened repeatedly by this factor until it fits into its piece
MIN_GRAIN_LENGTH = 0.1  # a grain direction is perpendicular to a piece if its mean projection is shorter
COMMON_SHARE = 0.3  # minimum share of a piece with equal directions; otherwise the mean direction is used
SAME_DIRECTION = 1e-3  # maximum angle between directions that are considered equal, radians


@dataclass(frozen=True, eq=False)
class PieceDirections:
    """The direction on each flat piece that corresponds to a direction in space.

    Attributes
    ----------
    towards : (#pieces,) complex128
        Unit directions. If the direction is perpendicular to a piece, the direction of its long side.
    known : (#pieces,) bool
        Whether the direction has a component in the piece.
    is_mean : (#pieces,) bool
        Whether the direction varies all over the piece, as on a cone, so that `towards` is the mean.
    across : (#pieces,) complex128
        Direction of the long side of the bounding rectangle that is aligned with most of the outline.
    """

    towards: ComplexArray
    known: BoolArray
    is_mean: BoolArray
    across: ComplexArray

    @property
    def upright_turn(self) -> ComplexArray:
        """The rotation of each piece that makes the direction point up.

        Several pieces are all rotated in this way, so that they have the same grain. A single piece with a
        common direction is instead rotated so that most of its outline is upright or horizontal. If no piece
        defines an upward direction, the long sides are horizontal, as in drawings of plates.
        """
        if len(self.towards) > 1 or not self.known.any() or self.is_mean.any():
            return self.towards.conj() * (1j if self.known.any() else 1)
        quarters = self.across.conj() * [1, 1j, -1, -1j]
        return quarters[[np.argmax((self.towards * quarters).imag)]]


def find_directions(cut: CutSurface, direction: FloatArray) -> PieceDirections:
    """Project a unit direction in space to each piece of the flat map.

    If the faces of most of a piece have a common direction, such as the sides of a box, that direction is
    used, otherwise the mean. If the direction in space is perpendicular to a piece, the direction of the
    piece's long side is used, towards increasing coordinates in space.
    """
    z = complex_positions(cut.flat)
    along, area = map_direction(cut.surface, z, cut.F, direction)
    aside, _ = map_direction(cut.surface, z, cut.F, np.ones(3))
    piece = cut.piece
    of = piece[cut.F[:, 0]]
    long_sides = _find_long_sides(cut, piece)
    found = np.empty(int(piece.max()) + 1, dtype=np.complex128)
    known, is_mean = np.empty((2, len(found)), dtype=bool)
    for i, faces in enumerate(group_rows(of)):
        whole = area[faces].sum()
        mean = complex((along[faces] * area[faces]).sum() / whole)
        chosen, largest = _find_common_direction(along[faces], area[faces], mean)
        is_mean[i] = largest < COMMON_SHARE / 2
        known[i] = abs(chosen) >= MIN_GRAIN_LENGTH * whole
        if not known[i]:
            to = complex((aside[faces] * area[faces]).sum())
            chosen = long_sides[i] if (to * long_sides[i].conj()).real >= 0 else -long_sides[i]
        found[i] = chosen / abs(chosen)
    return PieceDirections(found, known, is_mean, long_sides)


def place_arrows(
    cut: CutSurface, loops: tuple[IntArray, ...], piece: IntArray, directions: ComplexArray
) -> FloatArray:
    """Return the tail and head of each piece's arrow, (#pieces, 2, 2), for given directions in the plane.

    `loops` are the outlines, and `piece` is the piece of each vertex.
    """
    found = []
    for i, faces in enumerate(group_rows(piece[cut.F[:, 0]])):
        points = cut.flat[piece == i]
        rim = np.concatenate([cut.flat[loop] for loop in loops if piece[loop[0]] == i])
        along = np.array([directions[i].real, directions[i].imag])
        found.append(_fit_arrow(cut.flat[cut.F[faces]], rim, points, along))
    return np.array(found)


def _find_long_sides(cut: CutSurface, piece: IntArray) -> ComplexArray:
    """Return the direction of the long side of each piece's bounding rectangle.

    The rectangle is aligned with most of the outline if possible. Otherwise, the rectangle with the smallest
    area is used.
    """
    z, loops = complex_positions(cut.flat), cut.topology.loops
    found = find_narrowest_turns(z, piece).conj()
    side = np.concatenate([z[np.roll(loop, -1)] - z[loop] for loop in loops])
    of = np.repeat([piece[loop[0]] for loop in loops], [len(loop) for loop in loops])
    for i, rows in enumerate(group_rows(of)):
        length = np.abs(side[rows])
        quarters = (
            side[rows] / np.maximum(length, np.finfo(float).tiny)
        ) ** 4  # directions that differ by quarter turns have equal fourth powers
        group, shares = _group_directions(quarters, length)
        if not shares.max(initial=0) >= COMMON_SHARE:
            continue
        best = group == shares.argmax()
        turn = complex((quarters[best] @ length[best]) ** 0.25)
        turned = z[piece == i] * np.conj(turn)
        found[i] = turn * (1 if np.ptp(turned.real) >= np.ptp(turned.imag) else 1j) / abs(turn)
    return found


def _group_directions(directions: ComplexArray, weight: FloatArray) -> tuple[IntArray, FloatArray]:
    """Group equal directions; return the group of each direction, and the weight of each group as a share."""
    angle = np.angle(directions)
    order = np.argsort(angle, kind="stable")
    group = np.empty(len(order), dtype=np.int64)
    group[order] = np.cumsum(np.append(True, np.diff(angle[order]) > SAME_DIRECTION)) - 1
    if (
        angle[order[-1]] - angle[order[0]] > 2 * np.pi - SAME_DIRECTION
    ):  # angles wrap around, so the first and the last group are equal
        group[group == group[order[-1]]] = 0
    return group, np.bincount(group, weight) / max(float(weight.sum()), np.finfo(float).tiny)


def _find_common_direction(along: ComplexArray, area: FloatArray, mean: complex) -> tuple[complex, float]:
    """Return the sum of the directions in the largest group, and the largest share of a group.

    A group is a set of faces with a common direction. If no group is large, the sum is over all faces. Among
    groups of equal size, the group with the direction nearest to the mean is used. Faces are weighted by
    their area and by the length of the projected direction.
    """
    weight = area * np.abs(along)
    group, shares = _group_directions(along, weight)
    sums = np.bincount(group, (along * area).real) + 1j * np.bincount(group, (along * area).imag)
    large = np.flatnonzero(shares >= COMMON_SHARE / 2)  # at most six groups can be this large
    towards = sums / np.maximum(np.abs(sums), np.finfo(float).tiny)
    # subtract the share of the opposite direction: both are equal on the halves of a horizontal tube
    against = (np.abs(towards[large, None] + towards) < SAME_DIRECTION) @ shares
    net = shares[large] - against
    most = (net > SAME_DIRECTION) & (net >= net.max(initial=0) - SAME_DIRECTION)
    # accept half the share if no group has the full share, because the mean may be parallel to no edge
    large = large[most & (net >= (COMMON_SHARE if (net >= COMMON_SHARE).any() else COMMON_SHARE / 2))]
    if not len(large):
        return mean * float(area.sum()), float(shares.max())
    best = large[np.argmax((sums[large] * np.conj(mean)).real)]
    return complex(sums[best]), float(shares.max())


def _fit_arrow(
    triangles: FloatArray, rim: FloatArray, points: FloatArray, along: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the tail and head of an arrow inside a piece, centred at a point far from the outline."""
    centres, shapes = triangles.mean(axis=1), polygons(triangles)
    room, _ = cKDTree(rim).query(centres)
    at, half = centres[np.argmax(room)], ARROW_HALF_LENGTH * np.ptp(points @ along)
    while half > room.max():
        shaft = LineString((at - half * along, at + half * along))
        if unary_union(shapes[intersects(shapes, shaft)]).contains(shaft):
            break
        half *= ARROW_SHRINKAGE
    return at - half * along, at + half * along
