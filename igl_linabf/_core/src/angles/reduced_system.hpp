// Assembly of the reduced system S = sum_t M_t P_t M_t^T, and of the Laplacian L_s that preconditions it.
#pragma once
#include "triangles.hpp"

namespace angles {

// Return the pair weight w_i w_j / d at corner k, opposite to the corners i and j, where d is the sum of the weights w.
// The quadratic form y^T P y is the sum of pair weight times (y_i - y_j)^2 over the three pairs of corners.
inline Grid<double> pair_weights(Values w, Numbers d) {
    return tabulate_corners(w.columns, [w = CornerRows(w), d](Index t) {
        const auto [a, b, c] = w[t];
        return Triple{b * c / d[t], c * a / d[t], a * b / d[t]};
    });
}

// Return the weight of each half-edge in the Laplacian sum_t s_t K_t, where K_t is the cotangent matrix of triangle t,
// and s_t = 2 sqrt(w0 w1 w2 / d) is the geometric mean of the two eigenvalue ratios of P_t and K_t.
inline Grid<double> conformal_weights(Values w, Numbers d, Values cot) {
    return tabulate_corners(w.columns, [w = CornerRows(w), d, cot = CornerRows(cot)](Index t) {
        const auto [a, b, c] = w[t];
        const double half = std::sqrt(a * b * c / d[t]);
        return Triple{cot.a[t] * half, cot.b[t] * half, cot.c[t] * half};
    });
}

// Return rho + 1 / rho of each triangle, where rho is the ratio of the two eigenvalues of K+ P on the plane sum e = 0.
// K+ is the pseudoinverse of the cotangent matrix K. On that plane, tr(K+ P) = (tr K tr P - tr K P) / (3/4)
// and det(K+ P) = 4 w0 w1 w2 / d.
inline Array<double> eigenvalue_disparity(Values w, Numbers d, Values cot) {
    return tabulate(d.size, [w = CornerRows(w), d, cot = CornerRows(cot)](Index t) {
        const auto [a, b, c] = w[t];
        const auto [x, y, z] = cot[t];
        const double pa = b * c / d[t], pb = c * a / d[t], pc = a * b / d[t];
        const double product = 0.5 * ((y + z) * (pb + pc) + (z + x) * (pc + pa) + (x + y) * (pa + pb)) +
                               x * pa + y * pb + z * pc;
        const double trace = ((x + y + z) * 2 * (pa + pb + pc) - product) / 0.75;
        return trace * trace * d[t] / (4 * a * b * c) - 2;
    });
}

// Return the sum of the values, (3, #F), of the half-edges `sides`, (2, #E), of each edge.
// The second half-edge of a boundary edge is -1.
inline Array<double> edge_sums(Values values, Matrix<const Index> sides) {
    const double* value = values.data;
    return tabulate(sides.columns, [value, one = sides[0], other = sides[1]](Index e) {
        return value[one[e]] + (other[e] >= 0 ? value[other[e]] : 0.0);
    });
}

// Return the entries of the upper triangle of a Laplacian in CSR.
// `ends`, (2, #E), are the rows of the end vertices of each edge, or -1 for fixed vertices.
// `slot` is the position of the entry of each edge.
template <class I>
Array<double> laplacian_entries(View<const I> indptr, View<const Index> slot, Matrix<const Index> ends,
                                Numbers weight) {
    Array<double> result = zeros(indptr[indptr.size - 1]);
    for (Index e = 0; e < ends.columns; ++e) {
        const Index i = ends[0][e], j = ends[1][e];
        if (i == j) continue;
        if (i >= 0) result[indptr[i]] += weight[e];
        if (j >= 0) result[indptr[j]] += weight[e];
        if (slot[e] >= 0) result[slot[e]] -= weight[e];
    }
    return result;
}

// Return the contribution of fixed vertices to L x, (n, 2).
// In each row, it is the sum of weight times z over the edges to fixed vertices; z must be zero at all other vertices.
inline Grid<double> fixed_vertex_terms(Matrix<const Index> ends, Matrix<const Index> edges, Numbers weight,
                                       View<const Complex> z, Index n) {
    Grid<double> result = zeros<Grid<double>>(n, 2);
    for (Index e = 0; e < ends.columns; ++e)
        for (Index s = 0; s < 2; ++s) {
            const Index i = ends[s][e];
            if (i < 0) continue;
            const Complex fixed = z[edges[e][1 - s]];
            result[2 * i] += weight[e] * fixed.x, result[2 * i + 1] += weight[e] * fixed.y;
        }
    return result;
}

// A 2 by 2 block of the reduced system, with the entries (vertex, vertex), (vertex, wheel),
// (wheel, vertex) and (wheel, wheel).
struct SystemBlock {
    double vv = 0, vw = 0, wv = 0, ww = 0;

