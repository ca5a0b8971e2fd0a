"""Least cuts between two nodes of a graph."""

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .._types import BoolArray, IntArray
from .choice import inlined, with_loops


@inlined
def _levels(
    begin: IntArray, arcs: IntArray, head: IntArray, left: IntArray, level: IntArray, source: int
) -> None:
    """How many arcs with something left lead from the source to each node; -1 where none do."""
    queue, first, last = np.empty(len(level), dtype=np.int64), 0, 1
    level[:] = -1
    level[source], queue[0] = 0, source
    while first < last:
        v = queue[first]
        first += 1
        for k in range(begin[v], begin[v + 1]):
            w = head[arcs[k]]
            if left[arcs[k]] > 0 and level[w] < 0:
                level[w], queue[last] = level[v] + 1, w
                last += 1


@inlined
def _saturate(
    begin: IntArray, arcs: IntArray, head: IntArray, left: IntArray, level: IntArray, source: int, sink: int
) -> None:
    """Send flow on ways of ascending levels until none is left."""
    at, path, depth, v = begin[:-1].copy(), np.empty(len(level), dtype=np.int64), 0, source
    while True:
        if v == sink:
            flow = left[path[0]]
            for k in range(depth):
                flow = min(flow, left[path[k]])
            full = depth
            for k in range(depth - 1, -1, -1):
                left[path[k]] -= flow
                left[path[k] ^ 1] += flow
                if left[path[k]] == 0:
                    full = k
            depth, v = full, head[path[full] ^ 1]
        while at[v] < begin[v + 1]:
            a = arcs[at[v]]
            if left[a] > 0 and level[head[a]] == level[v] + 1:
                break
            at[v] += 1
        if at[v] < begin[v + 1]:
            path[depth] = arcs[at[v]]
            v = head[path[depth]]
            depth += 1
        elif depth == 0:
            return
        else:
            depth -= 1
            v = head[path[depth] ^ 1]
            at[v] += 1


def _behind_least_cut(ends: IntArray, capacity: IntArray, n: int, source: int, sink: int) -> BoolArray:
    m = len(ends)
    begin, head, left = np.zeros(n + 1, dtype=np.int64), np.empty(2 * m, np.int64), np.empty(2 * m, np.int64)
    for e in range(m):
        head[2 * e], head[2 * e + 1] = ends[e, 1], ends[e, 0]
        left[2 * e] = left[2 * e + 1] = capacity[e]
        begin[ends[e, 0] + 1] += 1
        begin[ends[e, 1] + 1] += 1
    for v in range(n):
        begin[v + 1] += begin[v]
    place, arcs = begin[:-1].copy(), np.empty(2 * m, dtype=np.int64)
    for a in range(2 * m):
        v = head[a ^ 1]
        arcs[place[v]] = a
        place[v] += 1
    level = np.empty(n, dtype=np.int64)
    while True:
        _levels(begin, arcs, head, left, level, source)
        if level[sink] < 0:
            return level < 0
        _saturate(begin, arcs, head, left, level, source, sink)


@with_loops(_behind_least_cut)
def behind_least_cut(ends: IntArray, capacity: IntArray, n: int, source: int, sink: int) -> BoolArray:
    """The nodes (n,) behind the least cut between two nodes; of several, the one nearest to the source.

    Parameters
    ----------
    ends : (#E, 2) int64
        Edges between different nodes.
    capacity : (#E,) int64
        What it costs to cut each; below 2^31.
    n, source, sink : int
    """
    values, (tail, head) = np.tile(capacity, 2), np.concatenate((ends, ends[:, ::-1])).T
    graph = sparse.csr_array((values, (tail, head)), shape=(n, n))
    graph.data = np.minimum(graph.data, np.iinfo(np.int32).max)
    graph = graph.astype(np.int32)
    left = sparse.csr_array(graph - csgraph.maximum_flow(graph, source, sink).flow)
    left.data[left.data <= 0] = 0
    left.eliminate_zeros()
    behind = np.ones(n, dtype=bool)
    behind[csgraph.breadth_first_order(left, source, return_predecessors=False)] = False
    return behind
