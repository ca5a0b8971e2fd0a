"""Contract clusters of nodes of a closed surface along trees, which preserves every handle.

The nodes of a cluster are connected to its root by a tree of shortest paths. Contracting the trees leaves a
graph embedded in the same surface. A face with only two remaining sides is merged into one edge. A loop
around a handle remains a loop, even if it lies within a cluster. Therefore a seam of the coarse surface,
extended along the trees, cuts the fine surface into parts of the same topology, for any choice of clusters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..._core import choose_distant_nodes, spanning_forest
from ..._types import FloatArray, IntArray
from ...surface import connected_labels, sum_by_index
from .closed_surface import ClosedSurface
from .constants import MIN_BOND_WEIGHT
from .graph import SurfaceGraph, prune_stubs
from .laplacians import SurfaceLaplacian
from .shortening import pull_tight

# Maximum number of nodes in a search for seams. Larger surfaces are contracted to clusters first.
MAX_CLUSTERS = 6_000
MIN_NODES_OF_WIDE_CLUSTERS = 12_000  # with more nodes, the roots of clusters are one edge farther apart
CLUSTER_HOPS = 2  # the roots of two clusters are more than this many edges apart
MIN_PEAK_CURVATURE = 0.1  # curvature, radians, below which nodes become roots in random order
CORRIDOR_WIDTH = 3.0  # a lifted seam may move by this many mean distances between nodes and roots


@dataclass(frozen=True, eq=False)
class Forest:
    """Trees on a closed surface, each with a root.

    Attributes
    ----------
    root, before : (n,) int64
        The root of each node's tree, and the parent of each node. The parent of a root is -1.
    distance : (n,) float64
        Distance to the root along the tree.
    """

    root: IntArray
    before: IntArray
    distance: FloatArray


class _ContractedGraph(NamedTuple):
    """The graph after a contraction; the fields have the same meaning as in `Contraction`."""

    label: IntArray
    roots: IntArray
    edge: IntArray
    graph: SurfaceGraph


@dataclass(frozen=True, eq=False)
class Contraction:
    """A closed surface and the result of contracting each of its trees to one node.

    Attributes
    ----------
    fine, coarse : ClosedSurface
        The holes are the first nodes of both surfaces.
    forest : Forest
    label : (n,) int64
        The node of `coarse` that contains each node of `fine`.
    roots : (N,) int64
        The root of each node of `coarse`; increasing.
    edge : (#E,) int64
        The edge of `fine` that each edge of `coarse` represents.
    """

    fine: ClosedSurface
    coarse: ClosedSurface
    forest: Forest
    label: IntArray
    roots: IntArray
    edge: IntArray

    @classmethod
    def from_forest(cls, fine: ClosedSurface, forest: Forest) -> Contraction:
        """Contract each tree of a forest on a closed surface to one node."""
        label, roots, edge, graph = _contract_graph(fine.graph, forest)
        coarse = ClosedSurface(
            graph,
            node=label[fine.node],
            edges=fine.edges[edge],
            hiding=fine.hiding[edge],
            curvature=sum_by_index(label, fine.curvature, graph.n),
            area=sum_by_index(label, fine.area, graph.n),
            laplacian=_build_cluster_laplacian(fine, label, roots, forest.distance),
            size=fine.size,
            isometric=fine.isometric,
        )
        return cls(fine, coarse, forest, label, roots, edge)

    def lift_along_trees(self, seam: IntArray) -> IntArray:
        """Map a seam of the coarse surface to the fine surface. The leaves of the result are roots."""
        graph, chosen = self.fine.graph, self.edge[seam]
        paths = graph.find_edges_on_paths(self.forest.before, graph.ends[chosen].ravel())
        tips = np.bincount(self.coarse.graph.ends[seam].ravel(), minlength=self.coarse.graph.n) == 1
        return prune_stubs(graph, graph.unite_seams(chosen, paths), self.roots[tips])

    def lift(self, seam: IntArray, kept: IntArray) -> IntArray:
        """Map a coarse seam to the fine surface, and pull it tight, except at the coarse nodes `kept`."""
        if not len(seam):
            return seam
        graph, lifted = self.fine.graph, self.lift_along_trees(seam)
        mean = float(self.forest.distance.sum()) / max(graph.n - self.coarse.graph.n, 1)
        width = CORRIDOR_WIDTH * mean
        near = np.isfinite(graph.find_shortest_paths(graph.find_boundary_nodes(lifted), limit=width)[0])
        return pull_tight(self.fine, lifted, self.roots[kept], near, 2 * width)


@dataclass(frozen=True, eq=False)
class Levels:
    """A closed surface and its contractions, each of which contracts the previous result further.

    Attributes
    ----------
    steps : list of Contraction
        The first step contracts the surface itself.
    coarse : ClosedSurface
        The result of the last step; the surface itself if there are no steps.
    """

    steps: list[Contraction]
    coarse: ClosedSurface

    @classmethod
    def from_surface(cls, closed: ClosedSurface, most: int | None = None) -> Levels:
        """Contract a surface until it has at most `most` nodes, by default `MAX_CLUSTERS`.

        Holes are never merged. Therefore more than `most` nodes remain if there are many holes.
        """
        steps, coarse = list[Contraction](), closed
        while coarse.graph.n > (most or MAX_CLUSTERS):
            wide = coarse.graph.n >= MIN_NODES_OF_WIDE_CLUSTERS
            step = Contraction.from_forest(coarse, build_shortest_path_trees(coarse, CLUSTER_HOPS + wide))
            if step.coarse.graph.n == coarse.graph.n:
                break
            steps.append(step)
            coarse = step.coarse
        return cls(steps, coarse)

    def lift(self, seam: IntArray, leaves: IntArray) -> IntArray:
        """Map a coarse seam to the surface in steps, and pull it tight; the nodes `leaves` do not move."""
        for step in reversed(self.steps):
            seam, leaves = step.lift(seam, leaves), step.roots[leaves]
        return seam


def build_shortest_path_trees(closed: ClosedSurface, hops: int) -> Forest:
    """Return trees of shortest paths to the nearest root; roots are more than `hops` edges apart.

    Each hole, which is a single node, is a tree of its own.
    """
    graph, holes = closed.graph, np.arange(closed.graph.n_holes)
    by_chance = np.argsort(np.random.default_rng(0).permutation(graph.n))
    curvature = np.maximum(np.abs(closed.curvature), MIN_PEAK_CURVATURE)
    peak = np.round(np.log2(curvature)).astype(np.int16)
    order = by_chance[np.argsort(peak[by_chance], kind="stable")][::-1]
    excluded = np.zeros(graph.n, dtype=bool)
    excluded[holes] = True
    matrix = graph.adjacency[0]
    is_root = choose_distant_nodes(matrix.indptr, matrix.indices, order, hops, excluded)
    is_root[holes] = False
    distance, before, root = graph.find_shortest_paths(np.flatnonzero(is_root), holes)
    distance[holes], before[holes], root[holes] = 0, -1, holes
    return Forest(root, before, distance)


def _contract_graph(graph: SurfaceGraph, forest: Forest) -> _ContractedGraph:
    """Contract the trees of a forest, and remove faces with only two sides."""
    roots = np.flatnonzero(forest.before < 0)
    place = np.empty(graph.n, dtype=np.int64)
    place[roots] = np.arange(len(roots))
    label = place[forest.root]
    ends = label[graph.ends]
    inner = ends[:, 0] == ends[:, 1]
    in_tree, shortest = np.zeros(len(ends), dtype=bool), graph.adjacent_pairs[1]
    a, b = graph.ends[shortest].T
    in_tree[shortest] = (forest.before[a] == b) | (forest.before[b] == a)
    a, b = graph.ends.T
    way = forest.distance[a] + forest.distance[b] + graph.length

    crossed = _select_crossed_edges(graph, np.flatnonzero(inner & ~in_tree), ends[:, 0], way)
    face = connected_labels(graph.faces[crossed], graph.n_faces)
    keep = ~in_tree
    keep[crossed] = False
    edge = np.flatnonzero(keep)
    edge, sides = _remove_digons(edge, face[graph.faces[edge]], way)
    used = np.zeros(int(sides.max()) + 1, dtype=bool)
    used[sides] = True
    sides = (np.cumsum(used) - 1)[sides]
    coarse = SurfaceGraph(
        n=len(roots),
        n_holes=graph.n_holes,
        genus=graph.genus,
        n_faces=int(sides.max()) + 1,
        ends=ends[edge],
        faces=sides,
        length=way[edge],
        position=graph.position[roots],
    )
    return _ContractedGraph(label, roots, edge, coarse)


def _select_crossed_edges(
    graph: SurfaceGraph, within: IntArray, cluster: IntArray, way: FloatArray
) -> IntArray:
    """Return the edges within clusters whose two faces are merged.

    In a cluster that is a disk, faces are merged across all edges outside the tree. In any other cluster, one
    edge remains for each independent loop, and the shortest edges are chosen to remain.
    """
    crossed = spanning_forest(graph.faces, within, graph.n_faces)
    if len(crossed) == len(within):
        return crossed
    left = np.zeros(len(cluster), dtype=bool)
    left[within], left[crossed] = True, False
    no_disk = np.zeros(int(cluster.max()) + 1, dtype=bool)
    no_disk[cluster[left]] = True
    again = within[no_disk[cluster[within]]]
    longest_first = again[np.argsort(-way[again], kind="stable")]
    others = crossed[~no_disk[cluster[crossed]]]  # no cluster shares such a face
    return np.append(others, spanning_forest(graph.faces, longest_first, graph.n_faces))


def _remove_digons(edge: IntArray, sides: IntArray, way: FloatArray) -> tuple[IntArray, IntArray]:
    """Merge each strip of two-sided faces into the strip's shortest edge; return edges and their faces."""
    n = int(sides.max()) + 1
    number = np.bincount(sides.ravel(), minlength=n)
    alone = sides[:, 0] == sides[:, 1]  # an edge with the same face on both sides is not in a strip
    number[sides[alone, 0]] = 0
    digon = number == 2
    at, of = np.repeat(np.arange(len(edge)), 2), sides.ravel()
    both = np.empty((n, 2), dtype=np.int64)  # first and last edge of each face: the last assignment wins
    both[of[::-1], 0], both[of, 1] = at[::-1], at
    strip = connected_labels(both[digon], len(edge))
    outer = ~digon[sides]  # sides at the ends of strips: two for an open strip, none for a closed one
    closed = np.bincount(strip, outer.sum(axis=1)) == 0
    if closed.any():  # only two clusters on a sphere: keep all edges between them
        return edge, sides
    size = int(strip.max()) + 1
    length, least = way[edge], np.full(size, np.inf)
    np.minimum.at(least, strip, length)
    shortest = np.flatnonzero(length == least[strip])[::-1]
    best, beside = np.empty(size, dtype=np.int64), np.empty((size, 2), dtype=np.int64)
    best[strip[shortest]] = shortest  # if an index is repeated, the last assignment wins
    at, side = np.nonzero(outer)
    of, faces = strip[at], sides[at, side]
    beside[of[::-1], 0], beside[of, 1] = faces[::-1], faces
    return edge[best], beside


def _build_cluster_laplacian(
    closed: ClosedSurface, label: IntArray, roots: IntArray, distance: FloatArray
) -> SurfaceLaplacian:
    """Return the Laplacian of the clusters.

    The weight of a bond between two clusters is multiplied by the bond's share of the distance between their
    roots. For linear functions, this finite-volume scheme gives the exact flux between clusters.
    """
    graph, position, (one, other) = closed.graph, closed.graph.position, closed.laplacian.bonds.T
    across = np.flatnonzero(label[one] != label[other])
    a, b = np.minimum(one[across], other[across]), np.maximum(one[across], other[across])
    i, j = label[a], label[b]
    step, whole = position[b] - position[a], position[roots[j]] - position[roots[i]]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.einsum("ij,ij->i", step, whole) / np.einsum("ij,ij->i", whole, whole)
        hole = i < graph.n_holes  # holes have no position: use path lengths
        if hole.any():
            # index the rows of the vertices b, because the rows of holes are long
            edge = np.asarray(graph.adjacency[0][b[hole], a[hole]]).ravel()
            share[hole] = edge / (edge + distance[b[hole]])
    weight = closed.laplacian.weight[across] * np.clip(np.nan_to_num(share), MIN_BOND_WEIGHT, 1)
    return SurfaceLaplacian(len(roots), np.column_stack((i, j)), weight, weight)
