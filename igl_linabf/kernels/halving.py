"""Halving a graph again and again with short cuts, as loops (Karypis, Kumar 1998).

The graph is coarsened: stars of vertices become one. The coarsest one is halved by trial. On the way back to
the finest, vertices move across the cut where that shortens it (Fiduccia, Mattheyses 1982).
"""

from typing import NamedTuple

import numpy as np

from .._types import IntArray
from .choice import inlined
from .minimum_degree import Numbers

STAR = 4  # vertices that become one
COARSEST, STARTS = 100, 8  # vertices of the graph that is halved by trial, and the trials
ROUNDS, MOVES = 8, 60  # of moves across a cut; in each so many in vain, and then these are taken back
UNEVEN = 0.55  # share of a graph in the larger half


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
def stars(g: Graph, most: int) -> tuple[Numbers, Numbers]:
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
def contracted(g: Graph, cluster: Numbers, weight: Numbers) -> Graph:
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
    """Shorten the cut by moving vertices across it, one after the other; return its length."""
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
        cluster, weight = stars(g, most)
        if len(weight) > 0.85 * len(cluster):
            break
        g = contracted(g, cluster, weight)
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
def halved_again(g: Graph, chosen: Numbers, depth: int) -> Numbers:
    """The part of each chosen vertex: its bits say in which half it is, from the first halving on."""
    n, member = len(g.weight), chosen.copy()
    label, place = np.zeros(n, np.int32), np.full(n, -1, np.int32)
    start = np.array([0, len(chosen)])
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
    return label[chosen]
