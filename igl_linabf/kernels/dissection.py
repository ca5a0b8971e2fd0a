"""Nested dissection: separators divide a large graph again and again, as loops (George 1973).

The fewest vertices near a cut that part its sides are its separator: by Menger, as many as there are paths
across without a common vertex. Eliminated last, separators save minimum degree half of a factor's work; and
threads order the parts, each of which fits the cache.
"""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._runtime import in_threads
from .._types import IntArray
from .choice import inlined, only_loops
from .halving import Graph, contracted, halved_again, stars
from .minimum_degree import Numbers, in_postorder, linked, minimum_degree
from .supernodes import hang

PART = 6_000  # vertices of a part about which minimum degree is as good
TOGETHER = 64  # vertices at most that are in the same half of each cut, by two rounds of coarsening
NEAR = 2  # edges from a cut within which its separator is looked for
IN_ONE_THREAD = 3  # halvings of the whole graph, after which threads take the parts
NONE, END = -1, -2  # instead of a path's vertex before or after another one


class Cut(NamedTuple):
    """A graph with cuts between parts, where separators are looked for.

    Attributes
    ----------
    begin, ends : (n + 1,) int64, (#ends,) int32
        Where the neighbours of each vertex begin, and these.
    label : (n,) int32
        The part of each vertex: its bits say in which half it is, from the first halving on.
    last : (n,) int32
        At which turn each vertex is eliminated, if it is in a separator that has been found; else 0.
    place : (n,) int32
        Work space: -1.
    is_near : (n,) bool
        Which vertices are listed as having been at a cut at some time.
    """

    begin: IntArray
    ends: Numbers
    label: Numbers
    last: Numbers
    place: Numbers
    is_near: NDArray[np.bool_]


@inlined
def _other_half(g: Cut, v: int, shift: int) -> int:
    """A neighbour in the other half of the same part, or -1."""
    for p in range(g.begin[v], g.begin[v + 1]):
        u = g.ends[p]
        if not g.last[u] and g.label[u] >> shift == (g.label[v] >> shift) ^ 1:
            return int(u)
    return -1


@inlined
def _reached(g: Cut, band: Numbers, end: Numbers) -> NDArray[np.bool_]:
    """Where a search comes to that starts at ends 1 of a band, crossing as many paths to ends 2 as there are.

    The paths have no common vertex. Entries 2 i and 2 i + 1 tell whether the search enters vertex i, and
    whether it leaves it: a vertex that it only enters is in the separator.
    """
    m = len(band)
    before, after, at = np.full(m, NONE, np.int32), np.full(m, NONE, np.int32), np.empty(m, np.int32)
    seen, path, found = np.empty(2 * m, np.bool_), np.empty(2 * m, np.int32), True
    while found:
        found = False
        seen[:] = False
        at[:] = 0
        for b in range(m):
            if not end[b] & 1 or seen[2 * b]:
                continue
            seen[2 * b] = True
            if before[b] == END:
                continue
            k, path[0] = 0, 2 * b
            while k >= 0:
                i, to = path[k] >> 1, NONE
                if path[k] & 1:
                    if end[i] & 2 and after[i] != END:
                        break
                    if before[i] != NONE and not seen[2 * i]:
                        to = 2 * i
                    while to < 0 and at[i] < g.begin[band[i] + 1] - g.begin[band[i]]:
                        j = g.place[g.ends[g.begin[band[i]] + at[i]]]
                        at[i] += 1
                        if j >= 0 and not seen[2 * j]:
                            to = 2 * j
                elif before[i] == NONE:
                    to = 2 * i + 1
                elif before[i] >= 0:  # back along the path that is there
                    to = 2 * before[i] + 1
                if to < 0 or seen[to]:
                    k -= 1
                else:
                    k += 1
                    path[k], seen[to] = to, True
            if k < 0:
                continue
            found = True
            before[b], after[path[k] >> 1] = END, END
            for q in range(k):
                i, j = path[q] >> 1, path[q + 1] >> 1
                if path[q] & 1:
                    after[i], before[j] = (j, i) if i != j else (NONE, NONE)
    return seen


def _neighbours(indptr: IntArray, indices: IntArray) -> tuple[IntArray, Numbers]:
    n = len(indptr) - 1
    begin, lists = linked(indptr, indices)
    return begin[: n + 1], lists[: begin[n]].copy()


