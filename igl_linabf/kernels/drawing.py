"""The cells of a grid that outlines in the plane touch, as blocks of equal runs of cells."""

import numpy as np

from .._types import Array, BoolArray, ComplexArray, FloatArray, IntArray
from .choice import inlined, with_loops
from .unsigned import ONE
from .words import NONE, WORD, lowest

ONCE = 1 << 16  # a winding in a number that also counts sides, of which fewer reach a cell
FEW = 24  # blocks that are sorted one by one

Drawn = tuple[IntArray, ComplexArray, IntArray, IntArray]


@inlined
def _change(row: int, column: int, by: int, columns: int, change: Array, marks: Array) -> None:
    """Add to what changes at a cell, and mark it in its row."""
    change[row * (columns + 1) + column] += by
    marks[row * (columns // WORD + 1) + column // WORD] |= ONE << np.uint64(column % WORD)


@inlined
def _marked(
    a: complex, b: complex, weight: int, rows: int, columns: int, half: float, change: Array, marks: Array
) -> None:
    """Add what a side changes from cell to cell: how often the outline winds, and the sides that are near."""
    across, rise = b.real - a.real, b.imag - a.imag
    low, high = min(a.imag, b.imag), max(a.imag, b.imag)
    for row in range(int(np.ceil(low - 0.5)), int(np.ceil(high - 0.5))):
        column = np.ceil(a.real + (row + 0.5 - a.imag) / rise * across - 0.5)
        by = weight * ONCE if rise > 0 else -weight * ONCE
        _change(row, int(min(max(column, 0.0), columns)), by, columns, change, marks)
    bottom, top = int(max(np.floor(low - half), 0)), int(min(np.floor(high + half), rows - 1))
    for row in range(bottom, top + 1):
        first, last = 0.0, 1.0
        if bottom < top and rise != 0:
            first = min(max((row - half - a.imag) / rise, 0.0), 1.0)
            last = min(max((row + 1 + half - a.imag) / rise, 0.0), 1.0)
        one, other = a.real + first * across, a.real + last * across
        left, right = max(np.floor(min(one, other) - half), 0.0), np.floor(max(one, other) + half)
        _change(row, int(left), 1, columns, change, marks)
        _change(row, int(min(right, columns - 1.0)) + 1, -1, columns, change, marks)


@inlined
def _in_blocks(rows: int, columns: int, change: Array, marks: Array, last: IntArray, blocks: IntArray) -> int:
    """Fill `blocks` with those of the cells where the sum of changes is not 0; their number.

    Changes and marks are 0 then.
    """
    size, at = 0, 0
    last[: columns + 1] = -1  # the block that begins at each column
    for row in range(rows):
        now, begin, inside = 0, 0, False
        for word in range(columns // WORD + 1):
            bits = marks[at]
            marks[at] = NONE
            at += 1
            while bits != NONE:
                column = word * WORD + int(lowest(bits))
                bits &= bits - ONE
                now += change[row * (columns + 1) + column]
                change[row * (columns + 1) + column] = 0
                if (now != 0) == inside:
                    continue
                inside = not inside
                if inside:
                    begin = column
                    continue
                b = last[begin]
                if b < 0 or blocks[b, 2] != column - begin or blocks[b, 0] + blocks[b, 3] != row:
                    b, last[begin] = size, size
                    blocks[b, 0], blocks[b, 1], blocks[b, 2], blocks[b, 3] = row, begin, column - begin, 0
                    size += 1
                blocks[b, 3] += 1
    return size


@inlined
def _largest_first(blocks: IntArray, to: IntArray) -> None:
    """Fill `to` with the blocks by their numbers of cells, equal ones in their order."""
    cells = blocks[:, 2] * blocks[:, 3]
    if len(blocks) > FEW:
        order = np.argsort(-cells, kind="mergesort")
        for i in range(len(blocks)):
            for j in range(4):
                to[i, j] = blocks[order[i], j]
        return
    for k in range(len(blocks)):
        i = k
        while i > 0 and to[i - 1, 2] * to[i - 1, 3] < cells[k]:
            for j in range(4):
                to[i, j] = to[i - 1, j]
            i -= 1
        for j in range(4):
            to[i, j] = blocks[k, j]


@inlined
def _turned_over(blocks: IntArray, rows: int, columns: int, to: IntArray) -> None:
    """Fill `to` with the blocks of a mask turned by half a turn."""
    for i in range(len(blocks)):
        to[i, 0] = rows - blocks[i, 0] - blocks[i, 3]
        to[i, 1] = columns - blocks[i, 1] - blocks[i, 2]
        to[i, 2], to[i, 3] = blocks[i, 2], blocks[i, 3]


def _drawn(
    start: ComplexArray,
    end: ComplexArray,
    weight: IntArray,
    sides: IntArray,
    turns: ComplexArray,
    of: IntArray,
    half: float,
) -> Drawn:
    most = 0
    for i in range(len(sides) - 1):
        most = max(most, sides[i + 1] - sides[i])
    a, b = np.empty(most, dtype=np.complex128), np.empty(most, dtype=np.complex128)
    shapes, low = np.empty((len(turns), 2), dtype=np.int64), np.empty(len(turns), dtype=np.complex128)
    change, marks = np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.uint64)
    last = np.empty(0, dtype=np.int64)
    blocks, begin, size = (
        np.empty((64 * len(turns), 4), dtype=np.int64),
        np.zeros(len(turns) + 1, np.int64),
        0,
    )
    own = np.empty((0, 4), dtype=np.int64)
    for k in range(len(turns)):
        if k and of[k] == of[k - 1] and turns[k] == -turns[k - 1]:
            before, rows, columns = begin[k - 1], shapes[k - 1, 0], shapes[k - 1, 1]
            found = size - before
            if size + found > len(blocks):
                blocks = np.concatenate((blocks, np.empty((size + found, 4), dtype=np.int64)))
            _turned_over(blocks[before:size], rows, columns, blocks[size : size + found])
            size += found
            shapes[k, 0], shapes[k, 1], begin[k + 1] = rows, columns, size
            low[k] = complex(-low[k - 1].real - columns, -low[k - 1].imag - rows)
            continue
        first, number = sides[of[k]], sides[of[k] + 1] - sides[of[k]]
        left, bottom, right, top = np.inf, np.inf, -np.inf, -np.inf
        for s in range(number):
            z = turns[k] * start[first + s]
            a[s], b[s] = z, turns[k] * end[first + s]
            left, right = min(left, z.real), max(right, z.real)
            bottom, top = min(bottom, z.imag), max(top, z.imag)
        corner = complex(left - half, bottom - half)
        columns, rows = int(right - corner.real + half) + 1, int(top - corner.imag + half) + 1
        cells = rows * (columns + 1)
        if cells > len(change):
            change, marks = np.zeros(2 * cells, dtype=np.int32), np.zeros(2 * cells, dtype=np.uint64)
        if columns >= len(last):
            last = np.empty(2 * (columns + 1), dtype=np.int64)
        for s in range(number):
            _marked(a[s] - corner, b[s] - corner, weight[first + s], rows, columns, half, change, marks)
        if cells > 2 * len(own):
            own = np.empty((cells, 4), dtype=np.int64)
        found = _in_blocks(rows, columns, change, marks, last, own)
        if size + found > len(blocks):
            blocks = np.concatenate((blocks, np.empty((size + found, 4), dtype=np.int64)))
        _largest_first(own[:found], blocks[size : size + found])
        size += found
        shapes[k, 0], shapes[k, 1], low[k], begin[k + 1] = rows, columns, corner, size
    return shapes, low, blocks[:size].copy(), begin


@with_loops(_drawn)
def drawn(
    start: ComplexArray,
    end: ComplexArray,
    weight: IntArray,
    sides: IntArray,
    turns: ComplexArray,
    of: IntArray,
    half: float,
) -> Drawn:
    """The blocks of cells that turned outlines, widened by `half` to all four sides, touch.

    Outline i has the sides from sides[i] to sides[i + 1], each with a weight. Mask k is that of outline
    of[k], which ascends, times turns[k], in the smallest grid from its lower left corner; where turns[k] is
    the opposite of the one before, of the same outline, it is that mask turned over.

    Returns rows and columns (#M, 2), the corners (#M,), the blocks (#B, 4), those of a mask by size, and
    where each mask's begin (#M + 1,).
    """
    anew = np.append(True, (of[1:] != of[:-1]) | (turns[1:] != -turns[:-1]))[: len(turns)]
    shapes, low, blocks, begin = _each_drawn(start, end, weight, sides, turns[anew], of[anew], half)
    by = np.cumsum(anew) - 1
    number = np.diff(begin)[by]
    over = (np.arange(len(turns)) - np.flatnonzero(anew)[by]) % 2 == 1
    whole = np.append(0, np.cumsum(number))
    blocks = blocks[np.arange(whole[-1]) + np.repeat(begin[:-1][by] - whole[:-1], number)]
    shapes, low = shapes[by], low[by]
    low.real[over], low.imag[over] = -low.real[over] - shapes[over, 1], -low.imag[over] - shapes[over, 0]
    turned = np.repeat(over, number)
    blocks[turned, :2] = (np.repeat(shapes, number, axis=0) - blocks[:, :2] - blocks[:, [3, 2]])[turned]
    return shapes, low, blocks, whole


def _each_drawn(
    start: ComplexArray,
    end: ComplexArray,
    weight: IntArray,
    sides: IntArray,
    turns: ComplexArray,
    of: IntArray,
    half: float,
) -> Drawn:
    """`drawn`, for which all turns are drawn."""
    number = np.diff(sides)[of]
    begin = np.concatenate(([0], np.cumsum(number)))
    side = np.arange(begin[-1]) + np.repeat(sides[:-1][of] - begin[:-1], number)
    by = np.repeat(turns, number)
    a, b = by * start[side], by * end[side]
    low = np.empty(len(turns), dtype=np.complex128)
    low.real, low.imag = (np.minimum.reduceat(x, begin[:-1]) - half for x in (a.real, a.imag))
    a, b = a - np.repeat(low, number), b - np.repeat(low, number)
    columns, rows = (
        (np.maximum.reduceat(x, begin[:-1]) + half).astype(np.int64) + 1 for x in (a.real, a.imag)
    )
    shapes, cells = np.column_stack((rows, columns)), np.append(0, np.cumsum(rows * (columns + 1)))
    touched = _touched(a, b, weight[side], begin, shapes, cells, half)
    mask, blocks = _runs_in_blocks(touched, cells, columns)
    blocks = blocks[np.lexsort((-blocks[:, 2] * blocks[:, 3], mask))]
    return shapes, low, blocks, np.searchsorted(mask, np.arange(len(turns) + 1))


def _touched(
    start: ComplexArray,
    end: ComplexArray,
    weight: IntArray,
    sides: IntArray,
    shapes: IntArray,
    cells: IntArray,
    half: float,
) -> BoolArray:
    """The cells that closed outlines, widened by `half` to all four sides, touch.

    Outline k has the sides from sides[k] to sides[k + 1], each with a weight, and a grid with a corner at 0
    of rows and columns shapes[k]. Its cells begin at cells[k], row by row; one more, that nothing touches,
    ends each row.
    """
    of = np.repeat(np.arange(len(shapes)), np.diff(sides))
    begin, (rows, columns) = cells[:-1][of], shapes[of].T
    wound = _wound(start, end, weight, begin, columns, int(cells[-1]))
    return np.asarray((wound != 0) | (_swept(start, end, half, begin, columns, rows, int(cells[-1])) > 0))


def _wound(
    start: ComplexArray, end: ComplexArray, weight: IntArray, begin: IntArray, columns: IntArray, total: int
) -> FloatArray:
    """How often outlines wind around the centre of each cell."""
    first = np.ceil(np.minimum(start.imag, end.imag) - 0.5).astype(np.int64)
    side, row = _rows(first, np.ceil(np.maximum(start.imag, end.imag) - 0.5).astype(np.int64))
    t = (row + 0.5 - start.imag[side]) / (end.imag - start.imag)[side]
    x = start.real[side] + t * (end.real - start.real)[side]
    column = np.clip(np.ceil(x - 0.5), 0, columns[side]).astype(np.int64)
    by = np.where(end.imag > start.imag, weight, -weight)[side]
    turns = np.bincount(begin[side] + row * (columns[side] + 1) + column, by, total)
    return np.asarray(np.cumsum(turns))  # outlines are closed: each row adds nothing to the next one


def _swept(
    start: ComplexArray,
    end: ComplexArray,
    half: float,
    begin: IntArray,
    columns: IntArray,
    rows: IntArray,
    total: int,
) -> IntArray:
    """How many sides come within `half`, in u and in v, of each cell.

    A side reaches those columns of a row that its part within `half` of the row reaches.
    """
    low, high = np.minimum(start.imag, end.imag), np.maximum(start.imag, end.imag)
    first = np.maximum(np.floor(low - half), 0).astype(np.int64)
    side, row = _rows(first, np.minimum(np.floor(high + half).astype(np.int64), rows - 1) + 1)
    rise = (end.imag - start.imag)[side]
    level, rise = rise == 0, np.where(rise == 0, 1.0, rise)
    one, other = (np.clip((y - start.imag[side]) / rise, 0.0, 1.0) for y in (row - half, row + 1 + half))
    x, across = start.real[side], (end.real - start.real)[side]
    one, other = x + np.where(level, 0.0, one) * across, x + np.where(level, 1.0, other) * across
    left = np.maximum(np.floor(np.minimum(one, other) - half), 0).astype(np.int64)
    right = np.minimum(np.floor(np.maximum(one, other) + half), columns[side] - 1).astype(np.int64) + 1
    at = begin[side] + row * (columns[side] + 1)
    change = np.bincount(at + left, minlength=total) - np.bincount(at + right, minlength=total)
    return np.asarray(np.cumsum(change))


def _rows(first: IntArray, end: IntArray) -> tuple[IntArray, IntArray]:
    """Each side as often as it has rows, and these."""
    count = end - first
    side = np.repeat(np.arange(len(count)), count)
    return side, np.arange(len(side)) - np.repeat(np.cumsum(count) - count - first, count)


def _runs_in_blocks(touched: BoolArray, cells: IntArray, columns: IntArray) -> tuple[IntArray, IntArray]:
    """Blocks of the cells that `_touched` gives: the grid of each; row, column, length, height.

    Equal runs of cells, one above the other, are a block. They are sorted by grid, row and column.
    """
    change = np.diff(touched.astype(np.int8), prepend=0)  # a mask begins after the last column of another one
    at = np.flatnonzero(change == 1)
    length = np.flatnonzero(change == -1) - at
    mask = np.searchsorted(cells, at, side="right") - 1
    row, begin = np.divmod(at - cells[mask], columns[mask] + 1)
    order = np.lexsort((row, length, begin, mask))
    mask, row, begin, length = mask[order], row[order], begin[order], length[order]
    first = np.ones(len(row), dtype=bool)
    first[1:] = np.diff(row) != 1
    for part in (begin, length, mask):
        first[1:] |= np.diff(part) != 0
    high = np.diff(np.append(np.flatnonzero(first), len(row)))
    mask, blocks = mask[first], np.column_stack((row[first], begin[first], length[first], high))
    order = np.lexsort((blocks[:, 1], blocks[:, 0], mask))
    return mask[order], blocks[order]
