// Edges of triangles, boundary loops, connected components, and sparsity patterns over graphs.
#pragma once
#include <limits>

#include "../lists.hpp"
#include "../threads.hpp"

namespace graphs {

// A pair of integers, the first below 2^31 and the second below 2^32, is packed into one integer.
// Packed pairs are sorted by their first integers.
constexpr Index UPPER_END = Index(1) << 31, LOWER_END = Index(1) << 32;
inline Index upper(Index pair) { return pair >> 32; }
inline Index lower(Index pair) { return pair & (LOWER_END - 1); }

// Build lists of pairs for n nodes: visit(put) calls put(node, upper, lower) with upper < n and lower < lower_end.
template <class Visit>
Lists build_pair_lists(Index n, Index lower_end, const Visit& visit) {
    if (n > UPPER_END || lower_end > LOWER_END) throw std::invalid_argument("more than 2^31 nodes or 2^32 edges");
    return build_lists(n, [&](const auto& put) {
        visit([&](Index node, Index upper, Index lower) {
            check_index(upper, n), check_index(lower, lower_end);
            put(node, Index(std::uint64_t(upper) << 32 | std::uint64_t(lower)));
        });
    });
}

// Sort the packed pairs of each node. Returns the cumulative number of distinct first integers per node, (n + 1,).
inline std::vector<Index> sort_lists(const Lists& lists) {
    const Index n = Index(lists.begin.size()) - 2;
    std::vector<Index> before(n + 1);
    parallel_for_pieces(n, [&](Index first, Index last) {
        for (Index v = first; v < last; ++v) {
            const View<Index> own = lists[v];
            if (!std::is_sorted(own.begin(), own.end())) std::sort(own.begin(), own.end());
            Index number = 0, known = -1;
            for (const Index pair : own) {
                number += upper(pair) != known;
                known = upper(pair);
            }
            before[v + 1] = number;
        }
    });
    std::partial_sum(before.begin(), before.end(), before.begin());
    return before;
}

struct Edges {
    Grid<Index> ends, sides;  // end vertices, (#E, 2), and half-edges, (2, #E)
    bool sound;
};

// Find the edges of triangles, sorted by their lower and higher ends.
// Half-edge k m + t is opposite to corner k of triangle t.
// The edges are sound if no edge has more than two half-edges or two half-edges of the same direction.
inline Edges find_edges(Matrix<const Index> corner, Index n) {
    const Index m = corner.columns;
    // for each lower end, pairs of the higher end and 2 h, or 2 h + 1 if half-edge h starts at the higher end
    const Lists at = build_pair_lists(n, 6 * m, [&](const auto& put) {
        for (Index t = 0; t < m; ++t)
            for (Index k = 0; k < 3; ++k) {
                const Index tail = corner[(k + 1) % 3][t], head = corner[(k + 2) % 3][t];
                put(std::min(tail, head), std::max(tail, head), 2 * (k * m + t) + (head < tail));
            }
    });
    const std::vector<Index> first = sort_lists(at);
    Edges result{Grid<Index>(first[n], 2), Grid<Index>(2, first[n]), true};
    const Matrix<Index> ends = result.ends.matrix(), sides = result.sides.matrix();
    std::atomic<bool> sound{true};
    parallel_for_pieces(n, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            Index e = first[v] - 1, known = -1;
            for (const Index pair : at[v]) {
                const Index h = lower(pair) >> 1, down = pair & 1;
                if (upper(pair) != known) {
                    known = upper(pair);
                    ++e;
                    ends[e][down] = v, ends[e][1 - down] = known;
                    sides[0][e] = h, sides[1][e] = -1;
                } else if (sides[1][e] >= 0 || ends[e][down] == v) {
                    sound = false;
                } else {
                    sides[1][e] = h;
                }
            }
        }
    });
    result.sound = sound;
    return result;
}

struct SideGroups {
    Array<Index> order, begin, count;
};

