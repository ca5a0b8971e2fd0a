"""Where charts' masks go on pages, one after the other, on a grid of cells.

Each goes to the first page that has room for it, and there to where it meets no cell that is taken and the
square that holds all grows least.

In NumPy, the cells are the bits of one integer, row after row: a shift moves the whole page. A run of n
cells of the mask is free where n bits in a row are. `page | page >> 1` has a bit where one of two is taken,
the same again with a shift of 2 where one of four is: so a run takes two shifts, however long it is. Equal
runs one above the other are one block, by shifts of rows.
"""

import numpy as np

from .._types import BoolArray, IntArray
from .choice import inlined, with_loops

FREE = 1 << 14  # cells in a row: more than any page has

Place = tuple[int, int, int]
Placed = tuple[IntArray, IntArray, BoolArray]


@inlined
def _behind(ahead: IntArray, column: int, length: int) -> int:
    """How far a run of cells must move on to behind the first taken ones that it meets; 0 if it is free."""
    if ahead[column] >= length:
        return 0
    free = max(ahead[column], 0)
    return int(free - ahead[column + free])


@inlined
def _place(
    ahead: IntArray,
    extent: IntArray,
    shapes: IntArray,
    blocks: IntArray,
    start: IntArray,
    first: int,
    after: int,
) -> Place:
    """The best mask, from `first` to before `after`, and where it goes.

    `ahead` is the number of cells from each cell to the right that are free; negative, of those that are not.
    """
    side, width, height = len(ahead), extent[0], extent[1]
    rows = min(height + shapes[first:after, 0].max(), side)
    columns = min(width + shapes[first:after, 1].max(), side)
    best, mask, best_x, best_y = np.inf, -1, -1, -1
    longest = 8.0 * side**2  # is more than all that squares are alike in
    for k in range(first, after):
        high, wide = shapes[k, 0], shapes[k, 1]
        block, above = start[k], blocks[start[k], 0]  # whose row, so far above y, met taken cells last
        for y in range(rows - high + 1):
            x, tall, up = 0, max(width, max(y + high, height)), (y + high / 2) ** 2
            while x + wide <= columns:
                cost = max(x + wide, tall) * longest + (x + wide / 2) ** 2 + up
                if cost >= best:  # and so is all that is further right
                    break
                if y + above < height and x + blocks[block, 1] < width:
                    step = _behind(ahead[y + above], x + blocks[block, 1], blocks[block, 2])
                    if step:  # as mostly: charts have thick limbs
                        x += step
                        continue
                step = 0
                for i in range(start[k], start[k + 1]):
                    column, lowest = x + blocks[i, 1], y + blocks[i, 0]
                    if column >= width:
                        continue
                    for row in range(lowest, min(lowest + blocks[i, 3], height)):
                        step = _behind(ahead[row], column, blocks[i, 2])
                        if step:
                            block, above = i, row - y
                            break
                    if step:
                        break
                if not step:
                    best, mask, best_x, best_y = cost, k, x, y
                    break
                x += step
            if x == 0:  # it has a place there, or costs too much, and so does all that is further up
                break
    return mask, best_x, best_y


@inlined
def _take(ahead: IntArray, shape: IntArray, blocks: IntArray, x: int, y: int) -> None:
    """Take the cells of a mask at (x, y)."""
    high, wide = shape
    for i in range(len(blocks)):
        for row in range(y + blocks[i, 0], y + blocks[i, 0] + blocks[i, 3]):
            ahead[row, x + blocks[i, 1] : x + blocks[i, 1] + blocks[i, 2]] = -1
    for row in range(y, y + high):
        there = ahead[row, x + wide] if x + wide < len(ahead) else FREE
        for column in range(x + wide - 1, -1, -1):
            there = min(there, 0) - 1 if ahead[row, column] < 0 else max(there, 0) + 1
            ahead[row, column] = there


