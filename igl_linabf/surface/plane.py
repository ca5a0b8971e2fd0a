"""Plane geometry of flat maps: areas, angles, scale, and similarities."""

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .._core import signed_double_areas
from .._types import Array, ComplexArray, FloatArray, IntArray
from ..errors import MeshError
from .arrays import Pins
from .constants import LEAST_AREA_SHARE
from .mesh import Mesh
from .topology import NEXT, PREV, Topology


def area_scale_ratio(mesh: Mesh, z: ComplexArray) -> float:
    """The largest area scale of a map over its smallest one, bounded as by `bounded_ratio`."""
    scale = np.abs(signed_double_areas(z, mesh.topology.corner)) / mesh.double_area
    return float(bounded_ratio(scale.max(), scale.min()))


def bounded_ratio(largest: Array, smallest: Array) -> Array:
    """The ratio of area scales, at most a hundred times a hopeless one: of a collapsed map it is that."""
    return np.asarray(largest / np.maximum(smallest, LEAST_AREA_SHARE * largest))


def of_size_one(uv: FloatArray) -> FloatArray:
    """The coordinates scaled by a power of two, exactly, so that the largest is about one.

    Squares of larger ones could overflow.
    """
    largest = float(np.abs(uv).max())
    return np.ldexp(uv, -int(np.frexp(largest)[1]))


def times_power_of_two(number: float, power: int) -> float:
    """The number times this power of two; infinite where double precision ends."""
    with np.errstate(over="ignore"):
        return float(np.ldexp(number, power))


def flat_angles(z: ComplexArray, corner: IntArray) -> FloatArray:
    """Angles of the triangles of a flat map (#V,), (3, #F) radians; positive, flipped or not."""
    at = z[corner]
    cross = (at[NEXT] - at).conj() * (at[PREV] - at)
    return np.arctan2(np.abs(cross.imag), cross.real)


def complex_positions(uv: FloatArray) -> ComplexArray:
    """(#V, 2) coordinates as complex numbers."""
    return np.asarray(uv[:, 0] + 1j * uv[:, 1])


def coordinates(z: ComplexArray) -> FloatArray:
    """Complex positions as (#V, 2)."""
    return np.column_stack((z.real, z.imag))


def flipped_faces(z: ComplexArray, corner: IntArray) -> IntArray:
    """Faces whose area in the map is not positive."""
    return np.flatnonzero(~(signed_double_areas(z, corner) > 0))


def move_to_pins(z: ComplexArray, pinned: Pins) -> ComplexArray:
    """The map rotated, scaled and moved so that the pinned vertices are at their pins."""
    (i, j), position = pinned[0], complex_positions(pinned[1])
    if z[i] == z[j]:
        raise MeshError(f"vertices {i} and {j} coincide in the map: pin two other vertices")
    return np.asarray(position[0] + (z - z[i]) * ((position[1] - position[0]) / (z[j] - z[i])))


def unit_vectors(vectors: FloatArray) -> FloatArray:
    """Vectors along the last axis at length one; those of no length stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0, length, 1.0))


def direction_in_space(given: ArrayLike, name: str) -> FloatArray:
    """Three numbers as a unit vector.

    Raises
    ------
    ValueError
        They are not three, not finite, or all zero.
    """
    try:
        direction = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        direction = np.empty(0)
    length = float(np.linalg.norm(direction))
    if direction.shape != (3,) or not 0 < length < np.inf:
        raise ValueError(f"{name} is {given!r}: give a direction in space, three numbers")
    return np.asarray(direction / length)


def mapped_direction(
    V: FloatArray, z: ComplexArray, F: IntArray, direction: FloatArray
) -> tuple[ComplexArray, FloatArray]:
    """A direction in space projected to each triangle (#F, 3) and mapped, (#F,); and their areas in space."""
    e, f = (V[F[:, k]] - V[F[:, 0]] for k in (1, 2))
    u, v = (z[F[:, k]] - z[F[:, 0]] for k in (1, 2))
    ee, ef, ff = (e * e).sum(1), (e * f).sum(1), (f * f).sum(1)
    de, df = e @ direction, f @ direction
    det = np.maximum(ee * ff - ef * ef, np.finfo(float).tiny)  # a collapsed triangle has none
    along = (de * ff - df * ef) / det * u + (df * ee - de * ef) / det * v
    return along, np.sqrt(det) / 2


def centred(topology: Topology, z: ComplexArray, area: float) -> ComplexArray:
    """The map scaled to `area` and placed by `_core.centred`."""
    corner = topology.corner
    double = np.abs(signed_double_areas(z, corner))
    ends = np.array([0, len(z)]), np.array([0, len(double)])
    return _core.centred(z, corner, double, np.array([area]), *ends)
