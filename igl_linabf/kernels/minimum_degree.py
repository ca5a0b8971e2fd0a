"""An order of elimination with little fill, by approximate minimum degree, as loops.

Amestoy, Davis, Duff (1996). An eliminated variable becomes an element: the list of the variables that it has
joined to each other. A variable has a list of elements, then one of variables. Its degree is bounded by the
sum of what is in its elements. Variables with the same lists are one, of larger weight.
"""

import numpy as np
from numpy.typing import NDArray

from .._types import IntArray
from .choice import inlined, only_loops
from .supernodes import Numbers, Places, in_order
from .unsigned import ONE, TWO, ZERO, index

DENSE = 10.0  # times the root of the number of rows: degree above which a row comes last, as in AMD


@inlined
def linked(indptr: IntArray, indices: IntArray) -> tuple[IntArray, Numbers]:
    """Where the list of each variable begins, and the lists, with space for elements at the end."""
    n = len(indptr) - 1
    begin = np.zeros(n + 2, dtype=np.uint64)
    for j in range(index(n)):
        for p in range(index(indptr[j]), index(indptr[j + ONE])):
            i = index(indices[p])
            if i != j:
                begin[i + TWO] += ONE
                begin[j + TWO] += ONE
    for j in range(index(n)):
        begin[j + TWO] += begin[j + ONE]
    lists = np.empty(2 * np.int64(begin[n + 1]), dtype=np.int32)
    for j in range(index(n)):
        for p in range(index(indptr[j]), index(indptr[j + ONE])):
            i = index(indices[p])
            if i != j:
                lists[begin[i + ONE]], lists[begin[j + ONE]] = j, i
                begin[i + ONE] += ONE
                begin[j + ONE] += ONE
    return begin.astype(np.int64), lists


@inlined
def _join(i: int, j: int, weight: Numbers, follower: Numbers, tail: Places) -> None:
    """Let variable j be eliminated with i, right after it."""
    weight[j] = 0
    follower[tail[i]] = j
    tail[i] = tail[j]


@inlined
def in_postorder(parent: Numbers, follower: Numbers, pivot: NDArray[np.bool_]) -> IntArray:
    """The variables of all elements, children in a tree first; what is in none comes last."""
    n = len(parent)
    order, waiting, top, k = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int32), 0, 0
    placed = np.zeros(n, dtype=np.bool_)
    child, sibling, e = np.full(n, -1, dtype=np.int32), np.full(n, -1, dtype=np.int32), -1
    for i in range(n - 1, -1, -1):
        if not pivot[i]:
            continue
        if parent[i] >= 0:
            sibling[i], child[parent[i]] = child[parent[i]], i
        else:
            sibling[i], e = e, i
    while e >= 0 or top:
        if e >= 0:
            waiting[top], e = e, child[e]
            top += 1
            continue
        top -= 1
        i = waiting[top]
        e = sibling[i]
        while i >= 0:
            order[k], placed[i] = i, True
            i = follower[i]
            k += 1
    order[k:] = np.flatnonzero(~placed)
    return order


@inlined
def postordered(indptr: IntArray, indices: IntArray, order: IntArray) -> IntArray:
    """The order in which the children in its elimination tree come right before a variable."""
    n = len(order)
    tree = in_order(indptr, indices, order)[-1].astype(np.int32)
    place = in_postorder(tree, np.full(n, -1, dtype=np.int32), np.ones(n, dtype=np.bool_))
    made: IntArray = order[place]
    return made


@inlined
def _list(i: int, ring: int, after: Places, before: Places) -> None:
    """Put variable i first into a ring, those of one degree."""
    other = after[ring]
    after[ring], after[i] = i, other
    before[other], before[i] = i, ring


@inlined
def _unlist(i: int, after: Places, before: Places) -> None:
    """Take variable i out of its ring."""
    after[before[i]], before[after[i]] = after[i], before[i]


@inlined
def _meet(
    place: int,
    at: int,
    begin: NDArray[np.uint64],
    elements: Places,
    lists: Places,
    weight: Numbers,
    degree: Places,
    mark: IntArray,
    flag: np.int64,
) -> None:
    """Let mark - flag be how much of each older element is not in the new one, which is listed there.

    The weights of the new one's variables are negative.
    """
    for p in range(place, at):
        i = lists[p]
        w = weight[i]
        for q in range(begin[i], begin[i] + elements[i]):
            e = lists[q]
            m = mark[e]
            mark[e] = (m if m >= flag else degree[e] + flag) + w if m else 0


@inlined
def _merge(
    k: int,
    alike: Numbers,
    begin: NDArray[np.uint64],
    size: Places,
    elements: Places,
    lists: Places,
    weight: Numbers,
    follower: Numbers,
    tail: Places,
    mark: IntArray,
    flag: np.int64,
) -> np.int64:
    """Join the variables with the same lists in a chain of those with one key; the next flag."""
    while k >= 0 and alike[k] >= 0:
        i = index(k)
        for q in range(begin[i] + ONE, begin[i] + size[i]):
            mark[lists[q]] = flag
        last, k = i, alike[i]
        while k >= 0:
            j = index(k)
            same = size[j] == size[i] and elements[j] == elements[i]
            q, end = begin[j] + ONE, begin[j] + size[j]
            while same and q < end:
                same = mark[lists[q]] == flag
                q += ONE
            if same:
                weight[i] += weight[j]
                _join(i, j, weight, follower, tail)
                alike[last] = alike[j]
            else:
                last = j
            k = alike[j]
        flag += 1
        k = alike[i]
    return flag


