"""Graphs in which several edges may join two nodes, and nodes of a graph that are far from each other."""

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .._types import BoolArray, FloatArray, IntArray
from .choice import with_loops
from .connectivity import LOW_BITS, connected_labels, sort_part

Graph = tuple[IntArray, IntArray, IntArray]


def _shortest_pairs(ends: IntArray, length: FloatArray, n: int) -> Graph:
    size = len(ends)
    begin = np.zeros(n + 2, dtype=np.int64)
    for e in range(size):
        if ends[e, 0] != ends[e, 1]:
            begin[ends[e, 0] + 2] += 1
            begin[ends[e, 1] + 2] += 1
    for v in range(n):
        begin[v + 2] += begin[v + 1]
    keys = np.empty(begin[n + 1], dtype=np.int64)  # the other node, and the edge
    for e in range(size):
        i, j = ends[e, 0], ends[e, 1]
        if i != j:
            keys[begin[i + 1]] = (j << 32) | e
            begin[i + 1] += 1
            keys[begin[j + 1]] = (i << 32) | e
            begin[j + 1] += 1
    indptr = np.zeros(n + 1, dtype=np.int64)
    indices, edge = np.empty(len(keys), dtype=np.int64), np.empty(len(keys), dtype=np.int64)
    at = np.int64(-1)
    for v in range(n):
        sort_part(keys, begin[v], begin[v + 1])
        last = np.int64(-1)
        for i in range(begin[v], begin[v + 1]):
            other, e = keys[i] >> 32, keys[i] & LOW_BITS
            if other != last:
                at += 1
                last = other
                indices[at], edge[at] = other, e
            elif length[e] < length[edge[at]]:
                edge[at] = e
        indptr[v + 1] = at + 1
    return indptr, indices[: at + 1].copy(), edge[: at + 1].copy()


@with_loops(_shortest_pairs)
def shortest_pairs(ends: IntArray, length: FloatArray, n: int) -> Graph:
    """The neighbours of each of n nodes, and the shortest edge to each, as in CSR; `ends` are (#E, 2).

    Columns ascend. Of equally short edges it is the first one; edges from a node to itself are left out.
    """
    proper = np.flatnonzero(ends[:, 0] != ends[:, 1])
    key, edge = ends[proper].min(axis=1) * n + ends[proper].max(axis=1), proper
    if not (key[1:] > key[:-1]).all():
        order = np.lexsort((length[edge], key))
        key, edge = key[order], edge[order]
        first = np.append(True, key[1:] > key[:-1])
        key, edge = key[first], edge[first]
    row, column = np.append(key // n, key % n), np.append(key % n, key // n)
    order = np.lexsort((column, row))
    return np.searchsorted(row[order], np.arange(n + 1)), column[order], np.tile(edge, 2)[order]


def _far_apart(
    indptr: IntArray, indices: IntArray, order: IntArray, hops: int, closed: BoolArray
) -> BoolArray:
    n = len(indptr) - 1
    chosen, near = np.zeros(n, dtype=np.bool_), closed.copy()
    seen, queue = np.full(n, -1, dtype=np.int64), np.empty(n, dtype=np.int64)
    for node in order:
        if near[node]:
            continue
        chosen[node], seen[node], queue[0] = True, node, node
        begin, end = 0, 1
        for _ in range(hops):
            last = end
            for k in range(begin, last):
                for at in range(indptr[queue[k]], indptr[queue[k] + 1]):
                    there = indices[at]
                    if seen[there] != node and not closed[there]:
                        seen[there], near[there], queue[end] = node, True, there
                        end += 1
            begin = last
    return chosen


@with_loops(_far_apart)
def far_apart(
    indptr: IntArray, indices: IntArray, order: IntArray, hops: int, closed: BoolArray
) -> BoolArray:
    """A mask of the nodes that one takes in an order, leaving out those `hops` edges or less from taken ones.

    The graph is given as in CSR, each node with a neighbour. Closed nodes are neither taken nor passed.
    """
    n, start = len(indptr) - 1, indptr[:-1]
    rank = np.zeros(n, dtype=np.int32)
    rank[order] = np.arange(len(order), 0, -1)
    rank[closed] = 0

    def spread(values: IntArray) -> IntArray:
        for _ in range(hops):
            values = np.maximum(values, np.maximum.reduceat(values[indices], start))
            values[closed] = 0
        return values

    chosen, waiting = np.zeros(n, dtype=bool), rank > 0
    while waiting.any():  # those that come first within their reach, all at once
        left = np.where(waiting, rank, 0)
        new = waiting & (spread(left) == left)
        chosen |= new
        waiting &= spread(new.astype(np.int32)) == 0
    return chosen


def _above(pairs: IntArray, n: int) -> IntArray:
    begin = np.zeros(n + 2, dtype=np.int64)
    for e in range(len(pairs)):
        begin[pairs[e, 0] + 2] += 1
        begin[pairs[e, 1] + 2] += 1
    for v in range(n):
        begin[v + 2] += begin[v + 1]
    beside = np.empty(2 * len(pairs), dtype=np.int64)
    for e in range(len(pairs)):
        i, j = pairs[e, 0], pairs[e, 1]
        beside[begin[i + 1]], beside[begin[j + 1]] = j, i
        begin[i + 1] += 1
        begin[j + 1] += 1
    above, waiting = np.full(n, -1, dtype=np.int64), np.empty(n, dtype=np.int64)
    for root in range(n):
        if above[root] >= 0:
            continue
        above[root], waiting[0], done, size = root, root, 0, 1
        while done < size:
            node, done = waiting[done], done + 1
            for at in range(begin[node], begin[node + 1]):
                there = beside[at]
                if above[there] < 0:
                    above[there], waiting[size] = node, there
                    size += 1
    return above


@with_loops(_above)
def above(pairs: IntArray, n: int) -> IntArray:
    """The node above each of n nodes of a forest with these edges, (#E, 2); that of a root is itself.

    The root of a tree is its first node.
    """
    root = np.unique(connected_labels(pairs, n), return_index=True)[1]
    # breadth first from a node that is beside each root
    ends = np.concatenate((pairs, np.column_stack((root, np.full(len(root), n)))))
    graph = sparse.csr_array((np.ones(len(ends), dtype=np.int8), ends.T), shape=(n + 1, n + 1))
    before = csgraph.breadth_first_order(graph, n, directed=False)[1][:n].astype(np.int64)
    before[root] = root
    return np.asarray(before)
