"""Separators that divide a large graph again and again, as loops (George 1973; Karypis, Kumar 1998).

The graph is coarsened: stars of vertices become one. What is coarse is halved with a short cut, each half
again; every halving coarsens further, and moves vertices across the cut on the way back. On the graph itself,
the fewest vertices near each cut that part its sides are its separator: by Menger, as many as there are paths
across without a common vertex. Eliminated last, the separators save minimum degree half of the factor's work.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._types import IntArray
from .choice import inlined, only_loops
from .minimum_degree import Numbers, linked

PART = 6_000  # vertices of a part about which minimum degree is as good
STAR = 4  # vertices that become one
COARSEST, STARTS = 100, 8  # vertices of the graph that is halved by trial, and the trials
ROUNDS, MOVES = 8, 60  # of moves across a cut; in each so many in vain, and then these are taken back
UNEVEN = 0.55  # share of a graph in the larger half
NEAR = 2  # edges from a cut within which its separator is looked for
NONE, END = -1, -2  # of a path's vertices before and after another one


class Graph(NamedTuple):
    """An undirected graph with weights.

    Attributes
    ----------
    begin : (n + 1,) int64
    ends : (2 #edges,) int32
        The neighbours of each vertex, those of vertex i from `begin[i]` on.
    along, weight : (2 #edges,) and (n,) int32
        How many edges and vertices of the finest graph these are.
    """

    begin: IntArray
    ends: Numbers
    along: Numbers
    weight: Numbers


@inlined
def _stars(g: Graph, most: int) -> tuple[Numbers, Numbers]:
    """Clusters of a vertex and some neighbours, by the most edges: that of each vertex, and their weights."""
    n = len(g.weight)
    cluster, weight, number = np.full(n, -1, np.int32), np.zeros(n, np.int32), 0
    for v in range(n):
        if cluster[v] >= 0:
            continue
        cluster[v], own, alone = number, g.weight[v], True
        for _ in range(STAR - 1):
            best, strength = -1, 0
            for p in range(g.begin[v], g.begin[v + 1]):
                u = g.ends[p]
                if cluster[u] < 0 and g.along[p] > strength and own + g.weight[u] <= most:
                    best, strength = u, g.along[p]
            if best < 0:
                break
            cluster[best], alone = number, False
            own += g.weight[best]
        if alone:
            best, strength = -1, 0
            for p in range(g.begin[v], g.begin[v + 1]):
                c = cluster[g.ends[p]]
                if c >= 0 and c != number and g.along[p] > strength and weight[c] + own <= most:
                    best, strength = c, g.along[p]
            if best >= 0:
                cluster[v] = best
                weight[best] += own
                continue
        weight[number] = own
        number += 1
    return cluster, weight[:number].copy()


@inlined
def _contracted(g: Graph, cluster: Numbers, weight: Numbers) -> Graph:
    """The graph of clusters."""
    n, number = len(cluster), len(weight)
    first = np.zeros(number + 2, dtype=np.int64)
    for v in range(n):
        first[cluster[v] + 2] += 1
    for c in range(number):
        first[c + 2] += first[c + 1]
    member = np.empty(n, dtype=np.int32)
    for v in range(n):
        member[first[cluster[v] + 1]] = v
        first[cluster[v] + 1] += 1
    begin, place, last = np.zeros(number + 1, np.int64), np.full(number, -1, np.int64), 0
    ends, along = np.empty(len(g.ends), np.int32), np.empty(len(g.ends), np.int32)
    for c in range(number):
        for q in range(first[c], first[c + 1]):
            v = member[q]
            for p in range(g.begin[v], g.begin[v + 1]):
                d = cluster[g.ends[p]]
                if d == c:
                    continue
                if place[d] < begin[c]:
                    place[d], ends[last], along[last] = last, d, 0
                    last += 1
                along[place[d]] += g.along[p]
        begin[c + 1] = last
    return Graph(begin, ends[:last].copy(), along[:last].copy(), weight)


@inlined
def _grown(g: Graph, start: int, side: Numbers) -> int:
    """Let side 0 be the half that is nearest to a vertex; return the farthest one."""
    n, total, own = len(side), g.weight.sum(), 0
    side[:] = -1
    waiting, top, next_one = np.empty(n, dtype=np.int32), 0, 0
    for k in range(n):
        if k == top:  # another component
            while top and side[next_one] >= 0:
                next_one += 1
            waiting[top] = next_one if top else start
            top += 1
        v = waiting[k]
        side[v] = 1
        if 2 * own < total:
            side[v] = 0
            own += g.weight[v]
        for p in range(g.begin[v], g.begin[v + 1]):
            u = g.ends[p]
            if side[u] < 0:
                side[u], waiting[top] = 1, u
                top += 1
    return int(waiting[n - 1])


@inlined
def _move(g: Graph, v: int, side: Numbers, gain: Numbers) -> None:
    """Move a vertex to the other side; a gain is what the cut loses by a vertex's move."""
    side[v], gain[v] = 1 - side[v], -gain[v]
    for p in range(g.begin[v], g.begin[v + 1]):
        u = g.ends[p]
        gain[u] += 2 * g.along[p] if side[u] != side[v] else -2 * g.along[p]


@inlined
def _improved(g: Graph, side: Numbers) -> int:
    """Shorten the cut by the moves of Fiduccia and Mattheyses (1982); return its length."""
    n, total, own, cut = len(side), g.weight.sum(), 0, 0
    gain = np.zeros(n, dtype=np.int32)
    for v in range(n):
        own += g.weight[v] * (1 - side[v])
        for p in range(g.begin[v], g.begin[v + 1]):
            across = side[g.ends[p]] != side[v]
            gain[v] += g.along[p] if across else -g.along[p]
            cut += g.along[p] * across
    cut //= 2
    moved, near, is_near = np.empty(n, np.int32), np.empty(n, np.int32), np.empty(n, np.bool_)
    for _ in range(ROUNDS):
        count = 0
        is_near[:] = False
        for v in range(n):
            for p in range(g.begin[v], g.begin[v + 1]):
                if side[g.ends[p]] != side[v]:
                    near[count], is_near[v] = v, True
                    count += 1
                    break
        k, best, least, at = 0, 0, cut, cut
        while k - best < MOVES:
            pick, larger = -1, max(own, total - own)
            for q in range(count):
                v = near[q]
                if pick >= 0 and gain[v] <= gain[near[pick]]:
                    continue
                after = own - g.weight[v] if side[v] == 0 else own + g.weight[v]
                after = max(after, total - after)
                if after <= UNEVEN * total or after < larger:
                    pick = q
            if pick < 0:
                break
            v = near[pick]
            count -= 1
            near[pick] = near[count]
            own += g.weight[v] if side[v] else -g.weight[v]
            at -= gain[v]
            _move(g, v, side, gain)
            for p in range(g.begin[v], g.begin[v + 1]):
                u = g.ends[p]
                if not is_near[u]:
                    near[count], is_near[u] = u, True
                    count += 1
            moved[k] = v
            k += 1
            if at < least or (at == least and max(own, total - own) < larger):
                least, best = at, k
        for q in range(k - 1, best - 1, -1):
            v = moved[q]
            own += g.weight[v] if side[v] else -g.weight[v]
            _move(g, v, side, gain)
        cut = least
        if not best:
            break
    return int(cut)


@inlined
def _halved(g: Graph) -> Numbers:
    """The side of each vertex, 0 or 1, with a short cut between halves."""
    finer, clusters = [g], [np.empty(0, dtype=np.int32)]
    most = max(STAR, g.weight.sum() * 3 // (2 * COARSEST))
    while len(g.weight) > COARSEST:
        cluster, weight = _stars(g, most)
        if len(weight) > 0.85 * len(cluster):
            break
        g = _contracted(g, cluster, weight)
        finer.append(g)
        clusters.append(cluster)
    n = len(g.weight)
    side, best, least = np.empty(n, np.int32), np.zeros(n, np.int32), -1
    start = _grown(g, 0, side)
    for trial in range(STARTS):
        far = _grown(g, start, side)
        cut = _improved(g, side)
        if least < 0 or cut < least:
            least, best[:] = cut, side
        start = far if not trial else trial * n // STARTS
    for k in range(len(finer) - 1, 0, -1):
        best = best[clusters[k]]
        _improved(finer[k - 1], best)
    return best


@inlined
def _labelled(g: Graph, depth: int) -> Numbers:
    """The part of each vertex: its bits say in which half it is, from the first halving on."""
    n = len(g.weight)
    label, member, place = np.zeros(n, np.int32), np.arange(n).astype(np.int32), np.full(n, -1, np.int32)
    start = np.array([0, n])
    for _ in range(depth):
        starts = np.zeros(2 * len(start) - 1, dtype=np.int64)
        for part in range(len(start) - 1):
            own = member[start[part] : start[part + 1]].copy()
            size, room = len(own), 0
            for i in range(size):
                place[own[i]] = i
                room += g.begin[own[i] + 1] - g.begin[own[i]]
            begin, last = np.zeros(size + 1, np.int64), 0
            ends, along = np.empty(room, np.int32), np.empty(room, np.int32)
            for i in range(size):
                for p in range(g.begin[own[i]], g.begin[own[i] + 1]):
                    if place[g.ends[p]] >= 0:
                        ends[last], along[last] = place[g.ends[p]], g.along[p]
                        last += 1
                begin[i + 1] = last
            for i in range(size):
                place[own[i]] = -1
            side = np.zeros(size, dtype=np.int32)
            if size > 1:
                side = _halved(Graph(begin, ends[:last].copy(), along[:last].copy(), g.weight[own]))
            low, high = start[part], start[part + 1]
            for i in range(size):
                label[own[i]] = 2 * label[own[i]] + side[i]
                if side[i]:
                    high -= 1
                    member[high] = own[i]
                else:
                    member[low] = own[i]
                    low += 1
            starts[2 * part + 1], starts[2 * part + 2] = low, start[part + 1]
        start = starts
    return label


@inlined
def _other_half(g: Graph, v: int, label: Numbers, last: Numbers, shift: int) -> int:
    """A neighbour in the other half of the same part, or -1."""
    for p in range(g.begin[v], g.begin[v + 1]):
        u = g.ends[p]
        if not last[u] and label[u] >> shift == (label[v] >> shift) ^ 1:
            return int(u)
    return -1


@inlined
def _reached(g: Graph, band: Numbers, place: Numbers, end: Numbers) -> NDArray[np.bool_]:
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
                        j = place[g.ends[g.begin[band[i]] + at[i]]]
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


def _separators(indptr: IntArray, indices: IntArray, depth: int) -> Numbers:
    n = len(indptr) - 1
    begin, lists = linked(indptr, indices)
    ends = lists[: begin[n]].copy()
    g = coarse = Graph(begin, ends, np.ones(len(ends), np.int32), np.ones(n, np.int32))
    of = np.arange(n).astype(np.int32)
    for _ in range(2):
        cluster, weight = _stars(coarse, 64)
        coarse = _contracted(coarse, cluster, weight)
        of = cluster[of]
    label, last, place = _labelled(coarse, depth)[of], np.zeros(n, np.int32), np.full(n, -1, np.int32)
    near, is_near, count = np.empty(n, dtype=np.int32), np.zeros(n, dtype=np.bool_), 0
    for v in range(n):
        for p in range(begin[v], begin[v + 1]):
            if label[ends[p]] != label[v]:
                near[count], is_near[v] = v, True
                count += 1
                break
    band = np.empty(n, dtype=np.int32)
    for shift in range(depth - 1, -1, -1):
        m, ring = 0, 0
        for q in range(count):
            v = near[q]
            if not last[v] and _other_half(g, v, label, last, shift) >= 0:
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
        seen = _reached(g, band[:m], place, end)
        for i in range(m):
            v = band[i]
            if seen[2 * i] and not seen[2 * i + 1]:
                last[v] = shift + 1
        for i in range(m):
            v = band[i]
            place[v] = -1
            if not last[v] and label[v] >> shift & 1 == seen[2 * i + 1]:
                to = _other_half(g, v, label, last, shift)
                label[v] = label[to] if to >= 0 else ((label[v] >> shift) ^ 1) << shift
                for p in range(begin[v], begin[v + 1]):
                    u = ends[p]
                    if not is_near[u]:
                        near[count], is_near[u] = u, True
                        count += 1
    return last


_found = only_loops(_separators)


def separators(indptr: IntArray, indices: IntArray) -> Numbers:
    """At which turn each vertex of a symmetric pattern is to be eliminated, (n,): after all of smaller ones.

    The pattern is given by its lower triangle in CSC. Those of turn 0 are in no separator.
    """
    n = len(indptr) - 1
    return _found(indptr, indices, max(round(np.log2(max(n, 1) / PART)), 0))
