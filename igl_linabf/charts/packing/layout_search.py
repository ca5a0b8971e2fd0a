"""Where charts go on pages, and how they are turned: the search for the layout of the largest charts.

The largest chart comes first, each to where the square that holds all of them grows least, and there to the
corner. Layouts of several orders are found on a coarse grid, with charts turned to many directions. The best
ones are found again on a fine grid, with the turns that they have. If there is time and charts are few, moves
are tried before: a chart at another place of the order, or held in one direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..._core import on_shelves
from ..._types import ComplexArray, FloatArray, IntArray
from .outlines import NONE_KNOWN, Outline, Row, masks_of
from .spacing import Spacing

FEW, SOME = 24, 40  # charts up to which as many turns and layouts are tried as for few, or for some
MOST_SHAPED, LARGEST = 100, 60  # charts that are placed by their shape; of more, how many of the largest ones
SMALL = 1 / 400  # of the area of all: of more charts than that, those below are placed as rectangles
RECTANGULAR = 0.9  # of the rectangle around it: a chart with this area is one
COARSE, MIDDLE, FINE, FIXED = 64, 96, 448, 384  # cells along a page's side
DIRECTIONS = 32  # of charts that are moved
MOST_MOVES, MOVED = 100, 400  # of them, and of charts that are placed again for them
ROOM = 1.3  # side of the page that a layout grows on, of the one it is meant for
SHARE = 0.62  # of a page that charts are expected to cover
HALVINGS = 7  # of the interval of sides
MOST_SIDE = 1e3  # of the least side: beyond it, gaps leave no room
MOST_TRIALS = 8  # on the fine grid
CLOSE = 1.02  # times the best coarse side, up to which a layout is tried on the fine grid
SLACK = 0.002  # share by which the page is larger at the next one, doubled each time

Turns = Sequence[ComplexArray] | ComplexArray  # of each chart


@dataclass(frozen=True, eq=False)
class Layout:
    """Places of charts, in units of their own.

    Attributes
    ----------
    turn : (#C,) complex128
    page : (#C,) int64
    corner : (#C,) complex128
        Where the turned chart's point 0 comes to, from the page's lower left corner.
    side : float
        Of the page; gaps between charts are shares of it.
    """

    turn: ComplexArray
    page: IntArray
    corner: ComplexArray
    side: float


@dataclass(frozen=True, eq=False)
class Charts:
    """Charts that are to be laid out, their lower left corners at 0, turned to their narrowest rectangles.

    Attributes
    ----------
    outlines : list of Outline
    sizes : (#C, 2) float64
        Widths and heights.
    upright : bool
        Turn them by quarter turns only.
    fixed : bool
        Do not turn them.
    """

    outlines: Sequence[Outline]
    sizes: FloatArray
    upright: bool = False
    fixed: bool = False

    @property
    def areas(self) -> FloatArray:
        """(#C,) float64."""
        return np.array([outline.area for outline in self.outlines], dtype=np.float64)

    @property
    def least_side(self) -> float:
        """Smaller pages cannot hold the longest chart: nothing in a square is longer than its diagonal."""
        return float(self.sizes.max() / np.sqrt(2))

    def turns(self, directions: int) -> list[ComplexArray]:
        """Of each chart by equal steps, as many as are wanted or allowed; short rectangles stay upright."""
        areas = self.areas
        if self.fixed:
            return [np.ones(1, dtype=np.complex128)] * len(areas)
        return turns_of(areas, self.sizes, float(areas.sum()), directions, self.upright)

    def shaped(self) -> IntArray:
        """Those that are placed by their shape."""
        areas: FloatArray = self.areas
        if len(areas) <= MOST_SHAPED:
            return np.arange(len(areas))
        largest = np.argsort(-areas, kind="stable")[:LARGEST]
        return np.asarray(largest[areas[largest] > SMALL * areas.sum()])


def turns_of(
    areas: FloatArray, sizes: FloatArray, total: float, directions: int, upright: bool
) -> list[ComplexArray]:
    """As `Charts.turns`, of charts that are a part of a layout of this area in total.

    Opposite ones stand side by side, so that they are drawn once.
    """
    few = min(directions, 4)
    rectangular = areas > RECTANGULAR * sizes.prod(axis=1)
    rectangular &= sizes.max(axis=1) < np.sqrt(total) / 2  # or along a diagonal
    steps = np.where(upright | rectangular, few, directions)
    halves = {n: np.exp(2j * np.pi * np.arange(n // 2) / n) for n in (few, directions)}
    by = {n: np.column_stack((half, -half)).ravel() for n, half in halves.items()}
    return [by[n] for n in steps.tolist()]


def fixed_layout(charts: Charts, side: float, spacing: Spacing, pages: int | None) -> Layout | None:
    """Charts on pages of this side, as many as it takes or is allowed; None if that does not do."""
    if charts.least_side > side * spacing.inner:
        return None
    return _on_pages(charts, charts.shaped(), charts.turns(8), side, spacing, pages)


def largest_layout(charts: Charts, spacing: Spacing, pages: int, thorough: bool = False) -> Layout | None:
    """The layout whose pages have the smallest side, so that charts have the largest share of it.

    Where it is to be `thorough`, a few charts take up to half a second more.
    """
    shaped, n = charts.shaped(), len(charts.outlines)
    if n * spacing.gap**2 > pages * (spacing.inner + spacing.gap) ** 2:
        return None
    turns = np.ones((n, 1), dtype=np.complex128)
    if n == 1:
        side = float(charts.sizes.max()) / spacing.inner
        return Layout(turns[0], np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.complex128), side)
    if len(shaped):
        found = _coarse(charts, shaped, spacing)
        if pages == 1 and len(shaped) == n:
            close = sum(entry.reached <= CLOSE * found[0].reached for entry in _different(found))
            tried = min(close, 2 if n <= SOME else 1)
            if thorough and 1 < n <= FEW:
                return _fine(charts, [_moved(charts, found[0], spacing), *found], spacing, tried + 1)
            return _fine(charts, found, spacing, tried)
        turns[shaped] = found[0].layout.turn[shaped, None]
    low = float(np.sqrt(charts.areas.sum() / pages)) / spacing.inner
    low = max(low, float(charts.sizes.min(axis=1).max()) / spacing.inner, charts.least_side / spacing.inner)
    best, high = None, 1.5 * low
    while best is None and high < MOST_SIDE * low:
        best = _on_pages(charts, shaped, turns, high, spacing, pages)
        high = 1.5 * high if best is None else high
    low = max(low, high / 1.5)
    for _ in range(0 if best is None else HALVINGS):
        trial = (low + high) / 2
        trial_layout = _on_pages(charts, shaped, turns, trial, spacing, pages)
        if trial_layout is None:
            low = trial
        else:
            best, high = trial_layout, trial
    return best


@dataclass(frozen=True, eq=False)
class _Grown:
    """A layout on one page, how it came about, and the side of the square that holds its charts.

    Gaps are shares of the side of `layout`; so it serves only pages that are not larger.
    """

    pages: _Pages
    order: IntArray
    side: float
    cells: int  # along the square's side, with a gap
    reached: float

    @cached_property
    def layout(self) -> Layout:
        return self.pages.layout(self.order, self.side)

    @property
    def places(self) -> IntArray:
        """Of charts in this order: mask, page, column and row."""
        return self.pages.places

    @property
    def serves(self) -> bool:
        return self.reached <= self.side


def _coarse(charts: Charts, shaped: IntArray, spacing: Spacing) -> list[_Grown]:
    """Layouts on one page, the best one first."""
    n = len(shaped)
    turns = charts.turns(16 if n <= FEW else 8)
    areas, sizes = charts.areas[shaped], charts.sizes[shaped]
    keys = (areas, sizes.max(axis=1), sizes.prod(axis=1))
    all_shaped = n == len(charts.outlines)  # else the small ones fill what gaps these leave
    tried = 1 if not all_shaped else 3 if n <= SOME else 2
    order_by = {tuple(np.argsort(-key, kind="stable").tolist()) for key in keys[:tried]}
    orders = [np.array(order) for order in sorted(order_by)]
    found: list[_Grown] = []
    side = max(float(np.sqrt(areas.sum() / SHARE)), charts.least_side)
    for _ in range(2 if all_shaped else 1):
        row = _row(charts, shaped, turns, COARSE / side, spacing.gap * COARSE)  # for all orders
        found += [
            _grown(len(charts.outlines), shaped[order], row, row.spans[order], side, COARSE, spacing)
            for order in orders
        ]
        least = min(entry.reached for entry in found)
        side *= 0.985 if abs(least / side - 1) < 0.005 else least / side
    return sorted(found, key=lambda entry: entry.reached)


def _moved(charts: Charts, start: _Grown, spacing: Spacing) -> _Grown:
    """A layout of a smaller square, after moves at random."""
    chance, n = np.random.default_rng(0), len(start.order)
    side = start.reached
    cells = MIDDLE / side
    row = _row(charts, np.arange(n), charts.turns(DIRECTIONS), cells, spacing.gap * MIDDLE)
    best = _grown(n, start.order, row, row.spans[start.order], side, MIDDLE, spacing)
    spans = row.spans  # of charts that are held in one direction, they are shorter
    up_to = np.cumsum(charts.areas / charts.areas.sum())
    longest = np.minimum.reduceat(row.shapes.max(axis=1), row.spans[:, 0])
    least = int(longest.max())  # no square has less
    for _ in range(min(MOST_MOVES, MOVED // n)):
        if best.cells <= least:
            break
        order, now = best.order, spans
        if chance.random() < 0.5:
            at, to = chance.integers(n, size=2).tolist()
            if at == to:
                continue
            moved = order.tolist()
            moved.insert(to, moved.pop(at))
            order = np.array(moved)
        else:
            by_area = chance.random() < 0.7
            chart = int(up_to.searchsorted(chance.random() * up_to[-1]) if by_area else chance.integers(n))
            (first, after), held = row.spans[chart].tolist(), spans[chart].tolist()
            own = [first, after]
            if held == own or chance.random() < 0.7:
                k = first + int(chance.integers(after - first))
                own = [k, k + 1]
            if own == held:
                continue
            now = spans.copy()
            now[chart] = own
        known = _still_known(best, spans, order, now)
        pages = _placed(n, row, now[order], cells, best.cells, 1, known)
        if pages is not None:  # it takes no more cells; an equal one may lead on
            best, spans = _grown_to(pages, order, side, MIDDLE, spacing), now
    return best


def _still_known(best: _Grown, spans: IntArray, order: IntArray, now: IntArray) -> IntArray:
    """The places of the first charts, which do not change in another order or with fewer masks."""
    k, (first, after), (own_first, own_after) = best.places[:, 0], spans[order].T, now[order].T
    same = (order == best.order) & (own_first >= first) & (own_after <= after)
    same &= (own_first <= k) & (k < own_after)
    return best.places[: len(same) if same.all() else int(same.argmin())]


def _fine(charts: Charts, coarse: list[_Grown], spacing: Spacing, tried: int) -> Layout | None:
    """The first ones again on a fine grid, until one serves the page that it needs; None if none does.

    On it a chart may miss the bay of another one, and all end far apart: then more of them are tried.
    """
    found: list[_Grown] = []
    close = CLOSE * min(entry.reached for entry in coarse)
    for number, entry in enumerate(_different(coarse)):
        best_side = min((made.reached for made in found if made.serves), default=np.inf)
        if number >= tried and (best_side <= close or entry.reached >= best_side):
            break
        side, turns = entry.reached * (1 + SLACK), entry.layout.turn[:, None]
        for trial in range(MOST_TRIALS):
            row = _row(charts, entry.order, turns, FINE / side, spacing.gap * FINE)
            found.append(_grown(len(charts.outlines), entry.order, row, row.spans, side, FINE, spacing))
            if found[-1].serves:
                break
            side = max(side, found[-1].reached) * (1 + SLACK * 2**trial)
    serving = [entry for entry in (*found, *coarse) if entry.serves]
    if not serving:
        return None
    best = min(serving, key=lambda entry: entry.reached)
    return replace(best.layout, side=best.reached)


def _different(layouts: list[_Grown]) -> list[_Grown]:
    """The first one of each order and turns."""
    first: dict[tuple[bytes, bytes], _Grown] = {}
    for entry in layouts:
        first.setdefault((entry.order.tobytes(), entry.layout.turn.tobytes()), entry)
    return list(first.values())


def _row(charts: Charts, chosen: IntArray, turns: Turns, cells: float, gap: float) -> Row:
    """The masks of the chosen charts; `cells` of the grid are one unit, and `gap` is in cells."""
    which = chosen.tolist()
    return Row.of(masks_of([charts.outlines[i] for i in which], [turns[i] for i in which], cells, gap))


@dataclass(frozen=True, eq=False)
class _Pages:
    """Pages with some of `n` charts on them; in cells, `cells` of which are a unit of the charts."""

    n: int
    row: Row
    cells: float
    places: IntArray  # in the order of the charts: mask, page, column and row
    extents: IntArray  # widths and heights that are taken

    def layout(self, order: IntArray, side: float) -> Layout:
        """Where charts are that were placed in this order; the others stay at 0 on the first page."""
        k, page, x, y = self.places.T
        turn, corner = np.ones(self.n, dtype=np.complex128), np.zeros(self.n, dtype=np.complex128)
        number = np.zeros(self.n, dtype=np.int64)
        turn[order], number[order] = self.row.turns[k], page
        corner[order] = (x + 1j * y) / self.cells - self.row.origin[k]
        return Layout(turn, number, corner, side)


def _grown(
    n: int, order: IntArray, row: Row, spans: IntArray, side: float, grid: int, spacing: Spacing
) -> _Grown:
    """Some of `n` charts on one page whose gaps are those of a page of this side, which has `grid` cells."""
    room, pages = ROOM, None
    while pages is None:
        pages = _placed(n, row, spans, grid / side, int(room * grid), 1)
        room *= ROOM
    return _grown_to(pages, order, side, grid, spacing)


def _grown_to(pages: _Pages, order: IntArray, side: float, grid: int, spacing: Spacing) -> _Grown:
    cells = int(pages.extents.max())
    reached = (cells - spacing.gap * grid) / grid * side / spacing.inner
    return _Grown(pages, order, side, cells, reached)


def _placed(
    n: int, row: Row, spans: IntArray, cells: float, side: int, most: int, known: IntArray = NONE_KNOWN
) -> _Pages | None:
    """Some of `n` charts one after the other, each on the first page that has room for it.

    The spans are those of the masks that each may take. `cells` of the grid are one unit; `side` is in cells.
    The places of the first charts may be `known`.
    """
    places, extents = row.placed(side, most, spans, known)
    if len(places) and places[-1, 0] < 0:
        return None
    return _Pages(n, row, cells, places, extents)


def _on_pages(
    charts: Charts, shaped: IntArray, turns: Turns, side: float, spacing: Spacing, pages: int | None
) -> Layout | None:
    """Charts on pages of this side; the small ones as rectangles in what the others leave.

    The rectangles lie, and stand on shelves, the highest ones first.
    """
    n, gap, cells = len(charts.outlines), spacing.gap * FIXED, FIXED / side
    inner = int(spacing.inner * FIXED + gap)
    order = shaped[np.argsort(-charts.areas[shaped], kind="stable")]
    row = _row(charts, order, turns, cells, gap)
    made = _placed(n, row, row.spans, cells, inner, len(order) if pages is None else pages)
    if made is None:
        return None
    layout = made.layout(order, side)
    small = np.setdiff1d(np.arange(len(charts.outlines)), shaped)
    if not len(small):
        return layout
    turn, number, corner = layout.turn, layout.page, layout.corner
    sheets = row.taken(inner, made.places)
    width, height = charts.sizes[small].T
    lies = (width >= height) | charts.fixed
    boxes = np.where(lies[:, None], charts.sizes[small], charts.sizes[small, ::-1]) * cells + gap
    by_height = np.lexsort((-boxes[:, 0], -boxes[:, 1]))
    small, boxes, lies = small[by_height], boxes[by_height], lies[by_height]
    at = first = 0
    while first < len(small):
        if at == pages:
            return None
        taken = sheets[at] if at < len(sheets) else np.zeros((inner, inner), dtype=bool)
        places = on_shelves(boxes[first:], taken)
        if not len(places) and at >= len(sheets):
            return None
        on = slice(first, first + len(places))
        number[small[on]] = at
        turn[small[on]] = np.where(lies[on], 1, 1j)
        low = (places @ [1, 1j] + gap / 2 * (1 + 1j)) / cells
        corner[small[on]] = low + np.where(lies[on], 0, charts.sizes[small[on], 1])
        first, at = first + len(places), at + 1
    return layout
