"""Represent polygonal faces, and triangulate them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError, first_few, format_count
from .constants import LARGEST_SEARCHED_POLYGON
from .ragged import Ragged, index_and_rank
from .triangulation import triangulate_polygons

Kind = TypeVar("Kind", bound=np.generic)
Faces = IntArray | tuple[IntArray, ...]  # (#F, k), or an array for each face if sizes differ


@dataclass(frozen=True, eq=False)
class Polygons:
    """Polygons with any numbers of corners, in one flat array.

    Attributes
    ----------
    corners : (#C,) int64
        The vertices at the corners of all polygons, one polygon after another.
    sizes : (#F,) int64
        Number of corners of each polygon.
    """

    corners: IntArray
    sizes: IntArray

    @classmethod
    def from_faces(cls, F: ArrayLike) -> Polygons:
        """Convert input faces: an array (#F, k), or a list of lists of different lengths.

        Raises
        ------
        MeshError
            A face has fewer than three corners, or an entry that is not an integer.
        """
        rows: Any
        try:
            rows = np.asarray(F)
        except ValueError:  # the rows have different lengths
            rows = _convert_rows(F)
        if not isinstance(rows, list) and (rows.ndim != 2 or rows.dtype == object):
            rows = _convert_rows(F)
        if len(rows) == 0:
            raise MeshError("F has no faces: pass (#F, k) vertex indices, or one list of indices per face")
        sizes = np.array([len(row) for row in rows], dtype=np.int64) if isinstance(rows, list) else None
        if sizes is None:
            sizes = np.full(len(rows), rows.shape[1], dtype=np.int64)
        few = np.flatnonzero(sizes < 3)
        if len(few):
            raise MeshError(f"faces {first_few(few)} have fewer than three corners: remove them")
        flat = np.concatenate(rows) if isinstance(rows, list) else rows.ravel()
        if not (flat.dtype.kind in "iuf" and _is_integral(flat)):
            bad = [i for i, row in enumerate(rows) if not _is_integral(np.asarray(row))]
            raise MeshError(f"faces {first_few(bad)} have entries that are not vertex indices: pass integers")
        return cls(flat.astype(np.int64), sizes)

    @classmethod
    def from_triangles(cls, F: IntArray) -> Polygons:
        return cls(F.ravel(), np.full(len(F), 3, dtype=np.int64))

    def __len__(self) -> int:
        return len(self.sizes)

    @cached_property
    def starts(self) -> IntArray:
        """Index of the first corner of each polygon, (#F,)."""
        return np.asarray(np.cumsum(self.sizes) - self.sizes)

    @cached_property
    def polygon_of_corner(self) -> IntArray:
        """The polygon of each corner, (#C,)."""
        return np.repeat(np.arange(len(self)), self.sizes)

    def select_corners(self, faces: IntArray) -> IntArray:
        """Return the indices of the corners of some polygons, in order."""
        row, rank = index_and_rank(self.sizes[faces])
        return np.asarray(self.starts[faces][row] + rank)

    @cached_property
    def next_corner(self) -> IntArray:
        """Index of the next corner of the same polygon, (#C,)."""
        return Ragged.from_sizes(self.sizes).next_element

    @property
    def as_faces(self) -> Faces:
        """The vertices of each polygon: (#F, k) if all have k corners, otherwise a tuple of arrays."""
        return self.reshape_like_faces(self.corners)

    def reshape_like_faces(self, values: NDArray[Kind]) -> NDArray[Kind] | tuple[NDArray[Kind], ...]:
        """Reshape values at the corners to the shape of the faces."""
        if len(self) and (self.sizes == self.sizes[0]).all():
            return values.reshape(len(self), -1)
        return tuple(np.split(values, self.starts[1:])) if len(self) else values.reshape(0, 3)

    def parse_texture_indices(self, FTC: ArrayLike) -> Polygons:
        """Convert the input `FTC`, the rows of texture coordinates at the corners of polygons.

        Raises
        ------
        MeshError
            `FTC` is malformed, or does not have the shape of these polygons.
        """
        texture = Polygons.from_faces(FTC)
        if len(texture) != len(self) or (texture.sizes != self.sizes).any():
            raise MeshError(
                f"FTC has {format_count(len(texture), 'row')} for {format_count(len(self), 'face')}, or "
                "rows of other lengths: pass F's shape"
            )
        return texture

    def check_vertices(self, n: int) -> None:
        """Raise a `MeshError` if a polygon refers to a vertex outside 0 .. n - 1."""
        bad = self.find_out_of_range(n)
        if len(bad):
            first = self.corners[self.polygon_of_corner == bad[0]].tolist()
            raise MeshError(
                f"faces {first_few(bad)} refer to vertices outside 0..{n - 1} (face {bad[0]} is {first}): "
                "correct F or complete V"
            )

    def find_out_of_range(self, n: int) -> IntArray:
        """Return the polygons that refer to a vertex outside 0 .. n - 1."""
        wrong = (self.corners < 0) | (self.corners >= n)
        return np.unique(self.polygon_of_corner[wrong]) if wrong.any() else np.zeros(0, dtype=np.int64)

    def iterate_by_size(self) -> Iterator[tuple[IntArray, IntArray]]:
        """Yield, for each number of corners k, the polygons (p,) and the indices of their corners (p, k)."""
        for k in np.unique(self.sizes).tolist():
            rows = np.flatnonzero(self.sizes == k)
            yield rows, self.starts[rows, None] + np.arange(k)

    def triangulate(self, V: FloatArray) -> Triangles:
        """Triangulate the polygons, without reversed triangles where possible."""
        kept = self._remove_repeats()
        own = np.arange(len(self.corners)) if kept is self else np.flatnonzero(~self._is_repeat)
        made: list[tuple[IntArray, IntArray, BoolArray]] = []
        for rows, at in kept.iterate_by_size():
            if at.shape[1] < 3:  # polygons without area get one degenerate triangle each
                local = np.tile(np.arange(at.shape[1])[[0, -1, -1]], (len(rows), 1, 1))
            else:
                local = triangulate_polygons(V[kept.corners[at]])
            made.append(_flatten_group(rows, at, local))
        face, place, inner = (np.concatenate(parts) for parts in zip(*made, strict=True))
        order = np.argsort(face, kind="stable")
        done = Triangles(self, self.corners[own[place]], face, own[place], inner).select_rows(order)
        return done if not inner.any() else _retriangulate_double_edges(done, kept, own, V)

    def _remove_repeats(self) -> Polygons:
        """Return the polygons without repeated corners, see `_is_repeat`."""
        again = self._is_repeat
        if not again.any():
            return self
        sizes = self.sizes - np.bincount(self.polygon_of_corner[again], minlength=len(self))
        return Polygons(self.corners[~again], sizes)

    @cached_property
    def _is_repeat(self) -> BoolArray:
        """Return a mask of the corners with the same vertex as the next corner.

        In a polygon with a single vertex, the last corner is not marked.
        """
        again = self.corners == self.corners[self.next_corner]
        whole = np.flatnonzero(np.bincount(self.polygon_of_corner[again], minlength=len(self)) == self.sizes)
        again[self.starts[whole]] = False
        return np.asarray(again)

    def fill_repeated_corners(self, values: IntArray) -> IntArray:
        """Replace values of -1 at the corners by the value of the next corner, which has the same vertex."""
        values = values.copy()
        waiting = np.flatnonzero(values < 0)
        while len(waiting):
            values[waiting] = values[self.next_corner[waiting]]
            left = waiting[values[waiting] < 0]
            if len(left) == len(waiting):
                break
            waiting = left
        return values


@dataclass(frozen=True, eq=False)
class Triangles:
    """A triangulation of polygons, in the order of the polygons.

    Attributes
    ----------
    polygons : Polygons
    F : (#T, 3) int64
        Vertices of the triangles.
    face : (#T,) int64
        The polygon that contains each triangle.
    place : (#T, 3) int64
        Index in `polygons.corners` of each corner.
    inner : (#T, 3) bool
        Whether the side from corner k to k + 1 is a diagonal of the polygon rather than one of its edges.
    """

    polygons: Polygons
    F: IntArray
    face: IntArray
    place: IntArray
    inner: BoolArray

    def select_rows(self, rows: IntArray) -> Triangles:
        """Return some triangles of the triangulation, selected by row."""
        return Triangles(self.polygons, self.F[rows], self.face[rows], self.place[rows], self.inner[rows])

    def select_polygons(self, faces: IntArray) -> Triangles:
        """Return the triangles of some polygons, ascending, as a triangulation of these polygons alone."""
        polygons, corners = self.polygons, self.polygons.select_corners(faces)
        first, end = (np.searchsorted(self.face, faces, side) for side in ("left", "right"))
        face, rank = index_and_rank(end - first)
        rows = first[face] + rank
        own = Polygons(polygons.corners[corners], polygons.sizes[faces])
        return Triangles(
            own, self.F[rows], face, np.searchsorted(corners, self.place[rows]), self.inner[rows]
        )

    def convert_to_polygon_corners(self, values: IntArray) -> IntArray:
        """Convert values at the triangles' corners, (#T, 3), to values at the polygons' corners, (#C,)."""
        known = np.full(len(self.polygons.corners), -1)
        known[self.place[::-1].ravel()] = values[::-1].ravel()  # the first triangle at a corner wins
        return self.polygons.fill_repeated_corners(known)


def _flatten_group(rows: IntArray, at: IntArray, local: IntArray) -> tuple[IntArray, IntArray, BoolArray]:
    """Return polygon, corners and mask of diagonals of each triangle, from triangles (P, t, 3) of k-gons."""
    k = at.shape[1]
    step = (local[..., [1, 2, 0]] - local) % k
    place = at[np.arange(len(rows))[:, None, None], local]
    inner = (step > 1).reshape(-1, 3) if k > 3 else np.zeros((local.shape[0] * local.shape[1], 3), dtype=bool)
    return np.repeat(rows, local.shape[1]), place.reshape(-1, 3), inner


def _retriangulate_double_edges(done: Triangles, kept: Polygons, own: IntArray, V: FloatArray) -> Triangles:
    """Triangulate again the polygons that have a diagonal which is an edge or diagonal of another polygon.

    The two sides of a flat card, for example, may share a diagonal.
    """
    n = len(V)

    def make_edge_keys(i: IntArray, j: IntArray) -> IntArray:
        return np.asarray(np.minimum(i, j) * n + np.maximum(i, j))

    edges = np.unique(make_edge_keys(kept.corners, kept.corners[kept.next_corner]))
    t, k = np.nonzero(done.inner)
    diagonal, face = make_edge_keys(done.F[t, k], done.F[t, (k + 1) % 3]), done.face[t]
    order = np.lexsort((face, diagonal))
    diagonal, face = diagonal[order], face[order]
    first = np.searchsorted(diagonal, diagonal)  # the polygon with the lowest index keeps its diagonal
    late = np.unique(face[(face != face[first]) | np.isin(diagonal, edges)])
    if not len(late):
        return done
    taken = np.union1d(edges, diagonal[~np.isin(face, late)])
    parts = [done.select_rows(np.flatnonzero(~np.isin(done.face, late)))]
    for rows, at in kept.iterate_by_size():
        chosen = np.isin(rows, late)
        rows, at = rows[chosen], at[chosen]
        if len(rows) and 3 < at.shape[1] <= LARGEST_SEARCHED_POLYGON:
            v = kept.corners[at]
            local = triangulate_polygons(V[v], np.isin(make_edge_keys(v[:, :, None], v[:, None]), taken))
            owner, place, inner = _flatten_group(rows, at, local)
            parts.append(
                Triangles(done.polygons, done.polygons.corners[own[place]], owner, own[place], inner)
            )
        elif len(rows):
            parts.append(done.select_rows(np.flatnonzero(np.isin(done.face, rows))))
    names = ("F", "face", "place", "inner")
    F, owner, place, inner = (np.concatenate([getattr(part, name) for part in parts]) for name in names)
    return Triangles(done.polygons, F, owner, place, inner).select_rows(np.argsort(owner, kind="stable"))


def _is_integral(row: np.ndarray) -> bool:
    if row.dtype.kind == "f":
        return bool((row == np.round(row)).all())
    return row.dtype.kind in "iu" or row.size == 0


def _convert_rows(F: ArrayLike) -> list[np.ndarray]:
    try:
        rows = [np.asarray(row) for row in F]  # type: ignore[union-attr]
    except (TypeError, ValueError):
        raise MeshError("F is not a list of faces: pass one list of vertex indices per face") from None
    bad = [i for i, row in enumerate(rows) if row.ndim != 1 or not _is_integral(row)]
    if bad:
        raise MeshError(f"faces {first_few(bad)} have entries that are not vertex indices: pass integers")
    return [row.astype(np.int64) for row in rows]
