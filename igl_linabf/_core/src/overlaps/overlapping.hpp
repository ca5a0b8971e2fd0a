// Search for overlapping pairs of triangles of flat maps.
#pragma once
#include <array>

#include "separating_axes.hpp"

namespace overlaps {

constexpr Index LEAF_SIZE = 8;                    // triangles per leaf of the bounding volume hierarchy
constexpr double LAST_CELL = double(0x7fffffff);  // maximum cell coordinate in the grid of the Morton curve

// Insert a 0 before each of 32 bits, for the Morton code.
inline std::uint64_t spread_bits(std::uint64_t bits) {
    for (const int shift : {16, 8, 4, 2, 1}) bits = (bits | bits << shift) & ~std::uint64_t(0) / ((1ULL << shift) + 1);
    return bits;
}

// A bounding volume hierarchy of the triangles of several charts. Degenerate triangles are left out.
class BoxTree {
    struct MortonEntry {
        Index chart;
        std::uint64_t code;  // Morton code
        Index face;
        bool operator<(const MortonEntry& b) const {
            return chart != b.chart ? chart < b.chart : code != b.code ? code < b.code : face < b.face;
        }
    };
    std::vector<MortonEntry> place;  // order of the triangles: by chart, then along the curve
    std::vector<Triangle> triangle;
    std::vector<Box> box, node;  // boxes of triangles, and of nodes; node k is the parent of 2 k and 2 k + 1
    std::vector<Index> end;      // position after the last triangle of the same chart
    Index leaves = 1;

    // Sort the triangles of each chart along a Morton curve (Morton 1966), so that nearby triangles share a leaf.
    void sort(View<const Complex> z, Matrix<const Index> F, View<const Index> chart) {
        const auto triangle_at = [&](Index f) { return make_triangle(z[F[f][0]], z[F[f][1]], z[F[f][2]]); };
        const auto centre = [&](Index f) { return z[F[f][0]] + z[F[f][1]] + z[F[f][2]]; };
        Box centres;
        for (Index f = 0; f < F.rows; ++f)
            if (triangle_at(f).is_solid()) centres.add(centre(f)), place.push_back({chart[f], 0, f});
        const double by = LAST_CELL / std::max({centres.width(), centres.height(), std::numeric_limits<double>::min()});
        for (auto& p : place) {
            const Complex at = by * (centre(p.face) - Complex{centres.left, centres.low});
            p.code = spread_bits(clamp_index(at.x, 0, LAST_CELL)) | spread_bits(clamp_index(at.y, 0, LAST_CELL)) << 1;
        }
        std::sort(place.begin(), place.end());
        triangle.reserve(place.size());
        for (const auto& p : place) triangle.push_back(triangle_at(p.face));
    }

    // Find overlapping pairs of a triangle of a leaf and a later triangle of node `at`.
    // The search ends after more than `limit` pairs.
    // The node has the triangles `begin` to `begin + size - 1`.
    void search(Index leaf, Index at, Index begin, Index size, Index limit,
                std::vector<std::array<Index, 2>>& found) const {
        const Index first = (leaf - leaves) * LEAF_SIZE, n = Index(triangle.size());
        const Index last = std::min(first + LEAF_SIZE, n);
        if (begin >= end[last - 1] || begin + size <= first || !node[at].intersects(node[leaf])) return;
        if (Index(found.size()) > limit) return;
        if (at < leaves) {
            search(leaf, 2 * at, begin, size / 2, limit, found);
            return search(leaf, 2 * at + 1, begin + size / 2, size / 2, limit, found);
        }
        for (Index i = first; i < last; ++i)
            for (Index j = std::max(i + 1, begin); j < std::min(begin + LEAF_SIZE, end[i]); ++j)
                if (box[i].intersects(box[j]) && do_overlap(triangle[i], triangle[j]))
                    found.push_back({std::min(place[i].face, place[j].face), std::max(place[i].face, place[j].face)});
    }

  public:
    BoxTree(View<const Complex> z, Matrix<const Index> F, View<const Index> chart) {
        sort(z, F, chart);
        const Index n = Index(triangle.size());
        while (leaves * LEAF_SIZE < n) leaves *= 2;
        box.resize(n), end.resize(n), node.resize(2 * leaves);
        for (Index i = n; i-- > 0;) {
            end[i] = i + 1 < n && place[i].chart == place[i + 1].chart ? end[i + 1] : i + 1;
            box[i] = bounding_box(triangle[i].corner);
            node[leaves + i / LEAF_SIZE].add(box[i]);
        }
        for (Index k = 2 * leaves; --k > 1;) node[k / 2].add(node[k]);
    }

    // Return the overlapping pairs of triangles i < j of the same chart, in lexicographic order,
    // or only `limit` + 1 pairs if there are more than `limit`.
    std::vector<std::array<Index, 2>> find_pairs(Index limit) const {
        std::vector<std::array<Index, 2>> found;
        for (Index first = 0; first < Index(triangle.size()); first += LEAF_SIZE)
            search(leaves + first / LEAF_SIZE, 1, 0, leaves * LEAF_SIZE, limit, found);
        if (Index(found.size()) > limit) found.resize(limit + 1);
        std::sort(found.begin(), found.end());
        return found;
    }
};

// Return the pairs of faces i < j, (#P, 2), of the same chart that overlap in the plane, in lexicographic order.
// If there are more than `limit` pairs, return only `limit` + 1,
// because a map that is collapsed onto itself has about #F^2 / 2 overlapping pairs.
inline std::vector<std::array<Index, 2>> find_overlaps(View<const Complex> z, Matrix<const Index> F,
                                                       View<const Index> chart, Index limit) {
    return BoxTree(z, F, chart).find_pairs(limit);
}

// Return true if a triangle of `some`, (#S, 3), overlaps another triangle of `some` or a triangle of `others`, (#O, 3).
inline bool has_overlap(Matrix<const Complex> some, Matrix<const Complex> others) {
    std::vector<Triangle> solid;
    std::vector<Box> box;
    Box around;
    const auto is_over = [&](const Triangle& t, const Box& own) {
        for (std::size_t i = 0; i < solid.size(); ++i)
            if (box[i].intersects(own) && do_overlap(solid[i], t)) return true;
        return false;
    };
    for (Index i = 0; i < some.rows; ++i) {
        const Triangle t = make_triangle(some[i][0], some[i][1], some[i][2]);
        if (!t.is_solid()) continue;
        const Box own = bounding_box(some[i]);
        if (is_over(t, own)) return true;
        around.add(own), box.push_back(own), solid.push_back(t);
    }
    for (Index j = 0; j < others.rows; ++j) {
        const Box own = bounding_box(others[j]);
        if (!own.intersects(around)) continue;
        const Triangle t = make_triangle(others[j][0], others[j][1], others[j][2]);
        if (t.is_solid() && is_over(t, own)) return true;
    }
    return false;
}

}  // namespace overlaps
