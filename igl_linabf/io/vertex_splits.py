"""Duplicate vertices along texture seams, for formats with a single index per corner."""

import warnings
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray, IntArray
from ..charts import UDIM_ROW
from ..errors import MeshError, MeshWarning, stack_level
from .mesh_file import MeshFile

MAX_OFFSET = 8  # a mesh with larger coordinates, in units of its extent, is written with a translation
# Largest rounding errors without a warning, relative to the extent. For TC: half a texel of 16,384 texels.
ROUNDING_TOLERANCES = {"V": 1e-6, "TC": 0.5 / 16384}


@dataclass(frozen=True, eq=False)
class SplitVertices:
    """The distinct combinations of position, texture coordinates and normal at the corners.

    Attributes
    ----------
    vertex : (#P,) int64
        The original vertex of each split vertex.
    TC : (#P, 2) float64
    normals : (#P, 3) float64 or None
    corners : (#C,) int64
        The split vertex at each corner.
    colours : (#P, 3 or 4) float64 or None
    first : (#P, 2) float64 or None
        The first texture coordinates, if `TC` are second texture coordinates.
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
    """Split vertices such that each corner has one index for position, texture coordinates and more.

    Only the corners in `corner` are included. Normals and `colours`, the colours at all corners (#C, 3 or 4),
    are optional.
    """
    assert mesh.TC is not None and mesh.texture is not None
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
    """Split vertices such that each vertex keeps its index, and further copies follow all original vertices.

    References to vertex indices therefore remain valid. Unreferenced vertices are kept, with texture
    coordinates 0, 0.
    """
    split, n = split_vertices(mesh, normals=normals), len(mesh.V)
    used, first = np.unique(split.vertex, return_index=True)
    is_copy = np.ones(len(split.vertex), dtype=bool)
    is_copy[first] = False
    new_index = np.empty(len(split.vertex), dtype=np.int64)
    new_index[first], new_index[is_copy] = used, n + np.arange(int(is_copy.sum()))

    def order_rows(rows: FloatArray) -> FloatArray:
        table = np.zeros((n + int(is_copy.sum()), rows.shape[1]))
        table[new_index] = rows
        return table

    return SplitVertices(
        np.append(np.arange(n), split.vertex[is_copy]),
        order_rows(split.TC),
        None if split.normals is None else order_rows(split.normals),
        new_index[split.corners],
        first=None if split.first is None else order_rows(split.first),
    )


def find_unique_tuples(*indices: IntArray) -> tuple[list[IntArray], IntArray]:
    """Return the unique rows of index arrays (one array per column), and the unique row at each position."""
    key = indices[0]
    for index in indices[1:]:  # compress the keys after each index to avoid overflow
        key = key * (int(index.max(initial=0)) + 1) + index
        if index is not indices[-1]:
            _, key = np.unique(key, return_inverse=True)
    _, first, place = np.unique(key, return_index=True, return_inverse=True)
    return [index[first] for index in indices], place.ravel().astype(np.int64)


def find_face_pages(mesh: MeshFile) -> IntArray:
    """Return the page (UDIM tile) of each face, (#F,): the tile that contains the mean of its corners."""
    assert mesh.TC is not None and mesh.texture is not None
    middle = np.zeros((len(mesh.polygons), 2))
    np.add.at(middle, mesh.polygons.polygon_of_corner, mesh.TC[mesh.texture])
    column, row = np.floor(middle / mesh.polygons.sizes[:, None]).astype(np.int64).T
    return np.asarray(column + UDIM_ROW * row)


class SplitTriangles(NamedTuple):
    """Triangles with one index for position and texture coordinates.

    Attributes
    ----------
    V, TC : (#P, 3) and (#P, 2) float64
    F : (#T, 3) int64
    vertex : (#P,) int64
        The original vertex of each row of `V`.
    """

    V: FloatArray
    TC: FloatArray
    F: IntArray
    vertex: IntArray


def split_at_seams(mesh: MeshFile) -> SplitTriangles:
    """Split the mesh into triangles with one vertex for each pair of position and texture coordinates."""
    split = split_vertices(mesh)
    return SplitTriangles(
        mesh.V[split.vertex], split.TC, split.corners[mesh.triangulation.place], split.vertex
    )


def make_flat_surface(mesh: MeshFile) -> tuple[FloatArray, IntArray, IntArray | None]:
    """Return the flat map as a surface: points (u, v, 0), (n, 3); triangles; and the vertex of each point.

    If each vertex has at most one texture coordinate, vertices keep their indices, vertices without one are
    at the origin, and None is returned instead of the vertex of each point.
    """
    split = split_vertices(mesh)
    if len(np.unique(split.vertex)) == len(split.vertex):
        points = np.zeros((len(mesh.V), 3))
        points[split.vertex, :2] = split.TC
        return points, mesh.triangles, None
    return np.insert(split.TC, 2, 0.0, axis=1), split.corners[mesh.triangulation.place], split.vertex


def choose_origin(V: FloatArray) -> FloatArray:
    """Return an origin (3,) such that V - origin is accurate in single precision; 0 if V is accurate."""
    low, high = V.min(axis=0), V.max(axis=0)
    middle, extent = low / 2 + high / 2, (high - low).max()
    if not np.abs(V).max() > MAX_OFFSET * extent or not np.isfinite(extent):
        return np.zeros(3)
    return np.asarray(middle)


def warn_about_rounding(rows: FloatArray, rounded: NDArray[Any], name: str) -> None:
    """Warn if rounding has changed coordinates by more than the tolerance for this array."""
    warn_of_error(find_rounding_error(rows, rounded), name)


def find_rounding_error(rows: FloatArray, rounded: NDArray[Any]) -> float:
    """Return the largest rounding error of coordinates, relative to their extent."""
    extent = np.ptp(rows, axis=0).max() if len(rows) else 0.0
    return float(np.abs(rows - rounded).max() / extent) if extent > 0 else 0.0


def warn_of_error(error: float, name: str) -> None:
    """Warn if a relative rounding error exceeds the tolerance for this array."""
    if error > ROUNDING_TOLERANCES.get(name, ROUNDING_TOLERANCES["V"]):
        warnings.warn(
            f"{name} is rounded by up to {error:.2g} of its extent, because the format has too few "
            "digits: write OBJ, which keeps all digits, or move it to the origin and scale it to a size of 1",
            MeshWarning,
            stacklevel=stack_level(),
        )


def to_single_precision(rows: FloatArray, name: str) -> NDArray[np.float32]:
    """Convert rows to single precision, with a warning if coordinates lose digits."""
    rounded = round_to_single(rows, name)
    if name in ROUNDING_TOLERANCES:
        warn_about_rounding(rows, rounded, name)
    return rounded


def round_to_single(rows: FloatArray, name: str) -> NDArray[np.float32]:
    """Convert rows to single precision without a warning; raise a `MeshError` for too large numbers."""
    if np.abs(rows).max(initial=0) > np.finfo(np.float32).max:
        raise MeshError(f"{name} has numbers beyond 3.4e38, the largest 32-bit float: scale it or write OBJ")
    return rows.astype("<f4")
