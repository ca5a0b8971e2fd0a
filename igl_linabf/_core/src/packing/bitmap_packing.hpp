// Where charts' masks go on pages, one after the other, on a grid of cells.
//
// Each goes to the first page that has room for it, and there to where it meets no cell that is taken and the square
// that holds all grows least.
//
// The cells are bits, words of 64 in a row. `page | page >> 1` has a bit where one of two cells is taken, the same
// again with a shift of 2 where one of four is: so a run of n cells is looked up by two of them, however long it is.
// A mask moves up several rows at once. The runs that met taken cells there come first in the next rows.
#pragma once
#include <array>

#include "cells.hpp"

namespace packing {

constexpr Index TOGETHER = 16;  // rows that a mask moves up at once

struct Span {  // masks of a chart
    Index first, after;
};

struct Place {
    Index mask, page, x, y;
};

struct Extent {
    Index width, height;
};

// A run of cells of a mask: its place in a page's words, and its length beyond a power of 2.
struct Run {
    Index at, column, more, row;
};

// A page's cells: `levels` times `words` columns of words, `high` to a column, one for each row. Level j has a bit
// where one of the 2^j cells from there is taken. The last words of a row stay free.
struct Page {
    Index words, high, levels;
    std::vector<Word> busy;
    Index width = 0, height = 0;  // that are taken

