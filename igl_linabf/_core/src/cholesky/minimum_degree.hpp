// Fill-reducing ordering by approximate minimum degree (Amestoy, Davis, Duff 1996).
//
// The elimination graph is represented by a quotient graph.
// An eliminated variable becomes an element: the list of the variables that its elimination connects.
// The list of a variable contains its elements, followed by its variables.
// The degree of a variable is bounded by the sum of the sizes of its elements.
// Indistinguishable variables, which have the same lists, are merged into one variable of larger weight.
#pragma once
#include "elimination_tree.hpp"

namespace cholesky {

constexpr double DENSE_FACTOR = 10.0;  // rows with a degree above DENSE_FACTOR * sqrt(n) are ordered last

template <class I>
class MinimumDegree {
    using Int = Index;
    using RowIndices = std::vector<RowIndex>;
    using Indices32 = std::vector<std::uint32_t>;

    View<const I> indptr, indices;
    Int n;
    std::vector<Int> begin;  // start of the list of each variable or element
    Indices32 lists, size, elements, degree, after, before, tail, key;
    RowIndices weight, parent, follower, first_alike, alike;
    std::vector<char> pivot;
    std::vector<Int> mark;  // time stamp of each element, compared with `flag`; 0 for absorbed elements
    Int flag = 2;

    // Build the list of each variable, and reserve space for the lists of elements after all lists of variables.
    void build_graph() {
        for (Int j = 0; j < n; ++j)
            for (I p = indptr[j]; p < indptr[j + 1]; ++p)
                if (const Int i = indices[p]; i != j) ++begin[i + 2], ++begin[j + 2];
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        lists.resize(2 * begin[n + 1]);
        for (Int j = 0; j < n; ++j)
            for (I p = indptr[j]; p < indptr[j + 1]; ++p)
                if (const Int i = indices[p]; i != j) {
                    lists[begin[i + 1]++] = j;
                    lists[begin[j + 1]++] = i;
                }
    }

    // Absorb variable j into i: j is ordered directly after i.
    void absorb(Int i, Int j) {
        weight[j] = 0;
        follower[tail[i]] = j;
        tail[i] = tail[j];
    }

    // Insert variable i at the front of the circular list of degree d, whose sentinel is n + d.
    void insert(Int i, Int d) {
        const auto ring = n + d, other = Int(after[ring]);
        after[ring] = i, after[i] = other;
        before[other] = i, before[i] = ring;
    }

    // Remove variable i from its degree list.
    void remove(Int i) {
        const auto next = after[i], last = before[i];
        after[last] = next, before[next] = last;
    }

    // Set mark[e] to flag plus the number of variables of the older element e outside the new element.
    // The new element consists of the variables lists[place .. at - 1], whose weights are negative.
    void scan_elements(Int place, Int at) {
        for (Int p = place; p < at; ++p) {
            const auto i = lists[p];
            const auto w = weight[i];
            for (Int q = begin[i]; q < begin[i] + elements[i]; ++q) {
                const auto e = lists[q];
                const Int m = mark[e];
                mark[e] = m ? (m >= flag ? m : degree[e] + flag) + w : 0;
            }
        }
    }

    // Merge the indistinguishable variables in a chain of variables with the same hash key.
    void merge_indistinguishable(RowIndex k) {
        while (k >= 0 && alike[k] >= 0) {
            const Int i = k;
            for (Int q = begin[i] + 1; q < begin[i] + size[i]; ++q) mark[lists[q]] = flag;
            Int last = i;
            k = alike[i];
            while (k >= 0) {
                const Int j = k, end = begin[j] + size[j];
                bool same = size[j] == size[i] && elements[j] == elements[i];
                for (Int q = begin[j] + 1; same && q < end; ++q) same = mark[lists[q]] == flag;
                if (same) {
                    weight[i] += weight[j];
                    absorb(i, j);
                    alike[last] = alike[j];
                } else {
                    last = j;
                }
                k = alike[j];
            }
            ++flag;
            k = alike[i];
        }
    }

    // Return the variables in a postorder of the tree of elements. Variables that are in no element come last.
    std::vector<Int> postorder() const {
        std::vector<Int> order;
        order.reserve(n);
        RowIndices waiting, child(n, -1), sibling(n, -1);
        std::vector<char> placed(n, false);
        RowIndex e = -1;
        for (Int i = n - 1; i >= 0; --i) {
            if (!pivot[i]) continue;
            RowIndex& first = parent[i] >= 0 ? child[parent[i]] : e;
            sibling[i] = first;
            first = i;
        }
        while (e >= 0 || !waiting.empty()) {
            if (e >= 0) {
                waiting.push_back(e);
                e = child[e];
                continue;
            }
            RowIndex i = waiting.back();
            waiting.pop_back();
            e = sibling[i];
            for (; i >= 0; i = follower[i]) order.push_back(i), placed[i] = true;
        }
        for (Int i = 0; i < n; ++i)
            if (!placed[i]) order.push_back(i);
        return order;
    }

