// Shortest paths (Dijkstra 1959): to sources, towards targets, and to where three meet.
#pragma once
#include <array>

#include "../lists.hpp"

namespace graphs {

// A graph in CSR: the edges from node i are those from indptr[i] up to indptr[i + 1], to `indices`.
template <class Int>
struct Graph {
    View<const Int> indptr, indices;
    View<const double> length;

    Index nodes() const { return indptr.size - 1; }
};

// Nodes in a binary heap, the one of the least key first.
class Heap {
    const double* key;
    Array<Index> heap, place;  // the place of each node that is in the heap or was
    Index size = 0;

  public:
    Heap(const double* key, Index n) : key(key), heap(n), place(n) { std::fill_n(place.data(), n, Index(-1)); }

    bool empty() const { return size == 0; }
    bool knows(Index node) const { return place[node] >= 0; }
    Index first() const { return heap[0]; }

    // Put a node where its key, which is new or less than before, belongs.
    void rise(Index node) {
        if (!knows(node)) heap[place[node] = size++] = node;
        Index i = place[node];
        node = heap[i];
        for (Index above; i > 0 && key[heap[above = (i - 1) / 2]] > key[node]; i = above)
            place[heap[i] = heap[above]] = i;
        place[heap[i] = node] = i;
    }

    Index take_first() {
        const Index first = heap[0], node = heap[--size];
        Index i = 0;
        for (Index child; (child = 2 * i + 1) < size; i = child) {
            if (child + 1 < size && key[heap[child + 1]] < key[heap[child]]) ++child;
            if (key[heap[child]] >= key[node]) break;
            place[heap[i] = heap[child]] = i;
        }
        place[heap[i] = node] = i;
        return first;
    }
};

// A search from sources: the distance of each node, the node before it on its path, and those that wait.
struct Search {
    Array<double> distance;
    Array<Index> before;
    Heap waiting;

    explicit Search(Index n) : distance(n), before(n), waiting(distance.data(), n) {
        std::fill_n(distance.data(), n, INFINITY);
        std::fill_n(before.data(), n, Index(-1));
    }

    void reach(Index node, double way, Index from) {
        distance[node] = way;
        before[node] = from;
        waiting.rise(node);
    }

    // The least distance of a node that waits.
    double least() const { return waiting.empty() ? INFINITY : distance[waiting.first()]; }

    // Go on from the nearest node that waits. passes(node, there, way) says whether a way that is shorter is taken.
    template <class Int, class Passes>
    void step(const Graph<Int>& graph, const Passes& passes) {
        const Index node = waiting.take_first();
        for (Index edge = graph.indptr[node]; edge < graph.indptr[node + 1]; ++edge) {
            const double way = distance[node] + graph.length[edge];
            const Index there = graph.indices[edge];
            if (way < distance[there] && passes(node, there, way)) reach(there, way, node);
        }
    }
};

struct Paths {
    Array<double> distance;
    Array<Index> before, source;
};

// The distance of each node to the nearest source over open nodes, the node before it, and that source.
template <class Int>
Paths nearest_sources(View<const Int> indptr, View<const Int> indices, View<const double> length,
                      View<const Index> sources, View<const bool> open, double limit) {
    const Graph<Int> graph{indptr, indices, length};
    Search search(graph.nodes());
    Array<Index> source = filled<Index>(graph.nodes(), -1);
    for (const Index node : sources)
        if (open[node] && !search.waiting.knows(node)) {
            search.reach(node, 0, -1);
            source[node] = node;
        }
    limit = std::max(limit, 0.0);
    while (!search.waiting.empty())
        search.step(graph, [&](Index node, Index there, double way) {
            if (!open[there] || !(way <= limit)) return false;
            source[there] = source[node];
            return true;
        });
    return {std::move(search.distance), std::move(search.before), std::move(source)};
}

// The distances from a node, and the nodes before, where all ways on to the targets stay within a limit. What is left
// of a way from a node, at `position`, to a target is at least `share` of the distance in space.
template <class Int>
std::tuple<Array<double>, Array<Index>> ways_towards(View<const Int> indptr, View<const Int> indices,
                                                     View<const double> length, Index source, View<const bool> open,
                                                     Matrix<const double> position, Matrix<const double> targets,
                                                     double share, double limit) {
    const Graph<Int> graph{indptr, indices, length};
    const auto left = [=](Index node) {
        double sum = 0;
        for (Index k = 0; k < targets.rows; ++k) {
            double squared = 0;
            for (Index j = 0; j < 3; ++j) {
                const double d = position[node][j] - targets[k][j];
                squared += d * d;
            }
            sum += share * std::sqrt(squared);
        }
        return sum;
    };
    Search search(graph.nodes());
    std::vector<double> ahead(graph.nodes());
    search.reach(source, 0, -1);
    while (!search.waiting.empty())
        search.step(graph, [&](Index, Index there, double way) {
            if (!open[there]) return false;
            if (!search.waiting.knows(there)) ahead[there] = left(there);
            return !(way + ahead[there] > limit);
        });
    return {std::move(search.distance), std::move(search.before)};
}

struct Ways {
    std::vector<Index> nodes, start;
};

// The node from which the ways to three sets are shortest in total, and these ways; none if that is over the limit.
// The searches grow at the same rate. None goes on to where the ways to the other two sets are over the limit, as
// long as these are at least: what a node was found with that both have reached, or as far as they have come.
template <class Int>
Ways meeting(View<const Int> indptr, View<const Int> indices, View<const double> length,
             std::array<View<const Index>, 3> sources, View<const bool> open, double limit) {
    const Graph<Int> graph{indptr, indices, length};
    const Index n = graph.nodes();
    Search search[3] = {Search(n), Search(n), Search(n)};
    double apart[3] = {INFINITY, INFINITY, INFINITY};  // at least, the ways to the sets other than k
    const auto note = [&](int k, Index node, double way) {
        for (int j = 0; j < 3; ++j)
            if (j != k) apart[3 - k - j] = std::min(apart[3 - k - j], way + search[j].distance[node]);
    };
    for (int k = 0; k < 3; ++k)
        for (const Index node : sources[k])
            if (!search[k].waiting.knows(node)) {
                search[k].reach(node, 0, -1);
                note(k, node, 0);
            }
    std::vector<char> done(n);
    Index centre = -1;
    for (double top[3] = {0, 0, 0}, reach[3], best = limit;;) {
        int next = -1;
        for (int k = 0; k < 3; ++k) {
            reach[k] = best * (1 + 1e-9) - std::min(apart[k], top[(k + 1) % 3] + top[(k + 2) % 3]);
            if (!search[k].waiting.empty() && top[k] <= reach[k] && (next < 0 || top[k] < top[next])) next = k;
        }
        if (next < 0) break;
        const Index node = search[next].waiting.first();
        if (++done[node] == 3) {
            const double total = search[0].distance[node] + search[1].distance[node] + search[2].distance[node];
            if (total < best || (total == best && (centre < 0 || node < centre))) best = total, centre = node;
        }
        search[next].step(graph, [&](Index, Index there, double way) {
            if (!open[there] || !(way <= reach[next])) return false;
            note(next, there, way);
            return true;
        });
        top[next] = search[next].least();
    }
    Ways made{{}, {0}};
    for (const Search& one : search) {
        for (Index node = centre; node >= 0; node = one.before[node]) made.nodes.push_back(node);
        made.start.push_back(Index(made.nodes.size()));
    }
    return made;
}

}  // namespace graphs
