"""Where a chart's boundary winds around a place more than once: only there can the chart overlap itself."""

import numpy as np

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..surface import index_and_rank, signed_double_areas
from .constants import CELL_MARGIN, MOST_GRID_CELLS


def may_overlap(z: ComplexArray, F: IntArray, tail: IntArray, head: IntArray) -> BoolArray:
    """Faces of a chart near places that its boundary winds around more than once; all, if some are flipped.

    The boundary's sides are given by their vertices, the chart on their left. Within a cell of a grid that
    the boundary does not pass, it winds around all points as often.
    """
    if not (signed_double_areas(z, F.T) > 0).all():
        return np.ones(len(F), dtype=bool)
    side = int(np.clip(np.sqrt(len(F)), 8, MOST_GRID_CELLS))
    (left, right), (below, above) = (
        (_least_of_three(x[F.T]), -_least_of_three(-x[F.T])) for x in (z.real, z.imag)
    )
    low = complex(left.min(), below.min())
    scale = side / max(float(right.max()) - low.real, float(above.max()) - low.imag)
    a, b = _short_pieces((z[tail] - low) * scale, (z[head] - low) * scale)
    marked = _cells_passed(a, b, side) | (_winding_numbers(a, b, side) > 1)
    total = np.zeros((side + 1, side + 1), dtype=np.int64)
    total[1:, 1:] = marked.cumsum(axis=0).cumsum(axis=1)
    first, last = _columns_touched((left - low.real) * scale, (right - low.real) * scale, side)
    lowest, highest = _columns_touched((below - low.imag) * scale, (above - low.imag) * scale, side)
    highest, last = highest + 1, last + 1
    in_box = total[highest, last] - total[lowest, last] - total[highest, first] + total[lowest, first]
    return np.asarray(in_box > 0)


def open_sides(F: IntArray, n: int) -> IntArray | None:
    """Sides with no face on their right, by F.T; None if two run the same way: they bound no surface."""
    tail, head = F.T.ravel(), F[:, [1, 2, 0]].T.ravel()
    code = np.sort(tail * n + head)
    if (code[1:] == code[:-1]).any():
        return None
    return np.flatnonzero(~np.isin(head * n + tail, code, assume_unique=True))


def _least_of_three(values: FloatArray) -> FloatArray:
    """Of the values at the three corners, (3, #F): row by row, which takes a quarter of the time."""
    a, b, c = values
    return np.asarray(np.minimum(np.minimum(a, b), c))


def _short_pieces(start: ComplexArray, end: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Sides in pieces that are shorter than a cell."""
    number = np.maximum(np.ceil(1.01 * np.abs(end - start)), 1).astype(np.int64)
    of, step = index_and_rank(number)
    a, along = start[of], (end - start)[of]
    ends = np.where(step + 1 == number[of], end[of], a + along * ((step + 1) / number[of]))
    return a + along * (step / number[of]), ends


def _columns_touched(low: FloatArray, high: FloatArray, side: int) -> tuple[IntArray, IntArray]:
    """The first and the last column, or row, that something from `low` to `high` touches."""
    ends = low - CELL_MARGIN, high + CELL_MARGIN
    first, last = (np.clip(np.floor(x), 0, side - 1).astype(np.int64) for x in ends)
    return first, last


def _cells_passed(a: ComplexArray, b: ComplexArray, side: int) -> BoolArray:
    """Cells that short pieces may pass."""
    columns = _columns_touched(np.minimum(a.real, b.real), np.maximum(a.real, b.real), side)
    rows = _columns_touched(np.minimum(a.imag, b.imag), np.maximum(a.imag, b.imag), side)
    marked = np.zeros((side, side), dtype=bool)
    for row in rows:
        for column in columns:
            marked[row, column] = True
    return marked


def _winding_numbers(a: ComplexArray, b: ComplexArray, side: int) -> IntArray:
    """How often short pieces wind around the cells' centres."""
    low, high = np.minimum(a.imag, b.imag), np.maximum(a.imag, b.imag)
    # a piece crosses the line through one row's centres at most
    row = np.ceil(high - 0.5).astype(np.int64) - 1
    crossing = low <= row + 0.5
    a, b, row = a[crossing], b[crossing], row[crossing]
    at = a.real + (row + 0.5 - a.imag) / (b.imag - a.imag) * (b.real - a.real)
    first = np.clip(np.ceil(at - 0.5), 0, side).astype(np.int64)  # the first centre on its right
    turns = np.zeros((side, side + 1), dtype=np.int64)
    np.add.at(turns, (row, first), np.where(b.imag < a.imag, 1, -1))
    return np.asarray(np.cumsum(turns, axis=1)[:, :side])
