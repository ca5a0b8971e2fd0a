// The Cholesky factorisation of a sparse matrix by supernodes (Duff, Reid 1983; Liu 1992).
//
// The front of a supernode is a dense matrix: the rows of A that belong to its columns, and what its children in
// the elimination tree leave. The front's columns are eliminated; what is left of the front goes to its parent.
#pragma once
#include "supernodes.hpp"

constexpr Index THIN = 2;              // columns up to which what a leaf leaves goes to its parent's front at once
constexpr double SHARED_FROM = 1e8;    // operations at a front above the subtrees from which threads share them

// Whether what this supernode leaves is not stored.
inline bool thin(const Supernodes& a, Index s) { return a.children[s] == 0 && a.width(s) <= THIN; }

// The largest rest of a front among some supernodes, and the most that fronts leave for parents at a time.
inline std::pair<Index, Index> space_for(const Supernodes& a, const Division& parts, const std::vector<Index>& which,
                                         Index root) {
    Index largest = 0, most = 0, last = 0;
    std::vector<Index> waiting;
    const auto left = [&](Index s) {
        const Index rest = padded(a.rows_below(s));
        return parts.number[s] >= 0 || thin(a, s) ? 0 : rest * rest;
    };
    for (const Index s : which) {
        if (parts.number[s] < 0 || s == root) {
            largest = std::max(largest, thin(a, s) ? 0 : padded(a.rows_below(s)));
            for (Index child = 0; child < a.children[s]; ++child, waiting.pop_back()) last -= left(waiting.back());
        }
        last += left(s);
        most = std::max(most, last);
        if (a.rows_below(s)) waiting.push_back(s);
    }
    return {largest * largest, most};
}

// Fill L's values by some supernodes in order; the place of a bad pivot, or -1.
//
// These are those of the subtree with this root. With root -1 they are those above all subtrees, and the roots of
// these, which leave their rests in `left`.
inline Index eliminate(View<const double> data, const Supernodes& a, const Division& parts,
                       const std::vector<Index>& which, Index root, double* values, double* left) {
    const auto [largest, most] = space_for(a, parts, which, root);
    const Array<double> space(largest), stack(most);
    double* top = stack.data();
    std::vector<Index> waiting;
    for (const Index s : which) {
        const Index first = a.start[s], width = a.width(s), m = a.rows_below(s), size = width + m;
        if (parts.number[s] >= 0 && s != root) {  // it is done
            if (m) waiting.push_back(s);
            continue;
        }
        double *L = values + a.value_start[s], *U = space.data();
        const Index rest = thin(a, s) ? 0 : padded(m);
        std::fill_n(L, width * size, 0.0);
        for (Index i = a.entry_start[s]; i < a.entry_start[s + 1]; ++i) L[a.target[i]] += data[a.source[i]];
        std::fill_n(U, rest * rest, 0.0);
        for (Index child = 0; child < a.children[s]; ++child, waiting.pop_back()) {
            const Index c = waiting.back(), n = a.rows_below(c), step = padded(n);
            const Place* to = a.local.data() + a.below_start[c];
            if (parts.number[c] >= 0) {
                add(left + parts.left[parts.number[c]], step, to, n, L, width, size, U, rest);
            } else if (thin(a, c)) {
                add_leaf(values + a.value_start[c], a.width(c), to, n, L, width, size, U, rest);
            } else {
                top -= step * step;
                add(top, step, to, n, L, width, size, U, rest);
            }
        }
        const bool large = root < 0 && a.children[s] && double(width) * double(size) * double(size) > SHARED_FROM;
        const Index bad = eliminate(L, width, size, U, rest, large);
        if (bad >= 0) return first + bad;
        if (s == root) {
            std::copy_n(U, rest * rest, left + parts.left[parts.number[s]]);
        } else {
            top = std::copy_n(U, rest * rest, top);
        }
        if (m) waiting.push_back(s);
    }
    return -1;
}
