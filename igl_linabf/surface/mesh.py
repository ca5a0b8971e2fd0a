"""The validated mesh of a single disk, with or without holes."""

from __future__ import annotations

import operator
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..errors import MeshError, MeshWarning, first_few, stack_level
from .areas import measure_faces
from .arrays import (
    check_finite,
    check_indices,
    count_vertices,
    drop_unused_vertices,
    face_array,
    vertex_array,
)
from .outer_loop import find_outer_loop
from .submesh import Submesh
from .topology import CachedTopology, Topology, build_planar_topology, check_planar, with_outer_loop


@dataclass(frozen=True, eq=False)
class Mesh:
    """A validated mesh without unreferenced vertices.

    Attributes
    ----------
    V : (#V, 3) float64
    topology : Topology
    double_area : (#F,) float64
        Twice the area of each face; none is zero.
    dot : (3, #F) float64
        Scalar product of the two sides that meet at each corner;
        `dot / double_area` is the cotangent of its angle.
    vertices : (#V,) int64
        The caller's indices of these vertices.
    n_given : int
        Number of vertices of the caller's mesh.
    """

    V: FloatArray
    topology: Topology
    double_area: FloatArray
    dot: FloatArray
    vertices: IntArray
    n_given: int

    @property
    def faces(self) -> IntArray:
        """The triangles in igl's layout, (#F, 3)."""
        return np.ascontiguousarray(self.topology.corner.T)

    @property
    def area(self) -> float:
        return float(self.double_area.sum()) / 2


def planar_mesh(V: ArrayLike, F: ArrayLike, outer: int | None = None) -> Mesh:
    """Check that `(V, F)` is a single disk, with or without holes, and return it as a `Mesh`.

    Parameters
    ----------
    V : (#V, 3) array of any real dtype
        Vertex positions.
    F : (#F, 3) array of any integer dtype, or of integral floats
        Oriented triangles.
    outer : int, optional
        A vertex of the outer boundary loop; by default the loop around all other loops.

    Raises
    ------
    MeshError
        The arrays are malformed, a face is degenerate, the surface is not a connected oriented manifold
        with a boundary and without handles, or `outer` is not on a boundary loop.

    Warns
    -----
    MeshWarning
        Some vertices belong to no face and are left out.
    """
    surface = Submesh.from_input(V, F)
    mesh = build_planar_mesh(surface, outer)
    _warn_about_unused_vertices(mesh)
    return mesh


def _warn_about_unused_vertices(mesh: Mesh) -> None:
    if len(mesh.vertices) < mesh.n_given:
        unused = np.setdiff1d(np.arange(mesh.n_given), mesh.vertices)
        warnings.warn(
            f"vertices {first_few(unused)} belong to no face: they are left out and their uv is NaN",
            MeshWarning,
            stacklevel=stack_level(),
        )


def build_planar_mesh(surface: Submesh, outer: int | None = None) -> Mesh:
    """Return the `planar_mesh` of a surface whose arrays have been checked."""
    check_planar(surface.topology, surface.vertices)
    return _build_mesh(surface.V, surface.topology, surface.vertices, surface.n_given, outer)


def _build_mesh(
    V: FloatArray, topology: Topology, vertices: IntArray, n_given: int, outer: int | None
) -> Mesh:
    """Build a mesh whose outer loop comes first."""
    double_area, dot = measure_faces(V, topology.corner, vertices)
    if outer is not None:
        first = find_loop_of_vertex(topology, outer, vertices)
    else:
        first = find_outer_loop(V, topology, double_area, dot)
    if first:
        topology = topology.compute_once(f"outer {first}", lambda: with_outer_loop(topology, first))
    return Mesh(V, topology, double_area, dot, vertices, n_given)


@dataclass(frozen=True, eq=False)
class PlanarFaces:
    """The faces of a single disk, with or without holes, without vertex positions.

    Attributes
    ----------
    F : (#F, 3) int64
        Triangles in the caller's indices.
    topology : KeptTopology
    vertices : (#V,) int64
        The caller's indices of the vertices.
    """

    F: IntArray
    topology: CachedTopology
    vertices: IntArray

    @classmethod
    def from_faces(cls, F: ArrayLike) -> PlanarFaces:
        """Check the triangles, with the errors of `planar_mesh` that concern faces."""
        faces = face_array(F)
        vertices, numbered = drop_unused_vertices(faces, count_vertices(faces))
        return cls(faces, CachedTopology.from_topology(build_planar_topology(numbered, vertices)), vertices)

    def with_positions(self, V: ArrayLike, outer: int | None = None) -> Mesh:
        """Return the mesh with the given vertex positions, after the checks of `planar_mesh`."""
        positions = vertex_array(V)
        n_given = len(positions)
        if n_given <= self.vertices[-1]:
            check_indices(self.F, n_given)
        if len(self.vertices) < n_given:
            positions = positions[self.vertices]
        check_finite(positions, self.vertices)
        mesh = _build_mesh(positions, self.topology, self.vertices, n_given, outer)
        _warn_about_unused_vertices(mesh)
        return mesh


def find_loop_of_vertex(topology: Topology, vertex: object, vertices: IntArray) -> int:
    """Return the index of the boundary loop through `vertex`, one of the caller's indices."""
    try:
        index = operator.index(vertex)  # type: ignore[arg-type]
    except TypeError:
        raise MeshError(f"outer is {vertex!r}: give one vertex index of the outer boundary loop") from None
    for i, loop in enumerate(topology.loops):
        if (vertices[loop] == index).any():
            return i
    firsts = [int(vertices[loop[0]]) for loop in topology.loops]
    raise MeshError(
        f"outer is vertex {index}, which is on no boundary loop: give a vertex of one of the "
        f"{len(firsts)} loops, which go through vertices {first_few(firsts)}"
    )
