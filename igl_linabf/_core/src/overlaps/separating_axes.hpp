// Triangles in the plane, and whether two of them overlap.
#pragma once
#include <limits>

#include "../arrays.hpp"

namespace overlaps {

constexpr double MIN_DEPTH = 1e-6;  // of a triangle's height: what lies deeper than that in another one is an overlap
constexpr double ROUNDING = 16 * std::numeric_limits<double>::epsilon();  // of a corner's distance from the origin
constexpr double NOTHING = -1;  // the depth of a triangle that overlaps nothing

// A number without its fraction, within bounds; the lower one for NaN.
inline Index clamped(double x, double low, double high) { return Index(x > low ? std::min(x, high) : low); }

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
    // Without branches, whose outcome no processor foresees.
    bool touches(const Box& b) const {
        return (left <= b.right) & (b.left <= right) & (low <= b.high) & (b.low <= high);
    }
    Complex centre() const { return {(left + right) / 2, (low + high) / 2}; }
    double width() const { return right - left; }
    double height() const { return high - low; }
};

inline Box box_around(const Complex* corner) {
    Box box;
    for (int k = 0; k < 3; ++k) box.add(corner[k]);
    return box;
}

// A counter-clockwise triangle, with what the test of two of them takes.
struct Triangle {
    Complex corner[3];
    Complex along[3];      // the direction of the side from each corner to the next one; 0 where that has no length
    double depth = 0;      // by which it and another one may reach into each other, if that is not less deep
    double rounding = 0;   // of its corners

    bool solid() const { return depth >= 0; }
};

// The triangle of these corners; returns the length of its longest side.
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

// The triangle of these corners, turned counter-clockwise, with its depth as a share of its height; nothing where its
// height is rounding.
inline Triangle triangle_of(Complex a, Complex b, Complex c) {
    const double area = cross(b - a, c - a);
    Triangle t;
    const double longest = area < 0 ? set_corners(t, a, c, b) : set_corners(t, a, b, c);
    const double height = longest > 0 ? std::abs(area) / longest : 0;
    t.rounding = ROUNDING * std::max({length(a), length(b), length(c)});
    t.depth = height > t.rounding ? MIN_DEPTH * height : NOTHING;
    return t;
}

// Whether b reaches across the lines of all sides of a by more than `least`.
inline bool reaches(const Triangle& a, const Triangle& b, double least) {
    for (int k = 0; k < 3; ++k) {
        bool across = false;
        for (const Complex corner : b.corner) across |= cross(a.along[k], corner - a.corner[k]) > least;
        if (!across) return false;
    }
    return true;
}

// Whether two solid triangles overlap by more than the smaller of their depths and by more than their rounding: no side
// of either is a separating axis (Ericson, Real-Time Collision Detection, 5.2.1).
inline bool overlap(const Triangle& a, const Triangle& b) {
    const double least = std::min(a.depth, b.depth) + std::max(a.rounding, b.rounding);
    return reaches(a, b, least) && reaches(b, a, least);
}

}  // namespace overlaps
