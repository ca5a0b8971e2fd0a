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
from .supernodes import Supernodes

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
) -> int:
    least, waiting, stack, last, top = work.least, work.waiting, work.stack, work.size[0], work.size[1]
    digits = values.dtype.type(DIGITS if values.itemsize < 8 else 0)
    for s in which:
        first, width = a.start[s], a.start[s + 1] - a.start[s]
        m = a.below_start[s + 1] - a.below_start[s]
        if parts.number[s] >= 0 and s != root:  # it is done
            if m:
                waiting[last] = s
                last += 1
            continue
        block = values[a.value_start[s] : a.value_start[s + 1]]
        rest = 0 if a.children[s] == 0 and width <= THIN else m
        L, U = block.reshape(width, width + m), work.space[: rest * rest].reshape(rest, rest)
        if does != LEAVE:
            block[:] = 0.0
            for p in range(a.column[first], a.column[first + width]):
                block[a.target[p]] += data[a.source[p]]
            for j in range(width):
                least[j] = digits * block[j * (width + m + 1)]
            for j in range(rest):
                U[j, j:] = 0.0
            for _ in range(a.children[s]):
                last -= 1
                c = waiting[last]
                wide, to = a.start[c + 1] - a.start[c], a.local[a.below_start[c] : a.below_start[c + 1]]
                if parts.number[c] >= 0:
                    begin = parts.left[parts.number[c]]
                    add(left[begin : begin + len(to) ** 2], to, L, U)
                elif a.children[c] == 0 and wide <= THIN:
                    add_leaf(values[a.value_start[c] : a.value_start[c + 1]], wide, to, L, U)
                else:
                    top -= len(to) ** 2
                    add(stack[top : top + len(to) ** 2], to, L, U)
        if does == ALL:
            bad = eliminate(L, U, least)
            if bad >= 0:
                return int(first + bad)
        if does != FRONT:
            if s == root:
                begin = parts.left[parts.number[s]]
                kept = left[begin : begin + rest * rest]
            else:
                kept = stack[top : top + rest * rest]
                top += rest * rest
            for j in range(rest):
                kept[j * rest + j : (j + 1) * rest] = U[j, j:]
            if m:
                waiting[last] = s
                last += 1
    work.size[0], work.size[1] = last, top
    return -1


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
    width, rest = int(a.start[s + 1] - a.start[s]), int(a.below_start[s + 1] - a.below_start[s])
    supernodal_factor(*args, FRONT)
    L = values[a.value_start[s] : a.value_start[s + 1]].reshape(width, width + rest)
    bad = eliminate_in_threads(L, work.space[: rest**2].reshape(rest, rest), work.least)
    if bad >= 0:
        return int(a.start[s] + bad)
    return supernodal_factor(*args, LEAVE)
