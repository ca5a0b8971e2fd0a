"""Charts cut further for their pages: those larger than a page, and those of many limbs where that pays.

Charts that cover a share f of a page need 1 / f as many texels as they use. `trade` is the seam length that
lowering this by one is worth, as it is for the L2 stretch. The parts keep the chart's map, each at the scale
of its own area: so what is packed is what was tried.
"""

from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from ..._core import behind_least_cut, divisions, narrowest_turns
from ..._types import BoolArray, FloatArray, IntArray
from ...measures import Quality, overlapping_pairs_of_chart, quality_of_each
from ...surface import Submesh, complex_positions
from ..atlas import Chart, flattening_of_part
from .flat_charts import OUTWARDS, Cells, Flat, whole_outlines
from .packing import Wish
from .trial_pages import Drawn, TrialPage

MOST_TRIAL_CHARTS, SMALL = 30, 1 / 400  # that are tried on a page; of more, those with this share of the area
MOST_CUTS, MOST_IDLE = 8, 1  # of all cuts, and of those in a row that do not pay yet
DIRECTIONS, OFFSETS = 8, 7  # of the lines that are tried
TRIED, SOUGHT = 8, 3  # of them are packed, and of these shifted to the shortest seam
SHORTER = 0.8  # of the edges that a line crosses is how long the seam beside it is expected to be
HOPE = 1.1  # times the cost that a seam may have is what the line beside it may have
FULL = 0.77  # of a page, which charts do not cover more of
LOOSE = 1.25  # of the area of their convex hulls is what charts take on a page
SHORTEST = 0.7  # of a chart's diameter is the side of a page that has room for it
GRID = 64  # squares along a chart, of which connected cells are taken as one to look for lines
BAND = 0.04  # of the chart's width: within it the shortest seam is sought
MIDDLE = 0.15  # the same, where a chart is halved that is larger than a page
FITS = 0.98  # of a page's side is what cells of a grid leave to a chart
UNITS = 1 << 20  # of length: flows are integers

Charts = list[tuple[Chart, Submesh]]  # each with its piece of the surface


@dataclass(frozen=True, eq=False)
class _State:
    """Charts after some cuts.

    Attributes
    ----------
    charts : list of Flat
    drawn : list of Drawn
    size : float
        The area of the page that they take, over their own.
    worth : float
        What the cuts gain.
    """

    charts: list[Flat]
    drawn: list[Drawn]
    size: float
    worth: float


def cut_for_fill(done: Charts, wish: Wish, trade: float, most_stretch: float) -> tuple[Charts, float]:
    """The charts, some of them cut along short seams; what a trial's page is over their area if none is.

    One cut alone may not pay where two do: so some more are tried before the best ones so far are taken.
    Of many charts only the largest ones are looked at: the others go into gaps. A chart of which a part would
    have more than `most_stretch` alone stays whole.
    """
    if trade == 0:
        return done, np.inf
    charts, others = _largest(_flat(done))
    if not charts:
        return done, np.inf
    page = TrialPage(sum(chart.area for chart in charts), wish.spacing, wish.upright)
    outlines = whole_outlines(charts)
    if not outlines:
        return done, np.inf  # one has no area to be packed
    drawn = page.drawn(outlines)
    state = _State(charts, drawn, page.size(drawn), 0.0)
    best, idle = state, 0
    for _ in range(MOST_CUTS):
        after = _best_cut(state, page, trade, best.worth, idle == MOST_IDLE)
        if after is None:
            break
        state, idle = after, idle + 1
        if state.worth > best.worth:
            best, idle = state, 0
        if idle > MOST_IDLE:
            break
    parts = sorted([*best.charts, *others], key=lambda chart: chart.parent)
    return _within(done, _parted(done, parts), parts, most_stretch), page.least_size(drawn)


def cut_to_fit(done: Charts, wish: Wish) -> Charts:
    """Charts that fit on pages of the side that is asked for: larger ones are halved along short seams."""
    assert wish.side is not None
    most = FITS * wish.side * wish.spacing.inner
    waiting, small = _flat(done), list[Flat]()
    while waiting:
        chart = waiting.pop()
        z = chart.z
        turn = narrowest_turns(z, np.array([0, len(z)]))[0]
        wide, high = np.ptp((z * turn).real), np.ptp((z * turn).imag)
        along = (complex_positions(chart.centre) * (turn if wide > high else 1j * turn)).real
        longest = max(wide, high)
        if longest > most:
            along -= (along.min() + along.max()) / 2
            parts = chart.parts(_shortest_between(along, MIDDLE * longest, chart.sides, chart.lengths))
        if longest <= most or len(parts) == 1:
            small.append(chart)
        else:
            waiting += parts
    return _parted(done, sorted(small, key=lambda chart: (chart.parent, int(chart.piece.faces[0]))))


def _flat(done: Charts) -> list[Flat]:
    return [Flat(piece, chart.result.uv, i) for i, (chart, piece) in enumerate(done)]


def _largest(charts: list[Flat]) -> tuple[list[Flat], list[Flat]]:
    """The largest charts, in their order, and the others."""
    if len(charts) <= MOST_TRIAL_CHARTS:
        return charts, []
    size = np.array([chart.piece.measured[0].sum() for chart in charts])
    is_large = np.zeros(len(charts), dtype=bool)
    is_large[np.argsort(-size, kind="stable")[:MOST_TRIAL_CHARTS]] = True
    is_large &= size > SMALL * size.sum()
    return [chart for chart in charts if is_large[chart.parent]], [
        chart for chart in charts if not is_large[chart.parent]
    ]


