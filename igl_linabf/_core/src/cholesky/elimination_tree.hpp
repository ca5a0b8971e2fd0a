// The elimination tree of a permuted pattern (Liu 1986).
#pragma once
#include <numeric>

#include "../arrays.hpp"

namespace cholesky {

using Number = std::int32_t;  // a row index, or -1

// The pattern of the lower triangle of P A P^T by columns.
struct Columns {
    std::vector<Index> begin;
    std::vector<Number> row;
    std::vector<Index> source;  // position of each entry among the values of A
};

// Permute the lower triangle of A, given in CSC; order[i] is the row of A that becomes row i.
template <class I>
Columns permute(View<const I> indptr, View<const I> indices, const std::vector<Index>& order) {
    const Index n = Index(order.size());
    std::vector<Number> place(n);
    for (Index i = 0; i < n; ++i) place[order[i]] = Number(i);
    Columns made{std::vector<Index>(n + 2), std::vector<Number>(indices.size), std::vector<Index>(indices.size)};
    for (Index j = 0; j < n; ++j)
        for (Index p = indptr[j]; p < Index(indptr[j + 1]); ++p)
            ++made.begin[std::min(place[j], place[indices[p]]) + 2];
    std::partial_sum(made.begin.begin(), made.begin.end(), made.begin.begin());
    for (Index j = 0; j < n; ++j)
        for (Index p = indptr[j]; p < Index(indptr[j + 1]); ++p) {
            const Number own = place[j], other = place[indices[p]];
            const Index at = made.begin[std::min(own, other) + 1]++;
            made.row[at] = std::max(own, other), made.source[at] = p;
        }
    return made;
}

// The pattern of the lower triangle by rows: the column indices of each row.
struct Rows {
    std::vector<Index> begin;
    std::vector<Number> before;
};

inline Rows transpose(const Columns& a) {
    const Number n = Number(a.begin.size()) - 2;
    Rows made{std::vector<Index>(n + 2), std::vector<Number>(a.row.size())};
    for (const Number i : a.row) ++made.begin[i + 2];
    std::partial_sum(made.begin.begin(), made.begin.end(), made.begin.begin());
    for (Number j = 0; j < n; ++j)
        for (Index p = a.begin[j]; p < a.begin[j + 1]; ++p) made.before[made.begin[a.row[p] + 1]++] = j;
    return made;
}

// Return the parent of each column in the elimination tree; -1 at roots.
inline std::vector<Number> elimination_tree(const Rows& rows) {
    const Number n = Number(rows.begin.size()) - 2;
    std::vector<Number> parent(n, -1), ancestor(n, -1);
    for (Number i = 0; i < n; ++i)
        for (Index p = rows.begin[i]; p < rows.begin[i + 1]; ++p)
            for (Number k = rows.before[p]; k >= 0 && k < i;) {  // make i an ancestor of k, with path compression
                const Number above = ancestor[k];
                ancestor[k] = i;
                if (above < 0) parent[k] = i;
                k = above;
            }
    return parent;
}

}  // namespace cholesky
