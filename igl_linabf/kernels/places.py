"""Where charts' masks go on pages, one after the other, on a grid of cells.

Each goes to the first page that has room for it, and there to where it meets no cell that is taken and the
square that holds all grows least.

The cells are bits: a shift moves the whole page. A run of n cells of the mask is free where n bits in a row
are. `page | page >> 1` has a bit where one of two is taken, the same again with a shift of 2 where one of
four is: so a run takes two shifts, however long it is.

In NumPy a page is one integer, row after row. Equal runs one above the other are one block, by shifts of
rows. The loops keep words of 64 cells, and move a mask up several rows at once. The runs that met taken cells
there come first in the next rows.
"""

import numpy as np

from .._types import Array, BoolArray, IntArray
from .choice import inlined, with_loops
from .gaps import Gaps
from .unsigned import ONE
from .words import EVERY, NONE, WORD, lowest

ROWS = 16  # that a mask moves up at once

Place = tuple[int, int, int]
Placed = tuple[IntArray, IntArray]


@inlined
def _runs_of(blocks: IntArray, power: IntArray, level: int, runs: IntArray) -> int:
    """Fill `runs` with those of a mask; their number.

    Each is its place in a page's words, its column, its length beyond a power of 2, and its row.
    """
    number = 0
    for i in range(len(blocks)):
        j = power[blocks[i, 2]]
        for row in range(blocks[i, 0], blocks[i, 0] + blocks[i, 3]):
            runs[number, 0], runs[number, 1] = j * level + row, blocks[i, 1]
            runs[number, 2], runs[number, 3] = blocks[i, 2] - (1 << j), row
            number += 1
    return number


