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
from scipy import sparse

from ..._core import far_apart, spanning_forest
from ..._types import FloatArray, IntArray
from ...surface import connected_labels, sum_by
from .graph import FIRST_BASES, ClosedSurface, open_handles, shortest_edges, shortest_loops, without_stubs
from .shortening import tightened

DIRECT = 8_500  # nodes up to which seams are found on the surface itself
DIRECT_HANDLES = 4_000  # the same, of parts with handles of a large surface
CLUSTERED = 6_000  # clusters of nodes on which they are found, at most
LEAST_PEAK = 0.1  # radians of curvature: nodes of less are roots as chance has it
REACH = 6.0  # mean distances to a root that a branch point's arcs may move
WIDTH = 3.0  # the same, of the corridor on each side of a seam in which it is drawn tight
FAR = 12_000  # nodes from which the roots of clusters are more than three edges apart, not two
HOPS, FEW_HOPS = 3, 2
MORE_ROOTS = 4  # times
SMALLEST_SHARE = 1e-3  # of the way that an edge across goes: the maximum principle then holds


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


@dataclass(frozen=True, eq=False)
class Contracted:
    """A closed surface of which each tree is one node.

    Attributes
    ----------
    fine, coarse : ClosedSurface
        The loops are the first nodes of both.
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

    def carried(self, seam: IntArray) -> IntArray:
        """A seam of the coarse surface on the fine one: tips are roots."""
        fine, chosen = self.fine, self.edge[seam]
        ways = fine.paths(self.forest.before, fine.ends[chosen].ravel())
        tips = np.bincount(self.coarse.ends[seam].ravel(), minlength=self.coarse.n) == 1
        return without_stubs(fine, fine.together(chosen, ways), self.roots[tips])

    def drawn(self, seam: IntArray, kept: IntArray) -> IntArray:
        """A seam of the coarse surface, drawn tight on the fine one between the roots of the nodes `kept`."""
        if not len(seam):
            return seam
        fine, carried = self.fine, self.carried(seam)
        mean = float(self.forest.distance.sum()) / max(fine.n - self.coarse.n, 1)
        near = np.isfinite(fine.search(fine.on(carried), limit=WIDTH * mean)[0])
        return tightened(fine, carried, self.roots[kept], near, REACH * mean)


@dataclass(frozen=True, eq=False)
class Levels:
    """A closed surface contracted once or more often.

    Attributes
    ----------
    steps : list of Contracted
        From the surface on.
    """

    steps: list[Contracted]

    @classmethod
    def of(cls, piece: ClosedSurface, most: int) -> Levels:
        """Down to so many nodes."""
        steps: list[Contracted] = []
        while not steps or piece.n > most:
            steps.append(_simply_contracted(piece, HOPS if piece.n >= FAR else FEW_HOPS))
            piece = steps[-1].coarse
        return cls(steps)

    @property
    def coarse(self) -> ClosedSurface:
        return self.steps[-1].coarse

    def label(self, nodes: IntArray) -> IntArray:
        """The coarse nodes that some nodes of the surface are in."""
        for step in self.steps:
            nodes = step.label[nodes]
        return nodes

    def drawn(self, seam: IntArray, leaves: IntArray) -> IntArray:
        """A seam of the coarse surface drawn tight on the surface, step by step; `leaves` stay roots."""
        for step in reversed(self.steps):
            seam, leaves = step.drawn(seam, leaves), step.roots[leaves]
        return seam


def clusters(piece: ClosedSurface, hops: int) -> Forest:
    """Each node on the shortest path to the nearest root; roots are more than `hops` edges apart.

    Each hole is a root with no other node.
    """
    holes, graph = np.arange(piece.holes), piece.graph
    by_chance = np.argsort(np.random.default_rng(0).permutation(piece.n))
    peak = np.round(np.log2(np.maximum(np.abs(piece.curvature), LEAST_PEAK))).astype(np.int16)
    order = by_chance[np.argsort(peak[by_chance], kind="stable")][::-1]
    closed = np.zeros(piece.n, dtype=bool)
    closed[holes] = True
    is_root = far_apart(graph.indptr, graph.indices, order, hops, closed)
    is_root[holes] = False
    distance, before, root = piece.search(np.flatnonzero(is_root), holes)
    distance[holes], before[holes], root[holes] = 0, -1, holes
    return Forest(root, before, distance)


def _with_roots(piece: ClosedSurface, forest: Forest, more: IntArray) -> Forest:
    """The forest with more roots, to which nodes change that are nearer to them."""
    holes = np.arange(piece.holes)
    distance, before, root = piece.search(np.setdiff1d(more, holes), holes, float(forest.distance.max()))
    nearer = distance < forest.distance
    return Forest(
        np.where(nearer, root, forest.root),
        np.where(nearer, before, forest.before),
        np.where(nearer, distance, forest.distance),
    )


class _Outline(NamedTuple):
    """What is left of the edges when trees are contracted: fields as of `Contracted` and `ClosedSurface`."""

    label: IntArray
    roots: IntArray
    edge: IntArray
    ends: IntArray
    faces: IntArray
    length: FloatArray
    graph: sparse.csr_array
    entry: IntArray


def _outline(piece: ClosedSurface, forest: Forest) -> _Outline:
    roots = np.flatnonzero(forest.before < 0)
    place = np.empty(piece.n, dtype=np.int64)
    place[roots] = np.arange(len(roots))
    label = place[forest.root]
    ends = label[piece.ends]
    inner = ends[:, 0] == ends[:, 1]
    in_tree = np.zeros(len(ends), dtype=bool)
    a, b = piece.ends[piece.shortest].T
    in_tree[piece.shortest] = (forest.before[a] == b) | (forest.before[b] == a)
    a, b = piece.ends.T
    way = forest.distance[a] + forest.distance[b] + piece.length

    crossed = _crossed(piece, np.flatnonzero(inner & ~in_tree), ends[:, 0], way)
    face = connected_labels(piece.faces[crossed], piece.n_faces)
    keep = ~in_tree
    keep[crossed] = False
    edge = np.flatnonzero(keep)
    edge, sides = _without_digons(edge, face[piece.faces[edge]], way)
    used = np.zeros(int(sides.max()) + 1, dtype=bool)
    used[sides] = True
    graph, entry = shortest_edges(ends[edge], way[edge], len(roots))
    return _Outline(label, roots, edge, ends[edge], (np.cumsum(used) - 1)[sides], way[edge], graph, entry)


def _crossed(piece: ClosedSurface, within: IntArray, cluster: IntArray, way: FloatArray) -> IntArray:
    """Of the edges within clusters those whose two faces become one: all, short of an annulus.

    Around what is no disk the shortest ways stay.
    """
    crossed = spanning_forest(piece.faces, within, piece.n_faces)
    if len(crossed) == len(within):
        return crossed
    left = np.zeros(len(cluster), dtype=bool)
    left[within], left[crossed] = True, False
    round_ = np.zeros(int(cluster.max()) + 1, dtype=bool)
    round_[cluster[left]] = True
    again = within[round_[cluster[within]]]
    longest_first = again[np.argsort(-way[again], kind="stable")]
    others = crossed[~round_[cluster[crossed]]]  # no face is beside edges within two clusters
    return np.append(others, spanning_forest(piece.faces, longest_first, piece.n_faces))


def contracted(piece: ClosedSurface, forest: Forest, outline: _Outline | None = None) -> Contracted:
    """Contract the trees of a forest."""
    outline = outline or _outline(piece, forest)
    label, roots, edge, ends, faces, length, graph, entry = outline
    n = len(roots)
    bonds, weight = _flow(piece, label, roots, forest.distance)
    coarse = ClosedSurface(
        n=n,
        holes=piece.holes,
        genus=piece.genus,
        n_faces=int(faces.max()) + 1,
        node=label[piece.node],
        edges=piece.edges[edge],
        ends=ends,
        faces=faces,
        true_length=piece.true_length[edge] * length / piece.length[edge],
        length=length,
        shown=piece.shown[edge],
        valleys=lambda: piece.valley[edge],
        sharp=piece.sharp[edge],
        graph=graph,
        entry=entry,
        curvature=sum_by(label, piece.curvature, n),
        noise=sum_by(label, piece.noise, n),
        area=sum_by(label, piece.area, n),
        bonds=bonds,
        cotangent=weight,
        weight=weight,
        position=piece.position[roots],
        size=piece.size,
        isometric=piece.isometric,
    )
    return Contracted(piece, coarse, forest, label, roots, edge)


def _simply_contracted(piece: ClosedSurface, hops: int) -> Contracted:
    """With more roots where clusters go around a thin part, so that two of them have one edge at most."""
    forest = clusters(piece, hops)
    for _ in range(MORE_ROOTS):
        outline = _outline(piece, forest)
        low, high = np.sort(outline.ends, axis=1).T
        # at both edges of such a pair: the ends of the longer one may be roots already
        key = low * len(outline.roots) + high
        ordered = np.sort(key)
        again = np.isin(key, ordered[1:][ordered[1:] == ordered[:-1]])
        if not again.any():
            return contracted(piece, forest, outline)
        forest = _with_roots(piece, forest, piece.ends[outline.edge[again]].ravel())
    return contracted(piece, forest)


def handles_of_clusters(piece: ClosedSurface) -> IntArray:
    """`open_handles`; of many nodes, through roots of those clusters where most loops of clusters meet."""
    if piece.n <= DIRECT:
        return open_handles(piece)
    step = _simply_contracted(piece, HOPS)
    met = np.bincount(step.coarse.ends[open_handles(step.coarse)].ravel(), minlength=step.coarse.n)
    return shortest_loops(piece, step.roots[np.argsort(-met, kind="stable")[:FIRST_BASES]].tolist())[0]


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


def _flow(
    piece: ClosedSurface, label: IntArray, roots: IntArray, distance: FloatArray
) -> tuple[IntArray, FloatArray]:
    """The bonds of the clusters: weights of the edges across, by the part of the way that they go.

    That is the Laplacian of finite volumes: if u is linear, what flows from one cluster to the next is right.
    """
    one, other = piece.bonds.T
    across = np.flatnonzero(label[one] != label[other])
    a, b = np.minimum(one[across], other[across]), np.maximum(one[across], other[across])
    i, j = label[a], label[b]
    step, whole = piece.position[b] - piece.position[a], piece.position[roots[j]] - piece.position[roots[i]]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.einsum("ij,ij->i", step, whole) / np.einsum("ij,ij->i", whole, whole)
        hole = i < piece.holes  # which has no place of its own
        if hole.any():
            edge = np.asarray(piece.graph[a[hole], b[hole]]).ravel()
            share[hole] = edge / (edge + distance[b[hole]])
    weight = piece.weight[across] * np.clip(np.nan_to_num(share), SMALLEST_SHARE, 1)
    return np.column_stack((i, j)), weight
