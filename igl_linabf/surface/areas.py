"""Compute areas of faces in space, and the scalar products of their sides for cotangents."""

import numpy as np

from .._core import side_products
from .._types import FloatArray, IntArray
from ..errors import MeshError, first_few
from .constants import LARGEST_COORDINATE, SMALLEST_COORDINATE


def measure_faces(V: FloatArray, corner: IntArray, vertices: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return twice the area of each face and the scalar products of the two sides at each corner.

    Raises
    ------
    MeshError
        The area of a face is not larger than its rounding error, or the coordinates are so large or
        so small that fourth powers of lengths overflow or underflow.
    """
    largest = max(V.max(), -V.min())
    if not SMALLEST_COORDINATE < largest < LARGEST_COORDINATE:
        i = int(np.argmax(np.abs(V))) // V.shape[1]
        raise MeshError(
            f"the largest coordinate is {largest:.1e} (vertex {vertices[i]}), outside "
            f"{SMALLEST_COORDINATE:g} .. {LARGEST_COORDINATE:g}, where areas can be computed: scale the mesh"
        )
    double_area, dot, least = side_products(V, corner)
    bad = np.flatnonzero(~(double_area > least))
    if len(bad):
        raise MeshError(
            f"faces {first_few(bad)} have zero area (face {bad[0]} has vertices "
            f"{vertices[corner[:, bad[0]]].tolist()}): "
            "collapse or remove them, or move their vertices apart, as igl_linabf.clean does"
        )
    return double_area, dot


def find_faces_without_area(V: FloatArray, F: IntArray, times: float = 1.0) -> IntArray:
    """Return the faces whose area is at most `times` the rounding error of an area.

    With `times` = 1, these are the faces that `measure_faces` rejects. Coordinates must be in the range that
    `measure_faces` accepts.
    """
    if not len(F):
        return np.zeros(0, dtype=np.int64)
    double_area, _, least = side_products(V, np.ascontiguousarray(F.T))
    return np.flatnonzero(~(double_area > times * least))