@inlined
def _meet(busy: Array, high: int, at: int, column: int, more: int, met: Array) -> tuple[np.uint64, np.uint64]:
    """Add to `met`, row by row, where a run meets taken cells; what all rows have then, and what is new.

    The bits are those of the places of the mask, one column after the other.
    """
    behind = column + more
    one, other = at + (column // WORD) * high, at + (behind // WORD) * high
    by, back = np.uint64(column % WORD), np.uint64(WORD - 1 - column % WORD)
    farther, less = np.uint64(behind % WORD), np.uint64(WORD - 1 - behind % WORD)
    every, new, next_ = EVERY, NONE, np.uint64(high)
    for r in range(ROWS):
        i, j, before = np.uint64(one + r), np.uint64(other + r), met[r]
        bits = before | (busy[i] >> by) | ((busy[i + next_] << ONE) << back)
        bits |= (busy[j] >> farther) | ((busy[j + next_] << ONE) << less)
        every &= bits
        new |= bits ^ before
        met[r] = bits
    return every, new


@inlined
def _free(
    busy: Array,
    high: int,
    extent: IntArray,
    runs: IntArray,
    size: int,
    y: int,
    number: int,
    last: int,
    met: Array,
    free: IntArray,
) -> bool:
    """Fill `free`, in so many rows from y on, with the first column up to `last` where a mask meets nothing.

    -1 where there is none; whether there is one in any row. Runs that met cells come first then.
    """
    found = False
    for r in range(ROWS):
        free[r] = -1
    for x in range(0, last + 1, WORD):
        beyond = NONE if last - x >= WORD - 1 else EVERY << np.uint64(last - x + 1)
        for r in range(ROWS):
            met[r] = beyond if r < number and free[r] < 0 else EVERY
        every, useful = beyond, 0
        for i in range(size):
            column = x + runs[i, 1]
            if column >= extent[0] or y + runs[i, 3] >= extent[1]:
                continue
            every, new = _meet(busy, high, runs[i, 0] + y, column, runs[i, 2], met)
            if new != NONE:
                if i != useful:
                    for c in range(4):
                        runs[i, c], runs[useful, c] = runs[useful, c], runs[i, c]
                useful += 1
                if every == EVERY:
                    break
        if every != EVERY:
            found = True
            for r in range(number):
                if met[r] != EVERY:
                    free[r] = x + lowest(~met[r])
    return found


@inlined
def _place(
    busy: Array,
    high: int,
    side: int,
    extent: IntArray,
    shapes: IntArray,
    blocks: IntArray,
    start: IntArray,
    first: int,
    after: int,
    power: IntArray,
    level: int,
    runs: IntArray,
    met: Array,
    free: IntArray,
) -> Place:
    """The best mask, from `first` to before `after`, and where it goes.

    A page has words of `high` rows: first those where a bit is a taken cell; `level` words on, those where
    one of two cells from there is, then one of 4.
    """
    width, height = extent[0], extent[1]
    rows = min(height + shapes[first:after, 0].max(), side)
    columns = min(width + shapes[first:after, 1].max(), side)
    least, rest = side + 1, np.inf  # the square that holds all, and how far out the mask is in it
    mask, best_x, best_y = -1, -1, -1
    for k in range(first, after):
        tall, wide = shapes[k, 0], shapes[k, 1]
        if max(max(tall, height), max(wide, width)) > least:
            continue
        size, low = _runs_of(blocks[start[k] : start[k + 1]], power, level, runs), 0
        while low <= min(rows, least) - tall:
            number, last = min(ROWS, min(rows, least) - tall - low + 1), min(columns, least) - wide
            if max(width, max(height, low + tall)) == least:  # then places far out are no better
                up = (low + tall / 2) ** 2
                if up >= rest:
                    break
                last = min(last, int(np.sqrt(rest - up) - wide / 2))
            if last < 0:
                break
            if _free(busy, high, extent, runs, size, low, number, last, met, free):
                for r in range(number):
                    x, y = free[r], low + r
                    if x < 0:
                        continue
                    square, far = max(x + wide, y + tall), (x + wide / 2) ** 2 + (y + tall / 2) ** 2
                    square = max(square, max(width, height))
                    if square < least or (square == least and far < rest):
                        least, rest, mask, best_x, best_y = square, far, k, x, y
            low += ROWS
    return mask, best_x, best_y


@inlined
def _take(
    busy: Array, high: int, levels: int, words: int, tall: int, blocks: IntArray, x: int, y: int
) -> None:
    """Take the cells of a mask at (x, y)."""
    for i in range(len(blocks)):
        begin, end = x + blocks[i, 1], x + blocks[i, 1] + blocks[i, 2]
        for word in range(begin // WORD, (end - 1) // WORD + 1):
            bits = EVERY
            if word * WORD < begin:
                bits = bits << np.uint64(begin - word * WORD)
            if (word + 1) * WORD > end:
                bits = bits & (EVERY >> np.uint64((word + 1) * WORD - end))
            for row in range(y + blocks[i, 0], y + blocks[i, 0] + blocks[i, 3]):
                busy[word * high + row] |= bits
    for j in range(1, levels):
        far, by = (1 << (j - 1)) // WORD, np.uint64((1 << (j - 1)) % WORD)
        for word in range(words - 1):  # the last one stays free
            at = ((j - 1) * words + word) * high
            to, behind = at + words * high, at + min(far, words - 2 - word) * high
            for row in range(y, y + tall):
                bits = (busy[behind + row] >> by) | (
                    (busy[behind + high + row] << ONE) << (np.uint64(63) - by)
                )
                busy[to + row] = busy[at + row] | bits


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
    longest, most_runs = 1, 0
    for chart in range(len(known), len(spans)):
        for k in range(spans[chart, 0], spans[chart, 1]):
            size = 0
            for i in range(start[k], start[k + 1]):
                longest, size = max(longest, blocks[i, 2]), size + blocks[i, 3]
            most_runs = max(most_runs, size)
    power = np.zeros(longest + 1, dtype=np.int64)
    for length in range(2, longest + 1):
        power[length] = power[length // 2] + 1
    levels, words, high = power[longest] + 1, side // WORD + 2, side + ROWS
    runs = np.empty((most_runs, 4), dtype=np.int64)
    met, free = np.empty(ROWS, dtype=np.uint64), np.empty(ROWS, dtype=np.int64)
    extents = np.zeros((0, 2), dtype=np.int64)
    busy = np.zeros((0, levels * words * high), dtype=np.uint64)
    for chart in range(len(places)):
        page = 0
        while places[chart, 0] < 0:
            if page == number:
                if page == most or (page and not extents[page - 1, 0]):
                    return places, extents[:number]
                if page == len(busy):
                    more = np.zeros((page + 1, levels * words * high), dtype=np.uint64)
                    busy = np.concatenate((busy, more))
                    extents = np.concatenate((extents, np.zeros((page + 1, 2), dtype=np.int64)))
                number += 1
            if chart < len(known):
                k, x, y = known[chart, 0] if known[chart, 1] == page else -1, known[chart, 2], known[chart, 3]
            else:
                k, x, y = _place(
                    busy[page],
                    high,
                    side,
                    extents[page],
                    shapes,
                    blocks,
                    start,
                    spans[chart, 0],
                    spans[chart, 1],
                    power,
                    words * high,
                    runs,
                    met,
                    free,
                )
            if k >= 0:
                _take(busy[page], high, levels, words, shapes[k, 0], blocks[start[k] : start[k + 1]], x, y)
                extents[page, 0] = max(extents[page, 0], x + shapes[k, 1])
                extents[page, 1] = max(extents[page, 1], y + shapes[k, 0])
                places[chart, 0], places[chart, 1], places[chart, 2], places[chart, 3] = k, page, x, y
            page += 1
    return places, extents[:number]


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

    Returns the chart's mask, page, x and y; and the pages' widths and heights that are taken. If `most` pages
    have no room for a chart, or an empty one has none, it and those after it have places of -1.
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
    return places, np.column_stack((widths, heights)).astype(np.int64)


def _taken_cells(side: int, places: IntArray, blocks: IntArray, start: IntArray) -> BoolArray:
    pages = 0
    for chart in range(len(places)):
        pages = max(pages, places[chart, 1] + 1)
    taken = np.zeros((pages, side, side), dtype=np.bool_)
    for chart in range(len(places)):
        k, page, x, y = places[chart, 0], places[chart, 1], places[chart, 2], places[chart, 3]
        for i in range(start[k], start[k + 1]):
            for row in range(y + blocks[i, 0], y + blocks[i, 0] + blocks[i, 3]):
                for column in range(x + blocks[i, 1], x + blocks[i, 1] + blocks[i, 2]):
                    taken[page, row, column] = True
    return taken


@with_loops(_taken_cells)
def taken_cells(side: int, places: IntArray, blocks: IntArray, start: IntArray) -> BoolArray:
    """The cells (#pages, side, side) that charts at their places take, as `placed` gives these."""
    pages = int(places[:, 1].max(initial=-1)) + 1
    change = np.zeros((pages, side + 1, side + 1), dtype=np.int64)
    number = np.diff(start)[places[:, 0]]
    of = np.repeat(np.arange(len(places)), number)
    first = start[:-1][places[:, 0]] - np.cumsum(number) + number
    row, column, length, high = blocks[np.arange(len(of)) + np.repeat(first, number)].T
    page, x, y = places[of, 1:].T
    for rows, by in ((row, 1), (row + high, -1)):
        np.add.at(change, (page, y + rows, x + column), by)
        np.add.at(change, (page, y + rows, x + column + length), -by)
    return np.asarray(change.cumsum(axis=1).cumsum(axis=2)[:, :side, :side] > 0)


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
    gaps, side = Gaps(taken[:rows, :columns]), len(taken)
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
