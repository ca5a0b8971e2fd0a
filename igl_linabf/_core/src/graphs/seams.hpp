// Seams as graphs: paths, trees, arcs, the topology of cut surfaces, and minimum cuts.
#pragma once
#include "../lists.hpp"

namespace graphs {

// Return the nodes on the paths from `ends` back to their sources, without the sources and without duplicates.
// `before` is the predecessor of each node, or -1 at sources.
inline std::vector<Index> path_nodes(View<const Index> before, View<const Index> ends) {
    std::vector<char> passed(before.size);
    std::vector<Index> found;
    for (Index node : ends)
        for (; before[node] >= 0 && !passed[node]; node = before[node]) {
            passed[node] = true;
            found.push_back(node);
        }
    return found;
}

// Find a path with the fewest edges between two sets of nodes, given as the masks `sources` and `ends`.
// Returns the nodes of the path, from an end back to a source.
inline std::vector<Index> breadth_first_path(View<const Index> indptr, View<const Index> indices,
                                             View<const bool> sources, View<const bool> ends) {
    const Index n = indptr.size - 1;
    std::vector<Index> before(n, -2), queue, way;
    for (Index node = 0; node < n; ++node)
        if (sources[node]) {
            before[node] = -1;
            queue.push_back(node);
        }
    for (std::size_t done = 0; done < queue.size() && way.empty(); ++done) {
        const Index node = queue[done];
        if (ends[node])
            for (Index at = node; at >= 0; at = before[at]) way.push_back(at);
        for (Index at = indptr[node]; at < indptr[node + 1]; ++at)
            if (before[indices[at]] == -2) {
                before[indices[at]] = node;
                queue.push_back(indices[at]);
            }
    }
    return way;
}

// Choose nodes greedily in the given order, skipping nodes within `hops` edges of a chosen node.
// Paths do not pass `closed` nodes.
// Returns a mask.
template <class Int>
Array<bool> choose_distant_nodes(View<const Int> indptr, View<const Int> indices, View<const Index> order, Index hops,
                                 View<const bool> closed) {
    const Index n = indptr.size - 1;
    Array<bool> chosen = full(n, false);
    std::vector<char> near(closed.begin(), closed.end());
    std::vector<Index> seen(n, -1), queue;
    for (const Index node : order) {
        if (near[node]) continue;
        chosen[node] = true;
        seen[node] = node;
        queue.assign(1, node);
        std::size_t done = 0;
        for (Index hop = 0; hop < hops; ++hop)
            for (const std::size_t last = queue.size(); done < last; ++done)
                for (Index at = indptr[queue[done]]; at < indptr[queue[done] + 1]; ++at)
                    if (const Index there = indices[at]; seen[there] != node && !closed[there]) {
                        seen[there] = node;
                        near[there] = true;
                        queue.push_back(there);
                    }
    }
    return chosen;
}

// Return the parent of each node of a forest. The root of a tree is its first node, whose parent is itself.
inline Array<Index> forest_parents(Matrix<const Index> pairs, Index n) {
    const Lists beside = build_lists(n, [&](const auto& put) {
        for (Index e = 0; e < pairs.rows; ++e) put(pairs[e][0], pairs[e][1]), put(pairs[e][1], pairs[e][0]);
    });
    Array<Index> above = full<Index>(n, -1);
    std::vector<Index> queue;
    for (Index root = 0; root < n; ++root) {
        if (above[root] >= 0) continue;
        above[root] = root;
        queue.assign(1, root);
        for (std::size_t done = 0; done < queue.size(); ++done)
            for (const Index there : beside[queue[done]])
                if (above[there] < 0) {
                    above[there] = queue[done];
                    queue.push_back(there);
                }
    }
    return above;
}

// Prune leaves repeatedly, and return a mask of the remaining edges. Nodes in `kept` are never pruned.
inline Array<bool> prune_leaves(Matrix<const Index> ends, View<const bool> kept) {
    std::vector<Index> degree(kept.size), edges(kept.size);  // XOR of the edges of a node: the only edge of a leaf
    const auto change = [&](Index e, Index by) {
        for (int k = 0; k < 2; ++k) degree[ends[e][k]] += by, edges[ends[e][k]] ^= e;
    };
    for (Index e = 0; e < ends.rows; ++e) change(e, 1);
    Array<bool> left = full(ends.rows, true);
    for (Index i = 0; i < 2 * ends.rows; ++i)
        for (Index node = ends.data[i]; degree[node] == 1 && !kept[node];) {
            const Index last = edges[node];
            left[last] = false;
            change(last, -1);
            node = ends[last][0] + ends[last][1] - node;
        }
    return left;
}

struct Arcs {
    Array<Index> edges;
    std::vector<Index> nodes, start;
};

// Divide the edges of a graph into arcs between joints, followed by closed arcs without a joint.
// Nodes that are not joints must have two edges.
// The edges of arc k begin at start[k]; its nodes begin at start[k] + k, because each arc has one more node than edges.
inline Arcs split_arcs(Matrix<const Index> ends, View<const bool> joint) {
    const Index n = joint.size, m = ends.rows;
    std::vector<Index> order;  // nodes in the order of their first occurrence in `ends`
    std::vector<char> known(n), taken(m);
    for (Index i = 0; i < 2 * m; ++i)
        if (!std::exchange(known[ends.data[i]], true)) order.push_back(ends.data[i]);
    const Lists sides = build_lists(n, [&](const auto& put) {  // half-edge 2 e + k leaves node ends[e, k]
        for (Index h = 0; h < 2 * m; ++h) put(ends.data[h], h);
    });
    Arcs result{Array<Index>(m), {}, {0}};
    Index size = 0;
    for (const bool closed : {false, true})
        for (const Index first : order) {
            if (!closed && !joint[first]) continue;
            for (Index h : sides[first]) {
                if (taken[h / 2]) continue;
                result.nodes.push_back(first);
                while (true) {
                    result.edges[size++] = h / 2;
                    taken[h / 2] = true;
                    const Index node = ends.data[h ^ 1];
                    result.nodes.push_back(node);
                    if (joint[node] || node == first) break;
                    const View<Index> own = sides[node];
                    h = own[own[0] / 2 == h / 2];
                }
                result.start.push_back(size);
            }
        }
    return result;
}

struct CutTopology {
    Index number, cycles;
    std::vector<Index> sizes;
};

// Analyse the topology of a surface that is cut along a seam.
// Returns the number of components of the seam, including the holes; its number of independent cycles;
// and the numbers of faces of the resulting pieces, ascending.
inline CutTopology cut_topology(Matrix<const Index> ends, Matrix<const Index> faces, View<const Index> seam,
                                Index holes, Index n, Index n_faces) {
    if (holes > n) throw std::invalid_argument("more holes than nodes");
    std::vector<char> on(ends.rows), on_seam(n);
    std::fill_n(on_seam.begin(), holes, true);
    CutTopology result{holes, 0, {n_faces}};
    UnionFind sets(n);
    for (const Index e : seam) {
        if (std::exchange(on[e], true)) continue;
        for (int k = 0; k < 2; ++k) result.number += !std::exchange(on_seam[ends[e][k]], true);
        const bool apart = sets.unite(ends[e][0], ends[e][1]);
        result.number -= apart;
        result.cycles += !apart;
    }
    if (!result.cycles) return result;  // a forest does not separate the surface
    UnionFind pieces(n_faces);
    Index left = n_faces;
    for (Index e = 0; e < faces.rows && left > 1; ++e)
        if (!on[e]) left -= pieces.unite(faces[e][0], faces[e][1]);
    if (left == 1) return result;
    result.sizes.assign(left, 0);
    const Array<Index> label = pieces.labels();
    for (Index face = 0; face < n_faces; ++face) ++result.sizes[label[face]];
    std::sort(result.sizes.begin(), result.sizes.end());
    return result;
}

// A flow network; edge e consists of the arcs 2 e and 2 e + 1.
struct Network {
    std::vector<Index> head, left, level;  // head and residual capacity of each arc, level of each node
    Lists arcs;                            // arcs that leave each node

