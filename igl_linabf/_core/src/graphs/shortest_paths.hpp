// Shortest paths (Dijkstra 1959) to sources, towards targets and to a Steiner point,
// and shortest closed walks of given parities.
#pragma once
#include <array>

#include "../lists.hpp"

namespace graphs {

// A graph in CSR: the edges indptr[i] to indptr[i + 1] - 1 lead from node i to `indices`.
template <class Int>
struct Graph {
    View<const Int> indptr, indices;
    View<const double> length;

    Index nodes() const { return indptr.size - 1; }
};

// A binary min-heap of nodes with keys.
class Heap {
    const double* key;
    Array<Index> heap, place;  // place: position of each node in `heap`; -1 until its insertion
    Index size = 0;

  public:
    Heap(const double* key, Index most) : key(key), heap(most), place(most) {}

    void clear(Index first, Index last) { std::fill(place.data() + first, place.data() + last, Index(-1)); }
    bool empty() const { return size == 0; }
    bool has_seen(Index node) const { return place[node] >= 0; }
    Index first() const { return heap[0]; }

    // Insert a node, or restore the heap after its key has decreased.
    void decrease_key(Index node) {
        if (!has_seen(node)) heap[place[node] = size++] = node;
        Index i = place[node];
        node = heap[i];
        for (Index above; i > 0 && key[heap[above = (i - 1) / 2]] > key[node]; i = above)
            place[heap[i] = heap[above]] = i;
        place[heap[i] = node] = i;
    }

