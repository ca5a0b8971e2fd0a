"""Seams that separate the overlapping parts of a flat map."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..._core import breadth_first_path, overlap_sheets, shortest_odd_walk, shortest_pairs
from ..._types import BoolArray, IntArray
from ...errors import MeshError, some
from ...surface import Submesh, check_planar, face_components
from ..features import CreasedSurface, box_sides

MAX_OVERLAPS = 6  # overlaps that one search separates; each doubles its graph
MAX_SEARCH_NODES = 1 << 19  # nodes of that graph
BARRIER_COST = 1e3  # factor on the price of edges within a sheet of an overlap
PART_COST = 0.1  # price of one more part as a share of the bounding box's diagonal


def separating_seams(V: ArrayLike, F: ArrayLike, pairs: ArrayLike) -> IntArray:
    """Short seams that separate the overlapping parts of a flat map.

    Each seam is a shortest path along edges of the surface, from boundary to boundary, with the two
    sheets of an overlap on different sides. If that is shorter, it runs from the boundary around
    one sheet and back to itself. Either way, one disk becomes two. The largest overlap comes first,
    until no pair of faces is left in one part. A part may overlap itself again when it is
    flattened: repeat until none does.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles. A chart with overlaps is a disk; charts without overlaps may be any surface.
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
    (27, array([[50, 51]]))
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
    return find_overlap_seams(charts, array)


def find_overlap_seams(charts: list[Submesh], pairs: IntArray) -> IntArray:
    """`separating_seams` of checked charts; faces and vertices are numbered as by the caller."""
    seams, _ = _separated(charts, pairs)
    return np.unique(np.concatenate([np.zeros((0, 2), dtype=np.int64), *seams]), axis=0)


def split_overlaps(chart: Submesh, pairs: IntArray, most: int = MAX_OVERLAPS) -> list[Submesh]:
    """Cut a chart along these seams; each search separates at most `most` overlaps."""
    return _separated([chart], pairs, most)[1]


