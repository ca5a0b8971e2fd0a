"""Many charts at once: turned to their narrowest rectangles, and put on shelves.

The rectangles lie, the highest ones first; every second shelf is filled from the right, and each rectangle
comes down onto what is below it. So high ones stand over low ones, and hardly a gap remains between shelves.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..surface import Parts

AT_ONCE = 1 << 20  # pairs of a turn and a point that are tried at once, which bounds the memory


def on_shelves(sizes: IntArray, side: int) -> tuple[IntArray, IntArray, BoolArray] | None:
    """Left, bottom, and whether it is turned, of rectangles (#R, 2) in a square; None if they do not fit."""
    turned = sizes[:, 1] > sizes[:, 0]
    width, height = sizes.max(axis=1), sizes.min(axis=1)
    if width.max() > side:
        return None
    order = np.lexsort((-width, -height))
    width, height = width[order], height[order]
    end = np.cumsum(width)
    x, y = np.empty_like(width), np.empty_like(width)
    edge, level = np.array([0]), np.array([0])  # of what is below: where each step begins, and its height
    first, leftward = 0, False
    while first < len(width):
        before = int(end[first] - width[first])
        last = int(np.searchsorted(end, before + side, side="right"))
        row = np.arange(first, last)
        left = end[row] - width[row] - before
        if leftward:
            left = side - left - width[row]
            row, left = row[::-1], left[::-1]
        right = left + width[row]
        bottom = _highest(edge, level, left, right)
        top = bottom + height[row]
        if top.max() > side:
            return None
        x[row], y[row] = left, bottom
        # beside the shelf what was below is still seen
        if leftward:
            rest = edge < left[0]
            edge, level = np.concatenate((edge[rest], left)), np.concatenate((level[rest], top))
        else:
            k = int(np.searchsorted(edge, right[-1], side="right"))
            edge = np.concatenate((left, right[-1:], edge[k:]))
            level = np.concatenate((top, level[k - 1 : k], level[k:]))
        first, leftward = last, not leftward
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return x[place], y[place], turned


def _highest(edge: IntArray, level: IntArray, left: IntArray, right: IntArray) -> IntArray:
    """The highest step below each of some intervals."""
    begin = np.searchsorted(edge, left, side="right") - 1
    stop = np.searchsorted(edge, right, side="left")
    bounds = np.column_stack((begin, stop)).ravel()
    return np.asarray(np.maximum.reduceat(np.append(level, 0), bounds)[::2])


def narrowest_turns(z: ComplexArray, charts: Parts) -> ComplexArray:
    """For each chart the turn to the rectangle of least area around it, which lies along its convex hull."""
    chart = charts.spread(np.arange(len(charts)))
    points = shapely.multipoints(shapely.points(z.real, z.imag), indices=chart)
    rings = shapely.get_exterior_ring(shapely.convex_hull(points))
    coordinates, chart = shapely.get_coordinates(rings, return_index=True)
    corner = coordinates[:, 0] + 1j * coordinates[:, 1]
    same = chart[1:] == chart[:-1]  # a ring ends with the point where it begins
    edge = (corner[1:] - corner[:-1])[same]
    hulls = Parts(np.searchsorted(chart[:-1][same], np.arange(len(charts) + 1)))
    corner, turns = corner[:-1][same], edge.conj() / np.abs(edge)
    best = np.ones(len(charts), dtype=np.complex128)
    for group in _groups(hulls):
        rows, columns = _all_pairs(hulls, group)
        turned = turns[rows] * corner[columns]
        tries = Parts(np.append(np.flatnonzero(np.diff(rows, prepend=-1)), len(rows)))
        spans = [tries.max(part) - tries.min(part) for part in (turned.real, turned.imag)]
        tried, cost = rows[tries.start[:-1]], spans[0] * spans[1]
        owner = np.repeat(group, hulls.sizes[group])
        order = np.lexsort((np.arange(len(cost)), cost, owner))
        first = np.flatnonzero(np.diff(owner[order], prepend=-1))
        best[owner[order][first]] = turns[tried[order][first]]
    return best


def _groups(hulls: Parts) -> Iterator[IntArray]:
    """Consecutive charts of not too many pairs of hull points."""
    pairs = np.cumsum(hulls.sizes**2)
    first = 0
    while first < len(hulls):
        base = pairs[first - 1] if first else 0
        last = max(first + 1, int(np.searchsorted(pairs, base + AT_ONCE, side="right")))
        yield np.arange(first, last)
        first = last


def _all_pairs(hulls: Parts, group: IntArray) -> tuple[IntArray, IntArray]:
    """Each hull point of the charts with each of the same chart."""
    sizes = hulls.sizes[group]
    rows = np.arange(hulls.start[group[0]], hulls.start[group[-1] + 1])
    of_row = np.repeat(np.arange(len(group)), sizes)
    repeated = sizes[of_row]
    within = np.arange(repeated.sum()) - np.repeat(np.cumsum(repeated) - repeated, repeated)
    return np.repeat(rows, repeated), np.repeat(hulls.start[group][of_row], repeated) + within


def extents(z: ComplexArray, charts: Parts) -> tuple[ComplexArray, ComplexArray]:
    """Lower left corners of the rectangles around charts, and their extents."""
    low, high = (function(z.real) + 1j * function(z.imag) for function in (charts.min, charts.max))
    return low, high - low


def areas(double: FloatArray, faces: Parts) -> FloatArray:
    """The area of each chart, by twice the signed areas of its faces."""
    return np.asarray(faces.sum(np.abs(double))) / 2
