// Operations on the front of a supernode, a dense matrix.
//
// The front consists of L, the columns to eliminate, and of its update matrix U,
// padded to a multiple of four rows and columns.
// Loops over four columns at a time also read entries above the diagonal and up
// to three entries beyond the end of a column.
// They write the results only to padding and above the diagonal, and these entries are never used.
// L therefore needs memory for three more entries.
#pragma once
#include "../threads.hpp"

namespace cholesky {

using FrontIndex = std::uint32_t;  // a position within a front

constexpr Index GROUP_COLUMNS = 4;    // columns that are eliminated together
constexpr Index PANEL_COLUMNS = 64;   // columns that are eliminated before the later columns are updated
constexpr Index TASK_COLUMNS = 128;  // number of columns of a front per parallel task

// Return the number of rows of an update matrix, rounded up to a multiple of GROUP_COLUMNS.
inline Index pad_rows(Index rows) { return (rows + GROUP_COLUMNS - 1) & -GROUP_COLUMNS; }

// Return the number of entries of a lower triangle.
inline Index triangle_size(Index rows) { return rows * (rows + 1) / 2; }

// Rank-k update: subtract the products of the eliminated columns of X, from `p` to `last` - 1, from columns of Y.
// These are the columns of Y from `first` to `until` - 1.
//
// The column stride is `size` in X and `step` in Y.
// Row 0 of Y is row `shift` of X.
// The update processes four columns of X and of Y at a time, which fit into the registers.
// If the number of columns of Y is not a multiple of four, the number of columns of X must be.
inline void rank_k_update(const double* X, Index size, Index p, Index last, double* Y, Index step, Index shift,
                          Index first, Index until) {
    const Index fours = p + ((last - p) & ~3), whole = first + ((until - first) & ~3);
    for (Index j = first; j < whole; j += 4) {
        double *__restrict y0 = Y + j * step, *__restrict y1 = y0 + step, *__restrict y2 = y1 + step,
          *__restrict y3 = y2 + step;
        const Index begin = j - ((j - step) & 3);  // makes step - begin a multiple of four
        Index k = p;
        for (; k < fours; k += 4) {
            const double *x0 = X + k * size + shift, *x1 = x0 + size, *x2 = x1 + size, *x3 = x2 + size;
            const double a0 = x0[j], a1 = x1[j], a2 = x2[j], a3 = x3[j];
            const double b0 = x0[j + 1], b1 = x1[j + 1], b2 = x2[j + 1], b3 = x3[j + 1];
            const double c0 = x0[j + 2], c1 = x1[j + 2], c2 = x2[j + 2], c3 = x3[j + 2];
            const double d0 = x0[j + 3], d1 = x1[j + 3], d2 = x2[j + 3], d3 = x3[j + 3];
            INDEPENDENT for (Index i = begin; i < step; ++i) {
                const double u = x0[i], v = x1[i], w = x2[i], z = x3[i];
                y0[i] = y0[i] - a0 * u - a1 * v - a2 * w - a3 * z;
                y1[i] = y1[i] - b0 * u - b1 * v - b2 * w - b3 * z;
                y2[i] = y2[i] - c0 * u - c1 * v - c2 * w - c3 * z;
                y3[i] = y3[i] - d0 * u - d1 * v - d2 * w - d3 * z;
            }
        }
        for (; k < last; ++k) {
            const double* x0 = X + k * size + shift;
            const double a0 = x0[j], b0 = x0[j + 1], c0 = x0[j + 2], d0 = x0[j + 3];
            INDEPENDENT for (Index i = begin; i < step; ++i) {
                const double u = x0[i];
                y0[i] -= a0 * u;
                y1[i] -= b0 * u;
                y2[i] -= c0 * u;
                y3[i] -= d0 * u;
            }
        }
    }
    for (Index j = whole; j < until; ++j) {
        double* __restrict y0 = Y + j * step;
        for (Index k = p; k < fours; k += 4) {
            const double *x0 = X + k * size + shift, *x1 = x0 + size, *x2 = x1 + size, *x3 = x2 + size;
            const double a0 = x0[j], a1 = x1[j], a2 = x2[j], a3 = x3[j];
            INDEPENDENT for (Index i = j; i < step; ++i)
                y0[i] = y0[i] - a0 * x0[i] - a1 * x1[i] - a2 * x2[i] - a3 * x3[i];
        }
    }
}

// Eliminate the columns `first` to `last` - 1 of a front without updating later columns.
// Returns the column of a bad pivot, or -1.
inline Index factor_panel(double* L, Index size, Index first, Index last) {
    const Index fours = first + ((last - first) & ~3);
    for (Index j = first; j < fours; j += 4) {
        double *l0 = L + j * size + j, *l1 = l0 + size, *l2 = l1 + size, *l3 = l2 + size;
        double pivot = l0[0];
        if (!(0 < pivot && pivot < INFINITY)) return j;
        const double a0 = 1.0 / std::sqrt(pivot), a1 = l0[1] * a0, a2 = l0[2] * a0, a3 = l0[3] * a0;
        pivot = l1[1] - a1 * a1;
        if (!(0 < pivot && pivot < INFINITY)) return j + 1;
        const double b1 = 1.0 / std::sqrt(pivot), b2 = (l1[2] - a1 * a2) * b1, b3 = (l1[3] - a1 * a3) * b1;
        pivot = l2[2] - a2 * a2 - b2 * b2;
        if (!(0 < pivot && pivot < INFINITY)) return j + 2;
        const double c2 = 1.0 / std::sqrt(pivot), c3 = (l2[3] - a2 * a3 - b2 * b3) * c2;
        pivot = l3[3] - a3 * a3 - b3 * b3 - c3 * c3;
        if (!(0 < pivot && pivot < INFINITY)) return j + 3;
        const double d3 = 1.0 / std::sqrt(pivot);
        l0[0] = a0, l0[1] = a1, l0[2] = a2, l0[3] = a3;
        l1[1] = b1, l1[2] = b2, l1[3] = b3;
        l2[2] = c2, l2[3] = c3, l3[3] = d3;
        INDEPENDENT for (Index i = 4; i < size - j; ++i) {
            const double u = l0[i] * a0;
            const double v = (l1[i] - a1 * u) * b1;
            const double w = (l2[i] - a2 * u - b2 * v) * c2;
            l0[i] = u, l1[i] = v, l2[i] = w;
            l3[i] = (l3[i] - a3 * u - b3 * v - c3 * w) * d3;
        }
        rank_k_update(L, size, j, j + 4, L, size, 0, j + 4, last);
    }
    for (Index j = fours; j < last; ++j) {
        double* l0 = L + j * size + j;
        if (!(0 < l0[0] && l0[0] < INFINITY)) return j;
        const double a0 = 1.0 / std::sqrt(l0[0]);
        l0[0] = a0;
        for (Index i = 1; i < size - j; ++i) l0[i] *= a0;
        for (Index r = j + 1; r < last; ++r) {
            const double *from = l0 + (r - j), a1 = from[0];
            double* __restrict to = L + r * size + r;
            INDEPENDENT for (Index i = 0; i < size - r; ++i) to[i] -= a1 * from[i];
        }
    }
    return -1;
}

// Eliminate the columns of a front, stored contiguously in L. Returns the column of a bad pivot, or -1.
//
// The update matrix U has `rest` rows and columns.
// A pivot is bad if it is not positive and finite.
// The diagonal of L is stored inverted, because solves multiply by it.
// If `shared` is true, threads share the work.
inline Index factor_front(double* L, Index width, Index size, double* U, Index rest, bool shared) {
    for (Index first = 0; first < width; first += PANEL_COLUMNS) {
        const Index last = std::min(first + PANEL_COLUMNS, width), bad = factor_panel(L, size, first, last);
        if (bad >= 0) return bad;
        const Index own = (width - last + TASK_COLUMNS - 1) / TASK_COLUMNS;
        const Index all = own + (rest + TASK_COLUMNS - 1) / TASK_COLUMNS;
        const auto piece = [&](Index k) {
            const Index j = k < own ? last + k * TASK_COLUMNS : (k - own) * TASK_COLUMNS;
            if (k < own)
                rank_k_update(L, size, first, last, L, size, 0, j, std::min(j + TASK_COLUMNS, width));
            else
                rank_k_update(L, size, first, last, U, rest, width, j, std::min(j + TASK_COLUMNS, rest));
        };
        if (shared) {
            parallel_for(all, piece);
        } else {
            for (Index k = 0; k < all; ++k) piece(k);
        }
    }
    return -1;
}

// Count the leading rows, of n, of a child's update matrix that are among the `width` columns eliminated in its parent.
inline Index count_eliminated_rows(const FrontIndex* to, Index n, Index width) {
    return std::find_if(to, to + n, [=](FrontIndex row) { return row >= width; }) - to;
}

// Return the number of stored values of a supernode.
// The first width mod 4 columns are stored from their diagonal on.
// The other columns are stored in groups of four, each from the diagonal of the first column of its group on.
inline Index count_values(Index width, Index size) {
    Index count = 0, j = 0;
    for (; j < (width & 3); ++j) count += size - j;
    for (; j < width; j += 4) count += 4 * (size - j);
    return count;
}

// Copy the eliminated columns of a front to the values of the factor.
inline void store_columns(const double* L, Index width, Index size, double* values) {
    Index j = 0;
    for (; j < (width & 3); ++j) values = std::copy_n(L + j * size + j, size - j, values);
    for (; j < width; j += 4)
        for (Index k = j; k < j + 4; ++k) values = std::copy_n(L + k * size + j, size - j, values);
}

// Store the lower triangle of the first n rows and columns of an update matrix, without its padding.
// Returns the end of the stored values.
inline double* store_update(const double* U, Index rest, Index n, double* left) {
    for (Index j = 0; j < n; ++j) left = std::copy_n(U + j * rest + j, n - j, left);
    return left;
}

// Extend-add: add the stored update matrix of a child to the front (L, U) of its parent.
inline void extend_add(const double* left, const FrontIndex* to, Index n, double* L, Index width, Index size, double* U,
                       Index rest) {
    const Index inner = count_eliminated_rows(to, n, width);
    for (Index j = 0; j < n; left += n - j++) {
        double* row = j < inner ? L + to[j] * size : U + (to[j] - width) * rest - width;
        for (Index i = j; i < n; ++i) row[to[i]] += left[i - j];
    }
}

// Extend-add the update matrix of a leaf of the elimination tree with only one or two columns, `wide`.
// The update matrix is not stored, but computed from the columns.
inline void extend_add_leaf(const double* own, Index wide, const FrontIndex* to, Index n, double* L, Index width,
                            Index size, double* U, Index rest) {
    const Index inner = count_eliminated_rows(to, n, width);
    for (Index k = 0; k < wide; own += wide + n - k++)
        for (Index j = 0; j < n; ++j) {
            const double* below = own + wide - k;
            double* row = j < inner ? L + to[j] * size : U + (to[j] - width) * rest - width;
            for (Index i = j; i < n; ++i) row[to[i]] -= below[j] * below[i];
        }
}

}  // namespace cholesky
