"""Charts cut further for their pages: those larger than a page, and those of many limbs where that pays.

Charts that fill a share f of a page need 1 / f times the texels that they use. Lowering 1 / f by one is
worth a seam of length `trade` times the side of a square of the charts' area, as lowering the L2 stretch is.
The parts keep the chart's map, scaled to their own area: so what is packed is what was tried.
"""

from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from ..._core import behind_least_cut, divisions, narrowest_turns
from ..._types import BoolArray, FloatArray, IntArray
from ...measures import Quality, overlapping_pairs_of_chart, quality_of_each
from ...surface import Submesh, complex_positions
from ..atlas import Chart, flattening_of_part
from .constants import (
    COARSE_CELLS,
    CUT_BAND,
    DIRECTIONS,
    FEW_CHARTS,
    FLOW_UNITS,
    GRID_TOLERANCE,
    HALVING_BAND,
    HULL_ROOM,
    LEAST_SIDE,
    SHORTENED_CUTS,
    SMALL_CHART,
)
from .flat_charts import OUTWARDS, FlatChart, PolygonGroups, whole_outlines
from .masks import Masks
from .packing import Wish
from .trial_pages import TrialPage

ChartPieces = list[tuple[Chart, Submesh]]  # each chart with its piece of the surface


@dataclass(frozen=True, eq=False)
class _CutCharts:
    """Charts after some cuts.

    Attributes
    ----------
    charts : list of FlatChart
    masks : list of Masks
    size : float
        The area of the page that they need, over their own.
    worth : float
        What the cuts gain, in seam length.
    """

    charts: list[FlatChart]
    masks: list[Masks]
    size: float
    worth: float


def cut_for_fill(
    done: ChartPieces, wish: Wish, trade: float, most_stretch: float
) -> tuple[ChartPieces, float]:
    """Charts cut along short seams where a fuller page is worth them.

    Also the least area of a trial's page, over that of the charts, if none is cut.

    One cut alone may not pay where two do: so a second one is tried before the best cuts so far are taken. Of
    many charts only the largest ones are looked at: the others fill gaps. A chart of which a part would have
    more than `most_stretch` alone stays whole.
    """
    if trade == 0:
        return done, np.inf
    charts, others = _largest(_flat_charts(done))
    if not charts:
        return done, np.inf
    page = TrialPage(sum(chart.area for chart in charts), wish.spacing, wish.upright)
    outlines = whole_outlines(charts)
    if not outlines:
        return done, np.inf
    masks = page.rasterize(outlines)
    state = best = _CutCharts(charts, masks, page.size(masks), 0.0)
    while (after := _best_cut(state, page, trade, best.worth, last=state is not best)) is not None:
        is_second, state = state is not best, after
        if state.worth > best.worth:
            best = state
        elif is_second:
            break
    parts = sorted([*best.charts, *others], key=lambda chart: chart.parent)
    return _without_stretched(done, _measured_parts(done, parts), parts, most_stretch), page.least_size(masks)


def cut_to_fit(done: ChartPieces, wish: Wish) -> ChartPieces:
    """Charts that fit on pages of the side that is asked for: larger ones are halved along short seams."""
    assert wish.side is not None
    most = (1 - GRID_TOLERANCE) * wish.side * wish.spacing.inner
    waiting, small = _flat_charts(done), list[FlatChart]()
    while waiting:
        chart = waiting.pop()
        z = chart.z
        turn = narrowest_turns(z, np.array([0, len(z)]))[0]
        wide, high = np.ptp((z * turn).real), np.ptp((z * turn).imag)
        along = (complex_positions(chart.centre) * (turn if wide > high else 1j * turn)).real
        longest = max(wide, high)
        if longest > most:
            along -= (along.min() + along.max()) / 2
            parts = chart.parts(_shortest_seam(along, HALVING_BAND * longest, chart.sides, chart.lengths))
        if longest <= most or len(parts) == 1:
            small.append(chart)
        else:
            waiting += parts
    return _measured_parts(done, sorted(small, key=lambda chart: (chart.parent, int(chart.piece.faces[0]))))