    void operator+=(SystemBlock b) { vv += b.vv, vw += b.vw, wv += b.wv, ww += b.ww; }
    SystemBlock transposed() const { return {vv, wv, vw, ww}; }
};

// The contributions of the triangles to the blocks of the reduced system.
struct TriangleBlocks {
    Values w, cot;
    Numbers d;

    // Return the block between the tail and the head of the half-edge opposite to corner k of triangle t.
    SystemBlock side_block(Index k, Index t) const {
        const Index i = (k + 1) % 3, j = (k + 2) % 3;
        const double a = w[k][t], b = w[i][t], c = w[j][t], x = cot[k][t], y = cot[i][t], z = cot[j][t];
        const double share = 1 / d[t], opposite = b * c * share;
        const double to_tail = a * b * share * (x + y), to_head = a * c * share * (x + z);
        return {-opposite, -opposite * y - to_tail, opposite * z + to_head,
                opposite * y * z - x * (to_tail + to_head)};
    }

    // Return half of the diagonal block of corner k of triangle t.
    SystemBlock half_corner_block(Index k, Index t) const {
        const Index i = (k + 1) % 3, j = (k + 2) % 3;
        const double share = 1 / d[t], a = w[k][t] * share, y = cot[i][t], z = cot[j][t];
        const double opposite = w[i][t] * w[j][t] * share, right = a * w[i][t], left = a * w[j][t];
        const double mixed = (left * z - right * y) / 2;
        return {(right + left) / 2, mixed, mixed,
                (opposite * (y + z) * (y + z) + right * y * y + left * z * z) / 2};
    }
};

// Return the blocks of the reduced system, (#blocks, 4), in the CSR pattern of its upper triangle.
// Diagonal blocks are halved.
// From row `wheels` on, wheel rows are replaced by rows of the identity.
// `ends` and `sides` are the rows and the half-edges of each edge.
// `row` is the row of each vertex; several vertices, such as those of a hole, may share a row.
template <class I>
Grid<double> system_blocks(View<const I> indptr, View<const I> indices, View<const Index> slot,
                           Matrix<const Index> ends, Matrix<const Index> sides, Corners corner,
                           View<const Index> row, Index wheels, Values w, Numbers d, Values cot) {
    const Index n = indptr.size - 1, m = corner.columns, size = indices.size;
    const TriangleBlocks triangles{w, cot, d};
    Grid<double> result(size, 4);
    SystemBlock* block = reinterpret_cast<SystemBlock*>(result.data());
    std::fill_n(block, size, SystemBlock());
    for (Index e = 0; e < slot.size; ++e) {
        const Index i = ends[0][e], j = ends[1][e], s = sides[0][e], t = sides[1][e];
        if (i < 0 || j < 0) continue;
        const Index k = (s >= m) + (s >= 2 * m), l = (t >= m) + (t >= 2 * m);
        SystemBlock sum = triangles.side_block(k, s - k * m);
        if (t >= 0) sum += triangles.side_block(l, t - l * m).transposed();  // the half-edges have opposite directions
        if (i == j) {
            sum.vw = sum.wv = (sum.vw + sum.wv) / 2;
            block[indptr[i]] += sum;
        } else {
            block[slot[e]] += i > j ? sum.transposed() : sum;
        }
    }
    for (Index t = 0; t < m; ++t)
        for (Index k = 0; k < 3; ++k)
            if (const Index i = row[corner[k][t]]; i >= 0) block[indptr[i]] += triangles.half_corner_block(k, t);
    for (Index i = 0; i < n && wheels < n; ++i) {
        for (Index p = indptr[i]; p < Index(indptr[i + 1]); ++p) {
            if (i >= wheels) block[p].wv = 0;
            if (Index(indices[p]) >= wheels) block[p].vw = block[p].ww = 0;
        }
        if (i >= wheels) block[indptr[i]].ww = 0.5;
    }
    return result;
}

}  // namespace angles
