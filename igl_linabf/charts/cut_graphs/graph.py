"""The graph of a closed surface: shortest paths on it, trees between its nodes, and what a seam opens."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from ..._core import meeting, nearest_sources, nodes_on_paths, opened, shortest_pairs, spanning_forest
from ..._core import without_leaves as without_leaf_edges
from ..._types import BoolArray, FloatArray, IntArray

Terminals = tuple[IntArray, IntArray, IntArray]  # three sets of nodes
SeamTopology = tuple[int, int, int]  # what a seam goes on to be when it moves


@dataclass(frozen=True, eq=False)
class SurfaceGraph:
    """A graph on a closed surface that cuts it into polygons. A seam is an array of its edges.

    Attributes
    ----------
    n, n_holes, genus, n_faces : int
        Numbers of nodes, of those (the first ones) that are holes, of handles and faces.
    ends, faces : (#E, 2) int64
        The nodes and the faces at each edge.
    length : (#E,) float64
        Of each edge, as a seam along it counts.
    position : (n, 3) float64
        Of each node; that of a hole is any of its vertices.
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
        """The length of the shortest edge between each two nodes, (n, n); and this edge, for each entry."""
        indptr, indices, edge = shortest_pairs(self.ends, self.length, self.n)
        return sparse.csr_array((self.length[edge], indices, indptr), shape=(self.n, self.n)), edge

    @cached_property
    def neighbours(self) -> tuple[IntArray, IntArray]:
        """Of each two neighbouring nodes i < j: i n + j, ascending; and the shortest edge between them."""
        matrix, edge = self.adjacency
        row, column = np.repeat(np.arange(self.n), np.diff(matrix.indptr)), matrix.indices
        upper = row < column
        return row[upper] * self.n + column[upper], edge[upper]

    def edges_between(self, i: IntArray, j: IntArray) -> IntArray:
        """The shortest edges between neighbouring nodes."""
        code, edge = self.neighbours
        return edge[np.searchsorted(code, np.minimum(i, j) * self.n + np.maximum(i, j))]

    def shortest_paths(
        self, sources: IntArray, avoid: IntArray | BoolArray | None = None, limit: float = np.inf
    ) -> tuple[FloatArray, IntArray, IntArray]:
        """The distance of each node to the nearest source, the node before it on the path, that source.

        `avoid` are nodes, or a mask of them.
        """
        is_open = np.ones(self.n, dtype=bool)
        if avoid is not None:
            is_open[avoid] = False
            is_open[sources] = True
        matrix = self.adjacency[0]
        return nearest_sources(matrix.indptr, matrix.indices, matrix.data, sources, is_open, limit)

    def path_edges(self, before: IntArray, ends: IntArray | list[int]) -> IntArray:
        """The edges on the shortest paths from some nodes to their sources, each once."""
        nodes = nodes_on_paths(before, np.asarray(ends, dtype=np.int64))
        return self.edges_between(nodes, before[nodes])

    def steiner_tree(
        self, terminals: Terminals, avoid: IntArray | None, limit: float
    ) -> tuple[int, IntArray]:
        """The node from which the paths to three sets of nodes are shortest in total, and their edges.

        The node is -1 if the total is over the limit. `avoid` are nodes that no path passes.
        """
        is_open = np.ones(self.n, dtype=bool)
        if avoid is not None:
            is_open[avoid] = False
        matrix = self.adjacency[0]
        nodes, start = meeting(matrix.indptr, matrix.indices, matrix.data, terminals, is_open, limit)
        if not len(nodes):
            return -1, nodes
        on = np.ones(len(nodes), dtype=bool)
        on[start[1:] - 1] = False  # the last node of each path
        on = np.flatnonzero(on)
        return int(nodes[0]), self.edges_between(nodes[on], nodes[on + 1])

    def boundary_nodes(self, seam: IntArray) -> IntArray:
        """The nodes on the boundary of the surface cut along a seam: those of the seam, and the holes."""
        passed = np.zeros(self.n, dtype=bool)
        passed[: self.n_holes], passed[self.ends[seam]] = True, True
        return np.flatnonzero(passed)

    def mask_of(self, seam: IntArray) -> BoolArray:
        """(#E,) bool: the edges of a seam."""
        mask = np.zeros(len(self.ends), dtype=bool)
        mask[seam] = True
        return mask

    def union(self, *seams: IntArray) -> IntArray:
        """The edges of some seams, each once, ascending."""
        return np.flatnonzero(self.mask_of(np.concatenate(seams)))

    def difference(self, seam: IntArray, others: IntArray) -> IntArray:
        """The edges of a seam that are not among others, in their order."""
        return seam[~self.mask_of(others)[seam]]

    def length_of(self, seam: IntArray) -> float:
        return float(self.length[seam].sum())

    def pieces_of(self, seam: IntArray) -> tuple[int, int, IntArray]:
        """Numbers of components and cycles of the seam with the holes; of faces of each piece, ascending.

        The pieces are what the surface falls into along the seam.
        """
        return opened(self.ends, self.faces, seam, self.n_holes, self.n, self.n_faces)

    def topology_of(self, seam: IntArray) -> SeamTopology:
        """Numbers of components and cycles of the seam with the holes, and of pieces.

        The pieces are disks for one seam if they are for another one of the same topology.
        """
        number, cycles, sizes = self.pieces_of(seam)
        return number, cycles, len(sizes)


def without_stubs(graph: SurfaceGraph, seam: IntArray, tips: IntArray) -> IntArray:
    """The seam without arcs that end at other nodes than these."""
    kept = np.zeros(graph.n, dtype=bool)
    kept[tips] = True
    return seam[without_leaf_edges(graph.ends[seam], kept)]


def join_terminals(graph: SurfaceGraph, seam: IntArray, others: IntArray | None = None) -> IntArray:
    """Join the holes, other nodes and the seam by a minimum spanning tree of shortest paths between them."""
    passed = np.zeros(graph.n, dtype=bool)
    passed[graph.ends[seam]] = True
    on_seam = np.flatnonzero(passed)
    passed[: graph.n_holes] = True
    if others is not None:
        passed[others] = True
    terminals = np.flatnonzero(passed)
    if len(terminals) == 0:
        return seam
    distance, before, source = graph.shortest_paths(terminals)
    group = np.arange(graph.n)
    group[on_seam] = on_seam.min(initial=graph.n)
    ends = group[np.maximum(source, 0)[graph.ends]]  # a body without any of them has no source
    way = distance[graph.ends].sum(axis=1) + graph.length
    between = np.flatnonzero(ends[:, 0] != ends[:, 1])
    bridge = spanning_forest(ends, between[np.argsort(way[between], kind="stable")], graph.n)
    paths = graph.path_edges(before, graph.ends[bridge].ravel())
    return np.concatenate((seam, graph.difference(graph.union(bridge, paths), seam)))
