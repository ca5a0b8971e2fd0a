// The analysis of a sparse Cholesky factorisation by supernodes (Liu 1992).
//
// A supernode is a run of columns of the factor with the same rows below them.
#pragma once
#include <queue>

#include "elimination_tree.hpp"
#include "fronts.hpp"

namespace cholesky {

constexpr Index SMALL = 16, MEDIUM = 48;  // columns
constexpr double ZEROS_OF_SMALL = 0.5, ZEROS_OF_MEDIUM = 0.1, ZEROS = 0.05;  // share of its entries that may be zeros

// A pattern, analysed; P A P^T = L L^T.
struct Supernodes {
    Index n = 0, front = 0;                // rows; those of the largest front
    std::vector<Index> order;              // the row of A that comes at each place
    std::vector<Index> start;              // the first column of each supernode
    std::vector<Index> value_start;        // where its part of L's values begins, as of `stored`
    std::vector<Index> entry_start;        // where its entries of P A P^T begin:
    std::vector<Place> source, target;     // where each is in A's data, and where it goes in the front
    std::vector<Index> below_start;        // where its rows below begin:
    std::vector<Place> below, local;       // these, ascending, and where they are in its parent's front
    std::vector<Index> children;           // how many it has in the elimination tree

    Index size() const { return Index(children.size()); }
    Index width(Index s) const { return start[s + 1] - start[s]; }
    Index rows_below(Index s) const { return below_start[s + 1] - below_start[s]; }
};

// The number of entries of each column of L, the columns in postorder (Gilbert, Ng, Peyton 1994).
inline std::vector<Index> column_counts(const Columns& a, const std::vector<Number>& parent) {
    const Number n = Number(parent.size());
    std::vector<Index> count(n);
    std::vector<Number> first(n, -1), last_first(n, -1), last_leaf(n, -1), ancestor(n);
    std::iota(ancestor.begin(), ancestor.end(), 0);
    for (Number k = 0; k < n; ++k) {
        count[k] = first[k] < 0;  // the leaves
        for (Number j = k; j >= 0 && first[j] < 0; j = parent[j]) first[j] = k;
    }
    for (Number j = 0; j < n; ++j) {
        if (parent[j] >= 0) --count[parent[j]];
        for (Index q = a.begin[j]; q < a.begin[j + 1]; ++q) {
            const Number i = a.row[q];
            if (i == j || first[j] <= last_first[i]) continue;
            // j is a leaf of the subtree of row i: from there up, its path is new to the least common ancestor
            last_first[i] = first[j];
            Number leaf = last_leaf[i];
            last_leaf[i] = j;
            ++count[j];
            if (leaf < 0) continue;
            Number top = leaf;
            while (top != ancestor[top]) top = ancestor[top];
            while (leaf != top) leaf = std::exchange(ancestor[leaf], top);
            --count[top];
        }
        if (parent[j] >= 0) ancestor[j] = parent[j];
    }
    for (Number j = 0; j < n; ++j)
        if (parent[j] >= 0) count[parent[j]] += count[j];
    return count;
}

// The first columns of the supernodes, and the rows of each; small ones take in zeros to be wider.
inline std::pair<std::vector<Index>, std::vector<Index>> supernode_columns(const std::vector<Number>& parent,
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
        const double share = width <= SMALL ? ZEROS_OF_SMALL : width <= MEDIUM ? ZEROS_OF_MEDIUM : ZEROS;
        if (width <= WIDTH || double(missing) < share * double(width * rows - width * (width - 1) / 2)) {
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

// Fill in the rows below each supernode, `of` being that of each column and `above` the parent of each.
inline void find_rows_below(Supernodes& a, const Rows& rows, const std::vector<Place>& of,
                            const std::vector<Place>& above) {
    std::vector<Index> end = a.below_start;
    std::vector<Place> seen(a.size(), Place(a.n));
    a.below.resize(a.below_start.back());
    for (Index i = 0; i < a.n; ++i) {
        seen[of[i]] = Place(i);
        for (Index p = rows.begin[i]; p < rows.begin[i + 1]; ++p)  // the diagonal is seen already
            for (Place s = of[rows.before[p]]; seen[s] != Place(i); s = above[s]) {
                seen[s] = Place(i);  // row i is in the supernodes up the tree from there
                a.below[end[s]++] = Place(i);
            }
    }
}

// Fill in where entries go, and where rows are in parents' fronts.
inline void find_places(Supernodes& a, const Columns& columns) {
    std::vector<Place> place(a.n);
    std::vector<Index> waiting;
    a.target.resize(columns.row.size()), a.local.resize(a.below.size());
    for (Index s = 0; s < a.size(); ++s) {
        const Index first = a.start[s], width = a.width(s), m = a.rows_below(s);
        for (Index j = 0; j < width; ++j) place[first + j] = Place(j);
        for (Index k = 0; k < m; ++k) place[a.below[a.below_start[s] + k]] = Place(width + k);
        for (Index j = 0; j < width; ++j)
            for (Index p = columns.begin[first + j]; p < columns.begin[first + j + 1]; ++p)
                a.target[p] = Place(j * (width + m) + place[columns.row[p]]);
        for (Index child = 0; child < a.children[s]; ++child) {  // in postorder, the children are on top
            const Index c = waiting.back();
            waiting.pop_back();
            for (Index k = a.below_start[c]; k < a.below_start[c + 1]; ++k) a.local[k] = place[a.below[k]];
        }
        if (m) waiting.push_back(s);
    }
}

// Analyse a symmetric pattern, given by its lower triangle in CSC, for a postordered elimination.
template <class I>
Supernodes supernodes(View<const I> indptr, View<const I> indices, std::vector<Index> order) {
    Supernodes a;
    a.n = Index(order.size());
    const Columns columns = permuted(indptr, indices, order);
    const Rows rows = rows_of(columns);
    const std::vector<Number> parent = elimination_tree(rows);
    std::vector<Index> size;
    std::tie(a.start, size) = supernode_columns(parent, column_counts(columns, parent));
    const Index number = Index(size.size());
    std::vector<Place> of(a.n), above(number);
    a.children.resize(number);
    a.below_start = a.value_start = a.entry_start = {0};
    for (Index s = 0; s < number; ++s) {
        a.below_start.push_back(a.below_start[s] + size[s] - a.width(s));
        a.value_start.push_back(a.value_start[s] + stored(a.width(s), size[s]));
        a.entry_start.push_back(columns.begin[a.start[s + 1]]);
        a.front = std::max(a.front, size[s]);
        for (Index j = a.start[s]; j < a.start[s + 1]; ++j) of[j] = Place(s);
    }
    for (Index s = 0; s < number; ++s)
        if (const Number next = parent[a.start[s + 1] - 1]; next >= 0) ++a.children[above[s] = of[next]];
    find_rows_below(a, rows, of, above);
    find_places(a, columns);
    a.order = std::move(order), a.source.assign(columns.source.begin(), columns.source.end());
    return a;
}

constexpr Index SUBTREES_FROM = 20'000;          // rows: below, threads take longer to begin than they save
constexpr double LARGEST = 0.15, LEAST = 0.005;  // share of the whole work in a subtree

// The elimination tree in subtrees, at which threads work at the same time, and the rest above them.
struct Division {
    std::vector<Index> number;      // of which subtree a supernode is the root; -1 for others
    std::vector<Index> left, rows;  // where what each root leaves begins: its matrix, and the rows of a right side
    std::vector<std::vector<Index>> subtrees;  // the supernodes of each, the most work first
    std::vector<Index> rest;                   // those above, and the roots
};

// Subtrees of much the same work; what is too small for one, or a leaf, is left to the rest.
inline Division divided(const Supernodes& a) {
    const Index size = a.size();
    Division made{std::vector<Index>(size, -1), {0}, {0}, {}, {}};
    std::vector<Index> first(size), waiting;  // the first supernode of each one's subtree
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
        else if (a.n >= SUBTREES_FROM)
            open.push({work[s], s});
    }
    while (!open.empty() && open.top().first > LARGEST * total) {
        const Index s = open.top().second;
        open.pop();
        for (Index child = s - 1; child >= first[s]; child = first[child] - 1) open.push({work[child], child});
    }
    for (; !open.empty(); open.pop()) {
        const auto [most, root] = open.top();
        if (most < LEAST * total || first[root] == root) continue;
        const Index m = a.rows_below(root);
        made.number[root] = Index(made.subtrees.size());
        made.left.push_back(made.left.back() + triangle(m));
        made.rows.push_back(made.rows.back() + m);
        made.subtrees.emplace_back(root + 1 - first[root]);
        std::iota(made.subtrees.back().begin(), made.subtrees.back().end(), first[root]);
        std::fill(inside.begin() + first[root], inside.begin() + root, true);
    }
    for (Index s = 0; s < size; ++s)
        if (!inside[s]) made.rest.push_back(s);
    return made;
}

}  // namespace cholesky
