// The Cholesky factorisation of a sparse matrix by supernodes (Duff, Reid 1983; Liu 1992).
//
// The front of a supernode is a dense matrix: the rows of A that belong to its columns, and what its children in
// the elimination tree leave. The front's columns are eliminated; what is left of the front goes to its parent.
#pragma once
#include "supernodes.hpp"

namespace cholesky {

constexpr double SHARED_FROM = 1e8;  // operations at a front above the subtrees from which threads share them
constexpr Index THIN = 2;              // columns up to which what a leaf leaves goes to its parent's front at once

// Whether what this supernode leaves is not stored.
inline bool thin(const Supernodes& a, Index s) { return a.children[s] == 0 && a.width(s) <= THIN; }

// Sizes of the work space for some supernodes.
struct Space {
    Index front = 0, rest = 0;  // of the largest front: its eliminated columns, and what is left
    Index stack = 0;            // the most that fronts leave for their parents at a time
};

inline Space space_for(const Supernodes& a, const Division& parts, const std::vector<Index>& which, Index root) {
    Space made;
    Index last = 0;
    std::vector<Index> waiting;
    const auto left = [&](Index s) { return parts.number[s] >= 0 || thin(a, s) ? 0 : triangle(a.rows_below(s)); };
    for (const Index s : which) {
        if (parts.number[s] < 0 || s == root) {
            const Index rest = thin(a, s) ? 0 : padded(a.rows_below(s));
            made.front = std::max(made.front, a.width(s) * (a.width(s) + a.rows_below(s)));
            made.rest = std::max(made.rest, rest * rest);
            for (Index child = 0; child < a.children[s]; ++child, waiting.pop_back()) last -= left(waiting.back());
        }
        last += left(s);
        made.stack = std::max(made.stack, last);
        if (a.rows_below(s)) waiting.push_back(s);
    }
    return made;
}

// Fill L's values by some supernodes in order; the place of a bad pivot, or -1.
//
// These are those of the subtree with this root. With root -1 they are those above all subtrees, and the roots of
// these, which leave their rests in `left`.
inline Index eliminate(View<const double> data, const Supernodes& a, const Division& parts,
                       const std::vector<Index>& which, Index root, double* values, double* left) {
    const Space sizes = space_for(a, parts, which, root);
    const Array<double> front(sizes.front + 3), space(sizes.rest), stack(sizes.stack);  // +3: loops read by fours
    double* top = stack.data();
    std::vector<Index> waiting;
    for (const Index s : which) {
        const Index first = a.start[s], width = a.width(s), m = a.rows_below(s), size = width + m;
        if (parts.number[s] >= 0 && s != root) {  // it is done
            if (m) waiting.push_back(s);
            continue;
        }
        double *L = front.data(), *U = space.data();
        const Index rest = thin(a, s) ? 0 : padded(m);
        std::fill_n(L, width * size, 0.0);
        for (Index i = a.entry_start[s]; i < a.entry_start[s + 1]; ++i) L[a.target[i]] += data[a.source[i]];
        std::fill_n(U, rest * rest, 0.0);
        for (Index child = 0; child < a.children[s]; ++child, waiting.pop_back()) {
            const Index c = waiting.back(), n = a.rows_below(c);
            const Place* to = a.local.data() + a.below_start[c];
            if (parts.number[c] >= 0) {
                add(left + parts.left[parts.number[c]], to, n, L, width, size, U, rest);
            } else if (thin(a, c)) {
                add_leaf(values + a.value_start[c], a.width(c), to, n, L, width, size, U, rest);
            } else {
                top -= triangle(n);
                add(top, to, n, L, width, size, U, rest);
            }
        }
        const bool shared = root < 0 && double(width) * double(size) * double(size) > SHARED_FROM;
        const Index bad = eliminate(L, width, size, U, rest, shared);
        if (bad >= 0) return first + bad;
        store(L, width, size, values + a.value_start[s]);
        if (s == root)
            keep(U, rest, m, left + parts.left[parts.number[s]]);
        else if (rest)
            top = keep(U, rest, m, top);
        if (m) waiting.push_back(s);
    }
    return -1;
}

}  // namespace cholesky
