"""Triangle strips as triangles."""

import numpy as np

from .._types import IntArray
from ..surface import three_vertices


def triangles_of_strips(corners: IntArray, strip: IntArray) -> IntArray:
    """Each corner makes a triangle with the two before it; every second one is turned.

    Triangles that have a vertex twice are left out: programs write them to join strips into one.

    Parameters
    ----------
    corners : (#C,) int64
        The vertices of all strips.
    strip : (#C,) int64
        The strip of each, which does not decrease.

    Returns
    -------
    F : (#F, 3) int64
    """
    at = np.arange(len(corners))
    first = np.maximum.accumulate(np.where(np.diff(strip, prepend=-1) != 0, at, 0))
    F = np.column_stack((corners[:-2], corners[1:-1], corners[2:]))
    turned = (at - first)[:-2] % 2 == 1
    F[turned] = F[turned][:, [1, 0, 2]]
    return np.asarray(F[three_vertices(F) & (strip[:-2] == strip[2:])])
