"""A page's grid of cells, and where on it a chart's mask meets none that is taken.

The cells are the bits of one integer, row after row: a shift moves the whole page. A run of n cells of the
mask is free where n bits in a row are. `page | page >> 1` has a bit where one of two is taken, the same again
with a shift of 2 where one of four is: so a run takes two shifts, however long it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .._types import BoolArray, IntArray


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

    def best_place(self, masks: Sequence[BoolArray]) -> tuple[int, int, int] | None:
        """Which mask, and where (x, y), so that the square of all grows least; None if none has room."""
        square = max(self.width, self.height)
        within = self._best_within(masks, square, square) if square else None
        if within is not None:  # which is all the same to the square: no larger one is searched
            return within
        rows, columns = (max(mask.shape[axis] for mask in masks) for axis in (0, 1))
        return self._best_within(masks, self.width + columns, self.height + rows)

    def _best_within(
        self, masks: Sequence[BoolArray], columns: int, rows: int
    ) -> tuple[int, int, int] | None:
        side = len(self.taken)
        gaps = _Gaps(self.taken[:rows, :columns])
        best: tuple[float, int, int, int] | None = None
        for k, mask in enumerate(masks):
            x, y = gaps.free(mask)
            if not len(x):
                continue
            high, wide = mask.shape
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
        packed = np.packbits(bits, bitorder="little").tobytes()
        self._runs = [int.from_bytes(packed, "little")]  # where a run of 1, 2, 4, ... cells is not free

    def _taken_from(self, power: int) -> int:
        while len(self._runs) <= power:
            last = self._runs[-1]
            self._runs.append(last | (last >> (1 << (len(self._runs) - 1))))
        return self._runs[power]

    def free(self, cells: BoolArray) -> tuple[IntArray, IntArray]:
        """All places (x, y) for the lower left corner of a mask."""
        rows, columns = cells.shape
        up, across = self._rows - rows + 1, self._columns - columns + 1
        if up <= 0 or across <= 0:
            none = np.zeros(0, dtype=np.int64)
            return none, none
        stride = self._columns + 1
        change = np.diff(np.pad(cells, ((0, 0), (1, 1))).astype(np.int8), axis=1)
        row, begin = np.nonzero(change == 1)
        length = np.nonzero(change == -1)[1] - begin
        bad = 0
        for first, n in zip((row * stride + begin).tolist(), length.tolist(), strict=True):
            power = n.bit_length() - 1
            taken = self._taken_from(power)
            bad |= taken >> first
            if n > 1 << power:
                bad |= taken >> (first + n - (1 << power))
        bits = up * stride
        data = (bad & ((1 << bits) - 1)).to_bytes((bits + 7) // 8, "little")
        found = np.unpackbits(np.frombuffer(data, np.uint8), count=bits, bitorder="little")
        y, x = np.nonzero(found.reshape(up, stride)[:, :across] == 0)
        return x, y
