"""A coarse page on which charts are tried again and again: what stays the same is drawn once."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from ..._types import IntArray
from ...surface import Ragged, coordinates
from .layout_search import ROOM, SHARE, turns_of
from .outlines import Masks, Outline, Row, extents, masks_of
from .spacing import Spacing

DIRECTIONS = 8  # of charts
CELLS = 96  # along the side of the page that charts are expected to take


@dataclass(frozen=True, eq=False)
class Drawn:
    """A chart as it is drawn on a page.

    Attributes
    ----------
    masks : Masks
    area : float
    """

    masks: Masks
    area: float


@dataclass(frozen=True, eq=False)
class TrialPage:
    """A page of one scale for charts of this area.

    Attributes
    ----------
    area : float
        Of all charts.
    spacing : Spacing
    upright : bool
        Turn charts by quarter turns only.
    """

    area: float
    spacing: Spacing
    upright: bool

    @property
    def _cells(self) -> float:
        """Along a unit of the charts' lengths."""
        return CELLS / float(np.sqrt(self.area / SHARE))

    def drawn(self, outlines: Sequence[Outline]) -> list[Drawn]:
        """Charts, turned to their narrowest rectangles."""
        sides = Ragged.of_sizes([len(outline.start) for outline in outlines])
        sizes = coordinates(extents(np.concatenate([outline.start for outline in outlines]), sides)[1])
        areas = np.array([outline.area for outline in outlines])
        turns = turns_of(areas, sizes, self.area, DIRECTIONS, self.upright)
        masks = masks_of(outlines, turns, self._cells, self.spacing.gap * CELLS)
        return [Drawn(mask, area) for mask, area in zip(masks, areas.tolist(), strict=True)]

    def each_drawn(self, several: Sequence[Sequence[Outline]]) -> list[list[Drawn]]:
        """The same of several lists of charts."""
        made = self.drawn([outline for outlines in several for outline in outlines])
        start = Ragged.of_sizes([len(outlines) for outlines in several]).start.tolist()
        return [made[i:j] for i, j in pairwise(start)]

    def size(self, charts: Sequence[Drawn]) -> float:
        """The page's area over that of the charts, the largest ones placed first."""
        return next(self.sizes([], [charts]))(np.inf)

    def least_size(self, charts: Sequence[Drawn]) -> float:
        """The least `size` with the largest charts by area, by length or by rectangle placed first."""
        row, boxes = Row.of([chart.masks for chart in charts]), np.array([c.masks.shapes[0] for c in charts])
        keys = np.array([chart.area for chart in charts]), boxes.max(axis=1), boxes.prod(axis=1)
        least = np.inf
        for order in sorted({tuple(np.argsort(-key, kind="stable").tolist()) for key in keys}):
            least = min(least, self._size(row, row.spans[list(order)], least))
        return least

    def sizes(
        self, others: Sequence[Drawn], several: Sequence[Sequence[Drawn]]
    ) -> Iterator[Callable[[float], float]]:
        """For each of several lists of charts, `size` with the others; infinite if not below a limit."""
        charts = [*others, *(chart for own in several for chart in own)]
        row, areas = Row.of([chart.masks for chart in charts]), np.array([chart.area for chart in charts])
        first = len(others)
        for own in several:
            which = np.append(np.arange(len(others)), np.arange(first, first + len(own)))
            spans = row.spans[which[np.argsort(-areas[which], kind="stable")]]
            first += len(own)
            yield partial(self._size, row, spans)

    def _size(self, row: Row, spans: IntArray, most: float) -> float:
        gap, inner = self.spacing.gap * CELLS, self.spacing.inner * self._cells * float(np.sqrt(self.area))
        limit = np.ceil(gap + inner * np.sqrt(max(most, 0.0))) - 1
        room = ROOM * CELLS
        while limit >= 1:
            places, extents = row.placed(int(min(room, limit)), 1, spans)
            if places[-1, 0] >= 0:
                return float(((extents.max() - gap) / inner) ** 2)
            if room >= limit:
                break
            room *= ROOM
        return np.inf