// Sort half-edges by edge.
// Returns the sorted half-edges, and the first position and the number of half-edges of each edge.
inline SideGroups group_sides(View<const Index> tail, View<const Index> head, Index n) {
    const Lists at = build_pair_lists(n, tail.size, [&](const auto& put) {
        for (Index h = 0; h < tail.size; ++h) put(std::min(tail[h], head[h]), std::max(tail[h], head[h]), h);
    });
    const Index size = sort_lists(at)[n];
    SideGroups result{Array<Index>(tail.size), Array<Index>(size), full<Index>(size, 0)};
    for (Index v = 0, e = -1; v < n; ++v)
        for (Index i = at.begin[v], known = -1; i < at.begin[v + 1]; ++i) {
            const Index pair = at.items[i];
            if (upper(pair) != known) result.begin[++e] = i;
            known = upper(pair);
            result.order[i] = lower(pair);
            ++result.count[e];
        }
    return result;
}

struct UsedVertices {
    Array<bool> vertices;
    bool sound;
};

// Mark the vertices that valid faces use, and check that all faces are valid.
// The indices of a valid face are distinct and below n.
inline UsedVertices used_vertices(Matrix<const Index> F, Index n) {
    UsedVertices result{full(n, false), true};
    const auto within = [n](Index v) { return std::uint64_t(v) < std::uint64_t(n); };
    for (Index t = 0; t < F.rows; ++t) {
        const Index a = F[t][0], b = F[t][1], c = F[t][2];
        const bool sound = within(a) && within(b) && within(c) && (a != b) && (b != c) && (c != a);
        if (sound) result.vertices[a] = result.vertices[b] = result.vertices[c] = true;
        result.sound &= sound;
    }
    return result;
}

struct SymmetricPattern {
    Array<Index> indptr, indices, slot;
};

// Build the CSR pattern of the upper triangle of a symmetric matrix with entries on the diagonal and
// at edges between two rows.
// The diagonal entry comes first in each row.
// Also return the position of the entry of each edge, or -1 if the edge does not join two rows.
inline SymmetricPattern symmetric_pattern(Matrix<const Index> ends, Index n) {
    const Lists at = build_pair_lists(n, ends.columns, [&](const auto& put) {
        for (Index e = 0; e < ends.columns; ++e) {
            const Index low = std::min(ends[0][e], ends[1][e]), high = std::max(ends[0][e], ends[1][e]);
            if (low >= 0 && low != high) put(low, high, e);
        }
    });
    const std::vector<Index> before = sort_lists(at);
    SymmetricPattern result{Array<Index>(n + 1), Array<Index>(n + before[n]), full<Index>(ends.columns, -1)};
    for (Index v = 0; v < n; ++v) {
        Index p = before[v] + v;
        result.indptr[v] = p;
        result.indices[p] = v;
        for (const Index pair : at[v]) {
            if (upper(pair) != result.indices[p]) result.indices[++p] = upper(pair);
            result.slot[lower(pair)] = p;
        }
    }
    result.indptr[n] = n + before[n];
    return result;
}

struct Neighbours {
    Array<Index> indptr, indices, edge;
};

// Return the neighbours of each node in CSR, in ascending order, and the shortest edge to each neighbour.
// The first of equally short edges is returned.
inline Neighbours shortest_edges(Matrix<const Index> ends, View<const double> length, Index n) {
    const Lists at = build_pair_lists(n, ends.rows, [&](const auto& put) {
        for (Index e = 0; e < ends.rows; ++e) {
            const Index i = ends[e][0], j = ends[e][1];
            if (i != j) put(i, j, e), put(j, i, e);
        }
    });
    const std::vector<Index> before = sort_lists(at);
    Neighbours result{Array<Index>(n + 1), Array<Index>(before[n]), Array<Index>(before[n])};
    std::copy(before.begin(), before.end(), result.indptr.data());
    for (Index v = 0, p = -1; v < n; ++v) {
        Index known = -1;
        for (const Index pair : at[v]) {
            const Index e = lower(pair);
            if (upper(pair) != known) {
                result.indices[++p] = known = upper(pair);
                result.edge[p] = e;
            } else if (length[e] < length[result.edge[p]]) {
                result.edge[p] = e;
            }
        }
    }
    return result;
}

struct Loops {
    std::vector<Index> vertices, sizes, twice;
};

