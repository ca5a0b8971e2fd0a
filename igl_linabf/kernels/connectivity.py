"""Half-edges joined to edges, and the pattern of a matrix over a graph."""

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .._runtime import at_once, unfilled
from .._types import BoolArray, IntArray
from .choice import inlined, instead, pieces_of, run, with_loops
from .triangles import NEXT, PREV

Joined = tuple[IntArray, IntArray, bool]
Entries = tuple[IntArray, IntArray, IntArray]
LOW_BITS = 2**32 - 1  # of a key, where its second number stands


@inlined
def sort_part(keys: IntArray, begin: int, end: int) -> None:
    """Sort a part of an array where it is (Shell 1959); most parts have a few entries."""
    gap = 1
    while 3 * gap < end - begin:
        gap = 3 * gap + 1
    while gap:
        for i in range(begin + gap, end):
            key, j = keys[i], i
            while j >= begin + gap and keys[j - gap] > key:
                keys[j] = keys[j - gap]
                j -= gap
            keys[j] = key
        gap //= 3


@inlined
def root(parent: IntArray, i: int) -> int:
    """The root of node i in a forest (union-find), whose paths are halved on the way."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@inlined
def _by_lower_end(corner: IntArray, begin: IntArray, keys: IntArray) -> None:
    """Put the half-edges where those of their lower ends are, `begin[v]` to `begin[v + 1]`.

    A key is the higher end, the half-edge, and whether that leaves the higher end. `begin`, (n + 2,), is zero
    before.
    """
    m = corner.shape[1]
    for t in range(m):
        for k in range(3):
            begin[min(corner[(k + 1) % 3, t], corner[(k + 2) % 3, t]) + 2] += 1
    for v in range(2, len(begin)):
        begin[v] += begin[v - 1]
    for t in range(m):
        for k in range(3):
            tail, head = corner[(k + 1) % 3, t], corner[(k + 2) % 3, t]
            at = begin[min(tail, head) + 1]
            keys[at] = (max(tail, head) << 32) | (2 * (k * m + t) + np.int64(head < tail))
            begin[min(tail, head) + 1] += 1


@inlined
def _sorted_edges(begin: IntArray, keys: IntArray, first: int, last: int) -> int:
    """Sort the keys of the vertices `first` up to `last`; the number of their edges."""
    size = 0
    for v in range(first, last):
        sort_part(keys, begin[v], begin[v + 1])
        high = np.int64(-1)
        for i in range(begin[v], begin[v + 1]):
            size += keys[i] >> 32 != high
            high = keys[i] >> 32
    return size


@inlined
def _put_edges(
    begin: IntArray, keys: IntArray, first: int, last: int, at: int, edges: IntArray, sides: IntArray
) -> bool:
    """Write the edges of these vertices from row `at` on; whether they are sound."""
    e, sound = at - 1, True
    for v in range(first, last):
        last_high = np.int64(-1)
        for i in range(begin[v], begin[v + 1]):
            high, h, down = keys[i] >> 32, (keys[i] & LOW_BITS) >> 1, keys[i] & 1
            if high != last_high:
                e += 1
                last_high = high
                edges[e, down], edges[e, 1 - down] = v, high
                sides[0, e], sides[1, e] = h, -1
            elif sides[1, e] >= 0 or edges[e, down] == v:
                sound = False
            else:
                sides[1, e] = h
    return sound


def _undirected(corner: IntArray, n: int) -> Joined:
    begin, keys = np.zeros(n + 2, dtype=np.int64), np.empty(3 * corner.shape[1], dtype=np.int64)
    _by_lower_end(corner, begin, keys)
    size = _sorted_edges(begin, keys, 0, n)
    edges, sides = np.empty((size, 2), dtype=np.int64), np.empty((2, size), dtype=np.int64)
    return edges, sides, _put_edges(begin, keys, 0, n, 0, edges, sides)


def _undirected_in_threads(corner: IntArray, n: int) -> Joined:
    pieces = pieces_of(n)
    if len(pieces) == 1:
        return run(_undirected, corner, n)
    begin, keys = np.zeros(n + 2, dtype=np.int64), unfilled(3 * corner.shape[1], np.int64)
    run(_by_lower_end, corner, begin, keys)
    sizes = at_once(lambda piece: run(_sorted_edges, begin, keys, *piece), pieces)
    at = np.cumsum([0, *sizes])
    size = int(at[-1])
    edges, sides = unfilled((size, 2), np.int64), unfilled((2, size), np.int64)
    sound = at_once(
        lambda k: run(_put_edges, begin, keys, *pieces[k], at[k], edges, sides), range(len(pieces))
    )
    return edges, sides, all(sound)


def in_edges(tail: IntArray, head: IntArray, n: int) -> tuple[IntArray, IntArray, IntArray]:
    """Sides in the order of their edges, by vertices below n; where each edge begins, and how many it has."""
    key = np.minimum(tail, head) * n + np.maximum(tail, head)
    bits = len(key).bit_length()
    if n * n < 2 ** (63 - bits):  # a sort of numbers takes a tenth of the time of a stable order
        both = np.sort((key << bits) | np.arange(len(key)))
        order, key = both & ((1 << bits) - 1), both >> bits
    else:
        order = np.argsort(key, kind="stable")
        key = key[order]
    starts = np.ones(len(key), dtype=bool)
    np.not_equal(key[1:], key[:-1], out=starts[1:])
    begin = np.flatnonzero(starts)
    return order, begin, np.diff(begin, append=len(key))


@instead(_undirected_in_threads, _undirected)
def undirected(corner: IntArray, n: int) -> Joined:
    """The edges of triangles, (3, #F): their ends, (#E, 2), sides, (2, #E), and whether they are sound.

    Ends and sides are as in `Topology`, the edges sorted by their lower and higher ends. They are sound where
    none has more than two sides, or two that run the same way.
    """
    tail, head = corner[NEXT].ravel(), corner[PREV].ravel()
    order, begin, count = in_edges(tail, head, n)
    first, second = order[begin], order[np.minimum(begin + 1, len(order) - 1)]
    same_way = tail[first] == tail[second]
    sides = np.stack((first, np.where((count > 1) & ~same_way, second, -1)))
    sound = not (count > 2).any() and not (same_way & (count == 2)).any()
    return np.column_stack((tail[first], head[first])), sides, sound


def _used_vertices(F: IntArray, n: int) -> tuple[BoolArray, bool]:
    used, sound = np.zeros(n, dtype=np.bool_), True
    for t in range(len(F)):
        a, b, c = F[t, 0], F[t, 1], F[t, 2]
        if a == b or b == c or c == a or min(a, b, c) < 0 or max(a, b, c) >= n:
            sound = False
        else:
            used[a] = used[b] = used[c] = True
    return used, sound


@with_loops(_used_vertices)
def used_vertices(F: IntArray, n: int) -> tuple[BoolArray, bool]:
    """Which of n vertices sound faces have, and whether all are: indices in range, none of them twice."""
    sound = ((F >= 0) & (n > F)).all(axis=1) & (F[:, NEXT] != F).all(axis=1)
    used = np.zeros(n, dtype=bool)
    used[F[sound]] = True
    return used, bool(sound.all())


def _entries(ends: IntArray, n: int) -> Entries:
    size = ends.shape[1]
    begin, before, in_order = np.zeros(n + 2, dtype=np.int64), np.int64(-1), True
    for e in range(size):
        low, high = min(ends[0, e], ends[1, e]), max(ends[0, e], ends[1, e])
        if low >= 0 and low != high:
            begin[low + 2] += 1
            in_order &= (low << 32) | high > before
            before = (low << 32) | high
    for v in range(n):
        begin[v + 2] += begin[v + 1]
    keys = np.empty(0 if in_order else begin[n + 1], dtype=np.int64)  # the higher row, and the edge
    indptr, indices = np.empty(n + 1, dtype=np.int64), np.empty(n + begin[n + 1], dtype=np.int64)
    slot, at = np.full(size, -1, dtype=np.int64), np.int64(-1)
    if in_order:
        for v in range(n + 1):
            indptr[v] = begin[v + 1] + v
        for v in range(n):
            indices[indptr[v]] = v
    pairs = 0
    for e in range(size):
        low, high = min(ends[0, e], ends[1, e]), max(ends[0, e], ends[1, e])
        if low >= 0 and low != high and in_order:
            slot[e] = pairs + low + 1
            indices[slot[e]] = high
            pairs += 1
        elif low >= 0 and low != high:
            keys[begin[low + 1]] = (high << 32) | e
            begin[low + 1] += 1
    if in_order:
        return indptr, indices, slot
    for v in range(n):
        at += 1
        indptr[v] = at
        indices[at] = v
        sort_part(keys, begin[v], begin[v + 1])
        for i in range(begin[v], begin[v + 1]):
            high = keys[i] >> 32
            if high != indices[at]:
                at += 1
                indices[at] = high
            slot[keys[i] & LOW_BITS] = at
    indptr[n] = at + 1
    return indptr, indices[: at + 1].copy(), slot


@with_loops(_entries)
def entries(ends: IntArray, n: int) -> Entries:
    """The upper triangle of symmetric matrices over a graph of n rows; its edges join rows `ends`, (2, #E).

    Returns indptr and indices as in CSR, the diagonal first in each row, and each edge's place among the
    entries; -1 where it joins a row to itself, or to none.
    """
    low, high = ends.min(axis=0), ends.max(axis=0)
    pairs = np.flatnonzero((low >= 0) & (low != high))
    key, rows = low[pairs] * n + high[pairs], np.arange(n)
    if (key[1:] > key[:-1]).all():  # the edges come in this order
        low, high = low[pairs], high[pairs]
        place = np.arange(len(pairs)) + low + 1
        indices = np.empty(n + len(pairs), dtype=np.int64)
        indptr = np.append(0, np.cumsum(np.bincount(low, minlength=n) + 1))
        indices[indptr[:-1]], indices[place] = rows, high
    else:
        key, place = np.unique(np.concatenate((rows * n + rows, key)), return_inverse=True)
        indptr, indices, place = np.searchsorted(key, n * np.arange(n + 1)), key % n, place[n:]
    slot = np.full(ends.shape[1], -1, dtype=np.int64)
    slot[pairs] = place
    return indptr, indices, slot


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
        i, j = root(parent, edges[e, 0]), root(parent, edges[e, 1])
        parent[max(i, j)] = min(i, j)  # the first node of a component is its root
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


def _spanning_forest(pairs: IntArray, order: IntArray, n: int) -> IntArray:
    parent, chosen, size = np.arange(n), np.empty(min(n, len(order)), dtype=np.int64), 0
    for e in order:
        i, j = root(parent, pairs[e, 0]), root(parent, pairs[e, 1])
        if i != j:
            parent[max(i, j)] = min(i, j)
            chosen[size] = e
            size += 1
    return chosen[:size].copy()


@with_loops(_spanning_forest)
def spanning_forest(pairs: IntArray, order: IntArray, n: int) -> IntArray:
    """Of the edges `order`, by their pairs of n nodes, those that close no cycle with earlier ones.

    If the order is by weight, this is the minimum spanning forest (Kruskal 1956).
    """
    i, j = np.sort(pairs[order], axis=1).T
    proper = np.flatnonzero(i != j)
    _, first = np.unique(i[proper] * n + j[proper], return_index=True)  # the earliest between two nodes
    first = proper[first]
    rank = sparse.csr_array((first + 1.0, (i[first], j[first])), shape=(n, n))  # weights name the edges
    return np.asarray(order[np.sort(spanning_tree(rank).data.astype(np.int64)) - 1])


def spanning_tree(graph: sparse.csr_array) -> sparse.coo_array:
    """The minimum spanning tree of a graph, or forest, as entries of it."""
    places = (graph.indices.astype(np.int32), graph.indptr.astype(np.int32))  # SciPy 1.15 takes no others
    narrow = sparse.csr_array((graph.data, *places), shape=graph.shape)
    return sparse.coo_array(csgraph.minimum_spanning_tree(narrow))


def _in_one_piece(sides: IntArray, n_faces: int) -> bool:
    m, reached, done = n_faces, 1, 0
    beside = np.full(3 * m, m, dtype=np.int32)  # the face across each half-edge; m where there is none
    for e in range(sides.shape[1]):
        i, j = sides[0, e], sides[1, e]
        if j >= 0:  # no division, which takes longer than the rest
            beside[i] = j - m * (np.int64(j >= m) + np.int64(j >= 2 * m))
            beside[j] = i - m * (np.int64(i >= m) + np.int64(i >= 2 * m))
    new, waiting = np.ones(m + 1, dtype=np.uint8), np.zeros(m + 2, dtype=np.int32)
    new[0], new[m] = 0, 0
    while done < reached:  # a queue: the next face is known long before the last one is done
        t = waiting[done]
        done += 1
        for k in range(3):
            u = beside[k * m + t]
            waiting[reached] = u  # without a branch, of which nobody could tell where it goes
            reached += new[u]
            new[u] = 0
    return reached >= m


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
