"""Triangulate a grid of points, and check its scale."""

from __future__ import annotations

import numpy as np

from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError
from ..io import Segment

SCALE_TOLERANCE = 4.0  # maximum ratio of the median point distance to the distance that the scale states


def triangulate_grid(points: FloatArray, filled: BoolArray) -> tuple[IntArray, BoolArray]:
    """Split each grid cell with four valid points along its shorter diagonal.

    Return the triangles, (#F, 3), as indices into the row-major list of grid points, and a mask of the
    triangles of cells with a point that was filled in. Triangles are counterclockwise if columns run to the
    right and rows run down.
    """
    columns = points.shape[1]
    valid = np.asarray(np.isfinite(points).all(axis=2))
    row, column = np.nonzero(valid[:-1, :-1] & valid[:-1, 1:] & valid[1:, :-1] & valid[1:, 1:])
    a = row * columns + column  # upper left corner of each cell
    b, c, d = a + 1, a + columns, a + columns + 1
    flat, fill = points.reshape(-1, 3), filled.ravel()
    falling = np.linalg.norm(flat[d] - flat[a], axis=1) <= np.linalg.norm(flat[c] - flat[b], axis=1)
    first = np.column_stack((a, c, np.where(falling, d, b)))
    second = np.column_stack((np.where(falling, a, c), d, b))
    of_fill = np.repeat(fill[a] | fill[b] | fill[c] | fill[d], 2)
    return np.stack((first, second), axis=1).reshape(-1, 3), of_fill


def check_scale(segment: Segment) -> None:
    """Raise a MeshError if the distances of neighbouring points contradict the scale."""
    step = _compute_median_distance(segment.points, 1), _compute_median_distance(segment.points, 0)
    ratio = [d * s for d, s in zip(step, segment.scale, strict=True)]
    if all(1 / SCALE_TOLERANCE <= r <= SCALE_TOLERANCE for r in ratio):
        return
    rows, columns = segment.points.shape[:2]
    wide, high = columns * ratio[0], rows * ratio[1]
    would = " x ".join(f"{n:,.0f}" if n >= 10 else f"{n:.2g}" for n in (high, wide))
    sx, sy = segment.scale
    raise MeshError(
        f"the scale is [{sx:g}, {sy:g}] cells per voxel, or {1 / sx:.4g} and {1 / sy:.4g} voxels between "
        f"neighbouring points, but their median distance is {step[0]:.4g} and {step[1]:.4g} voxels: the flat "
        f"segment would have {would} points ({12e-9 * high * wide:,.2g} GB), not {rows:,} x {columns:,}; "
        f"correct the scale in meta.json, perhaps to [{1 / step[0]:.4f}, {1 / step[1]:.4f}], or the unit of "
        "the points, which is a voxel"
    )


def _compute_median_distance(points: FloatArray, axis: int) -> float:
    """Return the median distance of neighbours along an axis of the grid, without coincident points."""
    squared = (np.diff(points, axis=axis) ** 2).sum(axis=2)
    squared = squared[squared > 0]  # also drops NaN at missing points
    if not len(squared):
        what = ("rows", "columns")[axis]
        raise MeshError(f"no two neighbouring {what} have valid points at different positions")
    return float(np.sqrt(np.median(squared)))