def _placed(
    side: int,
    most: int,
    spans: IntArray,
    shapes: IntArray,
    blocks: IntArray,
    start: IntArray,
    known: IntArray,
) -> Placed:
    places, number = np.full((len(spans), 4), -1, dtype=np.int64), 0
    extents, ahead = np.zeros((0, 2), dtype=np.int64), np.empty((0, side, side), dtype=np.int16)
    for chart in range(len(places)):
        page = 0
        while places[chart, 0] < 0:
            if page == number:
                if page == most or (page and not extents[page - 1, 0]):
                    return places, extents[:number], ahead[:number] < 0
                if page == len(ahead):
                    ahead = np.concatenate((ahead, np.empty((page + 1, side, side), dtype=np.int16)))
                    extents = np.concatenate((extents, np.zeros((page + 1, 2), dtype=np.int64)))
                for row in range(side):
                    for column in range(side):
                        ahead[page, row, column] = FREE + side - column
                number += 1
            if chart < len(known):
                k, x, y = known[chart, 0] if known[chart, 1] == page else -1, known[chart, 2], known[chart, 3]
            else:
                k, x, y = _place(
                    ahead[page], extents[page], shapes, blocks, start, spans[chart, 0], spans[chart, 1]
                )
            if k >= 0:
                _take(ahead[page], shapes[k], blocks[start[k] : start[k + 1]], x, y)
                extents[page, 0] = max(extents[page, 0], x + shapes[k, 1])
                extents[page, 1] = max(extents[page, 1], y + shapes[k, 0])
                places[chart, 0], places[chart, 1], places[chart, 2], places[chart, 3] = k, page, x, y
            page += 1
    return places, extents[:number], ahead[:number] < 0


@with_loops(_placed)
def placed(
    side: int,
    most: int,
    spans: IntArray,
    shapes: IntArray,
    blocks: IntArray,
    start: IntArray,
    known: IntArray,
) -> Placed:
    """Charts on square pages with `side` cells along a side; each has several masks, one of which is chosen.

    Those of chart i are from `spans[i, 0]` to `spans[i, 1]`; `shapes` are their rows and columns. Mask k has
    the `blocks` from `start[k]` to `start[k + 1]`: the first row and column, the length and the number of
    rows of equal runs of cells, the largest ones first. The places of the first charts may be `known`.

    Returns the chart's mask, page, x and y; the pages' widths and heights that are taken, and their cells
    that are. If `most` pages have no room for a chart, or an empty one has none, it and those after it have
    places of -1.
    """
    places, taken = np.full((len(spans), 4), -1, dtype=np.int64), list[BoolArray]()
    widths, heights = list[int](), list[int]()
    for chart in range(len(places)):
        page = 0
        first, after = spans[chart].tolist()
        while places[chart, 0] < 0:
            if page == len(taken):
                if page == most or (page and not widths[-1]):
                    break
                taken.append(np.zeros((side, side), dtype=bool))
                widths.append(0)
                heights.append(0)
            if chart < len(known):
                k, on, x, y = known[chart].tolist()
                k = k if on == page else -1
            else:
                k, x, y = _best_place(
                    taken[page],
                    widths[page],
                    heights[page],
                    shapes[first:after],
                    blocks,
                    start[first : after + 1],
                )
                k += first if k >= 0 else 0
            if k >= 0:
                for row, column, length, high in blocks[start[k] : start[k + 1]].tolist():
                    taken[page][y + row : y + row + high, x + column : x + column + length] = True
                widths[page] = max(widths[page], x + int(shapes[k, 1]))
                heights[page] = max(heights[page], y + int(shapes[k, 0]))
                places[chart] = k, page, x, y
            page += 1
        if places[chart, 0] < 0:
            break
    extents = np.column_stack((widths, heights)).astype(np.int64)
    return places, extents, np.array(taken, dtype=bool).reshape(-1, side, side)


def _best_place(
    taken: BoolArray, width: int, height: int, shapes: IntArray, blocks: IntArray, start: IntArray
) -> Place:
    """Which mask, and where (x, y), so that the square that holds all grows least; -1 if none has room."""
    square = max(width, height)
    if square:
        found = _best_within(taken, width, height, square, square, shapes, blocks, start)
        if found[0] >= 0:  # which is all the same to the square: no larger one is searched
            return found
    rows, columns = height + int(shapes[:, 0].max()), width + int(shapes[:, 1].max())
    return _best_within(taken, width, height, columns, rows, shapes, blocks, start)


def _best_within(
    taken: BoolArray,
    width: int,
    height: int,
    columns: int,
    rows: int,
    shapes: IntArray,
    blocks: IntArray,
    start: IntArray,
) -> Place:
    gaps, side = _Gaps(taken[:rows, :columns]), len(taken)
    least, best = np.inf, (-1, -1, -1)
    for k, (high, wide) in enumerate(shapes.tolist()):
        x, y = gaps.free(high, wide, blocks[start[k] : start[k + 1]].tolist())
        if not len(x):
            continue
        square = np.maximum(np.maximum(x + wide, width), np.maximum(y + high, height))
        cost = square * (8.0 * side**2) + (x + wide / 2) ** 2 + (y + high / 2) ** 2
        at = int(cost.argmin())
        if cost[at] < least:
            least, best = float(cost[at]), (k, int(x[at]), int(y[at]))
    return best


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
