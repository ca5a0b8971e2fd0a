"""Fill small holes smoothly during the flattening, without changing the result.

The fills save memory and time, because a map without holes is laid out from its boundary loop.
"""

import numpy as np
import scipy.ndimage
from scipy import sparse
from scipy.sparse import linalg

from .._types import BoolArray, FloatArray

MAX_FILLED_POINTS = 2_500  # holes with more missing points are not filled
SLOPE_WEIGHT = 1e-4  # weight of first differences relative to second differences; makes the fill unique


def fill_holes(points: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Fill the small holes of a grid of points with the least bending.

    Return the points, and a mask of the points that were filled.
    """
    missing = ~np.isfinite(points).all(axis=2)
    label, number = scipy.ndimage.label(missing, structure=np.ones((3, 3)))
    small = np.bincount(label.ravel(), minlength=number + 1) <= MAX_FILLED_POINTS
    small[0] = False
    for border in (label[0], label[-1], label[:, 0], label[:, -1]):
        small[border] = False
    filled = np.asarray(small[label])
    if not filled.any():
        return points, filled
    made = points.copy()
    made[filled] = _interpolate_positions(points, filled, ~missing | filled)
    return made, filled


def _interpolate_positions(points: FloatArray, filled: BoolArray, present: BoolArray) -> FloatArray:
    """Return positions of the filled points that minimize the squared differences along the grid."""
    number = np.full(filled.shape, -1)
    number[filled] = np.arange(filled.sum())
    rows, columns, values, right = [], [], [], []
    count = 0
    for stencil, weight in (((1.0, -2.0, 1.0), 1.0), ((1.0, -1.0), SLOPE_WEIGHT)):
        for axis in (0, 1):
            length = filled.shape[axis] - len(stencil) + 1
            at = [
                np.take(np.arange(filled.size).reshape(filled.shape), range(k, k + length), axis).ravel()
                for k in range(len(stencil))
            ]
            used = np.all([present.ravel()[i] for i in at], axis=0) & np.any(
                [filled.ravel()[i] for i in at], axis=0
            )
            at = [i[used] for i in at]
            known = np.zeros((len(at[0]), 3))
            for index, factor in zip(at, stencil, strict=True):
                unknown = number.ravel()[index]
                rows.append(count + np.flatnonzero(unknown >= 0))
                columns.append(unknown[unknown >= 0])
                values.append(np.full(len(rows[-1]), factor * weight))
                known += factor * weight * np.where(unknown[:, None] < 0, points.reshape(-1, 3)[index], 0)
            right.append(-known)
            count += len(known)
    shape = count, int(filled.sum())
    A = sparse.csc_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape)
    solved = linalg.splu(sparse.csc_matrix(A.T @ A)).solve(A.T @ np.concatenate(right))
    return np.asarray(solved)