    Network(Matrix<const Index> ends, View<const Index> capacity, Index n)
        : head(2 * ends.rows), left(2 * ends.rows), level(n) {
        for (Index a = 0; a < 2 * ends.rows; ++a) {
            head[a] = ends.data[a ^ 1];
            left[a] = capacity[a / 2];
        }
        arcs = build_lists(n, [&](const auto& put) {
            for (Index a = 0; a < 2 * ends.rows; ++a) put(ends.data[a], a);
        });
    }

    // Compute the level of each node: its distance from the source over arcs with residual capacity, or -1.
    void find_levels(Index source) {
        std::fill(level.begin(), level.end(), Index(-1));
        std::vector<Index> queue{source};
        level[source] = 0;
        for (std::size_t done = 0; done < queue.size(); ++done) {
            const Index node = queue[done];
            for (const Index a : arcs[node])
                if (left[a] > 0 && level[head[a]] < 0) {
                    level[head[a]] = level[node] + 1;
                    queue.push_back(head[a]);
                }
        }
    }

    // Send a blocking flow along paths of ascending levels.
    void send_blocking_flow(Index source, Index sink) {
        std::vector<Index> next(arcs.begin), path;
        for (Index node = source;;) {
            if (node == sink) {
                Index flow = left[path[0]], saturated = Index(path.size());
                for (const Index a : path) flow = std::min(flow, left[a]);
                for (Index k = saturated - 1; k >= 0; --k) {
                    left[path[k]] -= flow;
                    left[path[k] ^ 1] += flow;
                    if (left[path[k]] == 0) saturated = k;
                }
                node = head[path[saturated] ^ 1];
                path.resize(saturated);
            }
            const auto is_admissible = [&](Index a) { return left[a] > 0 && level[head[a]] == level[node] + 1; };
            while (next[node] < arcs.begin[node + 1] && !is_admissible(arcs.items[next[node]])) ++next[node];
            if (next[node] < arcs.begin[node + 1]) {
                path.push_back(arcs.items[next[node]]);
                node = head[path.back()];
            } else if (path.empty()) {
                return;
            } else {
                node = head[path.back() ^ 1];
                path.pop_back();
                ++next[node];
            }
        }
    }
};

// Return a mask of the nodes on the sink side of a minimum cut (Dinic 1970).
// If there are several minimum cuts, return the cut nearest to the source.
inline Array<bool> minimum_cut_side(Matrix<const Index> ends, View<const Index> capacity, Index n, Index source,
                                    Index sink) {
    Network network(ends, capacity, n);
    for (network.find_levels(source); network.level[sink] >= 0; network.find_levels(source))
        network.send_blocking_flow(source, sink);
    Array<bool> behind(n);
    for (Index v = 0; v < n; ++v) behind[v] = network.level[v] < 0;
    return behind;
}

}  // namespace graphs
