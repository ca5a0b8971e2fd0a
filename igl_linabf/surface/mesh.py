"""What a valid input is: arrays, pins and the checked mesh that every other room works on."""

from __future__ import annotations

import operator
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError, MeshWarning, some, stack_level
from .arrays import check_finite, compact, face_array, vertex_array
from .topology import NEXT, PREV, FloatArray, IntArray, Topology, planar_topology, with_outer

SMALLEST, LARGEST = 1e-60, 1e60  # of a mesh's largest coordinate


@dataclass(frozen=True, eq=False)
class Mesh:
    """A checked mesh without unreferenced vertices.

    Attributes
    ----------
    V : (#V, 3) float64
    topology : Topology
    double_area : (#F,) float64
        Twice the area of each face; none is zero.
    dot : (3, #F) float64
        Scalar product of the two sides that meet at each corner, so that
        `dot / double_area` is the cotangent of its angle.
    vertices : (#V,) int64
        The caller's indices of these vertices, of which there are `n_given`.
    """

    V: FloatArray
    topology: Topology
    double_area: FloatArray
    dot: FloatArray
    vertices: IntArray
    n_given: int

    @property
    def faces(self) -> IntArray:
        """The triangles as igl takes them, (#F, 3)."""
        return np.ascontiguousarray(self.topology.corner.T)

    @property
    def area(self) -> float:
        return float(self.double_area.sum()) / 2


def planar(V: ArrayLike, F: ArrayLike, outer: int | None = None) -> Mesh:
    """Check that `(V, F)` is one disk, or one with holes, and gather what the other rooms need of it.

    Parameters
    ----------
    V : (#V, 3) array of any real dtype
        Vertex positions.
    F : (#F, 3) array of any integer dtype, or of integral floats
        Oriented triangles.
    outer : int, optional
        A vertex of the boundary loop that is the outer one; by default that is the longest.

    Raises
    ------
    MeshError
        The arrays are malformed, a face is degenerate, the surface is not one oriented manifold
        piece with a boundary and without handles, or `outer` is not on a boundary loop.

    Warns
    -----
    MeshWarning
        Some vertices belong to no face: they are left out.
    """
    positions, faces = vertex_array(V), face_array(F)
    n_given = len(positions)
    vertices, faces = compact(faces, n_given)
    if len(vertices) < n_given:
        positions = positions[vertices]
    check_finite(positions, vertices)
    topology = planar_topology(faces, vertices)
    if outer is not None:
        topology = with_outer(topology, loop_through(topology, outer, vertices))
    elif len(topology.loops) > 1:
        ahead = [np.roll(loop, -1) for loop in topology.loops]
        length = [
            np.linalg.norm(positions[b] - positions[a], axis=1).sum()
            for a, b in zip(topology.loops, ahead, strict=True)
        ]
        topology = with_outer(topology, int(np.argmax(length)))
    double_area, dot = measure(positions, topology.corner, vertices)
    if len(vertices) < n_given:
        unused = np.setdiff1d(np.arange(n_given), vertices)
        warnings.warn(
            f"vertices {some(unused)} belong to no face: they are left out and their uv is NaN",
            MeshWarning,
            stacklevel=stack_level(),
        )
    return Mesh(positions, topology, double_area, dot, vertices, n_given)


def loop_through(topology: Topology, vertex: object, vertices: IntArray) -> int:
    """The boundary loop that goes through a vertex of the caller's."""
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
        f"{len(firsts)} loops, which go through vertices {some(firsts)}"
    )


def measure(V: FloatArray, corner: IntArray, vertices: IntArray) -> tuple[FloatArray, FloatArray]:
    """Twice the area of each face and the scalar products of the sides at its corners.

    Raises
    ------
    MeshError
        A face is so thin that the rounding of its coordinates could have made its area, or the
        numbers are so large or small that the fourth powers of lengths leave double precision.
    """
    largest = np.abs(V).max(axis=1)
    if not SMALLEST < largest.max() < LARGEST:
        i = int(np.argmax(largest))
        raise MeshError(
            f"the largest coordinate, of vertex {vertices[i]}, is {largest[i]:.1e}, beyond the range of "
            f"{SMALLEST:g} to {LARGEST:g} in which areas can be computed: scale the mesh"
        )
    x, y, z = (axis[corner] for axis in np.ascontiguousarray(V.T))
    # side k is opposite to corner k
    ux, uy, uz = (c[PREV] - c[NEXT] for c in (x, y, z))
    dot = -(ux[NEXT] * ux[PREV] + uy[NEXT] * uy[PREV] + uz[NEXT] * uz[PREV])
    double_area = np.sqrt(
        (uy[0] * uz[1] - uz[0] * uy[1]) ** 2
        + (uz[0] * ux[1] - ux[0] * uz[1]) ** 2
        + (ux[0] * uy[1] - uy[0] * ux[1]) ** 2
    )
    longest = np.sqrt((ux**2 + uy**2 + uz**2).max(axis=0))
    extent = np.maximum(longest, np.maximum(np.abs(x), np.maximum(np.abs(y), np.abs(z))).max(axis=0))
    # a coordinate x is known to eps |x|; that times the longest side is an area out of nothing
    bad = np.flatnonzero(~(double_area > 4 * np.finfo(float).eps * extent * longest))
    if len(bad):
        raise MeshError(
            f"faces {some(bad)} have zero area (face {bad[0]} has vertices "
            f"{vertices[corner[:, bad[0]]].tolist()}): "
            "collapse or remove them, or move their vertices apart"
        )
    return double_area, dot
