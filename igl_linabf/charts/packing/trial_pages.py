"""Estimate page sizes by packing charts on a coarse grid; each chart is rasterised only once."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from ..._types import IntArray
from ...surface import Ragged
from .constants import EXPECTED_FILL, GROWING_ROOM
from .layout_search import list_turns
from .outlines import ChartMasks, Masks, Outline, rasterize_outlines
from .spacing import Spacing

TRIAL_GRID = 96  # cells along the page's side for trial pages
MAX_PAGE_SIDES = 16  # use a coarser grid if a chart is longer than this many expected page sides


@dataclass(frozen=True, eq=False)
class TrialChart:
    """A chart that can be placed on a trial page: its masks, and its area."""

    masks: Masks
    area: float


@dataclass(frozen=True, eq=False)
class TrialPage:
    """A page on a coarse grid that estimates the size of the final page. Its charts may be cut into parts.

    Attributes
    ----------
    area : float
        Total area of the charts.
    cells : float
        Grid cells per unit of length.
    spacing : Spacing
    upright : bool
        Turn charts by quarter turns only.
    """

    area: float
    cells: float
    spacing: Spacing
    upright: bool

    @classmethod
    def from_outlines(cls, outlines: Sequence[Outline], spacing: Spacing, upright: bool) -> "TrialPage":
        """Return a trial page for charts and their parts, with a grid that matches the expected page size."""
        area = sum(outline.area for outline in outlines)
        side = float(np.sqrt(area / spacing.aspect / EXPECTED_FILL))
        longest = max(float(np.abs(outline.start).max()) for outline in outlines)
        return cls(area, TRIAL_GRID / max(side, longest / MAX_PAGE_SIDES), spacing, upright)

    def draw_charts(self, outlines: Sequence[Outline]) -> list[TrialChart]:
        """Rasterise the outlines of charts at several rotations."""
        if not outlines:
            return []
        turns = list_turns(np.full(len(outlines), self.upright))
        gap = self.spacing.gap * TRIAL_GRID
        masks = rasterize_outlines(outlines, turns, self.cells, gap, self.spacing.aspect)
        return [TrialChart(mask, outline.area) for mask, outline in zip(masks, outlines, strict=True)]

    def draw_lists_of_charts(self, several: Sequence[Sequence[Outline]]) -> list[list[TrialChart]]:
        """Rasterise several lists of outlines; return a list of trial charts for each of them."""
        made = self.draw_charts([outline for outlines in several for outline in outlines])
        start = Ragged.from_sizes([len(outlines) for outlines in several]).start.tolist()
        return [made[i:j] for i, j in pairwise(start)]

    def measure_size(self, charts: Sequence[TrialChart]) -> float:
        """Return the ratio of the area of the smallest page that holds `charts` to the total area `area`."""
        return next(self.iterate_size_functions([], [charts]))(np.inf)

    def iterate_size_functions(
        self, others: Sequence[TrialChart], several: Sequence[Sequence[TrialChart]]
    ) -> Iterator[Callable[[float], float]]:
        """Yield a function for each list of charts in `several`, which computes its size with `others`.

        The function takes a limit, and returns infinity if the size is not below it. A low limit saves time.
        """
        charts = [*others, *(chart for own in several for chart in own)]
        masks = ChartMasks.concatenate([chart.masks for chart in charts])
        areas = np.array([chart.area for chart in charts])
        first = len(others)
        for own in several:
            which = np.append(np.arange(len(others)), np.arange(first, first + len(own)))
            spans = masks.spans[which[np.argsort(-areas[which], kind="stable")]]
            first += len(own)
            yield partial(self._measure_masks, masks, spans)

    def _measure_masks(self, masks: ChartMasks, spans: IntArray, limit: float) -> float:
        """Return the page size for charts placed in the order of `spans`; infinity if it reaches `limit`."""
        gap = self.spacing.gap * TRIAL_GRID
        # number of cells along the side of a page that the charts would cover completely
        full = self.cells * float(np.sqrt(self.area / self.spacing.aspect))
        inner = self.spacing.inner_width * full
        most = np.ceil(gap + inner * np.sqrt(max(limit, 0.0))) - 1
        room = GROWING_ROOM * TRIAL_GRID
        while most >= 1:
            places, extents = masks.place(int(min(room, most)), 1, spans)
            if places[-1, 0] >= 0:
                return float(((extents.max() - gap) / inner) ** 2)
            if room >= most:
                break
            room *= GROWING_ROOM
        return np.inf
