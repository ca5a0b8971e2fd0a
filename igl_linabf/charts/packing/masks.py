"""Bitmap packing: masks are the cells of a page's grid that a turned chart touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ... import _core
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import Ragged
from .constants import PACKING_ROUNDING
from .outlines import Outline

NO_PLACES = np.empty((0, 4), np.int64)


@dataclass(frozen=True, eq=False)
class Masks:
    """The cells that a chart touches in several directions, each within the smallest rectangle of cells.

    Attributes
    ----------
    area : float
        The chart's.
    turns : (#M,) complex128
        The directions.
    shapes : (#M, 2) int64
        Their rows and columns.
    origin : (#M,) complex128
        The point of the turned chart at each mask's lower left corner.
    blocks : (#B, 4) int64
        Rectangles of touched cells: row, first column, length and number of rows; the largest come first.
    start : (#M + 1,) int64
        Mask k has the blocks from start[k] to start[k + 1].
    """

    area: float
    turns: ComplexArray
    shapes: IntArray
    origin: ComplexArray
    blocks: IntArray
    start: IntArray


NO_MASKS = Masks(
    0.0,
    np.empty(0, np.complex128),
    np.empty((0, 2), np.int64),
    np.empty(0, np.complex128),
    np.empty((0, 4), np.int64),
    np.zeros(1, np.int64),
)


@dataclass(frozen=True, eq=False)
class MaskTable:
    """The masks of several charts one after the other, as `Masks` has those of one.

    Attributes
    ----------
    areas : (#C,) float64
        The charts'.
    spans : (#C, 2) int64
        Chart i has the masks from spans[i, 0] to spans[i, 1].
    turns, shapes, origin, blocks, start
    """

    areas: FloatArray
    spans: IntArray
    turns: ComplexArray
    shapes: IntArray
    origin: ComplexArray
    blocks: IntArray
    start: IntArray

    @classmethod
    def of(cls, masks: Sequence[Masks]) -> MaskTable:
        """The table of these charts."""
        areas = np.array([one.area for one in masks], dtype=np.float64)
        first = Ragged.of_sizes([len(one.turns) for one in masks])
        reached = Ragged.of_sizes([len(one.blocks) for one in masks]).start
        masks = masks or (NO_MASKS,)
        start = np.concatenate([*(one.start[:-1] for one in masks), reached[-1:]])
        start[:-1] += first.repeat(reached[:-1])
        return cls(
            areas,
            np.stack((first.start[:-1], first.start[1:]), axis=1),
            np.concatenate([one.turns for one in masks]),
            np.concatenate([one.shapes for one in masks]),
            np.concatenate([one.origin for one in masks]),
            np.concatenate([one.blocks for one in masks]),
            start,
        )

    def pack(
        self, side: int, most_pages: int, spans: IntArray, known: IntArray = NO_PLACES
    ) -> tuple[IntArray, IntArray]:
        """Pack charts, in the order of their spans, on pages of `side` x `side` cells, by one mask of each.

        Returns the places (#C, 4): mask, page, column and row, -1 where there is no room; and the widths and
        heights (#pages, 2) that are taken. The places of the first charts may be `known`.
        """
        return _core.placed(side, most_pages, spans, self.shapes, self.blocks, self.start, known)

    def taken(self, side: int, places: IntArray) -> BoolArray:
        """The cells (#pages, side, side) that charts at these places take."""
        return _core.taken_cells(side, places, self.blocks, self.start)


def rasterize(
    outlines: Sequence[Outline], turns: Sequence[ComplexArray], cells_per_unit: float, gap: float
) -> list[Masks]:
    """The cells that charts, turned and widened by half a gap (in cells) to all four sides, touch.

    Charts whose masks share no cell are at least the gap apart, in u or in v.
    """
    if not outlines:
        return []
    half = gap / 2 * (1 + PACKING_ROUNDING) + PACKING_ROUNDING
    number = [len(directions) for directions in turns]
    sides = Ragged.of_sizes([len(outline.start) for outline in outlines])
    start, end, weight = (
        np.concatenate(arrays) for arrays in zip(*((o.start, o.end, o.weight) for o in outlines), strict=True)
    )
    chart, turn = np.repeat(np.arange(len(outlines)), number), np.concatenate(turns) * cells_per_unit
    shapes, low, blocks, first = _core.drawn(start, end, weight, sides.start, turn, chart, half)
    origin, block = low / cells_per_unit, first.tolist()
    mask = pairwise([0, *np.cumsum(number).tolist()])
    return [
        Masks(
            outline.area,
            directions,
            shapes[i:j],
            origin[i:j],
            blocks[block[i] : block[j]],
            first[i : j + 1] - first[i],
        )
        for outline, directions, (i, j) in zip(outlines, turns, mask, strict=True)
    ]
