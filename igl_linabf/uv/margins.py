"""Distances between charts, and from charts to the borders of their pages."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from .._types import BoolArray, IntArray
from .uv_charts import UVCharts

# Initial search distance for the nearest chart, relative to the page size; doubled until a chart is found.
FIRST_REACH = 1e-3


@dataclass(frozen=True)
class Margins:
    """Distances in texels.

    Attributes
    ----------
    between : float
        Smallest distance between two charts on the same page of an image; infinite for a single chart.
    border : float
        Smallest distance from a chart to the border of its page; negative if a chart crosses the border.
    pages : int
        Number of pages with charts, of all images.
    """

    between: float
    border: float
    pages: int


def measure_margins(charts: UVCharts, own: BoolArray, overlap: bool, size: tuple[int, int]) -> Margins:
    """Measure the margins of the charts selected by `own`; `between` is zero if charts `overlap`."""
    page, (low, high) = charts.page_corners[own], (box[own] for box in charts.bounding_boxes)
    border = float((np.minimum(low - page, page + 1 - high) * size).min())
    sheet = charts.sheet_of_chart[own]
    between = 0.0 if overlap else _find_least_distance(_extract_outlines(charts, own, size), sheet, max(size))
    return Margins(between, border, len(np.unique(sheet)))


def _extract_outlines(
    charts: UVCharts, own: BoolArray, size: tuple[int, int]
) -> list[shapely.MultiLineString]:
    """Return the outlines of the selected charts, in texels: the sides that belong to only one triangle."""
    rows = np.flatnonzero(own[charts.chart_of_triangle])
    F, of = charts.F[rows], np.repeat(charts.chart_of_triangle[rows], 3)
    tail, head = F.ravel(), F[:, [1, 2, 0]].ravel()
    n = len(charts.uv)
    key = (of * n + np.minimum(tail, head)) * n + np.maximum(tail, head)
    _, first, count = np.unique(key, return_index=True, return_counts=True)
    once = first[count == 1]
    order = once[np.argsort(of[once], kind="stable")]
    ends = np.stack((charts.uv[tail[order]], charts.uv[head[order]]), axis=1)
    lines = shapely.linestrings(ends * np.array(size, dtype=float))
    place = np.cumsum(own) - 1
    return list(shapely.multilinestrings(lines, indices=place[of[order]]))


def _find_least_distance(outlines: list[shapely.MultiLineString], sheet: IntArray, side: int) -> float:
    """Return the smallest distance between two outlines on the same sheet."""
    if len(outlines) < 2 or len(np.unique(sheet)) == len(sheet):
        return np.inf
    tree, reach = shapely.STRtree(outlines), FIRST_REACH * side
    while True:
        one, other = tree.query(outlines, predicate="dwithin", distance=reach)
        near = (one < other) & (sheet[one] == sheet[other])
        if near.any():
            shapes = np.array(outlines, dtype=object)
            return float(shapely.distance(shapes[one[near]], shapes[other[near]]).min())
        reach *= 2
