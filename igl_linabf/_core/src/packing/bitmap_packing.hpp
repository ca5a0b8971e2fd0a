// Greedy placement of the masks of charts on pages, on a grid of cells.
//
// Each mask goes to the first page with enough free space,
// and there to the free position that enlarges the bounding square of all masks least.
//
// Cells are bits in words of 64.
// `page | page >> 1` has a bit where one of two adjacent cells is occupied; with a shift of 2,
// this gives the bits of four cells, and so on.
// Therefore, two lookups suffice for a run of any length.
// Several rows are tested at once.
// Runs that collided with occupied cells are tested first in the next rows.
#pragma once
#include <array>

#include "cells.hpp"

namespace packing {

constexpr Index ROWS_AT_ONCE = 16;  // number of rows of a page that are tested together

// The masks of a chart: `first` to `after` - 1.
struct Span {
    Index first, after;
};

struct Placement {
    Index mask, page, x, y;
};

struct PageExtent {
    Index width, height;
};

// A run of occupied cells in a row of a mask.
// `at` is the position of its row among the words of a page,
// and `more` is its length minus the largest power of 2 that is at most its length.
struct Run {
    Index at, column, more, row;
};

// The cells of a page: `levels` times `words` columns of `high` words, one word for each row.
// A bit of level j is set if one of the 2^j cells that start at this bit is occupied.
// The last words of a row are always free.
struct Page {
    Index words, high, levels;
    std::vector<Word> busy;
    Index width = 0, height = 0;  // extents of the occupied part, in cells

