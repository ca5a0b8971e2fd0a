"""Shortest paths in a graph."""

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .._types import BoolArray, FloatArray, IntArray
from .choice import inlined, with_loops
from .heaps import reached, taken_first

Paths = tuple[FloatArray, IntArray, IntArray]


class Rest(NamedTuple):
    """What is left of a way to some targets, (#T, 3): at least a share of the distance in space to each.

    `position` is that of each node, (n, 3). With what is left to all of them, no way is over the `limit`.
    """

    position: FloatArray
    targets: FloatArray
    share: float
    limit: float


def _nearest_sources(
    indptr: IntArray, indices: IntArray, length: FloatArray, sources: IntArray, open_: BoolArray, limit: float
) -> Paths:
    n, size, limit = len(indptr) - 1, 0, max(limit, 0.0)
    distance, before = np.full(n, np.inf), np.full(n, -1, dtype=np.int64)
    source, place = np.full(n, -1, dtype=np.int64), np.full(n, -1, dtype=np.int64)
    heap = np.empty(n, dtype=np.int64)
    for node in sources:
        if open_[node] and place[node] < 0:
            distance[node], source[node] = 0.0, node
            heap[size], place[node] = node, size
            size += 1
    while size:
        node, size = taken_first(heap, place, distance, size), size - 1
        for at in range(indptr[node], indptr[node + 1]):
            there, way = indices[at], distance[node] + length[at]
            if open_[there] and way < distance[there] and way <= limit:
                source[there] = source[node]
                size = reached(there, way, node, heap, place, distance, before, size)
    return distance, before, source


@with_loops(_nearest_sources)
def nearest_sources(
    indptr: IntArray, indices: IntArray, length: FloatArray, sources: IntArray, open_: BoolArray, limit: float
) -> Paths:
    """The distance of each node to the nearest source, the node before it on the path, and that source.

    The graph is given as in CSR. Nodes that are not open are not reached, nor what is farther than `limit`:
    the distance is infinite there, and the nodes are -1. A limit below 0 is one of 0.
    """
    n = len(indptr) - 1
    rows = np.repeat(np.arange(n), np.diff(indptr))
    passed = np.where(open_[rows] & open_[indices], length, np.inf)
    graph = sparse.csr_array((passed, indices, indptr), shape=(n, n))
    sources = sources[open_[sources]]
    if not len(sources):
        return np.full(n, np.inf), np.full(n, -1), np.full(n, -1)
    distance, before, source = csgraph.dijkstra(
        graph, indices=sources, min_only=True, return_predecessors=True, limit=max(limit, 0.0)
    )
    return distance, np.maximum(before.astype(np.int64), -1), np.maximum(source.astype(np.int64), -1)


def _ways_towards(
    indptr: IntArray, indices: IntArray, length: FloatArray, source: int, open_: BoolArray, rest: Rest
) -> tuple[FloatArray, IntArray]:
    n, size = len(indptr) - 1, 1
    distance, before = np.full(n, np.inf), np.full(n, -1, dtype=np.int64)
    place, heap, ahead = np.full(n, -1, dtype=np.int64), np.empty(n, dtype=np.int64), np.empty(n)
    distance[source], heap[0], place[source] = 0.0, source, 0
    while size:
        node, size = taken_first(heap, place, distance, size), size - 1
        for at in range(indptr[node], indptr[node + 1]):
            there, way = indices[at], distance[node] + length[at]
            if not open_[there] or way >= distance[there]:
                continue
            if place[there] < 0:
                ahead[there] = 0.0
                for k in range(len(rest.targets)):
                    squared = 0.0
                    for j in range(3):
                        squared += (rest.position[there, j] - rest.targets[k, j]) ** 2
                    ahead[there] += rest.share * np.sqrt(squared)
            if way + ahead[there] > rest.limit:
                continue
            size = reached(there, way, node, heap, place, distance, before, size)
    return distance, before


@with_loops(_ways_towards)
def ways_towards(
    indptr: IntArray, indices: IntArray, length: FloatArray, source: int, open_: BoolArray, rest: Rest
) -> tuple[FloatArray, IntArray]:
    """The distances from a node, and the nodes before, where all ways on to the targets stay within a limit.

    As in `nearest_sources`; what is farther may be left out.
    """
    return nearest_sources(indptr, indices, length, np.array([source]), open_, rest.limit)[:2]


def _nodes_on_paths(before: IntArray, ends: IntArray) -> IntArray:
    passed, found, size = np.zeros(len(before), dtype=np.bool_), np.empty(len(before), dtype=np.int64), 0
    for end in ends:
        node = end
        while before[node] >= 0 and not passed[node]:
            passed[node], found[size] = True, node
            size += 1
            node = before[node]
    return found[:size].copy()