def _flat_charts(done: ChartPieces) -> list[FlatChart]:
    """The charts, each numbered as its own parent."""
    return [FlatChart(piece, chart.result.uv, i) for i, (chart, piece) in enumerate(done)]


def _largest(charts: list[FlatChart]) -> tuple[list[FlatChart], list[FlatChart]]:
    """The largest charts, in their order, and the others."""
    if len(charts) <= FEW_CHARTS:
        return charts, []
    size = np.array([chart.piece.measured[0].sum() for chart in charts])
    is_large = np.zeros(len(charts), dtype=bool)
    is_large[np.argsort(-size, kind="stable")[:FEW_CHARTS]] = True
    is_large &= size > SMALL_CHART * size.sum()
    return [chart for chart in charts if is_large[chart.parent]], [
        chart for chart in charts if not is_large[chart.parent]
    ]


def _measured_parts(done: ChartPieces, parts: list[FlatChart]) -> ChartPieces:
    """The charts as they are, or their parts, with their maps."""
    numbers = np.bincount([part.parent for part in parts])
    new = [part for part in parts if numbers[part.parent] > 1]
    overlaps = [
        len(overlapping_pairs_of_chart(part.piece.topology, part.uv))
        if done[part.parent][0].overlapping
        else 0
        for part in new
    ]
    table = [(part.piece, part.uv, count) for part, count in zip(new, overlaps, strict=True)]
    measured = iter(quality_of_each(table))
    return [
        (_chart_of_part(*done[part.parent], part, next(measured)), part.piece)
        if numbers[part.parent] > 1
        else done[part.parent]
        for part in parts
    ]


def _without_stretched(
    done: ChartPieces, made: ChartPieces, parts: list[FlatChart], most_stretch: float
) -> ChartPieces:
    """What is made of the charts, but for those that are left whole for the stretch of their parts."""
    whole: ChartPieces = []
    for parent, group in groupby(zip(parts, made, strict=True), key=lambda pair: pair[0].parent):
        own = [entry for _, entry in group]
        most = max(done[parent][0].quality.stretch_l2, most_stretch)
        whole += own if all(chart.quality.stretch_l2 <= most for chart, _ in own) else [done[parent]]
    return whole


def _chart_of_part(chart: Chart, piece: Submesh, part: FlatChart, quality: Quality) -> Chart:
    result = flattening_of_part(chart.result, piece, part.piece, part.uv)
    result = replace(result, message=f"{result.message}; one of the parts that its map is cut into")
    return replace(
        chart, faces=part.piece.faces, result=result, quality=quality, overlapping=quality.overlaps
    )


