"""Compute the connectivity of a triangle mesh: half-edges, boundary loops and components."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from .._core import (
    NEXT,
    PREV,
    boundary_loops,
    connected_labels,
    count_fans,
    edge_sums,
    find_edges,
    is_connected,
    sum_by_index,
)
from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError, first_few, format_count
from .ragged import Ragged


def label_vertex_components(F: IntArray, n: int) -> IntArray:
    """Label the component of each vertex 0 .. n - 1; an unreferenced vertex is a component by itself."""
    return connected_labels(np.concatenate((F[:, :2], F[:, ::2])), n)


def label_face_components(F: IntArray, n: int) -> IntArray:
    """Label the component of each face, numbered from 0; faces that share a vertex are connected."""
    label = label_vertex_components(F, n)[F[:, 0]]
    used = np.zeros(n, dtype=np.int64)
    used[label] = 1
    return np.asarray((np.cumsum(used) - 1)[label])


def compute_group_centres(of: IntArray, points: FloatArray) -> FloatArray:
    """Return the mean of the points (#P, dim) in each group, where `of` is the group of each point."""
    total = np.stack([sum_by_index(of, x, int(of.max()) + 1) for x in points.T], axis=1)
    return np.asarray(total / np.bincount(of)[:, None])


T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Topology:
    """The connectivity of an oriented manifold surface without unreferenced vertices.

    Arrays over corners have the shape (3, #F). Half-edge `(k, t)` is the side of triangle `t` opposite to
    its corner `k`, from corner k + 1 to corner k + 2.

    Attributes
    ----------
    n : int
        Number of vertices.
    corner : (3, #F) int64
        Vertices of the corners: `F` transposed.
    edges : (#E, 2) int64
        End vertices of each edge, in the direction of its first half-edge.
    sides : (2, #E) int64
        The two half-edges of each edge, numbered k #F + t; -1 for the missing half-edge of a boundary edge.
    loops : tuple of int64 arrays
        Boundary loops, with the mesh on their left, those with the most edges first. In a `Mesh` the first
        loop is the outer one.
    n_outer : int
        Number of outer loops, which come first in `loops`: one for each disk in a batch of disks.
    """

    n: int
    corner: IntArray
    edges: IntArray
    sides: IntArray
    loops: tuple[IntArray, ...]
    n_outer: int = 1

    @property
    def holes(self) -> tuple[IntArray, ...]:
        """The boundary loops except the outer loops."""
        return self.loops[self.n_outer :]

    @cached_property
    def outer_boundaries(self) -> tuple[IntArray, IntArray]:
        """Vertices of the outer loops, one loop after another, and the start of each loop plus the end."""
        outer = self.loops[: self.n_outer]
        return np.concatenate(outer), np.cumsum([0, *map(len, outer)])

    @property
    def characteristic(self) -> int:
        """Euler characteristic: vertices - edges + faces."""
        return self.n - len(self.edges) + len(self.corner[0])

    @property
    def genus(self) -> int:
        """Number of handles of a connected manifold: characteristic = 2 - 2 genus - loops."""
        return (2 - len(self.loops) - self.characteristic) // 2

    @property
    def is_planar(self) -> bool:
        """Return True if the surface is a single disk, with or without holes."""
        # The characteristic of an edge-connected surface is at most 2 - 2 genus - loops.
        # Vertices where several fans of faces meet only lower the characteristic.
        # Therefore a surface of characteristic 2 - loops has no handles.
        loops, n_faces = len(self.loops), len(self.corner[0])
        return loops > 0 and self.characteristic == 2 - loops and is_connected(self.sides, n_faces)

    def compute_once(self, name: str, make: Callable[[], T]) -> T:
        """Return `make()`, which depends on the connectivity only; a `CachedTopology` caches it as `name`."""
        return make()

    def sum_at_vertices(self, values: FloatArray) -> FloatArray:
        """Sum (3, #F) corner values over the corners of each vertex."""
        return sum_by_index(self.corner.ravel(), values.ravel(), self.n)

    def sum_at_edges(self, values: FloatArray) -> FloatArray:
        """Sum values of half-edges, (3, #F), over the two sides of each edge."""
        return edge_sums(values, self.sides)

    @cached_property
    def interior_edges(self) -> IntArray:
        """Indices of the interior edges, which have two faces."""
        return np.flatnonzero(self.sides[1] >= 0)

    @property
    def boundary_edges(self) -> IntArray:
        """End vertices of the boundary edges, (#B, 2); the faces are on their left."""
        return np.asarray(self.edges[self.sides[1] < 0])

    @cached_property
    def interior_edge_ends(self) -> IntArray:
        """End vertices of the interior edges, (#I, 2)."""
        return self.edges[self.interior_edges] if self.loops else self.edges

    @cached_property
    def interior_edge_sides(self) -> IntArray:
        """Half-edges of the interior edges, (2, #I)."""
        return np.ascontiguousarray(self.sides[:, self.interior_edges]) if self.loops else self.sides

    @cached_property
    def interior_edge_faces(self) -> IntArray:
        """Faces of the interior edges, (#I, 2)."""
        return np.ascontiguousarray((self.interior_edge_sides % len(self.corner[0])).T)

    @cached_property
    def is_interior(self) -> BoolArray:
        """Mask of the interior vertices, (#V,)."""
        inside = np.ones(self.n, dtype=bool)
        if self.loops:
            inside[np.concatenate(self.loops)] = False
        return inside


@dataclass(frozen=True, eq=False)
class CachedTopology(Topology):
    """A topology that is used in many calls, and caches results that depend only on the connectivity."""

    _kept: dict[str, Any] = field(init=False, default_factory=dict, repr=False)

    @classmethod
    def from_topology(cls, topology: Topology) -> CachedTopology:
        return cls(**{part.name: getattr(topology, part.name) for part in fields(Topology)})

    def compute_once(self, name: str, make: Callable[[], T]) -> T:
        if name not in self._kept:
            self._kept[name] = make()
        made: T = self._kept[name]
        return made


def build_topology(F: IntArray, vertices: IntArray) -> Topology:
    """Build the connectivity of an oriented manifold mesh with any number of pieces, loops and handles.

    Parameters
    ----------
    F : (#F, 3) int64
        Triangles that use all of the vertices `0 .. len(vertices) - 1`.
    vertices : (#V,) int64
        The caller's indices of these vertices, for error messages.

    Raises
    ------
    MeshError
        An edge has more than two faces, or two faces of opposite orientation; or two fans of faces meet
        in a boundary vertex.
    """
    made = build_sound_topology(F, vertices)
    if made is None:
        raise _make_nonmanifold_error(F, find_edges(np.ascontiguousarray(F.T), len(vertices))[0], vertices)
    return made


def build_sound_topology(F: IntArray, vertices: IntArray) -> Topology | None:
    """Build a `Topology`, or return None if an edge has more than two faces or inconsistent faces."""
    n = len(vertices)
    corner = np.ascontiguousarray(F.T)
    edges, sides, sound = find_edges(corner, n)
    if not sound:
        return None
    tail, head = edges[sides[1] < 0].T
    around, sizes, twice = boundary_loops(tail, head, n)
    if len(twice):  # two boundary edges leave a vertex
        check_fans(F, sides, vertices)
    loops = tuple(sorted(Ragged.from_sizes(sizes).split(around), key=len, reverse=True))
    return Topology(n, corner, edges, sides, loops)


def build_manifold_topology(F: IntArray, vertices: IntArray) -> Topology:
    """Build a `Topology`, and reject interior vertices where several fans of faces meet."""
    topology = build_topology(F, vertices)
    check_fans(F, topology.sides, vertices)
    return topology


def build_planar_topology(F: IntArray, vertices: IntArray) -> Topology:
    """Build the `Topology` of a mesh that must be a single disk, with or without holes.

    Raises
    ------
    MeshError
        In addition to `build_topology`: the mesh has several components, a vertex where several fans meet, no
        boundary, or handles.
    """
    topology = build_topology(F, vertices)
    check_planar(topology, vertices)
    return topology


def with_outer_loop(topology: Topology, outer: int) -> Topology:
    """Return the topology with `topology.loops[outer]` as its outer loop."""
    loops = (topology.loops[outer], *topology.loops[:outer], *topology.loops[outer + 1 :])
    return replace(topology, loops=loops)


def find_nonmanifold_edges(corner: IntArray, edges: IntArray) -> tuple[IntArray, BoolArray, BoolArray]:
    """Return the edge of each half-edge, (3 #F,), and two masks of nonmanifold edges.

    The first mask marks edges with more than two half-edges. The second mask marks edges with two half-edges
    of the same direction.
    """
    tail, head = corner[NEXT].ravel(), corner[PREV].ravel()
    n = int(corner.max()) + 1
    key, of_edge = (np.minimum(a, b) * n + np.maximum(a, b) for a, b in ((tail, head), edges.T))
    edge = np.searchsorted(of_edge, key)
    count, along = (np.bincount(edge[e], minlength=len(edges)) for e in (slice(None), tail == edges[edge, 0]))
    return edge, count > 2, (count == 2) & (along == 2)


def number_triangles(F: IntArray) -> tuple[IntArray, BoolArray]:
    """Number the distinct vertex triples of faces; also return a mask of the faces that repeat one."""
    corners = np.sort(F, axis=1).T
    order = np.lexsort((corners[2], corners[0] * (int(F.max()) + 1) + corners[1]))
    ordered = corners[:, order]
    new = np.append(True, (ordered[:, 1:] != ordered[:, :-1]).any(axis=0))
    triangle, twin = np.empty(len(F), dtype=np.int64), np.empty(len(F), dtype=bool)
    triangle[order], twin[order] = np.cumsum(new) - 1, ~new
    return triangle, twin


def _make_nonmanifold_error(F: IntArray, edges: IntArray, vertices: IntArray) -> MeshError:
    """Describe edges that have more than two faces, or two faces of opposite orientation."""
    edge, many, same_way = find_nonmanifold_edges(F.T, edges)
    crowded, turned = np.flatnonzero(many), np.flatnonzero(same_way)
    triangle, twin = number_triangles(F)
    if twin.any():
        several = np.unique(triangle[twin])
        same = np.flatnonzero(triangle == several[0])
        return MeshError(
            f"faces {first_few(same)} are the same triangle of vertices {vertices[F[same[0]]].tolist()} "
            f"({len(several)} such triangles in all): keep one of each, or let "
            "igl_linabf.clean take them apart"
        )
    if len(crowded):
        faces = np.flatnonzero(edge == crowded[0]) % len(F)
        return MeshError(
            f"edges {first_few(vertices[edges[crowded]])} have more than two faces "
            f"(the first: faces {first_few(np.sort(faces))}): separate the sheets there, as "
            "igl_linabf.clean does, or remove the extra faces"
        )
    a, b = np.sort(np.flatnonzero(edge == turned[0]) % len(F))
    return MeshError(
        f"faces {a} and {b} have opposite orientation: both run from vertex "
        f"{vertices[edges[turned[0], 0]]} to {vertices[edges[turned[0], 1]]} ({len(turned)} such edges in "
        "all): orient the faces consistently, as igl_linabf.clean does"
    )


def check_planar(topology: Topology, vertices: IntArray) -> None:
    """Raise a `MeshError` that describes the mesh unless it is a single disk, with or without holes."""
    if topology.is_planar:
        return
    loops, chi, genus, F = topology.loops, topology.characteristic, topology.genus, topology.corner.T
    label = label_vertex_components(F, topology.n)
    first = vertices[np.unique(label, return_index=True)[1]]
    if len(first) > 1:
        raise MeshError(
            f"the mesh has {len(first)} components, of {first_few(np.bincount(label[F[:, 0]]))} faces, with "
            f"vertices {first_few(first)}: "
            "use igl_linabf.unwrap, which makes charts of all of them, or flatten them one by one"
        )
    check_fans(F, topology.sides, vertices)
    if not loops:
        raise MeshError(
            f"the mesh is closed (no boundary, Euler characteristic {chi}, genus {genus}): "
            "use igl_linabf.unwrap, which makes an atlas, or cut it along "
            "igl_linabf.find_seams(V, F)"
        )
    raise MeshError(
        f"the mesh has {format_count(genus, 'handle')} (Euler characteristic {chi} with "
        f"{format_count(len(loops), 'boundary loop')}, the longest through vertex "
        f"{vertices[loops[0][0]]}): use igl_linabf.unwrap, which makes an atlas, or cut it "
        "along igl_linabf.find_seams(V, F)"
    )


def check_fans(F: IntArray, sides: IntArray, vertices: IntArray) -> None:
    """Raise a `MeshError` if the faces around a vertex form more than one edge-connected fan."""
    number = count_fans(F.T, sides, len(vertices))
    bad = np.flatnonzero(number > 1)
    if len(bad):
        raise MeshError(
            f"at vertices {first_few(vertices[bad])} several fans of faces meet in one point "
            f"(a bowtie; {number[bad[0]]} fans at the first): duplicate the vertex for each fan, "
            "as igl_linabf.clean does"
        )
