"""The cells of a grid that outlines in the plane touch."""

import numpy as np

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from .choice import with_loops


def _touched(
    start: ComplexArray,
    end: ComplexArray,
    weight: IntArray,
    sides: IntArray,
    shapes: IntArray,
    cells: IntArray,
    half: float,
) -> BoolArray:
    wound, near = np.zeros(cells[-1], dtype=np.int32), np.zeros(cells[-1], dtype=np.int32)
    for k in range(len(shapes)):
        rows, columns = shapes[k, 0], shapes[k, 1]
        for s in range(sides[k], sides[k + 1]):
            x, y = start[s].real, start[s].imag
            across, rise = end[s].real - x, end[s].imag - y
            low, high = min(y, end[s].imag), max(y, end[s].imag)
            for row in range(int(np.ceil(low - 0.5)), int(np.ceil(high - 0.5))):
                column = np.ceil(x + (row + 0.5 - y) / rise * across - 0.5)
                at = cells[k] + row * (columns + 1) + int(min(max(column, 0.0), columns))
                wound[at] += weight[s] if rise > 0 else -weight[s]
            for row in range(
                int(max(np.floor(low - half), 0)), int(min(np.floor(high + half), rows - 1)) + 1
            ):
                first, last = 0.0, 1.0
                if rise != 0:
                    first = min(max((row - half - y) / rise, 0.0), 1.0)
                    last = min(max((row + 1 + half - y) / rise, 0.0), 1.0)
                one, other = x + first * across, x + last * across
                left = int(max(np.floor(min(one, other) - half), 0.0))
                right = int(min(np.floor(max(one, other) + half), columns - 1.0)) + 1
                at = cells[k] + row * (columns + 1)
                near[at + left] += 1
                near[at + right] -= 1
    touched, turns, number = np.empty(cells[-1], dtype=np.bool_), 0, 0
    for at in range(len(touched)):
        turns += wound[at]
        number += near[at]
        touched[at] = turns != 0 or number > 0
    return touched


@with_loops(_touched)
def touched_cells(
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
    number, before = 0, False
    for at in range(len(touched)):
        number += touched[at] and not before
        before = touched[at]
    mask, blocks = np.empty(number, dtype=np.int64), np.empty((number, 4), dtype=np.int64)
    last, size = np.full(columns.max() + 1, -1, dtype=np.int64), 0  # the block that begins at each column
    for k in range(len(columns)):
        first = size
        for row in range((cells[k + 1] - cells[k]) // (columns[k] + 1)):
            at, begin = cells[k] + row * (columns[k] + 1), 0
            while begin < columns[k]:
                end = begin
                while touched[at + end]:
                    end += 1
                if end > begin:
                    b = last[begin]
                    if b < first or blocks[b, 2] != end - begin or blocks[b, 0] + blocks[b, 3] != row:
                        b, last[begin], mask[size] = size, size, k
                        blocks[b, 0], blocks[b, 1], blocks[b, 2], blocks[b, 3] = row, begin, end - begin, 0
                        size += 1
                    blocks[b, 3] += 1
                begin = end + 1
    return mask[:size], blocks[:size]


@with_loops(_runs_in_blocks)
def runs_in_blocks(touched: BoolArray, cells: IntArray, columns: IntArray) -> tuple[IntArray, IntArray]:
    """Blocks of the cells that `touched_cells` gives: the grid of each; row, column, length, height.

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
