"""A page's grid of cells, and the charts that are on it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .._types import BoolArray
from ..kernels import best_place
from .outlines import Masks


@dataclass(frozen=True, eq=False)
class Page:
    """Cells that are taken, and the rectangle from the corner that holds them.

    Attributes
    ----------
    taken : (side, side) bool
    width, height : int
    """

    taken: BoolArray
    width: int = 0
    height: int = 0

    @classmethod
    def empty(cls, side: int) -> Page:
        return cls(np.zeros((side, side), dtype=bool))

    def with_mask(self, cells: BoolArray, x: int, y: int) -> Page:
        """The page after a mask came to (x, y)."""
        rows, columns = cells.shape
        taken = self.taken.copy()
        taken[y : y + rows, x : x + columns] |= cells
        return replace(
            self, taken=taken, width=max(self.width, x + columns), height=max(self.height, y + rows)
        )

    def best_place(self, masks: Masks) -> tuple[int, int, int] | None:
        """Which mask, and where (x, y), so that the square of all grows least; None if none has room."""
        found = best_place(self.taken, self.width, self.height, masks.shapes, masks.blocks, masks.start)
        return found if found[0] >= 0 else None
