"""Where charts go on pages, and how they are turned: the search for the layout of the largest charts.

The largest chart comes first. Each goes to where the square that holds all of them grows least, and there to
the corner. Layouts of several orders are found on a coarse grid, with charts turned to many directions. The
best ones are found again on a fine grid, with the turns that they have. If there is time and charts are few,
moves are tried before: a chart at another place of the order, or held in one direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..._core import on_shelves
from ..._types import ComplexArray, FloatArray, IntArray
from .constants import (
    COARSE_CELLS,
    DIRECTIONS,
    EXPECTED_FILL,
    FEW_CHARTS,
    FINE_CELLS,
    GRID_TOLERANCE,
    LARGEST_SHAPED,
    MOST_MOVES,
    MOST_SHAPED,
    MOVE_CELLS,
    PAGE_CELLS,
    PAGE_GROWTH,
    RECTANGLE_FILL,
    SIDE_STEP,
    SMALL_CHART,
    SOME_CHARTS,
)
from .masks import NO_PLACES, MaskTable, rasterize
from .outlines import Outline
from .spacing import Spacing

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
class OutlinedCharts:
    """Charts that are to be laid out, their lower left corners at 0, turned to their narrowest rectangles.

    Attributes
    ----------
    outlines : list of Outline
    areas : (#C,) float64
    sizes : (#C, 2) float64
        Widths and heights.
    upright : bool
        Turn them by quarter turns only.
    """

    outlines: Sequence[Outline]
    areas: FloatArray
    sizes: FloatArray
    upright: bool = False

    @property
    def least_side(self) -> float:
        """Smaller pages cannot hold the longest chart: nothing in a square is longer than its diagonal."""
        return float(self.sizes.max() / np.sqrt(2))

    def turns(self, directions: int) -> list[ComplexArray]:
        """The turns of each chart, as `turns_of`."""
        return turns_of(self.areas, self.sizes, float(self.areas.sum()), directions, self.upright)

    def shaped(self) -> IntArray:
        """Those that are packed by their shape; of many charts, small ones are packed as rectangles."""
        areas = self.areas
        if len(areas) <= MOST_SHAPED:
            return np.arange(len(areas))
        largest = np.argsort(-areas, kind="stable")[:LARGEST_SHAPED]
        return np.asarray(largest[areas[largest] > SMALL_CHART * areas.sum()])


def turns_of(
    areas: FloatArray, sizes: FloatArray, total: float, directions: int, upright: bool
) -> list[ComplexArray]:
    """The turns that are tried for each chart of a layout that has the area `total`.

    They are equal steps around the circle: as many as are wanted, or four for short rectangles and where all
    are to stand `upright`. Opposite turns stand side by side, so that they are rasterized once.
    """
    rectangular = areas > RECTANGLE_FILL * sizes.prod(axis=1)
    rectangular &= sizes.max(axis=1) < np.sqrt(total) / 2  # a longer one may fit along the diagonal
    steps = np.where(upright | rectangular, 4, directions)
    halves = {n: np.exp(2j * np.pi * np.arange(n // 2) / n) for n in (4, directions)}
    by = {n: np.column_stack((half, -half)).ravel() for n, half in halves.items()}
    return [by[n] for n in steps.tolist()]


def fixed_layout(charts: OutlinedCharts, side: float, spacing: Spacing, pages: int | None) -> Layout | None:
    """Charts on pages of this side, as many as are needed or allowed; None if they do not fit."""
    if charts.least_side > side * spacing.inner:
        return None
    return _pack_pages(charts, charts.shaped(), charts.turns(DIRECTIONS), side, spacing, pages)


def largest_layout(
    charts: OutlinedCharts, spacing: Spacing, pages: int, thorough: bool = False
) -> Layout | None:
    """The layout whose pages have the smallest side, so that charts have the largest share of it.

    Where it is to be `thorough`, a few charts take up to half a second more. None if the gaps alone need more
    room than there is.
    """
    n = len(charts.outlines)
    if n * spacing.gap**2 > pages * (spacing.inner + spacing.gap) ** 2:
        return None
    turns = np.ones((n, 1), dtype=np.complex128)
    if n == 1:
        side = float(charts.sizes.max()) / spacing.inner
        return Layout(turns[0], np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.complex128), side)
    shaped = charts.shaped()
    if len(shaped):
        found = _coarse_layouts(charts, shaped, spacing)
        if pages == 1 and len(shaped) == n:
            close = sum(page.needed <= (1 + GRID_TOLERANCE) * found[0].needed for page in _distinct(found))
            tried = min(close, 2 if n <= SOME_CHARTS else 1)
            if thorough and n <= FEW_CHARTS:
                return _fine_layout(
                    charts, [_after_moves(charts, found[0], spacing), *found], spacing, tried + 1
                )
            return _fine_layout(charts, found, spacing, tried)
        turns[shaped] = found[0].layout.turn[shaped, None]
    low = float(np.sqrt(charts.areas.sum() / pages)) / spacing.inner
    low = max(low, float(charts.sizes.min(axis=1).max()) / spacing.inner, charts.least_side / spacing.inner)
    best, high = None, PAGE_GROWTH * low
    while best is None and high < PAGE_CELLS * low:  # beyond, each chart is in one cell
        best = _pack_pages(charts, shaped, turns, high, spacing, pages)
        high = PAGE_GROWTH * high if best is None else high
    low = max(low, high / PAGE_GROWTH)
    while best is not None and high - low > 2 * SIDE_STEP * high:
        side = (low + high) / 2
        layout = _pack_pages(charts, shaped, turns, side, spacing, pages)
        if layout is None:
            low = side
        else:
            best, high = layout, side
    return best


@dataclass(frozen=True, eq=False)
class _MaskLayout:
    """Masks of some of `n` charts on pages.

    Attributes
    ----------
    n : int
    masks : MaskTable
    cells : float
        Cells of the grid along a unit of the charts' lengths.
    places : (#placed, 4) int64
        Mask, page, column and row of each chart, in the order in which they were placed.
    extents : (#pages, 2) int64
        Widths and heights that are taken, in cells.
    """

    n: int
    masks: MaskTable
    cells: float
    places: IntArray
    extents: IntArray

    def layout(self, order: IntArray, side: float) -> Layout:
        """The layout of charts placed in this order; the others stay at 0 on the first page."""
        k, page, x, y = self.places.T
        turn, corner = np.ones(self.n, dtype=np.complex128), np.zeros(self.n, dtype=np.complex128)
        number = np.zeros(self.n, dtype=np.int64)
        turn[order], number[order] = self.masks.turns[k], page
        corner[order] = (x + 1j * y) / self.cells - self.masks.origin[k]
        return Layout(turn, number, corner, side)


@dataclass(frozen=True, eq=False)
class _OnePage:
    """A layout on one page, and the side of the square that holds its charts.

    Attributes
    ----------
    pages : _MaskLayout
    order : (#placed,) int64
        The charts, in the order in which they were placed.
    side : float
        Of the page that the gaps are shares of. A larger page would need wider gaps.
    cells : int
        Along the side of the square that holds the charts, with a gap.
    needed : float
        The side of the smallest page that holds the square.
    """

    pages: _MaskLayout
    order: IntArray
    side: float
    cells: int
    needed: float

    @classmethod
    def of(cls, pages: _MaskLayout, order: IntArray, side: float, grid: int, spacing: Spacing) -> _OnePage:
        """Of a page of `grid` cells along its side."""
        cells = int(pages.extents.max())
        return cls(pages, order, side, cells, (cells - spacing.gap * grid) / grid * side / spacing.inner)

    @cached_property
    def layout(self) -> Layout:
        return self.pages.layout(self.order, self.side)

    @property
    def fits(self) -> bool:
        """Whether the gaps are wide enough for the page that it needs."""
        return self.needed <= self.side


def _coarse_layouts(charts: OutlinedCharts, shaped: IntArray, spacing: Spacing) -> list[_OnePage]:
    """Layouts on one page, the best one first.

    The charts are placed in the order of their areas, of their lengths or of the rectangles around them.
    """
    n = len(shaped)
    turns = charts.turns(2 * DIRECTIONS if n <= FEW_CHARTS else DIRECTIONS)
    areas, sizes = charts.areas[shaped], charts.sizes[shaped]
    keys = (areas, sizes.max(axis=1), sizes.prod(axis=1))
    all_shaped = n == len(charts.outlines)  # else small charts fill the gaps in any order of the others
    tried = 1 if not all_shaped else 3 if n <= SOME_CHARTS else 2
    order_by = {tuple(np.argsort(-key, kind="stable").tolist()) for key in keys[:tried]}
    orders = [np.array(order) for order in sorted(order_by)]
    found: list[_OnePage] = []
    side = max(float(np.sqrt(areas.sum() / EXPECTED_FILL)), charts.least_side)
    for _ in range(2 if all_shaped else 1):
        masks = _mask_table(charts, shaped, turns, COARSE_CELLS / side, spacing.gap * COARSE_CELLS)
        for order in orders:
            spans = masks.spans[order]
            found.append(
                _pack_one_page(len(charts.outlines), shaped[order], masks, spans, side, COARSE_CELLS, spacing)
            )
        least = min(page.needed for page in found)
        # the second grid is that of the page that was needed, or another one if that is the first again
        side *= 0.985 if abs(least / side - 1) < 0.005 else least / side
    return sorted(found, key=lambda page: page.needed)


def _after_moves(charts: OutlinedCharts, start: _OnePage, spacing: Spacing) -> _OnePage:
    """A layout of a smaller square, after moves at random.

    Half of the moves take a chart to another place of the order. The others hold one in a single direction,
    or let it go again; large charts are held more often. A move stays if the square does not grow by it: one
    by which nothing shrinks may lead on.
    """
    chance, n = np.random.default_rng(0), len(start.order)
    side = start.needed
    cells = MOVE_CELLS / side
    masks = _mask_table(charts, np.arange(n), charts.turns(4 * DIRECTIONS), cells, spacing.gap * MOVE_CELLS)
    best = _pack_one_page(n, start.order, masks, masks.spans[start.order], side, MOVE_CELLS, spacing)
    spans = masks.spans  # a chart that is held in one direction has a span of one mask
    up_to = np.cumsum(charts.areas / charts.areas.sum())
    longest = np.minimum.reduceat(masks.shapes.max(axis=1), masks.spans[:, 0])
    least = int(longest.max())  # no square is smaller
    for _ in range(min(MOST_MOVES, 4 * MOST_MOVES // n)):
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
            if held == own or chance.random() < 0.7:
                k = first + int(chance.integers(after - first))
                own = [k, k + 1]
            if own == held:
                continue
            now = spans.copy()
            now[chart] = own
        known = _unchanged_places(best, spans, order, now)
        pages = _pack_masks(n, masks, now[order], cells, best.cells, 1, known)
        if pages is not None:
            best, spans = _OnePage.of(pages, order, side, MOVE_CELLS, spacing), now
    return best


def _unchanged_places(best: _OnePage, spans: IntArray, order: IntArray, now: IntArray) -> IntArray:
    """The places of the first charts, up to the one that a move of the order or of the spans changes."""
    places = best.pages.places
    k, (first, after), (own_first, own_after) = places[:, 0], spans[order].T, now[order].T
    same = (order == best.order) & (own_first >= first) & (own_after <= after)
    same &= (own_first <= k) & (k < own_after)
    return places[: len(same) if same.all() else int(same.argmin())]


def _fine_layout(
    charts: OutlinedCharts, coarse: list[_OnePage], spacing: Spacing, tried: int
) -> Layout | None:
    """The first `tried` layouts again on a fine grid, each until it fits; None if none does.

    There a chart may miss the bay of another one, and then all end far apart: if so, more layouts are tried.
    """
    found: list[_OnePage] = []
    close = (1 + GRID_TOLERANCE) * min(page.needed for page in coarse)
    for number, page in enumerate(_distinct(coarse)):
        best_side = min((made.needed for made in found if made.fits), default=np.inf)
        if number >= tried and (best_side <= close or page.needed >= best_side):
            break
        side, turns = page.needed * (1 + SIDE_STEP), page.layout.turn[:, None]
        step = SIDE_STEP
        while side < FINE_CELLS * charts.least_side:  # beyond, each chart is in one cell
            masks = _mask_table(charts, page.order, turns, FINE_CELLS / side, spacing.gap * FINE_CELLS)
            n, spans = len(charts.outlines), masks.spans
            found.append(_pack_one_page(n, page.order, masks, spans, side, FINE_CELLS, spacing))
            if found[-1].fits:
                break
            side = max(side, found[-1].needed) * (1 + step)
            step *= 2
    fitting = [page for page in (*found, *coarse) if page.fits]
    if not fitting:
        return None
    best = min(fitting, key=lambda page: page.needed)
    return replace(best.layout, side=best.needed)


def _distinct(layouts: list[_OnePage]) -> list[_OnePage]:
    """The first one of each order and turns."""
    first: dict[tuple[bytes, bytes], _OnePage] = {}
    for page in layouts:
        first.setdefault((page.order.tobytes(), page.layout.turn.tobytes()), page)
    return list(first.values())


def _mask_table(
    charts: OutlinedCharts, chosen: IntArray, turns: Turns, cells: float, gap: float
) -> MaskTable:
    """The masks of the chosen charts; `cells` of the grid are one unit, and `gap` is in cells."""
    which = chosen.tolist()
    return MaskTable.of(rasterize([charts.outlines[i] for i in which], [turns[i] for i in which], cells, gap))


def _pack_masks(
    n: int, masks: MaskTable, spans: IntArray, cells: float, side: int, most: int, known: IntArray = NO_PLACES
) -> _MaskLayout | None:
    """Some of `n` charts, in the order of their spans, on at most so many pages; None if they do not fit.

    A span has the masks that its chart may take. `cells` of the grid are one unit, and `side` is in cells.
    The places of the first charts may be `known`.
    """
    places, extents = masks.pack(side, most, spans, known)
    if len(places) and places[-1, 0] < 0:
        return None
    return _MaskLayout(n, masks, cells, places, extents)


def _pack_one_page(
    n: int, order: IntArray, masks: MaskTable, spans: IntArray, side: float, grid: int, spacing: Spacing
) -> _OnePage:
    """Some of `n` charts on one page, with the gaps of a page of this side and `grid` cells along it."""
    growth, pages = PAGE_GROWTH, None
    while pages is None:
        pages = _pack_masks(n, masks, spans, grid / side, int(growth * grid), 1)
        growth *= PAGE_GROWTH
    return _OnePage.of(pages, order, side, grid, spacing)


def _pack_pages(
    charts: OutlinedCharts, shaped: IntArray, turns: Turns, side: float, spacing: Spacing, pages: int | None
) -> Layout | None:
    """Charts on pages of this side: those `shaped` by their masks, the others as rectangles between them.

    The rectangles lie, and stand on shelves, the highest ones first. None if the charts do not fit.
    """
    n, gap, cells = len(charts.outlines), spacing.gap * PAGE_CELLS, PAGE_CELLS / side
    inner = int(spacing.inner * PAGE_CELLS + gap)
    order = shaped[np.argsort(-charts.areas[shaped], kind="stable")]
    masks = _mask_table(charts, order, turns, cells, gap)
    made = _pack_masks(n, masks, masks.spans, cells, inner, len(order) if pages is None else pages)
    if made is None:
        return None
    layout = made.layout(order, side)
    small = np.setdiff1d(np.arange(n), shaped)
    if not len(small):
        return layout
    turn, number, corner = layout.turn, layout.page, layout.corner
    taken = masks.taken(inner, made.places)
    width, height = charts.sizes[small].T
    lies = width >= height
    boxes = np.column_stack((np.maximum(width, height), np.minimum(width, height))) * cells + gap
    by_height = np.lexsort((-boxes[:, 0], -boxes[:, 1]))
    small, boxes, lies = small[by_height], boxes[by_height], lies[by_height]
    page = first = 0
    while first < len(small):
        if page == pages:
            return None
        is_new = page >= len(taken)
        places = on_shelves(boxes[first:], np.zeros((inner, inner), dtype=bool) if is_new else taken[page])
        if not len(places) and is_new:
            return None
        on = slice(first, first + len(places))
        number[small[on]] = page
        turn[small[on]] = np.where(lies[on], 1, 1j)
        low = (places @ [1, 1j] + gap / 2 * (1 + 1j)) / cells
        corner[small[on]] = low + np.where(lies[on], 0, charts.sizes[small[on], 1])
        first, page = first + len(places), page + 1
    return layout
