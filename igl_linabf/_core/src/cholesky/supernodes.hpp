// Supernodal analysis of a sparse Cholesky factorization (Liu 1992).
//
// A supernode is a range of consecutive columns of the factor that have the same rows below them.
#pragma once
#include <limits>
#include <queue>

#include "elimination_tree.hpp"
#include "fronts.hpp"

namespace cholesky {

// Relaxed supernodes: maximum share of explicit zeros in a supernode with up to SMALL_COLUMNS columns,
// with up to MEDIUM_COLUMNS columns, and with more columns.
constexpr Index SMALL_COLUMNS = 16, MEDIUM_COLUMNS = 48;
constexpr double MAX_ZEROS_SMALL = 0.5, MAX_ZEROS_MEDIUM = 0.1, MAX_ZEROS_LARGE = 0.05;

// The supernodal analysis of a sparsity pattern, with P A P^T = L L^T.
struct Supernodes {
    Index n = 0, front = 0;                  // number of rows of A, and of the largest front
    std::vector<Index> order;                // row of A for each row of P A P^T
    std::vector<Index> start;                // first column of each supernode
    std::vector<Index> value_start;          // start of the values of L of each supernode, see `count_values`
    std::vector<Index> entry_start;          // start of the entries of each supernode in `source` and `target`
    std::vector<FrontIndex> source, target;  // position of each entry in the values of A, and in the front
    std::vector<Index> below_start;          // start of the rows of each supernode in `below` and `local`
    std::vector<FrontIndex> below, local;    // rows below a supernode, ascending, and their places in the parent front
    std::vector<Index> children;             // number of children of each supernode in the elimination tree

