"""Rectangles on shelves: beside each other, and over what already lies on a page."""

import numpy as np

from .._types import BoolArray, FloatArray, IntArray
from .choice import inlined, with_loops


@inlined
def _free_above(taken: BoolArray) -> IntArray:
    """How many cells are free from each one upwards."""
    side = len(taken)
    above = np.empty((side + 1, side), dtype=np.int64)
    above[side] = 0
    for row in range(side - 1, -1, -1):
        for column in range(side):
            above[row, column] = 0 if taken[row, column] else above[row + 1, column] + 1
    return above


def _on_shelves(sizes: FloatArray, taken: BoolArray) -> FloatArray:
    side, n, above = len(taken), len(sizes), _free_above(taken)
    places, end = np.empty((n, 2)), np.zeros(n + 1)
    for i in range(n):
        end[i + 1] = end[i] + sizes[i, 0]
    first, bottom = 0, 0.0
    while first < n and bottom + sizes[first, 1] <= side:
        height, row, before, left = sizes[first, 1], int(bottom), first, 0
        rows, widest = int(np.ceil(bottom + height)) - row, 0
        while left < side and first < n:
            right = left
            while right < side and above[row, right] >= rows:
                right += 1
            begin, widest = first, max(widest, right - left)
            while first < n and end[first + 1] <= end[begin] + right - left:
                places[first, 0], places[first, 1] = left + end[first] - end[begin], bottom
                first += 1
            left = right + 1
        if first > before:
            bottom += height
        elif widest == side:
            break  # wider than the page
        else:
            bottom = np.floor(bottom) + 1.0
    return places[:first].copy()


@with_loops(_on_shelves)
def on_shelves(sizes: FloatArray, taken: BoolArray) -> FloatArray:
    """Lower left corners (#P, 2) of as many rectangles as find a place on a page.

    A shelf is as high as its first rectangle. Where cells are taken, it goes on behind them.

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
