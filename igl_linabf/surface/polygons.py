"""Faces of any number of corners, and the triangles they are made of."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError, some
from .constants import LARGEST_SEARCHED_POLYGON
from .ragged import Ragged
from .triangulation import triangulated

Kind = TypeVar("Kind", bound=np.generic)
Faces = IntArray | tuple[IntArray, ...]  # (#F, k), or one array a face where their sizes differ


@dataclass(frozen=True, eq=False)
class Polygons:
    """Polygons, corner after corner.

    Attributes
    ----------
    corners : (#C,) int64
        The vertices at the corners of all polygons.
    sizes : (#F,) int64
        How many corners each polygon has.
    """

    corners: IntArray
    sizes: IntArray

    @classmethod
    def of(cls, F: ArrayLike) -> Polygons:
        """Faces as the caller has them: an array (#F, k), or a list of lists of different lengths.

        Raises
        ------
        MeshError
            A face has less than three corners, or one that is no integer.
        """
        rows: Any
        try:
            rows = np.asarray(F)
        except ValueError:  # of different lengths
            rows = _rows_of_faces(F)
        if not isinstance(rows, list) and (rows.ndim != 2 or rows.dtype == object):
            rows = _rows_of_faces(F)
        if len(rows) == 0:
            raise MeshError("F has no faces: pass (#F, k) vertex indices, or one list of them a face")
        sizes = np.array([len(row) for row in rows], dtype=np.int64) if isinstance(rows, list) else None
        if sizes is None:
            sizes = np.full(len(rows), rows.shape[1], dtype=np.int64)
        few = np.flatnonzero(sizes < 3)
        if len(few):
            raise MeshError(f"faces {some(few)} have less than three corners: remove them")
        flat = np.concatenate(rows) if isinstance(rows, list) else rows.ravel()
        if not (flat.dtype.kind in "iuf" and _of_integers(flat)):
            bad = [i for i, row in enumerate(rows) if not _of_integers(np.asarray(row))]
            raise MeshError(f"faces {some(bad)} have entries that are no vertex indices: pass integers")
        return cls(flat.astype(np.int64), sizes)

    @classmethod
    def of_triangles(cls, F: IntArray) -> Polygons:
        return cls(F.ravel(), np.full(len(F), 3, dtype=np.int64))

    def __len__(self) -> int:
        return len(self.sizes)

    @cached_property
    def starts(self) -> IntArray:
        """Where the corners of each polygon begin, (#F,)."""
        return np.asarray(np.cumsum(self.sizes) - self.sizes)

    @cached_property
    def owner(self) -> IntArray:
        """The polygon of each corner, (#C,)."""
        return np.repeat(np.arange(len(self)), self.sizes)

    @cached_property
    def following(self) -> IntArray:
        """The next corner of the same polygon, (#C,)."""
        return Ragged.of_sizes(self.sizes).following

    @property
    def shaped(self) -> Faces:
        """The vertices of each polygon: (#F, k) if all have k corners, else a tuple of arrays."""
        return self.shape(self.corners)

    def shape(self, values: NDArray[Kind]) -> NDArray[Kind] | tuple[NDArray[Kind], ...]:
        """Values at the corners, in the shape of the faces."""
        if len(self) and (self.sizes == self.sizes[0]).all():
            return values.reshape(len(self), -1)
        return tuple(np.split(values, self.starts[1:])) if len(self) else values.reshape(0, 3)

    def texture_of(self, FTC: ArrayLike) -> Polygons:  # as everywhere
        """The rows of texture coordinates at the corners, as the caller has them.

        Raises
        ------
        MeshError
            They are malformed, or not in the shape of these polygons.
        """
        texture = Polygons.of(FTC)
        if len(texture) != len(self) or (texture.sizes != self.sizes).any():
            raise MeshError(f"FTC has {len(texture)} rows for {len(self)} faces, or others: pass F's shape")
        return texture

    def check(self, n: int) -> None:
        """Raise where a polygon names a vertex outside 0 .. n - 1."""
        bad = self.outside(n)
        if len(bad):
            first = self.corners[self.owner == bad[0]].tolist()
            raise MeshError(
                f"faces {some(bad)} refer to vertices outside 0..{n - 1} (face {bad[0]} is {first}): "
                "correct F or complete V"
            )

    def outside(self, n: int) -> IntArray:
        """The polygons that name a vertex outside 0 .. n - 1."""
        wrong = (self.corners < 0) | (self.corners >= n)
        return np.unique(self.owner[wrong]) if wrong.any() else np.zeros(0, dtype=np.int64)

    def groups(self) -> Iterator[tuple[IntArray, IntArray]]:
        """For each number of corners k: polygons, and the places of their corners, (p, k)."""
        for k in np.unique(self.sizes).tolist():
            rows = np.flatnonzero(self.sizes == k)
            yield rows, self.starts[rows, None] + np.arange(k)

    def split(self, V: FloatArray) -> Triangles:
        """The triangles of the polygons; concave ones are not turned over where that can be avoided."""
        kept = self._without_repeats()
        own = np.arange(len(self.corners)) if kept is self else np.flatnonzero(~self._repeats)
        made: list[tuple[IntArray, IntArray, BoolArray]] = []
        for rows, at in kept.groups():
            if at.shape[1] < 3:  # of no area, but each face keeps its row
                local = np.tile(np.arange(at.shape[1])[[0, -1, -1]], (len(rows), 1, 1))
            else:
                local = triangulated(V[kept.corners[at]])
            made.append(_triangles_of_group(rows, at, local))
        face, place, inner = (np.concatenate(parts) for parts in zip(*made, strict=True))
        order = np.argsort(face, kind="stable")
        done = Triangles(self, self.corners[own[place]], face, own[place], inner).rows(order)
        return done if not inner.any() else _without_double_edges(done, kept, own, V)

    def _without_repeats(self) -> Polygons:
        """Without corners at the vertex of the one before."""
        again = self._repeats
        if not again.any():
            return self
        sizes = self.sizes - np.bincount(self.owner[again], minlength=len(self))
        return Polygons(self.corners[~again], sizes)

    @cached_property
    def _repeats(self) -> BoolArray:
        """Corners at the vertex of the next one; of a polygon in one point, all but the last."""
        again = self.corners == self.corners[self.following]
        whole = np.flatnonzero(np.bincount(self.owner[again], minlength=len(self)) == self.sizes)
        again[self.starts[whole]] = False
        return np.asarray(again)

    def spread(self, values: IntArray) -> IntArray:
        """Values at the corners; where one is -1, that of the next corner, which is at the same vertex."""
        values = values.copy()
        waiting = np.flatnonzero(values < 0)
        while len(waiting):
            values[waiting] = values[self.following[waiting]]
            left = waiting[values[waiting] < 0]
            if len(left) == len(waiting):
                break
            waiting = left
        return values


@dataclass(frozen=True, eq=False)
class Triangles:
    """The triangles of polygons; those of one polygon follow each other.

    Attributes
    ----------
    polygons : Polygons
    F : (#T, 3) int64
        Vertices.
    face : (#T,) int64
        The polygon of each.
    place : (#T, 3) int64
        The corner of `polygons.corners` that each corner is.
    inner : (#T, 3) bool
        Whether the side from corner k to k + 1 is a diagonal, which no file has.
    """

    polygons: Polygons
    F: IntArray
    face: IntArray
    place: IntArray
    inner: BoolArray

    def rows(self, rows: IntArray) -> Triangles:
        """Some of them, in another order."""
        return Triangles(self.polygons, self.F[rows], self.face[rows], self.place[rows], self.inner[rows])

    def at_corners(self, values: IntArray) -> IntArray:
        """Values at the triangles' corners, (#T, 3), as values at the polygons' corners, (#C,)."""
        known = np.full(len(self.polygons.corners), -1)
        known[self.place[::-1].ravel()] = values[::-1].ravel()  # the first triangle of a polygon says
        return self.polygons.spread(known)


def _triangles_of_group(
    rows: IntArray, at: IntArray, local: IntArray
) -> tuple[IntArray, IntArray, BoolArray]:
    """Polygon, corners' places, and which sides are diagonals, of triangles (P, t, 3) over k corners."""
    k = at.shape[1]
    step = (local[..., [1, 2, 0]] - local) % k
    place = at[np.arange(len(rows))[:, None, None], local]
    inner = (step > 1).reshape(-1, 3) if k > 3 else np.zeros((local.shape[0] * local.shape[1], 3), dtype=bool)
    return np.repeat(rows, local.shape[1]), place.reshape(-1, 3), inner


def _without_double_edges(done: Triangles, kept: Polygons, own: IntArray, V: FloatArray) -> Triangles:
    """Polygons whose diagonals are edges of others, as the two faces of a card may be, get other ones."""
    n = len(V)

    def keys(i: IntArray, j: IntArray) -> IntArray:
        return np.asarray(np.minimum(i, j) * n + np.maximum(i, j))

    edges = np.unique(keys(kept.corners, kept.corners[kept.following]))
    t, k = np.nonzero(done.inner)
    diagonal, face = keys(done.F[t, k], done.F[t, (k + 1) % 3]), done.face[t]
    order = np.lexsort((face, diagonal))
    diagonal, face = diagonal[order], face[order]
    first = np.searchsorted(diagonal, diagonal)  # the polygon with the lowest number keeps its own
    late = np.unique(face[(face != face[first]) | np.isin(diagonal, edges)])
    if not len(late):
        return done
    taken = np.union1d(edges, diagonal[~np.isin(face, late)])
    parts = [done.rows(np.flatnonzero(~np.isin(done.face, late)))]
    for rows, at in kept.groups():
        chosen = np.isin(rows, late)
        rows, at = rows[chosen], at[chosen]
        if len(rows) and 3 < at.shape[1] <= LARGEST_SEARCHED_POLYGON:
            v = kept.corners[at]
            local = triangulated(V[v], np.isin(keys(v[:, :, None], v[:, None]), taken))
            owner, place, inner = _triangles_of_group(rows, at, local)
            parts.append(
                Triangles(done.polygons, done.polygons.corners[own[place]], owner, own[place], inner)
            )
        elif len(rows):
            parts.append(done.rows(np.flatnonzero(np.isin(done.face, rows))))
    names = ("F", "face", "place", "inner")
    F, owner, place, inner = (np.concatenate([getattr(part, name) for part in parts]) for name in names)
    return Triangles(done.polygons, F, owner, place, inner).rows(np.argsort(owner, kind="stable"))


def _of_integers(row: np.ndarray) -> bool:
    if row.dtype.kind == "f":
        return bool((row == np.round(row)).all())
    return row.dtype.kind in "iu" or row.size == 0


def _rows_of_faces(F: ArrayLike) -> list[np.ndarray]:
    try:
        rows = [np.asarray(row) for row in F]  # type: ignore[union-attr]
    except (TypeError, ValueError):
        raise MeshError("F is no list of faces: pass one list of vertex indices a face") from None
    bad = [i for i, row in enumerate(rows) if row.ndim != 1 or not _of_integers(row)]
    if bad:
        raise MeshError(f"faces {some(bad)} have entries that are no vertex indices: pass integers")
    return [row.astype(np.int64) for row in rows]
