// Overlap test for triangles in the plane.
#pragma once
#include <limits>

#include "../arrays.hpp"

namespace overlaps {

constexpr double MIN_DEPTH = 1e-6;  // shallower overlaps are ignored, relative to the height of the smaller triangle
constexpr double ROUNDING = 16 * std::numeric_limits<double>::epsilon();  // relative rounding error of a corner
constexpr double NEVER_OVERLAPS = -1;  // depth of a triangle that is excluded from overlap tests

// Truncate a number to an integer within bounds; NaN gives the lower bound.
inline Index clamp_index(double x, double low, double high) { return Index(x > low ? std::min(x, high) : low); }

struct Box {
    double left = INFINITY, low = left, right = -left, high = -left;

    void add(Complex z) {
        left = std::min(left, z.x), right = std::max(right, z.x);
        low = std::min(low, z.y), high = std::max(high, z.y);
    }
    void add(const Box& b) {
        left = std::min(left, b.left), right = std::max(right, b.right);
        low = std::min(low, b.low), high = std::max(high, b.high);
    }
    // Return true if two boxes intersect. Branch-free, because the branches would be unpredictable.
    bool intersects(const Box& b) const {
        return (left <= b.right) & (b.left <= right) & (low <= b.high) & (b.low <= high);
    }
    Complex centre() const { return {(left + right) / 2, (low + high) / 2}; }
    double width() const { return right - left; }
    double height() const { return high - low; }
};

inline Box bounding_box(const Complex* corner) {
    Box box;
    for (int k = 0; k < 3; ++k) box.add(corner[k]);
    return box;
}

// A counter-clockwise triangle with precomputed data for the overlap test.
struct Triangle {
    Complex corner[3];
    Complex along[3];     // unit vector from each corner to the next corner; 0 if the side has zero length
    double depth = 0;     // depth up to which overlaps are ignored; of two triangles, the smaller depth applies
    double rounding = 0;  // rounding error of the corners

    bool is_solid() const { return depth >= 0; }
};

// Set the corners of a triangle, and return the length of its longest side.
inline double set_corners(Triangle& t, Complex a, Complex b, Complex c) {
    t.corner[0] = a, t.corner[1] = b, t.corner[2] = c;
    double longest = 0;
    for (int k = 0; k < 3; ++k) {
        const Complex side = t.corner[(k + 1) % 3] - t.corner[k];
        const double size = length(side);
        t.along[k] = size > 0 ? side / size : Complex{0, 0};
        longest = std::max(longest, size);
    }
    return longest;
}

// Make a counter-clockwise triangle, and set the overlap depth that it tolerates, relative to its height.
// A triangle whose height is within the rounding error never overlaps.
inline Triangle make_triangle(Complex a, Complex b, Complex c) {
    const double area = cross(b - a, c - a);
    Triangle t;
    const double longest = area < 0 ? set_corners(t, a, c, b) : set_corners(t, a, b, c);
    const double height = longest > 0 ? std::abs(area) / longest : 0;
    t.rounding = ROUNDING * std::max({length(a), length(b), length(c)});
    t.depth = height > t.rounding ? MIN_DEPTH * height : NEVER_OVERLAPS;
    return t;
}

// Return true if b reaches across the lines through all sides of a by more than `least`.
inline bool penetrates(const Triangle& a, const Triangle& b, double least) {
    for (int k = 0; k < 3; ++k) {
        bool across = false;
        for (const Complex corner : b.corner) across |= cross(a.along[k], corner - a.corner[k]) > least;
        if (!across) return false;
    }
    return true;
}

// Return true if two solid triangles overlap by more than the smaller of their depths plus their rounding error:
// no side of either triangle is a separating axis (Ericson, Real-Time Collision Detection, 5.2.1).
inline bool do_overlap(const Triangle& a, const Triangle& b) {
    const double least = std::min(a.depth, b.depth) + std::max(a.rounding, b.rounding);
    return penetrates(a, b, least) && penetrates(b, a, least);
}

}  // namespace overlaps