    Page(Index side, Index levels)
        : words(side / WORD_BITS + 2), high(side + ROWS_AT_ONCE), levels(levels), busy(levels * words * high) {}
};

// Bit masks of columns: columns with a collision in every row, and columns with a new collision in some row.
struct Collisions {
    Word every, fresh;
};

// Set the bits of `met`, one word for each row, if a run collides with occupied cells.
// Each bit stands for a mask that is shifted to another column.
inline Collisions find_collisions(const Page& page, Index at, Index column, Index more, Word* __restrict met) {
    const Index behind = column + more;
    const Word* const one = page.busy.data() + at + column / WORD_BITS * page.high;
    const Word* const other = page.busy.data() + at + behind / WORD_BITS * page.high;
    const Word *const one_next = one + page.high, *const other_next = other + page.high;
    const int by = int(column % WORD_BITS), farther = int(behind % WORD_BITS);
    Word every = ALL_BITS, fresh = NO_BITS;
    INDEPENDENT
    for (Index r = 0; r < ROWS_AT_ONCE; ++r) {
        const Word before = met[r];
        const Word bits = before | one[r] >> by | one_next[r] << 1 << (63 - by) | other[r] >> farther |
                          other_next[r] << 1 << (63 - farther);
        every &= bits;
        fresh |= bits ^ before;
        met[r] = bits;
    }
    return {every, fresh};
}

// For `number` rows from y on, store in `free` the first column where a mask can be placed without a collision.
// The column is -1 if the mask collides in every column up to `last`.
// Returns true if any row has a free column.
// Runs of the mask that collided are moved to the front, so that they are tested first.
inline bool find_first_free(const Page& page, View<Run> runs, Index y, Index number, Index last, Index* free) {
    bool found = false;
    std::fill_n(free, ROWS_AT_ONCE, -1);
    for (Index x = 0; x <= last; x += WORD_BITS) {
        const Word beyond = last - x >= WORD_BITS - 1 ? NO_BITS : ALL_BITS << (last - x + 1);
        Word met[ROWS_AT_ONCE], every = ALL_BITS;
        for (Index r = 0; r < ROWS_AT_ONCE; ++r) every &= met[r] = r < number && free[r] < 0 ? beyond : ALL_BITS;
        if (every == ALL_BITS) break;
        Index useful = 0;
        for (Index i = 0; i < runs.size && every != ALL_BITS; ++i) {
            const Index column = x + runs[i].column;
            if (column >= page.width || y + runs[i].row >= page.height) continue;
            const Collisions now = find_collisions(page, runs[i].at + y, column, runs[i].more, met);
            if (now.fresh == NO_BITS) continue;
            every = now.every;
            std::swap(runs[i], runs[useful++]);
        }
        if (every == ALL_BITS) continue;
        found = true;
        for (Index r = 0; r < number; ++r)
            if (met[r] != ALL_BITS) free[r] = x + lowest_bit(~met[r]);
    }
    return found;
}

// Find the best mask of a chart and its position: the bounding square of all masks is smallest,
// and among equal squares the mask is nearest to the origin.
// The mask is -1 if no mask fits.
inline Placement find_best_place(const Page& page, Index side, Span span, View<const Shape> shapes,
                                 View<const CellBlock> blocks, View<const Index> start, std::vector<Run>& runs) {
    const Index taken = std::max(page.width, page.height);
    Index least = side + 1, free[ROWS_AT_ONCE];
    double rest = INFINITY;  // squared distance of the centre of the mask from the origin
    Placement best{-1, -1, -1, -1};
    for (Index k = span.first; k < span.after; ++k) {
        const auto [tall, wide] = shapes[k];
        if (std::max({tall, wide, taken}) > least) continue;
        runs.clear();
        for (const CellBlock& block : blocks.part(start[k], start[k + 1])) {
            const Index power = floor_log2(block.length), level = power * page.words * page.high;
            for (Index row = block.row; row < block.row + block.height; ++row)
                runs.push_back({level + row, block.column, block.length - (Index(1) << power), row});
        }
        for (Index low = 0;; low += ROWS_AT_ONCE) {
            const Index rows = std::min({page.height + tall, side, least}) - tall - low + 1;
            if (rows <= 0) break;
            Index last = std::min({page.width + wide, side, least}) - wide;
            if (std::max(taken, low + tall) == least) {  // only a position nearer to the origin is better
                const double up = (double(low) + double(tall) / 2) * (double(low) + double(tall) / 2);
                if (up >= rest) break;
                last = Index(std::min(double(last), std::sqrt(rest - up) - double(wide) / 2));
            }
            if (last < 0) break;
            const Index number = std::min(ROWS_AT_ONCE, rows);
            if (!find_first_free(page, runs, low, number, last, free)) continue;
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

// Occupy the cells of a mask at (x, y).
inline void occupy(Page& page, Shape shape, View<const CellBlock> blocks, Index x, Index y) {
    const Index high = page.high, words = page.words;
    for (const CellBlock& block : blocks) {
        const Index begin = x + block.column, end = begin + block.length;
        for (Index word = begin / WORD_BITS; word * WORD_BITS < end; ++word) {
            Word bits = ALL_BITS;
            if (word * WORD_BITS < begin) bits <<= begin - word * WORD_BITS;
            if ((word + 1) * WORD_BITS > end) bits &= ALL_BITS >> ((word + 1) * WORD_BITS - end);
            Word* const to = page.busy.data() + word * high + y + block.row;
            for (Index row = 0; row < block.height; ++row) to[row] |= bits;
        }
    }
    for (Index j = 1; j < page.levels; ++j) {
        const Index far = (Index(1) << (j - 1)) / WORD_BITS;
        const int by = int((Index(1) << (j - 1)) % WORD_BITS);
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

// Place charts on square pages with `side` by `side` cells, each by one of its masks.
// If a chart does not fit on an empty page or on `most` pages, this chart and all later ones are not placed.
inline std::tuple<std::vector<Placement>, std::vector<PageExtent>> place_masks(
    Index side, Index most, View<const Span> spans, View<const Shape> shapes, View<const CellBlock> blocks,
    View<const Index> start) {
    std::vector<Placement> places(spans.size, Placement{-1, -1, -1, -1});
    Index longest = 1;
    for (Index chart = 0; chart < spans.size; ++chart)
        for (Index k = spans[chart].first; k < spans[chart].after; ++k)
            for (const CellBlock& block : blocks.part(start[k], start[k + 1]))
                longest = std::max(longest, block.length);
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
            Placement to = find_best_place(on, side, spans[chart], shapes, blocks, start, runs);
            if (to.mask < 0) continue;
            to.page = page;
            const Shape shape = shapes[to.mask];
            occupy(on, shape, blocks.part(start[to.mask], start[to.mask + 1]), to.x, to.y);
            on.width = std::max(on.width, to.x + shape.columns);
            on.height = std::max(on.height, to.y + shape.rows);
            places[chart] = to;
        }
    }
    std::vector<PageExtent> extents;
    for (const Page& page : pages) extents.push_back({page.width, page.height});
    return {std::move(places), std::move(extents)};
}

// Return a mask of the cells, (#pages, side, side), that placed charts occupy.
inline Squares<bool> occupied_cells(Index side, View<const Placement> places, View<const CellBlock> blocks,
                                    View<const Index> start) {
    Index pages = 0;
    for (const Placement& place : places) pages = std::max(pages, place.page + 1);
    Squares<bool> taken(pages * side, side);
    std::fill_n(taken.data(), taken.size(), false);
    for (const Placement& place : places)
        for (const CellBlock& block : blocks.part(start[place.mask], start[place.mask + 1]))
            for (Index row = block.row; row < block.row + block.height; ++row) {
                bool* const cells = taken.data() + (place.page * side + place.y + row) * side + place.x;
                std::fill_n(cells + block.column, block.length, true);
            }
    return taken;
}

// Place rectangles on shelves of a square page with occupied cells,
// and return the lower left corners of the rectangles that fit.
// A shelf is as high as its first rectangle, and resumes after occupied cells.
inline std::vector<std::array<double, 2>> pack_shelves(Matrix<const double> sizes, Matrix<const bool> taken) {
    const Index side = taken.rows, n = sizes.rows;
    const Array<std::int32_t> above(side + 1, side);  // number of consecutive free cells from each cell upwards
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
