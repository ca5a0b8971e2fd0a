"""Cut triangles along straight lines of the plane, without gaps between neighbours."""

from dataclasses import dataclass, field

import numpy as np

from .._types import BoolArray, FloatArray, IntArray
from .constants import ROUNDING


@dataclass(frozen=True, eq=False)
class Fragments:
    """A triangle mesh in the plane and in space, which is successively cut into smaller triangles.

    Attributes
    ----------
    x : (#V, 2) float64
        Positions in the plane. Vertices created by a cut are exactly on the line.
    V : (#V, 3) float64
        The same vertices in space.
    F : (#F, 3) int64
    label : (#F,) int64
        Region of each triangle, inherited by its parts.
    """

    x: FloatArray
    V: FloatArray
    F: IntArray
    label: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))


def slice_along_integers(fragments: Fragments) -> Fragments:
    """Cut along all lines with integer coordinates, and label the parts by their cells."""
    x = _snap_to_integers(fragments.x)
    parts = Fragments(x, fragments.V, fragments.F, np.zeros(len(fragments.F), dtype=np.int64))
    for axis in (0, 1):
        low, high = x[:, axis].min(), x[:, axis].max()
        for value in range(int(np.floor(low)) + 1, int(np.ceil(high))):
            parts = _slice_triangles(parts, axis, float(value), None)
    low = parts.x[parts.F].min(axis=1)
    cell = np.floor(low).astype(np.int64)
    cell -= cell.min(axis=0)
    parts.label[:] = cell @ [1, cell[:, 0].max() + 1]
    return parts


def slice_region(fragments: Fragments, region: int, axis: int, value: float) -> Fragments:
    """Cut the triangles of one region along a line, and give the parts behind it a new label."""
    fresh = int(fragments.label.max()) + 1
    parts = _slice_triangles(fragments, axis, value, fragments.label == region)
    behind = parts.x[parts.F][..., axis].min(axis=1) >= value
    parts.label[behind & (parts.label == region)] = fresh
    return parts


def _snap_to_integers(x: FloatArray) -> FloatArray:
    """Round coordinates that are within rounding errors of an integer."""
    near = np.round(x)
    return np.where(np.abs(x - near) < ROUNDING, near, x)


def _slice_triangles(parts: Fragments, axis: int, value: float, rows: BoolArray | None) -> Fragments:
    """Cut the triangles of `rows` along a line, and split their neighbours at the new vertices."""
    x, V, F, label = parts.x, parts.V, parts.F, parts.label
    side = np.sign(x[:, axis] - value).astype(np.int8)
    corner = side[F]
    crossed = (corner.min(axis=1) < 0) & (corner.max(axis=1) > 0)
    if rows is not None:
        crossed &= rows
    if not crossed.any():
        return parts
    opposite = corner[:, [1, 2, 0]] * corner[:, [2, 0, 1]] < 0
    keys = np.unique(_make_edge_keys(F[crossed], len(x))[opposite[crossed]])
    a, b = np.divmod(keys, len(x))
    touched = crossed
    if rows is not None:
        touched = crossed | np.isin(_make_edge_keys(F, len(x)), keys).any(axis=1)
    marked = _make_edge_keys(F[touched], len(x))
    place = np.minimum(np.searchsorted(keys, marked), len(keys) - 1)
    middle = np.where(keys[place] == marked, len(x) + place, -1)
    t = ((value - x[a, axis]) / (x[b, axis] - x[a, axis]))[:, None]
    new = np.clip(x[a] + t * (x[b] - x[a]), np.minimum(x[a], x[b]), np.maximum(x[a], x[b]))
    new = _snap_to_integers(new)
    new[:, axis] = value
    pieces, parent = _split_triangles(F[touched], middle)
    return Fragments(
        np.concatenate((x, new)),
        np.concatenate((V, V[a] + t * (V[b] - V[a]))),
        np.concatenate((F[~touched], pieces)),
        np.concatenate((label[~touched], label[touched][parent])),
    )


def _make_edge_keys(F: IntArray, n: int) -> IntArray:
    """Return a unique number for each undirected edge, (#F, 3); column k is the edge opposite corner k."""
    after, last = F[:, [1, 2, 0]], F[:, [2, 0, 1]]
    return np.minimum(after, last) * n + np.maximum(after, last)


def _split_triangles(F: IntArray, middle: IntArray) -> tuple[IntArray, IntArray]:
    """Split triangles at new vertices on one or two of their sides.

    `middle` is the new vertex on the side opposite each corner, or -1. Returns the parts, and the triangle
    that each part belongs to.
    """
    count = (middle >= 0).sum(axis=1)
    one, two = np.flatnonzero(count == 1), np.flatnonzero(count == 2)

    def rotate(rows: IntArray, k: IntArray) -> tuple[IntArray, IntArray]:
        """Return corners and new vertices, rotated so that index k comes first."""
        order = (k[:, None] + np.arange(3)) % 3
        return np.take_along_axis(F[rows], order, 1).T, np.take_along_axis(middle[rows], order, 1).T

    (a, b, c), (m, *_) = rotate(one, np.argmax(middle[one] >= 0, axis=1))
    halves = np.concatenate((np.column_stack((a, b, m)), np.column_stack((a, m, c))))
    (p, q, r), (_, on_rp, on_pq) = rotate(two, np.argmax(middle[two] < 0, axis=1))
    thirds = np.concatenate(
        [np.column_stack(part) for part in ((p, on_pq, on_rp), (on_pq, q, r), (on_pq, r, on_rp))]
    )
    return np.concatenate((halves, thirds)), np.concatenate((np.tile(one, 2), np.tile(two, 3)))
