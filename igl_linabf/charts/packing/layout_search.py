"""Search for positions and rotations of charts on pages, using masks of the grid cells that charts touch.

Charts are placed one after another, the largest first. Each chart is placed where the square around all
placed charts grows least and, among such places, nearest to the corner. Many rotations of each chart are
tried on a coarse grid. The layout is then repeated on a fine grid with the chosen rotations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..._core import pack_shelves
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from .constants import COARSE_TURNS, EXPECTED_FILL, GROWING_ROOM, MIN_SHAPED_AREA
from .outlines import ChartMasks, Outline, rasterize_outlines
from .spacing import Spacing

# Maximum number of charts that are packed by their outlines. Smaller charts are packed as rectangles.
MAX_SHAPED_CHARTS = 100
OBLIQUE_GAIN = 0.1  # minimum share of the page that oblique straight charts have to save
COARSE_GRID = 64  # cells along the page's side when the rotations of charts are chosen
FINE_GRID = 448  # cells along the page's side in the final layout
# If the fine page is larger than the best coarse page by this factor, the next layout is refined, too.
CLOSE_SIDE = 1.02
FINE_SLACK = 0.002  # relative enlargement of the page in the first fine trial; doubled in each further trial
MAX_FINE_TRIALS = 8  # number of trials of a layout on the fine grid
SIDE_HALVINGS = 7  # number of bisection steps that minimise the side of the pages
MAX_SIDE_RATIO = 1e3  # give up at this multiple of the page side's lower bound: the gaps leave no room

Turns = Sequence[ComplexArray] | ComplexArray  # for each chart, the rotations to try


@dataclass(frozen=True, eq=False)
class Layout:
    """The positions and rotations of charts on pages, in the units of the charts.

    Attributes
    ----------
    turn : (#C,) complex128
        The rotation of each chart, a unit complex number.
    page : (#C,) int64
    corner : (#C,) complex128
        The position of the rotated chart's origin, relative to the page's lower left corner.
    side : float
        The width of a page. Gaps between charts are shares of its width and height.
    """

    turn: ComplexArray
    page: IntArray
    corner: ComplexArray
    side: float


@dataclass(frozen=True, eq=False)
class UnplacedCharts:
    """Charts to lay out, rotated to their narrowest rectangles, with lower left corners at the origin.

    Attributes
    ----------
    outlines : list of Outline
    sizes : (#C, 2) float64
        Widths and heights.
    areas : (#C,) float64
    upright : bool
        Turn the charts by quarter turns only.
    fixed : bool
        Do not turn the charts.
    """

    outlines: Sequence[Outline]
    sizes: FloatArray
    areas: FloatArray
    upright: bool = False
    fixed: bool = False

    def compute_min_page_width(self, aspect: float) -> float:
        """Return a lower bound of the page width, because no chart on a page is longer than its diagonal."""
        return float(self.sizes.max() / np.hypot(1, aspect))

    def list_candidate_turns(self, is_upright: BoolArray | bool) -> list[ComplexArray]:
        """Return the turns of each chart to try: `list_turns`, or only the identity if charts are fixed."""
        if self.fixed:
            return [np.ones(1, dtype=np.complex128)] * len(self.areas)
        return list_turns(np.broadcast_to(self.upright | is_upright, len(self.areas)))

    @cached_property
    def is_straight(self) -> BoolArray:
        """Mask of the charts whose outline `is_straight`."""
        return np.array([outline.is_straight for outline in self.outlines], dtype=bool)

    def select_charts_with_outlines(self) -> IntArray:
        """Return the charts that are packed by their outlines: at most `MAX_SHAPED_CHARTS`, largest first.

        All other charts are packed as rectangles into the gaps.
        """
        areas: FloatArray = self.areas
        if len(areas) <= MAX_SHAPED_CHARTS:
            return np.arange(len(areas))
        largest = np.argsort(-areas, kind="stable")[:MAX_SHAPED_CHARTS]
        return np.asarray(largest[areas[largest] > MIN_SHAPED_AREA * areas.sum()])


def list_turns(is_upright: BoolArray) -> list[ComplexArray]:
    """Return evenly spaced rotations for each chart: four for upright charts, `COARSE_TURNS` for all others.

    Opposite rotations are adjacent in the list, because the mask of a chart for one of them is the mask for
    the opposite one, rotated by 180 degrees.
    """
    halves = (np.exp(2j * np.pi * np.arange(n // 2) / n) for n in (COARSE_TURNS, 4))
    free, quarters = (np.column_stack((half, -half)).ravel() for half in halves)
    return [quarters if upright else free for upright in is_upright.tolist()]


def find_fixed_layout(
    charts: UnplacedCharts, side: float, spacing: Spacing, pages: int | None
) -> Layout | None:
    """Lay out charts on pages of the given side; return None if they do not fit.

    At most `pages` pages are used; None means any number.
    """
    if charts.compute_min_page_width(spacing.aspect) > side * spacing.inner_width:
        return None
    shaped = charts.select_charts_with_outlines()
    found = _place_on_pages(
        charts, shaped, charts.list_candidate_turns(charts.is_straight), side, spacing, pages
    )
    if found is None:
        found = _place_on_pages(charts, shaped, charts.list_candidate_turns(False), side, spacing, pages)
    return _convert_aspect(found, spacing)


def find_largest_layout(charts: UnplacedCharts, spacing: Spacing, pages: int) -> Layout | None:
    """Lay out charts on the smallest possible pages; return None if the gaps leave no room for charts."""
    return _convert_aspect(_search_largest_layout(charts, spacing, pages), spacing)


def _convert_aspect(layout: Layout | None, spacing: Spacing) -> Layout | None:
    """Convert a layout from the square pages of the search to pages with the given aspect."""
    if layout is None or spacing.aspect == 1:
        return layout
    return replace(layout, corner=layout.corner.real + 1j * layout.corner.imag * spacing.aspect)


def _search_largest_layout(charts: UnplacedCharts, spacing: Spacing, pages: int) -> Layout | None:
    """Find the layout of charts on the smallest possible square pages."""
    n = len(charts.outlines)
    if n * spacing.gap**2 > pages * (spacing.inner_width + spacing.gap) ** 2:
        return None
    if n == 1:
        side = float((charts.sizes / [1, spacing.aspect]).max()) / spacing.inner_width
        return Layout(np.ones(1, np.complex128), np.zeros(1, np.int64), np.zeros(1, np.complex128), side)
    shaped, turns = charts.select_charts_with_outlines(), np.ones((n, 1), dtype=np.complex128)
    if len(shaped):
        found = _find_coarse_layouts(charts, shaped, spacing, charts.list_candidate_turns(charts.is_straight))
        if charts.is_straight[shaped].any() and not charts.upright:
            free = _find_coarse_layouts(charts, shaped, spacing, charts.list_candidate_turns(False))
            if free[0].needed ** 2 < (1 - OBLIQUE_GAIN) * found[0].needed ** 2:
                found = free
        if pages == 1 and len(shaped) == n:
            return _refine_layout(charts, found, spacing)
        turns[shaped] = found[0].layout.turn[shaped, None]
    return _bisect_side(charts, shaped, turns, spacing, pages)


def _bisect_side(
    charts: UnplacedCharts, shaped: IntArray, turns: Turns, spacing: Spacing, pages: int
) -> Layout | None:
    """Find the smallest pages by bisection and return the layout on them, with the given rotations."""
    aspect = spacing.aspect
    least = (
        np.sqrt(charts.areas.sum() / aspect / pages),
        charts.sizes.min(axis=1).max() / min(1, aspect),
        charts.compute_min_page_width(aspect),
    )
    low = float(max(least)) / spacing.inner_width
    best, high = None, 1.5 * low
    while best is None and high < MAX_SIDE_RATIO * low:
        best = _place_on_pages(charts, shaped, turns, high, spacing, pages)
        high = 1.5 * high if best is None else high
    low = max(low, high / 1.5)
    for _ in range(0 if best is None else SIDE_HALVINGS):
        trial = (low + high) / 2
        layout = _place_on_pages(charts, shaped, turns, trial, spacing, pages)
        if layout is None:
            low = trial
        else:
            best, high = layout, trial
    return best


@dataclass(frozen=True, eq=False)
class _PlacedCharts:
    """Some of `n` charts, placed on grids with `cells` cells per unit of length.

    `extents` has the number of grid columns and rows that the charts occupy on each page.
    """

    n: int
    masks: ChartMasks
    cells: float
    places: IntArray
    extents: IntArray

    def make_layout(self, order: IntArray, side: float) -> Layout:
        """Return the layout, in which charts outside `order` are at the origin of the first page."""
        k, page, x, y = self.places.T
        turn, corner = np.ones(self.n, dtype=np.complex128), np.zeros(self.n, dtype=np.complex128)
        number = np.zeros(self.n, dtype=np.int64)
        turn[order], number[order] = self.masks.turns[k], page
        corner[order] = (x + 1j * y) / self.cells - self.masks.origin[k]
        return Layout(turn, number, corner, side)


@dataclass(frozen=True, eq=False)
class _SquareLayout:
    """A layout on one page, and the square around its charts.

    The gaps between charts are shares of `side`. On a smaller page they would be wider than necessary, and on
    a larger page too narrow.
    """

    placed: _PlacedCharts
    order: IntArray
    side: float  # width of the page that defines the gaps
    needed: float  # width of the smallest page that contains the square of the charts

    @cached_property
    def layout(self) -> Layout:
        return self.placed.make_layout(self.order, self.side)

    @property
    def fits_on_page(self) -> bool:
        return self.needed <= self.side


def _find_coarse_layouts(
    charts: UnplacedCharts, shaped: IntArray, spacing: Spacing, turns: Turns
) -> list[_SquareLayout]:
    """Return layouts on two coarse grids, best first."""
    areas = charts.areas[shaped]
    order = np.argsort(-areas, kind="stable")
    found = list[_SquareLayout]()
    expected = float(np.sqrt(areas.sum() / spacing.aspect / EXPECTED_FILL))
    side = max(expected, charts.compute_min_page_width(spacing.aspect))
    for _ in range(2):
        masks = _draw_masks(charts, shaped[order], turns, side, COARSE_GRID, spacing)
        found.append(_make_square_layout(charts, shaped[order], masks, side, COARSE_GRID, spacing))
        least = found[-1].needed
        # retry with the required page width or, if it is nearly the same, with a slightly different grid
        side *= 0.985 if abs(least / side - 1) < 0.005 else least / side
    return sorted(found, key=lambda entry: entry.needed)


def _refine_layout(charts: UnplacedCharts, coarse: list[_SquareLayout], spacing: Spacing) -> Layout | None:
    """Repeat the best coarse layout on a fine grid; return None if no layout fits its page.

    On the fine grid, a chart may narrowly fail to fit into a concavity of another chart, and the page becomes
    much larger. If this happens, the next coarse layout is tried.
    """
    found: list[_SquareLayout] = []
    for entry in coarse:
        best_side = min((made.needed for made in found if made.fits_on_page), default=np.inf)
        if best_side <= CLOSE_SIDE * coarse[0].needed or entry.needed >= best_side:
            break
        side, turns = entry.needed * (1 + FINE_SLACK), entry.layout.turn[:, None]
        for trial in range(MAX_FINE_TRIALS):
            masks = _draw_masks(charts, entry.order, turns, side, FINE_GRID, spacing)
            found.append(_make_square_layout(charts, entry.order, masks, side, FINE_GRID, spacing))
            if found[-1].fits_on_page:
                break
            side = max(side, found[-1].needed) * (1 + FINE_SLACK * 2**trial)
    fitting = [entry for entry in (*found, *coarse) if entry.fits_on_page]
    if not fitting:
        return None
    best = min(fitting, key=lambda entry: entry.needed)
    return replace(best.layout, side=best.needed)


def _draw_masks(
    charts: UnplacedCharts, chosen: IntArray, turns: Turns, side: float, grid: int, spacing: Spacing
) -> ChartMasks:
    """Rasterise the chosen charts for pages of width `side` that have `grid` cells along the side."""
    which, gap = chosen.tolist(), spacing.gap * grid
    outlines, own = [charts.outlines[i] for i in which], [turns[i] for i in which]
    return ChartMasks.concatenate(rasterize_outlines(outlines, own, grid / side, gap, spacing.aspect))


def _make_square_layout(
    charts: UnplacedCharts, order: IntArray, masks: ChartMasks, side: float, grid: int, spacing: Spacing
) -> _SquareLayout:
    """Place charts on one page, with the gaps of a page of width `side` that has `grid` cells along it."""
    room, placed = GROWING_ROOM, None
    while placed is None:
        placed = _place_charts(len(charts.outlines), masks, grid / side, int(room * grid), 1)
        room *= GROWING_ROOM
    cells = int(placed.extents.max())
    needed = (cells - spacing.gap * grid) / grid * side / spacing.inner_width
    return _SquareLayout(placed, order, side, needed)


def _place_charts(n: int, masks: ChartMasks, cells: float, side: int, pages: int) -> _PlacedCharts | None:
    """Place some of `n` charts with `ChartMasks.place`; return None if they do not all fit."""
    places, extents = masks.place(side, pages, masks.spans)
    if len(places) and places[-1, 0] < 0:
        return None
    return _PlacedCharts(n, masks, cells, places, extents)


def _place_on_pages(
    charts: UnplacedCharts, shaped: IntArray, turns: Turns, side: float, spacing: Spacing, pages: int | None
) -> Layout | None:
    """Place charts on square pages: some by their outlines, and the rest as rectangles in the gaps.

    The longer side of each rectangle is horizontal. Rectangles are placed in rows, tallest first.
    """
    n, grid = len(charts.outlines), FINE_GRID
    gap, cells = spacing.gap * grid, grid / side
    inner = int(spacing.inner_width * grid + gap)
    order = shaped[np.argsort(-charts.areas[shaped], kind="stable")]
    masks = _draw_masks(charts, order, turns, side, grid, spacing)
    placed = _place_charts(n, masks, cells, inner, len(order) if pages is None else pages)
    if placed is None:
        return None
    layout = placed.make_layout(order, side)
    small = np.setdiff1d(np.arange(n), shaped)
    if not len(small):
        return layout
    turn, number, corner = layout.turn, layout.page, layout.corner
    taken = masks.find_taken_cells(inner, placed.places)
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
        places = pack_shelves(boxes[first:], np.zeros((inner, inner), dtype=bool) if is_new else taken[page])
        if is_new and not len(places):
            return None
        on = slice(first, first + len(places))
        number[small[on]] = page
        turn[small[on]] = np.where(lies[on], 1, 1j)
        low = (places @ [1, 1j] + gap / 2 * (1 + 1j)) / cells
        corner[small[on]] = low + np.where(lies[on], 0, charts.sizes[small[on], 1])
        first, page = first + len(places), page + 1
    return layout
