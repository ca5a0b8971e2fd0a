// The elimination tree of a permuted pattern (Liu 1986).
#pragma once
#include <numeric>

#include "../arrays.hpp"

namespace cholesky {

using RowIndex = std::int32_t;  // index of a row, or -1 for no row

// The sparsity pattern of the lower triangle of P A P^T, column by column.
struct ColumnPattern {
    std::vector<Index> begin;
    std::vector<RowIndex> row;
    std::vector<Index> source;  // position of each entry among the values of A
};

// Permute the lower triangle of A, given in CSC; order[i] is the row of A that becomes row i.
template <class I>
ColumnPattern permute(View<const I> indptr, View<const I> indices, const std::vector<Index>& order) {
    const Index n = Index(order.size());
    std::vector<RowIndex> place(n);
    for (Index i = 0; i < n; ++i) place[order[i]] = RowIndex(i);
    ColumnPattern result{std::vector<Index>(n + 2), std::vector<RowIndex>(indices.size),
                         std::vector<Index>(indices.size)};
    for (Index j = 0; j < n; ++j)
        for (Index p = indptr[j]; p < Index(indptr[j + 1]); ++p)
            ++result.begin[std::min(place[j], place[indices[p]]) + 2];
    std::partial_sum(result.begin.begin(), result.begin.end(), result.begin.begin());
    for (Index j = 0; j < n; ++j)
        for (Index p = indptr[j]; p < Index(indptr[j + 1]); ++p) {
            const RowIndex own = place[j], other = place[indices[p]];
            const Index at = result.begin[std::min(own, other) + 1]++;
            result.row[at] = std::max(own, other), result.source[at] = p;
        }
    return result;
}

// The sparsity pattern of the lower triangle of P A P^T, row by row: the column indices of each row.
struct RowPattern {
    std::vector<Index> begin;
    std::vector<RowIndex> before;
};

inline RowPattern transpose(const ColumnPattern& a) {
    const RowIndex n = RowIndex(a.begin.size()) - 2;
    RowPattern result{std::vector<Index>(n + 2), std::vector<RowIndex>(a.row.size())};
    for (const RowIndex i : a.row) ++result.begin[i + 2];
    std::partial_sum(result.begin.begin(), result.begin.end(), result.begin.begin());
    for (RowIndex j = 0; j < n; ++j)
        for (Index p = a.begin[j]; p < a.begin[j + 1]; ++p) result.before[result.begin[a.row[p] + 1]++] = j;
    return result;
}

// Return the parent of each column in the elimination tree, or -1 at roots.
inline std::vector<RowIndex> elimination_tree(const RowPattern& rows) {
    const RowIndex n = RowIndex(rows.begin.size()) - 2;
    std::vector<RowIndex> parent(n, -1), ancestor(n, -1);
    for (RowIndex i = 0; i < n; ++i)
        for (Index p = rows.begin[i]; p < rows.begin[i + 1]; ++p)
            for (RowIndex k = rows.before[p]; k >= 0 && k < i;) {  // make i an ancestor of k, with path compression
                const RowIndex above = ancestor[k];
                ancestor[k] = i;
                if (above < 0) parent[k] = i;
                k = above;
            }
    return parent;
}

}  // namespace cholesky