def _minimum_degree(indptr: IntArray, indices: IntArray) -> IntArray:
    n = len(indptr) - 1
    starts, ends = linked(indptr, indices)
    begin, lists = starts.astype(np.uint64), ends.astype(np.uint32)
    free, rings = begin[n], index(n)  # the ring of degree d begins and ends at rings + d
    size, elements = np.empty(n, dtype=np.uint32), np.zeros(n, dtype=np.uint32)
    degree, weight = np.empty(n, dtype=np.uint32), np.ones(n, dtype=np.int32)
    after, before = np.arange(2 * n + 1).astype(np.uint32), np.arange(2 * n + 1).astype(np.uint32)
    parent, pivot = np.full(n, -1, dtype=np.int32), np.zeros(n, dtype=np.bool_)
    follower, tail = np.full(n, -1, dtype=np.int32), np.arange(n).astype(np.uint32)
    first_alike, alike = np.full(n, -1, dtype=np.int32), np.empty(n, dtype=np.int32)
    key, mark = np.empty(n, dtype=np.uint32), np.ones(n, dtype=np.int64)  # marks are 0 at dead elements
    done, least, flag, dense = 0, ZERO, np.int64(2), max(16, DENSE * np.sqrt(n))
    for back in range(n):
        i = index(n - 1 - back)
        d = begin[i + ONE] - begin[i]
        size[i] = degree[i] = d
        if d > dense:
            weight[i] = 0
            done += 1
        else:
            _list(i, rings + d, after, before)
    some_left = done > 0
    while done < n:
        while after[rings + least] == rings + least:
            least += ONE
        me = index(after[rings + least])
        _unlist(me, after, before)
        done += weight[me]
        weight[me] = -weight[me]
        # the new element's variables, whose weights are negative from now on
        first, old = begin[me], index(elements[me])
        own, place = first + old, first
        if old:
            place, room = free, index(size[me])
            for p in range(first, own):
                room += size[lists[p]]
            if free + room > index(len(lists)):
                lists = np.concatenate((lists, np.empty(len(lists) + np.int64(room), dtype=np.uint32)))
        at, total = place, 0
        for q in range(old + ONE):
            e = index(lists[first + q]) if q < old else me
            low = begin[e] if q < old else own
            for p in range(low, begin[e] + size[e]):
                i = lists[p]
                w = weight[i]
                if w > 0:
                    total += w
                    weight[i] = -w
                    lists[at] = i
                    at += ONE
                    _unlist(i, after, before)
            if q < old:
                parent[e] = me
                mark[e] = 0
        begin[me], degree[me], elements[me], pivot[me] = place, total, 0, True
        _meet(place, at, begin, elements, lists, weight, degree, mark, flag)
        for p in range(place, at):
            i = lists[p]
            low = begin[i]
            to, middle, end = low, low + elements[i], low + size[i]
            d, code = np.int64(0), ZERO
            for q in range(low, middle):
                e = lists[q]
                m = mark[e]
                lists[to] = e  # without a branch, which would often be mispredicted
                d += m - flag if m else 0
                code += e if m else ZERO
                to += ONE if m else ZERO
            between = to
            for q in range(middle, end):
                j = lists[q]
                w = weight[j]
                lists[to] = j
                d += w if w > 0 else 0
                code += j if w > 0 else ZERO
                to += ONE if w > 0 else ZERO
            if to == low:  # it is in the new element only: eliminated with it
                done -= weight[i]
                total += weight[i]
                _join(me, i, weight, follower, tail)
                continue
            degree[i] = min(np.int64(degree[i]), d)
            lists[to], lists[between], lists[low] = lists[between], lists[low], me  # first of the elements
            elements[i], size[i] = between - low + ONE, to - low + ONE
            code %= rings
            key[i] = code
            alike[i] = first_alike[code]
            first_alike[code] = i
        degree[me] = total
        flag += n  # above all marks
        for p in range(place, at):
            if weight[lists[p]] != 0:
                chain, first_alike[key[lists[p]]] = first_alike[key[lists[p]]], -1
                flag = _merge(chain, alike, begin, size, elements, lists, weight, follower, tail, mark, flag)
        to = place
        for p in range(place, at):
            i = index(lists[p])
            if weight[i] == 0:
                continue
            w = weight[i] = -weight[i]
            d = index(min(degree[i] + total - w, n - done - w))
            degree[i] = d
            _list(i, rings + d, after, before)
            least = min(least, d)
            lists[to] = i
            to += ONE
        size[me], weight[me] = to - place, 0
        if old:
            free = to
    order = in_postorder(parent, follower, pivot)
    return postordered(indptr, indices, order) if some_left else order  # by links that no element knows of


minimum_degree = only_loops(_minimum_degree)
minimum_degree.__doc__ = """The postordered order for a symmetric pattern, given by its lower triangle in CSC.

CHOLMOD's, by the same method, takes up to twice as long.
"""
