"""Cut graphs: edges along which a component opens to a disk, and how to shorten them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial

import numpy as np
from scipy import sparse

from ..._core import (
    lengths,
    meeting,
    nearest_sources,
    nodes_on_paths,
    shortest_pairs,
    spanning_forest,
    without_leaves,
)
from ..._core import opened as opened_by
from ..._types import BoolArray, FloatArray, IntArray
from ...surface import Submesh, sum_by
from ..features import Smoothing, all_bends, angle_noise, sharpness, shown, valleys
from .laplacians import ZeroAtNodes, laplacian_of

CREASE_DISCOUNT = 0.5  # share of its length that an edge along a bend of a right angle or more is shorter by
SMALLEST_WEIGHT = 1e-3  # of an edge's cotangent: the maximum principle then holds
LARGEST_WEIGHT = 1e6  # of a needle's: beside larger ones double precision would not see the others
FIRST_BASES = 4  # base points for the loops around handles, far from each other
MOST_BASES = 6  # of a round, evenly along the loops
BASE_ROUNDS = 3  # of such points
SHORTER = 1 - 1e-9  # times a length: what is shorter by less is equal

Sources = tuple[IntArray, IntArray, IntArray]  # three sets of nodes
Loops = tuple[IntArray, IntArray]  # a cut graph, and the edges in the middle of its loops
Shape = tuple[int, int, int]  # what a seam goes on to be when it moves


@dataclass(frozen=True, eq=False)
class ClosedSurface:
    """A component as a closed surface: each boundary loop is contracted to a node of its own.

    A graph on it whose complement is a disk also cuts the component to a disk, wherever it meets
    the boundary. So holes need no special treatment.

    Attributes
    ----------
    n, holes, genus, n_faces : int
        Numbers of nodes, of those (the first ones) that are loops, of handles and faces.
    node : (#V,) int64
        The node of each vertex. Interior vertices keep their order.
    edges, ends, faces : (#E, 2) int64
        Vertices, nodes and faces at each edge that has two faces. Diagonals of polygons are no edges, and
        the triangles of a polygon are one face.
    true_length, length : (#E,) float64
        Of the edges; and shorter where a seam shows less: at creases, and where it is hidden.
    shown : (#E,) float64
        By what hiding multiplies the lengths.
    valleys : callable
        By what valleys multiply those lengths by which arcs are rerouted in the end, (#E,): few need it.
    sharp : (#E,) float64
        From 0 for no crease to 1 for a sharp one.
    graph : (n, n) sparse
        The shortest edge between each two nodes.
    entry : (nnz,) int64
        This edge, for each entry of `graph`.
    curvature, noise, area : (n,) float64
        Angle defects, what rounding adds to them, and vertex areas.
    bonds : (#B, 2) int64
        The nodes that the Laplacian joins: the ends of the edges, and of the diagonals of polygons.
    cotangent, weight : (#B,) float64
        Of them there: half the sum of the cotangents; and the same, raised to a positive number.
    position : (n, 3) float64
        Of each node; that of a loop is any of its vertices.
    size : float
        Square root of the area.
    isometric : bool
        Whether the map is to keep lengths, not angles.
    """

    n: int
    holes: int
    genus: int
    n_faces: int
    node: IntArray
    edges: IntArray
    ends: IntArray
    faces: IntArray
    true_length: FloatArray
    length: FloatArray
    shown: FloatArray
    valleys: Callable[[], FloatArray]
    sharp: FloatArray
    graph: sparse.csr_array
    entry: IntArray
    curvature: FloatArray
    noise: FloatArray
    area: FloatArray
    bonds: IntArray
    cotangent: FloatArray
    weight: FloatArray
    position: FloatArray
    size: float
    isometric: bool = False

    @cached_property
    def _pairs(self) -> tuple[IntArray, IntArray]:
        row, column = np.repeat(np.arange(self.n), np.diff(self.graph.indptr)), self.graph.indices
        upper = row < column
        return row[upper] * self.n + column[upper], self.entry[upper]

    @property
    def key(self) -> IntArray:
        """Of each two neighbouring nodes i < j: i n + j, ascending."""
        return self._pairs[0]

    @property
    def shortest(self) -> IntArray:
        """The shortest edge between these two."""
        return self._pairs[1]

    @cached_property
    def laplacian(self) -> sparse.csc_array:
        """Its lower triangle, (n, n)."""
        return laplacian_of(self.bonds, self.weight, self.n)

    @cached_property
    def zero_at_nodes(self) -> ZeroAtNodes:
        """Solves Laplace systems."""
        return ZeroAtNodes(self.laplacian)

    @property
    def thin_share(self) -> float:
        """Share of the bonds whose cotangents sum to zero or less: their triangles are thin."""
        return float(np.mean(self.cotangent <= 0)) if len(self.cotangent) else 0.0

    @cached_property
    def zero_by_cotangents(self) -> ZeroAtNodes:
        """The same of the cotangents themselves, as far as double precision holds them."""
        if not (np.abs(self.cotangent) < LARGEST_WEIGHT).all():
            return self.zero_at_nodes
        return self.zero_at_nodes.of(laplacian_of(self.bonds, self.cotangent, self.n))

    @cached_property
    def valley(self) -> FloatArray:
        """(#E,): less than 1 in concave valleys."""
        return self.valleys()

    @cached_property
    def hides(self) -> bool:
        """Whether some seams are better hidden than others."""
        return bool((self.shown != 1).any())

    @cached_property
    def seen(self) -> FloatArray:
        """By what hiding multiplies lengths on average at each node, (n,)."""
        ends = self.ends.ravel()
        total, number = (
            np.bincount(ends, np.repeat(self.shown, 2), self.n),
            np.bincount(ends, minlength=self.n),
        )
        return np.where(number, total, 1.0) / np.maximum(number, 1)

    def with_lengths(self, length: FloatArray) -> ClosedSurface:
        """The same with other lengths of its edges."""
        graph, entry = shortest_edges(self.ends, length, self.n)
        return replace(self, length=length, graph=graph, entry=entry)

    def between(self, i: IntArray, j: IntArray) -> IntArray:
        """The shortest edges between neighbouring nodes."""
        return self.shortest[np.searchsorted(self.key, np.minimum(i, j) * self.n + np.maximum(i, j))]

    def search(
        self, sources: IntArray, avoid: IntArray | BoolArray | None = None, limit: float = np.inf
    ) -> tuple[FloatArray, IntArray, IntArray]:
        """The distance of each node to the nearest source, the node before it on the path, that source.

        `avoid` are nodes, or a mask of them.
        """
        open_ = np.ones(self.n, dtype=bool)
        if avoid is not None:
            open_[avoid] = False
            open_[sources] = True
        graph = self.graph
        return nearest_sources(graph.indptr, graph.indices, graph.data, sources, open_, limit)

    def meeting(self, sets: Sources, avoid: IntArray | None, limit: float) -> tuple[int, IntArray]:
        """The node where ways to three sets are shortest in total, -1 if over the limit; their edges.

        `avoid` are nodes that no way passes.
        """
        open_ = np.ones(self.n, dtype=bool)
        if avoid is not None:
            open_[avoid] = False
        graph = self.graph
        nodes, start = meeting(graph.indptr, graph.indices, graph.data, sets, open_, limit)
        if not len(nodes):
            return -1, nodes
        on = np.ones(len(nodes), dtype=bool)
        on[start[1:] - 1] = False  # the last node of each way
        on = np.flatnonzero(on)
        return int(nodes[0]), self.between(nodes[on], nodes[on + 1])

    def paths(self, before: IntArray, ends: IntArray | list[int]) -> IntArray:
        """The edges on the shortest paths from some nodes to their sources, each once."""
        nodes = nodes_on_paths(before, np.asarray(ends, dtype=np.int64))
        return self.between(nodes, before[nodes])

    def on(self, seam: IntArray) -> IntArray:
        """The nodes on a seam, and the holes."""
        passed = np.zeros(self.n, dtype=bool)
        passed[: self.holes], passed[self.ends[seam]] = True, True
        return np.flatnonzero(passed)

    def together(self, *seams: IntArray) -> IntArray:
        """The edges of some seams, each once, ascending."""
        taken = np.zeros(len(self.ends), dtype=bool)
        for seam in seams:
            taken[seam] = True
        return np.flatnonzero(taken)

    def without(self, seam: IntArray, others: IntArray) -> IntArray:
        """The edges of a seam that are not among others."""
        kept = np.ones(len(self.ends), dtype=bool)
        kept[others] = False
        return seam[kept[seam]]

    def total(self, seam: IntArray) -> float:
        return float(self.length[seam].sum())


def closed_surface(
    component: Submesh,
    hidden: FloatArray | None = None,
    isometric: bool = False,
    bend: FloatArray | None = None,
) -> ClosedSurface:
    """Contract the boundary loops of a surface in one piece.

    `hidden` is as `hiding` returns it; `bend` are the `all_bends`, if they are known.
    """
    V, topology = component.V, component.topology
    holes = len(topology.loops)
    node = np.full(len(V), -1)
    for i, loop in enumerate(topology.loops):
        node[loop] = i
    n = holes + int(np.count_nonzero(node < 0))
    node[node < 0] = np.arange(holes, n)
    cell, inside = component.polygon_labels, component.cuttable_edges
    edges, beside = topology.edges_inside, topology.faces_inside
    every, bend = topology.inside, all_bends(component) if bend is None else bend
    if component.inner is not None:
        taken = np.searchsorted(every, inside)
        edges, beside, bend = edges[taken], cell[beside[taken]], bend[taken]
    ends, every_length = node[edges], lengths(V, topology.edges)
    true_length = every_length[inside]
    length = seam_lengths(true_length, bend)
    double_area, dot = component.measured
    size = float(np.sqrt(double_area.sum() / 2))
    smoothing = cache(partial(Smoothing, component, edges, true_length))
    visible = np.ones(len(edges)) if hidden is None else shown(component, edges, hidden, smoothing(), size)
    length *= visible
    graph, entry = shortest_edges(ends, length, n)
    corner = node[topology.corner]
    vertex = np.empty(n, dtype=np.int64)
    vertex[node] = np.arange(len(V))
    cotangent = topology.sum_at_edges(dot / double_area)[every] / 2
    return ClosedSurface(
        n=n,
        holes=holes,
        genus=topology.genus,
        n_faces=int(cell.max()) + 1,
        node=node,
        edges=edges,
        ends=ends,
        faces=beside,
        true_length=true_length,
        length=length,
        shown=visible,
        valleys=lambda: valleys(component, edges, true_length, bend, smoothing(), size),
        sharp=sharpness(bend),
        graph=graph,
        entry=entry,
        curvature=np.asarray(2 * np.pi - np.bincount(node, component.angle_sums, n)),
        noise=angle_noise(component, every_length, node, n),
        area=sum_by(corner.ravel(), np.tile(double_area / 6, 3), n),
        bonds=node[topology.edges_inside],
        cotangent=cotangent,
        weight=np.clip(cotangent, SMALLEST_WEIGHT, LARGEST_WEIGHT),
        position=V[vertex],
        size=size,
        isometric=isometric,
    )


def seam_lengths(length: FloatArray, bend: FloatArray) -> FloatArray:
    """The lengths of edges for a seam, which shows less along bends."""
    return np.asarray(length * (1 - CREASE_DISCOUNT * np.minimum(np.abs(bend) / (np.pi / 2), 1)))


def open_handles(piece: ClosedSurface, rounds: int = BASE_ROUNDS) -> IntArray:
    """The shortest cut graph made of loops through one point, over several base points."""
    bases, tried = [int(np.argmax(np.abs(piece.curvature)))], set[int]()
    while len(bases) < FIRST_BASES:
        bases.append(int(np.argmax(piece.search(np.array(bases))[0])))
    best = shortest_loops(piece, bases)
    for _ in range(rounds - 1):
        tried.update(bases)
        # a loop is short as seen from a point on it
        bases = sorted(set(piece.ends[best[1]].ravel().tolist()) - tried)
        bases = bases[:: -(-len(bases) // MOST_BASES) or 1]
        best = shortest_loops(piece, bases, best)
    return best[0]


def shortest_loops(piece: ClosedSurface, bases: list[int], best: Loops | None = None) -> Loops:
    """The shortest of the cut graphs of loops through each base point, and of one that is known."""
    for base in bases:
        loops = _loops(piece, base)
        if best is None or piece.total(loops[0]) < piece.total(best[0]) * SHORTER:
            best = loops
    assert best is not None
    return best


def _loops(piece: ClosedSurface, base: int) -> Loops:
    """The cut graph of the shortest loops through `base`, and the edges in their middle."""
    distance, before, _ = piece.search(np.array([base]))
    a, b = piece.ends[piece.shortest].T
    in_tree = np.zeros(len(piece.edges), dtype=bool)
    in_tree[piece.shortest] = (before[a] == b) | (before[b] == a)
    loop = distance[piece.ends[:, 0]] + distance[piece.ends[:, 1]] + piece.length
    outside = np.flatnonzero(~in_tree)
    in_cotree = np.zeros(len(piece.edges), dtype=bool)
    longest_first = outside[np.argsort(-loop[outside], kind="stable")]
    in_cotree[spanning_forest(piece.faces, longest_first, piece.n_faces)] = True
    across = np.flatnonzero(~in_tree & ~in_cotree)
    seam = piece.together(across, piece.paths(before, piece.ends[across].ravel()))
    return without_stubs(piece, seam, seam[:0]), across  # what all loops share on their way to the base


def without_stubs(piece: ClosedSurface, seam: IntArray, tips: IntArray) -> IntArray:
    """The seam without arcs that end at other nodes than these."""
    kept = np.zeros(piece.n, dtype=bool)
    kept[tips] = True
    return seam[without_leaves(piece.ends[seam], kept)]


def join(piece: ClosedSurface, seam: IntArray, others: IntArray | None = None) -> IntArray:
    """Join the holes, other nodes and the seam by a minimum spanning tree of shortest paths between them."""
    passed = np.zeros(piece.n, dtype=bool)
    passed[piece.ends[seam]] = True
    on_seam = np.flatnonzero(passed)
    passed[: piece.holes] = True
    if others is not None:
        passed[others] = True
    terminals = np.flatnonzero(passed)
    if len(terminals) == 0:
        return seam
    distance, before, source = piece.search(terminals)
    group = np.arange(piece.n)
    group[on_seam] = on_seam.min(initial=piece.n)
    ends = group[np.maximum(source, 0)[piece.ends]]  # a body without any of them has no source
    way = distance[piece.ends].sum(axis=1) + piece.length
    between = np.flatnonzero(ends[:, 0] != ends[:, 1])
    bridge = spanning_forest(ends, between[np.argsort(way[between], kind="stable")], piece.n)
    paths = piece.paths(before, piece.ends[bridge].ravel())
    return np.concatenate((seam, piece.without(piece.together(bridge, paths), seam)))


def shape(piece: ClosedSurface, seam: IntArray) -> Shape:
    """Numbers of components and cycles of the seam with the holes, and of pieces that the surface falls into.

    The pieces are disks for one seam of a shape if they are for another one.
    """
    number, cycles, sizes = opened(piece, seam)
    return number, cycles, len(sizes)


def opened(piece: ClosedSurface, seam: IntArray) -> tuple[int, int, IntArray]:
    """`shape`, with the numbers of faces of the pieces, ascending."""
    return opened_by(piece.ends, piece.faces, seam, piece.holes, piece.n, piece.n_faces)


def shortest_edges(ends: IntArray, length: FloatArray, n: int) -> tuple[sparse.csr_array, IntArray]:
    """The shortest edge between each two nodes, as a graph; and this edge, for each of its entries."""
    indptr, indices, edge = shortest_pairs(ends, length, n)
    return sparse.csr_array((length[edge], indices, indptr), shape=(n, n)), edge
