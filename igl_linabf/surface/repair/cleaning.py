"""Any array of triangles as a clean surface: an oriented manifold, of which each face has an area."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ..._core import sum_by
from ..._types import BoolArray, FloatArray, IntArray
from ...errors import LISTED, MeshError, is_number, some
from ..areas import without_area
from ..arrays import check_finite, check_indices, distinct_corners, face_array, vertex_array
from ..constants import SMALLEST_COORDINATE
from ..submesh import Submesh
from ..topology import connected_labels, face_components
from .constants import (
    FLATNESS,
    LARGEST_USUAL_COORDINATE,
    LARGEST_WELDED_COORDINATE,
    SMALLEST_USUAL_COORDINATE,
)
from .sheets import Sheets, separate_sheets
from .slivers import collapse_short_sides, open_caps


def is_soup(V: FloatArray, F: IntArray, label: IntArray) -> bool:
    """Whether most faces are in loose pieces: triangles, quadrangles, or flat sides of a body.

    `label` is the component of each face.
    """
    size = np.bincount(label)
    loose = size <= 2  # a triangle, or the two of a quadrangle
    if len(size) >= 4 and not loose.all():  # no body has fewer sides
        a, b, c = V[F.T]
        with np.errstate(over="ignore", invalid="ignore"):
            normal = np.cross(b - a, c - a)
            first = np.unique(label, return_index=True)[1]  # faces may run either way around
            along = np.sign((normal * normal[first[label]]).sum(axis=1))
            total = np.stack([sum_by(label, along * x, len(size)) for x in normal.T])
            area = sum_by(label, np.linalg.norm(normal, axis=1), len(size))
            loose |= np.linalg.norm(total, axis=0) >= (1 - FLATNESS) * area
    return 2 * int(loose[label].sum()) > len(F)


def merge_coincident(V: FloatArray, used: IntArray) -> IntArray:
    """For each vertex the first of the `used` ones in the same place, to the bit."""
    points = V[used]
    order = np.lexsort(points.T)
    new = np.append(True, (points[order[1:]] != points[order[:-1]]).any(axis=1))
    first = np.minimum.reduceat(order, np.flatnonzero(new))
    merged = np.arange(len(V))
    merged[used[order]] = used[first[np.cumsum(new) - 1]]
    return merged


def merge_within(V: FloatArray, used: IntArray, distance: float) -> IntArray:
    """For each vertex the first of those that a chain of steps of at most `distance` leads to.

    Raises
    ------
    ValueError
        `distance` is negative or not finite.
    """
    if not is_number(distance, 0, np.finfo(float).max):
        raise ValueError(f"weld is {distance!r}: give a distance from 0 on, in the units of V")
    if distance == 0:
        return merge_coincident(V, used)
    points = V[used]
    size = float(np.abs(points).max(initial=0))
    if size > LARGEST_WELDED_COORDINATE:
        raise MeshError(f"vertices have coordinates of {size:.1e}: scale the mesh to weld it")
    pairs = scipy.spatial.cKDTree(points).query_pairs(distance, output_type="ndarray")
    label = connected_labels(pairs, len(used))
    merged = np.arange(len(V))
    merged[used] = used[np.unique(label, return_index=True)[1]][label]
    return merged


@dataclass(frozen=True, eq=False)
class Repair:
    """One kind of repair, and where it was done.

    Attributes
    ----------
    kind : str
        "scaled", "tiny", "welded", "collapsed", "crowded", "twin", "turned", "torn", "bowtie", "arealess"
        or "opened".
    count : int
    of : str
        What is counted: "vertices", "edges" or "faces".
    first : (at most 5,) or (at most 5, 2) int64
        The first of them, as the caller numbers them; edges by their two vertices.
    """

    kind: str
    count: int
    of: str
    first: IntArray

    def __str__(self) -> str:
        more = f", ... ({self.count:,} in all)" if self.count > len(self.first) else ""
        return f"{self.of} {some(self.first)}{more} {SAID[self.kind]}"


SAID = {
    "scaled": "were beyond the range of coordinates: all are scaled by a power of two",
    "tiny": "are, beside the others, at the origin",
    "welded": "are welded to another one in their place",
    "collapsed": "had two corners in one place: they are set aside",
    "crowded": "had more than two faces: the sheets are cut apart, but for the best pairs",
    "twin": "have the vertices of another face: they are a sheet of their own",
    "turned": "are turned to the orientation of their neighbours",
    "torn": "cut a one-sided sheet (a Moebius band) open",
    "bowtie": "joined several fans of faces: each fan has a vertex of its own",
    "arealess": "are a piece without area: they are set aside",
    "opened": "had zero area: they are opened a little",
}


@dataclass(frozen=True, eq=False)
class Cleaned:
    """A surface that `flatten`, `cut` and the others take, as `V, F, origin, repairs = cleaned`.

    Attributes
    ----------
    V : (#V', 3) float64
        The given positions, but for what `repairs` lists as scaled, welded, collapsed or opened.
    F : (#F', 3) int64
        An oriented manifold; each face has an area. May be empty.
    origin : (#V',) int64
        The given vertex that each is.
    repairs : tuple of Repair
        What was done; empty if the mesh was clean.
    faces : (#F',) int64
        The given face that each is, ascending; those set aside are missing.
    turned : (#F',) bool
        Whether it runs the other way around: its last two corners have then changed places.
    merged : (#V,) int64
        The given vertex that each given one was made one with, or itself.
    power : int
        V is scaled by 2 to this.
    """

    V: FloatArray
    F: IntArray
    origin: IntArray
    repairs: tuple[Repair, ...]
    faces: IntArray
    turned: BoolArray
    merged: IntArray
    power: int = 0

    def __iter__(self) -> Iterator[object]:
        return iter((self.V, self.F, self.origin, self.repairs))


def clean(V: ArrayLike, F: ArrayLike, *, weld: float | None = None) -> Cleaned:
    """Make any triangles an oriented manifold surface, of which each face has an area.

    Where three and more faces meet in an edge, sheets are cut apart; the pairs that continue
    each other best stay together. Two faces of the same vertices become two sheets. Each sheet is
    oriented as most of its faces are; a one-sided one (a Moebius band) is cut. Where fans of faces
    meet in a vertex, each gets a vertex of its own. Faces with two corners in one place are set
    aside, and the surface closes over them. Other faces without area stay, opened a little: a vertex
    moves by a tenth of their shortest side at most, in the plane of the neighbour. A clean mesh comes
    back as it is.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions, finite where a face is.
    F : (#F, 3) int
        Any triangles.
    weld : float, optional
        Make vertices one that are at most this far apart, or linked by a chain of such steps; 0:
        those equal to the bit. By default that is done for a soup, most of whose triangles,
        quadrangles or flat sides have vertices of their own.

    Returns
    -------
    Cleaned
        Unpacks as `V, F, origin, repairs`.

    Raises
    ------
    MeshError
        The arrays are malformed, an index is out of range, or a coordinate at a face is NaN or
        infinite.
    ValueError
        `weld` is no distance.

    Examples
    --------
    Three pages of a book; two of them stay together:

    >>> V = [[0, 0, 0], [0, 1, 0], [1, 0, 0], [-1, 0, 0], [0, 0, 1]]
    >>> V, F, origin, repairs = clean(V, [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    >>> F.tolist(), origin.tolist()
    ([[0, 2, 4], [2, 0, 5], [1, 3, 6]], [0, 0, 1, 1, 2, 3, 4])
    >>> print(*repairs)
    edges [0, 1] had more than two faces: the sheets are cut apart, but for the best pairs
    """
    return cleaned_surface(V, F, weld)[0]


def cleaned_surface(V: ArrayLike, F: ArrayLike, weld: float | None = None) -> tuple[Cleaned, Submesh]:
    """`clean`, and the cleaned surface; of a clean mesh, it has the caller's vertices."""
    positions, faces = vertex_array(V), face_array(F)
    check_indices(faces, len(positions))
    in_use = np.zeros(len(positions), dtype=bool)
    in_use[faces.ravel()] = True
    used = np.flatnonzero(in_use)
    check_finite(positions[used], used)
    if weld is None:
        surface = _if_clean(positions, faces)
        if surface is not None:
            return unrepaired(surface), surface
    done = _repaired(positions, faces, used, weld)
    n = len(done.V)
    return done, Submesh(done.V, done.F, done.faces, np.arange(n), n)


def _if_clean(V: FloatArray, F: IntArray) -> Submesh | None:
    """The surface, if nothing is to be repaired."""
    try:
        surface = Submesh.of_arrays(V, F)
        _ = surface.measured  # what follows is for faces with an area
        if surface.sound_topology is None:
            return None
        surface.as_manifold()
    except MeshError:  # that is what is to be repaired
        return None
    soup = is_soup(surface.V, surface.F, surface.label) and not _apart(surface.V)
    size = np.abs(surface.V.T).max(axis=0)
    tiny = (size > 0) & (size <= SMALLEST_COORDINATE)
    unclear = tiny.any() and tiny[surface.F].all(axis=1).any()
    return None if soup or unclear or _beyond(size).any() else surface


def unrepaired(surface: Submesh) -> Cleaned:
    """A clean surface in the form of a repaired one."""
    return Cleaned(
        V=surface.V,
        F=surface.F,
        origin=surface.vertices,
        repairs=(),
        faces=surface.faces,
        turned=np.zeros(len(surface.F), dtype=bool),
        merged=np.arange(surface.n_given),
    )


def _apart(V: FloatArray) -> bool:
    every = np.arange(len(V))
    return bool((merge_coincident(V, every) == every).all())


def _repaired(V: FloatArray, F: IntArray, used: IntArray, weld: float | None) -> Cleaned:
    did: list[Repair] = []

    def note(kind: str, of: str, which: IntArray) -> None:
        if len(which):
            did.append(Repair(kind, len(which), of, which[:LISTED]))

    merged = np.arange(len(V))
    if weld is not None:
        merged = merge_within(V, used, weld)
    elif is_soup(V, F, face_components(F, len(V))):
        merged = merge_coincident(V, used)
    note("welded", "vertices", np.flatnonzero(merged != np.arange(len(V))))
    beyond, power = used[_beyond(np.abs(V[used].T).max(axis=0))], 0
    if len(beyond):
        note("scaled", "vertices", beyond)
        power = -int(np.frexp(np.abs(V[used]).max())[1])
        V = np.ldexp(V, power)
    size = np.abs(V[used].T).max(axis=0)
    tiny = used[(size > 0) & (size <= SMALLEST_COORDINATE)]
    if len(tiny):
        note("tiny", "vertices", tiny)
        V = V.copy()
        V[tiny] = 0.0
    merged = collapse_short_sides(V, merged[F])[merged]
    G = merged[F]
    distinct = distinct_corners(G)
    note("collapsed", "faces", np.flatnonzero(~distinct))
    rows = np.flatnonzero(distinct)
    sheets = separate_sheets(V, G[rows])
    note("crowded", "edges", sheets.crowded)
    note("twin", "faces", rows[sheets.twins])
    note("turned", "faces", rows[sheets.turned])
    note("torn", "edges", sheets.torn)
    note("bowtie", "vertices", _bowties(sheets, G[rows]))
    solid, lost = _with_area(V[sheets.origin], sheets.F)
    note("arealess", "faces", rows[lost])
    kept = np.zeros(len(sheets.origin), dtype=bool)
    kept[sheets.F[solid]] = True
    number = np.cumsum(kept) - 1
    F_new, origin = number[sheets.F[solid]], sheets.origin[kept]
    V_new, opened = open_caps(V[origin], F_new)
    note("opened", "faces", rows[solid][opened])
    return Cleaned(V_new, F_new, origin, tuple(did), rows[solid], sheets.turned[solid], merged, power)


def _beyond(size: FloatArray) -> BoolArray:
    """The vertices for which to scale, by the largest coordinate of each; none if all have a usual size."""
    largest = float(size.max())
    if SMALLEST_USUAL_COORDINATE < largest < LARGEST_USUAL_COORDINATE or largest == 0:
        return np.zeros(len(size), dtype=bool)
    return np.asarray(size >= LARGEST_USUAL_COORDINATE if largest > 1 else size > 0)


def _bowties(sheets: Sheets, F: IntArray) -> IntArray:
    """Vertices of several fans that are on no edge where sheets were cut."""
    copies = np.bincount(sheets.origin)
    copies[np.concatenate((sheets.crowded, sheets.torn)).ravel()] = 0
    copies[F[sheets.twins]] = 0
    return np.flatnonzero(copies > 1)


def _with_area(V: FloatArray, F: IntArray) -> tuple[IntArray, IntArray]:
    """Faces of pieces in which one has an area, and the others."""
    if not len(F):
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    flat = without_area(V, F)
    if not len(flat):
        return np.arange(len(F)), flat
    label = face_components(F, len(V))
    area = np.ones(len(F), dtype=bool)
    area[flat] = False
    solid = np.bincount(label, weights=area)[label] > 0
    return np.flatnonzero(solid), np.flatnonzero(~solid)
