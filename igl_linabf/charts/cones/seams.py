"""Seams through cones, and the closed paths along which the scale has to come back across them."""

from collections.abc import Iterator

import numpy as np
from scipy import sparse

from ..._types import IntArray
from ...angles import ClosedPath
from ...surface import NEXT, Submesh, Topology
from ..cut_graphs import ClosedSurface, Levels, SurfaceGraph, join_terminals, open_handles


def seam_through(piece: ClosedSurface, cones: IntArray, handles: IntArray | None = None) -> IntArray:
    """A short cut graph that opens the handles and joins holes and cones; edges of `piece`.

    What opens the handles may be known.
    """
    return join_terminals(piece.graph, along_handles(piece) if handles is None else handles, cones)


def along_handles(piece: ClosedSurface) -> IntArray:
    """A short cut graph that opens the handles; of a large surface found on clusters, and drawn tight."""
    none = np.zeros(0, dtype=np.int64)
    if not piece.graph.genus:
        return none
    levels = Levels.of(piece)
    return levels.lift(open_handles(levels.coarse), none)


def paths_across(component: Submesh, graph: SurfaceGraph, seam: IntArray) -> tuple[ClosedPath, ...]:
    """Closed paths around the holes but one, and after them those along and across the handles.

    The scale comes back along every closed path if it does along these and around each interior vertex.
    Each crosses the seam at one edge. The edges are those that close a cycle of the seam, and on a
    spanning tree of it, the first one from each hole on the way to another one.
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
    """The right side of a shortest strip of triangles across one seam edge, for each of some."""
    m = topology.corner.shape[1]
    closed = np.zeros(len(topology.edges), dtype=bool)
    closed[seam] = True
    edge = np.flatnonzero((topology.sides[1] >= 0) & ~closed)
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
