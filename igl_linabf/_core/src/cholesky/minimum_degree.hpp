// An order of elimination with little fill, by approximate minimum degree.
//
// Amestoy, Davis, Duff (1996). An eliminated variable becomes an element: the list of the variables that it has
// joined to each other. A variable has a list of elements, then one of variables. Its degree is bounded by the
// sum of what is in its elements. Variables with the same lists are one, of larger weight.
#pragma once
#include "elimination_tree.hpp"

namespace cholesky {

constexpr double DENSE = 10.0;  // times the root of the number of rows: degree above which a row comes last

template <class I>
class MinimumDegree {
    using Int = Index;
    using Numbers = std::vector<Number>;
    using Places = std::vector<std::uint32_t>;

    View<const I> indptr, indices;
    Int n;
    std::vector<Int> begin;  // of each variable's list: elements first
    Places lists, size, elements, degree, after, before, tail, key;
    Numbers weight, parent, follower, first_alike, alike;
    std::vector<char> pivot;
    std::vector<Int> mark;  // 0 at dead elements
    Int flag = 2;

    // The list of each variable, with space for elements at the end.
    void link() {
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

    // Let variable j be eliminated with i, right after it.
    void join(Int i, Int j) {
        weight[j] = 0;
        follower[tail[i]] = j;
        tail[i] = tail[j];
    }

    // Put variable i first into the ring of degree d, which begins and ends at n + d.
    void list(Int i, Int d) {
        const auto ring = n + d, other = Int(after[ring]);
        after[ring] = i, after[i] = other;
        before[other] = i, before[i] = ring;
    }

    // Take variable i out of its ring.
    void unlist(Int i) {
        const auto next = after[i], last = before[i];
        after[last] = next, before[next] = last;
    }

    // Let mark - flag be how much of each older element is not in the new one, which is listed there.
    //
    // The weights of the new one's variables are negative.
    void meet(Int place, Int at) {
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

    // Join the variables with the same lists in a chain of those with one key.
    void merge(Number k) {
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
                    join(i, j);
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

    // The variables of all elements, children in a tree first; what is in none comes last.
    std::vector<Int> in_postorder() const {
        std::vector<Int> order;
        order.reserve(n);
        Numbers waiting, child(n, -1), sibling(n, -1);
        std::vector<char> placed(n, false);
        Number e = -1;
        for (Int i = n - 1; i >= 0; --i) {
            if (!pivot[i]) continue;
            Number& first = parent[i] >= 0 ? child[parent[i]] : e;
            sibling[i] = first;
            first = i;
        }
        while (e >= 0 || !waiting.empty()) {
            if (e >= 0) {
                waiting.push_back(e);
                e = child[e];
                continue;
            }
            Number i = waiting.back();
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
        link();
        std::iota(after.begin(), after.end(), 0);
        std::iota(before.begin(), before.end(), 0);
        std::iota(tail.begin(), tail.end(), 0);
    }

    std::vector<Int> order() {
        Int free = begin[n], done = 0, least = 0;
        const double dense = std::max(16.0, DENSE * std::sqrt(n));
        for (Int i = n - 1; i >= 0; --i) {
            const Int d = size[i] = degree[i] = begin[i + 1] - begin[i];
            if (d > dense) {
                weight[i] = 0;
                ++done;
            } else {
                list(i, d);
            }
        }
        const bool some_left = done > 0;
        while (done < n) {
            while (after[n + least] == n + least) ++least;
            const Int me = after[n + least];
            unlist(me);
            done += weight[me];
            weight[me] = -weight[me];
            // the new element's variables, whose weights are negative from now on
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
                        unlist(i);
                    }
                }
                if (q < old) parent[e] = me, mark[e] = 0;
            }
            begin[me] = place, degree[me] = total, elements[me] = 0, pivot[me] = true;
            meet(place, at);
            for (Int p = place; p < at; ++p) {
                const Int i = lists[p], low = begin[i], middle = low + elements[i], end = low + size[i];
                Int to = low, d = 0, code = 0;
                for (Int q = low; q < middle; ++q) {
                    const Int e = lists[q], m = mark[e];
                    lists[to] = e;  // without a branch, which would often be mispredicted
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
                if (to == low) {  // it is in the new element only: eliminated with it
                    done -= weight[i];
                    total += weight[i];
                    join(me, i);
                    continue;
                }
                degree[i] = std::min<Int>(degree[i], d);
                lists[to] = lists[between], lists[between] = lists[low], lists[low] = me;  // first of the elements
                elements[i] = between - low + 1, size[i] = to - low + 1;
                code %= n;
                key[i] = code;
                alike[i] = first_alike[code];
                first_alike[code] = i;
            }
            degree[me] = total;
            flag += n;  // above all marks
            for (Int p = place; p < at; ++p)
                if (const auto i = lists[p]; weight[i] != 0) {
                    const auto chain = first_alike[key[i]];
                    first_alike[key[i]] = -1;
                    merge(chain);
                }
            Int to = place;
            for (Int p = place; p < at; ++p) {
                const Int i = lists[p];
                if (weight[i] == 0) continue;
                const Int w = weight[i] = -weight[i];
                const Int d = std::min<Int>(degree[i] + total - w, n - done - w);
                degree[i] = d;
                list(i, d);
                least = std::min(least, d);
                lists[to++] = i;
            }
            size[me] = to - place, weight[me] = 0;
            if (old) free = to;
        }
        auto made = in_postorder();
        if (!some_left) return made;
        parent = elimination_tree(rows_of(permuted(indptr, indices, made)));  // by links that no element knows of
        std::fill(follower.begin(), follower.end(), -1);
        std::fill(pivot.begin(), pivot.end(), true);
        auto place = in_postorder();
        for (Int& i : place) i = made[i];
        return place;
    }
};

}  // namespace cholesky