@with_loops(_nodes_on_paths)
def nodes_on_paths(before: IntArray, ends: IntArray) -> IntArray:
    """The nodes that lead from some ends to their sources, each once, in the order of the paths.

    `before` is the node before each one on its path, and -1 at sources, which are left out.
    """
    found: dict[int, None] = {}
    for node in ends.tolist():
        while before[node] >= 0 and node not in found:
            found[node] = None
            node = int(before[node])
    return np.array([*found], dtype=np.int64)


def _way_of_fewest(indptr: IntArray, indices: IntArray, sources: BoolArray, ends: BoolArray) -> IntArray:
    n, done, size = len(indptr) - 1, 0, 0
    before, queue = np.full(n, -2, dtype=np.int64), np.empty(n, dtype=np.int64)
    for node in range(n):
        if sources[node]:
            before[node], queue[size] = -1, node
            size += 1
    while done < size and not ends[queue[done]]:
        for at in range(indptr[queue[done]], indptr[queue[done] + 1]):
            if before[indices[at]] == -2:
                before[indices[at]], queue[size] = queue[done], indices[at]
                size += 1
        done += 1
    node, steps = queue[done] if done < size else -1, 0
    while node >= 0:  # the queue up to here is done with
        queue[steps] = node
        node, steps = before[node], steps + 1
    return queue[:steps].copy()


@with_loops(_way_of_fewest)
def way_of_fewest(indptr: IntArray, indices: IntArray, sources: BoolArray, ends: BoolArray) -> IntArray:
    """The nodes of a way of the fewest steps, from one of the `ends` back to one of the sources, both masks.

    The graph is given as in CSR. There are none if no end can be reached.
    """
    n, source = len(indptr) - 1, np.flatnonzero(sources)
    pattern = np.append(indices, source), np.append(indptr, len(indices) + len(source))
    graph = sparse.csr_array((np.ones(len(pattern[0])), *pattern), shape=(n + 1, n + 1))
    reached, before = csgraph.breadth_first_order(graph, n)  # from a node beside all sources
    at = np.flatnonzero(np.append(ends, False)[reached])[:1]
    way = reached[at].tolist()
    while way and before[way[-1]] != n:
        way.append(int(before[way[-1]]))
    return np.array(way, dtype=np.int64)


def _without_leaves(ends: IntArray, kept: BoolArray) -> BoolArray:
    degree, edges = np.zeros(len(kept), dtype=np.int64), np.zeros(len(kept), dtype=np.int64)
    for e in range(len(ends)):
        for k in range(2):
            degree[ends[e, k]] += 1
            edges[ends[e, k]] ^= e  # of a node with one edge that is left, this edge
    left = np.ones(len(ends), dtype=np.bool_)
    for e in range(len(ends)):
        for k in range(2):
            node = ends[e, k]
            while degree[node] == 1 and not kept[node]:
                last = edges[node]
                left[last] = False
                for end in range(2):
                    degree[ends[last, end]] -= 1
                    edges[ends[last, end]] ^= last
                node = ends[last, 0] + ends[last, 1] - node
    return left


@with_loops(_without_leaves)
def without_leaves(ends: IntArray, kept: BoolArray) -> BoolArray:
    """The edges of a graph, by their ends (#E, 2), that are left when those at leaves are dropped in turn.

    Leaves that are to be kept are none.
    """
    left = np.ones(len(ends), dtype=bool)
    while True:
        loose = (np.bincount(ends[left].ravel(), minlength=len(kept)) == 1) & ~kept
        drop = left & loose[ends].any(axis=1)
        if not drop.any():
            return left
        left &= ~drop


@inlined
def _begin(
    copy: int, n: int, begun: BoolArray, distance: FloatArray, before: IntArray, place: IntArray
) -> None:
    """Prepare a copy of n nodes: none is reached."""
    begun[copy] = True
    distance[copy * n : (copy + 1) * n] = np.inf
    before[copy * n : (copy + 1) * n] = -1
    place[copy * n : (copy + 1) * n] = -1


@inlined
def _cheapen(cost: FloatArray, ways: int, length: float) -> None:
    """Let sets of excursions, by the ways that they cross an odd number of times, gain one more to choose."""
    for one in range(len(cost)):
        other = one ^ ways
        if one < other:
            before = cost[one]
            cost[one] = min(before, cost[other] + length)
            cost[other] = min(cost[other], before + length)


@inlined
def _chosen(found: FloatArray) -> IntArray:
    """Of excursions the shortest set that crosses all ways; by what each crosses, 0 at first."""
    copies = len(found)
    best, taken = np.full(copies, np.inf), np.zeros((copies, copies), dtype=np.bool_)
    best[0] = 0.0
    for ways in range(1, copies):
        before = best.copy()
        for copy in range(copies):
            if before[copy ^ ways] + found[ways] < best[copy]:
                best[copy], taken[ways, copy] = before[copy ^ ways] + found[ways], True
    chosen, left, size = np.zeros(copies, dtype=np.int64), copies - 1, 1
    for ways in range(copies - 1, 0, -1):
        if taken[ways, left]:
            chosen[size], size, left = ways, size + 1, left ^ ways
    return chosen[: size if left == 0 else 0].copy()


