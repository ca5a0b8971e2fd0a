"""The two sheets of each overlap of a flat map."""

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .._types import IntArray
from .choice import inlined, with_loops
from .connectivity import connected_labels

ROOM = 0.8  # share of the way to where a face is on both sheets, that they are grown


@inlined
def _place_of(upper_start: IntArray, lower: IntArray, one: int, other: int) -> int:
    """The row of the pair of two faces, or -1; the rows of face f begin at `upper_start[f]`."""
    low, high = upper_start[one], upper_start[one + 1]
    while low < high:
        middle = (low + high) >> 1
        if lower[middle] < other:
            low = middle + 1
        else:
            high = middle
    return int(low) if low < upper_start[one + 1] and lower[low] == other else -1


@inlined
def _beside(
    upper_start: IntArray, upper: IntArray, lower: IntArray, begin: IntArray, neighbour: IntArray
) -> tuple[IntArray, IntArray]:
    """The pairs beside each pair, in ascending order, as in CSR."""
    number = len(upper)
    start, most = np.empty(number + 1, dtype=np.int64), 0
    for k in range(number):
        most += begin[upper[k] + 1] - begin[upper[k]] + begin[lower[k] + 1] - begin[lower[k]]
    beside, size = np.empty(most, dtype=np.int64), 0
    for k in range(number):
        start[k] = size
        for side in range(2):
            face, other = (upper[k], lower[k]) if side == 0 else (lower[k], upper[k])
            for at in range(begin[face], begin[face + 1]):
                if side == 0:
                    there = _place_of(upper_start, lower, neighbour[at], other)
                else:
                    there = _place_of(upper_start, lower, other, neighbour[at])
                if there >= 0:
                    place = size
                    while place > start[k] and beside[place - 1] > there:
                        beside[place] = beside[place - 1]
                        place -= 1
                    beside[place] = there
                    size += 1
    start[number] = size
    return start, beside


@inlined
def _flooded(
    start: IntArray, beside: IntArray, seed: int, mark: int, marked: IntArray, queue: IntArray
) -> int:
    """Mark all that is joined to a pair; their number, and in the queue they stand by how near they are."""
    marked[seed], queue[0], size, done = mark, seed, 1, 0
    while done < size:
        for at in range(start[queue[done]], start[queue[done] + 1]):
            if marked[beside[at]] != mark:
                marked[beside[at]], queue[size] = mark, beside[at]
                size += 1
        done += 1
    return size


@inlined
def _keep_connected(
    sheet: IntArray, begin: IntArray, neighbour: IntArray, face: int, queue: IntArray
) -> None:
    """Make the marks of faces negative that are joined to one of the same mark."""
    mark, size, done = sheet[face], 1, 0
    queue[0], sheet[face] = face, -mark
    while done < size:
        for at in range(begin[queue[done]], begin[queue[done] + 1]):
            if sheet[neighbour[at]] == mark:
                sheet[neighbour[at]], queue[size] = -mark, neighbour[at]
                size += 1
        done += 1


