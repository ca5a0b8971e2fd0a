"""Cut charts that are larger than a page, and charts with limbs if the fuller page is worth the seam.

The cost of a page is its area over the area of the charts. The cost of a seam is its length over the square
root of the surface's area. `trade` is the seam length that is worth a decrease of the page's cost by 1. Parts
of a chart keep the map of the chart, each scaled to its own area. Therefore the charts that are packed are
exactly the charts that were tried.
"""

from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from ..._core import evaluate_cut_lines, min_rectangle_rotations
from ..._types import BoolArray, FloatArray, IntArray
from ...measures import Quality, find_overlapping_pairs_of_chart, measure_qualities
from ...surface import Submesh, complex_positions
from ..atlas import Chart, restrict_flattening
from ..constants import HALVING_BAND
from ..features import CreasedSurface
from .constants import MIN_SHAPED_AREA
from .flat_charts import OUTWARDS, FlatChart, make_chart_outlines
from .packing import PackingRequest
from .trial_pages import TrialChart, TrialPage

MOST_TRIAL_CHARTS = 30  # maximum number of charts on a trial page
MAX_PAGE_CUTS = 8  # maximum number of cuts that are tried for a fuller page
LINE_DIRECTIONS = 8  # number of directions of the lines along which a chart may be cut
LINES_ACROSS = 7  # number of lines in each direction, evenly spaced across the chart
MAX_PACKED_LINES = 8  # pack the parts of a chart for this many of the most promising lines
MAX_SEAM_LINES = 3  # for this many of the best lines, find the shortest seam nearby
# Expected ratio of the shortest seam near a line to the total length of the edges that the line crosses.
SEAM_PER_LINE = 0.8
LINE_TOLERANCE = 1.1  # keep lines up to this multiple of the allowed cost; the seam nearby may be cheaper
BEST_FILL = 0.77  # largest share of a page that charts are expected to cover
PAGE_PER_HULL = 1.25  # expected ratio of a page's area to the area of its charts' convex hulls
PAGE_PER_DIAGONAL = 0.7  # minimum ratio of a page's side to the diagonal of a chart's bounding rectangle
LINE_GRID = 64  # grid squares along a chart; the polygons in a square count as one when lines are tried
SEAM_BAND = 0.04  # width of the search band around a line, as a share of the chart's width
MAX_CHART_SIDE = 0.98  # maximum ratio of a chart's length to the page's side; the rest allows for rounding

Charts = list[tuple[Chart, Submesh]]  # each chart, and the part of the surface it covers


@dataclass(frozen=True, eq=False)
class _CutState:
    """The charts after some cuts.

    Attributes
    ----------
    charts : list of FlatChart
    tried : list of TrialChart
        The trial chart of each chart.
    size : float
        The ratio of the smallest page's area to the total area of the charts.
    worth : float
        Net gain of the cuts: the saved page area, in units of seam length, minus the length of the cuts.
    """

    charts: list[FlatChart]
    tried: list[TrialChart]
    size: float
    worth: float


def cut_for_fill(
    creased: CreasedSurface, done: Charts, request: PackingRequest, trade: float, most_stretch: float
) -> tuple[Charts, float]:
    """Cut some charts along short seams to fill the page better; also return the page size without cuts.

    Two cuts may pay where a single cut does not. Therefore, after a cut that does not pay, one more cut is
    tried. If there are many charts, only the largest charts are considered, because small charts
    fit into gaps. The search ends when the page is as full as requested. A chart is not cut if the stretch of
    a part would exceed `most_stretch`. The size is infinite if no cut is tried.
    """
    if trade == 0:
        return done, np.inf
    charts, others = _select_largest(
        _make_flat_charts(creased, done), np.array([chart.scale == 1 for chart, _ in done])
    )
    if not charts:
        return done, np.inf
    outlines = make_chart_outlines(charts)
    if not outlines:
        return done, np.inf
    page = TrialPage.from_outlines(outlines, request.spacing, request.upright)
    tried = page.draw_charts(outlines)
    state = best = _CutState(charts, tried, page.measure_size(tried), 0.0)
    for _ in range(MAX_PAGE_CUTS):
        if best.size * request.cut_below <= 1:
            break
        after = _find_best_cut(state, page, trade, best.worth, last=state is not best)
        if after is None:
            break
        state = after
        if state.worth > best.worth:
            best = state
    parts = sorted([*best.charts, *others], key=lambda chart: chart.parent)
    return _limit_stretch(done, _replace_cut_charts(done, parts), parts, most_stretch), page.measure_size(
        tried
    )


