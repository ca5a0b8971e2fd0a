"""Validate input arrays, and convert them to canonical dtypes and shapes."""

from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from .._core import used_vertices
from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError, first_few, format_count
from .constants import LARGEST_COORDINATE

MOST_VERTICES = 2**31  # maximum vertex count that is inferred from face indices alone

Pins = tuple[IntArray, FloatArray]  # pinned vertices (#P,) and their positions (#P, 2), #P >= 2


@np.errstate(invalid="ignore")  # NumPy warns when it casts signalling NaN
def vertex_array(V: ArrayLike, columns: int = 3, name: str = "V") -> FloatArray:
    """Return `V` as a C-ordered (#V, columns) float64 array."""
    hint = _suggest_map(V) if columns == 2 else ""
    array = _convert_array(
        V, "biuf", f"{name} is not an array of real numbers: {hint or f'pass #V by {columns} coordinates'}"
    )
    if array.ndim != 2 or array.shape[1] != columns or len(array) == 0:
        hint = "append a column of zeros" if array.shape[1:] == (2,) else f"pass #V by {columns} coordinates"
        raise MeshError(
            f"{name} has the shape {array.shape}, not (#V, {columns}) with at least one row: {hint}"
        )
    return np.ascontiguousarray(array, dtype=np.float64)


def map_array(uv: ArrayLike, n: int) -> FloatArray:
    """Return a flat map of `n` vertices as a C-ordered (#V, 2) float64 array."""
    map_ = vertex_array(uv, 2, "uv")
    if len(map_) != n:
        raise MeshError(
            f"uv has {format_count(len(map_), 'row')} for {format_count(n, 'vertex')}: pass one row a vertex"
        )
    return map_


def face_array(F: ArrayLike) -> IntArray:
    """Return `F` as a C-ordered (#F, 3) int64 array."""
    array = _convert_array(
        F, "iuf", "F is not an array of integers: pass #F by 3 vertex indices (split polygons into triangles)"
    )
    if array.ndim != 2 or array.shape[1] != 3 or len(array) == 0:
        hint = "split polygons into triangles" if array.shape[1:] == (4,) else "pass #F by 3 vertex indices"
        raise MeshError(f"F has the shape {array.shape}, not (#F, 3) with at least one triangle: {hint}")
    if array.dtype.kind == "f":
        bad = np.flatnonzero(~((array == np.round(array)) & (np.abs(array) < 2.0**53)).all(axis=1))
        if len(bad):
            raise MeshError(
                f"faces {first_few(bad)} have entries that are not vertex indices "
                f"(face {bad[0]} is {array[bad[0]].tolist()}): pass integers"
            )
    elif array.dtype == np.uint64:
        array = np.minimum(array, np.uint64(np.iinfo(np.int64).max))
    return np.ascontiguousarray(array, dtype=np.int64)


def check_indices(F: IntArray, n: int) -> None:
    """Raise a `MeshError` if `F` refers to vertices outside 0 .. n - 1."""
    low, high = int(F.min()), int(F.max())
    if low < 0 or high >= n:
        bad = np.flatnonzero(((F < 0) | (n <= F)).any(axis=1))
        hint = "subtract 1 (indices start at 0)" if low == 1 and high == n else "correct F or complete V"
        raise MeshError(
            f"faces {first_few(bad)} refer to vertices outside 0..{n - 1} "
            f"(face {bad[0]} is {F[bad[0]].tolist()}): {hint}"
        )


def count_vertices(F: IntArray) -> int:
    """Return the number of vertices that the faces imply without positions: the largest index + 1."""
    bad = np.flatnonzero((F >= MOST_VERTICES).any(axis=1))
    if len(bad):
        raise MeshError(
            f"faces {first_few(bad)} refer to vertices beyond {MOST_VERTICES - 1}, more than memory holds "
            f"(face {bad[0]} is {F[bad[0]].tolist()}): correct F"
        )
    return max(int(F.max()) + 1, 1)


def drop_unused_vertices(F: IntArray, n: int) -> tuple[IntArray, IntArray]:
    """Check the indices of `F`; return the vertices in use, and `F` renumbered to index them."""
    used, sound = used_vertices(F, n)
    if not sound:
        check_indices(F, n)
        bad = np.flatnonzero(~has_distinct_corners(F))
        raise MeshError(
            f"faces {first_few(bad)} hold a vertex twice (face {bad[0]} is {F[bad[0]].tolist()}): remove "
            "them, as igl_linabf.clean does"
        )
    vertices = np.flatnonzero(used)
    return vertices, F if len(vertices) == n else (np.cumsum(used) - 1)[F]


