"""Fans: the faces around a vertex, connected by its edges."""

import numpy as np

from .._types import IntArray
from .choice import with_loops
from .connectivity import connected_labels


def _fans_around(corner: IntArray, sides: IntArray, n: int) -> IntArray:
    m, vertex = corner.shape[1], corner.ravel()
    step = np.full((2, 3 * m), -1, dtype=np.int64)  # from each corner around its vertex, either way
    for e in range(sides.shape[1]):
        if sides[1, e] >= 0:
            for k in range(2):  # a half-edge runs from the corner after the one opposite to the next one
                one, other = sides[k, e], sides[1 - k, e]
                start = one + m if one < 2 * m else one - 2 * m
                end = other + 2 * m if other < m else other - m
                step[0, start], step[1, end] = end, start
    number, known = np.zeros(n, dtype=np.int64), np.zeros(3 * m, dtype=np.bool_)
    for first in range(3 * m):
        if known[first]:
            continue
        number[vertex[first]] += 1
        known[first] = True
        for turn in range(2):
            at = step[turn, first]
            while at >= 0 and not known[at]:
                known[at] = True
                at = step[turn, at]
    return number


@with_loops(_fans_around)
def fans_around(corner: IntArray, sides: IntArray, n: int) -> IntArray:
    """How many fans each of n vertices has, by the corners (3, #F) and the sides of edges of a `Topology`."""
    m = corner.shape[1]
    a, b = sides[:, sides[1] >= 0]
    # half-edge (k, t) has its ends at corners k + 1 and k + 2; across an edge, end meets start
    ka, ta, kb, tb = a // m, a % m, b // m, b % m
    start, end = (np.column_stack(((ka + i) % 3 * m + ta, (kb + 3 - i) % 3 * m + tb)) for i in (1, 2))
    label = connected_labels(np.concatenate((start, end)), 3 * m)
    vertex = np.empty(int(label.max()) + 1, dtype=np.int64)
    vertex[label] = corner.ravel()
    return np.bincount(vertex, minlength=n)
