"""Search the graph of a closed surface for shortest paths and trees, and compute the topology of seams."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from ..._core import (
    cut_topology,
    nearest_sources,
    path_nodes,
    prune_leaves,
    shortest_edges,
    spanning_forest,
    steiner_paths,
)
from ..._types import BoolArray, FloatArray, IntArray

Terminals = tuple[IntArray, IntArray, IntArray]  # three sets of nodes; one path starts in each set
SeamTopology = tuple[int, int, int]  # numbers of components, cycles and pieces, see `find_seam_topology`


@dataclass(frozen=True, eq=False)
class SurfaceGraph:
    """A graph on a closed surface that divides it into polygons. A seam is an array of edges.

    Attributes
    ----------
    n, n_holes, genus, n_faces : int
        Numbers of nodes, of holes (which are the first nodes), of handles and of faces.
    ends, faces : (#E, 2) int64
        The nodes and the faces at each edge.
    length : (#E,) float64
        The price of a seam along each edge, in units of length.
    position : (n, 3) float64
        The position of each node; for a hole, the position of any of its vertices.
    """

    n: int
    n_holes: int
    genus: int
    n_faces: int
    ends: IntArray
    faces: IntArray
    length: FloatArray
    position: FloatArray

    @cached_property
    def adjacency(self) -> tuple[sparse.csr_array, IntArray]:
        """Sparse matrix of the shortest edge's length between nodes, (n, n), and the edge of each entry."""
        indptr, indices, edge = shortest_edges(self.ends, self.length, self.n)
        return sparse.csr_array((self.length[edge], indices, indptr), shape=(self.n, self.n)), edge

    @cached_property
    def nodes_near_holes(self) -> IntArray:
        """The nodes of the edges at holes, ascending."""
        return np.unique(self.ends[(self.ends < self.n_holes).any(axis=1)])

    @cached_property
    def adjacent_pairs(self) -> tuple[IntArray, IntArray]:
        """The keys i * n + j of the pairs of adjacent nodes i < j, ascending, and their shortest edges."""
        matrix, edge = self.adjacency
        row, column = np.repeat(np.arange(self.n), np.diff(matrix.indptr)), matrix.indices
        upper = row < column
        return row[upper] * self.n + column[upper], edge[upper]

    def find_edges_between(self, i: IntArray, j: IntArray) -> IntArray:
        """Return the shortest edge between each pair of adjacent nodes."""
        code, edge = self.adjacent_pairs
        return edge[np.searchsorted(code, np.minimum(i, j) * self.n + np.maximum(i, j))]

    def find_shortest_paths(
        self, sources: IntArray, avoid: IntArray | BoolArray | None = None, limit: float = np.inf
    ) -> tuple[FloatArray, IntArray, IntArray]:
        """Return each node's distance to the nearest source, its predecessor on the path, and the source.

        `avoid` are the nodes that paths may not pass, or a mask of them.
        """
        is_open = np.ones(self.n, dtype=bool)
        if avoid is not None:
            is_open[avoid] = False
            is_open[sources] = True
        matrix = self.adjacency[0]
        return nearest_sources(matrix.indptr, matrix.indices, matrix.data, sources, is_open, limit)

    def find_edges_on_paths(self, before: IntArray, ends: IntArray | list[int]) -> IntArray:
        """Return the edges, each once, on the shortest paths from the nodes `ends` to their sources."""
        nodes = path_nodes(before, np.asarray(ends, dtype=np.int64))
        return self.find_edges_between(nodes, before[nodes])

    def find_steiner_tree(
        self, terminals: Terminals, avoid: IntArray | None, limit: float
    ) -> tuple[int, IntArray]:
        """Return the node with the least total distance to three sets of nodes, and the edges of its paths.

        The node is -1 if the total exceeds `limit`. No path passes the nodes `avoid`.
        """
        is_open = np.ones(self.n, dtype=bool)
        if avoid is not None:
            is_open[avoid] = False
        matrix = self.adjacency[0]
        nodes, start = steiner_paths(matrix.indptr, matrix.indices, matrix.data, terminals, is_open, limit)
        if not len(nodes):
            return -1, nodes
        on = np.ones(len(nodes), dtype=bool)
        on[start[1:] - 1] = False  # exclude the last node of each path
        on = np.flatnonzero(on)
        return int(nodes[0]), self.find_edges_between(nodes[on], nodes[on + 1])

    def find_boundary_nodes(self, seam: IntArray) -> IntArray:
        """Return the boundary nodes after a cut along a seam: nodes of the seam and of the holes."""
        passed = np.zeros(self.n, dtype=bool)
        passed[: self.n_holes], passed[self.ends[seam]] = True, True
        return np.flatnonzero(passed)

    def mask_edges(self, seam: IntArray) -> BoolArray:
        """Return a mask of the edges of a seam, (#E,) bool."""
        mask = np.zeros(len(self.ends), dtype=bool)
        mask[seam] = True
        return mask

    def unite_seams(self, *seams: IntArray) -> IntArray:
        """Return the edges of several seams, each once, ascending."""
        return np.flatnonzero(self.mask_edges(np.concatenate(seams)))

    def subtract_seam(self, seam: IntArray, others: IntArray) -> IntArray:
        """Return the edges of a seam that are not in `others`, in the order of the seam."""
        return seam[~self.mask_edges(others)[seam]]

    def measure_length(self, seam: IntArray) -> float:
        """Return the total length of the edges of a seam."""
        return float(self.length[seam].sum())

    def find_topology_and_sizes(self, seam: IntArray) -> tuple[int, int, IntArray]:
        """Return the topology of a seam, and the sizes of the pieces of the surface cut along the seam.

        Returns
        -------
        n_components, n_cycles : int
            Numbers of components and cycles of the graph that consists of the seam's edges and the holes.
        sizes : (#pieces,) int64
            The number of faces of each piece, ascending.
        """
        return cut_topology(self.ends, self.faces, seam, self.n_holes, self.n, self.n_faces)

    def find_seam_topology(self, seam: IntArray) -> SeamTopology:
        """Return the numbers of components and cycles of a seam, and the number of pieces that it leaves.

        Holes count as parts of the seam. If two seams have the same three numbers, and one of them cuts the
        surface into disks, the other one does, too.
        """
        number, cycles, sizes = self.find_topology_and_sizes(seam)
        return number, cycles, len(sizes)


def prune_stubs(graph: SurfaceGraph, seam: IntArray, tips: IntArray) -> IntArray:
    """Remove the arcs that end at a leaf, repeatedly. Leaves in `tips` are kept."""
    kept = np.zeros(graph.n, dtype=bool)
    kept[tips] = True
    return seam[prune_leaves(graph.ends[seam], kept)]


def join_terminals(
    graph: SurfaceGraph, seam: IntArray, others: IntArray | None = None, uncut: IntArray | None = None
) -> IntArray:
    """Join the holes, the nodes `others` and the seam by a tree of shortest paths.

    It is a minimum spanning tree of their mutual distances. The holes `uncut` are not joined.
    """
    passed = np.zeros(graph.n, dtype=bool)
    passed[graph.ends[seam]] = True
    on_seam = np.flatnonzero(passed)
    holes = np.arange(graph.n_holes)
    passed[holes if uncut is None else np.setdiff1d(holes, uncut)] = True
    if others is not None:
        passed[others] = True
    terminals = np.flatnonzero(passed)
    if len(terminals) == 0:
        return seam
    distance, before, source = graph.find_shortest_paths(terminals)
    group = np.arange(graph.n)
    group[on_seam] = on_seam.min(initial=graph.n)
    ends = group[np.maximum(source, 0)[graph.ends]]  # source is -1 in components without terminals
    way = distance[graph.ends].sum(axis=1) + graph.length
    between = np.flatnonzero(ends[:, 0] != ends[:, 1])
    bridge = spanning_forest(ends, between[np.argsort(way[between], kind="stable")], graph.n)
    paths = graph.find_edges_on_paths(before, graph.ends[bridge].ravel())
    return np.concatenate((seam, graph.subtract_seam(graph.unite_seams(bridge, paths), seam)))
