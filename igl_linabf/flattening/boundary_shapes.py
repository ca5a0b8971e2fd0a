"""Resolve the shape of the boundary of a map: free, circles, a rectangle, or prescribed angles."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..angles import compute_inscribed_sums
from ..errors import MeshError, first_few, format_count
from ..surface import Mesh, Topology, convert_vertex_indices, find_chords
from .constants import BOUNDARY_TOL

BoundaryName = Literal["free", "circle", "circles", "rectangle"]

CORNER_WINDOW = 0.02  # turning at a corner is summed over this share of the boundary on each side

SPLIT_CHORDS_HINT = "igl_linabf.surface.split_chords(V, F) splits these edges at their midpoints"


@dataclass(frozen=True, eq=False)
class Shape:
    """The prescribed shape of the boundary.

    Attributes
    ----------
    name : {"free", "circle", "circles", "rectangle", "angles"}
    sums : (#V,) float64 or None
        The prescribed angle sum of each vertex of the mesh, NaN if it is free. None for a free boundary.
    circles : tuple of int
        The boundary loops that have to lie on circles.
    corners : (4,) or (0,) int64
        Vertices at the corners of the rectangle, in the order of the loop.
    """

    name: str = "free"
    sums: FloatArray | None = None
    circles: tuple[int, ...] = ()
    corners: IntArray = field(default_factory=np.empty(0, dtype=np.int64).copy)


FREE = Shape()


def resolve_shape(mesh: Mesh, boundary: BoundaryName | ArrayLike, corners: ArrayLike | None) -> Shape:
    """Return the requested shape of the boundary of a checked mesh.

    Raises
    ------
    MeshError
        The corners are not four vertices of the outer loop, the angles are not an array with one value per
        vertex, or no flat map has such a boundary.
    """
    name = boundary if isinstance(boundary, str) else "angles"
    if name != "angles" and name not in get_args(BoundaryName):
        names = ", ".join(map(repr, get_args(BoundaryName)))
        raise ValueError(f"boundary is {name!r}: use one of {names}, or an array of angles")
    if corners is not None and name != "rectangle":
        raise ValueError(f"corners does not apply to boundary={name!r}: leave it out, or use 'rectangle'")
    if name == "free":
        return Shape()
    topology, sums = mesh.topology, np.full(mesh.topology.n, np.nan)
    rim = topology.loops[0]
    if name in ("circle", "circles"):
        circles = tuple(range(1 if name == "circle" else len(topology.loops)))
        for i in circles:
            length = np.log(_measure_edge_lengths(mesh, i))
            sums[topology.loops[i]] = compute_inscribed_sums(length - np.roll(length, 1), i > 0)
        shape = Shape(name, sums, circles)
    elif name == "rectangle":
        at = _find_corners(mesh) if corners is None else _parse_corners(mesh, corners)
        sums[rim] = np.pi
        sums[at] = np.pi / 2
        shape = Shape(name, sums, (), at)
    else:
        shape = Shape(name, _parse_angles(mesh, boundary))
    _check_shape(mesh, shape)
    return shape


def _measure_edge_lengths(mesh: Mesh, i: int) -> FloatArray:
    """Return the lengths of the edges that start at the vertices of boundary loop i."""
    at = mesh.V[mesh.topology.loops[i]]
    return np.asarray(np.linalg.norm(np.roll(at, -1, axis=0) - at, axis=1))


def _parse_angles(mesh: Mesh, boundary: ArrayLike) -> FloatArray:
    try:
        angles = np.asarray(boundary, dtype=np.float64)
    except (TypeError, ValueError):
        raise MeshError("boundary is neither a name nor an array of angles: pass (#V,) radians") from None
    if angles.shape != (mesh.n_given,):
        raise MeshError(
            f"boundary has the shape {angles.shape}: pass one angle per vertex, ({mesh.n_given},) radians, "
            "NaN where the boundary is free and at all interior vertices"
        )
    angles = angles[mesh.vertices]
    inside = np.flatnonzero(mesh.topology.is_interior & ~np.isnan(angles))
    if len(inside):
        raise MeshError(
            f"boundary has angles at vertices {first_few(mesh.vertices[inside])}, which are inside the mesh: "
            "set them to NaN; interior angles of a flat map sum to 2 pi (igl_linabf.unwrap makes cones)"
        )
    return angles


def _parse_corners(mesh: Mesh, corners: ArrayLike) -> IntArray:
    """Return the four given vertices in the order of the outer loop, from the first given vertex on."""
    at = convert_vertex_indices(corners, mesh.vertices, mesh.n_given, "corners")
    rim = mesh.topology.loops[0]
    place = np.full(mesh.topology.n, -1)
    place[rim] = np.arange(len(rim))
    inside = np.flatnonzero(place[at] < 0)
    if len(inside):
        raise MeshError(
            f"corners {first_few(mesh.vertices[at[inside]])} are not on the outer boundary loop: give four "
            "vertices of this loop"
        )
    if len(np.unique(at)) != 4 or len(at) != 4:
        raise MeshError(f"corners are {mesh.vertices[at].tolist()}: give four different vertices")
    return np.asarray(rim[(np.sort((place[at] - place[at[0]]) % len(rim)) + place[at[0]]) % len(rim)])


def _find_corners(mesh: Mesh) -> IntArray:
    """Return the four vertices of the outer loop with the largest turning.

    The first side is one of the two opposite sides that are longer in total.
    """
    rim, length = mesh.topology.loops[0], _measure_edge_lengths(mesh, 0)
    if len(rim) < 4:
        raise MeshError(f"the boundary has {len(rim)} vertices, and a rectangle has four corners: refine it")
    angle = np.arctan2(mesh.double_area, mesh.dot)
    turning = np.pi - mesh.topology.sum_at_vertices(angle)[rim]
    arc, total = np.concatenate(([0.0], np.cumsum(length)[:-1])), length.sum()
    # compute the turning in the window around each vertex from cumulative sums over three rounds of the loop
    rounds = np.concatenate((arc - total, arc, arc + total))
    before = np.concatenate(([0.0], np.cumsum(np.tile(turning, 3))))
    first = np.searchsorted(rounds, arc - CORNER_WINDOW * total, "left")
    last = np.searchsorted(rounds, arc + CORNER_WINDOW * total, "right")
    turned, chosen = before[last] - before[first], []
    open_ = np.ones(len(rim), dtype=bool)
    for left in range(4, 0, -1):
        i = int(np.argmax(np.where(open_, turned, -np.inf)))
        around = np.arange(first[i], last[i]) % len(rim)
        around = around[open_[around]]
        i = int(around[np.argmax(turning[around])])
        chosen.append(i)
        near = np.abs((arc - arc[i] + total / 2) % total - total / 2) <= CORNER_WINDOW * total
        if np.count_nonzero(open_ & ~near) < left - 1:
            near = np.arange(len(rim)) == i  # exclude only i, to leave enough vertices for further corners
        open_ &= ~near
    chosen = sorted(chosen)
    sides = np.diff(arc[chosen], append=arc[chosen[0]] + total)
    if sides[0] + sides[2] < sides[1] + sides[3]:
        chosen = chosen[1:] + chosen[:1]
    return np.asarray(rim[chosen])


def _check_shape(mesh: Mesh, shape: Shape) -> None:
    """Raise an error if no flat map of the mesh has the prescribed angle sums at the boundary."""
    assert shape.sums is not None
    topology, sums, vertices = mesh.topology, shape.sums, mesh.vertices
    faces = np.bincount(topology.corner.ravel(), minlength=topology.n)
    if len(bad := np.flatnonzero(sums <= 0)):
        raise MeshError(
            f"boundary asks for angles of {first_few(sums[bad])} rad at vertices {first_few(vertices[bad])}: "
            "an angle of a flat map is positive"
        )
    _check_gauss_bonnet(mesh, shape, faces)
    if len(bad := np.flatnonzero(sums >= np.pi * faces - BOUNDARY_TOL)):
        first = bad[0]
        raise MeshError(
            f"the angles at vertices {first_few(vertices[bad])} cannot be so large (at vertex "
            f"{vertices[first]} {sums[first]:.4f} rad, and each of its {faces[first]} faces has less than pi)"
            + (": they are ears, with one face" if (faces[bad] == 1).all() else "")
            + f"; make them corners, or split the edges opposite to them: {SPLIT_CHORDS_HINT}"
        )
    parts = list(_find_chords_without_area(topology, sums))
    if parts:
        where = [vertices[[a, b]].tolist() for a, b in parts]
        raise MeshError(
            f"the edges between boundary vertices {first_few(where)} cut off parts of the mesh that would "
            "have no area, as the boundary does not turn around them: choose other corners; "
            f"{SPLIT_CHORDS_HINT}"
        )


def _check_gauss_bonnet(mesh: Mesh, shape: Shape, faces: IntArray) -> None:
    """Check that exterior angles sum to 2 pi along the outer loop and to -2 pi along a hole.

    These sums follow from the theorem of Gauss and Bonnet.
    """
    assert shape.sums is not None
    for i, loop in enumerate(mesh.topology.loops):
        asked, m = shape.sums[loop], len(loop)
        free = np.isnan(asked)
        if free.all():
            continue
        wanted = (m + 2 if i else m - 2) * np.pi
        given, left, where = float(np.nansum(asked)), int(free.sum()), f"vertex {mesh.vertices[loop[0]]}"
        around = f"{'hole' if i else 'outer loop'} of {format_count(m, 'vertex')} through {where}"
        if not left and abs(given - wanted) > BOUNDARY_TOL:
            raise MeshError(
                f"the angles asked for at the {around} sum to {given:.6f} rad, but in a flat map to "
                f"({m} {'+' if i else '-'} 2) pi = {wanted:.6f}: add {(wanted - given) / m:+.6f} to each, or "
                "leave some angles free (NaN)"
            )
        if left and not 0 < wanted - given < np.pi * faces[loop[free]].sum():
            raise MeshError(
                f"the angles asked for at the {around} sum to {given:.6f} rad; together with the {left} free "
                f"vertices they have to sum to ({m} {'+' if i else '-'} 2) pi = {wanted:.6f}, which leaves "
                f"{wanted - given:.6f} for the free vertices: ask for other angles, or leave more free"
            )


def _find_chords_without_area(topology: Topology, sums: FloatArray) -> Iterator[tuple[int, int]]:
    """Yield the chords of the outer loop that cut off a part with a nonpositive angle at the chord."""
    rim = topology.loops[0]
    place = np.full(topology.n, -1)
    place[rim] = np.arange(len(rim))
    ends = np.sort(place[topology.edges[find_chords(topology)]], axis=1)
    ends = ends[ends[:, 0] >= 0]
    # at free vertices, assume the largest possible turning: pi
    turning = np.where(np.isnan(sums[rim]), np.pi, np.pi - sums[rim])
    before = np.concatenate(([0.0], np.cumsum(turning)))
    i, j = ends.T
    one = before[j] - before[i + 1]
    other = before[-1] - before[j + 1] + before[i]
    for a, b in rim[ends[np.minimum(one, other) <= BOUNDARY_TOL]]:
        yield int(a), int(b)