def _best_cut(state: _CutCharts, page: TrialPage, trade: float, best: float, last: bool) -> _CutCharts | None:
    """The charts after one more cut, of the one that seems to waste most; None if no cut could pay.

    The `last` cut must be worth more than the `best` cuts so far. Others may also lead on.

    The page that a cut leaves is found in three steps. For many lines it is estimated by the convex hulls of
    the parts that they leave. For the best lines it is packed with these parts. For the very best ones it is
    packed with the parts that the shortest seams beside them leave.
    """
    charts, size = state.charts, state.size
    areas, hulls, wide = np.array([(chart.area, chart.hull, chart.diameter) for chart in charts]).T
    k = int(np.argmax(np.maximum(HULL_ROOM * hulls, LEAST_SIDE**2 * wide**2) - areas))
    chart, unit = charts[k], float(np.sqrt(page.area))
    groups = PolygonGroups.grouped(chart, COARSE_CELLS)
    normal, at, bands = _cut_lines(groups.centre)
    hull, widest, cut = divisions(
        groups.centre, groups.sides.T, groups.lengths, groups.outer, normal, at, OUTWARDS
    )
    hull += np.delete(hulls, k).sum()
    widest = np.maximum(widest, np.delete(wide, k).max(initial=0.0))
    pages = np.maximum(np.maximum(HULL_ROOM * hull, LEAST_SIDE**2 * widest**2) / page.area, 1.0)
    seams = cut / unit
    lines = np.argsort(trade * pages + seams, kind="stable")[:DIRECTIONS]
    lines = lines[state.worth + trade * (size - 1) - seams[lines] > best]  # no page is fuller than 1
    if not len(lines):
        return None
    others = [*state.masks[:k], *state.masks[k + 1 :]]
    parts = page.rasterize_each(groups.outlines(normal[lines] @ groups.centre.T > at[lines, None]))
    lines = lines[_cheapest(page, others, parts, seams[lines], trade, SHORTENED_CUTS)[0]]
    if not len(lines):
        return None
    sides = np.stack(
        [
            _shortest_seam(chart.centre @ normal[i] - at[i], bands[i], chart.sides, chart.lengths)
            for i in lines.tolist()
        ]
    )
    seams = (sides[:, chart.sides[0]] != sides[:, chart.sides[1]]) @ chart.lengths / unit
    parts = page.rasterize_each(chart.polygons().outlines(sides))
    limit = state.worth + trade * size - best if last else np.inf
    chosen, costs = _cheapest(page, others, parts, seams, trade, 1, limit)
    if not len(chosen):
        return None
    i, cost = int(chosen[0]), float(costs[0])
    return _CutCharts(
        [*charts[:k], *chart.parts(sides[i]), *charts[k + 1 :]],
        [*state.masks[:k], *parts[i], *state.masks[k + 1 :]],
        (cost - float(seams[i])) / trade,
        state.worth + trade * size - cost,
    )


def _cut_lines(points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Normals and offsets of lines across points, and the widths of bands beside them to seek seams in.

    There are 8 directions, and in each of them lines at all eighths of the width.
    """
    offsets = np.arange(1, DIRECTIONS)
    angle = np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    normal = np.column_stack((np.cos(angle), np.sin(angle)))
    along = points @ normal.T
    low, width = along.min(axis=0), np.ptp(along, axis=0)
    at = low[:, None] + width[:, None] * offsets / DIRECTIONS
    return np.repeat(normal, len(offsets), axis=0), at.ravel(), np.repeat(CUT_BAND * width, len(offsets))


def _cheapest(
    page: TrialPage,
    others: list[Masks],
    several: list[list[Masks]],
    seams: FloatArray,
    trade: float,
    number: int,
    limit: float = np.inf,
) -> tuple[IntArray, FloatArray]:
    """The cheapest lists of parts by page and seam, the cheapest first, and their costs below the limit."""
    costs = list[tuple[float, int]]()
    for i, size in enumerate(page.sizes(others, several)):
        if len(several[i]) > 1:
            most = costs[-1][0] if len(costs) == number else limit
            cost = float(seams[i]) + trade * size((most - float(seams[i])) / trade)
            if cost < most:
                costs = sorted([*costs, (cost, i)])[:number]
    found, which = np.array(costs).reshape(-1, 2).T
    return which.astype(np.int64), found


def _shortest_seam(along: FloatArray, band: float, sides: IntArray, length: FloatArray) -> BoolArray:
    """The polygons on one side of the shortest seam in a band around a line: a minimum cut.

    `along` is the distance of each polygon from the line.
    """
    within = np.abs(along) <= band
    m = int(np.count_nonzero(within))
    node = np.where(along < 0, m, m + 1)  # what is beyond the band is one node on each side
    outside = node[~within]
    if not len(outside) or (outside == outside[0]).all():
        return along > 0
    node[within] = np.arange(m)
    ends = node[sides]
    apart = ends[0] != ends[1]
    capacity = np.maximum(np.rint(length[apart] / length.max() * FLOW_UNITS).astype(np.int64), 1)
    return np.asarray(behind_least_cut(ends[:, apart].T, capacity, m + 2, m, m + 1)[node])
