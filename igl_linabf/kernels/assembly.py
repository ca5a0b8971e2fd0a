"""Flat regions put together in the plane, edge to edge, as long as nothing lies over anything else.

A region keeps its own frame; what changes is the motion, z -> turn * z + shift, from there to the plane of
its chart. So two charts are joined in the time that it takes to move the regions of the smaller one, and the
search for overlaps finds the triangles of a region in a grid that is made once.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from .choice import inlined, with_loops

DEPTH = 0.5e-6  # of the height of the smaller triangle, by which one may reach into another one
AT_ONCE = 16  # triangles that are compared with others at a time, in NumPy
FEW = 12  # triangles of a region that need no grid
LONG = 15.0  # times what a chart that is too long for the page adds to it counts
SIDES = 24  # directions of those of rectangles around a chart
MOST_CELLS = 128  # along a side of the grid
WIDER = 1e-6  # of a cell: rounding

Grids = tuple[FloatArray, IntArray, IntArray, IntArray, IntArray]
Charts = tuple[IntArray, ComplexArray, ComplexArray]


class Hinges(NamedTuple):
    """Where regions may be joined.

    Two regions `pairs[h]` = (a, b) are joined by the motion of b's frame to a's, z -> `turn[h]` * z +
    `shift[h]`, where the rectangle around both charts takes at most `worth[h]` more than those around each,
    of a page of the area `page[h]`.
    """

    pairs: IntArray
    turn: ComplexArray
    shift: ComplexArray
    worth: FloatArray
    page: FloatArray


@inlined
def _grids(triangle: ComplexArray, start: IntArray) -> Grids:
    """Of each region the box around it, columns and rows, its first cell; the triangles in each cell."""
    n = len(start) - 1
    box, shape, first = np.empty((n, 4)), np.ones((n, 2), dtype=np.int64), np.zeros(n + 1, dtype=np.int64)
    for r in range(n):
        box[r, 0], box[r, 1], box[r, 2], box[r, 3] = np.inf, np.inf, -np.inf, -np.inf
        for t in range(start[r], start[r + 1]):
            for k in range(3):
                x, y = triangle[t, k].real, triangle[t, k].imag
                box[r, 0], box[r, 1] = min(box[r, 0], x), min(box[r, 1], y)
                box[r, 2], box[r, 3] = max(box[r, 2], x), max(box[r, 3], y)
        size = start[r + 1] - start[r]
        if size > FEW:
            wide, high = box[r, 2] - box[r, 0], box[r, 3] - box[r, 1]
            cell = np.sqrt(wide * high / size)
            for k in range(2):
                shape[r, k] = int(min(max((wide, high)[k] / max(cell, 1e-300), 1.0), MOST_CELLS))
        first[r + 1] = first[r] + shape[r, 0] * shape[r, 1]
    begin, span = np.zeros(first[n] + 1, dtype=np.int64), np.empty(4, dtype=np.int64)
    for r in range(n):
        for t in range(start[r], start[r + 1]):
            _rows(triangle[t], box[r], shape[r], span)
            for y in range(span[1], span[3] + 1):
                _columns(triangle[t], box[r], shape[r], y, span)
                for x in range(span[0], span[2] + 1):
                    begin[first[r] + y * shape[r, 0] + x + 1] += 1
    for cell in range(first[n]):
        begin[cell + 1] += begin[cell]
    listed, filled = np.empty(begin[-1], dtype=np.int64), begin[:-1].copy()
    for r in range(n):
        for t in range(start[r], start[r + 1]):
            _rows(triangle[t], box[r], shape[r], span)
            for y in range(span[1], span[3] + 1):
                _columns(triangle[t], box[r], shape[r], y, span)
                for x in range(span[0], span[2] + 1):
                    at = first[r] + y * shape[r, 0] + x
                    listed[filled[at]] = t
                    filled[at] += 1
    return box, shape, first, begin, listed


@inlined
def _rows(corners: ComplexArray, box: FloatArray, shape: IntArray, span: IntArray) -> None:
    """The first and the last row of the cells that a triangle touches, as `span[1]` and `span[3]`."""
    a, b, c = corners
    low, high = min(a.imag, b.imag, c.imag), max(a.imag, b.imag, c.imag)
    by = shape[1] / max(box[3] - box[1], 1e-300)
    span[1] = int(min(max((low - box[1]) * by, 0.0), shape[1] - 1.0))
    span[3] = int(min(max((high - box[1]) * by, 0.0), shape[1] - 1.0))


@inlined
def _columns(corners: ComplexArray, box: FloatArray, shape: IntArray, row: int, span: IntArray) -> None:
    """The first and the last column that it touches in a row, as `span[0]` and `span[2]`.

    The box around a thin triangle across the grid holds far more cells.
    """
    high = (box[3] - box[1]) / shape[1]
    floor = box[1] + (row - WIDER) * high
    ceiling = floor + (1 + 2 * WIDER) * high
    low_x, high_x = np.inf, -np.inf
    for k in range(3):
        a, b = corners[k], corners[(k + 1) % 3]
        if floor <= a.imag <= ceiling:
            low_x, high_x = min(low_x, a.real), max(high_x, a.real)
        for level in (floor, ceiling):
            if min(a.imag, b.imag) < level < max(a.imag, b.imag):
                x = a.real + (level - a.imag) / (b.imag - a.imag) * (b.real - a.real)
                low_x, high_x = min(low_x, x), max(high_x, x)
    by = shape[0] / max(box[2] - box[0], 1e-300)
    span[0] = int(min(max((low_x - box[0]) * by - WIDER, 0.0), shape[0] - 1.0))
    span[2] = int(min(max((high_x - box[0]) * by + WIDER, -1.0), shape[0] - 1.0))


@inlined
def _parted(one: ComplexArray, other: ComplexArray, least: float) -> bool:
    """Whether a side of the first triangle has the other one beyond it, but for the depth `least`."""
    for k in range(3):
        start, side = one[k], one[(k + 1) % 3] - one[k]
        length, beyond = np.sqrt(side.real**2 + side.imag**2), True
        for corner in range(3):
            step = other[corner] - start
            beyond &= side.real * step.imag - side.imag * step.real <= least * length
        if beyond:
            return True
    return False


@inlined
def _meet(
    triangle: ComplexArray,
    depth: FloatArray,
    start: IntArray,
    grids: Grids,
    of_grid: int,
    other: int,
    by: complex,
    to: complex,
    moved: ComplexArray,
    span: IntArray,
) -> bool:
    """Whether a triangle of a region, moved to the frame of another one, lies over a triangle there."""
    box, shape, first, begin, listed = grids
    own = box[of_grid]
    for t in range(start[other], start[other + 1]):
        if depth[t] < 0:
            continue
        for k in range(3):
            moved[k] = by * triangle[t, k] + to
        a, b, c = moved
        low_x, high_x = min(a.real, b.real, c.real), max(a.real, b.real, c.real)
        low_y, high_y = min(a.imag, b.imag, c.imag), max(a.imag, b.imag, c.imag)
        if high_x < own[0] or low_x > own[2] or high_y < own[1] or low_y > own[3]:
            continue
        _rows(moved, own, shape[of_grid], span)
        for y in range(span[1], span[3] + 1):
            _columns(moved, own, shape[of_grid], y, span)
            for x in range(span[0], span[2] + 1):
                at = first[of_grid] + y * shape[of_grid, 0] + x
                for i in range(begin[at], begin[at + 1]):
                    s = listed[i]
                    if depth[s] < 0:
                        continue
                    corners, least = triangle[s], min(depth[s], depth[t])
                    if not _parted(corners, moved, least) and not _parted(moved, corners, least):
                        return True
    return False


@inlined
def _moved_box(box: FloatArray, by: complex, to: complex, into: FloatArray) -> None:
    """A box around a box that is moved."""
    centre = by * complex((box[0] + box[2]) / 2, (box[1] + box[3]) / 2) + to
    wide, high = (box[2] - box[0]) / 2, (box[3] - box[1]) / 2
    x = abs(by.real) * wide + abs(by.imag) * high
    y = abs(by.imag) * wide + abs(by.real) * high
    into[0], into[2] = centre.real - x, centre.real + x
    into[1], into[3] = centre.imag - y, centre.imag + y


@inlined
def _widened(extent: FloatArray, box: FloatArray, by: complex, to: complex, along: ComplexArray) -> None:
    """Widen an extent, the largest coordinate in each direction, to hold a box that is moved."""
    centre = by * complex((box[0] + box[2]) / 2, (box[1] + box[3]) / 2) + to
    across, up = by * ((box[2] - box[0]) / 2), by * ((box[3] - box[1]) / 2)
    half = len(along) // 2
    for k in range(half):
        x, y = along[k].real, along[k].imag
        middle = centre.real * x + centre.imag * y
        reach = abs(across.real * x + across.imag * y) + abs(up.real * y - up.imag * x)
        extent[k] = max(extent[k], middle + reach)
        extent[k + half] = max(extent[k + half], reach - middle)


@inlined
def _taken(extent: FloatArray, page: float) -> float:
    """The area of the smallest rectangle along one of the directions; or what a long one takes of a page."""
    least, quarter = np.inf, len(extent) // 4
    for k in range(quarter):
        wide, high = extent[k] + extent[k + 2 * quarter], extent[k + quarter] + extent[k + 3 * quarter]
        least = min(least, max(wide * high, LONG * (max(wide, high) ** 2 / 2 - page)))
    return float(least)


def _assembled(triangle: ComplexArray, depth: FloatArray, start: IntArray, hinges: Hinges) -> Charts:
    n = len(start) - 1
    grids = _grids(triangle, start)
    along, extent = np.exp(2j * np.pi * np.arange(SIDES) / SIDES), np.full((n, SIDES), -np.inf)
    for r in range(n):
        _widened(extent[r], grids[0][r], 1.0 + 0.0j, 0.0j, along)
    both = extent[0].copy()
    box, chart = grids[0].copy(), np.arange(n)
    turn, shift = np.ones(n, dtype=np.complex128), np.zeros(n, dtype=np.complex128)
    following, last, size = np.full(n, -1), np.arange(n), np.ones(n, dtype=np.int64)
    around, near = box.copy(), np.empty(4)
    moved, span = np.empty(3, dtype=np.complex128), np.empty(4, dtype=np.int64)
    for h in range(len(hinges.pairs)):
        a, b = hinges.pairs[h]
        here, there = chart[a], chart[b]
        if here == there:
            continue
        # from the plane of b's chart, by b's own frame and a's, to that of a's chart
        by = turn[a] * hinges.turn[h] * np.conj(turn[b])
        to = turn[a] * hinges.shift[h] + shift[a] - by * shift[b]
        if size[here] < size[there]:
            here, there, by = there, here, np.conj(by)
            to = -by * to
        both[:] = extent[here]
        s = there
        while s >= 0:
            _widened(both, grids[0][s], by * turn[s], by * shift[s] + to, along)
            s = following[s]
        page = hinges.page[h]
        more = _taken(both, page) - _taken(extent[here], page) - _taken(extent[there], page)
        at_hinge = b if chart[b] == there else a  # it comes second: it often lies over something, too
        fits, s = more <= hinges.worth[h], there
        while fits and s >= 0:
            own_turn, own_shift = by * turn[s], by * shift[s] + to
            _moved_box(grids[0][s], own_turn, own_shift, near)
            r = here
            if (
                near[0] > around[here, 2]
                or near[2] < around[here, 0]
                or near[1] > around[here, 3]
                or near[3] < around[here, 1]
            ):
                r = -1
            while fits and r >= 0:
                if (
                    near[0] <= box[r, 2]
                    and near[2] >= box[r, 0]
                    and near[1] <= box[r, 3]
                    and near[3] >= box[r, 1]
                ):
                    back = np.conj(turn[r]) * own_turn
                    forth = np.conj(turn[r]) * (own_shift - shift[r])
                    if start[s + 1] - start[s] <= start[r + 1] - start[r]:
                        fits = not _meet(triangle, depth, start, grids, r, s, back, forth, moved, span)
                    else:
                        back = np.conj(back)
                        fits = not _meet(
                            triangle, depth, start, grids, s, r, back, -back * forth, moved, span
                        )
                r = following[r]
            if s == there and at_hinge != there:
                s = at_hinge
            else:
                s = following[there] if s == at_hinge else following[s]
                if s == at_hinge:
                    s = following[s]
        if not fits:
            continue
        extent[here] = both
        s = there
        while s >= 0:
            turn[s], shift[s] = by * turn[s], by * shift[s] + to
            turn[s] /= abs(turn[s])
            _moved_box(grids[0][s], turn[s], shift[s], box[s])
            chart[s] = here
            for k in range(2):
                around[here, k] = min(around[here, k], box[s, k])
                around[here, 2 + k] = max(around[here, 2 + k], box[s, 2 + k])
            s = following[s]
        following[last[here]] = there
        last[here] = last[there]
        size[here] += size[there]
    return chart, turn, shift


@with_loops(_assembled)
def assembled(triangle: ComplexArray, depth: FloatArray, start: IntArray, hinges: Hinges) -> Charts:
    """The chart of each region, and the motion from the region's frame to the plane of the chart.

    Region r has the counter-clockwise triangles (#T, 3) from `start[r]` to `start[r + 1]`. One after the
    other, regions are joined by `hinges` with all that is joined to them, where the motion brings nothing of
    the one chart over the other. Triangles may reach into each other by the smaller of their `depth`; those
    of a negative one are not asked.
    """
    n, bounds = len(start) - 1, list(pairwise(start.tolist()))
    members, chart = [[r] for r in range(n)], np.arange(n)
    turn, shift = np.ones(n, dtype=np.complex128), np.zeros(n, dtype=np.complex128)
    ends = [[(x.min(), x.max()) for x in (z.real, z.imag)] for z in (triangle[i:j] for i, j in bounds)]
    corner = np.array([[complex(x, y) for x in ends_x for y in ends_y] for ends_x, ends_y in ends])
    extent = _extents(corner)
    solid = [np.flatnonzero(depth[i:j] >= 0) + i for i, j in bounds]
    flat = [(triangle[rows], depth[rows]) for rows in solid]  # those of each chart, in its plane
    listed = zip(*(column.tolist() for column in hinges), strict=True)
    for (a, b), own_turn, own_shift, most, whole in listed:
        here, there = int(chart[a]), int(chart[b])
        if here == there:
            continue
        by = turn[a] * own_turn * np.conj(turn[b])
        to = turn[a] * own_shift + shift[a] - by * shift[b]
        if len(members[here]) < len(members[there]):
            here, there, by = there, here, np.conj(by)
            to = -by * to
        joined = members[there]
        moved = by * (turn[joined, None] * corner[joined] + shift[joined, None]) + to
        both = np.maximum(extent[here], _extents(moved.reshape(1, -1))[0])
        if _taken(both, whole) - _taken(extent[here], whole) - _taken(extent[there], whole) > most:
            continue
        moving = by * flat[there][0] + to, flat[there][1]
        if _meets(flat[here], moving):
            continue
        extent[here] = both
        turn[joined], shift[joined], chart[joined] = by * turn[joined], by * shift[joined] + to, here
        turn[joined] /= np.abs(turn[joined])
        flat[here] = np.concatenate((flat[here][0], moving[0])), np.concatenate((flat[here][1], moving[1]))
        members[here], members[there] = members[here] + joined, []
    return chart, turn, shift


def _extents(points: ComplexArray) -> FloatArray:
    """The largest coordinate of each row of points in each direction."""
    along = np.exp(-2j * np.pi * np.arange(SIDES) / SIDES)
    return np.asarray((points[:, :, None] * along).real.max(axis=1))


Solid = tuple[ComplexArray, FloatArray]  # triangles, and their depths


def _meets(fixed: Solid, moving: Solid) -> bool:
    """Whether one of some triangles lies over one of others."""
    for _ in range(2):  # those that touch the box around all others
        boxes = [_sides(triangle) for triangle, _ in (fixed, moving)]
        low, high = boxes[1][:2].min(axis=1, initial=np.inf), boxes[1][2:].max(axis=1, initial=-np.inf)
        near = ((boxes[0][:2] <= high[:, None]) & (boxes[0][2:] >= low[:, None])).all(axis=0)
        fixed, moving = moving, (fixed[0][near], fixed[1][near])
    (one, depth), (other, own) = fixed, moving
    for first in range(0, len(one), AT_ONCE):
        rows = slice(first, first + AT_ONCE)
        a, b = _sides(one[rows])[:, :, None], _sides(other)[:, None]
        i, j = np.nonzero(((a[:2] <= b[2:]) & (b[:2] <= a[2:])).all(axis=0))
        i += first
        least = np.minimum(depth[i], own[j])
        if (~_parted_pairs(one[i], other[j], least) & ~_parted_pairs(other[j], one[i], least)).any():
            return True
    return False


def _sides(triangle: ComplexArray) -> FloatArray:
    """The left, lower, right and upper sides of boxes around triangles, (4, #T)."""
    x, y = triangle.real, triangle.imag
    return np.stack((x.min(axis=1), y.min(axis=1), x.max(axis=1), y.max(axis=1)))


def _parted_pairs(one: ComplexArray, other: ComplexArray, least: FloatArray) -> BoolArray:
    """`_parted` of pairs of triangles."""
    side = np.roll(one, -1, axis=1) - one
    inward = (side / np.abs(side)).conj()
    reach = (inward[:, :, None] * (other[:, None] - one[:, :, None])).imag
    return np.asarray((reach.max(axis=2) <= least[:, None]).any(axis=1))