def _shortest_odd_walk(
    indptr: IntArray, indices: IntArray, length: FloatArray, flip: IntArray, start: int, copies: int
) -> IntArray:
    # The walk is a set of excursions that pass the start at their ends only. Two ways from the start to one
    # node are an excursion, and none that is shorter than twice the least key of the heap is unknown.
    n, size, last = len(indptr) - 1, 1, copies - 1
    distance, before = np.empty(copies * n), np.empty(copies * n, dtype=np.int64)
    place, heap = np.empty(copies * n, dtype=np.int64), np.empty(copies * n, dtype=np.int64)
    begun = np.zeros(copies, dtype=np.bool_)  # most copies are never reached
    first, other_label = np.full(n, -1, dtype=np.int64), np.empty(copies * n, dtype=np.int64)
    found, ends = np.full(copies, np.inf), np.empty((copies, 2), dtype=np.int64)
    cost = np.full(copies, np.inf)
    cost[0] = 0.0
    _begin(0, n, begun, distance, before, place)
    distance[start], heap[0], place[start], first[start], other_label[start] = 0.0, start, 0, start, -1
    while size and 2 * distance[heap[0]] < cost[last]:
        node, size = taken_first(heap, place, distance, size), size - 1
        copy, label = node // n, first[node % n]
        while label >= 0 and (label == node or distance[label] + cost[copy ^ (label // n)] > distance[node]):
            label = other_label[label]
        if label >= 0:  # another way there, with excursions, does as much
            continue
        for at in range(indptr[node - copy * n], indptr[node - copy * n + 1]):
            vertex, other, way = indices[at], copy ^ flip[at], distance[node] + length[at]
            there = other * n + vertex
            if vertex != start:
                if not begun[other]:
                    _begin(other, n, begun, distance, before, place)
                if way >= distance[there]:
                    continue
                if distance[there] == np.inf:
                    other_label[there], first[vertex] = first[vertex], there
                size = reached(there, way, node, heap, place, distance, before, size)
            label = first[vertex]
            while label >= 0:
                ways = other ^ (label // n)
                if ways and way + distance[label] < found[ways]:
                    found[ways], ends[ways, 0], ends[ways, 1] = way + distance[label], node, label
                    _cheapen(cost, ways, found[ways])
                label = other_label[label]
    chosen, steps = _chosen(found), 1
    for ways in chosen[1:]:
        for end in range(2):
            at = ends[ways, end]
            while before[at] >= 0:
                at, steps = before[at], steps + 1
        steps += 1
    walk = np.empty(steps, dtype=np.int64)
    walk[0], at_copy, size = last * n + start, last, 1
    for ways in chosen[1:]:
        out, outward = ends[ways, 0], size
        while before[out] >= 0:
            walk[size], out, size = (at_copy ^ (out // n)) * n + out % n, before[out], size + 1
        walk[outward:size] = walk[outward:size][::-1].copy()
        back, at_copy = ends[ways, 1], at_copy ^ ways
        while back >= 0:
            walk[size], back, size = (at_copy ^ (back // n)) * n + back % n, before[back], size + 1
    return walk


@with_loops(_shortest_odd_walk)
def shortest_odd_walk(
    indptr: IntArray, indices: IntArray, length: FloatArray, flip: IntArray, start: int, copies: int
) -> IntArray:
    """The shortest closed walk from a node that crosses each of some ways an odd number of times.

    Bits of `flip` tell which ways an edge crosses; the graph is given as in CSR. There is a copy of it for
    each combination of bits: copy c, of the nodes from c n on, is reached over the ways of c's bits. The walk
    is given from its end, which is in the last copy; that alone if there is no such walk.
    """
    n = len(indptr) - 1
    rows, copy = np.repeat(np.arange(n), np.diff(indptr)), np.arange(copies)[:, None]
    ends = (copy * n + rows).ravel(), ((copy ^ flip) * n + indices).ravel()
    graph = sparse.csr_array((np.tile(length, copies), ends), shape=(copies * n, copies * n))
    walk, limit = [(copies - 1) * n + start], 32 * float(length.max())
    while True:  # most walks are short beside the whole graph
        distance, before = csgraph.dijkstra(graph, indices=start, return_predecessors=True, limit=limit)
        if np.isfinite(distance[walk[0]]) or not np.isfinite(limit):
            break
        limit = 4 * limit if limit < float(length.sum()) else np.inf
    while before[walk[-1]] >= 0:
        walk.append(int(before[walk[-1]]))
    return np.array(walk, dtype=np.int64)
