// Rasterization of outlines: the grid cells that they touch, as rectangular blocks of cells.
#pragma once
#include <cstdlib>
#include <new>
#include <stdexcept>

#include "cells.hpp"

namespace packing {

constexpr std::uint32_t WINDING_UNIT = 1 << 16;  // one winding in the counter of a cell; the lower 16 bits count sides
constexpr double MAX_MASK_CELLS = 1e15;  // maximum number of cells of a mask; exact in double precision

// A buffer of zeros. Because of calloc, memory pages that are never written to are not allocated.
template <class T>
class Zeros {
    struct Free {
        void operator()(T* data) const { std::free(data); }
    };
    std::unique_ptr<T, Free> held;
    Index size = 0;

  public:
    // Return a buffer of at least `wanted` zeros; the caller must have cleared the previous contents.
    T* reserve(Index wanted) {
        if (wanted > size) {
            held.reset(static_cast<T*>(std::calloc(std::size_t(2 * wanted), sizeof(T))));
            size = held ? 2 * wanted : 0;
            if (!held) throw std::bad_alloc();
        }
        return held.get();
    }
};

// The changes of a counter from each cell of a row to the next cell, and a bitmap of the cells with changes.
// Each row has one additional column at its end.
struct CellChanges {
    std::uint32_t* change;
    Word* marks;
    Index rows, columns, words;

