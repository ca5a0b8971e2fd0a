"""Seams through cones, and the closed paths along which the scale has to come back to what it was."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy import sparse

from ..._types import IntArray
from ...angles import ClosedPath
from ...surface import NEXT, Submesh, Topology
from ..cut_graphs import (
    DIRECT,
    ClosedSurface,
    Levels,
    SurfaceGraph,
    join_terminals,
    move_branch_points,
    open_handles,
)
from .constants import HANDLE_CLUSTERS


def seam_through(closed: ClosedSurface, cones: IntArray, handles: IntArray | None = None) -> IntArray:
    """A short cut graph that opens the handles and joins holes and cones; edges of `closed`.

    `handles` is `handle_seam(closed)`, if that is known.
    """
    return join_terminals(closed.graph, handle_seam(closed) if handles is None else handles, cones)


def handle_seam(closed: ClosedSurface) -> IntArray:
    """A short cut graph that opens the handles. On a large surface it is found on clusters, and shortened."""
    none = np.zeros(0, dtype=np.int64)
    if not closed.graph.genus:
        return none
    if closed.graph.n <= DIRECT:
        return move_branch_points(closed.graph, open_handles(closed), closed.graph.length_of)
    features = replace(closed.features, valleys=lambda: np.ones(len(closed.edges)))
    levels = Levels.of(replace(closed, features=features), HANDLE_CLUSTERS)
    graph, handles = levels.coarse.graph, open_handles(levels.coarse)
    return levels.lift(move_branch_points(graph, handles, graph.length_of), none)


def paths_across(component: Submesh, graph: SurfaceGraph, seam: IntArray) -> tuple[ClosedPath, ...]:
    """Closed paths around the holes but one, and after them those along and across the handles.

    The scale comes back along every closed path if it does along these and around each interior vertex.
    Each path crosses the seam at one edge. Take a spanning tree of the seam: these edges are those off the
    tree, which close its cycles, and from each hole but one the first edge towards the root.
    """
    if not len(seam):
        return ()
    ends = graph.ends[seam]
    proper = np.flatnonzero(ends[:, 0] != ends[:, 1])
    pair = np.sort(ends[proper], axis=1)
    key, at = np.unique(pair[:, 0] * graph.n + pair[:, 1], return_index=True)
    tree = sparse.csr_array((np.ones(len(key)), pair[at].T), shape=(graph.n, graph.n))
    _, before = sparse.csgraph.breadth_first_order(tree, int(ends.min()), directed=False)
    child = np.flatnonzero(before >= 0)
    low, high = np.minimum(child, before[child]), np.maximum(child, before[child])
    on_tree = proper[at[np.searchsorted(key, low * graph.n + high)]]
    crossed = np.concatenate((on_tree[child < graph.n_holes], np.setdiff1d(np.arange(len(seam)), on_tree)))
    if not len(crossed):
        return ()
    rows = component.cuttable_edges[seam]
    return tuple(_strips(component.topology, rows, rows[crossed]))


def _strips(topology: Topology, seam: IntArray, crossed: IntArray) -> Iterator[ClosedPath]:
    """For each crossed edge, a shortest closed strip of triangles across it; of this its right side.

    The strip crosses no other edge of the seam.
    """
    m = topology.corner.shape[1]
    on_seam = np.zeros(len(topology.edges), dtype=bool)
    on_seam[seam] = True
    edge = np.flatnonzero((topology.sides[1] >= 0) & ~on_seam)
    face = np.sort(topology.sides[:, edge] % m, axis=0)
    _, kept = np.unique(face[0] * m + face[1], return_index=True)  # two faces may share two edges
    dual = sparse.csr_array((edge[kept] + 1.0, face[:, kept]), shape=(m, m))
    dual = (dual + dual.T).tocsr()
    for e in crossed.tolist():
        end, start = (topology.sides[:, e] % m).tolist()
        _, before = sparse.csgraph.breadth_first_order(dual, start)
        faces = [end]
        while faces[-1] != start:
            faces.append(int(before[faces[-1]]))
        way = np.array(faces[::-1])
        between = np.asarray(dual[way[:-1], way[1:]]).ravel().astype(np.int64) - 1
        through = np.concatenate(([e], between, [e]))
        entry, leave = (
            np.where(first % m == way, first // m, second // m)  # the corner opposite to the edge
            for first, second in (topology.sides[:, through[:-1]], topology.sides[:, through[1:]])
        )
        pivot = 3 - entry - leave
        left = pivot == np.array(NEXT)[entry]  # the strip turns around a vertex on its left
        corners = np.concatenate((pivot[~left], entry[left], leave[left]))
        faces_of = np.concatenate((way[~left], way[left], way[left]))
        yield ClosedPath(corners * m + faces_of, int(np.count_nonzero(left)))