  public:
    MinimumDegree(View<const I> indptr, View<const I> indices)
        : indptr(indptr), indices(indices), n(indptr.size - 1), begin(n + 2), size(n), elements(n), degree(n),
          after(2 * n + 1), before(2 * n + 1), tail(n), key(n), weight(n, 1), parent(n, -1), follower(n, -1),
          first_alike(n, -1), alike(n), pivot(n), mark(n, 1) {
        build_graph();
        std::iota(after.begin(), after.end(), 0);
        std::iota(before.begin(), before.end(), 0);
        std::iota(tail.begin(), tail.end(), 0);
    }

    std::vector<Int> order() {
        Int free = begin[n], done = 0, least = 0;
        const double dense = std::max(16.0, DENSE_FACTOR * std::sqrt(n));
        for (Int i = n - 1; i >= 0; --i) {
            const Int d = size[i] = degree[i] = begin[i + 1] - begin[i];
            if (d > dense) {
                weight[i] = 0;
                ++done;
            } else {
                insert(i, d);
            }
        }
        const bool some_left = done > 0;
        while (done < n) {
            while (after[n + least] == n + least) ++least;
            const Int me = after[n + least];
            remove(me);
            done += weight[me];
            weight[me] = -weight[me];
            // collect the variables of the new element, and negate their weights
            const Int first = begin[me], old = elements[me], own = first + old;
            Int place = first;
            if (old) {
                place = free;
                Int room = size[me];
                for (Int p = first; p < own; ++p) room += size[lists[p]];
                if (free + room > Int(lists.size())) lists.resize(2 * lists.size() + room);
            }
            Int at = place, total = 0;
            for (Int q = 0; q <= old; ++q) {
                const Int e = q < old ? lists[first + q] : me, low = q < old ? begin[e] : own;
                for (Int p = low, end = begin[e] + size[e]; p < end; ++p) {
                    const Int i = lists[p], w = weight[i];
                    if (w > 0) {
                        total += w;
                        weight[i] = -w;
                        lists[at++] = i;
                        remove(i);
                    }
                }
                if (q < old) parent[e] = me, mark[e] = 0;
            }
            begin[me] = place, degree[me] = total, elements[me] = 0, pivot[me] = true;
            scan_elements(place, at);
            for (Int p = place; p < at; ++p) {
                const Int i = lists[p], low = begin[i], middle = low + elements[i], end = low + size[i];
                Int to = low, d = 0, code = 0;
                for (Int q = low; q < middle; ++q) {
                    const Int e = lists[q], m = mark[e];
                    lists[to] = e;  // written in any case, because a branch would be unpredictable
                    d += m ? m - flag : 0;
                    code += m ? e : 0;
                    to += m ? 1 : 0;
                }
                const Int between = to;
                for (Int q = middle; q < end; ++q) {
                    const Int j = lists[q], w = weight[j];
                    lists[to] = j;
                    d += w > 0 ? w : 0;
                    code += w > 0 ? j : 0;
                    to += w > 0 ? 1 : 0;
                }
                if (to == low) {  // mass elimination: the variable is adjacent to the new element only
                    done -= weight[i];
                    total += weight[i];
                    absorb(me, i);
                    continue;
                }
                degree[i] = std::min<Int>(degree[i], d);
                lists[to] = lists[between], lists[between] = lists[low], lists[low] = me;  // new element first
                elements[i] = between - low + 1, size[i] = to - low + 1;
                code %= n;
                key[i] = code;
                alike[i] = first_alike[code];
                first_alike[code] = i;
            }
            degree[me] = total;
            flag += n;  // now larger than all marks
            for (Int p = place; p < at; ++p)
                if (const auto i = lists[p]; weight[i] != 0) {
                    const auto chain = first_alike[key[i]];
                    first_alike[key[i]] = -1;
                    merge_indistinguishable(chain);
                }
            Int to = place;
            for (Int p = place; p < at; ++p) {
                const Int i = lists[p];
                if (weight[i] == 0) continue;
                const Int w = weight[i] = -weight[i];
                const Int d = std::min<Int>(degree[i] + total - w, n - done - w);
                degree[i] = d;
                insert(i, d);
                least = std::min(least, d);
                lists[to++] = i;
            }
            size[me] = to - place, weight[me] = 0;
            if (old) free = to;
        }
        auto result = postorder();
        if (!some_left) return result;
        parent = elimination_tree(transpose(permute(indptr, indices, result)));  // with dense rows
        std::fill(follower.begin(), follower.end(), -1);
        std::fill(pivot.begin(), pivot.end(), true);
        auto place = postorder();
        for (Int& i : place) i = result[i];
        return place;
    }
};

}  // namespace cholesky