def cut_to_fit(creased: CreasedSurface, done: Charts, request: PackingRequest) -> Charts:
    """Halve charts along short seams until they fit on pages of the requested side.

    A chart that cannot be divided is returned unchanged.
    """
    assert request.side is not None
    most = MAX_CHART_SIDE * request.side * request.spacing.inner_width
    most_long, most_short = most * max(1, request.spacing.aspect), most * min(1, request.spacing.aspect)
    waiting, small = _make_flat_charts(creased, done), list[FlatChart]()
    while waiting:
        chart = waiting.pop()
        z = chart.positions
        turn = min_rectangle_rotations(z, np.array([0, len(z)]))[0]
        wide, high = np.ptp((z * turn).real), np.ptp((z * turn).imag)
        along = (complex_positions(chart.atom_centres) * (turn if wide > high else 1j * turn)).real
        longest = max(wide, high)
        scale = done[chart.parent][0].scale
        fits = scale * longest <= most_long and scale * min(wide, high) <= most_short
        if not fits:
            along -= (along.min() + along.max()) / 2
            parts = chart.cut_into_parts(chart.divide_at_line(along, HALVING_BAND))
        if fits or len(parts) == 1:
            small.append(chart)
        else:
            waiting += parts
    return _replace_cut_charts(
        done, sorted(small, key=lambda chart: (chart.parent, int(chart.piece.faces[0])))
    )


def _make_flat_charts(creased: CreasedSurface, done: Charts) -> list[FlatChart]:
    """Convert charts to a form that can be cut between polygons."""
    return [FlatChart(creased, piece, chart.result.uv, i) for i, (chart, piece) in enumerate(done)]


def _select_largest(charts: list[FlatChart], whole: BoolArray) -> tuple[list[FlatChart], list[FlatChart]]:
    """Split the charts into the largest of those marked in `whole` and all others, in the given order."""
    is_large = whole
    if len(charts) > MOST_TRIAL_CHARTS:
        size = np.array([chart.piece.areas_and_products[0].sum() for chart in charts]) * whole
        is_large = np.zeros(len(charts), dtype=bool)
        is_large[np.argsort(-size, kind="stable")[:MOST_TRIAL_CHARTS]] = True
        is_large &= size > MIN_SHAPED_AREA * size.sum()
    return [chart for chart in charts if is_large[chart.parent]], [
        chart for chart in charts if not is_large[chart.parent]
    ]


def _replace_cut_charts(done: Charts, parts: list[FlatChart]) -> Charts:
    """Replace each chart that was cut with the charts of its parts."""
    numbers = np.bincount([part.parent for part in parts])
    new = [part for part in parts if numbers[part.parent] > 1]
    overlaps = [
        len(find_overlapping_pairs_of_chart(part.piece.topology, part.uv))
        if done[part.parent][0].overlapping
        else 0
        for part in new
    ]
    table = [(part.piece, part.uv, count) for part, count in zip(new, overlaps, strict=True)]
    measured = iter(measure_qualities(table))
    return [
        (_make_part(*done[part.parent], part, next(measured)), part.piece)
        if numbers[part.parent] > 1
        else done[part.parent]
        for part in parts
    ]


def _limit_stretch(done: Charts, made: Charts, parts: list[FlatChart], most_stretch: float) -> Charts:
    """Replace the parts of a chart by the whole chart if the stretch of any part is too large."""
    whole: Charts = []
    for parent, group in groupby(zip(parts, made, strict=True), key=lambda pair: pair[0].parent):
        own = [entry for _, entry in group]
        most = max(done[parent][0].quality.stretch_l2, most_stretch)
        whole += own if all(chart.quality.stretch_l2 <= most for chart, _ in own) else [done[parent]]
    return whole


def _make_part(chart: Chart, piece: Submesh, part: FlatChart, quality: Quality) -> Chart:
    """Return the `Chart` of a part that has been cut from `chart`."""
    result = restrict_flattening(chart.result, piece, part.piece, part.uv)
    result = replace(result, message=f"{result.message}; a part of the map that was cut")
    return replace(
        chart, faces=part.piece.faces, result=result, quality=quality, overlapping=quality.overlaps
    )


