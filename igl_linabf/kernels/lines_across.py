"""What lines across a flat graph divide it into: how far the parts reach, and how long the cuts are."""

import numpy as np

from .._core import connected_labels
from .._types import BoolArray, FloatArray, IntArray
from .choice import inlined, with_loops
from .connectivity import root
from .triangles import sum_by

Divisions = tuple[FloatArray, FloatArray, FloatArray]


@inlined
def _hull_of(points: FloatArray, at: IntArray) -> float:
    """The area of the polygon through points."""
    double = 0.0
    for d in range(len(at)):
        i, j = at[d], at[(d + 1) % len(at)]
        double += points[i, 0] * points[j, 1] - points[j, 0] * points[i, 1]
    return double / 2


def _divisions(
    points: FloatArray,
    ends: IntArray,
    length: FloatArray,
    outer: BoolArray,
    normal: FloatArray,
    offset: FloatArray,
    outwards: FloatArray,
) -> Divisions:
    n, lines, fan = len(points), len(offset), outwards.shape[1]
    hulls, widest, cut = np.zeros(lines), np.zeros(lines), np.zeros(lines)
    beyond, near = np.empty(n, dtype=np.bool_), np.empty(n, dtype=np.bool_)
    parent, part = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    most, at = np.empty((n, fan)), np.empty((n, fan), dtype=np.int64)
    for k in range(lines):
        for i in range(n):
            beyond[i] = points[i, 0] * normal[k, 0] + points[i, 1] * normal[k, 1] > offset[k]
            near[i], parent[i], part[i] = outer[i], i, -1
        for e in range(len(ends)):
            i, j = ends[e, 0], ends[e, 1]
            if beyond[i] != beyond[j]:
                cut[k] += length[e]
                near[i], near[j] = True, True
                continue
            i, j = root(parent, i), root(parent, j)
            parent[max(i, j)] = min(i, j)
        number = 0
        for i in range(n):
            if not near[i]:
                continue
            r = root(parent, i)
            if part[r] < 0:
                part[r] = number
                most[number], at[number] = -np.inf, i
                number += 1
            p, x, y = part[r], points[i, 0], points[i, 1]
            for d in range(fan):
                far = x * outwards[0, d] + y * outwards[1, d]
                if far > most[p, d]:
                    most[p, d], at[p, d] = far, i
        for p in range(number):
            hulls[k] += _hull_of(points, at[p])
            wide, high = most[p, 0] + most[p, fan // 2], most[p, fan // 4] + most[p, 3 * fan // 4]
            widest[k] = max(widest[k], np.sqrt(wide**2 + high**2))
    return hulls, widest, cut


@with_loops(_divisions)
def divisions(
    points: FloatArray,
    ends: IntArray,
    length: FloatArray,
    outer: BoolArray,
    normal: FloatArray,
    offset: FloatArray,
    outwards: FloatArray,
) -> Divisions:
    """What each line leaves of a graph in the plane, of which it cuts the edges that it crosses.

    Parameters
    ----------
    points : (#P, 2) float64
    ends : (#E, 2) int64
    length : (#E,) float64
        What it costs to cut an edge.
    outer : (#P,) bool
        Points that may be on the convex hull of a part; those at edges that are cut are, too.
    normal : (#L, 2) float64
    offset : (#L,) float64
        Beyond line k are the points whose product with its normal is larger.
    outwards : (2, 4 #D) float64
        Unit vectors by equal angles; the first one is (1, 0).

    Returns
    -------
    hulls : (#L,) float64
        The area of the convex hulls of connected parts: of their points that are farthest out.
    widest : (#L,) float64
        The longest diagonal of an upright rectangle around a part.
    cut : (#L,) float64
        The lengths of the edges that are cut, added up.
    """
    n, lines, quarter = len(points), len(offset), outwards.shape[1] // 4
    beyond = normal @ points.T > offset[:, None]
    line, edge = np.nonzero(beyond[:, ends[:, 0]] == beyond[:, ends[:, 1]])
    label = connected_labels(ends[edge] + n * line[:, None], n * lines)
    line, edge = np.nonzero(beyond[:, ends[:, 0]] != beyond[:, ends[:, 1]])
    near = np.tile(outer, (lines, 1))
    near[line[:, None], ends[edge]] = True
    of, point = np.nonzero(near)
    part = label[of * n + point]
    order = np.argsort(part, kind="stable")
    of, point, part = of[order], point[order], part[order]
    first = np.flatnonzero(np.diff(part, prepend=-1))
    far = points[point] @ outwards
    most = np.maximum.reduceat(far, first)
    number = np.diff(first, append=len(part))
    row, column = np.nonzero(far == np.repeat(most, number, axis=0))
    at = np.empty(most.shape, dtype=np.int64)
    at[np.repeat(np.arange(len(first)), number)[row[::-1]], column[::-1]] = point[row[::-1]]  # the first wins
    x, y = points[at].T
    hull = (x * np.roll(y, -1, axis=0) - y * np.roll(x, -1, axis=0)).sum(axis=0) / 2
    size = np.linalg.norm(most[:, : 2 * quarter : quarter] + most[:, 2 * quarter :: quarter], axis=1)
    widest = np.zeros(lines)
    np.maximum.at(widest, of[first], size)
    return sum_by(of[first], hull, lines), widest, sum_by(line, length[edge], lines)
