"""Seams that separate the overlapping parts of a flat map."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ..._core import overlap_sheets, shortest_pairs
from ..._types import BoolArray, IntArray
from ...errors import MeshError, some
from ...surface import Submesh, check_planar, face_components
from ..cut_graphs import ClosedSurface, join_terminals
from ..features import box_sides
from ..least_cuts import ON_EITHER, ON_ONE_SIDE, ON_THE_OTHER, edges_between_polygons, sides_of_least_cut
from . import constants


def separating_seams(V: ArrayLike, F: ArrayLike, pairs: ArrayLike) -> IntArray:
    """Short seams that separate the overlapping parts of a flat map.

    Each seam is the shortest along edges of the surface that has the two sheets of some overlaps on different
    sides, the largest overlaps first (a least cut of the graph of faces). It runs from boundary to boundary,
    or, if that is shorter, from the boundary around one sheet and back to itself. Disks stay disks. That is
    repeated until no pair of faces is left in one part. A part may overlap itself again when it is flattened:
    repeat until none does.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles. A chart with overlaps is a disk; the others may be anything.
    pairs : (#P, 2) int
        The pairs that `overlaps(uv, F)` returns; the two faces of a pair are of one chart.

    Returns
    -------
    seams : (#E, 2) int64
        Edges to cut along, as vertices i < j, in lexicographic order.

    Raises
    ------
    MeshError
        The arrays do not fit together; a pair is not two different faces of one chart; a chart
        with overlaps is not an oriented manifold disk.

    Examples
    --------
    >>> import numpy as np
    >>> from igl_linabf.measures.overlapping import overlaps

    A strip, wound up by one turn and a fifth:

    >>> t = np.repeat(np.linspace(0, 7.5, 31), 2)
    >>> V = np.column_stack((t, np.tile([0, 0.2], 31), 0 * t))
    >>> F = np.array([[[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]] for i in range(30)])
    >>> F = F.reshape(-1, 3)
    >>> uv = (1 - V[:, 1:2]) * np.column_stack((np.cos(t), np.sin(t)))
    >>> pairs = overlaps(uv, F)
    >>> len(pairs), separating_seams(V, F, pairs)
    (27, array([[10, 11]]))
    """
    surface = Submesh.checked(V, F)
    array = _pair_array(pairs, len(surface.F))
    chart = face_components(surface.F, len(surface.V))
    strangers = np.flatnonzero(chart[array[:, 0]] != chart[array[:, 1]])
    if len(strangers):
        raise MeshError(
            f"pairs {some(strangers)} are faces of two charts (the first: faces "
            f"{array[strangers[0]].tolist()}): leave these pairs out, and move the charts apart"
        )
    charts = [surface.of_faces(np.flatnonzero(chart == i)) for i in np.unique(chart[array[:, 0]])]
    return seams_of_overlaps(charts, array)


def seams_of_overlaps(charts: list[Submesh], pairs: IntArray) -> IntArray:
    """`separating_seams` of checked charts; faces and vertices are numbered as by the caller."""
    seams, _ = _separated(charts, pairs)
    return np.unique(np.concatenate([np.zeros((0, 2), dtype=np.int64), *seams]), axis=0)


def split_overlaps(chart: Submesh, pairs: IntArray, most: int = constants.MAX_OVERLAPS) -> list[Submesh]:
    """The parts of a chart cut along these seams, of which each separates so many overlaps at most."""
    return _separated([chart], pairs, most)[1]


def _separated(
    charts: list[Submesh], pairs: IntArray, most: int = constants.MAX_OVERLAPS
) -> tuple[list[IntArray], list[Submesh]]:
    seams, parts = list[IntArray](), list[Submesh]()
    waiting = []
    for chart in charts:
        rows = np.minimum(np.searchsorted(chart.faces, pairs), len(chart.faces) - 1)
        waiting.append((chart, rows[(chart.faces[rows] == pairs).all(axis=1)]))
    while waiting:
        part, local = waiting.pop()
        apart = local
        if part.inner is not None:
            apart = part.polygon_labels[local]
            apart = apart[apart[:, 0] != apart[:, 1]]  # no seam takes a polygon apart
        if len(apart):
            check_planar(part.topology, part.vertices)
            seams.append(np.sort(_shortest_seam(part, apart, most), axis=1))
            waiting += _with_pairs(part, part.cut_along(seams[-1]), local)
        else:
            parts.append(part)
    return seams, sorted(parts, key=lambda part: int(part.faces[0]))


def _with_pairs(whole: Submesh, parts: list[Submesh], pairs: IntArray) -> list[tuple[Submesh, IntArray]]:
    """The parts of a whole, each with those pairs of faces that are both in it, as the part has them."""
    of, row = np.empty(len(whole.F), dtype=np.int64), np.empty(len(whole.F), dtype=np.int64)
    for k, part in enumerate(parts):
        rows = np.searchsorted(whole.faces, part.faces)
        of[rows], row[rows] = k, np.arange(len(rows))
    label = of[pairs]
    pairs, label = row[pairs[same := label[:, 0] == label[:, 1]]], label[same, 0]
    order = np.argsort(label, kind="stable")
    start = np.searchsorted(label[order], np.arange(len(parts) + 1)).tolist()
    return [(part, pairs[order[i:j]]) for part, (i, j) in zip(parts, pairwise(start), strict=True)]


def _pair_array(pairs: ArrayLike, m: int) -> IntArray:
    """`pairs` as (#P, 2) int64, checked."""
    array = np.asarray(pairs)
    if array.ndim != 2 or array.shape[1] != 2 or array.dtype.kind not in "iu":
        raise MeshError(
            f"pairs has the shape {array.shape} and the dtype {array.dtype}: pass the (#P, 2) face indices "
            "that overlaps returns"
        )
    array = array.astype(np.int64)
    bad = np.flatnonzero(((array < 0) | (array >= m)).any(axis=1) | (array[:, 0] == array[:, 1]))
    if len(bad):
        raise MeshError(
            f"pairs {some(bad)} are not two different faces within 0..{m - 1} (the first: "
            f"{array[bad[0]].tolist()}): pass what overlaps returned for the same F"
        )
    return array


def _shortest_seam(part: Submesh, pairs: IntArray, most: int) -> IntArray:
    """The edges of the shortest seam that separates the sheets of the largest overlaps.

    They are by the caller's vertices. Where the seam runs around a sheet, the shortest way from there to the
    boundary is among them. `pairs` are of polygons.
    """
    number, (between, length) = int(part.polygon_labels.max()) + 1, edges_between_polygons(part)
    links, spoke = _links_along_rim(part), constants.PART_COST * np.linalg.norm(box_sides(part.V)) / 2
    sides, price = np.hstack((between, links)), np.append(length, np.full(len(links[0]), spoke))
    terminal, beyond = np.full(number, ON_EITHER), np.zeros(number, dtype=bool)
    for one, other in _largest_overlaps(between, number, pairs, most):
        cuts = list[tuple[float, IntArray, BoolArray]]()
        for this, that in ((one, other), (other, one)):
            if (terminal[this] != ON_THE_OTHER).all() and (terminal[that] != ON_ONE_SIDE).all():
                joined = terminal.copy()
                joined[this], joined[that] = ON_ONE_SIDE, ON_THE_OTHER
                are_apart = beyond[that].all() and not beyond[this].any()
                made = beyond if are_apart else sides_of_least_cut(sides, price, joined)
                cuts.append((float(price[made[sides[0]] != made[sides[1]]].sum()), joined, made))
                if are_apart or not beyond.any():  # of the first two, either may be on either side
                    break
        if cuts:  # else a later seam separates them
            _, terminal, beyond = min(cuts, key=lambda cut: cut[0])
    crossed = part.cuttable_edges[beyond[between[0]] != beyond[between[1]]]
    seam: IntArray = part.vertices[part.topology.edges[crossed]]
    if len(part.topology.loops) > 1:
        return seam
    rings = [ring for ring in part.cut_along(seam) if len(ring.topology.loops) > 1]
    return np.concatenate([seam, *map(_between_loops, rings)])


def _links_along_rim(part: Submesh) -> IntArray:
    """The polygons at the boundary before and after each of its vertices, where a seam may end, (2, #B)."""
    topology = part.topology
    at = topology.sides[1] < 0
    (start, end), polygon = topology.edges[at].T, part.polygon_labels[topology.sides[0, at] % len(part.F)]
    before = np.empty(len(part.V), dtype=np.int64)
    before[end] = polygon
    return np.stack((before[start], polygon))


def _between_loops(ring: Submesh) -> IntArray:
    """The edges, by the caller's vertices, of the shortest ways between the boundary loops."""
    closed = ClosedSurface.of(ring)
    return ring.vertices[closed.edges[join_terminals(closed.graph, np.zeros(0, dtype=np.int64))]]


def _largest_overlaps(
    sides: IntArray, number: int, pairs: IntArray, most: int
) -> list[tuple[IntArray, IntArray]]:
    """The two sheets of each of the largest overlaps, by their polygons, of so many in the part."""
    begin, neighbour, _ = shortest_pairs(sides.T, np.zeros(len(sides[0])), number)
    code = np.sort(np.concatenate((pairs @ [number, 1], pairs @ [1, number])))
    upper, lower = np.divmod(code[np.append(True, code[1:] != code[:-1])], number)
    polygons, start = overlap_sheets(upper, lower, begin, neighbour, most)
    sheets = [polygons[i:j] for i, j in pairwise(start.tolist())]
    return list(zip(sheets[::2], sheets[1::2], strict=True))
