"""Charts as outlines and as masks: the cells of a page's grid that a chart touches."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..surface import Parts, counted

AT_ONCE = 100_000  # sides of turned charts that are drawn at once


@dataclass(frozen=True, eq=False)
class Outline:
    """The sides of a chart's triangles that do not cancel out.

    Attributes
    ----------
    start, end : (#S,) complex128
        The chart lies on their left.
    weight : (#S,) int64
        How often each counts; 1 in an oriented manifold.
    area : float
        The chart's.
    """

    start: ComplexArray
    end: ComplexArray
    weight: IntArray
    area: float


@dataclass(frozen=True, eq=False)
class Masks:
    """The cells that a chart touches in several directions, each within the smallest rectangle of cells.

    Attributes
    ----------
    turns : (#M,) complex128
        The directions.
    cells : list of (#rows, #columns) bool
    shapes : (#M, 2) int64
        Their rows and columns.
    origin : (#M,) complex128
        What of the chart comes to a mask's lower left corner.
    blocks : (#B, 4) int64
        Row, first column, length and number of rows of runs of cells; equal ones in a row are one. The
        largest come first.
    start : (#M + 1,) int64
        Mask k has the blocks from start[k] to start[k + 1].
    """

    turns: ComplexArray
    cells: Sequence[BoolArray]
    shapes: IntArray
    origin: ComplexArray
    blocks: IntArray
    start: IntArray

    def only(self, k: int) -> Masks:
        """That in one direction."""
        blocks = self.blocks[self.start[k] : self.start[k + 1]]
        one = slice(k, k + 1)
        start = np.array([0, len(blocks)])
        return Masks(self.turns[one], self.cells[one], self.shapes[one], self.origin[one], blocks, start)


def outlines(z: ComplexArray, F: IntArray, vertices: Parts, faces: Parts, area: FloatArray) -> list[Outline]:
    """The outlines of charts whose vertices and faces stand one after the other."""
    tail, head = F.ravel(), F[:, [1, 2, 0]].ravel()
    key = np.minimum(tail, head) * len(z) + np.maximum(tail, head)
    edge, of_side = np.unique(key, return_inverse=True)
    net = np.bincount(of_side.ravel(), np.where(tail < head, 1, -1), len(edge)).astype(np.int64)
    low, high = np.divmod(edge, len(z))
    left = net != 0
    low, high, net = low[left], high[left], net[left]
    start, end = np.where(net > 0, low, high), np.where(net > 0, high, low)
    bounds = np.searchsorted(low, vertices.start)  # edges are sorted by their lower vertex
    weight = np.abs(net)
    return [
        Outline(z[start[i:j]], z[end[i:j]], weight[i:j], float(a))
        for i, j, a in zip(bounds[:-1].tolist(), bounds[1:].tolist(), area, strict=True)
    ]


def masks_of(
    outlines: Sequence[Outline], turns: Sequence[ComplexArray], cells_per_unit: float, gap: float
) -> list[Masks]:
    """The cells that charts, turned and widened by half a gap (in cells) to all four sides, touch.

    Charts whose masks share no cell are at least the gap apart, in u or in v.
    """
    made: list[Masks] = []
    sides = np.cumsum([len(outline.start) * len(by) for outline, by in zip(outlines, turns, strict=True)])
    for first, end in _groups(sides):
        made += _together(outlines[first:end], turns[first:end], cells_per_unit, gap)
    return made


def _groups(sides: IntArray) -> Iterator[tuple[int, int]]:
    """Consecutive charts of not too many sides."""
    first = 0
    while first < len(sides):
        base = int(sides[first - 1]) if first else 0
        end = max(first + 1, int(np.searchsorted(sides, base + AT_ONCE, side="right")))
        yield first, end
        first = end


def _together(
    outlines: Sequence[Outline], turns: Sequence[ComplexArray], cells_per_unit: float, gap: float
) -> list[Masks]:
    half = gap / 2 * (1 + 1e-9) + 1e-9
    number = np.array([len(by) for by in turns])
    sides = Parts.of_sizes(np.repeat([len(outline.start) for outline in outlines], number))
    pairs = [(outline, by[:, None] * cells_per_unit) for outline, by in zip(outlines, turns, strict=True)]
    a = np.concatenate([(by * outline.start).ravel() for outline, by in pairs])
    b = np.concatenate([(by * outline.end).ravel() for outline, by in pairs])
    weight = np.concatenate([np.tile(outline.weight, len(by)) for outline, by in pairs])
    low = np.empty(len(sides), dtype=np.complex128)
    low.real, low.imag = sides.min(a.real) - half, sides.min(a.imag) - half
    a, b = a - sides.spread(low), b - sides.spread(low)
    columns, rows = ((sides.max(part) + half).astype(np.int64) + 1 for part in (a.real, a.imag))
    cells = Parts.of_sizes(rows * (columns + 1))  # a last column ends each row
    grid = _Grid(sides.spread(cells.start[:-1]), sides.spread(columns), sides.spread(rows))
    total = int(cells.start[-1])
    touched = (_wound(a, b, weight, grid, total) != 0) | (_swept(a, b, half, grid, total) > 0)
    tables = [
        part.reshape(-1, n + 1)[:, :-1]
        for part, n in zip(cells.split(touched), columns.tolist(), strict=True)
    ]
    blocks, start = _blocks(touched, cells, columns)
    shapes, origin = np.column_stack((rows, columns)), low / cells_per_unit
    made = []
    for by, (i, j) in zip(turns, pairwise([0, *np.cumsum(number).tolist()]), strict=True):
        own, begin = blocks[start[i] : start[j]], start[i : j + 1] - start[i]
        made.append(Masks(by, tables[i:j], shapes[i:j], origin[i:j], own, begin))
    return made


@dataclass(frozen=True, eq=False)
class _Grid:
    """For each side: where the cells of its mask begin, and its columns, without the last one, and rows."""

    begin: IntArray
    columns: IntArray
    rows: IntArray

    def at(self, side: IntArray, row: IntArray, column: FloatArray) -> IntArray:
        """The places of cells."""
        return np.asarray(self.begin[side] + row * (self.columns[side] + 1) + column.astype(np.int64))


def _wound(a: ComplexArray, b: ComplexArray, weight: IntArray, grid: _Grid, total: int) -> FloatArray:
    """How often the sides wind around the centre of each cell."""
    up = b.imag > a.imag
    first = np.ceil(np.minimum(a.imag, b.imag) - 0.5).astype(np.int64)
    count = np.ceil(np.maximum(a.imag, b.imag) - 0.5).astype(np.int64) - first
    side, step = counted(count)
    row = first[side] + step
    t = (row + 0.5 - a.imag[side]) / (b.imag[side] - a.imag[side])
    x = a.real[side] + t * (b.real - a.real)[side]
    at = grid.at(side, row, np.clip(np.ceil(x - 0.5), 0, grid.columns[side]))
    turns = np.bincount(at, np.where(up, weight, -weight)[side], total)
    return np.asarray(np.cumsum(turns))  # outlines are closed: each row adds nothing to the next one


def _swept(a: ComplexArray, b: ComplexArray, half: float, grid: _Grid, total: int) -> FloatArray:
    """How many sides come within `half`, in u and in v, of each cell.

    A side reaches those columns of a row that its part within `half` of the row reaches.
    """
    low, high = np.minimum(a.imag, b.imag), np.maximum(a.imag, b.imag)
    first = np.maximum(np.floor(low - half), 0).astype(np.int64)
    last = np.minimum(np.floor(high + half).astype(np.int64), grid.rows - 1)
    side, step = counted(last - first + 1)
    row = first[side] + step
    rise = (b.imag - a.imag)[side]
    level, rise = rise == 0, np.where(rise == 0, 1.0, rise)
    begin, end = (np.clip((y - a.imag[side]) / rise, 0.0, 1.0) for y in (row - half, row + 1 + half))
    begin, end = np.where(level, 0.0, begin), np.where(level, 1.0, end)
    across = (b.real - a.real)[side]
    one, other = a.real[side] + begin * across, a.real[side] + end * across
    left = np.maximum(np.floor(np.minimum(one, other) - half), 0)
    right = np.minimum(np.floor(np.maximum(one, other) + half), grid.columns[side] - 1) + 1
    change = np.bincount(grid.at(side, row, left), minlength=total)
    change -= np.bincount(grid.at(side, row, right), minlength=total)
    return np.asarray(np.cumsum(change))


def _blocks(touched: BoolArray, cells: Parts, columns: IntArray) -> tuple[IntArray, IntArray]:
    """The `blocks` of masks one after the other, and where those of each mask begin."""
    change = np.diff(touched.astype(np.int8), prepend=0)  # a mask begins after the last column of another one
    at = np.flatnonzero(change == 1)
    length = np.flatnonzero(change == -1) - at
    mask = np.searchsorted(cells.start, at, side="right") - 1
    row, begin = np.divmod(at - cells.start[mask], columns[mask] + 1)
    order = np.lexsort((row, length, begin, mask))
    mask, row, begin, length = mask[order], row[order], begin[order], length[order]
    first = np.ones(len(row), dtype=bool)
    first[1:] = np.diff(row) != 1
    for part in (begin, length, mask):
        first[1:] |= np.diff(part) != 0
    high = np.diff(np.append(np.flatnonzero(first), len(row)))
    mask = mask[first]
    blocks = np.column_stack((row[first], begin[first], length[first], high))
    blocks = blocks[np.lexsort((-length[first] * high, mask))]
    return blocks, np.searchsorted(mask, np.arange(len(cells) + 1))
