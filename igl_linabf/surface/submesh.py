"""Represent a validated surface, and cut it into parts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from .._types import BoolArray, FloatArray, IntArray
from .areas import measure_faces
from .arrays import (
    check_finite,
    drop_unused_vertices,
    face_array,
    map_array,
    mark_sides,
    scatter_to_input,
    vertex_array,
)
from .topology import (
    NEXT,
    Topology,
    build_sound_topology,
    build_topology,
    check_fans,
    connected_labels,
    label_face_components,
)


@dataclass(frozen=True, eq=False)
class Submesh:
    """Some faces of the input mesh, with their own vertex numbering. Every vertex has a face.

    Attributes
    ----------
    V : (#V, 2 or 3) float64
        Positions, all finite.
    F : (#F, 3) int64
    faces : (#F,) int64
        The rows of these faces in the input F, ascending.
    vertices : (#V,) int64
        The input index of each vertex; the copies of a vertex on a cut have the same index.
    n_given : int
        Number of vertices of the input mesh.
    inner : (#F, 3) bool, optional
        Mask of the sides, from corner k to k + 1, that are diagonals of polygons. Seams avoid them.
    """

    V: FloatArray
    F: IntArray
    faces: IntArray
    vertices: IntArray
    n_given: int
    inner: BoolArray | None = None

    @classmethod
    def from_input(cls, V: ArrayLike, F: ArrayLike, columns: int = 3, name: str = "V") -> Submesh:
        """Check the arrays, indices and coordinates of a mesh in space or, if `columns` is 2, in the plane.

        Raises
        ------
        MeshError
            The arrays are malformed, an index is out of range, a face contains a vertex twice, or a
            coordinate is NaN or infinite.
        """
        return cls.from_arrays(vertex_array(V, columns, name), face_array(F), name)

    @classmethod
    def from_arrays(cls, positions: FloatArray, faces: IntArray, name: str = "V") -> Submesh:
        """Check a mesh as `from_input` does, given arrays of the right shapes and dtypes."""
        n_given = len(positions)
        vertices, faces = drop_unused_vertices(faces, n_given)
        if len(vertices) < n_given:
            positions = positions[vertices]
        check_finite(positions, vertices, name)
        return cls(positions, faces, np.arange(len(faces)), vertices, n_given)

    @classmethod
    def manifold_from_input(cls, V: ArrayLike, F: ArrayLike) -> Submesh:
        """Check a mesh as `from_input` does, and that it is an oriented manifold without degenerate faces."""
        return cls.from_input(V, F).as_manifold()

    def as_manifold(self) -> Submesh:
        """Check that the surface is an oriented manifold without degenerate faces, and return it."""
        _ = self.areas_and_products
        check_fans(self.F, self.topology.sides, self.vertices)
        return self

    def check_map(self, uv: ArrayLike) -> FloatArray:
        """Check a flat map of the input vertices, and return its rows for the vertices of this surface."""
        map_ = map_array(uv, self.n_given)[self.vertices]
        check_finite(map_, self.vertices, "uv")
        return map_

    @cached_property
    def topology(self) -> Topology:
        """The connectivity of the surface. The first access may raise the errors of `build_topology`."""
        return self.topology_or_none or build_topology(self.F, self.vertices)

    @cached_property
    def topology_or_none(self) -> Topology | None:
        """The connectivity, or None if edges are nonmanifold, without computing the error message."""
        return build_sound_topology(self.F, self.vertices)

    @cached_property
    def areas_and_products(self) -> tuple[FloatArray, FloatArray]:
        """Double areas and scalar products; the first access may raise the errors of `measure_faces`."""
        return measure_faces(self.V, np.ascontiguousarray(self.F.T), self.vertices)

    @cached_property
    def cuttable_edges(self) -> IntArray:
        """Edges along which seams may run: all interior edges except the diagonals of polygons."""
        inside = self.topology.interior_edges
        if self.inner is None:
            return inside
        inner = self.inner[:, NEXT].T.ravel()  # half-edge k of a face starts at corner k + 1
        return inside[~inner[self.topology.sides[:, inside]].all(axis=0)]

    @cached_property
    def polygon_labels(self) -> IntArray:
        """Polygon that contains each triangle, numbered from 0."""
        if self.inner is None:
            return np.arange(len(self.F))
        diagonals = np.setdiff1d(self.topology.interior_edges, self.cuttable_edges)
        return connected_labels(self.topology.sides[:, diagonals].T % len(self.F), len(self.F))

    @cached_property
    def component_of_face(self) -> IntArray:
        """Component of each face, numbered from 0."""
        return label_face_components(self.F, len(self.V))

    @cached_property
    def angle_sums(self) -> FloatArray:
        """Sum of the corner angles at each vertex, in radians."""
        return self.topology.sum_at_vertices(np.arctan2(*self.areas_and_products))

    def select_faces(self, rows: IntArray) -> Submesh:
        """Return the part of the surface with the given rows of `F`, which must be ascending."""
        used, F = drop_unused_vertices(self.F[rows], len(self.V))
        return Submesh(
            self.V[used], F, self.faces[rows], self.vertices[used], self.n_given, self._select_inner(rows)
        )

    def split_components(self) -> list[Submesh]:
        """Return the connected components, in the order of their first vertices."""
        label = self.component_of_face
        number = int(label.max()) + 1
        if number == 1:
            return [self]
        rows = np.argsort(label, kind="stable")
        of_vertex = np.empty(len(self.V), dtype=np.int64)
        of_vertex[self.F.ravel()] = np.repeat(label, 3)
        used = np.argsort(of_vertex, kind="stable")
        parts = np.arange(number + 1)
        first, start = np.searchsorted(label[rows], parts), np.searchsorted(of_vertex[used], parts)
        own = np.empty(len(self.V), dtype=np.int64)
        own[used] = np.arange(len(used)) - start[of_vertex[used]]
        V, F, faces, vertices = self.V[used], own[self.F[rows]], self.faces[rows], self.vertices[used]
        inner = self._select_inner(rows)
        at = [
            (slice(*f), slice(*v))
            for f, v in zip(pairwise(first.tolist()), pairwise(start.tolist()), strict=True)
        ]
        return [
            Submesh(V[v], F[f], faces[f], vertices[v], self.n_given, None if inner is None else inner[f])
            for f, v in at
        ]

    def cut(self, seams: BoolArray) -> list[Submesh]:
        """Cut along a mask (#F, 3) of the sides from corner k to k + 1, and return the components."""
        if not seams.any():
            return self.split_components()
        F, origin = cut_faces(self.F, len(self.V), self.topology.sides, seams)
        made = Submesh(self.V[origin], F, self.faces, self.vertices[origin], self.n_given, self.inner)
        return made.split_components()

    def cut_between_labels(self, label: IntArray | BoolArray) -> list[Submesh]:
        """Cut between faces with different labels, but never through a polygon, and return the components."""
        return self.cut(self.mask_sides_between(label))

    def mask_sides_between(self, label: IntArray | BoolArray) -> BoolArray:
        """Return a mask (#F, 3) of the sides from corner k to k + 1 that separate different labels."""
        inside = self.cuttable_edges
        right, left = label[self.topology.sides[:, inside] % len(self.F)]
        return self._mask_sides_of_edges(inside[right != left])

    def _select_inner(self, rows: IntArray) -> BoolArray | None:
        return None if self.inner is None else self.inner[rows]

    def cut_along(self, edges: IntArray) -> list[Submesh]:
        """Cut along edges (#E, 2), given as pairs of input vertices, and return the components."""
        return self.cut(mark_sides(edges, self.vertices[self.F], self.n_given))

    def cut_at_edges(self, rows: IntArray) -> list[Submesh]:
        """Cut along the given rows of `topology.edges`, and return the components."""
        return self.cut(self._mask_sides_of_edges(rows))

    def _mask_sides_of_edges(self, rows: IntArray) -> BoolArray:
        corner, face = np.divmod(self.topology.sides[:, rows], len(self.F))
        sides = np.zeros(self.F.shape, dtype=bool)
        sides[face, np.array(NEXT)[corner]] = True  # half-edge k of a face starts at corner k + 1
        return sides

    def scatter_to_input(self, values: FloatArray) -> FloatArray:
        """Return values for all input vertices, with NaN for vertices that are not in this surface."""
        return scatter_to_input(values, self.vertices, self.n_given)


def cut_faces(F: IntArray, n: int, sides: IntArray, seams: BoolArray) -> tuple[IntArray, IntArray]:
    """Duplicate the vertices 0 .. n - 1 along the marked sides; return the new faces and vertex origins.

    `sides` are the half-edges of each edge, see `Topology`. The numbering of vertices equals that of
    `igl.cut_mesh`, which takes at least a millisecond for any mesh. Each fan of faces around a vertex becomes
    a copy of the vertex. The original index goes to the fan that does not begin at a marked side, or to the
    last fan if all fans begin at marked sides.
    """
    m, flat = len(F), F.ravel()
    begins = np.flatnonzero(seams)  # the first corner of each fan
    at_seam = np.zeros(n, dtype=bool)
    at_seam[flat[begins]] = True
    near = at_seam[F.T[list(NEXT)]].ravel()  # half-edges that start at a seam vertex
    near = (sides[1] >= 0) & (near[sides[0]] | near[sides[1]])
    # half-edge (k, t) is side k + 1 of triangle t; its ends are the corners k + 1 and k + 2
    (k, opposite), (t, across) = np.divmod(sides[:, near], m)
    start, end = 3 * t + (k + 1) % 3, 3 * t + (k + 2) % 3
    inside = ~(seams.ravel()[start] | seams[across, (opposite + 1) % 3])
    corners = np.flatnonzero(at_seam[flat])
    place = np.empty(3 * m, dtype=np.int64)
    place[corners] = np.arange(len(corners))
    # pairs of corners that meet at an end of an edge, in the two faces of the edge
    pairs = np.column_stack((np.append(start, end), 3 * np.tile(across, 2)))
    pairs[:, 1] += np.append(opposite + 2, opposite + 1) % 3
    pairs = pairs[np.tile(inside, 2) & at_seam[flat[pairs[:, 0]]]]
    fan = connected_labels(place[pairs], len(corners))
    own = np.empty(int(fan.max(initial=-1)) + 1, dtype=np.int64)  # new vertex of each fan
    own[fan] = flat[corners]
    kept = np.ones(len(own), dtype=bool)
    kept[fan[place[begins]]] = False
    has_kept = np.zeros(n, dtype=bool)
    has_kept[own[kept]] = True
    last = np.empty(n, dtype=np.int64)
    last[flat[begins]] = begins  # for repeated vertices, the last assignment wins
    begins = begins[has_kept[flat[begins]] | (last[flat[begins]] != begins)]
    own[fan[place[begins]]] = n + np.arange(len(begins))
    cut = flat.copy()
    cut[corners] = own[fan]
    return cut.reshape(F.shape), np.append(np.arange(n), flat[begins])
