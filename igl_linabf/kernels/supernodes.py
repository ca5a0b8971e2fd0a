"""The analysis of a sparse Cholesky factorisation by supernodes, as loops (Liu 1992).

A supernode is a run of columns of the factor with the same rows below them. `supernodal` factors these.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray, IntArray
from .choice import inlined, only_loops
from .unsigned import ONE, TWO, index

SMALL, MEDIUM = 16, 48  # columns
ZEROS_OF_SMALL, ZEROS_OF_MEDIUM, ZEROS = 0.5, 0.1, 0.05  # share of a supernode's entries that may be zeros
WIDTH = 4  # columns that are eliminated together

Numbers = NDArray[np.int32]
Places = NDArray[np.uint32]  # unsigned, as the compiled loops then need not look for negative ones


class Supernodes(NamedTuple):
    """A pattern, analysed.

    Attributes
    ----------
    order : (n,) int64
        The row of A that comes at each place: P A P^T = L L^T.
    column : (n + 1,) int64
    source, target : uint32 arrays
        The lower triangle of P A P^T by columns: where in A's data each entry is, and where it goes among
        the values of its supernode.
    start : (#s + 1,) int64
        The first column of each supernode.
    below_start : (#s + 1,) int64
    below, local : uint32 arrays
        The rows below each supernode's columns, ascending, and where they are in its parent's front.
    children : (#s,) int64
        How many children each has in the elimination tree.
    value_start : (#s + 1,) int64
        Where its part of L's values begins, a row of it for each column.
    stack, front : int
        Sizes of the work space.
    """

    order: IntArray
    column: IntArray
    source: Places
    target: Places
    start: IntArray
    below_start: IntArray
    below: Places
    local: Places
    children: IntArray
    value_start: IntArray
    stack: int
    front: int


@inlined
def padded(rows: Any) -> Any:
    """The rows of what is left of a front, up to a multiple of `WIDTH`."""
    return rows + (WIDTH - 1) & -WIDTH


@inlined
def _permuted(indptr: IntArray, indices: IntArray, place: IntArray) -> tuple[IntArray, Numbers, Places]:
    """The lower triangle of P A P^T by columns, `place` being the inverse of the order."""
    n = len(place)
    column = np.zeros(n + 2, dtype=np.uint64)
    for j in range(index(n)):
        own = index(place[j])
        for p in range(index(indptr[j]), index(indptr[j + ONE])):
            column[min(own, index(place[index(indices[p])])) + TWO] += ONE
    for j in range(index(n)):
        column[j + TWO] += column[j + ONE]
    row, source = np.empty(indptr[n], dtype=np.int32), np.empty(indptr[n], dtype=np.uint32)
    for j in range(index(n)):
        own = index(place[j])
        for p in range(index(indptr[j]), index(indptr[j + ONE])):
            other = index(place[index(indices[p])])
            first = min(own, other) + ONE
            at = column[first]
            column[first] = at + ONE
            row[at], source[at] = max(own, other), p
    return column.astype(np.int64), row, source


@inlined
def _by_rows(column: IntArray, row: Numbers, n: int) -> tuple[IntArray, Numbers]:
    """The same entries by rows: where each row begins, and their columns."""
    begin = np.zeros(n + 2, dtype=np.int64)
    for q in range(len(row)):
        begin[row[q] + 2] += 1
    for j in range(n):
        begin[j + 2] += begin[j + 1]
    before = np.empty(len(row), dtype=np.int32)
    for j in range(n):
        for q in range(column[j], column[j + 1]):
            before[begin[row[q] + 1]] = j
            begin[row[q] + 1] += 1
    return begin, before


@inlined
def hang(k: int, i: int, parent: Numbers | IntArray, ancestor: Numbers | IntArray) -> None:
    """Hang the tree of column k below column i of the elimination tree (Liu 1986)."""
    while k >= 0 and k < i:
        above = ancestor[k]
        ancestor[k] = i
        if above < 0:
            parent[k] = i
        k = above


@inlined
def _tree(begin: IntArray, before: Numbers, n: int) -> IntArray:
    """The parent of each column in the elimination tree; -1 at roots."""
    parent, ancestor = np.full(n, -1, dtype=np.int64), np.full(n, -1, dtype=np.int64)
    for i in range(n):
        for p in range(begin[i], begin[i + 1]):
            hang(before[p], i, parent, ancestor)
    return parent


@inlined
def in_order(
    indptr: IntArray, indices: IntArray, order: IntArray
) -> tuple[IntArray, IntArray, Numbers, Places, IntArray, Numbers, IntArray]:
    """The place of each variable; the permuted pattern by columns and by rows; its elimination tree."""
    n = len(order)
    place = np.empty(n, dtype=np.int64)
    for i in range(n):
        place[order[i]] = i
    column, row, source = _permuted(indptr, indices, place)
    begin, before = _by_rows(column, row, n)
    return place, column, row, source, begin, before, _tree(begin, before, n)


@inlined
def _counts(column: IntArray, row: Numbers, parent: IntArray) -> IntArray:
    """The number of entries of each column of L, the columns in postorder (Gilbert, Ng, Peyton 1994)."""
    n = len(parent)
    first, count = np.full(n, -1, dtype=np.int64), np.zeros(n, dtype=np.int64)
    for k in range(n):
        count[k] = first[k] < 0  # the leaves
        j = k
        while j >= 0 and first[j] < 0:
            first[j] = k
            j = parent[j]
    last_first, last_leaf = np.full(n, -1, dtype=np.int64), np.full(n, -1, dtype=np.int64)
    ancestor = np.arange(n)
    for j in range(n):
        if parent[j] >= 0:
            count[parent[j]] -= 1
        for q in range(column[j], column[j + 1]):
            i = row[q]
            if i == j or first[j] <= last_first[i]:
                continue
            # j is a leaf of the subtree of row i: from there up, its path is new to the least common ancestor
            last_first[i] = first[j]
            leaf = last_leaf[i]
            last_leaf[i] = j
            count[j] += 1
            if leaf >= 0:
                top = leaf
                while top != ancestor[top]:
                    top = ancestor[top]
                while leaf != top:
                    ancestor[leaf], leaf = top, ancestor[leaf]
                count[top] -= 1
        if parent[j] >= 0:
            ancestor[j] = parent[j]
    for j in range(n):
        if parent[j] >= 0:
            count[parent[j]] += count[j]
    return count


@inlined
def _columns(parent: IntArray, count: IntArray) -> tuple[IntArray, IntArray]:
    """The first columns of the supernodes, and the rows of each; small ones take in zeros to be wider."""
    n = len(parent)
    start, number = np.empty(n + 1, dtype=np.int64), 0
    for j in range(n):
        if j == 0 or parent[j - 1] != j or count[j - 1] != count[j] + 1:
            start[number] = j
            number += 1
    start[number] = n
    end, size, zeros = np.empty(number, np.int64), np.empty(number, np.int64), np.zeros(number, np.int64)
    first = np.ones(number, dtype=np.bool_)
    for s in range(number - 1, -1, -1):
        end[s], size[s] = start[s + 1], count[start[s]]
        if s == number - 1 or parent[start[s + 1] - 1] != start[s + 1]:
            continue
        own, width = end[s] - start[s], end[s + 1] - start[s]
        rows = own + size[s + 1]
        missing = zeros[s + 1] + own * (rows - size[s])
        share = ZEROS_OF_SMALL if width <= SMALL else ZEROS_OF_MEDIUM if width <= MEDIUM else ZEROS
        if width <= WIDTH or missing < share * (width * rows - width * (width - 1) / 2):
            first[s + 1] = False
            end[s], size[s], zeros[s] = end[s + 1], rows, missing
    kept = np.flatnonzero(first)
    return np.append(start[kept], n), size[kept]


@inlined
def _places(
    column: IntArray,
    row: Numbers,
    start: IntArray,
    below_start: IntArray,
    below: Places,
    children: IntArray,
    place: IntArray,
) -> tuple[Places, Places]:
    """`Supernodes.target` and `local`; `place` is work space."""
    target, local = np.empty(len(row), dtype=np.uint32), np.empty(len(below), dtype=np.uint32)
    waiting, last = np.empty(len(children), dtype=np.int64), 0
    for s in range(len(children)):
        first, width, under = start[s], start[s + 1] - start[s], below_start[s]
        size = width + below_start[s + 1] - under
        for j in range(width):
            place[first + j] = j
        for k in range(size - width):
            place[below[under + k]] = width + k
        for j in range(width):
            for p in range(column[first + j], column[first + j + 1]):
                target[p] = j * size + place[row[p]]
        for _ in range(children[s]):  # in postorder, the children are on top
            last -= 1
            for k in range(below_start[waiting[last]], below_start[waiting[last] + 1]):
                local[k] = place[below[k]]
        if size > width:
            waiting[last] = s
            last += 1
    return target, local


@inlined
def _below(begin: IntArray, before: Numbers, of: Places, above: Places, below_start: IntArray) -> Places:
    """The rows below each supernode, `of` being that of each column and `above` the parent of each."""
    below, end = np.empty(below_start[-1], dtype=np.uint32), below_start.astype(np.uint32)
    seen = np.full(len(above), len(of), dtype=np.uint32)
    for i in range(index(len(of))):
        seen[of[i]] = i
        for p in range(index(begin[i]), index(begin[i + ONE])):
            s = of[index(before[p])]
            while seen[s] != i:  # row i is in the supernodes up the tree from there
                seen[s] = i
                below[end[s]] = i
                end[s] += 1
                s = above[s]
    return below


def _supernodes(
    indptr: IntArray, indices: IntArray, order: IntArray
) -> tuple[IntArray, Places, Places, IntArray, IntArray, Places, Places, IntArray, IntArray, int, int]:
    n = len(order)
    place, column, row, source, begin, before, parent = in_order(indptr, indices, order)
    start, size = _columns(parent, _counts(column, row, parent))
    number = len(size)
    of, above = np.empty(n, dtype=np.uint32), np.empty(number, dtype=np.uint32)
    below_start, value_start = np.zeros(number + 1, np.int64), np.zeros(number + 1, np.int64)
    for s in range(number):
        width = start[s + 1] - start[s]
        below_start[s + 1] = below_start[s] + size[s] - width
        value_start[s + 1] = value_start[s] + size[s] * width
        for j in range(start[s], start[s + 1]):
            of[j] = s
    children, left = np.zeros(number, dtype=np.int64), np.zeros(number, dtype=np.int64)
    depth = stack = front = 0
    for s in range(number):
        depth += padded(size[s] - (start[s + 1] - start[s])) ** 2 - left[s]
        stack, front = max(stack, depth), max(front, size[s])
        if parent[start[s + 1] - 1] >= 0:
            above[s] = of[parent[start[s + 1] - 1]]
            children[above[s]] += 1
            left[above[s]] += padded(below_start[s + 1] - below_start[s]) ** 2
    below = _below(begin, before, of, above, below_start)
    target, local = _places(column, row, start, below_start, below, children, place)
    column = column[: n + 1].copy()
    return column, source, target, start, below_start, below, local, children, value_start, stack, front


_analysed = only_loops(_supernodes)


def supernodes(indptr: IntArray, indices: IntArray, order: IntArray) -> Supernodes:
    """Analyse a symmetric pattern, given by its lower triangle in CSC, for a postordered elimination."""
    return Supernodes(order, *_analysed(indptr, indices, order))


def _doubled(a: Supernodes, indptr: IntArray, indices: IntArray) -> tuple[Places, Places]:
    n = len(a.order)
    place, own = np.empty(n, dtype=np.int64), np.empty(len(indices), dtype=np.int64)
    for i in range(n):
        place[a.order[i]] = i
    for j in range(n):
        own[indptr[j] : indptr[j + 1]] = place[j]
    source, target = np.empty(4 * len(indices), dtype=np.uint32), np.empty(4 * len(indices), dtype=np.uint32)
    for s in range(len(a.children)):
        size = a.start[s + 1] - a.start[s] + a.below_start[s + 1] - a.below_start[s]
        for p in range(a.column[a.start[s]], a.column[a.start[s + 1]]):
            j, i, k = a.target[p] // size, a.target[p] % size, a.source[p]
            across = place[indices[k]] < own[k]
            for c in range(2):
                for r in range(2):
                    source[4 * p + 2 * c + r] = 4 * k + (2 * r + c if across else 2 * c + r)
                    left, right = (r, c) if i == j and r < c else (c, r)
                    target[4 * p + 2 * c + r] = (2 * j + left) * 2 * size + 2 * i + right
    return source, target


_doubled_entries = only_loops(_doubled)


def doubled(a: Supernodes, indptr: IntArray, indices: IntArray) -> Supernodes:
    """The same of matrices with 2 by 2 blocks for entries.

    Their data are U's of U + U^T, as in `block_product`, but that the two diagonal entries of a block on the
    diagonal are whole there.
    """

    def twice(numbers: Any) -> Any:
        return (2 * numbers[:, None] + np.arange(2, dtype=numbers.dtype)).ravel()

    source, target = _doubled_entries(a, indptr, indices)
    return Supernodes(
        order=twice(a.order),
        column=4 * np.append(np.repeat(a.column[:-1], 2), a.column[-1]),
        source=source,
        target=target,
        start=2 * a.start,
        below_start=2 * a.below_start,
        below=twice(a.below),
        local=twice(a.local),
        children=a.children,
        value_start=4 * a.value_start,
        stack=4 * a.stack,
        front=2 * a.front,
    )


def _subtrees(a: Supernodes, work: FloatArray) -> tuple[IntArray, FloatArray]:
    first, total = np.arange(len(work)), work.copy()
    waiting, last = np.empty(len(work), dtype=np.int64), 0
    for s in range(len(work)):
        for _ in range(a.children[s]):
            last -= 1
            first[s] = first[waiting[last]]
            total[s] += total[waiting[last]]
        if a.below_start[s + 1] > a.below_start[s]:
            waiting[last] = s
            last += 1
    return first, total


subtrees = only_loops(_subtrees)
subtrees.__doc__ = (
    """The first supernode of each one's subtree, which are in postorder, and the work in it."""
)