def _coarsened(begin: IntArray, ends: Numbers) -> tuple[Graph, Numbers]:
    """The graph of clusters, and the cluster of each vertex."""
    n = len(begin) - 1
    coarse = Graph(begin, ends, np.ones(len(ends), np.int32), np.ones(n, np.int32))
    of = np.arange(n).astype(np.int32)
    for _ in range(2):
        cluster, weight = stars(coarse, TOGETHER)
        coarse = contracted(coarse, cluster, weight)
        of = cluster[of]
    return coarse, of


def _cut(begin: IntArray, ends: Numbers, coarse: Graph, of: Numbers, part: Numbers) -> tuple[Cut, Numbers]:
    """The graph cut where its clusters are in different parts, and the vertices near there."""
    n = len(of)
    across = np.zeros(len(part), dtype=np.bool_)
    for c in range(len(part)):
        for p in range(coarse.begin[c], coarse.begin[c + 1]):
            if part[coarse.ends[p]] != part[c]:
                across[c] = True
    near, is_near, count = np.empty(n, dtype=np.int32), np.zeros(n, dtype=np.bool_), 0
    for v in range(n):
        if not across[of[v]]:
            continue
        for p in range(begin[v], begin[v + 1]):
            if part[of[ends[p]]] != part[of[v]]:
                near[count], is_near[v] = v, True
                count += 1
                break
    place = np.full(n, -1, dtype=np.int32)
    return Cut(begin, ends, part[of], np.zeros(n, np.int32), place, is_near), near[:count].copy()


def _separated(g: Cut, listed: Numbers, high: int, low: int) -> Numbers:
    """Find the separators of some cuts, `high` to `low`, near listed vertices; return these and new ones.

    What other threads change meanwhile is behind separators that have been found.
    """
    begin, ends, label, last, place, is_near = g
    n, count = len(label), len(listed)
    near, band = np.empty(n, dtype=np.int32), np.empty(n, dtype=np.int32)
    near[:count] = listed
    for shift in range(high, low - 1, -1):
        m, ring = 0, 0
        for q in range(count):
            v = near[q]
            if not last[v] and _other_half(g, v, shift) >= 0:
                band[m], place[v] = v, m
                m += 1
        for _ in range(NEAR):
            ring, until = m, ring
            for i in range(until, ring):
                v = band[i]
                for p in range(begin[v], begin[v + 1]):
                    u = ends[p]
                    if not last[u] and place[u] < 0:
                        band[m], place[u] = u, m
                        m += 1
        end = np.zeros(m, dtype=np.int32)
        for i in range(m):
            v = band[i]
            for p in range(begin[v], begin[v + 1]):
                if not last[ends[p]] and place[ends[p]] < 0:
                    end[i] |= 1 + (label[v] >> shift & 1)
        seen = _reached(g, band[:m], end)
        for i in range(m):
            v = band[i]
            if seen[2 * i] and not seen[2 * i + 1]:
                last[v] = shift + 1
        for i in range(m):
            v = band[i]
            place[v] = -1
            if not last[v] and label[v] >> shift & 1 == seen[2 * i + 1]:
                to = _other_half(g, v, shift)
                label[v] = label[to] if to >= 0 else ((label[v] >> shift) ^ 1) << shift
                for p in range(begin[v], begin[v + 1]):
                    u = ends[p]
                    if not last[u] and not is_near[u]:
                        near[count], is_near[u] = u, True
                        count += 1
    return near[:count].copy()


def _in_postorder(begin: IntArray, ends: Numbers, order: IntArray) -> IntArray:
    """The order with the children in its elimination tree right before each vertex."""
    n = len(order)
    place = np.empty(n, dtype=np.int32)
    for i in range(n):
        place[order[i]] = i
    parent, ancestor = np.full(n, -1, dtype=np.int32), np.full(n, -1, dtype=np.int32)
    for i in range(n):
        for p in range(begin[order[i]], begin[order[i] + 1]):
            hang(place[ends[p]], i, parent, ancestor)
    made: IntArray = order[in_postorder(parent, np.full(n, -1, dtype=np.int32), np.ones(n, dtype=np.bool_))]
    return made


class Parts(NamedTuple):
    """The parts of a graph that separators leave, some of them together.

    Attributes
    ----------
    begin, ends : (n + 1,) int64, (#ends,) int32
        Where the neighbours of each vertex begin, and these.
    listed : (n,) int32
        The vertices, part after part, and then the separators' in turn.
    start : (#parts + 1,) int64
        Where each part begins among these, and the separators.
    place : (n,) int32
        Of each vertex in its part; -1 in separators.
    """

    begin: IntArray
    ends: Numbers
    listed: Numbers
    start: IntArray
    place: Numbers