def has_distinct_corners(F: IntArray) -> BoolArray:
    """Return a mask of the triangles whose three vertices are distinct."""
    return np.asarray((F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0]))


def check_finite(V: FloatArray, vertices: IntArray, name: str = "V") -> None:
    """Raise a `MeshError` if a coordinate is NaN or infinite."""
    finite = np.isfinite(V)
    if not finite.all():
        bad = np.flatnonzero(~finite.all(axis=1))
        raise MeshError(
            f"the coordinates in {name} of vertices {first_few(vertices[bad])} are NaN or infinite "
            f"(the first: {V[bad[0]].tolist()}): repair them, or remove their faces"
        )


def shape_is_pinned(pinned: Pins | None) -> TypeGuard[Pins]:
    """Return True if pins constrain the shape of a map.

    A similarity transform can always satisfy two pins, but in general not three or more pins.
    """
    return pinned is not None and len(pinned[0]) > 2


def validate_pins(b: ArrayLike | None, bc: ArrayLike | None, vertices: IntArray, n_given: int) -> Pins | None:
    """Check pins in the form that `igl.lscm` takes: two or more vertices `b` and their positions `bc`.

    `vertices` are the vertices in use among the `n_given` input vertices. `b` has input indices; the returned
    indices are positions in `vertices`.

    Raises
    ------
    MeshError
        There are fewer than two pins, a pinned vertex is repeated, out of range or not part of a face, or
        all pins have the same position.
    """
    if b is None and bc is None:
        return None
    if b is None or bc is None:
        missing = "b" if b is None else "bc"
        raise MeshError(f"{missing} is missing: give the pinned vertices b and their positions bc together")
    index = _convert_array(b, "iu", "b is not an array of integers: pass the indices of two or more vertices")
    if index.ndim == 2 and 1 in index.shape:
        index = index.ravel()
    if index.ndim != 1 or len(index) < 2:
        raise MeshError(f"b has the shape {index.shape}: pin two or more vertices, b of shape (#b,)")
    place = vertex_array(bc, 2, "bc")
    if len(place) != len(index):
        raise MeshError(
            f"bc has {format_count(len(place), 'row')} for {format_count(len(index), 'pin')}: give one "
            "position each"
        )
    if index.min() < 0 or index.max() >= n_given:
        bad = index[(index < 0) | (index >= n_given)]
        raise MeshError(
            f"pinned vertices {first_few(bad)} are not within 0..{n_given - 1}: pin vertices of the surface"
        )
    found, count = np.unique(index, return_counts=True)
    if len(found) < len(index):
        raise MeshError(f"vertex {first_few(found[count > 1])} is pinned twice: pin each vertex once")
    if len(index) > 2 and np.abs(place[np.isfinite(place)]).max(initial=0) > LARGEST_COORDINATE:
        raise MeshError(
            f"bc has coordinates beyond {LARGEST_COORDINATE:g}, where lengths overflow: scale them"
        )
    if not np.isfinite(place).all() or (place == place[0]).all():
        raise MeshError(
            f"pins {first_few(index)} go to {place[:3].tolist()}: give finite positions that are not all the "
            "same"
        )
    return _find_positions(index, vertices, "pinned vertices", "pin"), place


def convert_vertex_indices(values: ArrayLike, vertices: IntArray, n_given: int, name: str) -> IntArray:
    """Check vertex indices given by the caller, and return the position of each index in `vertices`.

    Raises
    ------
    MeshError
        The indices are not a one-dimensional array of integers, are out of range, or belong to no face.
    """
    index = _convert_array(values, "iu", f"{name} is not an array of integers: give indices of vertices")
    if index.ndim != 1 or not index.size:
        raise MeshError(f"{name} has the shape {index.shape}: give a list of vertices")
    if index.min() < 0 or index.max() >= n_given:
        raise MeshError(
            f"{name} {first_few(index)} are not all within 0..{n_given - 1}: give vertices of the mesh"
        )
    return _find_positions(index, vertices, name, "give")


def _find_positions(index: np.ndarray, vertices: IntArray, name: str, do: str) -> IntArray:
    index = index.astype(np.int64)
    new = np.minimum(np.searchsorted(vertices, index), len(vertices) - 1)
    lost = vertices[new] != index
    if lost.any():
        raise MeshError(f"{name} {first_few(index[lost])} belong to no face: {do} vertices of the surface")
    return np.asarray(new)


