"""What a valid input is: arrays, pins and the checked mesh that every other room works on."""

from __future__ import annotations

import operator
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .errors import MeshError, MeshWarning, some, stack_level
from .topology import NEXT, PREV, ComplexArray, FloatArray, IntArray, Topology, planar_topology, with_outer

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


def vertex_array(V: ArrayLike, columns: int = 3, name: str = "V") -> FloatArray:
    """`V` as a C-ordered (#V, columns) float64 array."""
    array = _array(V, "biuf", f"{name} is not an array of real numbers: pass #V by {columns} coordinates")
    if array.ndim != 2 or array.shape[1] != columns or len(array) == 0:
        hint = "append a column of zeros" if array.shape[1:] == (2,) else f"pass #V by {columns} coordinates"
        raise MeshError(
            f"{name} has the shape {array.shape}, not (#V, {columns}) with at least one row: {hint}"
        )
    return np.ascontiguousarray(array, dtype=np.float64)


def face_array(F: ArrayLike) -> IntArray:
    """`F` as a C-ordered (#F, 3) int64 array."""
    array = _array(F, "iuf", "F is not an array of integers: pass #F by 3 vertex indices")
    if array.ndim != 2 or array.shape[1] != 3 or len(array) == 0:
        hint = "split polygons into triangles" if array.shape[1:] == (4,) else "pass #F by 3 vertex indices"
        raise MeshError(f"F has the shape {array.shape}, not (#F, 3) with at least one triangle: {hint}")
    if array.dtype.kind == "f":
        bad = np.flatnonzero(~((array == np.round(array)) & (np.abs(array) < 2.0**53)).all(axis=1))
        if len(bad):
            raise MeshError(
                f"faces {some(bad)} hold numbers that are no vertex indices "
                f"(face {bad[0]} is {array[bad[0]].tolist()}): pass integers"
            )
    elif array.dtype == np.uint64:
        array = np.minimum(array, np.uint64(np.iinfo(np.int64).max))
    return np.ascontiguousarray(array, dtype=np.int64)


def compact(F: IntArray, n: int) -> tuple[IntArray, IntArray]:
    """Check the indices of `F`; return the vertices in use and `F` numbered by them."""
    low, high = int(F.min()), int(F.max())
    if low < 0 or high >= n:
        bad = np.flatnonzero(((F < 0) | (n <= F)).any(axis=1))
        hint = "subtract 1 (indices start at 0)" if low == 1 and high == n else "correct F or complete V"
        raise MeshError(
            f"faces {some(bad)} refer to vertices outside 0..{n - 1} "
            f"(face {bad[0]} is {F[bad[0]].tolist()}): {hint}"
        )
    twice = (F[:, 0] == F[:, 1]) | (F[:, 1] == F[:, 2]) | (F[:, 2] == F[:, 0])
    if twice.any():
        bad = np.flatnonzero(twice)
        raise MeshError(
            f"faces {some(bad)} hold a vertex twice (face {bad[0]} is {F[bad[0]].tolist()}): remove them"
        )
    used = np.zeros(n, dtype=bool)
    used[F.ravel()] = True
    vertices = np.flatnonzero(used)
    return vertices, F if len(vertices) == n else (np.cumsum(used) - 1)[F]


def check_finite(V: FloatArray, vertices: IntArray, name: str = "V") -> None:
    """Raise where a coordinate is NaN or infinite."""
    finite = np.isfinite(V)
    if not finite.all():
        bad = np.flatnonzero(~finite.all(axis=1))
        raise MeshError(
            f"the coordinates in {name} of vertices {some(vertices[bad])} are NaN or infinite "
            f"(the first: {V[bad[0]].tolist()}): repair them, or remove their faces"
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


def of_size_one(uv: FloatArray) -> FloatArray:
    """The coordinates by a power of two, which rounds none of them, so that the largest is about one.

    Squares of larger ones could overflow.
    """
    largest = float(np.abs(uv).max())
    return np.ldexp(uv, -int(np.frexp(largest)[1]))


def signed_double_areas(z: ComplexArray, corner: IntArray) -> FloatArray:
    """Twice the signed area of each face of a flat map (#V,); positive where it is not flipped."""
    a, b, c = z[corner]
    return np.asarray(((b - a).conj() * (c - a)).imag)


def flat_angles(z: ComplexArray, corner: IntArray) -> FloatArray:
    """Angles of the triangles of a flat map (#V,), (3, #F) radians; positive, flipped or not."""
    at = z[corner]
    cross = (at[NEXT] - at).conj() * (at[PREV] - at)
    return np.arctan2(np.abs(cross.imag), cross.real)


def complex_positions(uv: FloatArray) -> ComplexArray:
    """(#V, 2) coordinates as complex numbers."""
    return np.asarray(uv[:, 0] + 1j * uv[:, 1])


def coordinates(z: ComplexArray) -> FloatArray:
    """Complex positions as (#V, 2)."""
    return np.column_stack((z.real, z.imag))


def pins(
    b: ArrayLike | None, bc: ArrayLike | None, vertices: IntArray, n_given: int
) -> tuple[IntArray, FloatArray] | None:
    """Check pins as `igl.lscm` takes them, two vertices `b` and their positions `bc`.

    `vertices` are those in use among the `n_given` of the caller, in whose numbering `b` is;
    what is returned is in theirs.

    Raises
    ------
    MeshError
        There are not two pins, they are equal, out of range, of no face, or at one position.
    """
    if b is None and bc is None:
        return None
    if b is None or bc is None:
        missing = "b" if b is None else "bc"
        raise MeshError(f"{missing} is missing: give the pinned vertices b and their positions bc together")
    index = _array(b, "iu", "b is not an array of integers: pass two vertex indices")
    if index.ndim == 2 and 1 in index.shape:
        index = index.ravel()
    if index.shape != (2,):
        raise MeshError(f"b has the shape {index.shape}: pin exactly two vertices, b of shape (2,)")
    place = vertex_array(bc, 2, "bc")
    if place.shape != (2, 2):
        raise MeshError(f"bc has the shape {place.shape}: give two positions, bc of shape (2, 2)")
    listed = index.tolist()
    if min(listed) < 0 or max(listed) >= n_given:
        raise MeshError(f"pinned vertices {listed} are not all within 0..{n_given - 1}: pin two vertices")
    if listed[0] == listed[1]:
        raise MeshError(f"vertex {listed[0]} is pinned twice: pin two different vertices")
    if not np.isfinite(place).all() or (place[0] == place[1]).all():
        raise MeshError(f"pins {listed} go to {place.tolist()}: give two different finite positions")
    index = index.astype(np.int64)
    new = np.minimum(np.searchsorted(vertices, index), len(vertices) - 1)
    lost = vertices[new] != index
    if lost.any():
        raise MeshError(f"pinned vertices {some(index[lost])} belong to no face: pin vertices of the surface")
    return new, place


def scatter(uv: FloatArray, vertices: IntArray, n_given: int) -> FloatArray:
    """Coordinates of the caller's `n_given` vertices; NaN for those not among `vertices`."""
    if len(vertices) == n_given:
        return uv
    full = np.full((n_given, uv.shape[1]), np.nan)
    full[vertices] = uv
    return full


def _array(values: ArrayLike, kinds: str, message: str) -> np.ndarray:
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        raise MeshError(message) from None
    if array.dtype.kind not in kinds and array.size:
        raise MeshError(f"{message} (the dtype is {array.dtype})")
    return array
