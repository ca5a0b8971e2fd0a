// Multifrontal Cholesky factorization by supernodes (Duff, Reid 1983; Liu 1992).
//
// The front of a supernode is a dense matrix, assembled from the columns of A in the supernode and
// from the update matrices of its children in the elimination tree.
// After the columns of the supernode have been eliminated,
// the remaining rows and columns of the front form the update matrix, which is added to the front of the parent.
#pragma once
#include "supernodes.hpp"

namespace cholesky {

constexpr double SHARED_FRONT_WORK = 1e8;  // minimum number of operations on a front that threads share
constexpr Index THIN_COLUMNS = 2;          // maximum number of columns of a leaf without a stored update matrix

// Return true if the update matrix of this supernode is computed in its parent's front instead of being stored.
inline bool is_thin_leaf(const Supernodes& a, Index s) { return a.children[s] == 0 && a.width(s) <= THIN_COLUMNS; }

// The sizes of the work space for a set of supernodes.
struct WorkSpace {
    Index front = 0, rest = 0;  // maximum number of entries in the columns to eliminate, and in an update matrix
    Index stack = 0;            // maximum number of entries of update matrices stored at the same time
};

inline WorkSpace measure_workspace(const Supernodes& a, const TreePartition& parts, const std::vector<Index>& which,
                                   Index root) {
    WorkSpace result;
    Index last = 0;
    std::vector<Index> waiting;
    const auto left = [&](Index s) {
        return parts.number[s] >= 0 || is_thin_leaf(a, s) ? 0 : triangle_size(a.rows_below(s));
    };
    for (const Index s : which) {
        if (parts.number[s] < 0 || s == root) {
            const Index rest = is_thin_leaf(a, s) ? 0 : pad_rows(a.rows_below(s));
            result.front = std::max(result.front, a.width(s) * (a.width(s) + a.rows_below(s)));
            result.rest = std::max(result.rest, rest * rest);
            for (Index child = 0; child < a.children[s]; ++child, waiting.pop_back()) last -= left(waiting.back());
        }
        last += left(s);
        result.stack = std::max(result.stack, last);
        if (a.rows_below(s)) waiting.push_back(s);
    }
    return result;
}

// Factor the supernodes `which` in order, and fill in their values of L. Returns the column of a bad pivot, or -1.
//
// `which` are the supernodes of the subtree below `root`.
// The update matrix of the root is written to `left`.
// If `root` is -1, `which` are the supernodes above all subtrees, and the roots of the subtrees,
// whose update matrices are read from `left`.
inline Index factor_supernodes(View<const double> data, const Supernodes& a, const TreePartition& parts,
                               const std::vector<Index>& which, Index root, double* values, double* left) {
    const WorkSpace sizes = measure_workspace(a, parts, which, root);
    // three more entries, because loops over four columns at a time read beyond the end of a front (see fronts.hpp)
    const Array<double> front(sizes.front + 3), space(sizes.rest), stack(sizes.stack);
    double* top = stack.data();
    std::vector<Index> waiting;
    for (const Index s : which) {
        const Index first = a.start[s], width = a.width(s), m = a.rows_below(s), size = width + m;
        // a supernode with a number that is not `root` is the root of a subtree that has been factored: do not
        // factor it again, and let its parent add its update matrix
        if (parts.number[s] >= 0 && s != root) {
            if (m) waiting.push_back(s);
            continue;
        }
        double *L = front.data(), *U = space.data();
        const Index rest = is_thin_leaf(a, s) ? 0 : pad_rows(m);
        std::fill_n(L, width * size, 0.0);
        for (Index i = a.entry_start[s]; i < a.entry_start[s + 1]; ++i) L[a.target[i]] += data[a.source[i]];
        std::fill_n(U, rest * rest, 0.0);
        for (Index child = 0; child < a.children[s]; ++child, waiting.pop_back()) {
            const Index c = waiting.back(), n = a.rows_below(c);
            const FrontIndex* to = a.local.data() + a.below_start[c];
            if (parts.number[c] >= 0) {
                extend_add(left + parts.left[parts.number[c]], to, n, L, width, size, U, rest);
            } else if (is_thin_leaf(a, c)) {
                extend_add_leaf(values + a.value_start[c], a.width(c), to, n, L, width, size, U, rest);
            } else {
                top -= triangle_size(n);
                extend_add(top, to, n, L, width, size, U, rest);
            }
        }
        const bool shared = root < 0 && double(width) * double(size) * double(size) > SHARED_FRONT_WORK;
        const Index bad = factor_front(L, width, size, U, rest, shared);
        if (bad >= 0) return first + bad;
        store_columns(L, width, size, values + a.value_start[s]);
        if (s == root)
            store_update(U, rest, m, left + parts.left[parts.number[s]]);
        else if (rest)
            top = store_update(U, rest, m, top);
        if (m) waiting.push_back(s);
    }
    return -1;
}

}  // namespace cholesky
