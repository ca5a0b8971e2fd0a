"""A coarse page on which charts are tried again and again: what stays the same is drawn once."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..surface import Parts
from .layout_search import ROOM, SHARE, turns_of
from .outlines import Masks, Outline, Row, masks_of
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
        sizes = np.array([np.ptp(np.column_stack((o.start.real, o.start.imag)), axis=0) for o in outlines])
        areas = np.array([outline.area for outline in outlines])
        turns = turns_of(areas, sizes, self.area, DIRECTIONS, self.upright)
        masks = masks_of(outlines, turns, self._cells, self.spacing.gap * CELLS)
        return [Drawn(mask, area) for mask, area in zip(masks, areas.tolist(), strict=True)]

    def each_drawn(self, several: Sequence[Sequence[Outline]]) -> list[list[Drawn]]:
        """The same of several lists of charts."""
        made = self.drawn([outline for outlines in several for outline in outlines])
        start = Parts.of_sizes([len(outlines) for outlines in several]).start.tolist()
        return [made[i:j] for i, j in pairwise(start)]

    def reached(self, charts: Sequence[Drawn], most: float = np.inf) -> float:
        """The page's area over that of the charts, the largest ones first; infinite if not below `most`."""
        order = np.argsort([-chart.area for chart in charts], kind="stable").tolist()
        row = Row.of([charts[i].masks for i in order])
        gap, inner = self.spacing.gap * CELLS, self.spacing.inner * self._cells * float(np.sqrt(self.area))
        limit = np.ceil(gap + inner * np.sqrt(max(most, 0.0))) - 1
        room = ROOM * CELLS
        while limit >= 1:
            places, extents, _ = row.placed(int(min(room, limit)), 1)
            if (places[:, 0] >= 0).all():
                return float(((extents.max() - gap) / inner) ** 2)
            if room >= limit:
                break
            room *= ROOM
        return np.inf
