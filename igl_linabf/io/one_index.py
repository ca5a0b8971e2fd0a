"""Vertices duplicated along texture seams, for formats with one index a corner."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray, IntArray
from ..errors import MeshError


@dataclass(frozen=True, eq=False)
class OneIndex:
    """Each distinct combination of indices at the corners, once.

    Attributes
    ----------
    rows : tuple of (#P,) int64
        For each of the given indices (positions, texture, normals) its row at each new vertex.
    corners : (#C,) int64
        The new vertex at each corner.
    """

    rows: tuple[IntArray, ...]
    corners: IntArray


def one_index(*indices: IntArray) -> OneIndex:
    """One index for the corners instead of several, (#C,) each."""
    key, sizes = indices[0], []
    for index in indices[1:]:  # step by step, so that the keys stay small
        sizes.append(int(index.max(initial=0)) + 1)
        key = key * sizes[-1] + index
        if index is not indices[-1]:
            _, key = np.unique(key, return_inverse=True)
    _, first, corners = np.unique(key, return_index=True, return_inverse=True)
    return OneIndex(tuple(index[first] for index in indices), corners.ravel().astype(np.int64))


def split_at_seams(
    V: FloatArray, F: IntArray, TC: FloatArray, FTC: IntArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Each distinct pair of position and texture coordinate at a corner, and the faces over these pairs."""
    made = one_index(F.ravel(), FTC.ravel())
    return V[made.rows[0]], TC[made.rows[1]], made.corners.reshape(F.shape)


def single(rows: FloatArray, name: str) -> NDArray[np.float32]:
    """The rows in single precision."""
    if np.abs(rows).max(initial=0) > np.finfo(np.float32).max:
        raise MeshError(f"{name} has numbers beyond 3.4e38, the largest 32-bit float: scale it, or write OBJ")
    return rows.astype("<f4")
