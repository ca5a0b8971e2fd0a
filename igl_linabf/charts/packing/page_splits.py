"""Charts cut further for their pages: those larger than a page, and those with limbs where that pays.

A page costs its area over that of the charts, and a seam its length over the square root of the surface's
area. `trade` is the seam length that lowering the page's cost by 1 is worth, as it is for the L2 stretch. The
parts keep the chart's map, each at the scale of its own area: so what is packed is what was tried.
"""

from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from ..._core import divisions, narrowest_turns
from ..._types import BoolArray, FloatArray, IntArray
from ...measures import Quality, overlapping_pairs_of_chart, quality_of_each
from ...surface import Submesh, complex_positions
from ..atlas import Chart, flattening_of_part
from ..constants import HALVING_BAND
from . import constants
from .flat_charts import OUTWARDS, FlatChart, whole_outlines
from .packing import Wish
from .trial_pages import TrialChart, TrialPage

Charts = list[tuple[Chart, Submesh]]  # each with its piece of the surface


@dataclass(frozen=True, eq=False)
class _State:
    """Charts after some cuts.

    Attributes
    ----------
    charts : list of FlatChart
    tried : list of TrialChart
        The same on the trial page.
    size : float
        The area of the page that they take, over their own.
    worth : float
        What the cuts save of the page, as seam length, less their own.
    """

    charts: list[FlatChart]
    tried: list[TrialChart]
    size: float
    worth: float


def cut_for_fill(done: Charts, wish: Wish, trade: float, most_stretch: float) -> tuple[Charts, float]:
    """The charts, some of them cut along short seams; and the size of a trial page with all of them whole.

    One cut alone may not pay where two do, so one more is tried before the best ones so far are taken. Of
    many charts only the largest ones are looked at, since the others go into gaps. A chart stays whole if a
    part would have a stretch of more than `most_stretch`. The size is infinite if no cut is tried.
    """
    if trade == 0:
        return done, np.inf
    charts, others = _largest(_flat(done), np.array([chart.scale == 1 for chart, _ in done]))
    if not charts:
        return done, np.inf
    page = TrialPage(sum(chart.area for chart in charts), wish.spacing, wish.upright)
    outlines = whole_outlines(charts)
    if not outlines:
        return done, np.inf
    tried = page.charts(outlines)
    state = best = _State(charts, tried, page.size(tried), 0.0)
    for _ in range(constants.MAX_PAGE_CUTS):
        after = _best_cut(state, page, trade, best.worth, last=state is not best)
        if after is None:
            break
        state = after
        if state.worth > best.worth:
            best = state
    parts = sorted([*best.charts, *others], key=lambda chart: chart.parent)
    return _within(done, _parted(done, parts), parts, most_stretch), page.least_size(tried)


def cut_to_fit(done: Charts, wish: Wish) -> Charts:
    """Charts that fit on pages of the side that is asked for: larger ones are halved along short seams.

    A chart that no line parts stays as it is.
    """
    assert wish.side is not None
    most = constants.MAX_CHART_SIDE * wish.side * wish.spacing.inner
    most_long, most_short = most * max(1, wish.spacing.aspect), most * min(1, wish.spacing.aspect)
    waiting, small = _flat(done), list[FlatChart]()
    while waiting:
        chart = waiting.pop()
        z = chart.z
        turn = narrowest_turns(z, np.array([0, len(z)]))[0]
        wide, high = np.ptp((z * turn).real), np.ptp((z * turn).imag)
        along = (complex_positions(chart.centre) * (turn if wide > high else 1j * turn)).real
        longest = max(wide, high)
        scale = done[chart.parent][0].scale
        fits = scale * longest <= most_long and scale * min(wide, high) <= most_short
        if not fits:
            along -= (along.min() + along.max()) / 2
            parts = chart.parts(chart.divided_near(along, HALVING_BAND))
        if fits or len(parts) == 1:
            small.append(chart)
        else:
            waiting += parts
    return _parted(done, sorted(small, key=lambda chart: (chart.parent, int(chart.piece.faces[0]))))


def _flat(done: Charts) -> list[FlatChart]:
    return [FlatChart(piece, chart.result.uv, i) for i, (chart, piece) in enumerate(done)]


def _largest(charts: list[FlatChart], whole: BoolArray) -> tuple[list[FlatChart], list[FlatChart]]:
    """The largest charts of `whole` scale, in their order, and the others."""
    is_large = whole
    if len(charts) > constants.MOST_TRIAL_CHARTS:
        size = np.array([chart.piece.measured[0].sum() for chart in charts]) * whole
        is_large = np.zeros(len(charts), dtype=bool)
        is_large[np.argsort(-size, kind="stable")[: constants.MOST_TRIAL_CHARTS]] = True
        is_large &= size > constants.MIN_SHAPED_AREA * size.sum()
    return [chart for chart in charts if is_large[chart.parent]], [
        chart for chart in charts if not is_large[chart.parent]
    ]


def _parted(done: Charts, parts: list[FlatChart]) -> Charts:
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
        (_part_of(*done[part.parent], part, next(measured)), part.piece)
        if numbers[part.parent] > 1
        else done[part.parent]
        for part in parts
    ]


