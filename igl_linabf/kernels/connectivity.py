"""Half-edges joined to edges, and the pattern of a matrix over a graph."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .._types import IntArray
from .choice import with_loops

Joined = tuple[IntArray, IntArray, IntArray, IntArray]


def _undirected(tail: IntArray, head: IntArray, n: int) -> Joined:
    t, h = tail.ravel(), head.ravel()
    size = len(t)
    # sorted by the higher end, then by the lower one: each time in the order of before
    begin = np.zeros(n + 1, dtype=np.int64)
    for i in range(size):
        begin[max(t[i], h[i]) + 1] += 1
    for v in range(n):
        begin[v + 1] += begin[v]
    by_high = np.empty(size, dtype=np.int32)  # there is no memory for 2^31 half-edges
    for i in range(size):
        v = max(t[i], h[i])
        by_high[begin[v]] = i
        begin[v] += 1
    begin[:] = 0
    for i in range(size):
        begin[min(t[i], h[i]) + 1] += 1
    for v in range(n):
        begin[v + 1] += begin[v]
    order = np.empty(size, dtype=np.int32)
    for k in range(size):
        i = by_high[k]
        v = min(t[i], h[i])
        order[begin[v]] = i
        begin[v] += 1
    edge = np.empty(size, dtype=np.int64)
    first = np.empty(size, dtype=np.int64)
    second = np.full(size, -1, dtype=np.int64)
    count = np.zeros(size, dtype=np.int64)
    e, low, high = -1, np.int64(-1), np.int64(-1)
    for k in range(size):
        i = order[k]
        a, b = min(t[i], h[i]), max(t[i], h[i])
        if a != low or b != high:
            e += 1
            low, high = a, b
            first[e] = i
        elif count[e] == 1:
            second[e] = i
        count[e] += 1
        edge[i] = e
    e += 1
    return edge, first[:e].copy(), second[:e].copy(), count[:e].copy()


@with_loops(_undirected)
def undirected(tail: IntArray, head: IntArray, n: int) -> Joined:
    """The edge of each half-edge; the first two half-edges of each edge (or -1), and how many it has."""
    key = (np.minimum(tail, head) * n + np.maximum(tail, head)).ravel()
    order = np.argsort(key, kind="stable")
    key = key[order]
    starts = np.ones(len(key), dtype=bool)
    np.not_equal(key[1:], key[:-1], out=starts[1:])
    begin = np.flatnonzero(starts)
    count = np.diff(begin, append=len(key))
    second = np.where(count > 1, order[np.minimum(begin + 1, len(key) - 1)], -1)
    edge = np.empty_like(order)
    edge[order] = np.cumsum(starts) - 1
    return edge, order[begin], second, count


def _boundary_loops(tail: IntArray, head: IntArray, n: int) -> tuple[IntArray, IntArray, IntArray]:
    following = np.full(n, -1, dtype=np.int64)
    twice, many = np.empty(len(tail), dtype=np.int64), 0
    for e in range(len(tail)):
        if following[tail[e]] >= 0:
            twice[many] = tail[e]
            many += 1
        following[tail[e]] = head[e]
    vertices, sizes, found, loops = np.empty_like(tail), np.empty_like(tail), 0, 0
    for v in range(0 if many else n):
        before, at = found, v
        while following[at] >= 0:
            vertices[found] = at
            found += 1
            ahead = following[at]
            following[at] = -1
            at = ahead
        if found > before:
            sizes[loops] = found - before
            loops += 1
    return vertices[:found], sizes[:loops].copy(), twice[:many].copy()


@with_loops(_boundary_loops)
def boundary_loops(tail: IntArray, head: IntArray, n: int) -> tuple[IntArray, IntArray, IntArray]:
    """Boundary half-edges chained into loops: their vertices one loop after the other, and their sizes.

    A loop begins at its first vertex, and loops come in the order of these. There are none if two edges
    leave a vertex; the third array has such vertices.
    """
    order = np.argsort(tail, kind="stable")
    start = tail[order]
    twice = start[1:][start[1:] == start[:-1]]
    if len(twice):
        return start[:0], start[:0], twice
    loops = cycles(np.searchsorted(start, head[order]))
    sizes = np.array([len(loop) for loop in loops], dtype=np.int64)
    return start[[v for loop in loops for v in loop]], sizes, twice


def cycles(following: IntArray) -> list[list[int]]:
    """The cycles of a permutation, in the order of their first elements."""
    after, seen, found = following.tolist(), bytearray(len(following)), []
    for i in range(len(after)):
        cycle = []
        while not seen[i]:
            seen[i] = 1
            cycle.append(i)
            i = after[i]
        if cycle:
            found.append(cycle)
    return found


def _connected_labels(edges: IntArray, n: int) -> IntArray:
    parent = np.arange(n)
    for e in range(len(edges)):
        i, j = edges[e, 0], edges[e, 1]
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        while parent[j] != j:
            parent[j] = parent[parent[j]]
            j = parent[j]
        if i < j:  # the first node of a component is its root
            parent[j] = i
        else:
            parent[i] = j
    label, count = np.empty(n, dtype=np.int64), 0
    for i in range(n):
        if parent[i] == i:
            label[i] = count
            count += 1
        else:
            label[i] = label[parent[i]]
    return label


@with_loops(_connected_labels)
def connected_labels(edges: IntArray, n: int) -> IntArray:
    """The component of each of the nodes 0 .. n - 1 of a graph with these edges, (#E, 2).

    Components are numbered from 0, in the order of their first nodes.
    """
    graph = sparse.csr_array((np.ones(len(edges), dtype=np.int8), edges.T), shape=(n, n))
    return np.asarray(csgraph.connected_components(graph, directed=False)[1], dtype=np.int64)


def _in_one_piece(sides: IntArray, n_faces: int) -> bool:
    parent, pieces = np.arange(n_faces), n_faces
    for e in range(sides.shape[1]):
        if sides[1, e] < 0:
            continue
        i, j = sides[0, e] % n_faces, sides[1, e] % n_faces
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        while parent[j] != j:
            parent[j] = parent[parent[j]]
            j = parent[j]
        if i != j:
            pieces -= 1
            parent[max(i, j)] = min(i, j)
    return pieces <= 1


@with_loops(_in_one_piece)
def in_one_piece(sides: IntArray, n_faces: int) -> bool:
    """Whether every face can be reached from face 0 across edges; `sides` as in `Topology`.

    Checked for every disk before it is flattened.
    """
    neighbour = np.arange(3 * n_faces) % n_faces  # a half-edge on the boundary leads back to its own face
    first, second = sides
    inside = second >= 0
    a, b = first[inside], second[inside]
    neighbour[a], neighbour[b] = b % n_faces, a % n_faces
    graph = sparse.csr_array(
        (
            np.ones(3 * n_faces, dtype=np.int8),
            np.ascontiguousarray(neighbour.reshape(3, n_faces).T, dtype=np.int32).ravel(),
            np.arange(0, 3 * n_faces + 1, 3, dtype=np.int32),
        ),
        shape=(n_faces, n_faces),
    )
    reached = csgraph.breadth_first_order(graph, 0, directed=True, return_predecessors=False)
    return len(reached) == n_faces
