// The narrowest rectangles around points: each lies along a side of their convex hull.
#pragma once
#include <array>
#include <cmath>

#include "cells.hpp"

namespace packing {

constexpr double ALIKE = 1 + 1e-12;  // times the least area is an equal one: rounding must not choose
constexpr double LEVEL = 1e-14;      // of the lengths' product: below it, three points are on a line

constexpr std::size_t FAN = 16;      // directions

struct Directions {
    std::array<double, FAN> x, y;
};

// How far z lies to the left of the way from p to q, times its length; 0 if it is on that line.
inline double off(Point p, Point q, Point z) {
    const Point a = q - p, b = z - p;
    const double area = a.x * b.y - a.y * b.x;
    return area * area > LEVEL * LEVEL * (a.x * a.x + a.y * a.y) * (b.x * b.x + b.y * b.y) ? area : 0;
}

// Fill `kept` with the points that may be on the convex hull: not inside that of those farthest out in directions.
inline void outer_points(View<const Point> z, const Directions& outwards, std::vector<Point>& kept) {
    std::array<double, FAN> most;
    std::array<Index, FAN> far{};
    most.fill(-INFINITY);
    for (Index i = 0; i < z.size; ++i)
        for (std::size_t d = 0; d < FAN; ++d) {
            const double along = z[i].x * outwards.x[d] + z[i].y * outwards.y[d];
            const bool farther = along > most[d];
            most[d] = farther ? along : most[d], far[d] = farther ? i : far[d];
        }
    kept.clear();
    for (const Point p : z) {
        bool inside = true;
        for (std::size_t d = 0; d < FAN && inside; ++d) {
            const Point from = z[far[d]], to = z[far[(d + 1) % FAN]];
            inside = from == to || off(from, to, p) > 0;
        }
        if (!inside && p == p) kept.push_back(p);  // it is a number
    }
}

// Fill `hull` with the corners of the convex hull, clockwise from the lowest one (Andrew 1979); z is sorted.
inline void convex_hull(std::vector<Point>& z, std::vector<Point>& hull) {
    std::sort(z.begin(), z.end(), [](Point p, Point q) {
        return p.y < q.y || (p.y == q.y && p.x < q.x);
    });
    hull.clear();
    const std::size_t n = z.size();
    std::size_t least = 1;
    for (std::size_t k = 0; k + 1 < 2 * n; ++k) {
        if (k == n) least = hull.size();  // up along the left side, and down along the right one
        const Point p = z[k < n ? k : 2 * n - 2 - k];
        while (hull.size() > least && off(hull.end()[-2], hull.back(), p) >= 0) hull.pop_back();
        if (hull.size() != least || !(hull.back() == p)) hull.push_back(p);
    }
    if (hull.size() > 1) hull.pop_back();  // it is the first one
}

// Of each group of points the turn that makes the upright rectangle around it smallest; 1 for points on a line.
inline std::vector<Point> narrowest_turns(View<const Point> z, View<const Index> start) {
    Directions outwards;
    for (std::size_t d = 0; d < FAN; ++d) {
        const double angle = 2 * std::acos(-1.0) * double(d) / FAN;
        outwards.x[d] = std::cos(angle), outwards.y[d] = std::sin(angle);
    }
    std::vector<Point> turns(start.size - 1, Point{1, 0});
    std::vector<Point> kept, hull;
    std::vector<double> areas;
    for (Index i = 0; i < Index(turns.size()); ++i) {
        outer_points(z.part(start[i], start[i + 1]), outwards, kept);
        convex_hull(kept, hull);
        if (hull.size() < 3) continue;
        areas.clear();
        const auto along = [&](std::size_t r) {
            const Point edge = hull[r + 1 < hull.size() ? r + 1 : 0] - hull[r];
            const double length = std::hypot(edge.x, edge.y);
            return Point{edge.x / length, -edge.y / length};
        };
        for (std::size_t r = 0; r < hull.size(); ++r) {
            const Point turn = along(r);
            double left = INFINITY, right = -INFINITY, low = INFINITY, high = -INFINITY;
            for (const Point corner : hull) {
                const Point p = times(corner, turn);
                left = std::min(left, p.x), right = std::max(right, p.x);
                low = std::min(low, p.y), high = std::max(high, p.y);
            }
            areas.push_back((right - left) * (high - low));
        }
        const double alike = ALIKE * *std::min_element(areas.begin(), areas.end());
        for (std::size_t r = 0; r < hull.size(); ++r)
            if (areas[r] <= alike) {
                turns[i] = along(r);
                break;
            }
    }
    return turns;
}

}  // namespace packing
