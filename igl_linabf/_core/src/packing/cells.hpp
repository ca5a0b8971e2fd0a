// Cells of a grid, stored as bits in words of 64 bits or as rectangular blocks.
#pragma once
#include "../arrays.hpp"

#ifdef _MSC_VER
#include <intrin.h>
#endif

namespace packing {

using Word = std::uint64_t;

constexpr Index WORD_BITS = 64;  // number of bits in a word
constexpr Word NO_BITS = 0, ALL_BITS = ~Word(0);

// Return the position of the lowest set bit of a word that is not 0.
inline Index lowest_bit(Word word) {
#ifdef _MSC_VER
    unsigned long place;
    _BitScanForward64(&place, word);
    return Index(place);
#else
    return __builtin_ctzll(word);
#endif
}

// Return the exponent of the largest power of 2 that is at most `number`, which must be positive.
inline Index floor_log2(Index number) {
    Index power = 0;
    while (number >> (power + 1)) ++power;
    return power;
}

// A rectangular block of cells: its first row and column, its number of columns and its number of rows.
struct CellBlock {
    Index row, column, length, height;
};

struct Shape {
    Index rows, columns;
};

}  // namespace packing
