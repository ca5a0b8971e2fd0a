"""The seams of texture coordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError, some
from ..surface import NEXT, PREV, Polygons, Topology, compact, face_array, manifold_topology


def texture_seams(F: ArrayLike, FTC: ArrayLike) -> IntArray:
    """The seams of existing texture coordinates.

    Parameters
    ----------
    F : (#F, 3) or (#F, k) int, or list of lists of int
        Oriented triangles or polygons.
    FTC : in the shape of `F`
        Indices of the texture coordinates at the corners, as `igl.readOBJ` returns them.

    Returns
    -------
    seams : (#E, 2) int64
        Vertices of the interior edges whose two faces have different texture coordinates there.

    Raises
    ------
    MeshError
        The arrays are malformed or do not fit together, a corner has no texture coordinate, or the
        surface is not an oriented manifold.

    Examples
    --------
    >>> texture_seams([[0, 1, 2], [2, 1, 3]], [[0, 1, 2], [4, 1, 3]])
    array([[1, 2]])
    """
    faces, texture = _triangles(F, FTC)
    bad = np.flatnonzero((texture < 0).any(axis=1))
    if len(bad):
        raise MeshError(f"faces {some(bad)} have corners without texture in FTC: give them coordinates")
    vertices, packed = compact(faces, int(faces.max()) + 1)
    topology = manifold_topology(packed, vertices)
    return vertices[edges_between_textures(topology, texture)]


def _triangles(F: ArrayLike, FTC: ArrayLike) -> tuple[IntArray, IntArray]:
    """Faces and their texture as triangles; as fans, whose diagonals are no seams, whatever their shape."""
    polygons, texture = Polygons.of(F), Polygons.of(FTC)
    if len(texture) != len(polygons) or (texture.sizes != polygons.sizes).any():
        raise MeshError(f"FTC has {len(texture)} rows for {len(polygons)} faces, or others: pass F's shape")
    if (polygons.sizes == 3).all():
        return face_array(F), face_array(FTC)
    split = polygons.split(np.zeros((int(polygons.corners.max()) + 1, 3)))
    whole = (split.F[:, [1, 2, 0]] != split.F).all(axis=1)
    return split.F[whole], texture.corners[split.place[whole]]


def edges_between_textures(topology: Topology, texture: IntArray) -> IntArray:
    """`texture_seams` of a surface that is checked, by its own vertices."""
    return np.asarray(topology.edges[rows_between_textures(topology, texture)])


def textured_seams(topology: Topology, TC: FloatArray, FTC: IntArray) -> tuple[IntArray, float]:
    """`edges_between_textures`, and the largest |log ratio| of the lengths of their two sides."""
    between = rows_between_textures(topology, FTC)
    start, end = FTC.T[NEXT].ravel(), FTC.T[PREV].ravel()
    halves = topology.sides[:, between]
    length = np.linalg.norm(TC[end[halves]] - TC[start[halves]], axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):  # where a side is a point in the map
        ratio = np.abs(np.log(length[0] / length[1]))
    return topology.edges[between], float(np.nan_to_num(ratio, nan=0.0).max(initial=0.0))


def rows_between_textures(topology: Topology, texture: IntArray) -> IntArray:
    """Rows of `topology.edges`."""
    inside = np.flatnonzero(topology.sides[1] >= 0)
    first, second = topology.sides[:, inside]
    start, end = texture.T[NEXT].ravel(), texture.T[PREV].ravel()  # of each half-edge
    return np.asarray(inside[(start[first] != end[second]) | (end[first] != start[second])])


def texture_sides(V: FloatArray, F: ArrayLike, TC: FloatArray, FTC: ArrayLike) -> BoolArray:
    """The seams of the texture coordinates of any triangles or polygons, as a mask of their sides.

    Vertices, and texture coordinates, are those in one place. A side is on a seam if it has others beside
    it, none of which has its texture coordinates. The mask has the shape of triangles; else it is flat.
    """
    polygons, texture = Polygons.of(F), Polygons.of(FTC).corners
    a, s = (
        np.unique(points, axis=0, return_inverse=True)[1].ravel()[corners]
        for points, corners in ((V, polygons.corners), (TC, texture))
    )
    b, t = a[polygons.following], s[polygons.following]
    forth = a < b
    sides = np.column_stack([np.where(forth, *pair) for pair in ((a, b), (b, a), (s, t), (t, s))])

    def alike(columns: int) -> IntArray:
        _, which, number = np.unique(sides[:, :columns], axis=0, return_inverse=True, return_counts=True)
        return np.asarray(number[which.ravel()])

    mask = (alike(2) > 1) & (alike(4) == 1)
    return np.asarray(mask.reshape(-1, 3) if (polygons.sizes == 3).all() else mask)
