"""A page's grid of cells, and where on it a chart's mask meets none that is taken.

The cells are the bits of one integer, row after row: a shift moves the whole page. A run of n cells of the
mask is free where n bits in a row are. `page | page >> 1` has a bit where one of two is taken, the same again
with a shift of 2 where one of four is: so a run takes two shifts, however long it is. Equal runs one above
the other are one block, by shifts of rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .._types import BoolArray, IntArray
from .outlines import Mask


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

    def best_place(self, masks: Sequence[Mask]) -> tuple[int, int, int] | None:
        """Which mask, and where (x, y), so that the square of all grows least; None if none has room."""
        square = max(self.width, self.height)
        within = self._best_within(masks, square, square) if square else None
        if within is not None:  # which is all the same to the square: no larger one is searched
            return within
        rows, columns = (max(mask.cells.shape[axis] for mask in masks) for axis in (0, 1))
        return self._best_within(masks, self.width + columns, self.height + rows)

    def _best_within(self, masks: Sequence[Mask], columns: int, rows: int) -> tuple[int, int, int] | None:
        side = len(self.taken)
        gaps = _Gaps(self.taken[:rows, :columns])
        best: tuple[float, int, int, int] | None = None
        for k, mask in enumerate(masks):
            x, y = gaps.free(mask)
            if not len(x):
                continue
            high, wide = mask.cells.shape
            square = np.maximum(np.maximum(x + wide, self.width), np.maximum(y + high, self.height))
            cost = square * (8.0 * side**2) + (x + wide / 2) ** 2 + (y + high / 2) ** 2
            at = int(cost.argmin())
            if best is None or cost[at] < best[0]:
                best = float(cost[at]), k, int(x[at]), int(y[at])
        return None if best is None else best[1:]


class _Gaps:
    """Where masks fit on cells some of which are taken."""

    def __init__(self, taken: BoolArray) -> None:
        self._rows, self._columns = taken.shape
        bits = np.ones((self._rows, self._columns + 1), dtype=bool)  # a last column ends each row
        bits[:, :-1] = taken
        self._runs = [_number(bits)]  # where a run of 1, 2, 4, ... cells is not free
        self._of_block: dict[tuple[int, int], int] = {}

    def _taken_from(self, length: int, rows: int) -> int:
        """Where a block of runs of this length is not free."""
        known = self._of_block.get((length, rows))
        if known is None:
            if rows > 1:
                half = (rows + 1) // 2
                known = self._taken_from(length, half)
                known |= known >> ((rows - half) * (self._columns + 1))
            else:
                power = length.bit_length() - 1
                while len(self._runs) <= power:
                    last = self._runs[-1]
                    self._runs.append(last | (last >> (1 << (len(self._runs) - 1))))
                known = self._runs[power]
                if length > 1 << power:
                    known |= known >> (length - (1 << power))
            self._of_block[length, rows] = known
        return known

    def free(self, mask: Mask) -> tuple[IntArray, IntArray]:
        """Places (x, y) for the lower left corner of a mask, from which it goes no further left or down.

        The others are never the best: each is farther out than one of these.
        """
        rows, columns = mask.cells.shape
        up, across = self._rows - rows + 1, self._columns - columns + 1
        if up <= 0 or across <= 0:
            none = np.zeros(0, dtype=np.int64)
            return none, none
        stride = self._columns + 1
        bits = up * stride
        every = (1 << bits) - 1
        outside = np.zeros((up, stride), dtype=bool)
        outside[:, across:] = True
        bad, most = _number(outside), 4
        for tried, (row, begin, length, high) in enumerate(mask.blocks):
            if tried == most:  # the longest come first: mostly they tell that there is no place
                if bad & every == every:
                    break
                most *= 2
            bad |= self._taken_from(length, high) >> (row * stride + begin)
        free = every ^ (bad & every)
        corner = free ^ (free & (free << 1 | free << stride))
        data = np.frombuffer(corner.to_bytes((bits + 7) // 8, "little"), np.uint8)
        byte = np.flatnonzero(data)
        of_byte, bit = np.nonzero(np.unpackbits(data[byte, None], axis=1, bitorder="little"))
        y, x = np.divmod(8 * byte[of_byte] + bit, stride)
        return x, y


def _number(bits: BoolArray) -> int:
    """Bits as one integer, row after row."""
    return int.from_bytes(np.packbits(bits, bitorder="little").tobytes(), "little")