// Chain boundary half-edges into loops, in the order of their first vertices.
// If two half-edges leave the same vertex, no loops are returned,
// and `twice` contains the vertices that two half-edges leave.
inline Loops boundary_loops(View<const Index> tail, View<const Index> head, Index n) {
    Loops result;
    std::vector<Index> following(n, -1);
    for (Index e = 0; e < tail.size; ++e) {
        if (following[tail[e]] >= 0) result.twice.push_back(tail[e]);
        following[tail[e]] = head[e];
    }
    if (!result.twice.empty()) return result;
    result.vertices.reserve(tail.size);
    for (Index v = 0; v < n; ++v) {
        if (following[v] < 0) continue;
        const std::size_t before = result.vertices.size();
        for (Index at = v; following[at] >= 0;) {
            result.vertices.push_back(at);
            at = std::exchange(following[at], -1);
        }
        result.sizes.push_back(Index(result.vertices.size() - before));
    }
    return result;
}

// Return the cycles of a permutation, in the order of their first elements.
inline std::vector<std::vector<Index>> cycles(View<const Index> following) {
    std::vector<std::vector<Index>> found;
    std::vector<char> seen(following.size);
    for (Index i = 0; i < following.size; ++i) {
        if (seen[i]) continue;
        found.emplace_back();
        for (Index at = i; !seen[at]; at = following[at]) {
            seen[at] = true;
            found.back().push_back(at);
        }
    }
    return found;
}

// Return the connected component of each node of a graph; components are numbered in the order of their first nodes.
inline Array<Index> connected_labels(Matrix<const Index> edges, Index n) {
    UnionFind sets(n);
    for (Index e = 0; e < edges.rows; ++e) sets.unite(edges[e][0], edges[e][1]);
    return sets.labels();
}

// Return the edges that do not close a cycle with earlier edges.
// If the order is by weight, this is the minimum spanning forest (Kruskal 1956).
inline std::vector<Index> spanning_forest(Matrix<const Index> pairs, View<const Index> order, Index n) {
    UnionFind sets(n);
    std::vector<Index> chosen;
    for (const Index e : order)
        if (sets.unite(pairs[e][0], pairs[e][1])) chosen.push_back(e);
    return chosen;
}

// Return true if every face can be reached from face 0 across edges.
inline bool is_connected(Matrix<const Index> sides, Index m) {
    if (m == 0) return true;
    if (m >= std::numeric_limits<int>::max()) throw std::invalid_argument("too many faces");
    const auto face = [m](Index h) { return int(h - m * ((h >= m) + (h >= 2 * m))); };  // h % m, but faster
    std::vector<int> beside(3 * m, int(m)), waiting(m + 2);  // face across each half-edge; m at the boundary
    for (Index e = 0; e < sides.columns; ++e)
        if (const Index i = sides[0][e], j = sides[1][e]; j >= 0) beside[i] = face(j), beside[j] = face(i);
    std::vector<char> is_new(m + 1, 1);
    is_new[0] = is_new[m] = 0;
    Index reached = 1;
    for (Index done = 0; done < reached; ++done)
        for (Index k = 0; k < 3; ++k) {
            const int t = beside[k * m + waiting[done]];
            waiting[reached] = t;  // written in any case, because a branch would be unpredictable
            reached += is_new[t];
            is_new[t] = 0;
        }
    return reached >= m;
}

// Count the fans of each vertex. A fan is a set of corners at the vertex that are connected across edges.
inline Array<Index> count_fans(Matrix<const Index> corner, Matrix<const Index> sides, Index n) {
    const Index m = corner.columns;
    std::vector<Index> step[2] = {std::vector<Index>(3 * m, -1), std::vector<Index>(3 * m, -1)};
    for (Index e = 0; e < sides.columns; ++e)
        for (int k = 0; k < 2 && sides[1][e] >= 0; ++k) {  // half-edge k begins at corner k + 1 and ends at k + 2
            const Index one = sides[k][e], other = sides[1 - k][e];
            const Index start = one < 2 * m ? one + m : one - 2 * m, end = other < m ? other + 2 * m : other - m;
            step[0][start] = end, step[1][end] = start;
        }
    Array<Index> number = full<Index>(n, 0);
    std::vector<char> known(3 * m);
    for (Index first = 0; first < 3 * m; ++first) {
        if (known[first]) continue;
        ++number[corner.data[first]];
        known[first] = true;
        for (const auto& turn : step)
            for (Index at = turn[first]; at >= 0 && !known[at]; at = turn[at]) known[at] = true;
    }
    return number;
}

}  // namespace graphs