def make_seam_mask(seams: ArrayLike, F: IntArray, n: int, *, as_marked: bool = False) -> BoolArray:
    """Check the seams, and return them as a mask of sides, (#F, 3).

    A mask that marks one side of an edge is extended to all sides of that edge, unless `as_marked` is True.
    """
    try:
        array = np.asarray(seams)
    except ValueError:
        raise MeshError("seams is not an array: pass (#E, 2) vertex indices, or a (#F, 3) mask") from None
    if array.shape == F.shape:
        if array.dtype.kind not in "biu" or not np.isin(array, (0, 1)).all():
            raise MeshError("seams has the shape (#F, 3) but is not a mask: pass booleans, or zeros and ones")
        if as_marked:
            return array.astype(bool)
        keys = _make_side_keys(F, n)  # extend the mask to all sides of each marked edge
        return np.asarray(np.isin(keys, keys[array.astype(bool)]))
    if array.size == 0:
        return np.zeros(F.shape, dtype=bool)
    if array.ndim != 2 or array.shape[1] != 2 or array.dtype.kind not in "iu":
        raise MeshError(
            f"seams has the shape {array.shape} and the dtype {array.dtype}: pass (#E, 2) integers, "
            f"the vertices of edges, or a mask of shape {F.shape}"
        )
    bad = np.flatnonzero(((array < 0) | (array >= n)).any(axis=1))
    if len(bad):
        raise MeshError(
            f"seam edges {first_few(bad)} refer to vertices outside 0..{n - 1} "
            f"(edge {bad[0]} is {array[bad[0]].tolist()}): correct them"
        )
    pairs = array.astype(np.int64)
    bad = np.flatnonzero(~np.isin(_make_edge_keys(pairs, n), _make_side_keys(F, n)))
    if len(bad):
        raise MeshError(
            f"seam edges {first_few(bad)} are not edges of the mesh (edge {bad[0]} is "
            f"{pairs[bad[0]].tolist()}): give the end vertices of edges"
        )
    return mark_sides(pairs, F, n)


def mark_sides(edges: IntArray, F: IntArray, n: int) -> BoolArray:
    """Return a mask (#F, 3) of the sides, from corner k to k + 1, that lie on the given edges (#E, 2)."""
    at_edge = np.zeros(n, dtype=bool)
    at_edge[edges] = True
    corner = at_edge[F]
    sides = corner & corner[:, [1, 2, 0]]
    face, k = np.nonzero(sides)  # compare keys only for sides whose two ends are vertices of the edges
    sides[face, k] = np.isin(
        _make_edge_keys(np.stack((F[face, k], F[face, (k + 1) % 3]), axis=1), n), _make_edge_keys(edges, n)
    )
    return np.asarray(sides)


def scatter_to_input(uv: FloatArray, vertices: IntArray, n_given: int) -> FloatArray:
    """Return coordinates for the caller's `n_given` vertices, with NaN for vertices not in `vertices`."""
    if len(vertices) == n_given:
        return uv
    full = np.full((n_given, uv.shape[1]), np.nan)
    full[vertices] = uv
    return full


def _make_side_keys(F: IntArray, n: int) -> IntArray:
    return _make_edge_keys(np.stack((F, F[:, [1, 2, 0]]), axis=-1), n)


def _make_edge_keys(ends: IntArray, n: int) -> IntArray:
    """Return one number per edge, independent of its direction; the last axis holds the two end vertices."""
    a, b = ends[..., 0], ends[..., 1]
    return np.asarray(np.minimum(a, b) * n + np.maximum(a, b))


def _convert_array(values: ArrayLike, kinds: str, message: str) -> np.ndarray:
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        raise MeshError(message) from None
    if array.dtype.kind not in kinds and array.size:
        what = f"the dtype is {array.dtype}" if array.ndim else f"the type is {type(values).__name__}"
        raise MeshError(f"{message} ({what})")
    return array


def _suggest_map(result: object) -> str:
    """Return what to pass instead of a result of `flatten` or `unwrap`; "" for other objects."""
    if hasattr(result, "uv"):
        return "pass its attribute uv"
    if hasattr(result, "TC") and hasattr(result, "origin"):
        return (
            "the figures of an atlas are atlas.quality, and its texture coordinates atlas.TC and atlas.FTC; "
            "the vertices of the cut surface are V[atlas.origin], its triangles atlas.triangles, and their "
            "map atlas.flat"
        )
    return ""
