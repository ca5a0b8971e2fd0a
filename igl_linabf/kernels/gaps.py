"""Where masks fit on a page of which some cells are taken, in NumPy: the page is one long integer."""

import numpy as np

from .._types import BoolArray, IntArray


class Gaps:
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

    def free(self, rows: int, columns: int, blocks: list[list[int]]) -> tuple[IntArray, IntArray]:
        """Places (x, y) for the lower left corner of a mask, from which it goes no further left or down.

        The others are never the best: each is farther out than one of these.
        """
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
        for tried, (row, begin, length, high) in enumerate(blocks):
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