    Index size() const { return Index(children.size()); }
    Index width(Index s) const { return start[s + 1] - start[s]; }
    Index rows_below(Index s) const { return below_start[s + 1] - below_start[s]; }
};

// Count the entries of each column of L, for columns in postorder (Gilbert, Ng, Peyton 1994).
inline std::vector<Index> column_counts(const ColumnPattern& a, const std::vector<RowIndex>& parent) {
    const RowIndex n = RowIndex(parent.size());
    std::vector<Index> count(n);
    std::vector<RowIndex> first(n, -1), last_first(n, -1), last_leaf(n, -1), ancestor(n);
    std::iota(ancestor.begin(), ancestor.end(), 0);
    for (RowIndex k = 0; k < n; ++k) {
        count[k] = first[k] < 0;  // starts at 1 if column k is a leaf of the elimination tree
        for (RowIndex j = k; j >= 0 && first[j] < 0; j = parent[j]) first[j] = k;
    }
    for (RowIndex j = 0; j < n; ++j) {
        if (parent[j] >= 0) --count[parent[j]];
        for (Index q = a.begin[j]; q < a.begin[j + 1]; ++q) {
            const RowIndex i = a.row[q];
            if (i == j || first[j] <= last_first[i]) continue;
            // j is a leaf of the row subtree of i; its path is new up to the least common ancestor with the last leaf
            last_first[i] = first[j];
            RowIndex leaf = last_leaf[i];
            last_leaf[i] = j;
            ++count[j];
            if (leaf < 0) continue;
            RowIndex top = leaf;
            while (top != ancestor[top]) top = ancestor[top];
            while (leaf != top) leaf = std::exchange(ancestor[leaf], top);
            --count[top];
        }
        if (parent[j] >= 0) ancestor[j] = parent[j];
    }
    for (RowIndex j = 0; j < n; ++j)
        if (parent[j] >= 0) count[parent[j]] += count[j];
    return count;
}

// Find the first column and the number of rows of each supernode. Small supernodes are amalgamated, which adds zeros.
inline std::pair<std::vector<Index>, std::vector<Index>> find_supernodes(const std::vector<RowIndex>& parent,
                                                                         const std::vector<Index>& count) {
    const Index n = Index(parent.size());
    std::vector<Index> start;
    for (Index j = 0; j < n; ++j)
        if (j == 0 || parent[j - 1] != j || count[j - 1] != count[j] + 1) start.push_back(j);
    const Index number = Index(start.size());
    start.push_back(n);
    std::vector<Index> end(number), size(number), zeros(number);
    std::vector<char> first(number, true);
    for (Index s = number - 1; s >= 0; --s) {
        end[s] = start[s + 1], size[s] = count[start[s]];
        if (s == number - 1 || parent[start[s + 1] - 1] != start[s + 1]) continue;
        const Index own = end[s] - start[s], width = end[s + 1] - start[s], rows = own + size[s + 1];
        const Index missing = zeros[s + 1] + own * (rows - size[s]);
        const double share = width <= SMALL_COLUMNS    ? MAX_ZEROS_SMALL
                             : width <= MEDIUM_COLUMNS ? MAX_ZEROS_MEDIUM
                                                       : MAX_ZEROS_LARGE;
        if (width <= GROUP_COLUMNS || double(missing) < share * double(width * rows - width * (width - 1) / 2)) {
            first[s + 1] = false;
            end[s] = end[s + 1], size[s] = rows, zeros[s] = missing;
        }
    }
    Index kept = 0;
    for (Index s = 0; s < number; ++s)
        if (first[s]) start[kept] = start[s], size[kept++] = size[s];
    start.resize(kept), size.resize(kept);
    start.push_back(n);
    return {start, size};
}

// Fill in the rows below each supernode.
// `of` is the supernode of each column, and `above` the parent of each supernode.
inline void find_rows_below(Supernodes& a, const RowPattern& rows, const std::vector<FrontIndex>& of,
                            const std::vector<FrontIndex>& above) {
    std::vector<Index> end = a.below_start;
    std::vector<FrontIndex> seen(a.size(), FrontIndex(a.n));
    a.below.resize(a.below_start.back());
    for (Index i = 0; i < a.n; ++i) {
        seen[of[i]] = FrontIndex(i);
        for (Index p = rows.begin[i]; p < rows.begin[i + 1]; ++p)
            for (FrontIndex s = of[rows.before[p]]; seen[s] != FrontIndex(i); s = above[s]) {
                seen[s] = FrontIndex(i);  // row i is in all supernodes on the path up to the supernode of column i
                a.below[end[s]++] = FrontIndex(i);
            }
    }
}

// Fill in the position of each entry of A in its front, and of each row below a supernode in the front of the parent.
inline void find_positions(Supernodes& a, const ColumnPattern& columns) {
    std::vector<FrontIndex> place(a.n);
    std::vector<Index> waiting;
    a.target.resize(columns.row.size()), a.local.resize(a.below.size());
    for (Index s = 0; s < a.size(); ++s) {
        const Index first = a.start[s], width = a.width(s), m = a.rows_below(s);
        for (Index j = 0; j < width; ++j) place[first + j] = FrontIndex(j);
        for (Index k = 0; k < m; ++k) place[a.below[a.below_start[s] + k]] = FrontIndex(width + k);
        for (Index j = 0; j < width; ++j)
            for (Index p = columns.begin[first + j]; p < columns.begin[first + j + 1]; ++p)
                a.target[p] = FrontIndex(j * (width + m) + place[columns.row[p]]);
        for (Index child = 0; child < a.children[s]; ++child) {  // in postorder, the children are on top of the stack
            const Index c = waiting.back();
            waiting.pop_back();
            for (Index k = a.below_start[c]; k < a.below_start[c + 1]; ++k) a.local[k] = place[a.below[k]];
        }
        if (m) waiting.push_back(s);
    }
}

// Analyse a symmetric pattern, given by its lower triangle in CSC. The elimination order must be a postorder.
template <class I>
Supernodes analyse_supernodes(View<const I> indptr, View<const I> indices, std::vector<Index> order) {
    Supernodes a;
    a.n = Index(order.size());
    const ColumnPattern columns = permute(indptr, indices, order);
    const RowPattern rows = transpose(columns);
    const std::vector<RowIndex> parent = elimination_tree(rows);
    std::vector<Index> size;
    std::tie(a.start, size) = find_supernodes(parent, column_counts(columns, parent));
    const Index number = Index(size.size());
    std::vector<FrontIndex> of(a.n), above(number);
    a.children.resize(number);
    a.below_start = a.value_start = a.entry_start = {0};
    for (Index s = 0; s < number; ++s) {
        a.below_start.push_back(a.below_start[s] + size[s] - a.width(s));
        a.value_start.push_back(a.value_start[s] + count_values(a.width(s), size[s]));
        if (double(a.width(s)) * double(size[s]) > double(std::numeric_limits<FrontIndex>::max()))
            throw std::invalid_argument("too many entries in a front");
        a.entry_start.push_back(columns.begin[a.start[s + 1]]);
        a.front = std::max(a.front, size[s]);
        for (Index j = a.start[s]; j < a.start[s + 1]; ++j) of[j] = FrontIndex(s);
    }
    for (Index s = 0; s < number; ++s)
        if (const RowIndex next = parent[a.start[s + 1] - 1]; next >= 0) ++a.children[above[s] = of[next]];
    find_rows_below(a, rows, of, above);
    find_positions(a, columns);
    a.order = std::move(order), a.source.assign(columns.source.begin(), columns.source.end());
    return a;
}

constexpr Index PARALLEL_ROWS = 20'000;  // minimum number of rows of a matrix that is factored in parallel
constexpr double MAX_SUBTREE_SHARE = 0.15, MIN_SUBTREE_SHARE = 0.005;  // bounds of a subtree's share of all work

// A partition of the elimination tree into subtrees, which threads process in parallel, and supernodes above them.
struct TreePartition {
    std::vector<Index> number;      // for a root, the index of its subtree; -1 for all other supernodes
    std::vector<Index> left, rows;  // start of the update matrix of each root, and of its rows of a right-hand side
    std::vector<std::vector<Index>> subtrees;  // supernodes of each subtree; the subtree with the most work comes first
    std::vector<Index> rest;                   // supernodes above the subtrees, and the roots of the subtrees
};

// Partition the elimination tree into subtrees of similar work.
// Leaves and subtrees with little work are not separated from the supernodes above them.
inline TreePartition partition_tree(const Supernodes& a) {
    const Index size = a.size();
    TreePartition result{std::vector<Index>(size, -1), {0}, {0}, {}, {}};
    std::vector<Index> first(size), waiting;  // first supernode of the subtree with this root
    std::vector<double> work(size);
    std::vector<char> inside(size, false);
    std::priority_queue<std::pair<double, Index>> open;
    double total = 0;
    for (Index s = 0; s < size; ++s) {
        first[s] = s, work[s] = double(a.value_start[s + 1] - a.value_start[s]);
        total += work[s];
        for (Index child = 0; child < a.children[s]; ++child, waiting.pop_back())
            first[s] = first[waiting.back()], work[s] += work[waiting.back()];
        if (a.rows_below(s))
            waiting.push_back(s);
        else if (a.n >= PARALLEL_ROWS)
            open.push({work[s], s});
    }
    while (!open.empty() && open.top().first > MAX_SUBTREE_SHARE * total) {
        const Index s = open.top().second;
        open.pop();
        for (Index child = s - 1; child >= first[s]; child = first[child] - 1) open.push({work[child], child});
    }
    for (; !open.empty(); open.pop()) {
        const auto [most, root] = open.top();
        if (most < MIN_SUBTREE_SHARE * total || first[root] == root) continue;
        const Index m = a.rows_below(root);
        result.number[root] = Index(result.subtrees.size());
        result.left.push_back(result.left.back() + triangle_size(m));
        result.rows.push_back(result.rows.back() + m);
        result.subtrees.emplace_back(root + 1 - first[root]);
        std::iota(result.subtrees.back().begin(), result.subtrees.back().end(), first[root]);
        std::fill(inside.begin() + first[root], inside.begin() + root, true);
    }
    for (Index s = 0; s < size; ++s)
        if (!inside[s]) result.rest.push_back(s);
    return result;
}

}  // namespace cholesky