def _parted(done: Charts, parts: list[Flat]) -> Charts:
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


def _within(done: Charts, made: Charts, parts: list[Flat], most_stretch: float) -> Charts:
    """What is made of the charts, but for those that are left whole for the stretch of their parts."""
    whole: Charts = []
    for parent, group in groupby(zip(parts, made, strict=True), key=lambda pair: pair[0].parent):
        own = [entry for _, entry in group]
        most = max(done[parent][0].quality.stretch_l2, most_stretch)
        whole += own if all(chart.quality.stretch_l2 <= most for chart, _ in own) else [done[parent]]
    return whole


def _part_of(chart: Chart, piece: Submesh, part: Flat, quality: Quality) -> Chart:
    result = flattening_of_part(chart.result, piece, part.piece, part.uv)
    result = replace(result, message=f"{result.message}; one of the parts that its map is cut into")
    return replace(
        chart, faces=part.piece.faces, result=result, quality=quality, overlapping=quality.overlaps
    )


def _best_cut(state: _State, page: TrialPage, trade: float, best: float, last: bool) -> _State | None:
    """The charts after one more cut; None if none could be worth more than the best so far.

    The `last` one must be worth more itself; others may also lead on.

    First it is asked how far out the parts reach that many lines leave, then what page those of the best
    lines take, and last the same for the shortest seams beside the very best ones.
    """
    charts, size = state.charts, state.size
    areas, hulls, wide = np.array([(chart.area, chart.hull, chart.diameter) for chart in charts]).T
    k = int(np.argmax(np.maximum(LOOSE * hulls, SHORTEST**2 * wide**2) - areas))
    chart, unit = charts[k], float(np.sqrt(page.area))
    cells = Cells.grouped(chart, GRID)
    normal, at, bands = _lines_across(cells.centre)
    hull, widest, cut = divisions(
        cells.centre, cells.sides.T, cells.lengths, cells.outer, normal, at, OUTWARDS
    )
    hull += np.delete(hulls, k).sum()
    widest = np.maximum(widest, np.delete(wide, k).max(initial=0.0))
    pages = np.maximum(np.maximum(LOOSE * hull, SHORTEST**2 * widest**2) / page.area, 1.0)
    seams = SHORTER * cut / unit
    lines = np.argsort(trade * pages + cut / unit, kind="stable")[:TRIED]
    lines = lines[state.worth + trade * (size - 1 / FULL) - seams[lines] > best]
    if not len(lines):
        return None
    most = state.worth + trade * size - best if last else np.inf
    others = [*state.drawn[:k], *state.drawn[k + 1 :]]
    parted = cells.outlines(normal[lines] @ cells.centre.T > at[lines, None])
    parts, rough = page.each_drawn(parted), HOPE * most
    sought = lines[_cheapest(page, others, parts, seams[lines], trade, SOUGHT, rough)[0]]
    if not len(sought):
        return None
    sides = np.stack(
        [
            _shortest_between(chart.centre @ normal[i] - at[i], bands[i], chart.sides, chart.lengths)
            for i in sought.tolist()
        ]
    )
    seams = (sides[:, chart.sides[0]] != sides[:, chart.sides[1]]) @ chart.lengths / unit
    parts = page.each_drawn(chart.cells().outlines(sides))
    chosen, costs = _cheapest(page, others, parts, seams, trade, 1, most)
    if not len(chosen):
        return None
    i, cost = int(chosen[0]), float(costs[0])
    return _State(
        [*charts[:k], *chart.parts(sides[i]), *charts[k + 1 :]],
        [*state.drawn[:k], *parts[i], *state.drawn[k + 1 :]],
        (cost - float(seams[i])) / trade,
        state.worth + trade * size - cost,
    )


def _lines_across(points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Normals and offsets of lines across points, in several directions; bands in which seams are sought."""
    angle = np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    normal = np.column_stack((np.cos(angle), np.sin(angle)))
    along = points @ normal.T
    low, width = along.min(axis=0), np.ptp(along, axis=0)
    at = low[:, None] + width[:, None] * (np.arange(OFFSETS) + 1) / (OFFSETS + 1)
    return np.repeat(normal, OFFSETS, axis=0), at.ravel(), np.repeat(BAND * width, OFFSETS)


def _cheapest(
    page: TrialPage,
    others: list[Drawn],
    several: list[list[Drawn]],
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


def _shortest_between(along: FloatArray, band: float, sides: IntArray, length: FloatArray) -> BoolArray:
    """Cells on one side of the shortest seam in a band around a line: a minimum cut."""
    within = np.abs(along) <= band
    m = int(np.count_nonzero(within))
    node = np.where(along < 0, m, m + 1)  # what is beyond the band is one node on each side
    outside = node[~within]
    if not len(outside) or (outside == outside[0]).all():
        return along > 0
    node[within] = np.arange(m)
    ends = node[sides]
    apart = ends[0] != ends[1]
    capacity = np.maximum(np.rint(length[apart] / length.max() * UNITS).astype(np.int64), 1)
    return np.asarray(behind_least_cut(ends[:, apart].T, capacity, m + 2, m, m + 1)[node])
