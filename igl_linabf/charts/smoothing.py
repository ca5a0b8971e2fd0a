"""Values of vertices, smoothed so that noise and single faces do not matter; and the curvature that is."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from .._types import FloatArray, IntArray
from ..kernels import entries
from ..surface import Submesh, sum_by


class Smoothing:
    """Averages over neighbours, repeated: n times they reach over about the square root of n edges.

    Parameters
    ----------
    component : Submesh
    edges : (#E, 2) int64
    length : (#E,) float64
        Of the edges.
    """

    def __init__(self, component: Submesh, edges: IntArray, length: FloatArray) -> None:
        n = len(component.V)
        indptr, indices, _ = entries(edges.T, n)
        # both triangles have the diagonal
        self._upper = sparse.csr_array((np.ones(len(indices)), indices, indptr), shape=(n, n))
        self._number = np.diff(indptr) + np.bincount(indices, minlength=n) - 1.0
        self._length = float(np.median(length)) if len(length) else np.inf

    def steps(self, reach: float, most: int) -> int:
        """How many times reach so far, from 1 to `most`."""
        return int(np.clip(round((reach / self._length) ** 2), 1, most))

    def of(self, values: NDArray[Any], steps: int) -> FloatArray:
        """Smoothed values of the vertices, (#V,) or (#V, k)."""
        number = self._number.reshape((-1,) + (1,) * (values.ndim - 1))
        for _ in range(steps):
            values = (self._upper @ values + self._upper.T @ values - values) / number
        return np.asarray(values)


def turned_at(
    component: Submesh, edges: IntArray, length: FloatArray, bend: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Twice the mean curvature, integrated around each vertex, and the area there."""
    half, corner, double_area = bend * length / 2, component.F.T.ravel(), component.measured[0]
    turned = sum_by(edges.T.ravel(), np.tile(half, 2), len(component.V))
    return turned, sum_by(corner, np.tile(double_area / 6, 3), len(component.V))
