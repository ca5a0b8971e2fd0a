"""Repair arbitrary triangles into an oriented manifold without degenerate faces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ..._core import group_sides
from ..._types import BoolArray, FloatArray, IntArray
from ...errors import MAX_LISTED, MeshError, first_few, is_number, takes_vertices_and_faces
from ..areas import find_faces_without_area
from ..arrays import check_finite, check_indices, face_array, has_distinct_corners, vertex_array
from ..constants import SMALLEST_COORDINATE
from ..submesh import Submesh
from ..topology import connected_labels, label_face_components
from .sheets import Sheets, get_vertices_of_sides, separate_sheets
from .slivers import collapse_short_sides, open_faces_without_area

# Range of the largest coordinate in which eighth powers of lengths neither overflow nor vanish.
# Meshes outside this range are scaled by a power of two.
LARGEST_USUAL_COORDINATE = 1e30
SMALLEST_USUAL_COORDINATE = 1e-30

LARGEST_WELDED_COORDINATE = 1e150  # larger coordinates would overflow in squared distances


def mark_coincident_edges(V: FloatArray, edges: IntArray) -> BoolArray:
    """Mark the edges whose ends have the same two positions as those of another edge."""
    tail, head = np.ascontiguousarray(merge_coincident(V, np.unique(edges))[edges].T)
    order, _, count = group_sides(tail, head, len(V))
    shared = np.empty(len(edges), dtype=bool)
    shared[order] = np.repeat(count > 1, count)
    return shared


def _is_unwelded(V: FloatArray, boundary: IntArray) -> bool:
    """Return True if most boundary edges coincide, as in triangle soups and at the seams of older maps."""
    return bool(2 * np.count_nonzero(mark_coincident_edges(V, boundary)) > len(boundary))


def _find_boundary(F: IntArray, n: int) -> IntArray:
    """Return the edges that belong to exactly one triangle; the triangles need not form a manifold."""
    tail, head = get_vertices_of_sides(F)
    order, begin, count = group_sides(tail, head, n)
    rim = order[begin[count == 1]]
    return np.column_stack((tail[rim], head[rim]))


def merge_coincident(V: FloatArray, used: IntArray) -> IntArray:
    """Map each `used` vertex to the first used vertex with exactly the same position."""
    points = V[used]
    order = np.lexsort(points.T)
    new = np.append(True, (points[order[1:]] != points[order[:-1]]).any(axis=1))[: len(used)]
    first = np.minimum.reduceat(order, np.flatnonzero(new))
    merged = np.arange(len(V))
    merged[used[order]] = used[first[np.cumsum(new) - 1]]
    return merged


def merge_nearby(V: FloatArray, used: IntArray, distance: float) -> IntArray:
    """Map each vertex to the first vertex that a chain of steps of at most `distance` connects to it.

    Raises
    ------
    ValueError
        `distance` is negative or not finite.
    """
    if not is_number(distance, 0, np.finfo(float).max):
        raise ValueError(f"weld is {distance!r}: give a distance of at least 0, in the units of V, or False")
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
    """A repair that `clean` has made, and where.

    Attributes
    ----------
    kind : str
        "scaled", "tiny", "welded", "collapsed", "crowded", "twin", "turned", "torn", "bowtie", "arealess"
        or "opened".
    count : int
        Number of repaired vertices, edges or faces.
    of : str
        The kind of elements that are counted: "vertices", "edges" or "faces".
    first : (at most 5,) or (at most 5, 2) int64
        The first few elements, as input indices; edges are given by their two vertices.
    """

    kind: str
    count: int
    of: str
    first: IntArray

    def __str__(self) -> str:
        more = f", ... ({self.count:,} in all)" if self.count > len(self.first) else ""
        return f"{self.of} {first_few(self.first)}{more} {REPAIR_TEXTS[self.kind]}"


REPAIR_TEXTS = {
    "scaled": "were beyond the range of coordinates: all are scaled by a power of two",
    "tiny": "are so close to the origin that they are moved onto it",
    "welded": "are welded to another vertex at the same position (weld=False keeps them apart)",
    "collapsed": "had two corners at the same position: they are removed",
    "crowded": "had more than two faces: the sheets are cut apart, except for the best pairs",
    "twin": "have the same vertices as another face: they become a separate sheet",
    "turned": "are turned to the orientation of their neighbours",
    "torn": "cut a one-sided sheet (a Moebius band) open",
    "bowtie": "joined several fans of faces: each fan has its own vertex now",
    "arealess": "belong to pieces without area: they are removed",
    "opened": "had zero area: they are opened a little",
}


@dataclass(frozen=True, eq=False)
class Cleaned:
    """A clean surface for `flatten`, `cut` and all other functions: `V, F, origin, repairs = cleaned`.

    Attributes
    ----------
    V : (#V', 3) float64
        The given positions, except where `repairs` lists vertices or faces as scaled, tiny, welded,
        collapsed or opened.
    F : (#F', 3) int64
        An oriented manifold whose faces all have an area. May be empty.
    origin : (#V',) int64
        The given vertex that each vertex comes from.
    repairs : tuple of Repair
        The repairs; empty if the mesh was clean.
    faces : (#F',) int64
        The given face that each face comes from, ascending; removed faces are missing.
    turned : (#F',) bool
        Whether the orientation of the face was reversed. The last two corners of reversed faces are swapped.
    merged : (#V,) int64
        For each given vertex, the given vertex that it was merged into, or itself.
    power : int
        V is scaled by 2**power.
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


@takes_vertices_and_faces
def clean(V: ArrayLike, F: ArrayLike, *, weld: float | Literal[False] | None = None) -> Cleaned:
    """Repair arbitrary triangles into an oriented manifold whose faces all have an area.

    Where three or more faces meet in an edge, the sheets are cut apart, except for the pairs of faces that
    continue each other best. Two faces with the same vertices become separate sheets. Each sheet gets the
    orientation of most of its faces; a one-sided sheet (a Moebius band) is cut open. Where several fans of
    faces meet in a vertex, each fan gets its own copy of the vertex. Faces with two corners at the same
    position are removed, and the surface closes over them. Other faces without area are kept and opened a
    little: a vertex moves by at most a tenth of the shortest side, in the plane of the neighbouring face.
    A clean mesh is returned unchanged.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions; finite at vertices of faces.
    F : (#F, 3) int
        Any triangles.
    weld : float or False, optional
        Merge vertices whose distance is at most `weld`, also over chains of such steps; 0 merges exactly
        equal positions, and False merges nothing. By default, exactly equal positions are merged if most
        boundary edges coincide with another boundary edge, as in a triangle soup or in a file that doubles
        the vertices along the seams of an older map.

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
        `weld` is neither a distance nor False.

    Examples
    --------
    Three pages of a book; two of them stay together:

    >>> V = [[0, 0, 0], [0, 1, 0], [1, 0, 0], [-1, 0, 0], [0, 0, 1]]
    >>> V, F, origin, repairs = clean(V, [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    >>> F.tolist(), origin.tolist()
    ([[0, 2, 4], [2, 0, 5], [1, 3, 6]], [0, 0, 1, 1, 2, 3, 4])
    >>> print(*repairs)
    edges [0, 1] had more than two faces: the sheets are cut apart, except for the best pairs
    """
    return clean_surface(V, F, weld)[0]


def clean_surface(
    V: ArrayLike, F: ArrayLike, weld: float | Literal[False] | None = None
) -> tuple[Cleaned, Submesh]:
    """Return the result of `clean`, also as a `Submesh`; a clean mesh keeps the input vertices."""
    positions, faces = vertex_array(V), face_array(F)
    check_indices(faces, len(positions))
    in_use = np.zeros(len(positions), dtype=bool)
    in_use[faces.ravel()] = True
    used = np.flatnonzero(in_use)
    check_finite(positions[used], used)
    if weld is None or weld is False:
        surface = _check_clean(positions, faces, weld is None)
        if surface is not None:
            return wrap_sound_surface(surface), surface
    done = _repair_triangles(positions, faces, used, weld)
    n = len(done.V)
    return done, Submesh(done.V, done.F, done.faces, np.arange(n), n)


def _check_clean(V: FloatArray, F: IntArray, may_weld: bool) -> Submesh | None:
    """Return the surface if it needs no repair, otherwise None."""
    try:
        surface = Submesh.from_arrays(V, F)
        _ = surface.areas_and_products  # raises if a face has no area
        topology = surface.topology_or_none
        if topology is None:
            return None
        surface.as_manifold()
    except MeshError:
        return None
    unwelded = may_weld and _is_unwelded(surface.V, topology.boundary_edges)
    size = np.abs(surface.V.T).max(axis=0)
    tiny = (size > 0) & (size <= SMALLEST_COORDINATE)
    unclear = tiny.any() and tiny[surface.F].all(axis=1).any()
    return None if unwelded or unclear or _needs_scaling(size).any() else surface


def wrap_sound_surface(surface: Submesh) -> Cleaned:
    """Wrap a surface that needs no repair."""
    return Cleaned(
        V=surface.V,
        F=surface.F,
        origin=surface.vertices,
        repairs=(),
        faces=surface.faces,
        turned=np.zeros(len(surface.F), dtype=bool),
        merged=np.arange(surface.n_given),
    )


def _repair_triangles(
    V: FloatArray, F: IntArray, used: IntArray, weld: float | Literal[False] | None
) -> Cleaned:
    did: list[Repair] = []

    def add_repair(kind: str, of: str, which: IntArray) -> None:
        if len(which):
            did.append(Repair(kind, len(which), of, which[:MAX_LISTED]))

    merged = np.arange(len(V))
    if weld is None and _is_unwelded(V, _find_boundary(F, len(V))):
        merged = merge_coincident(V, used)
    elif weld is not None and weld is not False:
        merged = merge_nearby(V, used, weld)
    add_repair("welded", "vertices", np.flatnonzero(merged != np.arange(len(V))))
    beyond, power = used[_needs_scaling(np.abs(V[used].T).max(axis=0))], 0
    if len(beyond):
        add_repair("scaled", "vertices", beyond)
        power = -int(np.frexp(np.abs(V[used]).max())[1])
        V = np.ldexp(V, power)
    size = np.abs(V[used].T).max(axis=0)
    tiny = used[(size > 0) & (size <= SMALLEST_COORDINATE)]
    if len(tiny):
        add_repair("tiny", "vertices", tiny)
        V = V.copy()
        V[tiny] = 0.0
    merged = collapse_short_sides(V, merged[F])[merged]
    G = merged[F]
    distinct = has_distinct_corners(G)
    add_repair("collapsed", "faces", np.flatnonzero(~distinct))
    rows = np.flatnonzero(distinct)
    sheets = separate_sheets(V, G[rows])
    add_repair("crowded", "edges", sheets.crowded)
    add_repair("twin", "faces", rows[sheets.twins])
    add_repair("turned", "faces", rows[sheets.turned])
    add_repair("torn", "edges", sheets.torn)
    add_repair("bowtie", "vertices", _find_bowties(sheets, G[rows]))
    solid, lost = _partition_by_area(V[sheets.origin], sheets.F)
    add_repair("arealess", "faces", rows[lost])
    kept = np.zeros(len(sheets.origin), dtype=bool)
    kept[sheets.F[solid]] = True
    number = np.cumsum(kept) - 1
    F_new, origin = number[sheets.F[solid]], sheets.origin[kept]
    V_new, opened = open_faces_without_area(V[origin], F_new)
    add_repair("opened", "faces", rows[solid][opened])
    return Cleaned(V_new, F_new, origin, tuple(did), rows[solid], sheets.turned[solid], merged, power)


def _needs_scaling(size: FloatArray) -> BoolArray:
    """Mark vertices whose largest coordinate requires scaling; none if the mesh has no extreme size."""
    largest = float(size.max())
    if SMALLEST_USUAL_COORDINATE < largest < LARGEST_USUAL_COORDINATE or largest == 0:
        return np.zeros(len(size), dtype=bool)
    return np.asarray(size >= LARGEST_USUAL_COORDINATE if largest > 1 else size > 0)


def _find_bowties(sheets: Sheets, F: IntArray) -> IntArray:
    """Return the vertices with several fans of faces, except vertices on edges where sheets were cut."""
    copies = np.bincount(sheets.origin)
    copies[np.concatenate((sheets.crowded, sheets.torn)).ravel()] = 0
    copies[F[sheets.twins]] = 0
    return np.flatnonzero(copies > 1)


def _partition_by_area(V: FloatArray, F: IntArray) -> tuple[IntArray, IntArray]:
    """Divide the faces into pieces that contain a face with an area, and pieces that do not."""
    if not len(F):
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    flat = find_faces_without_area(V, F)
    if not len(flat):
        return np.arange(len(F)), flat
    label = label_face_components(F, len(V))
    area = np.ones(len(F), dtype=bool)
    area[flat] = False
    solid = np.bincount(label, weights=area)[label] > 0
    return np.flatnonzero(solid), np.flatnonzero(~solid)
