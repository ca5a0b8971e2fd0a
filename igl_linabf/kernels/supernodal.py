"""The Cholesky factorisation of a sparse matrix by supernodes, as loops (Duff, Reid 1983; Liu 1992).

The front of a supernode is a dense matrix: the rows of A that belong to its columns, and what its children in
the elimination tree leave. The front's columns are eliminated; what is left of the front goes to its parent.
Subtrees do not touch each other, so threads work at several of them at a time; the supernodes above them come
after. There is no form in NumPy: CHOLMOD's factor, in the same order, defines this one. On meshes of 10,000
to 200,000 triangles it takes less than half of CHOLMOD's time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._types import FloatArray, IntArray
from .choice import only_loops
from .fronts import add, add_leaf, eliminate, eliminate_in_threads
from .supernodes import Supernodes, padded
from .unsigned import ONE, ZERO, index

THIN = 2  # columns up to which what a leaf leaves goes to its parent's front at once
ALL, FRONT, LEAVE = 0, 1, 2  # of the work at a supernode: what is before its elimination, and after it
DIGITS = 1e-5  # share of a diagonal entry below which its pivot has no digits left in single precision


class Subtrees(NamedTuple):
    """Subtrees of an elimination tree, and the supernodes above them.

    Attributes
    ----------
    number : (#s,) int64
        Of which subtree a supernode is the root; -1 for others.
    left, rows : (#subtrees + 1,) int64
        Where what a root leaves begins: its matrix, and the rows of a right side.
    """

    number: IntArray
    left: IntArray
    rows: IntArray


def _fresh(size: int) -> FloatArray:
    return np.empty(size)


fresh = only_loops(_fresh)
fresh.__doc__ = """An array that is not filled, in small pages.

NumPy asks the system for large ones, and gigabytes of these take it longer than the factor takes.
"""


class Work(NamedTuple):
    """Work space.

    Attributes
    ----------
    stack : (Supernodes.stack,) float
        What fronts leave for their parents.
    space : (Supernodes.front^2,) float
        What is left of a front.
    least : (Supernodes.front,) float
        What pivots of a front must exceed.
    waiting : (#,) int64
        The supernodes whose parents come later.
    size : (2,) int64
        How many these are, and how much of the stack is in use; zeros at first.
    """

    stack: FloatArray
    space: FloatArray
    least: FloatArray
    waiting: IntArray
    size: IntArray


def _factor(
    data: FloatArray,
    a: Supernodes,
    parts: Subtrees,
    which: IntArray,
    root: int,
    values: FloatArray,
    left: FloatArray,
    work: Work,
    does: int = ALL,
) -> np.int64:
    # a look into a tuple counts who refers to the array
    source, target, column, start, value_start = a.source, a.target, a.column, a.start, a.value_start
    below_start, local, children = a.below_start, a.local, a.children
    number, left_start, least, waiting = parts.number, parts.left, work.least, work.waiting
    stack, space, last, top = work.stack, work.space, index(work.size[0]), index(work.size[1])
    digits = values.dtype.type(DIGITS if values.itemsize < 8 else 0)
    for s in which:
        first, width = index(start[s]), index(start[s + 1] - start[s])
        m = index(below_start[s + 1] - below_start[s])
        if number[s] >= 0 and s != root:  # it is done
            if m:
                waiting[last] = s
                last += ONE
            continue
        at, size = index(value_start[s]), width + m
        thin = children[s] == 0 and width <= THIN
        rest = ZERO if thin else index(padded(below_start[s + 1] - below_start[s]))
        if does != LEAVE:
            for i in range(at, at + width * size):
                values[i] = 0.0
            for i in range(index(column[first]), index(column[first + width])):
                values[at + target[i]] += data[source[i]]
            for j in range(width):
                least[j] = digits * values[at + j * size + j]
            for i in range(rest * rest):
                space[i] = 0.0
            for _ in range(children[s]):
                last -= ONE
                c = waiting[last]
                wide, under = index(start[c + 1] - start[c]), index(below_start[c])
                n = index(below_start[c + 1]) - under
                step = index(padded(below_start[c + 1] - below_start[c]))
                if number[c] >= 0:
                    begin = index(left_start[number[c]])
                    add(left, begin, step, local, under, n, values, at, width, size, space, rest)
                elif children[c] == 0 and wide <= THIN:
                    begin = index(value_start[c])
                    add_leaf(values, begin, wide, local, under, n, values, at, width, size, space, rest)
                else:
                    top -= step * step
                    add(stack, top, step, local, under, n, values, at, width, size, space, rest)
        if does == ALL:
            bad = eliminate(values, at, width, size, space, rest, least)
            if bad >= 0:
                return np.int64(first) + bad
        if does != FRONT:
            if s == root:
                begin = index(left_start[number[s]])
                for i in range(rest * rest):
                    left[begin + i] = space[i]
            else:
                for i in range(rest * rest):
                    stack[top + i] = space[i]
                top += rest * rest
            if m:
                waiting[last] = s
                last += ONE
    work.size[0], work.size[1] = last, top
    return np.int64(-1)


supernodal_factor = only_loops(_factor)
supernodal_factor.__doc__ = """Fill L's values by the supernodes `which`; the place of a bad pivot, or -1.

These are those of the subtree with this root, in order. With root -1 they are some of those above all
subtrees, and of the roots of these, which leave their rests in `left`. Values, rests and work space are of
one precision, double or single.
"""


def supernodal_front(
    data: FloatArray, a: Supernodes, parts: Subtrees, s: int, values: FloatArray, left: FloatArray, work: Work
) -> int:
    """The same for one large supernode above all subtrees, in which threads share the work."""
    args = data, a, parts, np.array([s]), -1, values, left, work
    width, m = int(a.start[s + 1] - a.start[s]), int(a.below_start[s + 1] - a.below_start[s])
    supernodal_factor(*args, FRONT)
    front = int(a.value_start[s]), width, width + m
    bad = eliminate_in_threads(values, *front, work.space, padded(m), work.least)
    if bad >= 0:
        return int(a.start[s] + bad)
    return int(supernodal_factor(*args, LEAVE))
