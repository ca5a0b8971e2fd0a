"""Distances between charts, and to the border of their pages."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from .._types import BoolArray, FloatArray, IntArray
from .constants import FIRST_REACH
from .uv_charts import UVCharts


@dataclass(frozen=True)
class Margins:
    """In texels.

    Attributes
    ----------
    between : float
        The least distance of two charts on one page; infinite if there are none.
    border : float
        The least distance of a chart to its page's border; negative if one reaches beyond.
    pages : int
        With charts on them.
    """

    between: float
    border: float
    pages: int


def margins_of(charts: UVCharts, own: BoolArray, overlap: bool, size: tuple[int, int]) -> Margins:
    """Of some charts, `own` of all, on pages of this size; they touch where some `overlap`."""
    rows = np.flatnonzero(own[charts.chart])
    corners, of = charts.uv[charts.F[rows]], charts.chart[rows]
    low, high = (
        np.stack([_of_charts(f, corners[..., k], of, len(own)) for k in (0, 1)], axis=1)[own]
        for f in (np.minimum, np.maximum)
    )
    page = np.floor((low + high) / 2)
    border = float((np.minimum(low - page, page + 1 - high) * size).min())
    number = np.unique(page, axis=0, return_inverse=True)[1].ravel()
    between = 0.0 if overlap else _least_distance(_outlines(charts, own, size), number, max(size))
    return Margins(between, border, int(number.max()) + 1)


def _of_charts(function: np.ufunc, values: FloatArray, of: IntArray, number: int) -> FloatArray:
    """The extreme value at the corners (#f, 3) of each chart."""
    made = np.full(number, np.inf if function is np.minimum else -np.inf)
    function.at(made, np.repeat(of, 3), values.ravel())
    return made


def _outlines(charts: UVCharts, own: BoolArray, size: tuple[int, int]) -> list[shapely.MultiLineString]:
    """The outlines of these charts in texels: the sides that only one of their triangles has."""
    rows = np.flatnonzero(own[charts.chart])
    F, of = charts.F[rows], np.repeat(charts.chart[rows], 3)
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


def _least_distance(outlines: list[shapely.MultiLineString], page: IntArray, side: int) -> float:
    """The least distance of two on one page, found within a reach that is doubled until there are some."""
    if len(outlines) < 2 or len(np.unique(page)) == len(page):
        return np.inf
    tree, reach = shapely.STRtree(outlines), FIRST_REACH * side
    while True:
        one, other = tree.query(outlines, predicate="dwithin", distance=reach)
        near = (one < other) & (page[one] == page[other])
        if near.any():
            shapes = np.array(outlines, dtype=object)
            return float(shapely.distance(shapes[one[near]], shapes[other[near]]).min())
        reach *= 2
