"""Resample the surface to a flat grid, whose points have equal distances in the map."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from .._types import FloatArray, IntArray
from ..errors import MeshWarning, stack_level
from ..io import Segment
from ..textures import Texels, find_covered_texels

FACES_AT_ONCE = 250_000  # number of triangles to sample at a time, to bound the memory


@dataclass(frozen=True, eq=False)
class Sheet:
    """A flattened piece of a segment.

    Attributes
    ----------
    origin : (#V,) int64
        The index of each vertex's point in the row-major list of the given grid's points.
    F : (#F, 3) int64
    cells : (#V, 2) float64
        The column and the row of each vertex in the flat grid, as fractions.
    """

    origin: IntArray
    F: IntArray
    cells: FloatArray


def compute_grid_positions(uv: FloatArray, scale: tuple[float, float]) -> tuple[FloatArray, tuple[int, int]]:
    """Return the column and the row of each vertex of a map with v upwards, and the size of the grid.

    The grid is centred, and as large as fits into the bounding box of the map.
    """
    cells = uv * scale
    low, high = np.nanmin(cells, axis=0), np.nanmax(cells, axis=0)
    columns, rows = (np.floor(high - low) + 1).astype(int).tolist()
    rest = (high - low - (columns - 1, rows - 1)) / 2
    return np.column_stack((cells[:, 0] - low[0] - rest[0], high[1] - cells[:, 1] - rest[1])), (columns, rows)


def sample_sheets(segment: Segment, sheets: list[Sheet], size: tuple[int, int]) -> Segment:
    """Interpolate the points and the channels of a segment at the points of the flat grid.

    Integer channels take the value at the nearest corner of the triangle; other channels are interpolated.
    Channels that do not have the size of the grid are left out with a warning.
    """
    columns, rows = size
    given = segment.points.shape[:2]
    kept = {name: values for name, values in segment.channels.items() if values.shape[:2] == given}
    lost = sorted(segment.channels.keys() - kept.keys())
    if lost:
        warnings.warn(
            f"the channels {', '.join(lost)} do not have the size of the grid, {given}: they are left out",
            MeshWarning,
            stacklevel=stack_level(),
        )
    sources = {"": segment.points, **kept}
    sources = {name: values.reshape(given[0] * given[1], -1) for name, values in sources.items()}
    made = {
        name: np.full((rows * columns, values.shape[1]), 0 if name else np.nan, dtype=values.dtype)
        for name, values in sources.items()
    }
    for sheet in sheets:
        for start in range(0, len(sheet.F), FACES_AT_ONCE):
            F = sheet.F[start : start + FACES_AT_ONCE]
            texels, F = find_covered_texels(sheet.cells[F], size), sheet.origin[F]
            for name, values in sources.items():
                made[name][texels.index] = _interpolate_texels(values, F, texels)
    points = made.pop("").reshape(rows, columns, 3)
    channels = {name: v.reshape(rows, columns, *kept[name].shape[2:]) for name, v in made.items()}
    return Segment(points, segment.scale, dict(segment.meta), channels)


def _interpolate_texels(values: np.ndarray, F: IntArray, texels: Texels) -> np.ndarray:
    """Interpolate values (#points, k) to texels linearly; integers are taken from the nearest corner."""
    if values.dtype.kind == "f":
        return texels.interpolate(values[F])
    nearest = texels.weights.argmax(axis=1)
    return np.asarray(values[F[texels.face, nearest]])
