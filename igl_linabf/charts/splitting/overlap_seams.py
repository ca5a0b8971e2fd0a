"""Find seams that separate the overlapping parts of a flat map."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..._core import breadth_first_path, overlap_sheets, shortest_edges, shortest_odd_walk
from ..._types import BoolArray, IntArray
from ...errors import MeshError, first_few
from ...surface import Submesh, check_planar, label_face_components
from ..features import CreasedSurface, measure_bounding_box

MAX_OVERLAPS = 6  # one search separates up to this many overlaps; each one doubles the search graph
MAX_SEARCH_NODES = 1 << 19  # maximum number of nodes of the search graph
BARRIER_COST = 1e3  # factor on the price of seam edges inside an overlap, which seams should pass around
PART_COST = 0.1  # price of an additional part, relative to the diagonal of the bounding box


def find_separating_seams(V: ArrayLike, F: ArrayLike, pairs: ArrayLike) -> IntArray:
    """Find short seams that separate the overlapping parts of a flat map.

    An overlap consists of two *sheets*: connected regions of faces that cover the same place in the map. Each
    seam is a shortest path along edges of the surface, from boundary to boundary, that has the two sheets of
    an overlap on different sides. A seam from the boundary around one sheet and back to itself is used if it
    is shorter. In both cases one disk becomes two disks. The largest overlaps are separated first, until the
    two faces of each pair are in different parts. A part may overlap itself again after it has been
    flattened. In this case, call the function again.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles. A chart with overlaps is a disk; charts without overlaps may be any surface.
    pairs : (#P, 2) int
        The pairs that `overlaps(uv, F)` returns. The two faces of each pair belong to the same chart.

    Returns
    -------
    seams : (#E, 2) int64
        Edges to cut along, as vertices i < j, in lexicographic order.

    Raises
    ------
    MeshError
        The arrays do not fit together, a pair is not two different faces of the same chart, or a chart with
        overlaps is not an oriented manifold disk.

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
    >>> len(pairs), find_separating_seams(V, F, pairs)
    (27, array([[50, 51]]))
    """
    surface = Submesh.from_input(V, F)
    array = _check_pairs(pairs, len(surface.F))
    chart = label_face_components(surface.F, len(surface.V))
    strangers = np.flatnonzero(chart[array[:, 0]] != chart[array[:, 1]])
    if len(strangers):
        raise MeshError(
            f"pairs {first_few(strangers)} are faces of two charts (the first: faces "
            f"{array[strangers[0]].tolist()}): leave these pairs out, and move the charts apart"
        )
    charts = [surface.select_faces(np.flatnonzero(chart == i)) for i in np.unique(chart[array[:, 0]])]
    return find_overlap_seams(charts, array)


def find_overlap_seams(charts: list[Submesh], pairs: IntArray) -> IntArray:
    """Return the seams of `find_separating_seams` for checked charts, given by input vertices; `pairs` has "
    "input faces."""
    seams, _ = _cut_between_overlaps(charts, pairs)
    return np.unique(np.concatenate([np.zeros((0, 2), dtype=np.int64), *seams]), axis=0)


def split_overlaps(chart: Submesh, pairs: IntArray, most: int = MAX_OVERLAPS) -> list[Submesh]:
    """Cut a chart along the seams of `find_separating_seams`; each search separates at most `most` "
    "overlaps."""
    return _cut_between_overlaps([chart], pairs, most)[1]


def _cut_between_overlaps(
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
            apart = apart[apart[:, 0] != apart[:, 1]]  # seams cannot separate triangles of the same polygon
        if len(apart):
            check_planar(part.topology, part.vertices)
            seams.append(np.sort(part.vertices[_find_shortest_seam(part, apart, most)], axis=1))
            waiting += _distribute_pairs(part, part.cut_along(seams[-1]), local)
        else:
            parts.append(part)
    return seams, sorted(parts, key=lambda part: int(part.faces[0]))


def _distribute_pairs(
    whole: Submesh, parts: list[Submesh], pairs: IntArray
) -> list[tuple[Submesh, IntArray]]:
    """Return each part of `whole` with the pairs whose two faces are in the part, as faces of the part."""
    of, row = np.empty(len(whole.F), dtype=np.int64), np.empty(len(whole.F), dtype=np.int64)
    for k, part in enumerate(parts):
        rows = np.searchsorted(whole.faces, part.faces)
        of[rows], row[rows] = k, np.arange(len(rows))
    label = of[pairs]
    pairs, label = row[pairs[same := label[:, 0] == label[:, 1]]], label[same, 0]
    order = np.argsort(label, kind="stable")
    start = np.searchsorted(label[order], np.arange(len(parts) + 1)).tolist()
    return [(part, pairs[order[i:j]]) for part, (i, j) in zip(parts, pairwise(start), strict=True)]


def _check_pairs(pairs: ArrayLike, m: int) -> IntArray:
    """Check `pairs` and return it as a (#P, 2) int64 array."""
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
            f"pairs {first_few(bad)} are not two different faces within 0..{m - 1} (the first: "
            f"{array[bad[0]].tolist()}): pass what overlaps returned for the same F"
        )
    return array


def _find_shortest_seam(part: Submesh, pairs: IntArray, most: int) -> IntArray:
    """Return seam edges, (#E, 2), that separate the largest overlaps formed by the `pairs` of polygons."""
    search, doublings = _Search(part), int(np.log2(MAX_SEARCH_NODES / part.topology.n))
    overlaps = search.find_largest_overlaps(pairs, min(most, max(1, doublings)))
    while not len(seam := search.find_seam(overlaps)):
        # No single seam separates three mutually overlapping faces, because no closed curve crosses
        # all three paths between the faces an odd number of times.
        overlaps.pop()
    return seam


class _Overlap(NamedTuple):
    """The edges that a path between the two sheets of an overlap crosses, and the edges in the sheets."""

    way: IntArray
    barred: IntArray


class _Search:
    """The search for seams in a part, on the part's edge graph and on the dual graph of its polygons."""

    def __init__(self, part: Submesh) -> None:
        cell, inner = part.polygon_labels, part.cuttable_edges
        topology = part.topology
        self._m, self._n = int(cell.max()) + 1, topology.n
        sides = cell[topology.sides[:, inner] % len(part.F)].T  # polygons on both sides of each inner edge
        self._dual = _Dual(*shortest_edges(sides, np.zeros(len(inner)), self._m))
        edges = topology.edges[inner]
        # an additional vertex per boundary loop connects all its vertices: a seam may leave the loop anywhere
        rim = np.concatenate(topology.loops)
        loop = np.repeat(np.arange(len(topology.loops)), [len(vertices) for vertices in topology.loops])
        ends = np.concatenate((edges, np.column_stack((rim, topology.n + loop))))
        spoke = PART_COST * np.linalg.norm(measure_bounding_box(part.V)) / 2
        price = CreasedSurface(part).edge_price[np.searchsorted(topology.interior_edges, inner)]
        self._cost = np.append(price, np.full(len(rim), spoke))
        self._graph = shortest_edges(ends, self._cost, topology.n + len(topology.loops))

    def find_largest_overlaps(self, pairs: IntArray, most: int) -> list[_Overlap]:
        """Return the overlaps that the pairs of polygons form, largest first, at most `most`."""
        m, dual = self._m, self._dual
        code = np.sort(np.concatenate((pairs @ [m, 1], pairs @ [1, m])))
        upper, lower = np.divmod(code[np.append(True, code[1:] != code[:-1])], m)
        faces, start = overlap_sheets(upper, lower, dual.begin, dual.neighbour, most)
        within, overlaps = np.zeros((2, m), dtype=bool), list[_Overlap]()
        sheets = [faces[i:j] for i, j in pairwise(start.tolist())]
        for one, other in zip(sheets[::2], sheets[1::2], strict=True):
            within[0, one], within[1, other] = True, True
            barred = np.append(
                dual.find_edges_within(one, within[0]), dual.find_edges_within(other, within[1])
            )
            overlaps.append(_Overlap(dual.find_edges_across_path(*within), barred))
            within[0, one], within[1, other] = False, False
        return overlaps

    def find_seam(self, overlaps: list[_Overlap]) -> IntArray:
        """Return the edges of the shortest seam that separates all overlaps; empty if none exists."""
        indptr, indices, edge = self._graph
        flip, cost = np.zeros(len(self._cost), dtype=np.int64), self._cost.copy()
        barred = np.concatenate([overlap.barred for overlap in overlaps])
        cost[barred] = BARRIER_COST * self._cost[barred]
        for k, overlap in enumerate(overlaps):
            flip[overlap.way] |= 1 << k
        # A closed curve separates two sheets if it crosses the path between them an odd number of times.
        # The search graph has a copy of the vertices for each combination of parities.
        # An edge that crosses a path leads to the copy with the flipped parity of this path.
        # Therefore a seam that separates all overlaps is a walk from a vertex to its copy with odd parities.
        n, copies = len(indptr) - 1, 1 << len(overlaps)
        walk = shortest_odd_walk(indptr, indices, cost[edge], flip[edge], self._n, copies).tolist()
        path = np.array(_prune_walk(walk, n, self._n), dtype=np.int64)
        steps = np.column_stack((path[:-1], path[1:]))
        return np.asarray(steps[(steps < self._n).all(axis=1)])


def _prune_walk(walk: list[int], n: int, rim: int) -> list[int]:
    """Return the vertices of a walk over copies of n vertices; the indices from `rim` on are boundary loops.

    If an arc runs from the boundary around a sheet and back to itself, the walk returns to the boundary
    along a second path of equal length. This second path is removed.
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
    """The adjacent faces of each face, and the edges between them, in CSR format."""

    begin: IntArray
    neighbour: IntArray
    edge: IntArray

    def find_edges_across_path(self, one: BoolArray, other: BoolArray) -> IntArray:
        """Return the edges crossed by a shortest path between two sheets, which are masks of faces."""
        way = breadth_first_path(self.begin, self.neighbour, one, other)
        at, of = self._find_entries(way[:-1])
        return np.asarray(self.edge[at[self.neighbour[at] == way[1:][of]]])

    def find_edges_within(self, faces: IntArray, within: BoolArray) -> IntArray:
        """Return the edges between two of the given faces, each twice; `within` is a mask of the faces."""
        at, _ = self._find_entries(faces)
        return np.asarray(self.edge[at[within[self.neighbour[at]]]])

    def _find_entries(self, faces: IntArray) -> tuple[IntArray, IntArray]:
        """Return the CSR entries of the given faces, and the position in `faces` for each entry."""
        number = self.begin[faces + 1] - self.begin[faces]
        of = np.repeat(np.arange(len(faces)), number)
        return (self.begin[faces] - np.cumsum(number) + number)[of] + np.arange(len(of)), of
