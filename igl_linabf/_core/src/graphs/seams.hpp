// Seams as graphs: paths, trees and their arcs, what they open, and least cuts.
#pragma once
#include <deque>
#include <limits>

#include "../lists.hpp"

namespace graphs {

// The nodes that lead from some ends to their sources, each once; `before` is -1 at sources, which are left out.
inline std::vector<Index> nodes_on_paths(View<const Index> before, View<const Index> ends) {
    std::vector<char> passed(before.size);
    std::vector<Index> found;
    for (Index node : ends)
        for (; before[node] >= 0 && !passed[node]; node = before[node]) {
            passed[node] = true;
            found.push_back(node);
        }
    return found;
}

// The nodes that one takes in an order, leaving out those `hops` edges or less from taken ones over nodes that are
// not closed; as a mask.
template <class Int>
Array<bool> far_apart(View<const Int> indptr, View<const Int> indices, View<const Index> order, Index hops,
                      View<const bool> closed) {
    const Index n = indptr.size - 1;
    Array<bool> chosen = filled(n, false);
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

// The node above each node of a forest; the root of a tree is its first node, and above itself.
inline Array<Index> forest_parents(Matrix<const Index> pairs, Index n) {
    const Lists beside = lists_of(n, [&](const auto& put) {
        for (Index e = 0; e < pairs.rows; ++e) put(pairs[e][0], pairs[e][1]), put(pairs[e][1], pairs[e][0]);
    });
    Array<Index> above = filled<Index>(n, -1);
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

// The edges that are left when those at leaves are dropped in turn; nodes that are kept are no leaves.
inline Array<bool> without_leaves(Matrix<const Index> ends, View<const bool> kept) {
    std::vector<Index> degree(kept.size), edges(kept.size);  // of a node with one edge left, `edges` is this one
    const auto change = [&](Index e, Index by) {
        for (int k = 0; k < 2; ++k) degree[ends[e][k]] += by, edges[ends[e][k]] ^= e;
    };
    for (Index e = 0; e < ends.rows; ++e) change(e, 1);
    Array<bool> left = filled(ends.rows, true);
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

// The edges of a graph in rows from joint to joint, then closed rows without any. Nodes that are no joints have two
// edges. The nodes of arc k begin k after its edges do, at start[k], as it has one more.
inline Arcs arcs_between(Matrix<const Index> ends, View<const bool> joint) {
    const Index n = joint.size, m = ends.rows;
    std::vector<Index> order;  // nodes as edges come
    std::vector<char> known(n), taken(m);
    for (Index i = 0; i < 2 * m; ++i)
        if (!std::exchange(known[ends.data[i]], true)) order.push_back(ends.data[i]);
    const Lists sides = lists_of(n, [&](const auto& put) {  // half-edge 2 e + k leaves node ends[e, k]
        for (Index h = 0; h < 2 * m; ++h) put(ends.data[h], h);
    });
    Arcs made{Array<Index>(m), {}, {0}};
    Index size = 0;
    for (const bool closed : {false, true})
        for (const Index first : order) {
            if (!closed && !joint[first]) continue;
            for (Index h : sides[first]) {
                if (taken[h / 2]) continue;
                made.nodes.push_back(first);
                while (true) {
                    made.edges[size++] = h / 2;
                    taken[h / 2] = true;
                    const Index node = ends.data[h ^ 1];
                    made.nodes.push_back(node);
                    if (joint[node] || node == first) break;
                    const View<Index> own = sides[node];
                    h = own[own[0] / 2 == h / 2];
                }
                made.start.push_back(size);
            }
        }
    return made;
}

struct Opened {
    Index number, cycles;
    std::vector<Index> sizes;
};

// What a seam on a surface opens: the numbers of its components, with the holes, and of its cycles; and the pieces,
// by their numbers of faces, ascending.
inline Opened opened(Matrix<const Index> ends, Matrix<const Index> faces, View<const Index> seam, Index holes,
                     Index n, Index n_faces) {
    std::vector<char> on(ends.rows), on_seam(n);
    std::fill_n(on_seam.begin(), holes, true);
    Opened made{holes, 0, {n_faces}};
    Joined joined(n);
    for (const Index e : seam) {
        if (std::exchange(on[e], true)) continue;
        for (int k = 0; k < 2; ++k) made.number += !std::exchange(on_seam[ends[e][k]], true);
        const bool apart = joined.join(ends[e][0], ends[e][1]);
        made.number -= apart;
        made.cycles += !apart;
    }
    if (!made.cycles) return made;  // a forest separates nothing
    Joined pieces(n_faces);
    Index left = n_faces;
    for (Index e = 0; e < faces.rows && left > 1; ++e)
        if (!on[e]) left -= pieces.join(faces[e][0], faces[e][1]);
    if (left == 1) return made;
    made.sizes.assign(left, 0);
    const Array<Index> label = pieces.labels();
    for (Index face = 0; face < n_faces; ++face) ++made.sizes[label[face]];
    std::sort(made.sizes.begin(), made.sizes.end());
    return made;
}

// The largest flow through a network, by two trees of arcs that are not full, from the source and to the sink, which
// grow until they touch and are mended where an arc gets full (Boykov, Kolmogorov 2004). Each edge is two arcs, 2 e
// and 2 e + 1.
class Flow {
    enum Tree : char { NONE, SOURCE, SINK };
    static constexpr Index ROOT = -1, ORPHAN = -2;  // in place of a parent

    Matrix<const Index> ends;
    std::vector<Index> left;    // what may still flow along each arc
    std::vector<Index> parent;  // the arc between each node and its parent
    std::vector<Tree> tree;
    std::vector<Index> seen, distance;  // when a node was last found to hang on a root, and how far from there
    std::vector<char> waits;
    Lists arcs;
    std::deque<Index> active, orphans;
    Index now = 0;

    Index tail(Index arc) const { return ends.data[arc]; }
    Index head(Index arc) const { return ends.data[arc ^ 1]; }
    // The node beyond a parent's arc.
    Index up(Index node) const { return tree[node] == SOURCE ? tail(parent[node]) : head(parent[node]); }

    void activate(Index node) {
        if (!std::exchange(waits[node], true)) active.push_back(node);
    }

    // The arc along which the trees touch, once they do; -1 if they cannot.
    Index grown() {
        for (; !active.empty(); active.pop_front()) {
            const Index node = active.front();
            waits[node] = false;
            if (tree[node] == NONE) continue;
            for (const Index a : arcs[node]) {
                const Index along = tree[node] == SOURCE ? a : a ^ 1, next = head(a);
                if (left[along] <= 0 || tree[next] == tree[node]) continue;
                if (tree[next] != NONE) {
                    waits[node] = true;  // it stays the first one
                    return along;
                }
                tree[next] = tree[node];
                parent[next] = along;
                seen[next] = seen[node];
                distance[next] = distance[node] + 1;
                activate(next);
            }
        }
        return -1;
    }

    // Send what fits from the source to the sink through an arc.
    void augment(Index arc) {
        Index flow = left[arc];
        for (const Index end : {tail(arc), head(arc)})
            for (Index v = end; parent[v] != ROOT; v = up(v)) flow = std::min(flow, left[parent[v]]);
        left[arc] -= flow;
        left[arc ^ 1] += flow;
        for (const Index end : {tail(arc), head(arc)})
            for (Index v = end; parent[v] != ROOT;) {
                const Index a = parent[v], next = up(v);
                left[a] -= flow;
                left[a ^ 1] += flow;
                if (!left[a]) orphaned(v);
                v = next;
            }
    }

    void orphaned(Index node) {
        parent[node] = ORPHAN;
        orphans.push_back(node);
    }

    // How far a node is from the root of its tree; -1 if it hangs on an orphan.
    Index depth(Index node) {
        Index steps = 0, v = node;
        for (; seen[v] != now && parent[v] != ROOT; v = up(v), ++steps)
            if (parent[v] == ORPHAN) return -1;
        const Index whole = steps + (parent[v] == ROOT ? 0 : distance[v]);
        for (Index d = whole; v != node; node = up(node), --d) seen[node] = now, distance[node] = d;
        return whole;
    }

    // Hang an orphan on the node of its tree that is nearest to the root, or free it.
    void adopt(Index node) {
        const Tree own = tree[node];
        Index best = -1, nearest = std::numeric_limits<Index>::max();
        for (const Index a : arcs[node]) {
            const Index along = own == SOURCE ? a ^ 1 : a;
            if (tree[head(a)] != own || left[along] <= 0) continue;
            const Index far = depth(head(a));
            if (far >= 0 && far < nearest) nearest = far, best = along;
        }
        if (best >= 0) {
            parent[node] = best;
            seen[node] = now;
            distance[node] = nearest + 1;
            return;
        }
        for (const Index a : arcs[node]) {
            const Index next = head(a);
            if (tree[next] != own) continue;
            if (left[own == SOURCE ? a ^ 1 : a] > 0) activate(next);
            if (parent[next] >= 0 && up(next) == node) orphaned(next);
        }
        tree[node] = NONE;
    }

  public:
    Flow(Matrix<const Index> ends, View<const Index> capacity, Index n, Index source, Index sink)
        : ends(ends), left(2 * ends.rows), parent(n, ORPHAN), tree(n, NONE), seen(n, -1), distance(n), waits(n) {
        for (Index a = 0; a < 2 * ends.rows; ++a) left[a] = capacity[a / 2];
        arcs = lists_of(n, [&](const auto& put) {
            for (Index a = 0; a < 2 * ends.rows; ++a) put(ends.data[a], a);
        });
        tree[source] = SOURCE, tree[sink] = SINK;
        parent[source] = parent[sink] = ROOT;
        activate(source), activate(sink);
        for (Index arc; (arc = grown()) >= 0;) {
            ++now;
            augment(arc);
            for (; !orphans.empty(); orphans.pop_front()) adopt(orphans.front());
        }
    }

    bool reaches(Index node) const { return tree[node] == SOURCE; }
};

// The nodes behind the least cut between two nodes; of several, the one nearest to the source.
inline Array<bool> behind_least_cut(Matrix<const Index> ends, View<const Index> capacity, Index n, Index source,
                                    Index sink) {
    const Flow flow(ends, capacity, n, source, sink);
    Array<bool> behind(n);
    for (Index v = 0; v < n; ++v) behind[v] = !flow.reaches(v);
    return behind;
}

}  // namespace graphs
