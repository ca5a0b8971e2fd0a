"""A closed surface with fewer nodes: clusters of nodes contracted along trees, which keeps every handle.

Each cluster of nodes hangs on a root by a tree of shortest paths. Contracting the trees leaves an embedded
graph on the same surface: faces that keep two sides only are dropped with one of the two equal edges, and a
loop around a handle that fits into a cluster stays as a loop. So a seam of the coarse surface, carried along
the trees, cuts the fine one into what it cut the coarse one into, whatever the clusters are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..._core import far_apart, spanning_forest
from ..._types import FloatArray, IntArray
from ...surface import connected_labels, sum_by
from . import constants
from .closed_surface import ClosedSurface
from .graph import SurfaceGraph, without_stubs
from .laplacians import SurfaceLaplacian
from .shortening import pull_tight


@dataclass(frozen=True, eq=False)
class Forest:
    """Trees on a closed surface, each with a root.

    Attributes
    ----------
    root, before : (n,) int64
        The root of the tree that each node is on, and the node before it, from there; -1 at a root.
    distance : (n,) float64
        Along the tree.
    """

    root: IntArray
    before: IntArray
    distance: FloatArray


class _Outline(NamedTuple):
    """The edges that remain when trees are contracted; the fields are those of `Contracted`."""

    label: IntArray
    roots: IntArray
    edge: IntArray
    graph: SurfaceGraph


@dataclass(frozen=True, eq=False)
class Contracted:
    """A closed surface of which each tree is one node.

    Attributes
    ----------
    fine, coarse : ClosedSurface
        The holes are the first nodes of both.
    forest : Forest
    label : (n,) int64
        The node of `coarse` that each node of `fine` is in.
    roots : (N,) int64
        The root of each node of `coarse`; increasing.
    edge : (#E,) int64
        The edge of `fine` that each edge of `coarse` stands for.
    """

    fine: ClosedSurface
    coarse: ClosedSurface
    forest: Forest
    label: IntArray
    roots: IntArray
    edge: IntArray

    @classmethod
    def of(cls, fine: ClosedSurface, forest: Forest) -> Contracted:
        """Contract the trees of a forest."""
        label, roots, edge, graph = _outline(fine.graph, forest)
        coarse = ClosedSurface(
            graph,
            node=label[fine.node],
            edges=fine.edges[edge],
            hiding=fine.hiding[edge],
            curvature=sum_by(label, fine.curvature, graph.n),
            area=sum_by(label, fine.area, graph.n),
            laplacian=_finite_volumes(fine, label, roots, forest.distance),
            size=fine.size,
            isometric=fine.isometric,
        )
        return cls(fine, coarse, forest, label, roots, edge)

    def lift_along_trees(self, seam: IntArray) -> IntArray:
        """A seam of the coarse surface on the fine one: tips are roots."""
        graph, chosen = self.fine.graph, self.edge[seam]
        paths = graph.path_edges(self.forest.before, graph.ends[chosen].ravel())
        tips = np.bincount(self.coarse.graph.ends[seam].ravel(), minlength=self.coarse.graph.n) == 1
        return without_stubs(graph, graph.union(chosen, paths), self.roots[tips])

    def lift(self, seam: IntArray, kept: IntArray) -> IntArray:
        """A seam of the coarse surface, pulled tight on the fine one; it still passes the roots of `kept`."""
        if not len(seam):
            return seam
        graph, lifted = self.fine.graph, self.lift_along_trees(seam)
        mean = float(self.forest.distance.sum()) / max(graph.n - self.coarse.graph.n, 1)
        return _tighten(self.fine, lifted, self.roots[kept], mean)


@dataclass(frozen=True, eq=False)
class Levels:
    """A closed surface contracted step by step.

    Attributes
    ----------
    steps : list of Contracted
        The surface itself is the fine one of the first step.
    coarse : ClosedSurface
        The result of the last step, or the surface itself.
    """

    steps: list[Contracted]
    coarse: ClosedSurface

    @classmethod
    def of(cls, closed: ClosedSurface) -> Levels:
        """Contract a surface to at most `MAX_CLUSTERS` nodes; one that has no more nodes stays as it is."""
        steps, coarse = list[Contracted](), closed
        while coarse.graph.n > constants.MAX_CLUSTERS:
            wide = coarse.graph.n >= constants.MIN_NODES_OF_WIDE_CLUSTERS
            steps.append(Contracted.of(coarse, shortest_path_trees(coarse, constants.CLUSTER_HOPS + wide)))
            coarse = steps[-1].coarse
        return cls(steps, coarse)

    def lift(self, seam: IntArray, leaves: IntArray) -> IntArray:
        """Pull a seam of the coarse surface tight on the surface, step by step; it passes its leaves."""
        if not self.steps and len(seam):
            return _tighten(self.coarse, seam, leaves, float(self.coarse.graph.length.mean()))
        for step in reversed(self.steps):
            seam, leaves = step.lift(seam, leaves), step.roots[leaves]
        return seam


def _tighten(closed: ClosedSurface, seam: IntArray, kept: IntArray, step: float) -> IntArray:
    """Pull a seam tight within a corridor, whose width is a multiple of `step`; it still passes `kept`."""
    width, graph = constants.CORRIDOR_WIDTH * step, closed.graph
    near = np.isfinite(graph.shortest_paths(graph.boundary_nodes(seam), limit=width)[0])
    return pull_tight(closed, seam, kept, near, 2 * width)


def shortest_path_trees(closed: ClosedSurface, hops: int) -> Forest:
    """The trees of shortest paths to the nearest roots, which are more than `hops` edges apart.

    Each hole is a root with no other node.
    """
    graph, holes = closed.graph, np.arange(closed.graph.n_holes)
    by_chance = np.argsort(np.random.default_rng(0).permutation(graph.n))
    curvature = np.maximum(np.abs(closed.curvature), constants.MIN_PEAK_CURVATURE)
    peak = np.round(np.log2(curvature)).astype(np.int16)
    order = by_chance[np.argsort(peak[by_chance], kind="stable")][::-1]
    excluded = np.zeros(graph.n, dtype=bool)
    excluded[holes] = True
    matrix = graph.adjacency[0]
    is_root = far_apart(matrix.indptr, matrix.indices, order, hops, excluded)
    is_root[holes] = False
    distance, before, root = graph.shortest_paths(np.flatnonzero(is_root), holes)
    distance[holes], before[holes], root[holes] = 0, -1, holes
    return Forest(root, before, distance)


def _outline(graph: SurfaceGraph, forest: Forest) -> _Outline:
    roots = np.flatnonzero(forest.before < 0)
    place = np.empty(graph.n, dtype=np.int64)
    place[roots] = np.arange(len(roots))
    label = place[forest.root]
    ends = label[graph.ends]
    inner = ends[:, 0] == ends[:, 1]
    in_tree, shortest = np.zeros(len(ends), dtype=bool), graph.neighbours[1]
    a, b = graph.ends[shortest].T
    in_tree[shortest] = (forest.before[a] == b) | (forest.before[b] == a)
    a, b = graph.ends.T
    way = forest.distance[a] + forest.distance[b] + graph.length

    crossed = _crossed(graph, np.flatnonzero(inner & ~in_tree), ends[:, 0], way)
    face = connected_labels(graph.faces[crossed], graph.n_faces)
    keep = ~in_tree
    keep[crossed] = False
    edge = np.flatnonzero(keep)
    edge, sides = _without_digons(edge, face[graph.faces[edge]], way)
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
    return _Outline(label, roots, edge, coarse)


def _crossed(graph: SurfaceGraph, within: IntArray, cluster: IntArray, way: FloatArray) -> IntArray:
    """Of the edges within clusters those whose two faces become one: all, short of an annulus.

    Around what is no disk the shortest ways stay.
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
    others = crossed[~no_disk[cluster[crossed]]]  # no face is beside edges within two clusters
    return np.append(others, spanning_forest(graph.faces, longest_first, graph.n_faces))


def _without_digons(edge: IntArray, sides: IntArray, way: FloatArray) -> tuple[IntArray, IntArray]:
    """Of the edges along a strip of faces with two sides the shortest, and the faces beside the strip."""
    n = int(sides.max()) + 1
    number = np.bincount(sides.ravel(), minlength=n)
    alone = sides[:, 0] == sides[:, 1]  # an edge with one face on both sides is no strip's
    number[sides[alone, 0]] = 0
    digon = number == 2
    at, of = np.repeat(np.arange(len(edge)), 2), sides.ravel()
    both = np.empty((n, 2), dtype=np.int64)  # the first and the last edge of each face: the last one written
    both[of[::-1], 0], both[of, 1] = at[::-1], at
    strip = connected_labels(both[digon], len(edge))
    outer = ~digon[sides]  # a strip has two such sides; one that is closed has none
    closed = np.bincount(strip, outer.sum(axis=1)) == 0
    if closed.any():  # two clusters are the whole sphere: their edges stay
        return edge, sides
    size = int(strip.max()) + 1
    length, least = way[edge], np.full(size, np.inf)
    np.minimum.at(least, strip, length)
    shortest = np.flatnonzero(length == least[strip])[::-1]
    best, beside = np.empty(size, dtype=np.int64), np.empty((size, 2), dtype=np.int64)
    best[strip[shortest]] = shortest  # the last one written stays, here and below
    at, side = np.nonzero(outer)
    of, faces = strip[at], sides[at, side]
    beside[of[::-1], 0], beside[of, 1] = faces[::-1], faces
    return edge[best], beside


def _finite_volumes(
    closed: ClosedSurface, label: IntArray, roots: IntArray, distance: FloatArray
) -> SurfaceLaplacian:
    """The Laplacian of the clusters: weights of the bonds across, by the part of the way that they go.

    That is the Laplacian of finite volumes: if u is linear, what flows from one cluster to the next is right.
    """
    graph, position, (one, other) = closed.graph, closed.graph.position, closed.laplacian.bonds.T
    across = np.flatnonzero(label[one] != label[other])
    a, b = np.minimum(one[across], other[across]), np.maximum(one[across], other[across])
    i, j = label[a], label[b]
    step, whole = position[b] - position[a], position[roots[j]] - position[roots[i]]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.einsum("ij,ij->i", step, whole) / np.einsum("ij,ij->i", whole, whole)
        hole = i < graph.n_holes  # which has no place of its own
        if hole.any():
            edge = np.asarray(graph.adjacency[0][b[hole], a[hole]]).ravel()  # a hole has a long row
            share[hole] = edge / (edge + distance[b[hole]])
    weight = closed.laplacian.weight[across] * np.clip(np.nan_to_num(share), constants.MIN_BOND_WEIGHT, 1)
    return SurfaceLaplacian(len(roots), np.column_stack((i, j)), weight, weight)
