"""Triangulate polygons in space without additional vertices.

Every corner belongs to a triangle, even if the corner lies on a straight side, because a neighbouring polygon
may use it. Ear clippers of other packages drop such corners. If all triangles have the orientation of their
simple polygon, they cover the polygon exactly once: their signed areas sum to the area of the polygon, and
each point is covered as often as the boundary winds around it.
"""

import numpy as np

from .._types import BoolArray, FloatArray, IntArray
from .constants import LARGEST_SEARCHED_POLYGON

SEARCH_BATCH = 4_000_000  # maximum number of elements (32 MB) of an array in the optimal triangulation
NEGLIGIBLE_POLYGON_AREA = 1e-12  # smaller double areas, over the squared longest diagonal, count as 0

# Costs of triangles with defects; all other triangles cost the sum of their cotangents.
COST_WITHOUT_AREA = 1e6
COST_OF_TAKEN_DIAGONAL = 100 * COST_WITHOUT_AREA  # cost of a diagonal that would have four faces
COST_OF_TURNED_TRIANGLE = 1000 * COST_OF_TAKEN_DIAGONAL  # cost of reversal, above any sum of the other costs


def triangulate_polygons(points: FloatArray, taken: BoolArray | None = None) -> IntArray:
    """Triangulate polygons that all have k corners.

    Parameters
    ----------
    points : (P, k, 3) float64
    taken : (P, k, k) bool, optional
        Pairs of corners to avoid as diagonals.

    Returns
    -------
    triangles : (P, k - 2, 3) int64
        Indices 0 .. k - 1 of corners, in the orientation of the polygon.
    """
    n, k, _ = points.shape
    if k == 3:
        return np.tile(np.arange(3), (n, 1, 1))
    if taken is None:
        made, bad = _triangulate_by_fans(points)
        if len(bad):
            made[bad] = _triangulate_with_costs(points[bad], None)
        return made
    return _triangulate_with_costs(points, taken)


