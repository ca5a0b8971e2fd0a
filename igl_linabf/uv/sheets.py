"""Figures of each sheet: a page of one image."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from .._types import BoolArray, IntArray
from ..measures import format_pair_count
from .uv_charts import UVCharts, get_first_of_each_label


@dataclass(frozen=True)
class Sheet:
    """The figures of one page of one image.

    Attributes
    ----------
    image : int or str
        The label of the image.
    page : (int, int)
        Lower left corner of the page, which is the UDIM tile 1001 + column + 10 row.
    charts, stacked, flips, overlaps : int
        As in `UVCheck`. An overlap counts on the sheet of the first of its two charts.
    fill : float
        Share of the page that is covered by charts. Stacked charts count once.
    texel_density : float
        Mean number of texels per unit of length of V.
    """

    image: int | str
    page: tuple[int, int]
    charts: int
    stacked: int
    flips: int
    overlaps: int
    fill: float
    texel_density: float


def measure_sheets(
    charts: UVCharts, own: BoolArray, pairs: IntArray, aspect: float, width: int
) -> Iterator[Sheet]:
    """Yield the figures of each sheet.

    `own` are the first charts of all stacks, and `pairs` the triangles that overlap by accident. A page is
    `width` texels wide, and `aspect` times as high.
    """
    sheet, number = charts.sheet_of_chart, int(charts.sheet_of_chart.max()) + 1
    of, face = sheet[charts.chart_of_triangle], charts.split.face[charts.rows]
    flips = np.unique(np.column_stack((of, face))[charts.is_flipped], axis=0)[:, 0]
    flat = np.abs(charts.double_area) / 2
    covered, area_in_map, area = (
        np.bincount(of, x, number)
        for x in (flat * own[charts.chart_of_triangle], flat * aspect, charts.area_in_space)
    )
    counts = [
        np.bincount(rows, minlength=number).tolist() for rows in (sheet, sheet[~own], flips, of[pairs[:, 0]])
    ]
    chart = get_first_of_each_label(np.arange(charts.n_charts), sheet).tolist()
    for i, (first, n_charts, n_stacked, n_flips, n_overlaps) in enumerate(zip(chart, *counts, strict=True)):
        left, low = charts.page_corners[first].astype(int).tolist()
        density = float(np.sqrt(area_in_map[i] / area[i]) * width)
        image = charts.images[charts.image_of_chart[first]].item()
        fill = float(covered[i])
        yield Sheet(image, (left, low), n_charts, n_stacked, n_flips, n_overlaps, fill, density)


def list_sheets(sheets: Iterable[Sheet]) -> list[tuple[str, ...]]:
    """Return the rows of a table of sheets."""
    rows: list[tuple[str, ...]] = [
        ("image", "page", "charts", "stacked", "flips", "overlaps", "filled", "texels per unit of length")
    ]
    for one in sheets:
        counts = (f"{one.charts:,}", f"{one.stacked:,}", f"{one.flips:,}", format_pair_count(one.overlaps))
        place = (str(one.image), "{}, {}".format(*one.page))
        rows.append((*place, *counts, f"{one.fill:.4g}", f"{one.texel_density:.4g}"))
    return rows
