"""Overlaps of a flat map with itself, which can occur even without flipped triangles."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import ArrayLike

from .._core import boundary_loops, find_overlaps
from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..errors import MeshWarning, stack_level
from ..surface import (
    Ragged,
    Submesh,
    Topology,
    complex_positions,
    label_face_components,
    scale_to_unit_size,
    signed_double_areas,
)
from .winding import find_open_sides, find_suspect_faces

NO_PAIRS: IntArray = np.zeros((0, 2), dtype=np.int64)
MAX_PAIRS = 5_000_000  # maximum number of listed pairs; n faces that all overlap have n^2 / 2 pairs


def format_pair_count(count: int) -> str:
    """Return the number of overlapping pairs as text; "more than ..." if not all pairs are listed."""
    return f"{count:,}" if count <= MAX_PAIRS else f"more than {MAX_PAIRS:,}"


def overlaps(uv: ArrayLike, F: ArrayLike, *, between: bool = False) -> IntArray:
    """Find the pairs of faces that overlap in the plane.

    Two faces overlap if one reaches into the other by more than a millionth of the smaller height (least
    width) of the two faces, and by more than the rounding error of the coordinates. Faces that touch at a
    vertex or along an edge do not overlap. A face folded over its neighbour overlaps it. A collapsed face
    never overlaps another face.

    Parameters
    ----------
    uv : (#V, 2) float
        The map; NaN is allowed at vertices that no face uses.
    F : (#F, 3) int
        Triangles. A chart is a component of faces that are connected by shared vertices.
    between : bool
        Also compare faces of different charts, for example in a packed atlas. By default, faces are
        compared only with faces of the same chart.

    Returns
    -------
    pairs : (#P, 2) int64
        Faces i < j, in lexicographic order; empty for an injective map. A list of more than 5,000,000 pairs
        is incomplete.

    Raises
    ------
    MeshError
        The arrays do not fit together, or `uv` is not finite at a vertex of a face.

    Warns
    -----
    MeshWarning
        More than 5,000,000 pairs overlap.

    Notes
    -----
    In a chart without flipped faces, a point is covered as often as the boundary loops wind around it.
    Therefore, if the loops do not cross and only one of them runs counter-clockwise, faces cannot overlap and
    are not compared.

    Examples
    --------
    >>> square, corner = [[0, 0], [2, 0], [2, 2], [0, 2]], [[1, 1], [3, 1], [3, 3]]
    >>> F = [[0, 1, 2], [0, 2, 3], [4, 5, 6]]
    >>> overlaps(square + corner, F)
    array([], shape=(0, 2), dtype=int64)
    >>> overlaps(square + corner, F, between=True)
    array([[0, 2]])
    """
    surface = Submesh.from_input(uv, F, 2, "uv")
    pairs = find_overlapping_pairs(surface.V, surface.F, between=between)
    if len(pairs) > MAX_PAIRS:
        warnings.warn(
            f"{format_pair_count(len(pairs))} pairs of faces overlap, and the list is incomplete: flatten "
            "the surface again, or pass fewer faces",
            MeshWarning,
            stacklevel=stack_level(),
        )
    return pairs


def find_overlapping_pairs(map_: FloatArray, F: IntArray, *, between: bool = False) -> IntArray:
    """Find overlapping pairs as `overlaps` does, in a checked map."""
    map_ = scale_to_unit_size(map_)
    if between:
        return _find_all_pairs(complex_positions(map_), F)
    chart = label_face_components(F, len(map_))
    z = complex_positions(map_)
    suspect = ~_prove_injectivity(z, F, chart)
    index = np.flatnonzero(suspect[chart])
    if np.count_nonzero(suspect) == 1:
        return np.asarray(index[_find_pairs_in_chart(z, F[index])])
    return np.asarray(index[find_overlaps(z, F[index], chart[index], MAX_PAIRS)])


def find_overlapping_pairs_of_chart(
    topology: Topology, map_: FloatArray, limit: int | None = None
) -> IntArray:
    """Find the `find_overlapping_pairs` of a connected surface whose boundary loops are known.

    If there are more than `limit` pairs, by default `MAX_PAIRS`, the list has `limit` + 1 rows.
    """
    z, F = complex_positions(scale_to_unit_size(map_)), np.ascontiguousarray(topology.corner.T)
    upright = bool((signed_double_areas(z, topology.corner) > 0).all())
    index = np.arange(len(F))
    if upright and topology.loops:
        rim = np.concatenate(topology.loops)
        following = Ragged.from_sizes(list(map(len, topology.loops))).next_element
        if _winds_once(z[rim], following, np.zeros(len(rim), dtype=np.int64), 1)[0]:
            return NO_PAIRS
        index = np.flatnonzero(find_suspect_faces(z, F, rim, rim[following]))
    return np.asarray(index[_find_all_pairs(z, F[index], limit)])


def find_overlapping_pairs_of_charts(maps: Sequence[tuple[FloatArray, IntArray]]) -> list[IntArray]:
    """Return the `find_overlapping_pairs` of each of many charts (uv, F), without comparing different "
    "charts."""
    if not maps:
        return []
    vertices, faces = (Ragged.from_sizes([len(pair[k]) for pair in maps]) for k in (0, 1))
    F = np.concatenate([F for _, F in maps]) + faces.repeat(vertices.start[:-1])[:, None]
    largest = np.array([np.abs(uv).max() for uv, _ in maps])
    scale = np.ldexp(1.0, -np.frexp(largest)[1])  # powers of two scale without rounding
    z = complex_positions(np.concatenate([uv for uv, _ in maps]) * vertices.repeat(scale)[:, None])
    chart = faces.repeat(np.arange(len(maps)))
    asked = np.flatnonzero(~_prove_injectivity(z, F, chart))
    found = [NO_PAIRS] * len(maps)
    if len(asked) == 1:
        own = slice(*vertices.start[asked[0] : asked[0] + 2])
        found[asked[0]] = _find_pairs_in_chart(z[own], maps[asked[0]][1])
    elif len(asked):
        rows = np.flatnonzero(np.isin(chart, asked))
        pairs = rows[find_overlaps(z, F[rows], chart[rows], MAX_PAIRS)]
        if len(pairs) > MAX_PAIRS:  # the list is truncated, and may lack pairs of any chart
            return [find_overlapping_pairs(uv, F) for uv, F in maps]
        of = chart[pairs[:, 0]]
        for i in np.unique(of).tolist():
            found[i] = pairs[of == i] - faces.start[i]
    return found


def _find_pairs_in_chart(z: ComplexArray, F: IntArray) -> IntArray:
    """Find the overlapping pairs of a chart, searching only near points with a winding number above one."""
    rim, index = find_open_sides(F, len(z)), np.arange(len(F))
    if rim is not None:
        tail, head = (F[:, columns].T.ravel()[rim] for columns in ([0, 1, 2], [1, 2, 0]))
        index = np.flatnonzero(find_suspect_faces(z, F, tail, head))
    return np.asarray(index[_find_all_pairs(z, F[index])])


def _find_all_pairs(z: ComplexArray, F: IntArray, limit: int | None = None) -> IntArray:
    """Find all overlapping pairs, including pairs of faces of different charts."""
    return find_overlaps(z, F, np.zeros(len(F), dtype=np.int64), MAX_PAIRS if limit is None else limit)


def _prove_injectivity(z: ComplexArray, F: IntArray, chart: IntArray) -> BoolArray:
    """Return a mask of the charts whose boundary and face orientations prove that faces do not overlap."""
    number = int(chart.max()) + 1
    proved = np.zeros(number, dtype=bool)
    upright = np.ones(number, dtype=bool)
    upright[chart[~(signed_double_areas(z, F.T) > 0)]] = False
    boundary = find_open_sides(F, len(z))
    if boundary is None:
        return proved
    of, tail, head = chart[boundary % len(F)], F.T.ravel()[boundary], F[:, [1, 2, 0]].T.ravel()[boundary]
    order = np.argsort(tail)
    upright[of[order[1:][tail[order[1:]] == tail[order[:-1]]]]] = False  # loops touch at a vertex
    ask = order[upright[of[order]]]
    if len(ask):
        proved[of[ask]] = True
        proved &= _winds_once(z[tail[ask]], np.searchsorted(tail[ask], head[ask]), of[ask], number)
    return proved


def find_crossed_loops(z: ComplexArray, rim: IntArray, loops: Ragged) -> IntArray:
    """Return the disks whose boundary loop crosses or touches itself.

    The map of any other disk without holes is injective if no face is flipped. `rim` has the vertices of all
    loops, and `loops` divides them into disks.
    """
    of, n = loops.repeat(np.arange(len(loops))), len(loops)
    return np.flatnonzero(~_winds_once(np.nan_to_num(z[rim]), loops.next_element, of, n))


def _winds_once(z: ComplexArray, following: IntArray, of: IntArray, number: int) -> BoolArray:
    """Return, for each chart, True if all boundary loops are simple and exactly one is counter-clockwise.

    If no face is flipped, the result True proves that faces do not overlap: the number of faces that cover a
    point is the winding number of the loops, which is at most one. Because the winding number is never
    negative, the loops are disjoint.

    `following` and `of` are the index of the next point and the chart of each point in `z`; `number` is the
    number of charts.
    """
    ordered, sizes, _ = boundary_loops(np.arange(len(z)), following, len(z))
    loops = Ragged.from_sizes(sizes)
    first = ordered[loops.start[:-1]]
    points = z[np.insert(ordered, loops.start[1:], first)]
    lines = shapely.linestrings(points.real, points.imag, indices=np.repeat(np.arange(len(loops)), sizes + 1))
    chart = of[first]
    turns = np.bincount(chart[shapely.is_ccw(lines)], minlength=number)
    simple = np.bincount(chart[~shapely.is_simple(lines)], minlength=number) == 0
    return np.asarray(simple & (turns == 1))
