"""Half-edges joined to edges, for the loops over small disks."""

import numpy as np

from .._types import IntArray
from .choice import inlined

Joined = tuple[IntArray, IntArray, bool]
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


@inlined
def _undirected(corner: IntArray, n: int) -> Joined:
    begin, keys = np.zeros(n + 2, dtype=np.int64), np.empty(3 * corner.shape[1], dtype=np.int64)
    _by_lower_end(corner, begin, keys)
    size = _sorted_edges(begin, keys, 0, n)
    edges, sides = np.empty((size, 2), dtype=np.int64), np.empty((2, size), dtype=np.int64)
    return edges, sides, _put_edges(begin, keys, 0, n, 0, edges, sides)


@inlined
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


@inlined
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
