// Pairs of triangles of flat maps that overlap.
#pragma once
#include <array>

#include "separating_axes.hpp"

namespace overlaps {

constexpr Index LEAF = 8;                       // triangles at a leaf of the tree of boxes
constexpr double LAST_CELL = double(0x7fffffff);  // along a side of the grid that the curve runs through

// The 32 bits of a number with a 0 before each of them.
inline std::uint64_t spread(std::uint64_t bits) {
    for (const int shift : {16, 8, 4, 2, 1}) bits = (bits | bits << shift) & ~std::uint64_t(0) / ((1ULL << shift) + 1);
    return bits;
}

// The solid ones of some triangles of charts, and a tree of boxes above them.
class Tree {
    struct Place {
        Index chart;
        std::uint64_t code;  // along the curve
        Index face;
        bool operator<(const Place& b) const {
            return chart != b.chart ? chart < b.chart : code != b.code ? code < b.code : face < b.face;
        }
    };
    std::vector<Place> place;  // in which order the triangles stand: chart after chart, each along the curve
    std::vector<Triangle> triangle;
    std::vector<Box> box, node;  // of each triangle; of a binary tree's nodes: k is above 2 k and 2 k + 1
    std::vector<Index> end;      // where the chart of each triangle ends
    Index leaves = 1;

    // Along Morton's curve (1966) those that follow each other are near each other.
    void sort(View<const Complex> z, Matrix<const Index> F, View<const Index> chart) {
        const auto triangle_at = [&](Index f) { return triangle_of(z[F[f][0]], z[F[f][1]], z[F[f][2]]); };
        const auto centre = [&](Index f) { return z[F[f][0]] + z[F[f][1]] + z[F[f][2]]; };
        Box centres;
        for (Index f = 0; f < F.rows; ++f)
            if (triangle_at(f).solid()) centres.add(centre(f)), place.push_back({chart[f], 0, f});
        const double by = LAST_CELL / std::max({centres.width(), centres.height(), std::numeric_limits<double>::min()});
        for (auto& p : place) {
            const Complex at = by * (centre(p.face) - Complex{centres.left, centres.low});
            p.code = spread(clamped(at.x, 0, LAST_CELL)) | spread(clamped(at.y, 0, LAST_CELL)) << 1;
        }
        std::sort(place.begin(), place.end());
        triangle.reserve(place.size());
        for (const auto& p : place) triangle.push_back(triangle_at(p.face));
    }

    // Pairs of a triangle at a leaf and a later one below a node, whose triangles begin at `begin`.
    void search(Index leaf, Index at, Index begin, Index size, std::vector<std::array<Index, 2>>& found) const {
        const Index first = (leaf - leaves) * LEAF, n = Index(triangle.size()), last = std::min(first + LEAF, n);
        if (begin >= end[last - 1] || begin + size <= first || !node[at].touches(node[leaf])) return;
        if (at < leaves) {
            search(leaf, 2 * at, begin, size / 2, found);
            return search(leaf, 2 * at + 1, begin + size / 2, size / 2, found);
        }
        for (Index i = first; i < last; ++i)
            for (Index j = std::max(i + 1, begin); j < std::min(begin + LEAF, end[i]); ++j)
                if (box[i].touches(box[j]) && overlap(triangle[i], triangle[j]))
                    found.push_back({std::min(place[i].face, place[j].face), std::max(place[i].face, place[j].face)});
    }

  public:
    Tree(View<const Complex> z, Matrix<const Index> F, View<const Index> chart) {
        sort(z, F, chart);
        const Index n = Index(triangle.size());
        while (leaves * LEAF < n) leaves *= 2;
        box.resize(n), end.resize(n), node.resize(2 * leaves);
        for (Index i = n; i-- > 0;) {
            end[i] = i + 1 < n && place[i].chart == place[i + 1].chart ? end[i + 1] : i + 1;
            box[i] = box_around(triangle[i].corner);
            node[leaves + i / LEAF].add(box[i]);
        }
        for (Index k = 2 * leaves; --k > 1;) node[k / 2].add(node[k]);
    }

    // All pairs of triangles of one chart that overlap, the one of the smaller index first, in lexicographic order.
    std::vector<std::array<Index, 2>> pairs() const {
        std::vector<std::array<Index, 2>> found;
        for (Index first = 0; first < Index(triangle.size()); first += LEAF)
            search(leaves + first / LEAF, 1, 0, leaves * LEAF, found);
        std::sort(found.begin(), found.end());
        return found;
    }
};

// Pairs of faces (#P, 2) of one chart that overlap in the plane, i < j, in lexicographic order.
inline std::vector<std::array<Index, 2>> overlapping(View<const Complex> z, Matrix<const Index> F,
                                                     View<const Index> chart) {
    return Tree(z, F, chart).pairs();
}

// Whether one of some triangles, (#S, 3), overlaps another one of them, or one of others, (#O, 3).
inline bool lie_over(Matrix<const Complex> some, Matrix<const Complex> others) {
    std::vector<Triangle> solid;
    std::vector<Box> box;
    Box around;
    const auto is_over = [&](const Triangle& t, const Box& own) {
        for (std::size_t i = 0; i < solid.size(); ++i)
            if (box[i].touches(own) && overlap(solid[i], t)) return true;
        return false;
    };
    for (Index i = 0; i < some.rows; ++i) {
        const Triangle t = triangle_of(some[i][0], some[i][1], some[i][2]);
        if (!t.solid()) continue;
        const Box own = box_around(some[i]);
        if (is_over(t, own)) return true;
        around.add(own), box.push_back(own), solid.push_back(t);
    }
    for (Index j = 0; j < others.rows; ++j) {
        const Box own = box_around(others[j]);
        if (!own.touches(around)) continue;
        const Triangle t = triangle_of(others[j][0], others[j][1], others[j][2]);
        if (t.solid() && is_over(t, own)) return true;
    }
    return false;
}

}  // namespace overlaps
