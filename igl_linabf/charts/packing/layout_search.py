"""The places and turns of charts on pages: a search by masks, the cells of a grid that charts touch.

Charts are placed one after another, mostly the largest first. Each comes to where the square that holds all
of them grows least, and there nearest to the corner. This is tried on a coarse grid, in several orders, with
many turns of each chart. The best layouts are found again on a fine grid, with the turns that they have. A
few charts are also moved before, if there is time: one comes earlier or later, or keeps one of its turns.
Tiny charts come last, as rectangles, into the gaps that the others leave.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..._core import on_shelves
from ..._types import ComplexArray, FloatArray, IntArray
from . import constants
from .outlines import NO_PLACES, ChartMasks, Outline, masks_of
from .spacing import Spacing

Turns = Sequence[ComplexArray] | ComplexArray  # of each chart


@dataclass(frozen=True, eq=False)
class Layout:
    """Where charts are on pages, in the charts' units.

    Attributes
    ----------
    turn : (#C,) complex128
    page : (#C,) int64
    corner : (#C,) complex128
        Where the origin of the turned chart comes to, from the page's lower left corner.
    side : float
        The width of a page; gaps between charts are shares of it, and of its height.
    """

    turn: ComplexArray
    page: IntArray
    corner: ComplexArray
    side: float


@dataclass(frozen=True, eq=False)
class Charts:
    """Charts to lay out, turned to their narrowest rectangles, whose lower left corners are at the origin.

    Attributes
    ----------
    outlines : list of Outline
    sizes : (#C, 2) float64
        Widths and heights.
    areas : (#C,) float64
    upright : bool
        Turn them by quarter turns only.
    fixed : bool
        Do not turn them.
    """

    outlines: Sequence[Outline]
    sizes: FloatArray
    areas: FloatArray
    upright: bool = False
    fixed: bool = False

    def least_side(self, aspect: float) -> float:
        """The width of a page for the longest chart: nothing on a page is longer than its diagonal."""
        return float(self.sizes.max() / np.hypot(1, aspect))

    def turns(self, number: int) -> list[ComplexArray]:
        """`turns_of` these charts."""
        if self.fixed:
            return [np.ones(1, dtype=np.complex128)] * len(self.areas)
        return turns_of(self.areas, self.sizes, float(self.areas.sum()), number, self.upright)

    def some(self, which: IntArray) -> Charts:
        """These alone."""
        outlines = [self.outlines[i] for i in which.tolist()]
        return replace(self, outlines=outlines, sizes=self.sizes[which], areas=self.areas[which])


def large_ones(areas: FloatArray) -> IntArray:
    """The charts that are placed by their shapes; the others come as rectangles into the gaps."""
    return np.flatnonzero(areas > constants.MIN_SHAPED_AREA * areas.sum())


def turns_of(
    areas: FloatArray, sizes: FloatArray, total: float, number: int, upright: bool
) -> list[ComplexArray]:
    """So many turns by equal angles for each chart, or four, of charts of a layout of this total area.

    Rectangles are turned by quarters only, unless they are long: those may fit along a page's diagonal.
    Opposite turns stand side by side, so that only one of two masks is drawn.
    """
    quarters = min(number, 4)
    rectangular = areas > constants.RECTANGLE_FILL * sizes.prod(axis=1)
    rectangular &= sizes.max(axis=1) < np.sqrt(total) / 2
    numbers = np.where(upright | rectangular, quarters, number)
    halves = {n: np.exp(2j * np.pi * np.arange(n // 2) / n) for n in (quarters, number)}
    turns = {n: np.column_stack((half, -half)).ravel() for n, half in halves.items()}
    return [turns[n] for n in numbers.tolist()]


def fixed_layout(charts: Charts, side: float, spacing: Spacing, pages: int | None) -> Layout | None:
    """Charts on pages of this side, on so many at most or as many as it takes; None if they do not fit."""
    if charts.least_side(spacing.aspect) > side * spacing.inner:
        return None
    turns = charts.turns(constants.COARSE_TURNS)
    return _raised(_on_pages(charts, large_ones(charts.areas), turns, side, spacing, pages), spacing)


def largest_layout(charts: Charts, spacing: Spacing, pages: int, thorough: bool = False) -> Layout | None:
    """The layout on pages of the shortest side, on which charts are largest; None if none has room for gaps.

    If it is to be `thorough`, a few charts are moved, too, which takes up to half a second.
    """
    return _raised(_largest(charts, spacing, pages, thorough), spacing)


def _raised(layout: Layout | None, spacing: Spacing) -> Layout | None:
    """The layout on pages as high as they are: the search has cells of their aspect, and square pages."""
    if layout is None or spacing.aspect == 1:
        return layout
    return replace(layout, corner=layout.corner.real + 1j * layout.corner.imag * spacing.aspect)


def _largest(charts: Charts, spacing: Spacing, pages: int, thorough: bool) -> Layout | None:
    n = len(charts.outlines)
    if n * spacing.gap**2 > pages * (spacing.inner + spacing.gap) ** 2:
        return None
    if n == 1:
        side = float((charts.sizes / [1, spacing.aspect]).max()) / spacing.inner
        return Layout(np.ones(1, np.complex128), np.zeros(1, np.int64), np.zeros(1, np.complex128), side)
    shaped, turns = large_ones(charts.areas), np.ones((n, 1), dtype=np.complex128)
    if len(shaped):
        large = charts.some(shaped)
        found = _coarse(large, spacing)
        best = _searched(large, found, spacing, thorough) if pages == 1 else None
        layout = None if best is None else _in_gaps(charts, shaped, best, spacing)
        if layout is not None:
            return layout
        turns[shaped] = (best or found[0]).layout.turn[:, None]
    return _shortest_side(charts, shaped, turns, spacing, pages)


def _searched(
    charts: Charts, found: list[_SquareLayout], spacing: Spacing, thorough: bool
) -> _SquareLayout | None:
    """The best layout on a fine grid, of coarse ones; None if none fits its page."""
    n = len(charts.areas)
    close = sum(entry.needed <= constants.CLOSE_SIDE * found[0].needed for entry in _different(found))
    number = min(close, 2 if n <= constants.MAX_REORDERED_CHARTS else 1)
    if thorough and n <= constants.MAX_MOVED_CHARTS:
        found, number = [_moved(charts, found[0], spacing), *found], number + 1
    return _fine(charts, found, spacing, number)


def _in_gaps(charts: Charts, shaped: IntArray, best: _SquareLayout, spacing: Spacing) -> Layout | None:
    """The layout of the large charts with the others in its gaps; None if these have no room."""
    placed, order = replace(best.placed, n=len(charts.areas)), shaped[best.order]
    layout = _with_rectangles(charts, placed, order, best.side, spacing, best.cells, 1)
    return None if layout is None else replace(layout, side=best.needed)


def _shortest_side(
    charts: Charts, shaped: IntArray, turns: Turns, spacing: Spacing, pages: int
) -> Layout | None:
    """The layout on pages of the shortest side that a bisection finds, with these turns."""
    aspect = spacing.aspect
    least = (
        np.sqrt(charts.areas.sum() / aspect / pages),
        charts.sizes.min(axis=1).max() / min(1, aspect),
        charts.least_side(aspect),
    )
    low = float(max(least)) / spacing.inner
    best, high = None, 1.5 * low
    while best is None and high < constants.MAX_SIDE_RATIO * low:
        best = _on_pages(charts, shaped, turns, high, spacing, pages)
        high = 1.5 * high if best is None else high
    low = max(low, high / 1.5)
    for _ in range(0 if best is None else constants.SIDE_HALVINGS):
        trial = (low + high) / 2
        layout = _on_pages(charts, shaped, turns, trial, spacing, pages)
        if layout is None:
            low = trial
        else:
            best, high = layout, trial
    return best


@dataclass(frozen=True, eq=False)
class _PlacedCharts:
    """Some of `n` charts in their places on pages, on a grid that has `cells` to a unit of the charts."""

    n: int
    masks: ChartMasks
    cells: float
    places: IntArray
    extents: IntArray  # of what they take on each page, in cells

    def layout(self, order: IntArray, side: float) -> Layout:
        """Of charts that were placed in this order; the others stay at the origin of the first page."""
        k, page, x, y = self.places.T
        turn, corner = np.ones(self.n, dtype=np.complex128), np.zeros(self.n, dtype=np.complex128)
        number = np.zeros(self.n, dtype=np.int64)
        turn[order], number[order] = self.masks.turns[k], page
        corner[order] = (x + 1j * y) / self.cells - self.masks.origin[k]
        return Layout(turn, number, corner, side)


@dataclass(frozen=True, eq=False)
class _SquareLayout:
    """A layout on one page, and the square that its charts take.

    Gaps are shares of `side`. On a shorter page they are wider than they need be; on a longer one they would
    be too narrow.
    """

    placed: _PlacedCharts
    order: IntArray
    side: float  # of the page that the gaps are for
    cells: int  # along the square, with a gap
    needed: float  # side of the page that has room for the square

    @cached_property
    def layout(self) -> Layout:
        return self.placed.layout(self.order, self.side)

    @property
    def fits(self) -> bool:
        return self.needed <= self.side


def _coarse(charts: Charts, spacing: Spacing) -> list[_SquareLayout]:
    """Layouts on a coarse grid, the best one first: charts in the order of areas, lengths or rectangles."""
    n, grid = len(charts.areas), constants.COARSE_GRID
    turns = charts.turns(constants.COARSE_TURNS * (2 if n <= constants.MAX_MOVED_CHARTS else 1))
    areas, sizes = charts.areas, charts.sizes
    keys = (areas, sizes.max(axis=1), sizes.prod(axis=1))
    number = 3 if n <= constants.MAX_REORDERED_CHARTS else 2
    order_by = {tuple(np.argsort(-key, kind="stable").tolist()) for key in keys[:number]}
    orders = [np.array(order) for order in sorted(order_by)]
    found: list[_SquareLayout] = []
    expected = float(np.sqrt(areas.sum() / spacing.aspect / constants.EXPECTED_FILL))
    side = max(expected, charts.least_side(spacing.aspect))
    for _ in range(2):
        masks = _masks(charts, np.arange(n), turns, side, grid, spacing)  # for all orders
        found += [
            _square_layout(n, order, masks, masks.spans[order], side, grid, spacing) for order in orders
        ]
        least = min(entry.needed for entry in found)
        # the page that they need; or, if that is this one, a slightly other grid, which rounds otherwise
        side *= 0.985 if abs(least / side - 1) < 0.005 else least / side
    return sorted(found, key=lambda entry: entry.needed)


def _moved(charts: Charts, start: _SquareLayout, spacing: Spacing) -> _SquareLayout:
    """A layout in a smaller square, after random moves: of a chart in the order, or to one of its turns."""
    chance, n = np.random.default_rng(0), len(start.order)
    side, grid = start.needed, constants.TRIAL_GRID
    cells = grid / side
    masks = _masks(charts, np.arange(n), charts.turns(constants.MOVE_TURNS), side, grid, spacing)
    best = _square_layout(n, start.order, masks, masks.spans[start.order], side, grid, spacing)
    spans = masks.spans  # of a chart that keeps one turn, of its mask alone
    up_to = np.cumsum(charts.areas / charts.areas.sum())
    longest = np.minimum.reduceat(masks.shapes.max(axis=1), masks.spans[:, 0])
    least = int(longest.max())  # cells along any square for them
    for _ in range(min(constants.MAX_MOVES, constants.MAX_MOVED_PLACES // n)):
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
            (first, after), held = masks.spans[chart].tolist(), spans[chart].tolist()
            own = [first, after]
            if held == own or chance.random() < 0.7:  # else it may have any turn again
                k = first + int(chance.integers(after - first))
                own = [k, k + 1]
            if own == held:
                continue
            now = spans.copy()
            now[chart] = own
        known = _unchanged(best, spans, order, now)
        placed = _place(n, masks, now[order], cells, best.cells, 1, known)
        if placed is not None:  # it takes no more cells; one that takes as many may lead on
            best, spans = _in_square(placed, order, side, grid, spacing), now
    return best


def _unchanged(best: _SquareLayout, spans: IntArray, order: IntArray, now: IntArray) -> IntArray:
    """The places of the first charts, as far as neither the new order nor the new spans change any."""
    places = best.placed.places
    k, (first, after), (own_first, own_after) = places[:, 0], spans[order].T, now[order].T
    same = (order == best.order) & (own_first >= first) & (own_after <= after)
    same &= (own_first <= k) & (k < own_after)
    return places[: len(same) if same.all() else int(same.argmin())]


def _fine(charts: Charts, coarse: list[_SquareLayout], spacing: Spacing, number: int) -> _SquareLayout | None:
    """The best of the first coarse layouts, found again on a fine grid; None if none fits its page.

    There a chart may just miss the bay of another one, and the square is far larger. If this happens to all
    of the first ones, more of them are tried.
    """
    found: list[_SquareLayout] = []
    grid, close = constants.FINE_GRID, constants.CLOSE_SIDE * min(entry.needed for entry in coarse)
    for tried, entry in enumerate(_different(coarse)):
        best_side = min((made.needed for made in found if made.fits), default=np.inf)
        if tried >= number and (best_side <= close or entry.needed >= best_side):
            break
        side, turns = entry.needed * (1 + constants.FINE_SLACK), entry.layout.turn[:, None]
        for trial in range(constants.MAX_FINE_TRIALS):
            masks = _masks(charts, entry.order, turns, side, grid, spacing)
            n = len(charts.outlines)
            found.append(_square_layout(n, entry.order, masks, masks.spans, side, grid, spacing))
            if found[-1].fits:
                break
            side = max(side, found[-1].needed) * (1 + constants.FINE_SLACK * 2**trial)
    fitting = [entry for entry in (*found, *coarse) if entry.fits]
    return min(fitting, key=lambda entry: entry.needed, default=None)


def _different(layouts: list[_SquareLayout]) -> list[_SquareLayout]:
    """The first one of each order and turns."""
    first: dict[tuple[bytes, bytes], _SquareLayout] = {}
    for entry in layouts:
        first.setdefault((entry.order.tobytes(), entry.layout.turn.tobytes()), entry)
    return list(first.values())


def _masks(
    charts: Charts, chosen: IntArray, turns: Turns, side: float, grid: int, spacing: Spacing
) -> ChartMasks:
    """The masks of the chosen charts on pages of this side, which have `grid` cells along it."""
    which, gap = chosen.tolist(), spacing.gap * grid
    outlines, own = [charts.outlines[i] for i in which], [turns[i] for i in which]
    return ChartMasks.of(masks_of(outlines, own, grid / side, gap, spacing.aspect))


def _square_layout(
    n: int, order: IntArray, masks: ChartMasks, spans: IntArray, side: float, grid: int, spacing: Spacing
) -> _SquareLayout:
    """Some of `n` charts on one page, with the gaps of a page of this side, which has `grid` cells."""
    room, placed = constants.GROWING_ROOM, None
    while placed is None:
        placed = _place(n, masks, spans, grid / side, int(room * grid), 1)
        room *= constants.GROWING_ROOM
    return _in_square(placed, order, side, grid, spacing)


def _in_square(
    placed: _PlacedCharts, order: IntArray, side: float, grid: int, spacing: Spacing
) -> _SquareLayout:
    cells = int(placed.extents.max())
    needed = (cells - spacing.gap * grid) / grid * side / spacing.inner
    return _SquareLayout(placed, order, side, cells, needed)


def _place(
    n: int,
    masks: ChartMasks,
    spans: IntArray,
    cells: float,
    side: int,
    pages: int,
    known: IntArray = NO_PLACES,
) -> _PlacedCharts | None:
    """`ChartMasks.place` of some of `n` charts; None if there is no room for all of them."""
    places, extents = masks.place(side, pages, spans, known)
    if len(places) and places[-1, 0] < 0:
        return None
    return _PlacedCharts(n, masks, cells, places, extents)


def _on_pages(
    charts: Charts, shaped: IntArray, turns: Turns, side: float, spacing: Spacing, pages: int | None
) -> Layout | None:
    """Charts on pages of this side: some by their shapes, and the others as rectangles in the gaps."""
    n, grid = len(charts.outlines), constants.FINE_GRID
    inner = int((spacing.inner + spacing.gap) * grid)
    order = shaped[np.argsort(-charts.areas[shaped], kind="stable")]
    masks = _masks(charts, order, turns, side, grid, spacing)
    placed = _place(n, masks, masks.spans, grid / side, inner, len(order) if pages is None else pages)
    if placed is None:
        return None
    return _with_rectangles(charts, placed, order, side, spacing, inner, pages)


def _with_rectangles(
    charts: Charts,
    placed: _PlacedCharts,
    order: IntArray,
    side: float,
    spacing: Spacing,
    inner: int,
    pages: int | None,
) -> Layout | None:
    """The charts that were placed in this order, and the others as rectangles in the gaps, if they have room.

    The rectangles lie on their longer sides, and stand on shelves, the highest ones first. Pages have `inner`
    cells along a side.
    """
    layout, cells = placed.layout(order, side), placed.cells
    gap = spacing.gap * side * cells
    small = np.setdiff1d(np.arange(placed.n), order)
    if not len(small):
        return layout
    turn, number, corner = layout.turn, layout.page, layout.corner
    taken = placed.masks.taken(inner, placed.places)
    width, height = charts.sizes[small].T
    lies = (width >= height) | charts.fixed
    boxes = np.where(lies[:, None], charts.sizes[small], charts.sizes[small, ::-1])
    boxes = boxes / [1, spacing.aspect] * cells + gap
    by_height = np.lexsort((-boxes[:, 0], -boxes[:, 1]))
    small, boxes, lies = small[by_height], boxes[by_height], lies[by_height]
    page = first = 0
    while first < len(small):
        if page == pages:
            return None
        is_new = page >= len(taken)
        places = on_shelves(boxes[first:], np.zeros((inner, inner), dtype=bool) if is_new else taken[page])
        if is_new and not len(places):
            return None
        on = slice(first, first + len(places))
        number[small[on]] = page
        turn[small[on]] = np.where(lies[on], 1, 1j)
        low = (places @ [1, 1j] + gap / 2 * (1 + 1j)) / cells
        corner[small[on]] = low + np.where(lies[on], 0, charts.sizes[small[on], 1])
        first, page = first + len(places), page + 1
    return layout
