"""The texels of a page that triangles cover, and those around them that a lookup may ask for.

Coordinates are in texels: the centre of texel (row, column) lies at x = column, y = row. So row k of a page
holds v = (k + 1/2) / height. A page's size is its width and its height.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import scipy

from .._types import FloatArray, IntArray
from ..surface import NEXT, PREV, index_and_rank

# Texels by which triangles are taken as larger, so that their sides are covered. With less, rounding leaves
# gaps between neighbours; with more, texels beside a triangle show it. tests/textures/test_baking.py.
ROUNDING = 1e-9

Size = tuple[int, int]  # width and height


class Source(IntEnum):
    """What stands for the texel that another one copies, where there is none."""

    FREE = -1  # none is known near
    OUTSIDE = -2  # the rim around a page


@dataclass(frozen=True, eq=False)
class Texels:
    """Some texels, and the point of the surface that each shows.

    Attributes
    ----------
    index : (#P,) int64
        Row times width plus column; each once.
    face : (#P,) int64
    weights : (#P, 3) float64
        Barycentric coordinates in that face.
    """

    index: IntArray
    face: IntArray
    weights: FloatArray

    def values(self, corners: FloatArray) -> FloatArray:
        """Values at the corners (#F, 3, k), interpolated."""
        made = self.weights[:, :1] * corners[self.face, 0]
        for k in (1, 2):
            made += self.weights[:, k : k + 1] * corners[self.face, k]
        return np.asarray(made)


def covered(triangles: FloatArray, size: Size) -> Texels:
    """The texels whose centres lie in triangles (#F, 3, 2); of two triangles, in the later one."""
    x, y = triangles[..., 0], triangles[..., 1]
    width, height = size
    bottom = np.clip(np.ceil(y.min(axis=1) - ROUNDING), 0, height).astype(np.int64)
    top = np.clip(np.floor(y.max(axis=1) + ROUNDING), -1, height - 1).astype(np.int64)
    face, step = index_and_rank(np.maximum(top - bottom + 1, 0))
    row = bottom[face] + step
    left, right = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for k in range(3):
        rise = y[:, NEXT[k]] - y[:, k]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (row - y[face, k]) / rise[face]
        slack = ROUNDING / np.maximum(np.abs(rise), ROUNDING)[face]
        meets = (t >= -slack) & (t <= 1 + slack)  # a level side is met by its neighbours
        at = x[face, k] + np.clip(np.where(meets, t, 0.0), 0, 1) * (x[:, NEXT[k]] - x[:, k])[face]
        np.minimum(left, np.where(meets, at, np.inf), out=left)
        np.maximum(right, np.where(meets, at, -np.inf), out=right)
    some = right >= left
    face, row, left, right = face[some], row[some], left[some], right[some]
    first = np.clip(np.ceil(left - ROUNDING), 0, width).astype(np.int64)
    last = np.clip(np.floor(right + ROUNDING), -1, width - 1).astype(np.int64)
    span, step = index_and_rank(np.maximum(last - first + 1, 0))
    column, row, face = first[span] + step, row[span], face[span]
    index = row * width + column
    latest = np.full(width * height, -1, dtype=np.int64)
    latest[index] = np.arange(len(index))
    index = np.flatnonzero(latest >= 0)
    face = face[latest[index]]
    row, column = np.divmod(index, width)
    return Texels(index, face, _barycentric(x, y, face, column, row))


def _barycentric(x: FloatArray, y: FloatArray, face: IntArray, at_x: IntArray, at_y: IntArray) -> FloatArray:
    """Weights of points in triangles: linear functions, found for each triangle once."""
    area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    safe = np.where(area == 0, 1.0, area)
    weights = np.empty((len(face), 3))
    for k in (1, 2):
        # the height over the side opposite to corner k, as a share of the corner's own
        i, j = NEXT[k], PREV[k]
        across, up = -(y[:, j] - y[:, i]) / safe, (x[:, j] - x[:, i]) / safe
        weights[:, k] = across[face] * (at_x - x[face, i]) + up[face] * (at_y - y[face, i])
    weights[:, 0] = 1 - weights[:, 1] - weights[:, 2]
    # of a triangle without an area any point is as good; a centre on a side may lie out by rounding
    np.clip(weights, 0, 1, out=weights)
    weights /= weights.sum(axis=1, keepdims=True)
    return weights


@dataclass(frozen=True, eq=False)
class Nearby:
    """Texels near sides: less than 1 away in x and in y.

    Attributes
    ----------
    index : (#P,) int64
        Row times width plus column; once for each side that it is near to.
    side : (#P,) int64
    at : (#P,) float64
        Where on the side its nearest point is, from 0 to 1.
    distance : (#P,) float64
        To that point, in texels.
    """

    index: IntArray
    side: IntArray
    at: FloatArray
    distance: FloatArray


def near_sides(start: FloatArray, end: FloatArray, size: Size) -> Nearby:
    """The texels that a bilinear lookup on sides (#S, 2) to (#S, 2) may ask for: less than 1 away."""
    last = np.array(size) - 1
    low = np.clip(np.floor(np.minimum(start, end) - 1) + 1, 0, last).astype(np.int64)
    high = np.clip(np.ceil(np.maximum(start, end) + 1) - 1, 0, last).astype(np.int64)
    side, step = index_and_rank(np.prod(np.maximum(high - low + 1, 0), axis=1))
    wide = (high - low + 1)[side, 0]
    centre = low[side] + np.column_stack((step % wide, step // wide))
    offset, direction = start[side] - centre, (end - start)[side]
    # max(|x|, |y|) along a side is least at an end, where x or y vanishes, or where they are equal
    reach = np.minimum(np.abs(offset).max(axis=1), np.abs(offset + direction).max(axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        for axis in ([1, 0], [0, 1], [1, 1], [1, -1]):
            t = np.clip(np.nan_to_num(-(offset @ axis) / (direction @ axis)), 0, 1)
            reach = np.minimum(reach, np.abs(offset + t[:, None] * direction).max(axis=1))
        at = np.clip(np.nan_to_num(-(offset * direction).sum(axis=1) / (direction**2).sum(axis=1)), 0, 1)
    distance, near = np.linalg.norm(offset + at[:, None] * direction, axis=1), reach < 1 + ROUNDING
    return Nearby(centre[near] @ [1, size[0]], side[near], at[near], distance[near])


def around(triangles: FloatArray, sides: tuple[IntArray, IntArray], size: Size) -> Texels:
    """The texels near sides k to k + 1 of faces; each shows the nearest point of the nearest side."""
    face, k = sides
    near = near_sides(triangles[face, k], triangles[face, (k + 1) % 3], size)
    order = np.argsort(-near.distance, kind="stable")  # the nearest one comes last, and counts
    latest = np.full(size[0] * size[1], -1, dtype=np.int64)
    latest[near.index[order]] = order
    index = np.flatnonzero(latest >= 0)
    chosen = latest[index]
    of, at = near.side[chosen], near.at[chosen]
    weights = np.zeros((len(index), 3))
    rows = np.arange(len(index))
    weights[rows, k[of]] = 1 - at
    weights[rows, (k[of] + 1) % 3] += at
    return Texels(index, face[of], weights)


def nearest_known(known: IntArray, size: Size, steps: int) -> tuple[IntArray, IntArray]:
    """Texels within some steps of those that are known, and a known one near each."""
    is_known = np.zeros(size[::-1], dtype=bool)
    is_known.flat[known] = True
    index = np.arange(is_known.size).reshape(is_known.shape)
    source = np.pad(np.where(is_known, index, Source.FREE), 1, constant_values=Source.OUTSIDE).ravel()
    edge = np.flatnonzero(np.pad(is_known & ~scipy.ndimage.binary_erosion(is_known, border_value=1), 1))
    wide, found = size[0] + 2, [edge[:0]]
    neighbours = np.array([1, -1, wide, -wide, wide + 1, wide - 1, 1 - wide, -1 - wide])
    for _ in range(steps):
        to, by = np.add.outer(neighbours, edge).ravel(), np.tile(source[edge], len(neighbours))
        free = np.flatnonzero(source[to] == Source.FREE)
        edge, first = np.unique(to[free], return_index=True)
        source[edge] = by[free[first]]
        found.append(edge)
    made = np.concatenate(found)
    return np.pad(index, 1).ravel()[made], source[made]
