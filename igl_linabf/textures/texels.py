"""Rasterise triangles: find the texels that they cover, and the nearby texels that a bilinear lookup uses.

Coordinates are in texels. The centre of texel (row, column) is at x = column, y = row, so that row k of a
page is at v = (k + 1/2) / height. The size of a page is its width and height.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import scipy

from .._types import BoolArray, FloatArray, IntArray
from ..surface import NEXT, PREV, index_and_rank

ROUNDING = 1e-9  # triangles are enlarged by this many texels, to close gaps between neighbours

Size = tuple[int, int]  # width and height
Rows = tuple[int, int]  # range of rows of a page: first row, and end (exclusive)


class SourceMarker(IntEnum):
    """Markers for texels without a source in an array of source texels."""

    FREE = -1  # a texel without a value so far
    OUTSIDE = -2  # a texel outside the page


@dataclass(frozen=True, eq=False)
class Texels:
    """A set of texels, and the corresponding point of the surface for each texel.

    Attributes
    ----------
    index : (#P,) int64
        Row times width plus column, without duplicates.
    face : (#P,) int64
    weights : (#P, 3) float64
        Barycentric coordinates in the face.
    """

    index: IntArray
    face: IntArray
    weights: FloatArray

    def select(self, rows: BoolArray | IntArray) -> "Texels":
        """Return the texels of a mask, or of rows."""
        return Texels(self.index[rows], self.face[rows], self.weights[rows])

    def interpolate(self, corners: FloatArray) -> FloatArray:
        """Interpolate values (#F, 3, k) from the corners of faces to the texels."""
        made = self.weights[:, :1] * corners[self.face, 0]
        for k in (1, 2):
            made += self.weights[:, k : k + 1] * corners[self.face, k]
        return np.asarray(made)


def find_covered_texels(triangles: FloatArray, size: Size, rows: Rows | None = None) -> Texels:
    """Return the texels whose centres lie in triangles (#F, 3, 2), each with the last triangle around it.

    If `rows` is given, only the texels in these rows are returned.
    """
    x, y = triangles[..., 0], triangles[..., 1]
    width, (begin, end) = size[0], rows or (0, size[1])
    bottom = np.clip(np.ceil(y.min(axis=1) - ROUNDING), begin, end).astype(np.int64)
    top = np.clip(np.floor(y.max(axis=1) + ROUNDING), begin - 1, end - 1).astype(np.int64)
    face, step = index_and_rank(np.maximum(top - bottom + 1, 0))
    row = bottom[face] + step
    left, right = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for k in range(3):
        rise = y[:, NEXT[k]] - y[:, k]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (row - y[face, k]) / rise[face]
        slack = ROUNDING / np.maximum(np.abs(rise), ROUNDING)[face]
        meets = (t >= -slack) & (t <= 1 + slack)  # False for horizontal sides
        at = x[face, k] + np.clip(np.where(meets, t, 0.0), 0, 1) * (x[:, NEXT[k]] - x[:, k])[face]
        np.minimum(left, np.where(meets, at, np.inf), out=left)
        np.maximum(right, np.where(meets, at, -np.inf), out=right)
    some = right >= left
    face, row, left, right = face[some], row[some], left[some], right[some]
    first = np.clip(np.ceil(left - ROUNDING), 0, width).astype(np.int64)
    last = np.clip(np.floor(right + ROUNDING), -1, width - 1).astype(np.int64)
    span, step = index_and_rank(np.maximum(last - first + 1, 0))
    column, row, face = first[span] + step, row[span], face[span]
    index = (row - begin) * width + column
    latest = np.full(width * (end - begin), -1, dtype=np.int64)
    latest[index] = np.arange(len(index))
    index = np.flatnonzero(latest >= 0)
    face = face[latest[index]]
    index += begin * width
    row, column = np.divmod(index, width)
    return Texels(index, face, _compute_barycentric(x, y, face, column, row))


def _compute_barycentric(
    x: FloatArray, y: FloatArray, face: IntArray, at_x: IntArray, at_y: IntArray
) -> FloatArray:
    """Return the barycentric coordinates of points (`at_x`, `at_y`) in the triangles `face`."""
    area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    safe = np.where(area == 0, 1.0, area)
    weights = np.empty((len(face), 3))
    for k in (1, 2):
        # weight k: distance of the point from the side opposite to corner k, divided by that of corner k
        i, j = NEXT[k], PREV[k]
        across, up = -(y[:, j] - y[:, i]) / safe, (x[:, j] - x[:, i]) / safe
        weights[:, k] = across[face] * (at_x - x[face, i]) + up[face] * (at_y - y[face, i])
    weights[:, 0] = 1 - weights[:, 1] - weights[:, 2]
    # clip, because rounding errors may move points on a side out of the triangle; the weights of degenerate
    # triangles do not matter
    np.clip(weights, 0, 1, out=weights)
    weights /= weights.sum(axis=1, keepdims=True)
    return weights


@dataclass(frozen=True, eq=False)
class NearbyTexels:
    """Texels near sides of triangles, at a distance of less than 1 in x and in y.

    Attributes
    ----------
    index : (#P,) int64
        Row times width plus column, once for each nearby side.
    side : (#P,) int64
    at : (#P,) float64
        Parameter of the nearest point on the side, from 0 to 1.
    distance : (#P,) float64
        Distance to the nearest point, in texels.
    """

    index: IntArray
    side: IntArray
    at: FloatArray
    distance: FloatArray


def find_texels_near_sides(
    start: FloatArray, end: FloatArray, size: Size, rows: Rows | None = None
) -> NearbyTexels:
    """Return the texels that a bilinear lookup on sides from `start` to `end`, (#S, 2) each, may use.

    If `rows` is given, only the texels in these rows are returned.
    """
    last = np.array(size) - 1
    low = np.clip(np.floor(np.minimum(start, end) - 1) + 1, 0, last).astype(np.int64)
    high = np.clip(np.ceil(np.maximum(start, end) + 1) - 1, 0, last).astype(np.int64)
    if rows is not None:
        low[:, 1], high[:, 1] = np.maximum(low[:, 1], rows[0]), np.minimum(high[:, 1], rows[1] - 1)
    side, step = index_and_rank(np.prod(np.maximum(high - low + 1, 0), axis=1))
    wide = (high - low + 1)[side, 0]
    centre = low[side] + np.column_stack((step % wide, step // wide))
    offset, direction = start[side] - centre, (end - start)[side]
    # max(|x|, |y|) is minimal at an end of the side, or where x = 0, y = 0 or |x| = |y|
    reach = np.minimum(np.abs(offset).max(axis=1), np.abs(offset + direction).max(axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        for axis in ([1, 0], [0, 1], [1, 1], [1, -1]):
            t = np.clip(np.nan_to_num(-(offset @ axis) / (direction @ axis)), 0, 1)
            reach = np.minimum(reach, np.abs(offset + t[:, None] * direction).max(axis=1))
        at = np.clip(np.nan_to_num(-(offset * direction).sum(axis=1) / (direction**2).sum(axis=1)), 0, 1)
    distance, near = np.linalg.norm(offset + at[:, None] * direction, axis=1), reach < 1 + ROUNDING
    return NearbyTexels(centre[near] @ [1, size[0]], side[near], at[near], distance[near])


def find_boundary_texels(
    triangles: FloatArray, sides: tuple[IntArray, IntArray], size: Size, rows: Rows
) -> Texels:
    """Return the texels near given sides (k, k + 1) of triangles, each with its nearest point on a side."""
    face, k = sides
    near = find_texels_near_sides(triangles[face, k], triangles[face, (k + 1) % 3], size, rows)
    order = np.argsort(-near.distance, kind="stable")  # descending: the nearest side is written last
    first = rows[0] * size[0]
    latest = np.full((rows[1] - rows[0]) * size[0], -1, dtype=np.int64)
    latest[near.index[order] - first] = order
    index = np.flatnonzero(latest >= 0)
    chosen = latest[index]
    index += first
    of, at = near.side[chosen], near.at[chosen]
    weights = np.zeros((len(index), 3))
    texel = np.arange(len(index))
    weights[texel, k[of]] = 1 - at
    weights[texel, (k[of] + 1) % 3] += at
    return Texels(index, face[of], weights)


def find_nearest_known_texels(is_known: BoolArray, steps: int) -> tuple[IntArray, IntArray]:
    """Return the texels that can be reached from known texels in `steps` steps, and the known texel for each.

    `is_known` is a mask of texels, (#rows, #columns).
    """
    index = np.arange(is_known.size).reshape(is_known.shape)
    source = np.pad(
        np.where(is_known, index, SourceMarker.FREE), 1, constant_values=SourceMarker.OUTSIDE
    ).ravel()
    edge = np.flatnonzero(np.pad(is_known & ~scipy.ndimage.binary_erosion(is_known, border_value=1), 1))
    wide, found = is_known.shape[1] + 2, [edge[:0]]
    neighbours = np.array([1, -1, wide, -wide, wide + 1, wide - 1, 1 - wide, -1 - wide])
    for _ in range(steps):
        to, by = np.add.outer(neighbours, edge).ravel(), np.tile(source[edge], len(neighbours))
        free = np.flatnonzero(source[to] == SourceMarker.FREE)
        edge, first = np.unique(to[free], return_index=True)
        source[edge] = by[free[first]]
        found.append(edge)
    made = np.concatenate(found)
    return np.pad(index, 1).ravel()[made], source[made]
