"""Compute areas, angles and scales of flat maps, and transform maps by similarities."""

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .._core import signed_double_areas
from .._types import Array, ComplexArray, FloatArray, IntArray
from ..errors import MeshError
from .arrays import Pins
from .mesh import Mesh
from .topology import NEXT, PREV, Topology

# Bounds of the ratio of the largest to the smallest area scale of a map.
SAFE_AREA_RATIO = 1e12  # maximum area scale ratio for computations in double precision
HOPELESS_AREA_RATIO = 1e30  # at a larger area scale ratio, edge lengths differ by all 15 digits of a double
LEAST_AREA_SHARE = 1e-32  # minimum area scale that is distinguished from 0, relative to the largest


def compute_area_scale_ratio(mesh: Mesh, z: ComplexArray) -> float:
    """Return the ratio of the largest to the smallest area scale of a map, see `compute_bounded_ratio`."""
    scale = np.abs(signed_double_areas(z, mesh.topology.corner)) / mesh.double_area
    return float(compute_bounded_ratio(scale.max(), scale.min()))


def compute_bounded_ratio(largest: Array, smallest: Array) -> Array:
    """Return largest / smallest, limited to 1 / `LEAST_AREA_SHARE`, the value for a collapsed map."""
    return np.asarray(largest / np.maximum(smallest, LEAST_AREA_SHARE * largest))


def scale_to_unit_size(uv: FloatArray) -> FloatArray:
    """Scale the coordinates exactly, by a power of two, so that the largest coordinate is about 1.

    Squares of the scaled coordinates cannot overflow.
    """
    largest = float(np.abs(uv).max())
    return np.ldexp(uv, -int(np.frexp(largest)[1]))


def multiply_by_power_of_two(number: float, power: int) -> float:
    """Return number * 2**power; infinite on overflow."""
    with np.errstate(over="ignore"):
        return float(np.ldexp(number, power))


def compute_flat_angles(z: ComplexArray, corner: IntArray) -> FloatArray:
    """Return the corner angles of a flat map, (3, #F), radians; also positive for flipped triangles."""
    at = z[corner]
    cross = (at[NEXT] - at).conj() * (at[PREV] - at)
    return np.arctan2(np.abs(cross.imag), cross.real)


def complex_positions(uv: FloatArray) -> ComplexArray:
    """Convert (#V, 2) coordinates to complex numbers."""
    return np.asarray(uv[:, 0] + 1j * uv[:, 1])


def real_coordinates(z: ComplexArray) -> FloatArray:
    """Convert complex positions to (#V, 2) coordinates."""
    return np.column_stack((z.real, z.imag))


def find_flipped_faces(z: ComplexArray, corner: IntArray) -> IntArray:
    """Return the faces whose signed area in the map is not positive."""
    return np.flatnonzero(~(signed_double_areas(z, corner) > 0))


def move_to_pins(z: ComplexArray, pinned: Pins) -> ComplexArray:
    """Rotate, scale and translate the map so that the two pinned vertices are at their pins."""
    (i, j), position = pinned[0], complex_positions(pinned[1])
    if z[i] == z[j]:
        raise MeshError(f"vertices {i} and {j} coincide in the map: pin two other vertices")
    return np.asarray(position[0] + (z - z[i]) * ((position[1] - position[0]) / (z[j] - z[i])))


def normalize_vectors(vectors: FloatArray) -> FloatArray:
    """Normalize the vectors along the last axis; zero vectors stay zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0, length, 1.0))


def parse_direction(given: ArrayLike, name: str) -> FloatArray:
    """Return three given numbers as a unit vector.

    Raises
    ------
    ValueError
        `given` is not three finite numbers, or all of them are zero.
    """
    try:
        direction = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        direction = np.empty(0)
    length = float(np.linalg.norm(direction))
    if direction.shape != (3,) or not 0 < length < np.inf:
        raise ValueError(f"{name} is {given!r}: give a direction in space, three numbers")
    return np.asarray(direction / length)


def map_direction(
    V: FloatArray, z: ComplexArray, F: IntArray, direction: FloatArray
) -> tuple[ComplexArray, FloatArray]:
    """Project a direction in space to each triangle, and map the projection to the plane.

    Return the mapped directions, (#F,), and the areas of the triangles in space, (#F,).
    """
    e, f = (V[F[:, k]] - V[F[:, 0]] for k in (1, 2))
    u, v = (z[F[:, k]] - z[F[:, 0]] for k in (1, 2))
    ee, ef, ff = (e * e).sum(1), (e * f).sum(1), (f * f).sum(1)
    de, df = e @ direction, f @ direction
    det = np.maximum(ee * ff - ef * ef, np.finfo(float).tiny)  # avoid 0 / 0 in collapsed triangles
    along = (de * ff - df * ef) / det * u + (df * ee - de * ef) / det * v
    return along, np.sqrt(det) / 2


def normalize_placement(topology: Topology, z: ComplexArray, area: float) -> ComplexArray:
    """Scale the map to `area`, center it and rotate it to its principal axes, see `_core.normalize_maps`."""
    corner = topology.corner
    double = np.abs(signed_double_areas(z, corner))
    ends = np.array([0, len(z)]), np.array([0, len(double)])
    return _core.normalize_maps(z, corner, double, np.array([area]), *ends)
