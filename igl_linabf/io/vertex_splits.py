"""Vertices duplicated along texture seams, for formats with one index a corner."""

import warnings
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray, IntArray
from ..charts import UDIM_ROW
from ..errors import MeshError, MeshWarning, stack_level
from .mesh_file import MeshFile

# Extents by which coordinates may lie from the origin before they are counted from a point near them. With
# more, single precision rounds them by more than a millionth of the extent; with less, meshes that are well
# where they are get a translation. tests/io/test_precision.py.
MAX_OFFSET = 8

# The share of the extent by which a format may round coordinates without a word. Single precision rounds by
# 6e-8 of the largest coordinate. With less, it would warn of what nobody sees; with more, steps show in thin
# triangles. tests/io/test_precision.py.
ROUNDING_TOLERANCE = 1e-6

COORDINATE_NAMES = ("V", "TC")  # what has an extent


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
    colours : (#P, 3 or 4) float64 or None
    first : (#P, 2) float64 or None
        The first texture coordinates, where `TC` are the second ones.
    """

    vertex: IntArray
    TC: FloatArray
    normals: FloatArray | None
    corners: IntArray
    colours: FloatArray | None = None
    first: FloatArray | None = None


def split_vertices(
    mesh: MeshFile,
    corner: IntArray | slice = slice(None),
    normals: bool = False,
    colours: FloatArray | None = None,
) -> SplitVertices:
    """One index for the corners, or for some of them, instead of two; or more, with normals and colours.

    Colours are those at all corners, (#C, 3 or 4).
    """
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    indices = {"vertex": mesh.polygons.corners[corner], "texture": mesh.texture[corner]}
    if mesh.first is not None:
        indices["first"] = mesh.first[1][corner]
    stored_normals, normal_index, shades = mesh.extras.normals, mesh.extras.normal, None
    if normals and stored_normals is not None and normal_index is not None:
        indices["normal"] = normal_index[corner]
    if colours is not None:
        shades, shade = np.unique(colours[corner], axis=0, return_inverse=True)
        indices["colour"] = shade.ravel()
    rows, corners = find_unique_tuples(*indices.values())
    row = dict(zip(indices, rows, strict=True))
    return SplitVertices(
        row["vertex"],
        mesh.TC[row["texture"]],
        stored_normals[row["normal"]] if "normal" in row and stored_normals is not None else None,
        corners,
        shades[row["colour"]] if shades is not None else None,
        None if mesh.first is None else mesh.first[0][row["first"]],
    )


def split_with_stable_indices(mesh: MeshFile, normals: bool = False) -> SplitVertices:
    """As `split_vertices`, where each vertex keeps its number: its first copy does, the others follow behind.

    So what names vertices by number stays right. Vertices of no corner stay, too, at 0, 0 of the texture.
    """
    split, n = split_vertices(mesh, normals=normals), len(mesh.V)
    used, first = np.unique(split.vertex, return_index=True)
    is_copy = np.ones(len(split.vertex), dtype=bool)
    is_copy[first] = False
    new_index = np.empty(len(split.vertex), dtype=np.int64)
    new_index[first], new_index[is_copy] = used, n + np.arange(int(is_copy.sum()))

    def ordered(rows: FloatArray) -> FloatArray:
        table = np.zeros((n + int(is_copy.sum()), rows.shape[1]))
        table[new_index] = rows
        return table

    return SplitVertices(
        np.append(np.arange(n), split.vertex[is_copy]),
        ordered(split.TC),
        None if split.normals is None else ordered(split.normals),
        new_index[split.corners],
        first=None if split.first is None else ordered(split.first),
    )


def find_unique_tuples(*indices: IntArray) -> tuple[list[IntArray], IntArray]:
    """The distinct combinations of several indices, as the rows of each, and which one is where."""
    key = indices[0]
    for index in indices[1:]:  # step by step, so that the keys stay small
        key = key * (int(index.max(initial=0)) + 1) + index
        if index is not indices[-1]:
            _, key = np.unique(key, return_inverse=True)
    _, first, place = np.unique(key, return_index=True, return_inverse=True)
    return [index[first] for index in indices], place.ravel().astype(np.int64)


def find_face_pages(mesh: MeshFile) -> IntArray:
    """The page (UDIM tile) that each face lies on, (#F,): that of the middle of its corners."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    middle = np.zeros((len(mesh.polygons), 2))
    np.add.at(middle, mesh.polygons.owner, mesh.TC[mesh.texture])
    column, row = np.floor(middle / mesh.polygons.sizes[:, None]).astype(np.int64).T
    return np.asarray(column + UDIM_ROW * row)


class SplitTriangles(NamedTuple):
    """Triangles that have one index for position and texture coordinates.

    Attributes
    ----------
    V, TC : (#P, 3) and (#P, 2) float64
    F : (#T, 3) int64
    vertex : (#P,) int64
        The vertex that each row is of.
    """

    V: FloatArray
    TC: FloatArray
    F: IntArray
    vertex: IntArray


def split_at_seams(mesh: MeshFile) -> SplitTriangles:
    """Each distinct pair of position and texture coordinate at a corner, and triangles over these pairs."""
    split = split_vertices(mesh)
    return SplitTriangles(mesh.V[split.vertex], split.TC, split.corners[mesh.split.place], split.vertex)


def make_flat_surface(mesh: MeshFile) -> tuple[FloatArray, IntArray, IntArray | None]:
    """The flat map as a surface, u, v, 0: points (n, 3) and triangles; and the vertices of the points.

    Vertices keep their numbers if each has one texture coordinate at most; those without are at the origin.
    Then there is None instead of the vertices.
    """
    split = split_vertices(mesh)
    if len(np.unique(split.vertex)) == len(split.vertex):
        points = np.zeros((len(mesh.V), 3))
        points[split.vertex, :2] = split.TC
        return points, mesh.triangles, None
    return np.insert(split.TC, 2, 0.0, axis=1), split.corners[mesh.split.place], split.vertex


def choose_origin(V: FloatArray) -> FloatArray:
    """A point (3,) from which single precision holds coordinates (n, 3); 0 where it does so already."""
    low, high = V.min(axis=0), V.max(axis=0)
    middle, extent = low / 2 + high / 2, (high - low).max()
    if not np.abs(V).max() > MAX_OFFSET * extent or not np.isfinite(extent):
        return np.zeros(3)
    return np.asarray(middle)


def warn_of_rounding(rows: FloatArray, rounded: NDArray[Any], name: str) -> None:
    """Say by how much the format rounds coordinates, if that is to be seen."""
    extent = np.ptp(rows, axis=0).max() if len(rows) else 0.0
    error = np.abs(rows - rounded).max(initial=0)
    if error > ROUNDING_TOLERANCE * extent > 0:
        warnings.warn(
            f"{name} is rounded by up to {error / extent:.2g} of its extent, as the format has too few digits: "
            "write OBJ, which keeps all of them, or bring it nearer to the origin and to a size of 1",
            MeshWarning,
            stacklevel=stack_level(),
        )


def to_single_precision(rows: FloatArray, name: str) -> NDArray[np.float32]:
    """The rows in single precision."""
    if np.abs(rows).max(initial=0) > np.finfo(np.float32).max:
        raise MeshError(f"{name} has numbers beyond 3.4e38, the largest 32-bit float: scale it, or write OBJ")
    rounded = rows.astype("<f4")
    if name in COORDINATE_NAMES:
        warn_of_rounding(rows, rounded, name)
    return rounded
