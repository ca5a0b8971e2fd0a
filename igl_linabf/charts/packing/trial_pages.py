"""A coarse page on which charts are packed again and again, to choose cuts: each chart is rasterized once."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from ..._types import IntArray
from ...surface import Ragged, coordinates
from .constants import DIRECTIONS, EXPECTED_FILL, MOVE_CELLS, PAGE_GROWTH
from .layout_search import turns_of
from .masks import Masks, MaskTable, rasterize
from .outlines import Outline, extents
from .spacing import Spacing


@dataclass(frozen=True, eq=False)
class TrialPage:
    """A page of one scale for charts of this area.

    Its grid is that on which moves are tried: `MOVE_CELLS` along the side of the page that the charts are
    expected to take.

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
    def _cells_per_unit(self) -> float:
        return MOVE_CELLS / float(np.sqrt(self.area / EXPECTED_FILL))

    def rasterize(self, outlines: Sequence[Outline]) -> list[Masks]:
        """Masks of charts that are turned to their narrowest rectangles."""
        sides = Ragged.of_sizes([len(outline.start) for outline in outlines])
        sizes = coordinates(extents(np.concatenate([outline.start for outline in outlines]), sides)[1])
        areas = np.array([outline.area for outline in outlines])
        turns = turns_of(areas, sizes, self.area, DIRECTIONS, self.upright)
        return rasterize(outlines, turns, self._cells_per_unit, self.spacing.gap * MOVE_CELLS)

    def rasterize_each(self, several: Sequence[Sequence[Outline]]) -> list[list[Masks]]:
        """The same of several lists of charts."""
        masks = self.rasterize([outline for outlines in several for outline in outlines])
        start = Ragged.of_sizes([len(outlines) for outlines in several]).start.tolist()
        return [masks[i:j] for i, j in pairwise(start)]

    def size(self, charts: Sequence[Masks]) -> float:
        """The area of the page that the charts need over their own, the largest ones placed first."""
        return next(self.sizes([], [charts]))(np.inf)

    def least_size(self, charts: Sequence[Masks]) -> float:
        """The least `size` with the largest charts by area, by length or by rectangle placed first."""
        table, boxes = MaskTable.of(charts), np.array([masks.shapes[0] for masks in charts])
        keys = table.areas, boxes.max(axis=1), boxes.prod(axis=1)
        least = np.inf
        for order in sorted({tuple(np.argsort(-key, kind="stable").tolist()) for key in keys}):
            least = min(least, self._size(table, table.spans[list(order)], least))
        return least

    def sizes(
        self, others: Sequence[Masks], several: Sequence[Sequence[Masks]]
    ) -> Iterator[Callable[[float], float]]:
        """For each list of charts a function of a limit: `size` with the others, infinite if not below it."""
        table = MaskTable.of([*others, *(masks for own in several for masks in own)])
        first = len(others)
        for own in several:
            which = np.append(np.arange(len(others)), np.arange(first, first + len(own)))
            spans = table.spans[which[np.argsort(-table.areas[which], kind="stable")]]
            first += len(own)
            yield partial(self._size, table, spans)

    def _size(self, table: MaskTable, spans: IntArray, limit: float) -> float:
        gap = self.spacing.gap * MOVE_CELLS
        inner = self.spacing.inner * self._cells_per_unit * float(np.sqrt(self.area))
        most_cells = np.ceil(gap + inner * np.sqrt(max(limit, 0.0))) - 1
        cells = PAGE_GROWTH * MOVE_CELLS
        while most_cells >= 1:
            places, extents = table.pack(int(min(cells, most_cells)), 1, spans)
            if places[-1, 0] >= 0:
                return float(((extents.max() - gap) / inner) ** 2)
            if cells >= most_cells:
                break
            cells *= PAGE_GROWTH
        return np.inf
