"""The two sheets of each overlap of a flat map."""

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .._core import connected_labels
from .._types import IntArray
from .choice import inlined, with_loops

ROOM = 0.8  # share of the way to where a face is on both sheets, that they are grown


@inlined
def _mirrors(upper_start: IntArray, lower: IntArray) -> IntArray:
    """The row of each pair the other way around."""
    mirror, filled = np.empty(len(lower), dtype=np.int64), upper_start[:-1].copy()
    for k in range(len(lower)):  # the upper faces ascend, as they do in each row
        mirror[k] = filled[lower[k]]
        filled[lower[k]] += 1
    return mirror


@inlined
def _beside(
    upper_start: IntArray, lower: IntArray, mirror: IntArray, begin: IntArray, neighbour: IntArray
) -> tuple[IntArray, IntArray]:
    """The pairs beside each pair, in ascending order, as in CSR."""
    number = len(lower)
    start = np.zeros(number + 1, dtype=np.int64)
    for face in range(len(begin) - 1):
        for k in range(upper_start[face], upper_start[face + 1]):
            start[k + 1] = start[k] + begin[face + 1] - begin[face]
    above, end = np.empty(start[number], dtype=np.int64), start[:-1].copy()  # with another upper face
    for face in range(len(begin) - 1):
        for at in range(begin[face], begin[face + 1]):
            k, last = upper_start[face], upper_start[face + 1]
            other, last_other = upper_start[neighbour[at]], upper_start[neighbour[at] + 1]
            while k < last and other < last_other:
                if lower[k] == lower[other]:
                    above[end[k]] = other
                    end[k], k, other = end[k] + 1, k + 1, other + 1
                elif lower[k] < lower[other]:
                    k += 1
                else:
                    other += 1
    begins, most = np.empty(number + 1, dtype=np.int64), 0
    for k in range(number):
        begins[k] = most
        most += end[k] - start[k] + end[mirror[k]] - start[mirror[k]]
    begins[number] = most
    beside = np.empty(most, dtype=np.int64)
    for k in range(number):
        size = begins[k]
        for side in range(2):
            row = k if side == 0 else mirror[k]
            for at in range(start[row], end[row]):
                there = above[at] if side == 0 else mirror[above[at]]
                place = size
                while place > begins[k] and beside[place - 1] > there:
                    beside[place] = beside[place - 1]
                    place -= 1
                beside[place] = there
                size += 1
    return begins, beside


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
def _connected(sheet: IntArray, begin: IntArray, neighbour: IntArray, face: int, queue: IntArray) -> int:
    """Put the faces into the queue that are joined to one of the same mark, and take it off; their number."""
    mark, size, done = sheet[face], 1, 0
    queue[0], sheet[face] = face, 0
    while done < size:
        for at in range(begin[queue[done]], begin[queue[done] + 1]):
            if sheet[neighbour[at]] == mark:
                sheet[neighbour[at]], queue[size] = 0, neighbour[at]
                size += 1
        done += 1
    return size


def _overlap_sheets(
    upper: IntArray, lower: IntArray, begin: IntArray, neighbour: IntArray, most: int
) -> tuple[IntArray, IntArray]:
    m, number, overlaps = len(begin) - 1, len(upper), 0
    upper_start = np.zeros(m + 1, dtype=np.int64)
    for k in range(number):
        upper_start[upper[k] + 1] += 1
    for face in range(m):
        upper_start[face + 1] += upper_start[face]
    mirrors = _mirrors(upper_start, lower)
    start, beside = _beside(upper_start, lower, mirrors, begin, neighbour)
    marked, queue = np.full(number, -1, dtype=np.int64), np.empty(number, dtype=np.int64)
    seeds, sizes = np.empty(number, dtype=np.int64), np.zeros(number, dtype=np.int64)
    for k in range(number):
        if marked[k] < 0:
            size = _flooded(start, beside, k, overlaps, marked, queue)
            mirror = marked[mirrors[k]]
            if 0 <= mirror < overlaps:  # the same overlap, seen from the other side
                sizes[mirror] += size
            seeds[overlaps], sizes[overlaps] = k, size if mirror < 0 or mirror == overlaps else 0
            overlaps += 1
    order = np.argsort(-sizes[:overlaps], kind="mergesort")
    found = 0
    while found < min(most, overlaps) and sizes[order[found]]:
        found += 1
    sheet, faces = np.zeros(m, dtype=np.int64), np.empty(m, dtype=np.int64)
    when = np.full((2, m), number, dtype=np.int64)
    made, start_of = np.empty(m + 1, dtype=np.int64), np.zeros(2 * found + 1, dtype=np.int64)
    for k in range(found):
        seed = seeds[order[k]]
        size = _flooded(start, beside, seed, number + k, marked, queue)
        for at in range(size - 1, -1, -1):
            when[0, upper[queue[at]]] = at
            when[1, lower[queue[at]]] = at
        met = size
        for at in range(size):
            for face in (upper[queue[at]], lower[queue[at]]):
                met = min(met, max(when[0, face], when[1, face]))
        limit = float(met) if met == size else ROOM * met
        for at in range(size):
            for face in (upper[queue[at]], lower[queue[at]]):
                sheet[face] = 1 if when[0, face] < limit else 2 if when[1, face] < limit else 0
        sheet[upper[seed]], sheet[lower[seed]] = 1, 2
        for side in range(2):
            row = 2 * k + side
            own = _connected(sheet, begin, neighbour, upper[seed] if side == 0 else lower[seed], faces)
            start_of[row + 1] = start_of[row] + own
            if start_of[row + 1] > len(made):
                made = np.append(made, np.empty(len(made) + own, dtype=np.int64))
            made[start_of[row] : start_of[row + 1]] = np.sort(faces[:own])
        for at in range(size):
            for face in (upper[queue[at]], lower[queue[at]]):
                sheet[face], when[0, face], when[1, face] = 0, number, number
    return made[: start_of[-1]].copy(), start_of


@with_loops(_overlap_sheets)
def overlap_sheets(
    upper: IntArray, lower: IntArray, begin: IntArray, neighbour: IntArray, most: int
) -> tuple[IntArray, IntArray]:
    """The two sheets of each of the `most` largest overlaps: the faces of each, ascending.

    And where each sheet begins, (2 #O + 1,).
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
    sheets, owner = list[IntArray](), np.repeat(np.arange(m), np.diff(begin))
    for seed in chosen:
        reached = csgraph.breadth_first_order(graph, seed, return_predecessors=False)
        when = np.full((2, m), len(reached))
        for side, faces in enumerate((upper[reached], lower[reached])):
            np.minimum.at(when[side], faces, np.arange(len(reached)))
        met = when.max(axis=0).min()  # where a face is first both; short of that is room for a seam
        near = when < (met if met == len(reached) else ROOM * met)
        sheet = np.where(near[0], 1, np.where(near[1], 2, 0))
        sheet[[upper[seed], lower[seed]]] = 1, 2
        same = (sheet[owner] == sheet[neighbour]) & (sheet[owner] > 0)
        piece = connected_labels(np.column_stack((owner[same], neighbour[same])), m)
        sheets += [np.flatnonzero(piece == piece[face]) for face in (upper[seed], lower[seed])]
    return np.concatenate(sheets), np.append(0, np.cumsum([len(sheet) for sheet in sheets]))
