"""Vertices duplicated along texture seams, in single precision, for formats with one index a corner."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray, IntArray
from ..errors import MeshError


def split_at_seams(
    V: FloatArray, F: IntArray, TC: FloatArray, FTC: IntArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Each distinct pair of position and texture coordinate at a corner, and the faces over these pairs."""
    n = len(TC)
    pairs, index = np.unique(F.ravel() * n + FTC.ravel(), return_inverse=True)
    return V[pairs // n], TC[pairs % n], index.reshape(F.shape).astype(np.int64)


def single(rows: FloatArray, name: str) -> NDArray[np.float32]:
    """The rows in single precision."""
    if np.abs(rows).max() > np.finfo(np.float32).max:
        raise MeshError(f"{name} has numbers beyond 3.4e38, the largest 32-bit float: scale it, or write OBJ")
    return rows.astype("<f4")
