"""The narrowest rectangles around points: each lies along a side of their convex hull."""

import numpy as np
import shapely

from .._types import ComplexArray, FloatArray, IntArray
from .choice import inlined, with_loops

ALIKE = 1 + 1e-12  # times the least area is an equal one: rounding must not choose
ROWS = 1 << 20  # pairs of a turn and a point that are tried at once in NumPy, which bounds the memory
LEVEL = 1e-14  # of the lengths' product: below it, three points are on a line
OUTWARDS = np.exp(
    2j * np.pi / 16 * np.arange(16)
)  # points inside the hull of the farthest ones are not on it


@inlined
def _off(p: complex, q: complex, z: complex) -> float:
    """How far a point lies to the left of the way from p to q, times its length; 0 if it is on that line."""
    a, b = q - p, z - p
    area = a.real * b.imag - a.imag * b.real
    return area if area**2 > LEVEL**2 * (a.real**2 + a.imag**2) * (b.real**2 + b.imag**2) else 0.0


@inlined
def _outer(z: ComplexArray, outwards: ComplexArray, kept: ComplexArray) -> int:
    """Fill `kept` with the points that may be on the convex hull; their number."""
    fan = len(outwards)
    most, far = np.full(fan, -np.inf), np.zeros(fan, dtype=np.int64)
    for i in range(len(z)):
        for d in range(fan):
            along = z[i].real * outwards[d].real + z[i].imag * outwards[d].imag
            if along > most[d]:
                most[d], far[d] = along, i
    number = 0
    for i in range(len(z)):
        inside = True
        for d in range(fan):
            p, q = z[far[d]], z[far[(d + 1) % fan]]
            if p != q and _off(p, q, z[i]) <= 0:
                inside = False
                break
        if not inside:
            kept[number] = z[i]
            number += 1
    return number


@inlined
def _hull(z: ComplexArray, hull: ComplexArray) -> int:
    """Fill `hull` with the corners of the convex hull, clockwise from the lowest one (Andrew 1979)."""
    by_x = np.argsort(z.real, kind="mergesort")
    order = by_x[np.argsort(z.imag[by_x], kind="mergesort")]
    number, least = 0, 0
    for k in range(2 * len(z) - 1):
        if k == len(z):
            least = number - 1  # up along the left side, and down along the right one
        point = z[order[k if k < len(z) else 2 * len(z) - 2 - k]]
        while number > least + 1 and _off(hull[number - 2], hull[number - 1], point) >= 0:
            number -= 1
        if number == least + 1 and hull[number - 1] == point:
            continue
        hull[number] = point
        number += 1
    return max(number - 1, 1)  # the last one is the first


def _narrowest_turns(z: ComplexArray, start: IntArray) -> ComplexArray:
    turns = np.ones(len(start) - 1, dtype=np.complex128)
    most = 0
    for i in range(len(turns)):
        most = max(most, start[i + 1] - start[i])
    kept, hull = np.empty(most, dtype=np.complex128), np.empty(2 * most, dtype=np.complex128)
    areas = np.empty(most)
    for i in range(len(turns)):
        number = _hull(kept[: _outer(z[start[i] : start[i + 1]], OUTWARDS, kept)], hull)
        if number < 3:
            continue
        least = np.inf
        for r in range(number):
            edge = hull[(r + 1) % number] - hull[r]
            cos, sin = edge.real / abs(edge), -edge.imag / abs(edge)
            left, right, low, high = np.inf, -np.inf, np.inf, -np.inf
            for c in range(number):
                x = hull[c].real * cos - hull[c].imag * sin
                y = hull[c].real * sin + hull[c].imag * cos
                left, right, low, high = min(left, x), max(right, x), min(low, y), max(high, y)
            areas[r] = (right - left) * (high - low)
            least = min(least, areas[r])
        for r in range(number):
            if areas[r] <= ALIKE * least:
                edge = hull[(r + 1) % number] - hull[r]
                turns[i] = edge.conjugate() / abs(edge)
                break
    return turns


@with_loops(_narrowest_turns)
def narrowest_turns(z: ComplexArray, start: IntArray) -> ComplexArray:
    """Of each group of points, the turn that makes the upright rectangle around it smallest.

    Parameters
    ----------
    z : (#P,) complex128
    start : (#G + 1,) int64
        Group i has the points from start[i] to start[i + 1], two at least.

    Returns
    -------
    turns : (#G,) complex128
        1 for points on a line.
    """
    group = np.repeat(np.arange(len(start) - 1), np.diff(start))
    lines = shapely.linestrings(z.real, z.imag, indices=group)
    rings = shapely.get_exterior_ring(shapely.convex_hull(lines))
    coordinates, group = shapely.get_coordinates(rings, return_index=True)
    corner = coordinates[:, 0] + 1j * coordinates[:, 1]
    same = group[1:] == group[:-1]  # a ring ends with the point where it begins
    edge = (corner[1:] - corner[:-1])[same]
    begin = np.searchsorted(group[:-1][same], np.arange(len(start)))
    return np.append(edge.conj() / np.abs(edge), 1)[_narrowest(corner[:-1][same], edge, begin)]


def _narrowest(corner: ComplexArray, edge: ComplexArray, start: IntArray) -> IntArray:
    """Along which edge the rectangle around each hull is smallest; the first of equal ones, -1 of none."""
    turns = edge.conj() / np.abs(edge)
    best = np.full(len(start) - 1, -1, dtype=np.int64)
    for i, (first, end) in enumerate(zip(start[:-1].tolist(), start[1:].tolist(), strict=True)):
        area: FloatArray = np.empty(end - first)
        step = max(ROWS // max(end - first, 1), 1)
        for row in range(first, end, step):
            turned = turns[row : min(row + step, end), None] * corner[first:end]
            area[row - first : row - first + len(turned)] = np.ptp(turned.real, axis=1) * np.ptp(
                turned.imag, axis=1
            )
        if end > first:
            best[i] = first + int(np.flatnonzero(area <= ALIKE * area.min())[0])
    return best
