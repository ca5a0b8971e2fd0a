// Items listed by node, and sets of nodes that are joined.
#pragma once
#include <numeric>

#include "arrays.hpp"

// The items of node v are those from begin[v] up to begin[v + 1].
struct Lists {
    std::vector<Index> begin;
    Array<Index> items;

    View<Index> operator[](Index v) const { return items.view().part(begin[v], begin[v + 1]); }
};

// The items of n nodes: visit(put) calls put(node, item) for each, and is called twice.
template <class Visit>
Lists lists_of(Index n, const Visit& visit) {
    Lists made{std::vector<Index>(n + 2), {}};
    Index* begin = made.begin.data();
    visit([=](Index node, Index) { ++begin[node + 2]; });
    std::partial_sum(begin, begin + n + 2, begin);
    made.items = Array<Index>(begin[n + 1]);
    visit([begin, items = made.items.data()](Index node, Index item) { items[begin[node + 1]++] = item; });
    return made;
}

// Disjoint sets of nodes (union-find with path halving); the root of each is its first node.
class Joined {
    std::vector<Index> parent;

  public:
    explicit Joined(Index n) : parent(n) { std::iota(parent.begin(), parent.end(), Index(0)); }

    Index root(Index i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    }

    // Whether they were apart.
    bool join(Index i, Index j) {
        i = root(i), j = root(j);
        parent[std::max(i, j)] = std::min(i, j);
        return i != j;
    }

    // The number of each node's set, in the order of their first nodes.
    Array<Index> labels() const {
        Array<Index> label(Index(parent.size()));
        Index count = 0;
        for (Index i = 0; i < label.size(); ++i) label[i] = parent[i] == i ? count++ : label[parent[i]];
        return label;
    }
};
