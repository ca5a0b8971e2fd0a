"""Compute outlines of charts, bounding rectangles, and masks, which are the grid cells that charts touch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..._core import occupied_cells, place_masks, rasterize
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import Ragged, real_coordinates

PARALLEL_ANGLE = np.deg2rad(1.0)  # maximum angle between an edge and a parallel side of the page
STRAIGHT_SHARE = 0.5  # minimum share of a straight outline's length that is parallel to the page's sides


def find_bounding_rectangles(z: ComplexArray, charts: Ragged) -> tuple[ComplexArray, ComplexArray]:
    """Return the bounding rectangles of charts: lower left corners, and sizes as width + i height."""
    low = charts.min(z.real) + 1j * charts.min(z.imag)
    return low, charts.max(z.real) + 1j * charts.max(z.imag) - low


@dataclass(frozen=True, eq=False)
class Outline:
    """The outline of a flat chart: the triangle sides that do not cancel with an opposite side.

    Attributes
    ----------
    start, end : (#S,) complex128
        The ends of each edge. The chart is on the left.
    weight : (#S,) int64
        Number of triangles on the left minus the number on the right; 1 in an oriented manifold.
    area : float
        Area of the chart.
    """

    start: ComplexArray
    end: ComplexArray
    weight: IntArray
    area: float

    @property
    def is_straight(self) -> bool:
        """Whether most edges are parallel to the axes, so that the chart belongs along the page's sides."""
        edge = real_coordinates(self.end - self.start)
        length = np.linalg.norm(edge, axis=1)
        parallel = np.abs(edge).min(axis=1) <= np.sin(PARALLEL_ANGLE) * length
        return bool(length[parallel].sum() >= STRAIGHT_SHARE * length.sum())


@dataclass(frozen=True, eq=False)
class Masks:
    """The grid cells that a chart touches at each of several rotations.

    Attributes
    ----------
    turns : (#M,) complex128
        The rotation of the chart for each mask.
    shapes : (#M, 2) int64
        The numbers of rows and columns of each mask.
    origin : (#M,) complex128
        The point of the rotated chart at the mask's lower left corner.
    blocks : (#B, 4) int64
        The cells of the masks as rectangular blocks: first row, first column, number of columns, number of
        rows. The largest blocks come first.
    start : (#M + 1,) int64
        Mask k consists of the blocks from start[k] to start[k + 1].
    """

    turns: ComplexArray
    shapes: IntArray
    origin: ComplexArray
    blocks: IntArray
    start: IntArray


NO_MASKS = Masks(
    np.empty(0, np.complex128),
    np.empty((0, 2), np.int64),
    np.empty(0, np.complex128),
    np.empty((0, 4), np.int64),
    np.zeros(1, np.int64),
)


@dataclass(frozen=True, eq=False)
class ChartMasks:
    """The masks of several charts, with the arrays of their `Masks` concatenated.

    The *place* of a chart consists of four numbers: its mask, and the page, column and row of the mask's
    lower left cell. All four are -1 if there was no room for the chart.

    Attributes
    ----------
    spans : (#C, 2) int64
        Chart i has the masks from spans[i, 0] to spans[i, 1].
    turns, shapes, origin, blocks, start
        The concatenated attributes of `Masks`.
    """

    spans: IntArray
    turns: ComplexArray
    shapes: IntArray
    origin: ComplexArray
    blocks: IntArray
    start: IntArray

    @classmethod
    def concatenate(cls, masks: Sequence[Masks]) -> ChartMasks:
        """Concatenate the masks of charts."""
        first = Ragged.from_sizes([len(one.turns) for one in masks])
        reached = Ragged.from_sizes([len(one.blocks) for one in masks]).start
        masks = masks or (NO_MASKS,)
        start = np.concatenate([*(one.start[:-1] for one in masks), reached[-1:]])
        start[:-1] += first.repeat(reached[:-1])
        return cls(
            np.stack((first.start[:-1], first.start[1:]), axis=1),
            np.concatenate([one.turns for one in masks]),
            np.concatenate([one.shapes for one in masks]),
            np.concatenate([one.origin for one in masks]),
            np.concatenate([one.blocks for one in masks]),
            start,
        )

    def place(self, side: int, pages: int, spans: IntArray) -> tuple[IntArray, IntArray]:
        """Place charts one after another, each with one of its candidate masks, on at most `pages` pages.

        A page has `side` x `side` cells.

        Returns
        -------
        places : (#spans, 4) int64
        extents : (#pages, 2) int64
            Number of columns, from the left, and rows, from below, that the charts of each page occupy.
        """
        return place_masks(side, pages, spans, self.shapes, self.blocks, self.start)

    def find_taken_cells(self, side: int, places: IntArray) -> BoolArray:
        """Return a mask of the cells, (#pages, side, side), that charts at these places occupy."""
        return occupied_cells(side, places, self.blocks, self.start)


def make_outlines(z: ComplexArray, F: IntArray, vertices: Ragged, area: FloatArray) -> list[Outline]:
    """Return the outlines of charts whose vertices and faces are concatenated."""
    tail, head = F.ravel(), F[:, [1, 2, 0]].ravel()
    key = np.sort((np.minimum(tail, head) * len(z) + np.maximum(tail, head)) * 2 + (tail > head))
    first = np.flatnonzero(np.diff(key // 2, prepend=-1))
    # for each edge: number of triangle sides that run to the higher index, minus number of opposite sides
    net = np.add.reduceat(1 - 2 * (key % 2), first) if len(key) else key
    left = net != 0
    (low, high), net = np.divmod(key[first[left]] // 2, len(z)), net[left]
    start, end = np.where(net > 0, low, high), np.where(net > 0, high, low)
    bounds = np.searchsorted(low, vertices.start)  # edge ranges of charts, as edges are sorted by `low`
    weight = np.abs(net)
    return [
        Outline(z[start[i:j]], z[end[i:j]], weight[i:j], float(a))
        for i, j, a in zip(bounds[:-1].tolist(), bounds[1:].tolist(), area, strict=True)
    ]


def rasterize_outlines(
    outlines: Sequence[Outline],
    turns: Sequence[ComplexArray],
    cells_per_unit: float,
    gap: float,
    aspect: float = 1.0,
) -> list[Masks]:
    """Return the cells that charts touch at each of their rotations, after widening them by half a gap.

    Charts whose masks share no cell are at least `gap` cells apart, in u or in v. The height of a cell is
    `aspect` times its width.
    """
    if not outlines:
        return []
    if aspect != 1:
        return [
            _draw_masks_in_low_cells(outline, by, cells_per_unit, gap, aspect)
            for outline, by in zip(outlines, turns, strict=True)
        ]
    half = _get_half_gap(gap)
    number = [len(by) for by in turns]
    sides = Ragged.from_sizes([len(outline.start) for outline in outlines])
    start, end, weight = (
        np.concatenate(arrays) for arrays in zip(*((o.start, o.end, o.weight) for o in outlines), strict=True)
    )
    of, by = np.repeat(np.arange(len(outlines)), number), np.concatenate(turns) * cells_per_unit
    shapes, low, blocks, begin = rasterize(start, end, weight, sides.start, by, of, half)
    origin, reached = low / cells_per_unit, begin.tolist()
    made = []
    for own_turns, (i, j) in zip(turns, pairwise([0, *np.cumsum(number).tolist()]), strict=True):
        own = blocks[reached[i] : reached[j]]
        made.append(Masks(own_turns, shapes[i:j], origin[i:j], own, begin[i : j + 1] - begin[i]))
    return made


def _get_half_gap(gap: float) -> float:
    """Return half a gap, slightly enlarged to absorb rounding errors."""
    return gap / 2 * (1 + 1e-9) + 1e-9


def _draw_masks_in_low_cells(
    outline: Outline, turns: ComplexArray, cells_per_unit: float, gap: float, aspect: float
) -> Masks:
    """Return the masks of an outline on cells that are not square: rotate it, then scale its height."""
    n, number = len(outline.start), len(turns)
    start, end = (
        _scale_height(np.multiply.outer(turns, ends), aspect).ravel() for ends in (outline.start, outline.end)
    )
    shapes, low, blocks, begin = rasterize(
        start,
        end,
        np.tile(outline.weight, number),
        n * np.arange(number + 1),
        np.full(number, cells_per_unit, dtype=np.complex128),
        np.arange(number),
        _get_half_gap(gap),
    )
    return Masks(turns, shapes, low / cells_per_unit, blocks, begin)


def _scale_height(z: ComplexArray, aspect: float) -> ComplexArray:
    """Scale the height of points so that a page whose height is `aspect` times its width becomes a square."""
    return np.asarray(z.real + 1j * z.imag / aspect)
