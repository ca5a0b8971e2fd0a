"""The point of a graph where three ways meet that are shortest in total."""

import numpy as np

from .._types import BoolArray, FloatArray, IntArray
from .choice import inlined, with_loops
from .heaps import reached, taken_first
from .paths import nearest_sources

Sources = tuple[IntArray, IntArray, IntArray]


@inlined
def _noted(k: int, node: int, distance: FloatArray, apart: FloatArray) -> None:
    """Note how far a set is from the other two by way of a node that its search has reached."""
    for j in range(3):
        if j != k:
            apart[3 - k - j] = min(apart[3 - k - j], distance[k, node] + distance[j, node])


def _meeting(
    indptr: IntArray, indices: IntArray, length: FloatArray, sources: Sources, open_: BoolArray, limit: float
) -> tuple[IntArray, IntArray]:
    # The three searches grow at the same rate. None goes on to where the ways to the other two sets are over
    # the limit, as long as these are at least: what a node was found with that both have reached, or as far
    # as they have come.
    n, centre, best = len(indptr) - 1, -1, limit
    distance, before = np.full((3, n), np.inf), np.full((3, n), -1, dtype=np.int64)
    place, heap = np.full((3, n), -1, dtype=np.int64), np.empty((3, n), dtype=np.int64)
    size, reach, top = np.zeros(3, dtype=np.int64), np.empty(3), np.zeros(3)
    apart, done = np.full(3, np.inf), np.zeros(n, dtype=np.int8)  # apart[k]: the sets other than k
    for k in range(3):
        for node in sources[k]:
            if place[k, node] < 0:
                distance[k, node], heap[k, size[k]], place[k, node] = 0.0, node, size[k]
                size[k] += 1
                _noted(k, node, distance, apart)
    while True:
        next_ = -1
        for k in range(3):
            one, other = (k + 1) % 3, (k + 2) % 3
            reach[k] = best * (1 + 1e-9) - min(apart[k], top[one] + top[other])
            if size[k] and top[k] <= reach[k] and (next_ < 0 or top[k] < top[next_]):
                next_ = k
        if next_ < 0:
            break
        k = next_
        node = taken_first(heap[k], place[k], distance[k], size[k])
        size[k] -= 1
        done[node] += 1
        if done[node] == 3:
            total = distance[0, node] + distance[1, node] + distance[2, node]
            if total < best or (total == best and (centre < 0 or node < centre)):
                best, centre = total, node
        for at in range(indptr[node], indptr[node + 1]):
            there, way = indices[at], distance[k, node] + length[at]
            if open_[there] and way < distance[k, there] and way <= reach[k]:
                size[k] = reached(there, way, node, heap[k], place[k], distance[k], before[k], size[k])
                _noted(k, there, distance, apart)
        top[k] = distance[k, heap[k, 0]] if size[k] else np.inf
    start, steps = np.zeros(4, dtype=np.int64), 0
    for k in range(3):
        node = centre
        while node >= 0:
            node, steps = before[k, node], steps + 1
        start[k + 1] = steps
    nodes, steps = np.empty(steps, dtype=np.int64), 0
    for k in range(3):
        node = centre
        while node >= 0:
            nodes[steps], node, steps = node, before[k, node], steps + 1
    return nodes, start


@with_loops(_meeting)
def meeting(
    indptr: IntArray, indices: IntArray, length: FloatArray, sources: Sources, open_: BoolArray, limit: float
) -> tuple[IntArray, IntArray]:
    """The ways to three sets of nodes from the node where they are shortest in total.

    The nodes of the three ways, one after the other, each from there to the first one in the set; and where
    each way begins, (4,). There are none if the total is over the limit. The graph is given as in CSR; nodes
    that are not open are not passed, but those of a set by the way to it.
    """
    searches = []
    for own in sources:
        passed = open_.copy()
        passed[own] = True
        searches.append(nearest_sources(indptr, indices, length, own, passed, limit))
    total = searches[0][0] + searches[1][0] + searches[2][0]
    centre = int(np.argmin(total))
    nodes, start = list[int](), [0]
    for _, before, _ in searches:
        node = centre if total[centre] <= limit else -1
        while node >= 0:
            nodes.append(node)
            node = int(before[node])
        start.append(len(nodes))
    return np.array(nodes, dtype=np.int64), np.array(start)
