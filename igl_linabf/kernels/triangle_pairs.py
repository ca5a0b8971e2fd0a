"""Pairs of triangles in the plane that lie over each other."""

from __future__ import annotations

import numpy as np

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from .choice import with_loops


def _interpenetrating(
    triangle: ComplexArray, pairs: IntArray, depth: FloatArray, rounding: FloatArray
) -> BoolArray:
    inward = np.empty_like(triangle)
    for t in range(len(triangle)):
        for k in range(3):
            side = triangle[t, (k + 1) % 3] - triangle[t, k]
            inward[t, k] = np.conj(side / abs(side))
    found = np.ones(len(pairs), dtype=np.bool_)
    for p in range(len(pairs)):
        least = min(depth[pairs[p, 0]], depth[pairs[p, 1]])
        least += max(rounding[pairs[p, 0]], rounding[pairs[p, 1]])
        for side in range(6):
            i, j, k = pairs[p, side // 3], pairs[p, 1 - side // 3], side % 3
            start, by, reach = triangle[i, k], inward[i, k], -np.inf
            for corner in range(3):
                reach = max(reach, (by * (triangle[j, corner] - start)).imag)
            if not reach > least:
                found[p] = False
                break
    return found


@with_loops(_interpenetrating)
def interpenetrating(
    triangle: ComplexArray, pairs: IntArray, depth: FloatArray, rounding: FloatArray
) -> BoolArray:
    """Which of the `pairs`, (#P, 2), of counter-clockwise triangles, (#T, 3), no side separates.

    Each of the two has to reach across all sides of the other by the smaller of their depths, and by their
    rounding.
    """
    side = np.roll(triangle, -1, axis=1) - triangle
    inward = (side / np.abs(side)).conj()
    found = np.arange(len(pairs))
    for order in ((0, 1), (1, 0)):
        for k in range(3):
            i, j = pairs[found][:, order].T
            reach = (inward[i, k] * (triangle[j, 0] - triangle[i, k])).imag
            for corner in (1, 2):
                np.maximum(reach, (inward[i, k] * (triangle[j, corner] - triangle[i, k])).imag, out=reach)
            least = np.minimum(depth[i], depth[j]) + np.maximum(rounding[i], rounding[j])
            found = found[reach > least]
    mask = np.zeros(len(pairs), dtype=bool)
    mask[found] = True
    return mask