    Page(Index side, Index levels)
        : words(side / WORD + 2), high(side + TOGETHER), levels(levels), busy(levels * words * high) {}
};

// Bits of columns: those of all rows, and those that are new in a row.
struct Met {
    Word every, fresh;
};

// Add to `met`, row by row, where a run meets taken cells. The bits are the places of the mask, column by column.
inline Met meet(const Page& page, Index at, Index column, Index more, Word* __restrict met) {
    const Index behind = column + more;
    const Word* const one = page.busy.data() + at + column / WORD * page.high;
    const Word* const other = page.busy.data() + at + behind / WORD * page.high;
    const Word *const one_next = one + page.high, *const other_next = other + page.high;
    const int by = int(column % WORD), farther = int(behind % WORD);
    Word every = EVERY, fresh = NONE;
    INDEPENDENT
    for (Index r = 0; r < TOGETHER; ++r) {
        const Word before = met[r];
        const Word bits = before | one[r] >> by | one_next[r] << 1 << (63 - by) | other[r] >> farther |
                          other_next[r] << 1 << (63 - farther);
        every &= bits;
        fresh |= bits ^ before;
        met[r] = bits;
    }
    return {every, fresh};
}

// Fill `free`, in `number` rows from y on, with the first column up to `last` where a mask meets nothing, or -1;
// whether there is one in any row. Runs that met cells come first then.
inline bool first_free(const Page& page, View<Run> runs, Index y, Index number, Index last, Index* free) {
    bool found = false;
    std::fill_n(free, TOGETHER, -1);
    for (Index x = 0; x <= last; x += WORD) {
        const Word beyond = last - x >= WORD - 1 ? NONE : EVERY << (last - x + 1);
        Word met[TOGETHER], every = EVERY;
        for (Index r = 0; r < TOGETHER; ++r) every &= met[r] = r < number && free[r] < 0 ? beyond : EVERY;
        if (every == EVERY) break;
        Index useful = 0;
        for (Index i = 0; i < runs.size && every != EVERY; ++i) {
            const Index column = x + runs[i].column;
            if (column >= page.width || y + runs[i].row >= page.height) continue;
            const Met now = meet(page, runs[i].at + y, column, runs[i].more, met);
            if (now.fresh == NONE) continue;
            every = now.every;
            std::swap(runs[i], runs[useful++]);
        }
        if (every == EVERY) continue;
        found = true;
        for (Index r = 0; r < number; ++r)
            if (met[r] != EVERY) free[r] = x + lowest_bit(~met[r]);
    }
    return found;
}

// The best mask of a span, and where it goes: to the smallest square, and in it to the corner at 0. Mask -1: to none.
inline Place best_place(const Page& page, Index side, Span span, View<const Shape> shapes, View<const Block> blocks,
                        View<const Index> start, std::vector<Run>& runs) {
    const Index taken = std::max(page.width, page.height);
    Index least = side + 1, free[TOGETHER];
    double rest = INFINITY;  // how far out the middle of the mask is, squared
    Place best{-1, -1, -1, -1};
    for (Index k = span.first; k < span.after; ++k) {
        const auto [tall, wide] = shapes[k];
        if (std::max({tall, wide, taken}) > least) continue;
        runs.clear();
        for (const Block& block : blocks.part(start[k], start[k + 1])) {
            const Index power = floor_log2(block.length), level = power * page.words * page.high;
            for (Index row = block.row; row < block.row + block.height; ++row)
                runs.push_back({level + row, block.column, block.length - (Index(1) << power), row});
        }
        for (Index low = 0;; low += TOGETHER) {
            const Index rows = std::min({page.height + tall, side, least}) - tall - low + 1;
            if (rows <= 0) break;
            Index last = std::min({page.width + wide, side, least}) - wide;
            if (std::max(taken, low + tall) == least) {  // then places far out are no better
                const double up = (double(low) + double(tall) / 2) * (double(low) + double(tall) / 2);
                if (up >= rest) break;
                last = Index(std::min(double(last), std::sqrt(rest - up) - double(wide) / 2));
            }
            if (last < 0) break;
            const Index number = std::min(TOGETHER, rows);
            if (!first_free(page, runs, low, number, last, free)) continue;
            for (Index r = 0; r < number; ++r) {
                const Index x = free[r], y = low + r;
                if (x < 0) continue;
                const Index square = std::max({x + wide, y + tall, taken});
                const double u = double(x) + double(wide) / 2, v = double(y) + double(tall) / 2;
                if (square < least || (square == least && u * u + v * v < rest)) {
                    least = square, rest = u * u + v * v;
                    best = {k, -1, x, y};
                }
            }
        }
    }
    return best;
}

// Take the cells of a mask at (x, y).
inline void take(Page& page, Shape shape, View<const Block> blocks, Index x, Index y) {
    const Index high = page.high, words = page.words;
    for (const Block& block : blocks) {
        const Index begin = x + block.column, end = begin + block.length;
        for (Index word = begin / WORD; word * WORD < end; ++word) {
            Word bits = EVERY;
            if (word * WORD < begin) bits <<= begin - word * WORD;
            if ((word + 1) * WORD > end) bits &= EVERY >> ((word + 1) * WORD - end);
            Word* const to = page.busy.data() + word * high + y + block.row;
            for (Index row = 0; row < block.height; ++row) to[row] |= bits;
        }
    }
    for (Index j = 1; j < page.levels; ++j) {
        const Index far = (Index(1) << (j - 1)) / WORD;
        const int by = int((Index(1) << (j - 1)) % WORD);
        for (Index word = 0; word < words - 1; ++word) {
            const Word* const from = page.busy.data() + ((j - 1) * words + word) * high + y;
            const Word* const behind = from + std::min(far, words - 2 - word) * high;
            Word* const to = page.busy.data() + (j * words + word) * high + y;
            INDEPENDENT
            for (Index row = 0; row < shape.rows; ++row)
                to[row] = from[row] | behind[row] >> by | behind[high + row] << 1 << (63 - by);
        }
    }
}

// Charts on square pages with `side` cells along a side, each by one of its masks; the places of the first ones are
// known. Where `most` pages have no room for a chart, or an empty one has none, it and those after it have none.
inline std::tuple<std::vector<Place>, std::vector<Extent>> place_masks(Index side, Index most, View<const Span> spans,
                                                                  View<const Shape> shapes, View<const Block> blocks,
                                                                  View<const Index> start, View<const Place> known) {
    std::vector<Place> places(spans.size, Place{-1, -1, -1, -1});
    Index longest = 1;
    for (Index chart = known.size; chart < spans.size; ++chart)
        for (Index k = spans[chart].first; k < spans[chart].after; ++k)
            for (const Block& block : blocks.part(start[k], start[k + 1])) longest = std::max(longest, block.length);
    const Index levels = floor_log2(longest) + 1;
    std::vector<Page> pages;
    std::vector<Run> runs;
    bool done = false;
    for (Index chart = 0; chart < spans.size && !done; ++chart) {
        for (Index page = 0; places[chart].mask < 0; ++page) {
            if (page == Index(pages.size())) {
                if ((done = page == most || (page && !pages.back().width))) break;
                pages.emplace_back(side, levels);
            }
            Page& on = pages[page];
            const bool is_known = chart < known.size;
            Place to = is_known ? known[chart] : best_place(on, side, spans[chart], shapes, blocks, start, runs);
            if (to.mask < 0 || (is_known && to.page != page)) continue;
            to.page = page;
            const Shape shape = shapes[to.mask];
            take(on, shape, blocks.part(start[to.mask], start[to.mask + 1]), to.x, to.y);
            on.width = std::max(on.width, to.x + shape.columns);
            on.height = std::max(on.height, to.y + shape.rows);
            places[chart] = to;
        }
    }
    std::vector<Extent> extents;
    for (const Page& page : pages) extents.push_back({page.width, page.height});
    return {std::move(places), std::move(extents)};
}

// The cells, (#pages, side, side), that charts at their places take.
inline Squares<bool> taken_cells(Index side, View<const Place> places, View<const Block> blocks,
                                 View<const Index> start) {
    Index pages = 0;
    for (const Place& place : places) pages = std::max(pages, place.page + 1);
    Squares<bool> taken(pages * side, side);
    std::fill_n(taken.data(), taken.size(), false);
    for (const Place& place : places)
        for (const Block& block : blocks.part(start[place.mask], start[place.mask + 1]))
            for (Index row = block.row; row < block.row + block.height; ++row) {
                bool* const cells = taken.data() + (place.page * side + place.y + row) * side + place.x;
                std::fill_n(cells + block.column, block.length, true);
            }
    return taken;
}

// Lower left corners of as many rectangles as find a place on a square page of which some cells are taken. A shelf is
// as high as its first rectangle; where cells are taken, it goes on behind them.
inline std::vector<std::array<double, 2>> on_shelves(Matrix<const double> sizes, Matrix<const bool> taken) {
    const Index side = taken.rows, n = sizes.rows;
    const Array<std::int32_t> above(side + 1, side);  // cells that are free from each one upwards
    std::fill_n(above.data() + side * side, side, 0);
    for (Index row = side; row--;) {
        std::int32_t *const own = above.data() + row * side, *const next = own + side;
        INDEPENDENT
        for (Index column = 0; column < side; ++column) {
            const std::int32_t more = next[column] + 1;
            own[column] = taken[row][column] ? 0 : more;
        }
    }
    std::vector<double> end(n + 1);
    for (Index i = 0; i < n; ++i) end[i + 1] = end[i] + sizes[i][0];
    std::vector<std::array<double, 2>> places;
    double bottom = 0;
    for (Index first = 0; first < n;) {
        const double height = sizes[first][1];
        if (!(height >= 0 && bottom + height <= double(side))) break;
        const Index row = Index(bottom), rows = Index(std::ceil(bottom + height)) - row, before = first;
        const std::int32_t* const over = above.data() + row * side;
        for (Index left = 0; left < side && first < n;) {
            if (over[left] < rows) {
                ++left;
                continue;
            }
            Index right = left + 1;
            while (right < side && over[right] >= rows) ++right;
            const Index begin = first;
            for (; first < n && end[first + 1] <= end[begin] + double(right - left); ++first)
                places.push_back({double(left) + end[first] - end[begin], bottom});
            left = right;
        }
        bottom = first > before ? bottom + height : std::floor(bottom) + 1;
    }
    return places;
}

}  // namespace packing
