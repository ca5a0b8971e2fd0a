"""Define the flat segment, and measure the distortion of its map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._runtime import align_columns
from .._types import FloatArray, IntArray
from ..errors import format_count
from ..io import Segment
from ..measures import find_overlapping_pairs, format_pair_count, measure_change
from ..surface import Repair, Submesh


@dataclass(frozen=True, eq=False)
class SegmentReport:
    """The distortion of a flat segment, and the parts of the given segment that are not in it.

    Attributes
    ----------
    method : str
        The method of flattening.
    faces : int
        Number of triangles.
    area : float
        Area of the surface in square voxels; the map has the same area.
    stretch_l2, stretch_l2_median, stretch_linf : float
        L2 stretch of the triangles (Sander et al. 2001): the root of the mean square, and the median, both
        weighted by area; and the largest stretch. 1 is best.
    area_error : float
        Mean over the triangles of 1 - min(a / b, b / a), where a and b are the areas on the surface and in
        the map. 0 is best.
    flips, overlaps : int
        Number of flipped triangles, and of pairs of triangles that overlap in the map.
    left_out : tuple of int
        Numbers of triangles of the pieces that are not flattened, largest first.
    repairs : tuple of Repair
        Repairs before flattening, for example of triangles between coincident points. Cells with four valid
        points have two triangles each, in the order of the grid.
    seconds : float
        Duration of the computation.
    """

    method: str
    faces: int
    area: float
    stretch_l2: float
    stretch_l2_median: float
    stretch_linf: float
    area_error: float
    flips: int
    overlaps: int
    left_out: tuple[int, ...]
    repairs: tuple[Repair, ...]
    seconds: float

    def __str__(self) -> str:
        rows = [
            ["method", self.method],
            ["triangles", f"{self.faces:,}"],
            ["area in square voxels", f"{self.area:,.0f}"],
            ["L2 stretch, mean", f"{self.stretch_l2:.4f}"],
            ["L2 stretch, median", f"{self.stretch_l2_median:.4f}"],
            ["stretch, largest", f"{self.stretch_linf:.4f}"],
            ["area error, mean", f"{self.area_error:.4f}"],
            ["flipped triangles", f"{self.flips:,}"],
            ["overlapping pairs", format_pair_count(self.overlaps)],
            ["seconds", f"{self.seconds:.1f}"],
        ]
        lines = [align_columns(rows)]
        if self.left_out:
            sizes = ", ".join(f"{n:,}" for n in self.left_out[:5]) + ", ..." * (len(self.left_out) > 5)
            lines.append(f"left out: {len(self.left_out):,} further pieces of {sizes} triangles")
        lines += [f"repaired: {repair}" for repair in self.repairs]
        return "\n".join(lines)


@dataclass(frozen=True, eq=False)
class FlatSegment:
    """A flattened scroll segment.

    Attributes
    ----------
    segment : Segment
        The points of the surface at equal distances in the map, at the scale of the given segment.
    V : (#V, 3) float64
        Vertices of the flattened triangles, at the given positions.
    F : (#F, 3) int64
    uv : (#V, 2) float64
        The map in voxels: the point in column c and row r of `segment` is at u = c / sx, v = (R - 1 - r) / sy
        for R rows and the scale (sx, sy).
    index : (#rows, #columns) int64
        The vertex of each point of the given grid; -1 at points that are missing or left out. Coincident
        neighbours have the same vertex.
    report : SegmentReport

    Examples
    --------
    >>> from igl_linabf.scrolls import flatten_segment, synthetic_segment
    >>> flat = flatten_segment(synthetic_segment(40, 120))
    >>> flat.report.flips, flat.index.shape, flat.uv[flat.index].shape
    (0, (40, 120), (40, 120, 2))
    """

    segment: Segment
    V: FloatArray
    F: IntArray
    uv: FloatArray
    index: IntArray
    report: SegmentReport

    def __repr__(self) -> str:
        rows, columns = self.segment.points.shape[:2]
        return (
            f"<FlatSegment of {format_count(self.report.faces, 'triangle')} on {rows:,} x {columns:,} points>"
        )


def measure_pieces(pieces: Sequence[tuple[Submesh, FloatArray]]) -> dict[str, Any]:
    """Measure the distortion of the maps of all pieces; return fields of `SegmentReport`."""
    changes = [measure_change(surface, uv) for surface, uv in pieces]
    area = np.concatenate([changed.double_area for changed in changes])
    squared = np.concatenate([changed.squared_stretch for changed in changes])
    ratio = np.concatenate([changed.log_area_ratio for changed in changes])
    order = np.argsort(squared)
    sums = np.cumsum(area[order])
    return {
        "area": float(sums[-1] / 2),
        "stretch_l2": float(np.sqrt(squared @ area / sums[-1])),
        "stretch_l2_median": float(np.sqrt(squared[order[np.searchsorted(sums, sums[-1] / 2)]])),
        "stretch_linf": max(float(changed.largest_stretch.max()) for changed in changes),
        "area_error": float((1 - np.exp(-np.abs(ratio))).mean()),
        "flips": sum(int(changed.is_flipped.sum()) for changed in changes),
        "overlaps": sum(len(find_overlapping_pairs(uv, surface.F)) for surface, uv in pieces),
    }
