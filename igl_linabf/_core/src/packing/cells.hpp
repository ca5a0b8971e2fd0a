// Cells of a grid, 64 to a word, and what outlines take of them.
#pragma once
#include "../arrays.hpp"

#ifdef _MSC_VER
#include <intrin.h>
#endif

namespace packing {

using Word = std::uint64_t;

constexpr Index WORD = 64;  // bits
constexpr Word NONE = 0, EVERY = ~Word(0);

// The place of the lowest bit that is set; one is.
inline Index lowest_bit(Word word) {
#ifdef _MSC_VER
    unsigned long place;
    _BitScanForward64(&place, word);
    return Index(place);
#else
    return __builtin_ctzll(word);
#endif
}

// The largest power of 2 that is not above a number from 1 upwards, as its exponent.
inline Index floor_log2(Index number) {
    Index power = 0;
    while (number >> (power + 1)) ++power;
    return power;
}

// Equal runs of cells, one above the other: the first row and column, the cells of a row, and the rows.
struct Block {
    Index row, column, length, height;
};

struct Shape {
    Index rows, columns;
};

}  // namespace packing
