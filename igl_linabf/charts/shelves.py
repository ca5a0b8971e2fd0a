"""The many small charts of an atlas: turned to their narrowest rectangles, and put on shelves.

The rectangles lie, the highest ones first. A shelf is as high as its first rectangle. Where a large chart
stands in its way, it goes on behind it: so the small ones fill the holes of the large ones.
"""

import numpy as np

from .._types import BoolArray, ComplexArray, FloatArray
from ..surface import Parts


def on_shelves(sizes: FloatArray, taken: BoolArray) -> FloatArray:
    """Lower left corners (#P, 2) of as many rectangles as find a place on a page.

    Parameters
    ----------
    sizes : (#R, 2) float64
        Widths and heights, the highest one first; in cells of the page.
    taken : (side, side) bool
        Cells where nothing may come.
    """
    side, n = len(taken), len(sizes)
    end = np.concatenate(([0.0], np.cumsum(sizes[:, 0])))
    blocked = np.concatenate((np.zeros((1, side), np.int64), np.cumsum(taken, axis=0)))  # below each row
    lefts: list[FloatArray] = []
    bottoms: list[FloatArray] = []
    first, bottom = 0, 0.0
    while first < n and bottom + sizes[first, 1] <= side:
        height = sizes[first, 1]
        top = int(np.ceil(bottom + height))
        free = blocked[top] == blocked[int(bottom)]
        change = np.flatnonzero(np.diff(np.concatenate(([False], free, [False]))))
        before = first
        for left, right in change.reshape(-1, 2).tolist():
            last = int(np.searchsorted(end, end[first] + right - left, side="right")) - 1
            if last > first:
                lefts.append(left + end[first:last] - end[first])
                bottoms.append(np.full(last - first, bottom))
                first = last
            if first == n:
                break
        if first > before:
            bottom += height
        elif len(change) == 2 and change[1] - change[0] == side:
            break  # wider than the page
        else:
            bottom = np.floor(bottom) + 1.0
    if not lefts:
        return np.zeros((0, 2))
    return np.column_stack((np.concatenate(lefts), np.concatenate(bottoms)))


def extents(z: ComplexArray, charts: Parts) -> tuple[ComplexArray, ComplexArray]:
    """Lower left corners of the rectangles around charts, and their extents."""
    low, high = (function(z.real) + 1j * function(z.imag) for function in (charts.min, charts.max))
    return low, high - low


def areas(double: FloatArray, faces: Parts) -> FloatArray:
    """The area of each chart, by twice the signed areas of its faces."""
    return np.asarray(faces.sum(np.abs(double))) / 2