    Index pop() {
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

// A Dijkstra search: the distance and the predecessor of each node, and the heap of open nodes.
struct Search {
    Array<double> distance;
    Array<Index> before;
    Heap waiting;

    // Allocate memory for `most` nodes, and initialize the first `n` of them.
    Search(Index most, Index n) : distance(most), before(most), waiting(distance.data(), most) { clear(0, n); }

    void clear(Index first, Index last) {
        std::fill(distance.data() + first, distance.data() + last, INFINITY);
        std::fill(before.data() + first, before.data() + last, Index(-1));
        waiting.clear(first, last);
    }

    void set_distance(Index node, double way, Index from) {
        distance[node] = way;
        before[node] = from;
        waiting.decrease_key(node);
    }

    // Return the smallest distance of an open node, or infinity if no node is open.
    double smallest_distance() const { return waiting.empty() ? INFINITY : distance[waiting.first()]; }

    // Relax the edges of `node`, which are in row `row` of the graph. accept(edge, way) returns the node whose
    // distance is to be updated to `way`, or -1.
    template <class Int, class Goes>
    void relax(const Graph<Int>& graph, Index row, Index node, const Goes& accept) {
        for (Index edge = graph.indptr[row]; edge < graph.indptr[row + 1]; ++edge) {
            const double way = distance[node] + graph.length[edge];
            if (const Index there = accept(edge, way); there >= 0) set_distance(there, way, node);
        }
    }

    // Relax the edges of the nearest open node. passes(node, there, way) returns true if a shorter path
    // of length `way` from `node` to `there` is accepted.
    template <class Int, class Passes>
    void step(const Graph<Int>& graph, const Passes& passes) {
        const Index node = waiting.pop();
        relax(graph, node, node, [&](Index edge, double way) {
            const Index there = graph.indices[edge];
            return way < distance[there] && passes(node, there, way) ? there : -1;
        });
    }
};

struct Paths {
    Array<double> distance;
    Array<Index> before, source;
};

// Find the nearest source of each node, along paths of `open` nodes.
// Returns the distance, the predecessor and the nearest source of each node.
template <class Int>
Paths nearest_sources(View<const Int> indptr, View<const Int> indices, View<const double> length,
                      View<const Index> sources, View<const bool> open, double limit) {
    const Graph<Int> graph{indptr, indices, length};
    Search search(graph.nodes(), graph.nodes());
    Array<Index> source = full<Index>(graph.nodes(), -1);
    for (const Index node : sources)
        if (open[node] && !search.waiting.has_seen(node)) {
            search.set_distance(node, 0, -1);
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

// Return the distance from a source to each node, and the predecessor of each node.
// A node is skipped if its distance plus lower bounds of the paths from there to all targets exceeds the limit.
// The lower bound of a path is `share` times the distance in space.
template <class Int>
std::tuple<Array<double>, Array<Index>> goal_directed_search(View<const Int> indptr, View<const Int> indices,
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
    Search search(graph.nodes(), graph.nodes());
    std::vector<double> ahead(graph.nodes());
    search.set_distance(source, 0, -1);
    while (!search.waiting.empty())
        search.step(graph, [&](Index, Index there, double way) {
            if (!open[there]) return false;
            if (!search.waiting.has_seen(there)) ahead[there] = left(there);
            return !(way + ahead[there] > limit);
        });
    return {std::move(search.distance), std::move(search.before)};
}

struct SteinerPaths {
    std::vector<Index> nodes, start;
};

// Find the Steiner point of three sets of nodes, which minimizes the total length of the paths to the sets.
// Return the three paths, or no paths if the total length exceeds the limit.
//
// The three searches advance at the same rate.
// A search skips a node if its distance plus a lower bound of the paths
// to the other two sets exceeds the best total so far.
// The lower bound is the smaller of two sums: the sum of the radii of the other two searches,
// and the smallest sum of both distances at a node that both searches have reached.
template <class Int>
SteinerPaths steiner_paths(View<const Int> indptr, View<const Int> indices, View<const double> length,
                           std::array<View<const Index>, 3> sources, View<const bool> open, double limit) {
    const Graph<Int> graph{indptr, indices, length};
    const Index n = graph.nodes();
    Search search[3] = {Search(n, n), Search(n, n), Search(n, n)};
    double apart[3] = {INFINITY, INFINITY, INFINITY};  // smallest sum of a node's distances to the sets other than k
    const auto update_bounds = [&](int k, Index node, double way) {
        for (int j = 0; j < 3; ++j)
            if (j != k) apart[3 - k - j] = std::min(apart[3 - k - j], way + search[j].distance[node]);
    };
    for (int k = 0; k < 3; ++k)
        for (const Index node : sources[k])
            if (!search[k].waiting.has_seen(node)) {
                search[k].set_distance(node, 0, -1);
                update_bounds(k, node, 0);
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
            update_bounds(next, there, way);
            return true;
        });
        top[next] = search[next].smallest_distance();
    }
    SteinerPaths result{{}, {0}};
    for (const Search& one : search) {
        for (Index node = centre; node >= 0; node = one.before[node]) result.nodes.push_back(node);
        result.start.push_back(Index(result.nodes.size()));
    }
    return result;
}

// Return the shortest set of closed walks that together cross each curve an odd number of times,
// or an empty set. found[bits] is the length of the shortest closed walk that crosses exactly the curves
// in `bits` an odd number of times.
inline std::vector<Index> choose_excursions(const std::vector<double>& found) {
    const Index all = Index(found.size()) - 1;
    std::vector<double> best(all + 1, INFINITY);
    std::vector<std::vector<char>> taken(all + 1, std::vector<char>(all + 1));
    best[0] = 0;
    for (Index ways = 1; ways <= all; ++ways) {
        const std::vector<double> before = best;
        for (Index odd = 0; odd <= all; ++odd)
            if (before[odd ^ ways] + found[ways] < best[odd]) {
                best[odd] = before[odd ^ ways] + found[ways];
                taken[ways][odd] = true;
            }
    }
    std::vector<Index> chosen;
    Index left = all;
    for (Index ways = all; ways > 0; --ways)
        if (taken[ways][left]) {
            chosen.push_back(ways);
            left ^= ways;
        }
    return chosen;
}

// Find the shortest closed walk from a node that crosses each of several curves an odd number of times.
// The bits of `flip` are the curves that an edge crosses.
// The search runs in copies of the graph, one for each combination of parities.
// The walk consists of excursions, which pass the start only at their ends.
// Two paths from the start to the same node form an excursion.
// All excursions shorter than twice the smallest distance of an open node have been found.
inline std::vector<Index> shortest_odd_walk(View<const Index> indptr, View<const Index> indices,
                                            View<const double> length, View<const Index> flip, Index start,
                                            Index copies) {
    const Graph<Index> graph{indptr, indices, length};
    const Index n = graph.nodes(), all = copies - 1;
    if (copies < 1 || copies & all) throw std::invalid_argument("the number of copies is not a power of two");
    Search search(copies * n, n);
    const auto& distance = search.distance;
    std::vector<char> begun(copies);  // initialize copies on first use, because most are never reached
    std::vector<Index> first(n, -1);  // head of the linked list of the reached copies of each node
    Array<Index> other_label(copies * n);
    // for each combination of parities: length of the shortest excursion, and of the shortest set of excursions
    std::vector<double> found(copies, INFINITY), cost(copies, INFINITY);
    std::vector<std::array<Index, 2>> ends(copies);
    cost[0] = 0;
    begun[0] = true;
    search.set_distance(start, 0, -1);
    first[start] = start;
    other_label[start] = -1;
    while (!search.waiting.empty() && 2 * search.smallest_distance() < cost[all]) {
        const Index node = search.waiting.pop(), copy = node / n;
        Index label = first[node % n];
        while (label >= 0 && (label == node || distance[label] + cost[copy ^ (label / n)] > distance[node]))
            label = other_label[label];
        if (label >= 0) continue;  // another path to this node, plus excursions, is at least as short
        search.relax(graph, node - copy * n, node, [&](Index edge, double way) {
            const Index vertex = graph.indices[edge], other = copy ^ flip[edge], there = other * n + vertex;
            if (vertex != start) {
                if (!begun[other]) {
                    begun[other] = true;
                    search.clear(other * n, other * n + n);
                }
                if (!(way < distance[there])) return Index(-1);
                if (distance[there] == INFINITY) other_label[there] = std::exchange(first[vertex], there);
            }
            for (Index at = first[vertex]; at >= 0; at = other_label[at]) {
                const Index ways = other ^ (at / n);
                if (!ways || !(way + distance[at] < found[ways])) continue;
                found[ways] = way + distance[at];
                ends[ways] = {node, at};
                for (Index odd = 0; odd < copies; ++odd)
                    if (const Index rest = odd ^ ways; odd < rest) {
                        const double before = cost[odd];
                        cost[odd] = std::min(before, cost[rest] + found[ways]);
                        cost[rest] = std::min(cost[rest], before + found[ways]);
                    }
            }
            return vertex != start ? there : Index(-1);
        });
    }
    std::vector<Index> walk{all * n + start};
    Index copy = all;
    for (const Index ways : choose_excursions(found)) {
        const auto outward = walk.size();
        for (Index at = ends[ways][0]; search.before[at] >= 0; at = search.before[at])
            walk.push_back((copy ^ (at / n)) * n + at % n);
        std::reverse(walk.begin() + outward, walk.end());
        copy ^= ways;
        for (Index at = ends[ways][1]; at >= 0; at = search.before[at])
            walk.push_back((copy ^ (at / n)) * n + at % n);
    }
    return walk;
}

}  // namespace graphs
