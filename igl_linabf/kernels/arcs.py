"""The arcs of a graph: its edges in rows, from joint to joint."""

import numpy as np

from .._types import BoolArray, IntArray
from .choice import with_loops

Arcs = tuple[IntArray, IntArray, IntArray]


def _arcs_between(ends: IntArray, joint: BoolArray) -> Arcs:
    n, m = len(joint), len(ends)
    begin = np.zeros(n + 1, dtype=np.int64)
    for e in range(m):
        begin[ends[e, 0] + 1] += 1
        begin[ends[e, 1] + 1] += 1
    order, known = np.empty(2 * m, dtype=np.int64), 0
    for v in range(n):
        begin[v + 1] += begin[v]
    beside, to, filled = np.empty(2 * m, np.int64), np.empty(2 * m, np.int64), begin.copy()
    for e in range(m):
        for k in range(2):
            node = ends[e, k]
            if filled[node] == begin[node]:
                order[known], known = node, known + 1
            beside[filled[node]], to[filled[node]] = e, ends[e, 1 - k]
            filled[node] += 1
    taken = np.zeros(m, dtype=np.bool_)
    edges, nodes = np.empty(m, dtype=np.int64), np.empty(2 * m, dtype=np.int64)
    start, number, size = np.empty(m + 1, dtype=np.int64), 0, 0
    for closed in range(2):
        for first in order[:known]:
            if not (closed or joint[first]):
                continue
            for step in range(begin[first], begin[first + 1]):
                if taken[beside[step]]:
                    continue
                start[number], nodes[size + number], at = size, first, step
                while True:
                    taken[beside[at]], edges[size], node, size = True, beside[at], to[at], size + 1
                    nodes[size + number] = node
                    if joint[node] or node == first:
                        break
                    at = begin[node] + (beside[begin[node]] == beside[at])
                number += 1
    start[number] = size
    return edges, nodes[: size + number].copy(), start[: number + 1].copy()


@with_loops(_arcs_between)
def arcs_between(ends: IntArray, joint: BoolArray) -> Arcs:
    """The edges of a graph, by their ends (#E, 2), in rows from joint to joint; then closed rows without any.

    All nodes without exactly two edges have to be joints. Returns the edges of all arcs in their order, the
    nodes that these pass, from the first to the last, and where the edges of each arc begin. The nodes of arc
    k begin k later, as it has one more. Arcs begin in the order of edges.
    """
    steps: dict[int, list[tuple[int, int]]] = {}
    for edge, (i, j) in enumerate(ends.tolist()):
        steps.setdefault(i, []).append((edge, j))
        steps.setdefault(j, []).append((edge, i))
    edges, nodes, start, taken = list[int](), list[int](), [0], set[int]()
    for first in [*(node for node in steps if joint[node]), *steps]:
        for edge, node in steps[first]:
            if edge in taken:
                continue
            edges.append(edge)
            nodes += [first, node]
            while not joint[node] and node != first:
                one, other = steps[node]
                edge, node = one if one[0] != edge else other
                edges.append(edge)
                nodes.append(node)
            taken.update(edges[start[-1] :])
            start.append(len(edges))
    return np.array(edges, np.int64), np.array(nodes, np.int64), np.array(start)
