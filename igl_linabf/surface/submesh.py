"""A checked surface, and the parts into which cuts divide it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from .._types import BoolArray, FloatArray, IntArray
from .areas import measure
from .arrays import check_finite, compact, face_array, map_array, scatter, sides_along, vertex_array
from .topology import (
    NEXT,
    Topology,
    check_fans,
    connected_labels,
    face_components,
    sound_topology,
    topology_of,
)


@dataclass(frozen=True, eq=False)
class Submesh:
    """Some faces of the caller's mesh, with vertices numbered from 0; every vertex has a face.

    Attributes
    ----------
    V : (#V, 2 or 3) float64
        Positions, all finite.
    F : (#F, 3) int64
    faces : (#F,) int64
        The rows of these faces in the caller's F, ascending.
    vertices : (#V,) int64
        The caller's index of each vertex; the two copies of a vertex on a cut have the same.
    n_given : int
        Number of the caller's vertices.
    inner : (#F, 3) bool, optional
        Sides, from corner k to k + 1, that are diagonals of polygons: no seam runs along them.
    """

    V: FloatArray
    F: IntArray
    faces: IntArray
    vertices: IntArray
    n_given: int
    inner: BoolArray | None = None

    @classmethod
    def checked(cls, V: ArrayLike, F: ArrayLike, columns: int = 3, name: str = "V") -> Submesh:
        """Check arrays, indices and coordinates of a caller's mesh, in space or, with 2 columns, flat.

        Raises
        ------
        MeshError
            The arrays are malformed, an index is out of range, a face has a vertex twice, or a
            coordinate is NaN or infinite.
        """
        return cls.of_arrays(vertex_array(V, columns, name), face_array(F), name)

    @classmethod
    def of_arrays(cls, positions: FloatArray, faces: IntArray, name: str = "V") -> Submesh:
        """As `checked`, of arrays in their form."""
        n_given = len(positions)
        vertices, faces = compact(faces, n_given)
        if len(vertices) < n_given:
            positions = positions[vertices]
        check_finite(positions, vertices, name)
        return cls(positions, faces, np.arange(len(faces)), vertices, n_given)

    @classmethod
    def checked_manifold(cls, V: ArrayLike, F: ArrayLike) -> Submesh:
        """As `checked`, and: an oriented manifold, of which each face has an area."""
        return cls.checked(V, F).as_manifold()

    def as_manifold(self) -> Submesh:
        """The same, checked to be an oriented manifold, of which each face has an area."""
        _ = self.measured
        check_fans(self.F, self.topology.sides, self.vertices)
        return self

    def checked_map(self, uv: ArrayLike) -> FloatArray:
        """Check a flat map of the caller's vertices; return the rows of these vertices."""
        map_ = map_array(uv, self.n_given)[self.vertices]
        check_finite(map_, self.vertices, "uv")
        return map_

    @cached_property
    def topology(self) -> Topology:
        """Connectivity, on first use; raises as `topology_of`."""
        return self.sound_topology or topology_of(self.F, self.vertices)

    @cached_property
    def sound_topology(self) -> Topology | None:
        """The same; None where it raises for what is wrong at edges, which takes long to tell."""
        return sound_topology(self.F, self.vertices)

    @cached_property
    def measured(self) -> tuple[FloatArray, FloatArray]:
        """Areas and scalar products, on first use; raises as `measure`."""
        return measure(self.V, np.ascontiguousarray(self.F.T), self.vertices)

    @cached_property
    def cuttable_edges(self) -> IntArray:
        """The edges with two faces that seams may take: all but the diagonals of polygons."""
        inside = self.topology.inside
        if self.inner is None:
            return inside
        inner = self.inner[:, NEXT].T.ravel()  # half-edge (k, t) is the side k + 1 of t
        return inside[~inner[self.topology.sides[:, inside]].all(axis=0)]

    @cached_property
    def polygon_labels(self) -> IntArray:
        """The polygon of each triangle, numbered from 0."""
        if self.inner is None:
            return np.arange(len(self.F))
        diagonals = np.setdiff1d(self.topology.inside, self.cuttable_edges)
        return connected_labels(self.topology.sides[:, diagonals].T % len(self.F), len(self.F))

    @cached_property
    def label(self) -> IntArray:
        """The component of each face, numbered from 0."""
        return face_components(self.F, len(self.V))

    @cached_property
    def angle_sums(self) -> FloatArray:
        """At each vertex, radians."""
        return self.topology.sum_at_vertices(np.arctan2(*self.measured))

    def of_faces(self, rows: IntArray) -> Submesh:
        """The part made of these rows of `F`, which are ascending."""
        used, F = compact(self.F[rows], len(self.V))
        return Submesh(
            self.V[used], F, self.faces[rows], self.vertices[used], self.n_given, self._inner(rows)
        )

    def components(self) -> list[Submesh]:
        """The components, in the order of their first vertices."""
        label = self.label
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
        inner = self._inner(rows)
        at = [
            (slice(*f), slice(*v))
            for f, v in zip(pairwise(first.tolist()), pairwise(start.tolist()), strict=True)
        ]
        return [
            Submesh(V[v], F[f], faces[f], vertices[v], self.n_given, None if inner is None else inner[f])
            for f, v in at
        ]

    def cut(self, seams: BoolArray) -> list[Submesh]:
        """The components after a cut along the marked sides k to k + 1 of the faces, (#F, 3)."""
        if not seams.any():
            return self.components()
        F, origin = cut_faces(self.F, len(self.V), self.topology.sides, seams)
        made = Submesh(self.V[origin], F, self.faces, self.vertices[origin], self.n_given, self.inner)
        return made.components()

    def divided(self, label: IntArray | BoolArray) -> list[Submesh]:
        """The components after a cut between faces of different labels; none goes through a polygon."""
        return self.cut(self.sides_between(label))

    def sides_between(self, label: IntArray | BoolArray) -> BoolArray:
        """The sides k to k + 1 of the faces, (#F, 3), beyond which is a face of another label."""
        inside = self.cuttable_edges
        right, left = label[self.topology.sides[:, inside] % len(self.F)]
        return self._sides_of(inside[right != left])

    def _inner(self, rows: IntArray) -> BoolArray | None:
        return None if self.inner is None else self.inner[rows]

    def cut_along(self, edges: IntArray) -> list[Submesh]:
        """The components after a cut along edges, (#E, 2) of the caller's vertices."""
        return self.cut(sides_along(edges, self.vertices[self.F], self.n_given))

    def cut_at(self, rows: IntArray) -> list[Submesh]:
        """The components after a cut along these rows of the topology's edges."""
        return self.cut(self._sides_of(rows))

    def _sides_of(self, rows: IntArray) -> BoolArray:
        corner, face = np.divmod(self.topology.sides[:, rows], len(self.F))
        sides = np.zeros(self.F.shape, dtype=bool)
        sides[face, np.array(NEXT)[corner]] = True  # half-edge (k, t) is the side k + 1 of t
        return sides

    def scatter(self, values: FloatArray) -> FloatArray:
        """Values of these vertices as rows for the caller's vertices; NaN for the others."""
        return scatter(values, self.vertices, self.n_given)


def cut_faces(F: IntArray, n: int, sides: IntArray, seams: BoolArray) -> tuple[IntArray, IntArray]:
    """`F` with the vertices 0 .. n - 1 duplicated along the marked sides, and each vertex's original.

    `sides` are those of its edges, as in `Topology`. Vertices are numbered as by `igl.cut_mesh`, which takes
    a millisecond for any mesh: of the fans around a vertex, one without a marked side at its beginning keeps
    it, or else the last one.
    """
    m, flat = len(F), F.ravel()
    begins = np.flatnonzero(seams)  # the corners at which fans begin
    at_seam = np.zeros(n, dtype=bool)
    at_seam[flat[begins]] = True
    near = at_seam[F.T[list(NEXT)]].ravel()  # half-edges, by where they start
    near = (sides[1] >= 0) & (near[sides[0]] | near[sides[1]])
    # half-edge (k, t) is the side k + 1 of t: its ends are at the corners k + 1 and k + 2
    (k, opposite), (t, across) = np.divmod(sides[:, near], m)
    start, end = 3 * t + (k + 1) % 3, 3 * t + (k + 2) % 3
    inside = ~(seams.ravel()[start] | seams[across, (opposite + 1) % 3])
    corners = np.flatnonzero(at_seam[flat])
    place = np.empty(3 * m, dtype=np.int64)
    place[corners] = np.arange(len(corners))
    # the two corners of the other side that meet these ends
    pairs = np.column_stack((np.append(start, end), 3 * np.tile(across, 2)))
    pairs[:, 1] += np.append(opposite + 2, opposite + 1) % 3
    pairs = pairs[np.tile(inside, 2) & at_seam[flat[pairs[:, 0]]]]
    fan = connected_labels(place[pairs], len(corners))
    own = np.empty(int(fan.max(initial=-1)) + 1, dtype=np.int64)  # the vertex of each fan
    own[fan] = flat[corners]
    kept = np.ones(len(own), dtype=bool)
    kept[fan[place[begins]]] = False
    has_kept = np.zeros(n, dtype=bool)
    has_kept[own[kept]] = True
    last = np.empty(n, dtype=np.int64)
    last[flat[begins]] = begins  # the last one stays there
    begins = begins[has_kept[flat[begins]] | (last[flat[begins]] != begins)]
    own[fan[place[begins]]] = n + np.arange(len(begins))
    cut = flat.copy()
    cut[corners] = own[fan]
    return cut.reshape(F.shape), np.append(np.arange(n), flat[begins])
