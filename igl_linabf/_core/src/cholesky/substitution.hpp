// Triangular solves with a supernodal Cholesky factor, for S right-hand sides at a time.
#pragma once
#include "supernodal.hpp"

namespace cholesky {

// Solve L x = P b for right-hand sides b, (n, S), whose rows have the stride `step`. x must be zero initially.
// `which` and `root` select supernodes as in `factor_supernodes`.
template <int S>
void solve_lower(const double* values, const Supernodes& a, const TreePartition& parts, const std::vector<Index>& which,
                 Index root, const double* b, Index step, double* left, double* x) {
    using Row = double[S];
    const Index end = root >= 0 ? a.start[root + 1] : a.n;
    std::vector<double> space((a.front + a.n - end) * S);  // initialized to zero
    Row *const y = (Row*)space.data(), *const above = y + a.front;
    auto *X = (Row*)x, *rests = (Row*)left;
    for (const Index s : which) {
        const Index first = a.start[s], width = a.width(s), m = a.rows_below(s), size = width + m;
        const FrontIndex* below = a.below.data() + a.below_start[s];
        if (parts.number[s] >= 0 && s != root) {
            const Row* from = rests + parts.rows[parts.number[s]];
            for (Index i = 0; i < m; ++i)
                for (int c = 0; c < S; ++c) X[below[i]][c] += from[i][c];
            continue;
        }
        Index inside = m;
        while (inside > 0 && below[inside - 1] >= end) --inside;  // rows outside the subtree come last
        bool empty = true;
        for (Index j = 0; j < width; ++j) {
            const double* own = b + a.order[first + j] * step;
            for (int c = 0; c < S; ++c) {
                y[j][c] = X[first + j][c] + own[c];
                empty &= y[j][c] == 0;
            }
        }
        if (empty) {  // skip the supernode: sparse right-hand sides are zero in most supernodes
            for (Index j = 0; j < width; ++j)
                for (int c = 0; c < S; ++c) X[first + j][c] = 0;
            continue;
        }
        std::fill_n(&y[width][0], m * S, 0.0);
        const double* l0 = values + a.value_start[s];
        Index j = 0;
        for (; j < (width & 3); l0 += size - j++) {
            double *yj = y[j], f[S];
            for (int c = 0; c < S; ++c) yj[c] = f[c] = yj[c] * l0[0];
            INDEPENDENT for (Index i = 1; i < size - j; ++i)
                for (int c = 0; c < S; ++c) yj[i * S + c] -= l0[i] * f[c];
        }
        for (; j < width; l0 += 4 * (size - j), j += 4) {  // four columns at a time
            const double *l1 = l0 + size - j, *l2 = l1 + size - j, *l3 = l2 + size - j;
            double *yj = y[j], f0[S], f1[S], f2[S], f3[S];
            for (int c = 0; c < S; ++c) {
                f0[c] = yj[c] * l0[0];
                f1[c] = (yj[S + c] - l0[1] * f0[c]) * l1[1];
                f2[c] = (yj[2 * S + c] - l0[2] * f0[c] - l1[2] * f1[c]) * l2[2];
                f3[c] = (yj[3 * S + c] - l0[3] * f0[c] - l1[3] * f1[c] - l2[3] * f2[c]) * l3[3];
                yj[c] = f0[c], yj[S + c] = f1[c], yj[2 * S + c] = f2[c], yj[3 * S + c] = f3[c];
            }
            INDEPENDENT for (Index i = 4; i < size - j; ++i) {
                const double e = l0[i], r = l1[i], t = l2[i], d = l3[i];
                double* const own = yj + i * S;
                const auto subtract = [=, &f0, &f1, &f2, &f3](int c) {
                    own[c] = own[c] - e * f0[c] - r * f1[c] - t * f2[c] - d * f3[c];
                };
                if constexpr (S < 4)
                    for (int c = 0; c < S; ++c) subtract(c);
                else
                    SIMD for (int c = 0; c < S; ++c) subtract(c);
            }
        }
        for (Index i = 0; i < width; ++i)
            for (int c = 0; c < S; ++c) X[first + i][c] = y[i][c];
        for (Index i = 0; i < m; ++i) {
            double* to = i < inside ? X[below[i]] : above[below[i] - end];
            for (int c = 0; c < S; ++c) to[c] += y[width + i][c];
        }
    }
    if (root < 0) return;
    Row* to = rests + parts.rows[parts.number[root]];
    for (Index i = a.below_start[root]; i < a.below_start[root + 1]; ++i, ++to)
        for (int c = 0; c < S; ++c) (*to)[c] = above[a.below[i] - end][c];
}

// Solve L^T P result = x, (n, S), over the supernodes `which` in reverse order; x is overwritten.
//
// The work space is column-major for few right-hand sides and row-major for many,
// so that the longer loop is vectorized.
template <int S>
void solve_upper(const double* values, const Supernodes& a, const TreePartition& parts, const std::vector<Index>& which,
                 Index root, double* x, double* result, Index step) {
    std::vector<double> space(a.front * S);
    double* const Y = space.data();
    const auto at = [&](Index i, int c) -> double& { return Y[S < 4 ? c * a.front + i : i * S + c]; };
    auto* X = (double(*)[S])x;
    for (auto next = which.rbegin(); next != which.rend(); ++next) {
        const Index s = *next;
        if (parts.number[s] >= 0 && s != root) continue;
        const Index first = a.start[s], width = a.width(s), m = a.rows_below(s), size = width + m;
        const FrontIndex* below = a.below.data() + a.below_start[s];
        for (Index j = 0; j < width; ++j)
            for (int c = 0; c < S; ++c) at(j, c) = X[first + j][c];
        for (Index i = 0; i < m; ++i)
            for (int c = 0; c < S; ++c) at(width + i, c) = X[below[i]][c];
        const double* l0 = values + a.value_start[s + 1];
        Index j = width;
        while (j >= 4) {
            j -= 4, l0 -= 4 * (size - j);
            const double *l1 = l0 + size - j, *l2 = l1 + size - j, *l3 = l2 + size - j;
            double f[4][S] = {};
            if constexpr (S < 4) {
                for (int c = 0; c < S; ++c) {
                    const double* const y = &at(j, c);
                    double p = 0, q = 0, r = 0, t = 0;
                    SUMS_OF(p, q, r, t) for (Index i = 4; i < size - j; ++i)
                        p += l0[i] * y[i], q += l1[i] * y[i], r += l2[i] * y[i], t += l3[i] * y[i];
                    f[0][c] = p, f[1][c] = q, f[2][c] = r, f[3][c] = t;
                }
            } else {
                for (Index i = 4; i < size - j; ++i) {
                    const double e = l0[i], r = l1[i], t = l2[i], d = l3[i];
                    const double* const y = &at(j + i, 0);
                    SIMD for (int c = 0; c < S; ++c)
                        f[0][c] += e * y[c], f[1][c] += r * y[c], f[2][c] += t * y[c], f[3][c] += d * y[c];
                }
            }
            for (int c = 0; c < S; ++c) {
                double &y0 = at(j, c), &y1 = at(j + 1, c), &y2 = at(j + 2, c), &y3 = at(j + 3, c);
                y3 = (y3 - f[3][c]) * l3[3];
                y2 = (y2 - f[2][c] - l2[3] * y3) * l2[2];
                y1 = (y1 - f[1][c] - l1[2] * y2 - l1[3] * y3) * l1[1];
                y0 = (y0 - f[0][c] - l0[1] * y1 - l0[2] * y2 - l0[3] * y3) * l0[0];
            }
        }
        while (j > 0) {
            --j, l0 -= size - j;
            double f[S] = {};
            for (Index i = 1; i < size - j; ++i)
                for (int c = 0; c < S; ++c) f[c] += l0[i] * at(j + i, c);
            for (int c = 0; c < S; ++c) at(j, c) = (at(j, c) - f[c]) * l0[0];
        }
        for (Index i = 0; i < width; ++i) {
            double* own = result + a.order[first + i] * step;
            for (int c = 0; c < S; ++c) X[first + i][c] = own[c] = at(i, c);
        }
    }
}

}  // namespace cholesky
