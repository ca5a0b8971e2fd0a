"""Vertices duplicated along texture seams, for formats with one index a corner."""

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray, IntArray
from ..errors import MeshError, MeshWarning, stack_level
from .mesh_file import MeshFile


@dataclass(frozen=True, eq=False)
class SplitVertices:
    """Each distinct combination of position, texture coordinates and normal at a corner, once.

    Attributes
    ----------
    vertex : (#P,) int64
        The vertex of each.
    TC : (#P, 2) float64
    normals : (#P, 3) float64 or None
    corners : (#C,) int64
        Which one is at each corner.
    """

    vertex: IntArray
    TC: FloatArray
    normals: FloatArray | None
    corners: IntArray


def split_vertices(
    mesh: MeshFile, corner: IntArray | slice = slice(None), normals: bool = False
) -> SplitVertices:
    """One index for the corners, or for some of them, instead of two; or, with normals, of three."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    indices = [mesh.polygons.corners[corner], mesh.texture[corner]]
    given, of = mesh.extras.normals, mesh.extras.normal
    if not normals or given is None or of is None:
        (vertex, texture), corners = unique_tuples(*indices)
        return SplitVertices(vertex, mesh.TC[texture], None, corners)
    (vertex, texture, normal), corners = unique_tuples(*indices, of[corner])
    return SplitVertices(vertex, mesh.TC[texture], given[normal], corners)


def split_behind(mesh: MeshFile, normals: bool = False) -> SplitVertices:
    """As `split_vertices`, where each vertex keeps its number: its first copy does, the others follow behind.

    So what names vertices by number stays right. Vertices of no corner stay, too, at 0, 0 of the texture.
    """
    made, n = split_vertices(mesh, normals=normals), len(mesh.V)
    known, first = np.unique(made.vertex, return_index=True)
    rest = np.ones(len(made.vertex), dtype=bool)
    rest[first] = False
    number = np.empty(len(made.vertex), dtype=np.int64)
    number[first], number[rest] = known, n + np.arange(int(rest.sum()))

    def ordered(rows: FloatArray) -> FloatArray:
        table = np.zeros((n + int(rest.sum()), rows.shape[1]))
        table[number] = rows
        return table

    return SplitVertices(
        np.append(np.arange(n), made.vertex[rest]),
        ordered(made.TC),
        None if made.normals is None else ordered(made.normals),
        number[made.corners],
    )


def unique_tuples(*indices: IntArray) -> tuple[list[IntArray], IntArray]:
    """The distinct combinations of several indices, as the rows of each, and which one is where."""
    key = indices[0]
    for index in indices[1:]:  # step by step, so that the keys stay small
        key = key * (int(index.max(initial=0)) + 1) + index
        if index is not indices[-1]:
            _, key = np.unique(key, return_inverse=True)
    _, first, place = np.unique(key, return_index=True, return_inverse=True)
    return [index[first] for index in indices], place.ravel().astype(np.int64)


def split_at_seams(mesh: MeshFile) -> tuple[FloatArray, FloatArray, IntArray]:
    """Each distinct pair of position and texture coordinate at a corner, and triangles over these pairs."""
    made = split_vertices(mesh)
    return mesh.V[made.vertex], made.TC, made.corners[mesh.split.place]


def flat_surface(mesh: MeshFile) -> tuple[FloatArray, IntArray]:
    """The flat map as a surface, u, v, 0: points (n, 3) and triangles.

    Vertices keep their numbers if each has one texture coordinate at most; those without are at the origin.
    """
    made = split_vertices(mesh)
    if len(np.unique(made.vertex)) == len(made.vertex):
        points = np.zeros((len(mesh.V), 3))
        points[made.vertex, :2] = made.TC
        return points, mesh.triangles
    warnings.warn(
        "vertices are written once for each of their texture coordinates: data of the given vertices "
        "does not fit to the flat surface",
        MeshWarning,
        stacklevel=stack_level(),
    )
    return np.insert(made.TC, 2, 0.0, axis=1), made.corners[mesh.split.place]


def single_precision(rows: FloatArray, name: str) -> NDArray[np.float32]:
    """The rows in single precision."""
    if np.abs(rows).max(initial=0) > np.finfo(np.float32).max:
        raise MeshError(f"{name} has numbers beyond 3.4e38, the largest 32-bit float: scale it, or write OBJ")
    return rows.astype("<f4")
