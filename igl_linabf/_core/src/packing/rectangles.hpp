// Smallest bounding rectangles of sets of points. One side of a smallest rectangle contains a side of the convex hull.
#pragma once
#include <array>

#include "cells.hpp"

namespace packing {

constexpr double EQUAL_AREA_FACTOR = 1 + 1e-12;  // areas within this factor count as equal
constexpr double COLLINEAR_SHARE = 1e-14;        // three points with a smaller relative area count as collinear

constexpr std::size_t HULL_DIRECTIONS = 16;  // number of directions for finding extreme points

struct Directions {
    std::array<double, HULL_DIRECTIONS> x, y;
};

// Return the distance of z to the left of the line from p to q, times |q - p|. It is 0 if the points are collinear.
inline double signed_offset(Complex p, Complex q, Complex z) {
    const Complex a = q - p, b = z - p;
    const double area = cross(a, b);
    return area * area > COLLINEAR_SHARE * COLLINEAR_SHARE * dot(a, a) * dot(b, b) ? area : 0;
}

// Fill `kept` with the points that may be on the convex hull, which are not inside the polygon of the extreme points.
inline void select_outer_points(View<const Complex> z, const Directions& outwards, std::vector<Complex>& kept) {
    std::array<double, HULL_DIRECTIONS> most;
    std::array<Index, HULL_DIRECTIONS> far{};
    most.fill(-INFINITY);
    for (Index i = 0; i < z.size; ++i)
        for (std::size_t d = 0; d < HULL_DIRECTIONS; ++d) {
            const double along = z[i].x * outwards.x[d] + z[i].y * outwards.y[d];
            const bool farther = along > most[d];
            most[d] = farther ? along : most[d], far[d] = farther ? i : far[d];
        }
    kept.clear();
    for (const Complex p : z) {
        bool inside = true;
        for (std::size_t d = 0; d < HULL_DIRECTIONS && inside; ++d) {
            const Complex from = z[far[d]], to = z[far[(d + 1) % HULL_DIRECTIONS]];
            inside = from == to || signed_offset(from, to, p) > 0;
        }
        if (!inside && p == p) kept.push_back(p);  // skip NaN
    }
}

// Fill `hull` with the corners of the convex hull, clockwise from the lowest corner (Andrew 1979). Sorts z.
inline void convex_hull(std::vector<Complex>& z, std::vector<Complex>& hull) {
    std::sort(z.begin(), z.end(), [](Complex p, Complex q) {
        return p.y < q.y || (p.y == q.y && p.x < q.x);
    });
    hull.clear();
    const std::size_t n = z.size();
    std::size_t least = 1;
    for (std::size_t k = 0; k + 1 < 2 * n; ++k) {
        if (k == n) least = hull.size();  // the left side is complete; continue down the right side
        const Complex p = z[k < n ? k : 2 * n - 2 - k];
        while (hull.size() > least && signed_offset(hull.end()[-2], hull.back(), p) >= 0) hull.pop_back();
        if (hull.size() != least || !(hull.back() == p)) hull.push_back(p);
    }
    if (hull.size() > 1) hull.pop_back();  // the last corner repeats the first
}

// Return, for each group of points, the rotation that minimizes the area of its axis-aligned bounding rectangle,
// as a unit complex number.
// The result for collinear points is 1.
inline std::vector<Complex> min_rectangle_rotations(View<const Complex> z, View<const Index> start) {
    Directions outwards;
    for (std::size_t d = 0; d < HULL_DIRECTIONS; ++d) {
        const Complex to = direction(2 * PI * double(d) / HULL_DIRECTIONS);
        outwards.x[d] = to.x, outwards.y[d] = to.y;
    }
    std::vector<Complex> turns(start.size - 1, Complex{1, 0});
    std::vector<Complex> kept, hull;
    std::vector<double> areas;
    for (Index i = 0; i < Index(turns.size()); ++i) {
        select_outer_points(z.part(start[i], start[i + 1]), outwards, kept);
        convex_hull(kept, hull);
        if (hull.size() < 3) continue;
        areas.clear();
        const auto along = [&](std::size_t r) {
            const Complex edge = hull[r + 1 < hull.size() ? r + 1 : 0] - hull[r];
            return Complex{edge.x, -edge.y} / std::hypot(edge.x, edge.y);
        };
        for (std::size_t r = 0; r < hull.size(); ++r) {
            const Complex turn = along(r);
            double left = INFINITY, right = -INFINITY, low = INFINITY, high = -INFINITY;
            for (const Complex corner : hull) {
                const Complex p = times(corner, turn);
                left = std::min(left, p.x), right = std::max(right, p.x);
                low = std::min(low, p.y), high = std::max(high, p.y);
            }
            areas.push_back((right - left) * (high - low));
        }
        const double alike = EQUAL_AREA_FACTOR * *std::min_element(areas.begin(), areas.end());
        for (std::size_t r = 0; r < hull.size(); ++r)
            if (areas[r] <= alike) {
                turns[i] = along(r);
                break;
            }
    }
    return turns;
}

}  // namespace packing
