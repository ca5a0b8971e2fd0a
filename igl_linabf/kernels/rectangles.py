"""The narrowest rectangles around convex hulls: each lies along a side of its hull."""

import numpy as np

from .._types import ComplexArray, IntArray
from .choice import with_loops

ALIKE = 1 + 1e-12  # times the least area is an equal one: rounding must not choose
ROWS = 1 << 20  # pairs of a turn and a point that are tried at once in NumPy, which bounds the memory


def _narrowest(corner: ComplexArray, turns: ComplexArray, start: IntArray) -> IntArray:
    best, area = np.full(len(start) - 1, -1, dtype=np.int64), np.empty(len(turns))
    for i in range(len(best)):
        least = np.inf
        for r in range(start[i], start[i + 1]):
            cos, sin = turns[r].real, turns[r].imag
            left, right, low, high = np.inf, -np.inf, np.inf, -np.inf
            for c in range(start[i], start[i + 1]):
                x = corner[c].real * cos - corner[c].imag * sin
                y = corner[c].real * sin + corner[c].imag * cos
                left, right, low, high = min(left, x), max(right, x), min(low, y), max(high, y)
            area[r] = (right - left) * (high - low)
            least = min(least, area[r])
        for r in range(start[i], start[i + 1]):
            if area[r] <= ALIKE * least:
                best[i] = r
                break
    return best


@with_loops(_narrowest)
def narrowest(corner: ComplexArray, turns: ComplexArray, start: IntArray) -> IntArray:
    """Of each hull, which turn makes the upright rectangle around it smallest; the first of equal ones.

    Parameters
    ----------
    corner, turns : (#P,) complex128
        Points, and as many turns, which are tried for all points of the same hull.
    start : (#H + 1,) int64
        Hull i has those from start[i] to start[i + 1].

    Returns
    -------
    best : (#H,) int64
        -1 where there is none.
    """
    best = np.full(len(start) - 1, -1, dtype=np.int64)
    for i, (first, end) in enumerate(zip(start[:-1].tolist(), start[1:].tolist(), strict=True)):
        area = np.empty(end - first)
        step = max(ROWS // max(end - first, 1), 1)
        for row in range(first, end, step):
            turned = turns[row : min(row + step, end), None] * corner[first:end]
            area[row - first : row - first + len(turned)] = np.ptp(turned.real, axis=1) * np.ptp(
                turned.imag, axis=1
            )
        if end > first:
            best[i] = first + int(np.flatnonzero(area <= ALIKE * area.min())[0])
    return best