def _find_best_cut(
    state: _CutState, page: TrialPage, trade: float, best: float, last: bool
) -> _CutState | None:
    """Return the state after one more cut, or None if no cut could lead to a state worth more than `best`.

    If `last` is True, the returned state itself is worth more than `best`. Otherwise one more cut may follow.

    The chart that wastes most of the page is cut. For many lines across the chart, the size of the page is
    predicted from the convex hulls of the parts. For the best of these lines, the parts are packed. Near the
    best lines after packing, the shortest seams are found, and their parts are packed.
    """
    charts, size = state.charts, state.size
    areas, hulls, diagonals = np.array(
        [(chart.map_area, chart.hull_area, chart.bounding_diagonal) for chart in charts]
    ).T
    k = int(np.argmax(_estimate_page_area(hulls, diagonals) - areas))
    chart, unit = charts[k], float(np.sqrt(page.area))
    groups = chart.group_by_square(LINE_GRID)
    normal, at = _generate_lines(groups.centre)
    # keep one of the lines that divide the polygons in the same way
    _, distinct = np.unique(normal @ groups.centre.T > at[:, None], axis=0, return_index=True)
    normal, at = normal[np.sort(distinct)], at[np.sort(distinct)]
    hull, diagonal, crossed = evaluate_cut_lines(
        groups.centre,
        groups.groups_beside_edges.T,
        groups.edge_prices,
        groups.is_at_boundary,
        normal,
        at,
        OUTWARDS,
    )
    hull += np.delete(hulls, k).sum()
    diagonal = np.maximum(diagonal, np.delete(diagonals, k).max(initial=0.0))
    pages = np.maximum(_estimate_page_area(hull, diagonal) / page.area, 1.0)
    seams = SEAM_PER_LINE * crossed / unit
    lines = np.argsort(trade * pages + crossed / unit, kind="stable")[:MAX_PACKED_LINES]
    lines = lines[state.worth + trade * (size - 1 / BEST_FILL) - seams[lines] > best]
    if not len(lines):
        return None
    most = state.worth + trade * size - best if last else np.inf
    others = [*state.tried[:k], *state.tried[k + 1 :]]
    parts = page.draw_lists_of_charts(
        groups.make_outlines_of_parts(normal[lines] @ groups.centre.T > at[lines, None])
    )
    hoped = LINE_TOLERANCE * most
    chosen, _ = _select_cheapest(page, others, parts, seams[lines], trade, MAX_SEAM_LINES, hoped)
    if not len(chosen):
        return None
    sides = np.stack(
        [
            chart.divide_at_line(chart.atom_centres @ normal[i] - at[i], SEAM_BAND)
            for i in lines[chosen].tolist()
        ]
    )
    seams = (
        (sides[:, chart.atoms_beside_edges[0]] != sides[:, chart.atoms_beside_edges[1]])
        @ chart.edge_prices
        / unit
    )
    parts = page.draw_lists_of_charts(chart.make_groups_of_one().make_outlines_of_parts(sides))
    chosen, costs = _select_cheapest(page, others, parts, seams, trade, 1, most)
    if not len(chosen):
        return None
    i, cost = int(chosen[0]), float(costs[0])
    return _CutState(
        [*charts[:k], *chart.cut_into_parts(sides[i]), *charts[k + 1 :]],
        [*state.tried[:k], *parts[i], *state.tried[k + 1 :]],
        (cost - float(seams[i])) / trade,
        state.worth + trade * size - cost,
    )


def _estimate_page_area(hulls: FloatArray, diagonals: FloatArray) -> FloatArray:
    """Estimate the area of a page from its charts' convex hull areas and diagonals."""
    square = PAGE_PER_DIAGONAL**2 * diagonals**2
    return np.asarray(np.maximum(PAGE_PER_HULL * hulls, square))


def _generate_lines(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the normals and offsets of evenly spaced lines through a set of points."""
    directions, number = LINE_DIRECTIONS, LINES_ACROSS
    angle = np.pi * np.arange(directions) / directions
    normal = np.column_stack((np.cos(angle), np.sin(angle)))
    along = points @ normal.T
    low, width = along.min(axis=0), np.ptp(along, axis=0)
    at = low[:, None] + width[:, None] * (np.arange(number) + 1) / (number + 1)
    return np.repeat(normal, number, axis=0), at.ravel()


def _select_cheapest(
    page: TrialPage,
    others: list[TrialChart],
    several: list[list[TrialChart]],
    seams: FloatArray,
    trade: float,
    number: int,
    limit: float,
) -> tuple[IntArray, FloatArray]:
    """Return the `number` cheapest of several alternative lists of parts, and their costs, ascending.

    The cost, below `limit`, is that of the seam and of a page with the parts and the charts `others`.
    """
    costs = list[tuple[float, int]]()
    for i, size in enumerate(page.iterate_size_functions(others, several)):
        if len(several[i]) > 1:
            most = costs[-1][0] if len(costs) == number else limit
            cost = float(seams[i]) + trade * size((most - float(seams[i])) / trade)
            if cost < most:
                costs = sorted([*costs, (cost, i)])[:number]
    found, which = np.array(costs).reshape(-1, 2).T
    return which.astype(np.int64), found
