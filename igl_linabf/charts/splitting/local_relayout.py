"""A few faces of a map that lie over others, laid out narrower, so that no seam has to cut them off.

All other faces keep their places. `small_charts` lays out charts of a few faces in the same way, each beside
one neighbour; here the faces keep all their neighbours.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..._core import lie_over
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...flattening import Flattening
from ...layouts import energy_matrix, least_energy_positions
from ...measures import change_of
from ...surface import (
    Submesh,
    compact,
    complex_positions,
    coordinates,
    face_components,
    flat_angles,
    signed_double_areas,
)
from ..atlas import scaled_to_surface
from . import constants


def relayout_locally(piece: Submesh, result: Flattening, pairs: IntArray) -> tuple[Flattening, IntArray]:
    """The map with overlapping faces laid out anew where they then have room, and the pairs that are left.

    Parameters
    ----------
    piece : Submesh
    result : Flattening
        Its map, without flips, as large as the surface.
    pairs : (#P, 2) int64
        The faces that overlap in it.
    """
    faces = np.unique(pairs)
    label = face_components(piece.F[faces], len(piece.V))
    number = int(label.max()) + 1
    if number > constants.MAX_OVERLAPPING_GROUPS:
        return result, pairs
    low, high = np.sort(label[np.searchsorted(faces, pairs)], axis=1).T
    codes, of = np.unique(low * number + high, return_inverse=True)
    plan, left = _Relayout(piece, result.uv), np.ones(len(pairs), dtype=bool)
    for k, code in enumerate(codes.tolist()):
        groups = [faces[label == group] for group in {*divmod(code, number)}]
        if plan.makes_room(sorted(groups, key=len)):
            left[of == k] = False
    return plan.made(result), pairs[left]


class _Relayout:
    """A map that is changed at a few faces."""

    def __init__(self, piece: Submesh, uv: FloatArray) -> None:
        self._piece, self._uv = piece, uv
        self._unit = float(np.ldexp(1.0, -int(np.frexp(np.abs(uv).max())[1])))  # squares could overflow
        self._z = complex_positions(uv) * self._unit
        self._moved = np.zeros(len(piece.F), dtype=bool)
        self._box = self._around(piece.topology.corner)
        self._faces_at = np.bincount(piece.F.ravel())
        self._area = float(piece.measured[0].sum())
        # squared stretch times area that moves may still add
        self._left = (constants.MAX_STRETCH_FACTOR**2 - 1) * self._area

    def makes_room(self, groups: list[IntArray]) -> bool:
        """Move as few faces as possible, until one group, or two, overlap no more; whether that succeeds."""
        own, *others = (self._z[self._piece.F[group]] for group in groups)
        if not lie_over(own, np.concatenate([own[:0], *others])):
            return True  # another move was enough
        return any(self._moves(faces) for faces in self._with_rings(groups))

    def _with_rings(self, groups: list[IntArray]) -> Iterator[IntArray]:
        """The groups, and then with rings of faces around them."""
        F, area = self._piece.F, self._piece.measured[0]
        for ring in range(constants.MAX_RELAYOUT_RINGS + 1):
            for k, faces in enumerate(groups):
                if ring:
                    near = np.zeros(len(self._z), dtype=bool)
                    near[F[faces]] = True
                    groups[k] = faces = np.flatnonzero(near[F].any(axis=1))
                if area[faces].sum() < constants.MAX_AREA_OF_SMALL_CHART * self._area:
                    yield faces

    def _moves(self, faces: IntArray) -> bool:
        """Lay out faces where they overlap nothing, if stretch and shear allow it; whether that succeeds."""
        piece = self._piece
        used, F = compact(piece.F[faces], len(self._z))
        free = np.bincount(F.ravel()) == self._faces_at[used]
        if not 0 < np.count_nonzero(free) <= min(constants.MAX_DENSE_VERTICES, len(free) - 2):
            return False
        part = Submesh(piece.V[used], F, piece.faces[faces], piece.vertices[used], piece.n_given)
        cot = np.divide(part.measured[1], part.measured[0])
        before, within = self._z[used], np.zeros(len(piece.F), dtype=bool)
        within[faces] = True

        def laid_out(width: float) -> ComplexArray | None:
            z = least_energy_positions(energy_matrix(F.T, len(used), cot, width), before, free)
            if z is None or not signed_double_areas(z, F.T).min() > 0:
                return None
            rest = self._z[piece.F[self._near(z) & ~within]]
            return None if lie_over(z[F], rest) else z

        z = next((made for width in constants.RELAYOUT_WIDTHS if (made := laid_out(width)) is not None), None)
        if z is None:
            return False
        squared, shear = self._measured(part, z)
        added = squared - self._measured(part, before)[0]
        if not (shear <= constants.MAX_NARROWED_SHEAR and added <= self._left):
            return False
        self._z[used], self._left = z, self._left - max(added, 0.0)
        self._moved |= within
        self._box[:, faces] = self._around(piece.topology.corner[:, faces])
        return True

    def _around(self, corner: IntArray) -> FloatArray:
        """The boxes around faces: the least coordinates, and the largest negated, (4, #f)."""
        sides = (np.ascontiguousarray(part)[corner] for part in (self._z.real, self._z.imag))
        boxes = [(values.min(axis=0), -values.max(axis=0)) for values in sides]
        return np.stack([side for box in zip(*boxes, strict=True) for side in box])

    def _near(self, z: ComplexArray) -> BoolArray:
        """A mask of the faces in the map whose boxes touch the box around these places."""
        x, y = z.real, z.imag
        beyond = np.array([x.max(), y.max(), -x.min(), -y.min()])
        return np.asarray((self._box <= beyond[:, None]).all(axis=0))

    def _measured(self, part: Submesh, z: ComplexArray) -> tuple[float, float]:
        """The squared stretch of faces there, times their area; and their mean angle distortion."""
        changed = change_of(part, coordinates(z))
        area = float(part.measured[0].sum())
        flat = float(signed_double_areas(z, part.F.T).sum()) / self._unit**2
        return changed.mean(changed.squared_stretch) * area**2 / flat, float(changed.angle_distortion.mean())

    def made(self, result: Flattening) -> Flattening:
        """The map, as large as the surface again, if faces have moved."""
        if not self._moved.any():
            return result
        corner = self._piece.topology.corner[:, self._moved]
        angles = result.angles.copy()
        angles[self._moved] = flat_angles(self._z, corner).T
        uv = scaled_to_surface(coordinates(self._z), self._piece)
        number = np.count_nonzero(self._moved)
        message = f"{result.message}; {number:,} faces where it overlapped are laid out narrower"
        return replace(result, uv=uv, angles=angles, message=message)
