"""Vertices duplicated along texture seams, for formats with one index a corner."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray, IntArray
from ..errors import MeshError, MeshWarning, stack_level
from .mesh_file import MeshFile


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


def split_at_seams(mesh: MeshFile) -> tuple[FloatArray, FloatArray, IntArray]:
    """Each distinct pair of position and texture coordinate at a corner, and triangles over these pairs."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    made = one_index(mesh.polygons.corners, mesh.texture)
    return mesh.V[made.rows[0]], mesh.TC[made.rows[1]], made.corners[mesh.split.place]


def flat_surface(mesh: MeshFile) -> tuple[FloatArray, IntArray]:
    """The flat map as a surface, u, v, 0: points (n, 3) and triangles.

    Vertices keep their numbers if each has one texture coordinate at most; those without are at the origin.
    """
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    made = one_index(mesh.polygons.corners, mesh.texture)
    if len(np.unique(made.rows[0])) == len(made.rows[0]):
        points = np.zeros((len(mesh.V), 3))
        points[made.rows[0], :2] = mesh.TC[made.rows[1]]
        return points, mesh.triangles
    warnings.warn(
        "vertices are written once for each of their texture coordinates: data of the given vertices "
        "does not fit to the flat surface",
        MeshWarning,
        stacklevel=stack_level(),
    )
    return np.column_stack((mesh.TC[made.rows[1]], np.zeros(len(made.rows[1])))), made.corners[
        mesh.split.place
    ]


def single(rows: FloatArray, name: str) -> NDArray[np.float32]:
    """The rows in single precision."""
    if np.abs(rows).max(initial=0) > np.finfo(np.float32).max:
        raise MeshError(f"{name} has numbers beyond 3.4e38, the largest 32-bit float: scale it, or write OBJ")
    return rows.astype("<f4")
