"""Overlaps of a flat map with itself, which occur also without flipped triangles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import ArrayLike

from .._core import boundary_loops, overlapping
from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..surface import (
    Ragged,
    Submesh,
    Topology,
    complex_positions,
    face_components,
    of_size_one,
    signed_double_areas,
)
from .winding import may_overlap, open_sides

NO_PAIRS: IntArray = np.zeros((0, 2), dtype=np.int64)


def overlaps(uv: ArrayLike, F: ArrayLike, *, between: bool = False) -> IntArray:
    """Pairs of faces that overlap in the plane.

    Two faces overlap if one reaches into the other by more than a millionth of the smaller one's
    height (its least width), and by more than the rounding of the coordinates. Touching at a
    vertex or along an edge is not an overlap.
    A face folded over its neighbour overlaps it. A collapsed face overlaps nothing.

    Parameters
    ----------
    uv : (#V, 2) float
        The map; NaN is allowed at vertices that no face uses.
    F : (#F, 3) int
        Triangles. A chart is a component of faces connected by common vertices.
    between : bool
        Compare faces of different charts, too, as in a packed atlas. By default each chart is
        compared with itself only.

    Returns
    -------
    pairs : (#P, 2) int64
        Faces i < j, in lexicographic order; empty for an injective map.

    Raises
    ------
    MeshError
        The arrays do not fit together, or `uv` is not finite at a vertex of a face.

    Notes
    -----
    In a chart without flipped faces, a point is covered as often as the boundary loops wind around
    it. So if the loops do not cross, and only one of them runs counter-clockwise, nothing overlaps
    and no faces are compared.

    Examples
    --------
    >>> square, corner = [[0, 0], [2, 0], [2, 2], [0, 2]], [[1, 1], [3, 1], [3, 3]]
    >>> F = [[0, 1, 2], [0, 2, 3], [4, 5, 6]]
    >>> overlaps(square + corner, F)
    array([], shape=(0, 2), dtype=int64)
    >>> overlaps(square + corner, F, between=True)
    array([[0, 2]])
    """
    surface = Submesh.checked(uv, F, 2, "uv")
    return overlapping_pairs(surface.V, surface.F, between=between)


def overlapping_pairs(map_: FloatArray, F: IntArray, *, between: bool = False) -> IntArray:
    """`overlaps` of a checked map."""
    map_ = of_size_one(map_)
    if between:
        return _in_one_plane(complex_positions(map_), F)
    chart = face_components(F, len(map_))
    z = complex_positions(map_)
    suspect = ~_injective(z, F, chart)
    index = np.flatnonzero(suspect[chart])
    if np.count_nonzero(suspect) == 1:
        return np.asarray(index[_within_chart(z, F[index])])
    return np.asarray(index[overlapping(z, F[index], chart[index])])


def overlapping_pairs_of_chart(topology: Topology, map_: FloatArray) -> IntArray:
    """`overlapping_pairs` of the map of a surface in one piece, whose boundary loops are known."""
    z, F = complex_positions(of_size_one(map_)), np.ascontiguousarray(topology.corner.T)
    upright = bool((signed_double_areas(z, topology.corner) > 0).all())
    index = np.arange(len(F))
    if upright and topology.loops:
        rim = np.concatenate(topology.loops)
        following = Ragged.of_sizes(list(map(len, topology.loops))).following
        if _wind_once(z[rim], following, np.zeros(len(rim), dtype=np.int64), 1)[0]:
            return NO_PAIRS
        index = np.flatnonzero(may_overlap(z, F, rim, rim[following]))
    return np.asarray(index[_in_one_plane(z, F[index])])


def overlapping_pairs_of_each(maps: Sequence[tuple[FloatArray, IntArray]]) -> list[IntArray]:
    """`overlapping_pairs` of many charts (uv, F), each in a plane of its own."""
    if not maps:
        return []
    vertices, faces = (Ragged.of_sizes([len(pair[k]) for pair in maps]) for k in (0, 1))
    F = np.concatenate([F for _, F in maps]) + faces.repeat(vertices.start[:-1])[:, None]
    largest = np.array([np.abs(uv).max() for uv, _ in maps])
    scale = np.ldexp(1.0, -np.frexp(largest)[1])  # all of size one, without rounding
    z = complex_positions(np.concatenate([uv for uv, _ in maps]) * vertices.repeat(scale)[:, None])
    chart = faces.repeat(np.arange(len(maps)))
    asked = np.flatnonzero(~_injective(z, F, chart))
    found = [NO_PAIRS] * len(maps)
    if len(asked) == 1:
        own = slice(*vertices.start[asked[0] : asked[0] + 2])
        found[asked[0]] = _within_chart(z[own], maps[asked[0]][1])
    elif len(asked):
        rows = np.flatnonzero(np.isin(chart, asked))
        pairs = rows[overlapping(z, F[rows], chart[rows])]
        of = chart[pairs[:, 0]]
        for i in np.unique(of).tolist():
            found[i] = pairs[of == i] - faces.start[i]
    return found


def _within_chart(z: ComplexArray, F: IntArray) -> IntArray:
    """All overlapping pairs of a chart, sought where its boundary winds around a place more than once."""
    rim, index = open_sides(F, len(z)), np.arange(len(F))
    if rim is not None:
        tail, head = (F[:, columns].T.ravel()[rim] for columns in ([0, 1, 2], [1, 2, 0]))
        index = np.flatnonzero(may_overlap(z, F, tail, head))
    return np.asarray(index[_in_one_plane(z, F[index])])


def _in_one_plane(z: ComplexArray, F: IntArray) -> IntArray:
    """All overlapping pairs, also of faces of different charts."""
    return overlapping(z, F, np.zeros(len(F), dtype=np.int64))


def _injective(z: ComplexArray, F: IntArray, chart: IntArray) -> BoolArray:
    """Charts whose boundary loops and face orientations prove that nothing overlaps."""
    number = int(chart.max()) + 1
    proved = np.zeros(number, dtype=bool)
    upright = np.ones(number, dtype=bool)
    upright[chart[~(signed_double_areas(z, F.T) > 0)]] = False
    boundary = open_sides(F, len(z))
    if boundary is None:
        return proved
    of, tail, head = chart[boundary % len(F)], F.T.ravel()[boundary], F[:, [1, 2, 0]].T.ravel()[boundary]
    order = np.argsort(tail)
    upright[of[order[1:][tail[order[1:]] == tail[order[:-1]]]]] = False  # loops touch in a vertex
    ask = order[upright[of[order]]]
    if len(ask):
        proved[of[ask]] = True
        proved &= _wind_once(z[tail[ask]], np.searchsorted(tail[ask], head[ask]), of[ask], number)
    return proved


def _wind_once(z: ComplexArray, following: IntArray, of: IntArray, number: int) -> BoolArray:
    """Whether all loops are simple and just one is counter-clockwise; for each of a number of charts.

    Of faces that are all upright, nothing then overlaps: as many faces cover a place as the loops wind
    around it, which is at most once, and never less than zero, so that the loops are disjoint, too.
    Each point has the place of the one after it, and its chart.
    """
    ordered, sizes, _ = boundary_loops(np.arange(len(z)), following, len(z))
    loops = Ragged.of_sizes(sizes)
    first = ordered[loops.start[:-1]]
    points = z[np.insert(ordered, loops.start[1:], first)]
    lines = shapely.linestrings(points.real, points.imag, indices=np.repeat(np.arange(len(loops)), sizes + 1))
    chart = of[first]
    turns = np.bincount(chart[shapely.is_ccw(lines)], minlength=number)
    simple = np.bincount(chart[~shapely.is_simple(lines)], minlength=number) == 0
    return np.asarray(simple & (turns == 1))