def _parts(begin: IntArray, ends: Numbers, turn: Numbers, least: int) -> Parts:
    n = len(turn)
    listed, start = np.empty(n, dtype=np.int32), np.zeros(n + 1, dtype=np.int64)
    seen, done, size, count = turn > 0, 0, 0, 0
    for first in range(n):
        if seen[first]:
            continue
        listed[size], seen[first] = first, True
        size += 1
        while done < size:
            v = listed[done]
            done += 1
            for p in range(begin[v], begin[v + 1]):
                u = ends[p]
                if not seen[u]:
                    listed[size], seen[u] = u, True
                    size += 1
        if size - start[count] >= least:
            count += 1
            start[count] = size
    if size > start[count]:
        count += 1
        start[count] = size
    rest = np.flatnonzero(turn > 0)
    listed[size:] = rest[np.argsort(turn[rest], kind="mergesort")]
    place = np.full(n, -1, dtype=np.int32)
    for k in range(count):
        for q in range(start[k], start[k + 1]):
            place[listed[q]] = q - start[k]
    return Parts(begin, ends, listed, start[: count + 1], place)


def _pattern_of(parts: Parts, k: int) -> tuple[IntArray, IntArray]:
    """The pattern of part k, as its lower triangle in CSC."""
    begin, ends, place = parts.begin, parts.ends, parts.place
    part = parts.listed[parts.start[k] : parts.start[k + 1]]
    indptr, room = np.zeros(len(part) + 1, dtype=np.int64), 0
    for v in part:
        room += begin[v + 1] - begin[v] + 1
    indices, size = np.empty(room, dtype=np.int64), 0
    for j in range(len(part)):
        v = part[j]
        indices[size] = j
        size += 1
        for p in range(begin[v], begin[v + 1]):
            i = place[ends[p]]
            if i > j:
                indices[size] = i
                size += 1
        indptr[j + 1] = size
    return indptr, indices[:size]


_coarse, _halved, _at_cuts = only_loops(_coarsened), only_loops(halved_again), only_loops(_cut)
_found, _postordered = only_loops(_separated), only_loops(_in_postorder)
_in_parts, _part = only_loops(_parts), only_loops(_pattern_of)

neighbours = only_loops(_neighbours)
neighbours.__doc__ = """Where the neighbours of each vertex of a symmetric pattern begin, (n + 1,), and these.

The pattern is given by its lower triangle in CSC.
"""


def separators(begin: IntArray, ends: Numbers) -> Numbers:
    """At which turn each vertex of a graph is to be eliminated, (n,): after all of smaller ones.

    The graph is given by its `neighbours`. Those of turn 0 are in no separator.
    """
    depth = max(round(np.log2(max(len(begin) - 1, 1) / PART)), 0)
    first = min(depth, IN_ONE_THREAD)
    rest, parts = depth - first, range(1 << first)
    coarse, of = _coarse(begin, ends)
    part = _halved(coarse, np.arange(len(coarse.weight), dtype=np.int32), first)
    chosen = [np.flatnonzero(part == k).astype(np.int32) for k in parts]
    labels = list(in_threads(lambda vertices: _halved(coarse, vertices, rest), chosen))
    part <<= rest
    for vertices, label in zip(chosen, labels, strict=True):
        part[vertices] += label
    cut, near = _at_cuts(begin, ends, coarse, of, part)
    near = _found(cut, near, depth - 1, rest)
    number = cut.label[near] >> rest
    deque(in_threads(lambda k: _found(cut, near[number == k], rest - 1, 0), parts), maxlen=0)
    return cut.last


def dissected(indptr: IntArray, indices: IntArray) -> IntArray:
    """The postordered order for a symmetric pattern by nested dissection, and minimum degree in each part."""
    graph = neighbours(indptr, indices)
    parts = _in_parts(*graph, separators(*graph), PART // 2)

    def ordered(k: int) -> IntArray:
        order: IntArray = parts.listed[parts.start[k] + minimum_degree(*_part(parts, k))].astype(np.int64)
        return order

    orders = in_threads(ordered, range(len(parts.start) - 1))
    order = np.concatenate((*orders, parts.listed[parts.start[-1] :]), dtype=np.int64)
    return _postordered(*graph, order)
