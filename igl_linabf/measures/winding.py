"""Winding numbers of chart boundaries; a chart overlaps itself only where they exceed one."""

import numpy as np

from .._core import group_sides
from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..surface import index_and_rank, signed_double_areas

MOST_GRID_CELLS = 512  # maximum number of cells along one side of the grid
CELL_MARGIN = 1e-6  # margin of ranges for rounding errors, in cells


def find_suspect_faces(z: ComplexArray, F: IntArray, tail: IntArray, head: IntArray) -> BoolArray:
    """Mark the faces of a chart near points with a winding number above one; all faces if any is flipped.

    `tail` and `head` are the end vertices of the boundary sides, with the chart on their left. The winding
    number is constant in each grid cell that the boundary does not pass. Faces in cells that the boundary
    passes are also marked.
    """
    if not (signed_double_areas(z, F.T) > 0).all():
        return np.ones(len(F), dtype=bool)
    side = int(np.clip(np.sqrt(len(F)), 8, MOST_GRID_CELLS))
    (left, right), (below, above) = (
        (_find_min_of_three(x[F.T]), -_find_min_of_three(-x[F.T])) for x in (z.real, z.imag)
    )
    low = complex(left.min(), below.min())
    scale = side / max(float(right.max()) - low.real, float(above.max()) - low.imag)
    a, b = _subdivide((z[tail] - low) * scale, (z[head] - low) * scale)
    marked = _mark_passed_cells(a, b, side) | (_compute_winding_numbers(a, b, side) > 1)
    total = np.zeros((side + 1, side + 1), dtype=np.int64)
    total[1:, 1:] = marked.cumsum(axis=0).cumsum(axis=1)
    first, last = _find_touched_cells((left - low.real) * scale, (right - low.real) * scale, side)
    lowest, highest = _find_touched_cells((below - low.imag) * scale, (above - low.imag) * scale, side)
    highest, last = highest + 1, last + 1
    in_box = total[highest, last] - total[lowest, last] - total[highest, first] + total[lowest, first]
    return np.asarray(in_box > 0)


def find_open_sides(F: IntArray, n: int) -> IntArray | None:
    """Return the boundary sides as indices of `F.T.ravel()`, or None if a directed side occurs twice."""
    tail, head = F.T.ravel(), F[:, [1, 2, 0]].T.ravel()
    order, begin, count = group_sides(tail, head, n)
    first = begin[count == 2]
    if (count > 2).any() or (tail[order[first]] == tail[order[first + 1]]).any():
        return None
    return np.sort(order[begin[count == 1]])


def _find_min_of_three(values: FloatArray) -> FloatArray:
    """Return the minimum of values at the three corners, (3, #F), four times as fast as `min(axis=0)`."""
    a, b, c = values
    return np.asarray(np.minimum(np.minimum(a, b), c))


def _subdivide(start: ComplexArray, end: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Subdivide sides into pieces that are shorter than a grid cell."""
    number = np.maximum(np.ceil(1.01 * np.abs(end - start)), 1).astype(np.int64)
    of, step = index_and_rank(number)
    a, along = start[of], (end - start)[of]
    ends = np.where(step + 1 == number[of], end[of], a + along * ((step + 1) / number[of]))
    return a + along * (step / number[of]), ends


def _find_touched_cells(low: FloatArray, high: FloatArray, side: int) -> tuple[IntArray, IntArray]:
    """Return the first and last grid columns (or rows) that overlap each range from `low` to `high`."""
    ends = low - CELL_MARGIN, high + CELL_MARGIN
    first, last = (np.clip(np.floor(x), 0, side - 1).astype(np.int64) for x in ends)
    return first, last


def _mark_passed_cells(a: ComplexArray, b: ComplexArray, side: int) -> BoolArray:
    """Return a mask of the grid cells that short line segments from a to b may pass."""
    columns = _find_touched_cells(np.minimum(a.real, b.real), np.maximum(a.real, b.real), side)
    rows = _find_touched_cells(np.minimum(a.imag, b.imag), np.maximum(a.imag, b.imag), side)
    marked = np.zeros((side, side), dtype=bool)
    for row in rows:
        for column in columns:
            marked[row, column] = True
    return marked


def _compute_winding_numbers(a: ComplexArray, b: ComplexArray, side: int) -> IntArray:
    """Compute winding numbers at cell centres, for a curve that consists of short pieces from a to b."""
    low, high = np.minimum(a.imag, b.imag), np.maximum(a.imag, b.imag)
    # a short piece crosses at most one horizontal line through cell centres
    row = np.ceil(high - 0.5).astype(np.int64) - 1
    crossing = low <= row + 0.5
    a, b, row = a[crossing], b[crossing], row[crossing]
    at = a.real + (row + 0.5 - a.imag) / (b.imag - a.imag) * (b.real - a.real)
    first = np.clip(np.ceil(at - 0.5), 0, side).astype(np.int64)  # first cell centre to the right
    turns = np.zeros((side, side + 1), dtype=np.int64)
    np.add.at(turns, (row, first), np.where(b.imag < a.imag, 1, -1))
    return np.asarray(np.cumsum(turns, axis=1)[:, :side])
