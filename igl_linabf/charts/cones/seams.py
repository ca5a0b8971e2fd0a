"""Find seams through cones, and closed paths whose holonomy is constrained."""

from collections.abc import Iterator

import numpy as np
from scipy import sparse

from ..._types import IntArray
from ...angles import ClosedPath
from ...surface import NEXT, Submesh, Topology
from ..cut_graphs import ClosedSurface, Levels, SurfaceGraph, join_terminals, move_branch_points, open_handles

HANDLE_CLUSTERS = 1_000  # contract larger surfaces to this many nodes before handles are cut


def find_seam(piece: ClosedSurface, cones: IntArray, handles: IntArray | None = None) -> IntArray:
    """Return the edges of a short cut graph that opens the handles of `piece` and joins holes and cones.

    `handles` is the result of `cut_handles` if it has been computed before.
    """
    return join_terminals(piece.graph, cut_handles(piece) if handles is None else handles, cones)


def cut_handles(piece: ClosedSurface) -> IntArray:
    """Return the edges of a short cut graph that opens the handles of `piece`."""
    none = np.zeros(0, dtype=np.int64)
    if not piece.graph.genus:
        return none
    levels = Levels.from_surface(piece, HANDLE_CLUSTERS)
    graph, handles = levels.coarse.graph, open_handles(levels.coarse)
    return levels.lift(move_branch_points(graph, handles, graph.measure_length), none)


def find_closed_paths(component: Submesh, graph: SurfaceGraph, seam: IntArray) -> tuple[ClosedPath, ...]:
    """Return closed paths around all holes but one, followed by paths along and across the handles.

    If the scale of a map returns to its initial value along these paths and around each interior vertex, it
    does so along every closed path. Each path crosses the seam at one edge: an edge that closes a cycle of
    the seam, or the first edge from a hole on the way to another hole along a spanning tree of the seam.
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
    return tuple(_find_strips(component.topology, rows, rows[crossed]))


def _find_strips(topology: Topology, seam: IntArray, crossed: IntArray) -> Iterator[ClosedPath]:
    """For each seam edge in `crossed`, yield the right side of a shortest closed strip of triangles.

    The strip crosses the given seam edge and no other edge of the seam.
    """
    m = topology.corner.shape[1]
    closed = np.zeros(len(topology.edges), dtype=bool)
    closed[seam] = True
    edge = np.flatnonzero((topology.sides[1] >= 0) & ~closed)
    face = np.sort(topology.sides[:, edge] % m, axis=0)
    _, kept = np.unique(face[0] * m + face[1], return_index=True)  # keep one edge if two faces share two
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
            np.where(first % m == way, first // m, second // m)  # corner opposite to the crossed edge
            for first, second in (topology.sides[:, through[:-1]], topology.sides[:, through[1:]])
        )
        pivot = 3 - entry - leave
        left = pivot == np.array(NEXT)[entry]  # triangles where the strip turns left
        corners = np.concatenate((pivot[~left], entry[left], leave[left]))
        faces_of = np.concatenate((way[~left], way[left], way[left]))
        yield ClosedPath(corners * m + faces_of, int(np.count_nonzero(left)))