def _overlap_sheets(
    upper: IntArray, lower: IntArray, begin: IntArray, neighbour: IntArray, most: int
) -> IntArray:
    m, number, overlaps = len(begin) - 1, len(upper), 0
    upper_start = np.zeros(m + 1, dtype=np.int64)
    for k in range(number):
        upper_start[upper[k] + 1] += 1
    for face in range(m):
        upper_start[face + 1] += upper_start[face]
    start, beside = _beside(upper_start, upper, lower, begin, neighbour)
    marked, queue = np.full(number, -1, dtype=np.int64), np.empty(number, dtype=np.int64)
    seeds, sizes = np.empty(number, dtype=np.int64), np.zeros(number, dtype=np.int64)
    for k in range(number):
        if marked[k] < 0:
            size = _flooded(start, beside, k, overlaps, marked, queue)
            mirror = marked[_place_of(upper_start, lower, lower[k], upper[k])]
            if 0 <= mirror < overlaps:  # the same overlap, seen from the other side
                sizes[mirror] += size
            seeds[overlaps], sizes[overlaps] = k, size if mirror < 0 or mirror == overlaps else 0
            overlaps += 1
    order = np.argsort(-sizes[:overlaps], kind="mergesort")
    found = 0
    while found < min(most, overlaps) and sizes[order[found]]:
        found += 1
    sheets = np.zeros((found, m), dtype=np.int64)
    when, faces = np.empty((2, m), dtype=np.int64), np.empty(m, dtype=np.int64)
    for k in range(found):
        seed = seeds[order[k]]
        size = _flooded(start, beside, seed, number + k, marked, queue)
        when[:] = size
        for at in range(size - 1, -1, -1):
            when[0, upper[queue[at]]] = at
            when[1, lower[queue[at]]] = at
        met = size
        for face in range(m):
            met = min(met, max(when[0, face], when[1, face]))
        limit = float(met) if met == size else ROOM * met
        for face in range(m):
            sheets[k, face] = 1 if when[0, face] < limit else 2 if when[1, face] < limit else 0
        sheets[k, upper[seed]], sheets[k, lower[seed]] = 1, 2
        _keep_connected(sheets[k], begin, neighbour, upper[seed], faces)
        _keep_connected(sheets[k], begin, neighbour, lower[seed], faces)
        for face in range(m):
            sheets[k, face] = max(0, -sheets[k, face])
    return sheets


@with_loops(_overlap_sheets)
def overlap_sheets(
    upper: IntArray, lower: IntArray, begin: IntArray, neighbour: IntArray, most: int
) -> IntArray:
    """The two sheets of each of the `most` largest overlaps, (#O, #F): faces marked 1 and 2, 0 elsewhere.

    The pairs of faces, both ways around, are in lexicographic order, each once; the faces beside each face
    are given as in CSR. Pairs are neighbours if one face is the same, and the others are neighbours: so an
    overlap is a component of them, and of those the other way around. Where it winds on, so that a face is
    over one and under another, its sheets are grown from its first pair on until they meet. Each sheet is
    connected.
    """
    m, number = len(begin) - 1, len(upper)
    code = upper * m + lower
    starts, ends = [], []
    for k in range(int(np.diff(begin).max(initial=0))):
        here = np.flatnonzero(begin[upper] + k < begin[upper + 1])
        key = neighbour[begin[upper[here]] + k] * m + lower[here]
        place = np.minimum(np.searchsorted(code, key), number - 1)
        found = code[place] == key
        starts.append(here[found])
        ends.append(place[found])
    mirror = np.searchsorted(code, lower * m + upper)
    i, j = np.concatenate(starts), np.concatenate(ends)
    i, j = np.concatenate((i, mirror[i])), np.concatenate((j, mirror[j]))
    graph = sparse.csr_array((np.ones(len(i)), (i, j)), shape=(number, number))
    label = connected_labels(np.column_stack((i, j)), number)
    label = np.minimum(label, label[mirror])
    size, seeds = np.bincount(label), np.full(number, number)
    np.minimum.at(seeds, label, np.arange(number))
    size, seeds = size[size > 0], seeds[seeds < number]
    chosen = seeds[np.argsort(-size, kind="stable")][:most]
    sheets, owner = np.zeros((len(chosen), m), dtype=np.int64), np.repeat(np.arange(m), np.diff(begin))
    for sheet, seed in zip(sheets, chosen, strict=True):
        reached = csgraph.breadth_first_order(graph, seed, return_predecessors=False)
        when = np.full((2, m), len(reached))
        for side, faces in enumerate((upper[reached], lower[reached])):
            np.minimum.at(when[side], faces, np.arange(len(reached)))
        met = when.max(axis=0).min()  # where a face is first both; short of that is room for a seam
        near = when < (met if met == len(reached) else ROOM * met)
        sheet[:] = np.where(near[0], 1, np.where(near[1], 2, 0))
        sheet[[upper[seed], lower[seed]]] = 1, 2
        same = (sheet[owner] == sheet[neighbour]) & (sheet[owner] > 0)
        piece = connected_labels(np.column_stack((owner[same], neighbour[same])), m)
        sheet[(piece != piece[upper[seed]]) & (piece != piece[lower[seed]])] = 0
    return sheets
