"""The checked mesh of one disk, with or without holes."""

from __future__ import annotations

import operator
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..errors import MeshError, MeshWarning, some, stack_level
from .areas import measure
from .submesh import Submesh
from .topology import Topology, check_planar, with_outer


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
        The caller's indices of these vertices. The caller has `n_given` vertices.
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
    """Check that `(V, F)` is one disk, with or without holes, and return it as a `Mesh`.

    Parameters
    ----------
    V : (#V, 3) array of any real dtype
        Vertex positions.
    F : (#F, 3) array of any integer dtype, or of integral floats
        Oriented triangles.
    outer : int, optional
        A vertex of the outer boundary loop; by default the longest loop is the outer one.

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
    surface = Submesh.checked(V, F)
    mesh = planar_mesh(surface, outer)
    if len(surface.V) < surface.n_given:
        unused = np.setdiff1d(np.arange(surface.n_given), surface.vertices)
        warnings.warn(
            f"vertices {some(unused)} belong to no face: they are left out and their uv is NaN",
            MeshWarning,
            stacklevel=stack_level(),
        )
    return mesh


def planar_mesh(surface: Submesh, outer: int | None = None) -> Mesh:
    """`planar` of a surface whose arrays are checked."""
    V, topology = surface.V, surface.topology
    check_planar(topology, surface.vertices)
    if outer is not None:
        topology = with_outer(topology, loop_through(topology, outer, surface.vertices))
    elif len(topology.loops) > 1:
        ahead = [np.roll(loop, -1) for loop in topology.loops]
        length = [
            np.linalg.norm(V[b] - V[a], axis=1).sum() for a, b in zip(topology.loops, ahead, strict=True)
        ]
        topology = with_outer(topology, int(np.argmax(length)))
    double_area, dot = measure(V, topology.corner, surface.vertices)
    return Mesh(V, topology, double_area, dot, surface.vertices, surface.n_given)


def loop_through(topology: Topology, vertex: object, vertices: IntArray) -> int:
    """The boundary loop through one of the caller's vertices."""
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
