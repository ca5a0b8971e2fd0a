// The areas that pairs of triangles have in common.
#pragma once
#include <array>

#include "separating_axes.hpp"

namespace overlaps {

// Return the area of the intersection of the triangles a and b,
// by clipping b at each side of a (Sutherland and Hodgman 1974).
// Coordinates are relative to the first corner of a.
inline double common_area(const Complex* a, const Complex* b) {
    constexpr int MAX_CORNERS = 6;  // maximum number of corners of the intersection of two triangles
    std::array<Complex, MAX_CORNERS + 1> part{b[0] - a[0], b[1] - a[0], b[2] - a[0]}, clipped;
    const Complex corner[3] = {{0, 0}, a[1] - a[0], a[2] - a[0]};
    const double turn = cross(corner[1], corner[2]) < 0 ? -1 : 1;
    int number = 3;
    for (int k = 0; k < 3; ++k) {
        const Complex from = corner[k], side = corner[(k + 1) % 3] - from;
        int kept = 0;
        for (int i = 0; i < number; ++i) {
            const Complex here = part[i], next = part[(i + 1) % number];
            const double depth = turn * cross(side, here - from), after = turn * cross(side, next - from);
            if (depth >= 0 && kept < MAX_CORNERS) clipped[kept++] = here;
            if ((depth > 0 && after < 0) || (depth < 0 && after > 0))
                if (kept < MAX_CORNERS) clipped[kept++] = here + depth / (depth - after) * (next - here);
        }
        part = clipped, number = kept;
    }
    double doubled = 0;
    for (int i = 2; i < number; ++i) doubled += cross(part[i - 1] - part[0], part[i] - part[0]);
    return std::abs(doubled) / 2;
}

// Return the area that the two triangles of each pair, (#P, 2), have in common.
inline std::vector<double> common_areas(View<const Complex> z, Matrix<const Index> F, Matrix<const Index> pairs) {
    std::vector<double> area(pairs.rows);
    for (Index p = 0; p < pairs.rows; ++p) {
        Complex corner[2][3];
        for (int side = 0; side < 2; ++side)
            for (int k = 0; k < 3; ++k) corner[side][k] = z[F[pairs[p][side]][k]];
        area[p] = common_area(corner[0], corner[1]);
    }
    return area;
}

}  // namespace overlaps
