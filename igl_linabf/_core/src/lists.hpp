// Lists of items for each node of a graph, and a union-find data structure.
#pragma once
#include <numeric>

#include "arrays.hpp"

// A list of items for each node: node v has items[begin[v]] up to items[begin[v + 1] - 1].
struct Lists {
    std::vector<Index> begin;
    Array<Index> items;

    View<Index> operator[](Index v) const { return items.view().part(begin[v], begin[v + 1]); }
};

// Build the lists of n nodes.
// `visit` is called twice, with a function `put`; each time, it must call put(node, item) for each item.
template <class Visit>
Lists build_lists(Index n, const Visit& visit) {
    Lists result{std::vector<Index>(n + 2), {}};
    Index* begin = result.begin.data();
    visit([=](Index node, Index) {
        check_index(node, n);
        ++begin[node + 2];
    });
    std::partial_sum(begin, begin + n + 2, begin);
    result.items = Array<Index>(begin[n + 1]);
    visit([begin, items = result.items.data()](Index node, Index item) { items[begin[node + 1]++] = item; });
    return result;
}

// A union-find data structure with path halving. The root of each set is its first node.
class UnionFind {
    std::vector<Index> parent;

  public:
    explicit UnionFind(Index n) : parent(n) { std::iota(parent.begin(), parent.end(), Index(0)); }

    Index find(Index i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    }

    // Merge two sets; return true if they were different.
    bool unite(Index i, Index j) {
        i = find(i), j = find(j);
        parent[std::max(i, j)] = std::min(i, j);
        return i != j;
    }

    // Number the sets in the order of their first nodes, and return the number of each node's set.
    Array<Index> labels() const {
        Array<Index> label(Index(parent.size()));
        Index count = 0;
        for (Index i = 0; i < label.size(); ++i) label[i] = parent[i] == i ? count++ : label[parent[i]];
        return label;
    }
};
