// Steps of conjugate gradients for independent blocks, products with symmetric matrices stored as one triangle,
// and access to rows of matrices of 2 by 2 blocks.
#pragma once
#include "triangles.hpp"

namespace angles {

// Return the scalar product of a and b in each block; block k has the entries start[k] to start[k + 1] - 1.
inline Array<double> block_dots(View<const Index> start, View<const double> a, View<const double> b) {
    Array<double> result(start.size - 1);
    for (Index k = 0; k < result.rows; ++k) {
        const double *u = a.data + start[k], *v = b.data + start[k];
        result[k] = parallel_sum(start[k + 1] - start[k], [=](Index first, Index last) {
            double total = 0;
            SUMS_OF(total) for (Index i = first; i < last; ++i) total += u[i] * v[i];
            return total;
        });
    }
    return result;
}

// In each block, take the conjugate gradient step along the direction p: x += length p and r -= length q,
// where q = A p and length = rho / p . q.
// Blocks with rho = 0 do not change.
// Returns r . r.
inline Array<double> cg_step(View<const Index> start, View<const double> rho, View<const double> p,
                             View<const double> q, View<double> x, View<double> r) {
    Array<double> result = block_dots(start, p, q);
    for (Index k = 0; k < result.rows; ++k) {
        const double along = rho[k] == 0 || result[k] == 0 ? 0.0 : rho[k] / result[k];
        const double *u = p.data + start[k], *v = q.data + start[k];
        double *to = x.data + start[k], *left = r.data + start[k];
        result[k] = parallel_sum(start[k + 1] - start[k], [=](Index first, Index last) {
            double total = 0;
            SUMS_OF(total) for (Index i = first; i < last; ++i) {
                to[i] += along * u[i];
                const double rest = left[i] - along * v[i];
                left[i] = rest;
                total += rest * rest;
            }
            return total;
        });
    }
    return result;
}

// In each block, update the conjugate gradient direction p to z + (rho / last) p, where `last` is the previous rho.
// If rho or last is 0, the new direction is z.
inline void update_cg_direction(View<const Index> start, View<const double> rho, View<const double> last,
                                View<const double> z, View<double> p) {
    for (Index k = 0; k + 1 < start.size; ++k) {
        const double kept = rho[k] == 0 || last[k] == 0 ? 0.0 : rho[k] / last[k], *from = z.data + start[k];
        double* to = p.data + start[k];
        parallel_for_pieces(start[k + 1] - start[k], [=](Index first, Index until) {
            INDEPENDENT for (Index i = first; i < until; ++i) to[i] = from[i] + kept * to[i];
        });
    }
}

// Accumulate the contributions of the rows of an upper triangular matrix to y, (n, 2).
// The function add(first, last, y) adds the contributions of rows `first` to `last` - 1 to a vector
// that begins at row `first`.
// Because a row also contributes to later rows, the two halves of a large matrix are accumulated in separate vectors.
template <class Made, class Add>
Made accumulate_in_halves(Index n, Made&& y, const Add& add) {
    const Index half = n < PARALLEL_SIZE ? n : n / 2;
    Array<double> below = zeros(2 * (n - half));
    parallel_for(half < n ? 2 : 1, [&](Index k) { k ? add(half, n, below.data()) : add(Index(0), half, y.data()); });
    double* to = y.data() + 2 * half;
    parallel_for_pieces(below.size(), [&](Index first, Index last) {
        INDEPENDENT for (Index i = first; i < last; ++i) to[i] += below[i];
    });
    return std::move(y);
}

// Return (U + U^T) x, where U is a matrix of 2 by 2 blocks, (#blocks, 4), in a CSR pattern.
template <class I>
Array<double> block_product(View<const I> indptr, View<const I> indices, Matrix<const double> block,
                            View<const double> x) {
    const Index n = indptr.size - 1;
    return accumulate_in_halves(n, zeros(2 * n), [=](Index first, Index last, double* y) {
        for (Index i = first; i < last; ++i) {
            const double u = x[2 * i], v = x[2 * i + 1];
            double s = 0, t = 0;
            for (Index k = indptr[i]; k < Index(indptr[i + 1]); ++k) {
                const double *b = block[k], *at = x.data + 2 * Index(indices[k]);
                double* to = y + 2 * (Index(indices[k]) - first);
                s += b[0] * at[0] + b[1] * at[1], t += b[2] * at[0] + b[3] * at[1];
                to[0] += b[0] * u + b[2] * v, to[1] += b[1] * u + b[3] * v;
            }
            y[2 * (i - first)] += s, y[2 * (i - first) + 1] += t;
        }
    });
}

// Return A x, (n, 2), for a symmetric matrix A, given by its lower triangle in CSC.
template <class I>
Grid<double> symmetric_product(View<const I> indptr, View<const I> indices, View<const double> data,
                               Matrix<const double> x) {
    const Index n = indptr.size - 1;
    return accumulate_in_halves(n, zeros<Grid<double>>(n, 2), [=](Index first, Index last, double* y) {
        for (Index i = first; i < last; ++i) {
            const double u = x[i][0], v = x[i][1];
            double s = 0, t = 0;
            for (Index k = indptr[i]; k < Index(indptr[i + 1]); ++k) {
                const Index j = indices[k];
                const double a = data[k], own = i == j ? 0.0 : a;
                double* to = y + 2 * (j - first);
                s += a * x[j][0], t += a * x[j][1];
                to[0] += own * u, to[1] += own * v;
            }
            y[2 * (i - first)] += s, y[2 * (i - first) + 1] += t;
        }
    });
}

// Return the pattern of selected rows of U + U^T: the start of each row,
// and the ascending columns and the positions of its blocks.
// The position of a block is its index in U, or ~index for a transposed block.
// `number`, (n,), counts the selected rows from 0 in ascending order; it is -1 for all other rows.
template <class I>
std::tuple<Array<Index>, Array<Index>, Array<Index>> block_rows(View<const I> indptr, View<const I> indices,
                                                                View<const Index> number) {
    const Index n = number.size, chosen = n ? 1 + *std::max_element(number.begin(), number.end()) : 0;
    Array<Index> start(chosen + 1);
    const auto each = [&](const auto& put) {  // calls put(row, column, position) for each block
        for (Index i = 0; i < n; ++i)
            for (Index k = indptr[i]; k < Index(indptr[i + 1]); ++k) {
                const Index j = indices[k];
                if (number[i] >= 0) put(number[i], j, k);
                if (number[j] >= 0 && i != j) put(number[j], i, ~k);
            }
    };
    std::vector<Index> end(chosen + 2, 0);
    each([&](Index row, Index, Index) { ++end[row + 2]; });
    for (Index i = 2; i < chosen + 2; ++i) end[i] += end[i - 1];
    std::copy(end.begin() + 1, end.end(), start.data());
    Array<Index> column(end[chosen + 1]), place(end[chosen + 1]);
    each([&](Index row, Index j, Index k) {  // sorted by column, because rows of U are visited in order
        const Index at = end[row + 1]++;
        column[at] = j, place[at] = k;
    });
    return {std::move(start), std::move(column), std::move(place)};
}

// Return the blocks, (#blocks, 4), of the rows selected by `block_rows`.
// `of` is the row of each returned block.
// `block` contains the stored blocks of U; diagonal blocks are halved.
inline Grid<double> gather_row_blocks(Matrix<const double> block, View<const Index> column, View<const Index> place,
                                      View<const Index> of) {
    Grid<double> result(column.size, 4);
    for (Index k = 0; k < column.size; ++k) {
        const bool transposed = place[k] < 0, own = column[k] == of[k];
        const double *b = block[transposed ? ~place[k] : place[k]], vw = b[1 + transposed], wv = b[2 - transposed];
        double* to = result.matrix()[k];
        to[0] = own ? 2 * b[0] : b[0], to[1] = own ? vw + wv : vw;
        to[2] = own ? vw + wv : wv, to[3] = own ? 2 * b[3] : b[3];
    }
    return result;
}

// Return r - R^T x, where R consists of the rows selected by `block_rows`; r may have more entries than R has columns.
inline Array<double> subtract_rows(View<const Index> start, View<const Index> column, Matrix<const double> block,
                                   View<const double> x, View<const double> r) {
    Array<double> left(r.size);
    std::copy(r.begin(), r.end(), left.data());
    for (Index i = 0; i + 1 < start.size; ++i)
        for (Index k = start[i]; k < start[i + 1]; ++k) {
            const double* b = block[k];
            double* to = left.data() + 2 * column[k];
            to[0] -= b[0] * x[2 * i] + b[2] * x[2 * i + 1], to[1] -= b[1] * x[2 * i] + b[3] * x[2 * i + 1];
        }
    return left;
}

// Return r - R z, (2 #rows,), where R consists of the rows `of` of a matrix, and r is restricted to these rows.
inline Array<double> row_residual(View<const Index> start, View<const Index> column, Matrix<const double> block,
                                  View<const Index> of, View<const double> r, View<const double> z) {
    Array<double> result(2 * of.size);
    for (Index i = 0; i < of.size; ++i) {
        double u = r[2 * of[i]], v = r[2 * of[i] + 1];
        for (Index k = start[i]; k < start[i + 1]; ++k) {
            const double *b = block[k], *at = z.data + 2 * column[k];
            u -= b[0] * at[0] + b[1] * at[1], v -= b[2] * at[0] + b[3] * at[1];
        }
        result[2 * i] = u, result[2 * i + 1] = v;
    }
    return result;
}

}  // namespace angles
