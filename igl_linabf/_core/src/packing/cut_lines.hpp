// Evaluation of lines that cut a graph in the plane: the extents of the parts, and the lengths of the cuts.
#pragma once
#include "../lists.hpp"

namespace packing {

struct CutLineValues {
    Array<double> hulls, widest, cut;
};

// Evaluate lines, each of which cuts the edges that it crosses.
// For each line, return the total area of the approximate convex hulls of the connected parts;
// the longest diagonal of an axis-aligned bounding rectangle of a part; and the total length of the cut edges.
//
// A point is beyond line k if its scalar product with the normal of the line exceeds the offset of the line.
// Only the `outer` points and the ends of cut edges can be on a hull.
// The vertices of an approximate hull are the extreme points in the directions `outwards`, (2, 4 n):
// unit vectors at equal angles, beginning with (1, 0).
inline CutLineValues evaluate_cut_lines(Matrix<const double> points, Matrix<const Index> ends,
                                        View<const double> length, View<const bool> outer,
                                        Matrix<const double> normal, View<const double> offset,
                                        Matrix<const double> outwards) {
    const Index n = points.rows, lines = offset.size, fan = outwards.columns;
    CutLineValues result{Array<double>(lines), Array<double>(lines), Array<double>(lines)};
    std::vector<char> beyond(n), near(n);
    std::vector<Index> part(n), at;
    std::vector<double> most;
    for (Index k = 0; k < lines; ++k) {
        result.hulls[k] = result.widest[k] = result.cut[k] = 0;
        UnionFind sets(n);
        for (Index i = 0; i < n; ++i) {
            beyond[i] = points[i][0] * normal[k][0] + points[i][1] * normal[k][1] > offset[k];
            near[i] = outer[i], part[i] = -1;
        }
        for (Index e = 0; e < ends.rows; ++e) {
            const Index i = ends[e][0], j = ends[e][1];
            if (beyond[i] != beyond[j]) {
                result.cut[k] += length[e];
                near[i] = near[j] = true;
            } else {
                sets.unite(i, j);
            }
        }
        at.clear(), most.clear();
        for (Index i = 0; i < n; ++i) {
            if (!near[i]) continue;
            Index& p = part[sets.find(i)];
            if (p < 0) {
                p = Index(at.size());
                at.resize(at.size() + fan, i), most.resize(most.size() + fan, -INFINITY);
            }
            for (Index d = 0; d < fan; ++d) {
                const double far = points[i][0] * outwards[0][d] + points[i][1] * outwards[1][d];
                if (far > most[p + d]) most[p + d] = far, at[p + d] = i;
            }
        }
        for (Index p = 0; p < Index(at.size()); p += fan) {
            double double_area = 0;
            for (Index d = 0; d < fan; ++d) {
                const double *a = points[at[p + d]], *b = points[at[p + (d + 1) % fan]];
                double_area += a[0] * b[1] - a[1] * b[0];
            }
            result.hulls[k] += double_area / 2;
            const double wide = most[p] + most[p + fan / 2], high = most[p + fan / 4] + most[p + 3 * fan / 4];
            result.widest[k] = std::max(result.widest[k], std::sqrt(wide * wide + high * high));
        }
    }
    return result;
}

}  // namespace packing