def _within(done: Charts, made: Charts, parts: list[FlatChart], most_stretch: float) -> Charts:
    """The parts that are made of the charts; those charts whole of which a part has too much stretch."""
    whole: Charts = []
    for parent, group in groupby(zip(parts, made, strict=True), key=lambda pair: pair[0].parent):
        own = [entry for _, entry in group]
        most = max(done[parent][0].quality.stretch_l2, most_stretch)
        whole += own if all(chart.quality.stretch_l2 <= most for chart, _ in own) else [done[parent]]
    return whole


def _part_of(chart: Chart, piece: Submesh, part: FlatChart, quality: Quality) -> Chart:
    result = flattening_of_part(chart.result, piece, part.piece, part.uv)
    result = replace(result, message=f"{result.message}; one of the parts that its map is cut into")
    return replace(
        chart, faces=part.piece.faces, result=result, quality=quality, overlapping=quality.overlaps
    )


def _best_cut(state: _State, page: TrialPage, trade: float, best: float, last: bool) -> _State | None:
    """The charts after one more cut; None if none could be worth more than the best ones so far.

    The `last` cut must be worth more itself; others may also lead on.

    The chart that wastes most of the page is cut. For many lines across it, the convex hulls of the parts
    tell what page they may take. The parts of the best lines are packed; and last those of the shortest
    seams beside the very best lines.
    """
    charts, size = state.charts, state.size
    areas, hulls, diagonals = np.array([(chart.area, chart.hull, chart.diagonal) for chart in charts]).T
    k = int(np.argmax(_expected_page(hulls, diagonals) - areas))
    chart, unit = charts[k], float(np.sqrt(page.area))
    groups = chart.groups(constants.LINE_GRID)
    normal, at = _lines_across(groups.centre)
    hull, diagonal, crossed = divisions(
        groups.centre, groups.sides.T, groups.lengths, groups.outer, normal, at, OUTWARDS
    )
    hull += np.delete(hulls, k).sum()
    diagonal = np.maximum(diagonal, np.delete(diagonals, k).max(initial=0.0))
    pages = np.maximum(_expected_page(hull, diagonal) / page.area, 1.0)
    seams = constants.SEAM_PER_LINE * crossed / unit
    lines = np.argsort(trade * pages + crossed / unit, kind="stable")[: constants.MAX_PACKED_LINES]
    lines = lines[state.worth + trade * (size - 1 / constants.BEST_FILL) - seams[lines] > best]
    if not len(lines):
        return None
    most = state.worth + trade * size - best if last else np.inf
    others = [*state.tried[:k], *state.tried[k + 1 :]]
    parts = page.charts_of_each(groups.outlines(normal[lines] @ groups.centre.T > at[lines, None]))
    hoped = constants.LINE_TOLERANCE * most
    chosen, _ = _cheapest(page, others, parts, seams[lines], trade, constants.MAX_SEAM_LINES, hoped)
    if not len(chosen):
        return None
    sides = np.stack(
        [
            chart.divided_near(chart.centre @ normal[i] - at[i], constants.SEAM_BAND)
            for i in lines[chosen].tolist()
        ]
    )
    seams = (sides[:, chart.sides[0]] != sides[:, chart.sides[1]]) @ chart.lengths / unit
    parts = page.charts_of_each(chart.polygons().outlines(sides))
    chosen, costs = _cheapest(page, others, parts, seams, trade, 1, most)
    if not len(chosen):
        return None
    i, cost = int(chosen[0]), float(costs[0])
    return _State(
        [*charts[:k], *chart.parts(sides[i]), *charts[k + 1 :]],
        [*state.tried[:k], *parts[i], *state.tried[k + 1 :]],
        (cost - float(seams[i])) / trade,
        state.worth + trade * size - cost,
    )


def _expected_page(hulls: FloatArray, diagonals: FloatArray) -> FloatArray:
    """The area of a page that has room for convex hulls of these areas, and for rectangles so long."""
    square = constants.PAGE_PER_DIAGONAL**2 * diagonals**2
    return np.asarray(np.maximum(constants.PAGE_PER_HULL * hulls, square))


def _lines_across(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Normals and offsets of lines across points."""
    directions, number = constants.LINE_DIRECTIONS, constants.LINES_ACROSS
    angle = np.pi * np.arange(directions) / directions
    normal = np.column_stack((np.cos(angle), np.sin(angle)))
    along = points @ normal.T
    low, width = along.min(axis=0), np.ptp(along, axis=0)
    at = low[:, None] + width[:, None] * (np.arange(number) + 1) / (number + 1)
    return np.repeat(normal, number, axis=0), at.ravel()


def _cheapest(
    page: TrialPage,
    others: list[TrialChart],
    several: list[list[TrialChart]],
    seams: FloatArray,
    trade: float,
    number: int,
    limit: float,
) -> tuple[IntArray, FloatArray]:
    """Which lists of parts, beside others, cost least by page and seam, the first one least; the costs."""
    costs = list[tuple[float, int]]()
    for i, size in enumerate(page.sizes(others, several)):
        if len(several[i]) > 1:
            most = costs[-1][0] if len(costs) == number else limit
            cost = float(seams[i]) + trade * size((most - float(seams[i])) / trade)
            if cost < most:
                costs = sorted([*costs, (cost, i)])[:number]
    found, which = np.array(costs).reshape(-1, 2).T
    return which.astype(np.int64), found