def _triangulate_with_costs(points: FloatArray, taken: BoolArray | None) -> IntArray:
    n, k, _ = points.shape
    if k > LARGEST_SEARCHED_POLYGON:
        return np.stack([_clip_ears(polygon) for polygon in points])
    step = max(1, SEARCH_BATCH // k**2)
    parts = [
        _minimize_cost(points[i : i + step], None if taken is None else taken[i : i + step])
        for i in range(0, n, step)
    ]
    return np.concatenate(parts)


def _triangulate_by_fans(points: FloatArray) -> tuple[IntArray, IntArray]:
    """Triangulate by fans around the first corners, like igl; also return the polygons with invalid fans.

    A fan is invalid if a triangle is reversed or has no area.
    """
    k = points.shape[1]
    step = np.arange(1, k - 1)
    fan = np.column_stack((np.zeros(k - 2, dtype=np.int64), step, step + 1))
    with np.errstate(all="ignore"):  # coordinates may be NaN or infinite
        arm = points[:, 1:] - points[:, :1]
        cross = np.cross(arm[:, :-1], arm[:, 1:])
        normal = cross.sum(axis=1)  # normal by Newell's method
        area = np.einsum("ptx,px->pt", cross, normal)
        flat = NEGLIGIBLE_POLYGON_AREA * (arm**2).sum(axis=2).max(axis=1) * np.linalg.norm(normal, axis=1)
        bad = ~(area > flat[:, None]).all(axis=1)
    return np.tile(fan, (len(points), 1, 1)), np.flatnonzero(bad)


def _minimize_cost(points: FloatArray, taken: BoolArray | None) -> IntArray:
    """Find the triangulations of least cost by dynamic programming over runs of corners i .. j."""
    n, k, _ = points.shape
    points, normal = _normalize_polygons(points)
    length = ((points[:, :, None] - points[:, None]) ** 2).sum(axis=-1)
    turn = np.cross(points[:, :, None], points[:, None])
    area = np.einsum("pijx,px->pij", turn, normal)  # signed area of the triangle 0, i, j; antisymmetric
    flat = NEGLIGIBLE_POLYGON_AREA * length.max(axis=(1, 2))[:, None, None]
    best, middle = np.zeros((n, k, k)), np.zeros((n, k, k), dtype=np.int64)
    if taken is not None:
        best += COST_OF_TAKEN_DIAGONAL * taken
        step = np.arange(k)
        best[:, step[:-1], step[1:]] = best[:, 0, -1] = 0.0  # the sides of the polygon
    for gap in range(2, k):
        i = np.arange(k - gap)[:, None]
        j, m = i + gap, i + np.arange(1, gap)
        double = area[:, i, m] + area[:, m, j] + area[:, j, i]
        sides = length[:, i, m] + length[:, m, j] + length[:, i, j]
        # sides / area is the sum of cotangents, which a Delaunay triangulation minimizes
        cost = np.minimum(sides / np.maximum(double, np.maximum(flat, 1e-300)), COST_WITHOUT_AREA)
        cost[double < -flat] = COST_OF_TURNED_TRIANGLE
        cost += best[:, i, m] + best[:, m, j]
        at = cost.argmin(axis=2)
        middle[:, i[:, 0], j[:, 0]] = i[:, 0] + 1 + at
        best[:, i[:, 0], j[:, 0]] += np.take_along_axis(cost, at[..., None], axis=2)[..., 0]
    made, every = np.empty((n, k - 2, 3), dtype=np.int64), np.arange(n)
    low, high = (np.zeros((n, k), dtype=np.int64) for _ in range(2))
    high[:, 0], count = k - 1, np.ones(n, dtype=np.int64)
    for t in range(k - 2):
        i, j = low[:, t], high[:, t]
        m = middle[every, i, j]
        made[:, t] = np.column_stack((i, m, j))
        for start, end in ((i, m), (m, j)):
            low[every, count], high[every, count] = start, end
            count += end - start >= 2  # a run without a triangle is overwritten by the next run
    return made


def _normalize_polygons(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Center the polygons, scale them to size one, and compute their unit normals by Newell's method."""
    points = np.where(np.isfinite(points), points, 0.0)
    far = np.abs(points).max(axis=(1, 2), keepdims=True)
    points = points / np.where(far > 0, far, 1.0)  # the mean of huge coordinates could overflow
    points = points - points.mean(axis=1, keepdims=True)
    size = np.abs(points).max(axis=(1, 2), keepdims=True)
    points = points / np.where(size > 0, size, 1.0)
    normal = np.cross(points, np.roll(points, -1, axis=1)).sum(axis=1)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return points, np.asarray(normal / np.where(length > 0, length, 1.0))


def _clip_ears(polygon: FloatArray) -> IntArray:
    """Triangulate a polygon by clipping ears, the best-shaped ear first."""
    (points,), (normal,) = _normalize_polygons(polygon[None])
    across = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    flat = np.column_stack((points @ across, points @ np.cross(normal, across)))
    k = len(flat)
    before, after = np.roll(np.arange(k), 1), np.roll(np.arange(k), -1)
    remaining, cost = np.ones(k, dtype=bool), np.empty(k)
    corner_inside = np.full(k, -1)  # a corner that lies in the ear at each corner, so that it is not clipped

    def rate_ears(i: int | IntArray) -> None:
        a, b, c = flat[before[i]], flat[i], flat[after[i]]
        double = _compute_double_area(a, b, c)
        sides = ((b - a) ** 2).sum(-1) + ((c - b) ** 2).sum(-1) + ((a - c) ** 2).sum(-1)
        shape = np.minimum(sides / np.maximum(double, 1e-300), COST_WITHOUT_AREA)
        cost[i] = np.where(double < -NEGLIGIBLE_POLYGON_AREA, COST_OF_TURNED_TRIANGLE * (1 - double), shape)

    rate_ears(np.arange(k))
    made = np.empty((k - 2, 3), dtype=np.int64)
    for t in range(k - 2):
        while True:
            is_blocked = ~remaining | (corner_inside >= 0)
            ear = int(np.argmin(np.where(is_blocked, np.inf, cost)))
            stuck = is_blocked[ear] or cost[ear] >= COST_OF_TURNED_TRIANGLE
            if stuck:
                break
            corner_inside[ear] = _find_corner_inside(flat, before[ear], ear, after[ear], remaining)
            if corner_inside[ear] < 0:
                break
        if stuck:  # the polygon crosses itself: clip the cheapest ear
            ear = int(np.argmin(np.where(remaining, cost, np.inf)))
        i, j = before[ear], after[ear]
        made[t] = i, ear, j
        remaining[ear], after[i], before[j] = False, j, i
        rate_ears(i)
        rate_ears(j)
        corner_inside[[i, j]] = -1
        corner_inside[corner_inside == ear] = -1
    return made


def _find_corner_inside(flat: FloatArray, i: int, ear: int, j: int, remaining: BoolArray) -> int:
    """Return a remaining corner in an ear, or on the side where the ear is cut off; -1 if there is none."""
    a, b, c = flat[i], flat[ear], flat[j]
    inside = remaining & (_compute_double_area(a, b, flat) > 0) & (_compute_double_area(b, c, flat) > 0)
    inside &= _compute_double_area(c, a, flat) >= 0
    inside[[i, ear, j]] = False
    places = np.flatnonzero(inside)
    places = places[(flat[places] != a).any(axis=1) & (flat[places] != c).any(axis=1)]
    return int(places[0]) if len(places) else -1


def _compute_double_area(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    return np.asarray(
        (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
    )
