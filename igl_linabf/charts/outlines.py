"""Charts as outlines and as masks: the cells of a page's grid that a chart touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..surface import Parts, counted


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

    def turned(self, turn: complex) -> Outline:
        """The same times a complex number."""
        return Outline(self.start * turn, self.end * turn, self.weight, self.area * abs(turn) ** 2)


@dataclass(frozen=True, eq=False)
class Mask:
    """The cells that a chart touches, within the smallest rectangle of cells.

    Attributes
    ----------
    cells : (#rows, #columns) bool
    origin : complex
        What of the chart comes to the mask's lower left corner.
    """

    cells: BoolArray
    origin: complex

    @cached_property
    def blocks(self) -> list[tuple[int, int, int, int]]:
        """Row, first column, length and number of rows of runs of cells; equal ones in a row are one.

        The largest come first.
        """
        rows, columns = self.cells.shape
        padded = np.zeros((rows, columns + 2), dtype=np.int8)
        padded[:, 1:-1] = self.cells
        change = padded[:, 1:] - padded[:, :-1]
        row, begin = np.nonzero(change == 1)
        length = np.nonzero(change == -1)[1] - begin
        order = np.lexsort((row, length, begin))
        row, begin, length = row[order], begin[order], length[order]
        first = np.ones(len(row), dtype=bool)
        first[1:] = (np.diff(row) != 1) | (np.diff(begin) != 0) | (np.diff(length) != 0)
        high = np.diff(np.append(np.flatnonzero(first), len(row)))
        blocks = np.column_stack((row[first], begin[first], length[first], high))
        return [(*block,) for block in blocks[np.argsort(-length[first] * high, kind="stable")].tolist()]

    def quarter_turned(self, cells_per_unit: float) -> Mask:
        """That of the chart times i."""
        # the cell (x, y) of R rows comes to (R - 1 - y, x)
        return Mask(self.cells[::-1].T, self.origin * 1j - len(self.cells) / cells_per_unit)


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


def mask_of(outline: Outline, cells_per_unit: float, gap: float) -> Mask:
    """The cells that the chart, widened by half a gap (in cells) to all four sides, touches.

    Charts whose masks share no cell are at least the gap apart, in u or in v.
    """
    half = gap / 2 * (1 + 1e-9) + 1e-9
    a, b = outline.start * cells_per_unit, outline.end * cells_per_unit
    low = complex(a.real.min() - half, a.imag.min() - half)
    a, b = a - low, b - low
    columns, rows = (int(extent.max() + half) + 1 for extent in (a.real, a.imag))
    cells = _inside(a, b, outline.weight, rows, columns)
    # a square of at most one cell touches those in which its corners lie; a larger one is divided
    steps = np.linspace(-half, half, int(np.ceil(2 * half)) + 1)
    shifts = [complex(x, y) for x in steps for y in steps if half in (abs(x), abs(y))]
    crossed = _crossed(a, b, shifts)
    column, row = (
        np.clip(part.astype(np.int64), 0, n - 1) for part, n in zip(crossed, (columns, rows), strict=True)
    )
    cells[row, column] = True
    return Mask(cells, low / cells_per_unit)


def masks_of(outline: Outline, turns: ComplexArray, cells_per_unit: float, gap: float) -> list[Mask]:
    """`mask_of` the turned chart; a fourth of the turns is enough where they are equal steps all around."""
    steps = len(turns) // 4
    if not steps or not np.allclose(turns[steps:], 1j * turns[:-steps]):
        return [mask_of(outline.turned(turn), cells_per_unit, gap) for turn in turns.tolist()]
    masks = [mask_of(outline.turned(turn), cells_per_unit, gap) for turn in turns[:steps].tolist()]
    for _ in range(3):
        masks += [mask.quarter_turned(cells_per_unit) for mask in masks[-steps:]]
    return masks


def _inside(a: ComplexArray, b: ComplexArray, weight: IntArray, rows: int, columns: int) -> BoolArray:
    """Cells around whose centres the sides wind."""
    up = b.imag > a.imag
    first = np.ceil(np.minimum(a.imag, b.imag) - 0.5).astype(np.int64)
    count = np.ceil(np.maximum(a.imag, b.imag) - 0.5).astype(np.int64) - first
    side, step = counted(count)
    row = first[side] + step
    t = (row + 0.5 - a.imag[side]) / (b.imag[side] - a.imag[side])
    x = a.real[side] + t * (b.real[side] - a.real[side])
    column = np.clip(np.ceil(x - 0.5).astype(np.int64), 0, columns)
    turns = np.bincount(
        row * (columns + 1) + column, np.where(up, weight, -weight)[side], rows * (columns + 1)
    )
    return np.asarray(np.cumsum(turns.reshape(rows, -1), axis=1)[:, :columns] != 0)


def _crossed(a: ComplexArray, b: ComplexArray, shifts: Sequence[complex]) -> tuple[FloatArray, FloatArray]:
    """A point in each cell that a side passes through, when shifted."""
    a, b = (np.concatenate([z + shift for shift in shifts]) for z in (a, b))
    n = len(a)
    everyone = np.arange(n)
    at, of_side = [np.zeros(n), np.ones(n)], [everyone, everyone]
    for u, v in ((a.real, b.real), (a.imag, b.imag)):
        first = np.floor(np.minimum(u, v)).astype(np.int64) + 1
        side, step = counted(np.maximum(np.ceil(np.maximum(u, v)).astype(np.int64) - first, 0))
        at.append((first[side] + step - u[side]) / (v[side] - u[side]))
        of_side.append(side)
    t, side = np.concatenate(at), np.concatenate(of_side)
    order = np.argsort(side + np.clip(t, 0, 1) / 2)
    t, side = t[order], side[order]
    # between two lines of the grid a side stays in one cell
    same = side[1:] == side[:-1]
    middle, side = ((t[1:] + t[:-1]) / 2)[same], side[1:][same]
    return (
        a.real[side] + middle * (b.real[side] - a.real[side]),
        a.imag[side] + middle * (b.imag[side] - a.imag[side]),
    )