def _separated(
    charts: list[Submesh], pairs: IntArray, most: int = MAX_OVERLAPS
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
            seams.append(np.sort(part.vertices[_shortest_seam(part, apart, most)], axis=1))
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
    """The edges (#E, 2) of the seams that separate the sheets of the largest overlaps; pairs of polygons."""
    search, doublings = _Search(part), int(np.log2(MAX_SEARCH_NODES / part.topology.n))
    overlaps = search.largest(pairs, min(most, max(1, doublings)))
    while not len(seam := search.seam(overlaps)):
        # three single faces over each other: no closed line crosses all three ways an odd number of times
        overlaps.pop()
    return seam


class _Overlap(NamedTuple):
    """The edges that a way from one of two sheets to the other crosses, and the edges in a sheet."""

    way: IntArray
    barred: IntArray


class _Search:
    """The graphs of a part in which seams are sought."""

    def __init__(self, part: Submesh) -> None:
        cell, inner = part.polygon_labels, part.cuttable_edges
        topology = part.topology
        self._m, self._n = int(cell.max()) + 1, topology.n
        sides = cell[topology.sides[:, inner] % len(part.F)].T  # the faces that such an edge separates
        self._dual = _Dual(*shortest_pairs(sides, np.zeros(len(inner)), self._m))
        edges = topology.edges[inner]
        # each boundary loop is one more vertex: a seam may end there, and another begin elsewhere on it
        rim = np.concatenate(topology.loops)
        loop = np.repeat(np.arange(len(topology.loops)), [len(vertices) for vertices in topology.loops])
        ends = np.concatenate((edges, np.column_stack((rim, topology.n + loop))))
        spoke = PART_COST * np.linalg.norm(box_sides(part.V)) / 2
        price = CreasedSurface(part).price[np.searchsorted(topology.inside, inner)]
        self._cost = np.append(price, np.full(len(rim), spoke))
        self._graph = shortest_pairs(ends, self._cost, topology.n + len(topology.loops))

    def largest(self, pairs: IntArray, most: int) -> list[_Overlap]:
        """Return at most `most` overlaps of pairs of polygons, the largest first."""
        m, dual = self._m, self._dual
        code = np.sort(np.concatenate((pairs @ [m, 1], pairs @ [1, m])))
        upper, lower = np.divmod(code[np.append(True, code[1:] != code[:-1])], m)
        faces, start = overlap_sheets(upper, lower, dual.begin, dual.neighbour, most)
        within, overlaps = np.zeros((2, m), dtype=bool), list[_Overlap]()
        sheets = [faces[i:j] for i, j in pairwise(start.tolist())]
        for one, other in zip(sheets[::2], sheets[1::2], strict=True):
            within[0, one], within[1, other] = True, True
            barred = np.append(dual.inside(one, within[0]), dual.inside(other, within[1]))
            overlaps.append(_Overlap(dual.edges_across_path(*within), barred))
            within[0, one], within[1, other] = False, False
        return overlaps

    def seam(self, overlaps: list[_Overlap]) -> IntArray:
        """The shortest that has the two sheets of each overlap on different sides; no edge if none does."""
        indptr, indices, edge = self._graph
        flip, cost = np.zeros(len(self._cost), dtype=np.int64), self._cost.copy()
        barred = np.concatenate([overlap.barred for overlap in overlaps])
        cost[barred] = BARRIER_COST * self._cost[barred]
        for k, overlap in enumerate(overlaps):
            flip[overlap.way] |= 1 << k
        # A closed line separates two sheets if it crosses the way from one to the other an odd number of
        # times. With a copy of the vertices for each combination of odd and even, and edges across a way
        # leading from copy to copy, it goes from a point to that point's all-odd copy.
        n, copies = len(indptr) - 1, 1 << len(overlaps)
        walk = shortest_odd_walk(indptr, indices, cost[edge], flip[edge], self._n, copies).tolist()
        path = np.array(_pruned(walk, n, self._n), dtype=np.int64)
        steps = np.column_stack((path[:-1], path[1:]))
        return np.asarray(steps[(steps < self._n).all(axis=1)])


def _pruned(walk: list[int], n: int, rim: int) -> list[int]:
    """The vertices of a walk over copies of n; `rim` and above are boundary loops.

    Where an arc runs around a sheet and back to itself, a second way from there to the
    boundary, of the same length as the first, is left out.
    """
    path, arc = [], []
    for node in walk:
        arc.append(node)
        if node % n < rim or len(arc) == 1:
            continue
        first: dict[int, int] = {}
        for end, vertex in enumerate(i % n for i in arc[1:-1]):
            begin = first.setdefault(vertex, end)
            if begin < end:
                tails = arc[0] // n ^ arc[1 + begin] // n ^ arc[1 + end] // n ^ arc[-1] // n
                if not tails:
                    arc = [*arc[: end + 2], arc[-1]]
                    break
        path += [i % n for i in arc[:-1]]
        if len(first) < len(arc) - 2:
            path.append(rim)
        arc = [node]
    return [*path, walk[-1] % n]


class _Dual(NamedTuple):
    """The faces beside each face, as in CSR, with the edges between."""

    begin: IntArray
    neighbour: IntArray
    edge: IntArray

    def edges_across_path(self, one: BoolArray, other: BoolArray) -> IntArray:
        """Return the edges that a shortest path between two sheets crosses; both are masks of faces."""
        way = breadth_first_path(self.begin, self.neighbour, one, other)
        at, of = self._around(way[:-1])
        return np.asarray(self.edge[at[self.neighbour[at] == way[1:][of]]])

    def inside(self, faces: IntArray, within: BoolArray) -> IntArray:
        """The edges between two of some faces, which are also given as a mask; each twice."""
        at, _ = self._around(faces)
        return np.asarray(self.edge[at[within[self.neighbour[at]]]])

    def _around(self, faces: IntArray) -> tuple[IntArray, IntArray]:
        """Return the entries of some faces, and the face of each entry."""
        number = self.begin[faces + 1] - self.begin[faces]
        of = np.repeat(np.arange(len(faces)), number)
        return (self.begin[faces] - np.cumsum(number) + number)[of] + np.arange(len(of)), of
