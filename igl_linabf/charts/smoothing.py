"""Values of vertices, smoothed so that noise and single faces do not matter; and the curvature that is."""

import numpy as np

from .._core import entries, product_with_pairs
from .._types import FloatArray, IntArray
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
        self._matrix = indptr, indices, np.ones(len(indices))  # the upper triangle; the diagonal is one, too
        self._number = np.diff(indptr) + np.bincount(indices, minlength=n) - 1.0
        self._length = float(np.median(length)) if len(length) else np.inf

    def steps(self, reach: float, most: int) -> int:
        """How many times reach so far, from 1 to `most`."""
        return int(np.clip(round((reach / self._length) ** 2), 1, most))

    def of(self, values: FloatArray, steps: int) -> FloatArray:
        """Smoothed values of the vertices, (#V,) or (#V, 2)."""
        pairs = values if values.ndim > 1 else np.column_stack((values, np.zeros(len(values))))
        for _ in range(steps):
            pairs = product_with_pairs(*self._matrix, pairs) / self._number[:, None]
        return pairs if values.ndim > 1 else np.ascontiguousarray(pairs[:, 0])


def turned_at(
    component: Submesh, edges: IntArray, length: FloatArray, bend: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Twice the mean curvature, integrated around each vertex, and the area there."""
    half, corner, double_area = bend * length / 2, component.F.T.ravel(), component.measured[0]
    turned = sum_by(edges.T.ravel(), np.tile(half, 2), len(component.V))
    return turned, sum_by(corner, np.tile(double_area / 6, 3), len(component.V))
