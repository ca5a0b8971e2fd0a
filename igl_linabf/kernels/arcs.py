"""Seams as graphs: their arcs, edges in rows from joint to joint, and the pieces that they open."""

import numpy as np

from .._types import BoolArray, IntArray
from .choice import with_loops
from .connectivity import connected_labels, root

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


def _opened(
    ends: IntArray, faces: IntArray, seam: IntArray, holes: int, n: int, n_faces: int
) -> tuple[int, int, IntArray]:
    on, parent = np.zeros(len(ends), dtype=np.bool_), np.full(n, -1, dtype=np.int64)
    parent[:holes] = np.arange(holes)
    number, cycles = holes, 0
    for e in seam:
        if on[e]:
            continue
        on[e] = True
        for k in range(2):
            if parent[ends[e, k]] < 0:
                parent[ends[e, k]] = ends[e, k]
                number += 1
        i, j = root(parent, ends[e, 0]), root(parent, ends[e, 1])
        parent[max(i, j)] = min(i, j)
        number -= i != j
        cycles += i == j
    pieces = n_faces if cycles else 1  # a forest separates nothing
    whole = np.full(1, n_faces)
    if pieces == 1:
        return number, cycles, whole
    piece = np.arange(n_faces)
    for e in range(len(faces)):
        if not on[e]:
            i, j = root(piece, faces[e, 0]), root(piece, faces[e, 1])
            piece[max(i, j)] = min(i, j)
            pieces -= i != j
            if pieces == 1:
                return number, cycles, whole
    size = np.zeros(n_faces, dtype=np.int64)
    for face in range(n_faces):
        piece[face] = piece[piece[face]]  # the root of a lower face is known
        size[piece[face]] += 1
    return number, cycles, np.sort(size[size > 0])


@with_loops(_opened)
def opened(
    ends: IntArray, faces: IntArray, seam: IntArray, holes: int, n: int, n_faces: int
) -> tuple[int, int, IntArray]:
    """What a seam, edges of a graph on a surface, opens: its components and cycles, and the pieces.

    `ends` and `faces` are the nodes and the faces of each edge, (#E, 2); the first nodes, the holes, are on
    the seam. The pieces are given by their numbers of faces, ascending.
    """
    on = np.zeros(n, dtype=bool)
    on[:holes], on[ends[seam]] = True, True
    nodes = int(np.count_nonzero(on))
    number = int(connected_labels(ends[seam], n).max()) + 1 - (n - nodes)
    cycles = number + len(np.unique(seam)) - nodes  # two ways that have become one are no cycle
    if not cycles:
        return number, cycles, np.array([n_faces])
    sides = faces.copy()
    sides[seam] = 0  # a face is beside itself
    return number, cycles, np.sort(np.bincount(connected_labels(sides, n_faces)))
