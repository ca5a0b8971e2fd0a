"""Connected components: of graphs, and of a surface's vertices and faces."""

import numpy as np

from .._core import connected_labels, sum_by
from .._types import FloatArray, IntArray


def vertex_components(F: IntArray, n: int) -> IntArray:
    """The component of each of the vertices 0 .. n - 1; one of no face is a component of its own."""
    return connected_labels(np.concatenate((F[:, :2], F[:, ::2])), n)


def face_components(F: IntArray, n: int) -> IntArray:
    """The component of each face, numbered from 0; faces that share a vertex are in the same one."""
    label = vertex_components(F, n)[F[:, 0]]
    used = np.zeros(n, dtype=np.int64)
    used[label] = 1
    return np.asarray((np.cumsum(used) - 1)[label])


def centres(of: IntArray, points: FloatArray) -> FloatArray:
    """The mean of the points (#P, dim) of each group, `of` being the group of each."""
    total = np.stack([sum_by(of, x, int(of.max()) + 1) for x in points.T], axis=1)
    return np.asarray(total / np.bincount(of)[:, None])