    void add(Index row, Index column, std::uint32_t by) const {
        change[row * (columns + 1) + column] += by;
        marks[row * words + (column >> 6)] |= Word(1) << (column & 63);
    }
};

// Return the floor or the ceiling of a number, clamped to 0 .. most.
inline Index clamped_floor(double x, Index most) { return Index(std::min(double(most), std::max(0.0, x))); }
inline Index clamped_ceiling(double x, Index most) {
    const Index below = clamped_floor(x, most);
    return below + (double(below) < x && below < most);
}

// Add the sides from a to b to the counters of cells.
// The counter of a cell is the winding number of the outline around its centre,
// plus the number of sides whose distance from the cell is at most `half` in both coordinates.
// In each row, only the part of a side within the distance `half` of the row counts.
inline void add_sides(View<const Complex> a, View<const Complex> b, View<const Index> weight, double half,
                      CellChanges cells) {
    for (Index s = 0; s < a.size; ++s) {
        const auto [x, y] = a[s];
        const double across = b[s].x - x, rise = b[s].y - y;
        const double low = std::min(y, b[s].y), high = std::max(y, b[s].y);
        const std::uint32_t by = WINDING_UNIT * std::uint32_t(rise > 0 ? weight[s] : -weight[s]);
        const Index above = clamped_ceiling(high - 0.5, cells.rows);
        for (Index row = clamped_ceiling(low - 0.5, cells.rows); row < above; ++row) {
            const double at = x + (double(row) + 0.5 - y) / rise * across;
            cells.add(row, clamped_ceiling(at - 0.5, cells.columns), by);
        }
        const Index bottom = clamped_floor(low - half, cells.rows);
        const Index top = clamped_floor(high + half, cells.rows - 1) + 1;
        for (Index row = bottom; row < top; ++row) {
            double first = 0, last = 1;
            if (bottom + 1 < top && rise != 0) {
                first = std::min(1.0, std::max(0.0, (double(row) - half - y) / rise));
                last = std::min(1.0, std::max(0.0, (double(row + 1) + half - y) / rise));
            }
            const double one = x + first * across, other = x + last * across;
            cells.add(row, clamped_floor(std::min(one, other) - half, cells.columns), 1);
            cells.add(row, clamped_floor(std::max(one, other) + half, cells.columns - 1) + 1, std::uint32_t(-1));
        }
    }
}

// Append the rectangular blocks of the cells whose counter is not 0, and clear the changes.
// The work space `last`, (columns + 1,), stores the last block that begins at each column.
inline void append_blocks(CellChanges cells, View<Index> last, std::vector<CellBlock>& blocks) {
    std::fill(last.begin(), last.end(), -1);
    for (Index row = 0; row < cells.rows; ++row) {
        std::uint32_t* change = cells.change + row * (cells.columns + 1);
        Word* marks = cells.marks + row * cells.words;
        std::uint32_t now = 0;
        bool inside = false;
        Index begin = 0;
        for (Index word = 0; word < cells.words; ++word) {
            for (Word bits = std::exchange(marks[word], NO_BITS); bits != NO_BITS; bits &= bits - 1) {
                const Index column = word * WORD_BITS + lowest_bit(bits);
                now += std::exchange(change[column], 0);
                if ((now != 0) == inside) continue;
                inside = !inside;
                if (inside) {
                    begin = column;
                    continue;
                }
                Index& b = last[begin];
                if (b < 0 || blocks[b].length != column - begin || blocks[b].row + blocks[b].height != row) {
                    b = Index(blocks.size());
                    blocks.emplace_back() = {row, begin, column - begin, 0};
                }
                ++blocks[b].height;
            }
        }
    }
}

struct Masks {
    std::vector<Shape> shapes;
    std::vector<Complex> low;
    std::vector<CellBlock> blocks;
    std::vector<Index> begin;
};

// Rasterize rotated outlines, widened by `half` in all four directions.
// Outline i has the sides sides[i] to sides[i + 1] - 1.
// Mask k shows outline of[k], multiplied by turns[k], in the smallest grid that contains it.
// If turns[k] is the opposite of turns[k - 1] for the same outline,
// the mask is the previous mask rotated by 180 degrees.
inline Masks rasterize(View<const Complex> start, View<const Complex> end, View<const Index> weight,
                       View<const Index> sides, View<const Complex> turns, View<const Index> of, double half) {
    Masks result;
    result.begin.push_back(0);
    Zeros<std::uint32_t> change;
    Zeros<Word> marks;
    std::vector<Complex> a, b;
    std::vector<Index> last;
    std::vector<CellBlock> own;
    for (Index k = 0; k < turns.size; ++k) {
        const auto first_block = Index(result.blocks.size());
        if (k && of[k] == of[k - 1] && turns[k] == Complex{0, 0} - turns[k - 1]) {
            const auto [rows, columns] = result.shapes[k - 1];
            result.blocks.resize(2 * first_block - result.begin[k - 1]);
            for (Index i = result.begin[k - 1], j = first_block; i < first_block; ++i, ++j) {
                const auto [row, column, length, height] = result.blocks[i];
                result.blocks[j] = {rows - row - height, columns - column - length, length, height};
            }
            const Complex before = result.low[k - 1];
            result.low.push_back({-before.x - double(columns), -before.y - double(rows)});
            result.shapes.push_back({rows, columns});
            result.begin.push_back(Index(result.blocks.size()));
            continue;
        }
        const Index first = sides[of[k]], number = sides[of[k] + 1] - first;
        a.resize(number), b.resize(number);
        double left = INFINITY, bottom = INFINITY, right = -INFINITY, top = -INFINITY;
        bool finite = true;
        for (Index s = 0; s < number; ++s) {
            const Complex p = a[s] = times(turns[k], start[first + s]), q = b[s] = times(turns[k], end[first + s]);
            finite = finite && std::isfinite(p.x + p.y + q.x + q.y);
            left = std::min(left, p.x), right = std::max(right, p.x);
            bottom = std::min(bottom, p.y), top = std::max(top, p.y);
        }
        const Complex corner{left - half, bottom - half};
        const double wide = right - corner.x + half, high = top - corner.y + half;
        if (!finite || !(wide >= 0 && high >= 0))
            throw std::invalid_argument("an outline has no sides, or is not finite");
        if (!((wide + 2) * (high + 1) < MAX_MASK_CELLS)) throw std::bad_alloc();
        const Index columns = Index(wide) + 1, rows = Index(high) + 1;
        const Index stride = columns + 1, words = columns / WORD_BITS + 1;
        const CellChanges cells{change.reserve(rows * stride), marks.reserve(rows * words), rows, columns, words};
        for (Index s = 0; s < number; ++s) a[s] = a[s] - corner, b[s] = b[s] - corner;
        add_sides(a, b, weight.part(first, first + number), half, cells);
        if (Index(last.size()) < stride) last.resize(stride);
        own.clear();
        append_blocks(cells, View<Index>(last).part(0, stride), own);
        std::stable_sort(own.begin(), own.end(), [](const CellBlock& one, const CellBlock& other) {
            return one.length * one.height > other.length * other.height;
        });
        result.blocks.insert(result.blocks.end(), own.begin(), own.end());
        result.shapes.push_back({rows, columns});
        result.low.push_back(corner);
        result.begin.push_back(Index(result.blocks.size()));
    }
    return result;
}

}  // namespace packing
