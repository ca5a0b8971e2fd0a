"""An order of elimination with little fill, by approximate minimum degree, as loops.

Amestoy, Davis, Duff (1996). An eliminated variable becomes an element: the list of the variables that it has
joined to each other. A variable has a list of elements, then one of variables. Its degree is bounded by the
sum of what is in its elements. Variables with the same lists are one, of larger weight.
"""

import numpy as np
from numpy.typing import NDArray

from .._types import IntArray
from .choice import inlined, only_loops
from .supernodes import Numbers, in_order

DENSE = 10.0  # times the root of the number of rows: degree above which a row comes last, as in AMD


@inlined
def linked(indptr: IntArray, indices: IntArray) -> tuple[IntArray, Numbers]:
    """Where the list of each variable begins, and the lists, with space for elements at the end."""
    n = len(indptr) - 1
    begin = np.zeros(n + 2, dtype=np.int64)
    for j in range(n):
        for p in range(indptr[j], indptr[j + 1]):
            if indices[p] != j:
                begin[indices[p] + 2] += 1
                begin[j + 2] += 1
    for j in range(n):
        begin[j + 2] += begin[j + 1]
    lists = np.empty(2 * begin[n + 1], dtype=np.int32)
    for j in range(n):
        for p in range(indptr[j], indptr[j + 1]):
            i = indices[p]
            if i != j:
                lists[begin[i + 1]], lists[begin[j + 1]] = j, i
                begin[i + 1] += 1
                begin[j + 1] += 1
    return begin, lists


@inlined
def _join(i: int, j: int, weight: Numbers, follower: Numbers, tail: Numbers) -> None:
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


def _minimum_degree(indptr: IntArray, indices: IntArray) -> IntArray:
    n = len(indptr) - 1
    begin, lists = linked(indptr, indices)
    free = begin[n]
    size, elements = np.empty(n, dtype=np.int32), np.zeros(n, dtype=np.int32)
    degree, weight = np.empty(n, dtype=np.int32), np.ones(n, dtype=np.int32)
    head, after, before = np.full(n + 1, -1, np.int32), np.empty(n, np.int32), np.empty(n, np.int32)
    parent, pivot = np.full(n, -1, dtype=np.int32), np.zeros(n, dtype=np.bool_)
    follower, tail = np.full(n, -1, dtype=np.int32), np.arange(n).astype(np.int32)
    first_alike, alike = np.full(n, -1, dtype=np.int32), np.empty(n, dtype=np.int32)
    key, mark = np.empty(n, dtype=np.int32), np.ones(n, dtype=np.int64)  # marks are 0 at dead elements
    done, least, flag, dense = 0, 0, np.int64(2), max(16, DENSE * np.sqrt(n))
    for i in range(n - 1, -1, -1):
        size[i] = degree[i] = d = begin[i + 1] - begin[i]
        if d > dense:
            weight[i] = 0
            done += 1
            continue
        after[i], before[i] = head[d], -1
        if head[d] >= 0:
            before[head[d]] = i
        head[d] = i
    some_left = done > 0
    while done < n:
        while head[least] < 0:
            least += 1
        me = head[least]
        head[least] = after[me]
        if after[me] >= 0:
            before[after[me]] = -1
        done += weight[me]
        weight[me] = -weight[me]
        # the new element's variables, whose weights are negative from now on
        first, old = begin[me], elements[me]
        own, place = first + old, first
        if old:
            place, room = free, size[me]
            for p in range(first, own):
                room += size[lists[p]]
            if free + room > len(lists):
                lists = np.concatenate((lists, np.empty(len(lists) + room, dtype=np.int32)))
        at, total = place, 0
        for q in range(old + 1):
            e = lists[first + q] if q < old else me
            low = begin[e] if q < old else own
            for p in range(low, begin[e] + size[e]):
                i = lists[p]
                if weight[i] > 0:
                    total += weight[i]
                    weight[i] = -weight[i]
                    lists[at] = i
                    at += 1
                    if after[i] >= 0:
                        before[after[i]] = before[i]
                    if before[i] >= 0:
                        after[before[i]] = after[i]
                    else:
                        head[degree[i]] = after[i]
            if q < old:
                parent[e] = me
                mark[e] = 0
        begin[me], degree[me], elements[me], pivot[me] = place, total, 0, True
        # how much of each older element is not in the new one: mark - flag
        for p in range(place, at):
            i = lists[p]
            for q in range(begin[i], begin[i] + elements[i]):
                e = lists[q]
                if mark[e] >= flag:
                    mark[e] += weight[i]
                elif mark[e]:
                    mark[e] = degree[e] + flag + weight[i]
        for p in range(place, at):
            i = lists[p]
            low = to = begin[i]
            d, code = 0, 0
            for q in range(low, low + elements[i]):
                e = lists[q]
                if mark[e]:
                    d += mark[e] - flag
                    code += e
                    lists[to] = e
                    to += 1
            between = to
            for q in range(low + elements[i], low + size[i]):
                j = lists[q]
                if weight[j] > 0:
                    d += weight[j]
                    code += j
                    lists[to] = j
                    to += 1
            if to == low:  # it is in the new element only: eliminated with it
                done -= weight[i]
                total += weight[i]
                _join(me, i, weight, follower, tail)
                continue
            degree[i] = min(degree[i], d)
            lists[to], lists[between], lists[low] = lists[between], lists[low], me  # first of the elements
            elements[i], size[i] = between - low + 1, to - low + 1
            key[i] = code % n
            alike[i] = first_alike[key[i]]
            first_alike[key[i]] = i
        degree[me] = total
        flag += n  # above all marks
        # variables with the same lists
        for p in range(place, at):
            i = lists[p]
            if weight[i] == 0:
                continue
            code = key[i]
            i = first_alike[code]
            first_alike[code] = -1
            while i >= 0 and alike[i] >= 0:
                for q in range(begin[i] + 1, begin[i] + size[i]):
                    mark[lists[q]] = flag
                last, j = i, alike[i]
                while j >= 0:
                    same = size[j] == size[i] and elements[j] == elements[i]
                    q = begin[j] + 1
                    while same and q < begin[j] + size[j]:
                        same = mark[lists[q]] == flag
                        q += 1
                    if same:
                        weight[i] += weight[j]
                        _join(i, j, weight, follower, tail)
                        alike[last] = alike[j]
                    else:
                        last = j
                    j = alike[j]
                flag += 1
                i = alike[i]
        to = place
        for p in range(place, at):
            i = lists[p]
            if weight[i] == 0:
                continue
            weight[i] = -weight[i]
            degree[i] = d = min(degree[i] + total - weight[i], n - done - weight[i])
            after[i], before[i] = head[d], -1
            if head[d] >= 0:
                before[head[d]] = i
            head[d] = i
            least = min(least, d)
            lists[to] = i
            to += 1
        size[me], weight[me] = to - place, 0
        if old:
            free = to
    order = in_postorder(parent, follower, pivot)
    return postordered(indptr, indices, order) if some_left else order  # by links that no element knows of


minimum_degree = only_loops(_minimum_degree)
minimum_degree.__doc__ = """The postordered order for a symmetric pattern, given by its lower triangle in CSC.

CHOLMOD's, by the same method, takes up to twice as long.
"""
