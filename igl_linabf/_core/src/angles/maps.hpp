// Flat maps: areas, distortion, normalization of position and direction, and layout from angles.
#pragma once
#include "triangles.hpp"

namespace angles {

constexpr double SYMMETRIC_MOMENT = 1e-9;  // a map with a smaller relative moment counts as symmetric

inline Complex map_point(Values uv, Index v) {
    check_index(v, uv.rows);
    return {uv.data[2 * v], uv.data[2 * v + 1]};
}

// Return twice the signed area of each face; positive unless the face is flipped or collapsed.
inline Array<double> signed_double_areas(View<const Complex> z, Corners corner) {
    return tabulate(corner.columns, [z, at = CornerRows(corner)](Index t) {
        const auto [i, j, k] = at[t];
        return cross(z[j] - z[i], z[k] - z[i]);
    });
}

// Scale each of several concatenated maps to a given area, move its centroid to 0,
// and rotate its principal axes to x and y.
//
// `double_area` is twice the area of each face in the map.
// Map i has the vertices vertex_start[i] to vertex_start[i + 1] - 1 and the faces face_start[i]
// to face_start[i + 1] - 1.
// The longer principal axis becomes the x axis, in the direction for which the third moment is positive.
// The axes and the direction of symmetric maps would depend on rounding;
// they are chosen by a rule that is robust to rounding.
inline Array<Complex> normalize_maps(View<const Complex> z, Corners corner, Numbers double_area, Numbers area,
                                     View<const Index> vertex_start, View<const Index> face_start) {
    Array<Complex> result(z.size);
    const CornerRows at(corner);
    const Complex beside_axes{std::cos(0.3), -std::sin(0.3)};  // arbitrary: few maps are aligned to this direction
    for (Index i = 0; i < area.size; ++i) {
        const Index first = face_start[i], last = face_start[i + 1];
        double total = 0, size = 0, third = 0;
        Complex centroid{0, 0}, second{0, 0}, turn{1, 0};
        for (Index t = first; t < last; ++t) {
            const auto [j, k, l] = at[t];
            total += double_area[t];
            centroid = centroid + double_area[t] / 3 * (z[j] + z[k] + z[l]);
        }
        centroid = 1 / total * centroid;
        for (Index t = first; t < last; ++t) {
            const auto [j, k, l] = at[t];
            const Complex a = z[j] - centroid, b = z[k] - centroid, c = z[l] - centroid, s = a + b + c;
            second = second + double_area[t] * (times(a, a) + times(b, b) + times(c, c) + times(s, s));
            size += double_area[t] * (dot(a, a) + dot(b, b) + dot(c, c));
        }
        if (std::hypot(second.x, second.y) > SYMMETRIC_MOMENT * size) {
            const double angle = std::atan2(second.y, second.x) / 2;
            turn = {std::cos(angle), -std::sin(angle)};
        }
        for (Index t = first; t < last; ++t) {
            const auto [j, k, l] = at[t];
            const double x = times(1.0 / 3 * (z[j] + z[k] + z[l]) - centroid, turn).x;
            third += double_area[t] * x * x * x;
        }
        const double least_third = SYMMETRIC_MOMENT * total * std::pow(size / total, 1.5);
        if (!(std::abs(third) > least_third)) third = times(turn, beside_axes).x;
        turn = (third < 0 ? -1 : 1) * std::sqrt(2 * area[i] / total) * turn;
        for (Index v = vertex_start[i]; v < vertex_start[i + 1]; ++v) result[v] = times(z[v] - centroid, turn);
    }
    return result;
}

using TriangleChanges =
    std::tuple<Grid<double>, Grid<double>, Array<double>, Array<double>, Array<double>, Grid<double>>;

// Measure the distortion of each triangle in a flat map `uv`: the angles in space;
// the angles in the map minus those in space; twice the signed areas in the map;
// the larger and the smaller singular value; and the ratios of side lengths.
inline TriangleChanges triangle_changes(Values V, Values uv, Corners corner, Numbers double_area, Values products) {
    const Index m = corner.columns;
    Grid<double> angle(3, m), more(3, m), sides(3, m);
    Array<double> signed_double_area(m), major(m), minor(m);
    parallel_for_pieces(m, [&](Index first, Index last) {
        const CornerRows at(corner);
        const CornerRows in_space(angle.matrix()), error(more.matrix()), ratio(sides.matrix());
        double *signed_area = signed_double_area.data(), *larger = major.data(), *smaller = minor.data();
        INDEPENDENT for (Index t = first; t < last; ++t) {
            const auto [i, j, k] = at[t];
            const double x = products[0][t], y = products[1][t], z = products[2][t];
            const double area = double_area[t];
            const Point A = point(V, i), B = point(V, j), C = point(V, k), p = C - B, q = A - C, r = B - A;
            const Complex a = map_point(uv, i), b = map_point(uv, j), c = map_point(uv, k);
            const Complex u = c - b, v = a - c, w = b - a;
            const double length = std::sqrt(dot(r, r)), signed_double = cross(v, w);
            const Triple own{arctangent(area, x), arctangent(area, y), arctangent(area, z)};
            in_space.set(t, own);
            // each angle is computed from the two sides at its corner, so that it is 0 if a side has zero length
            error.set(t, {arctangent(std::abs(signed_double), -dot(v, w)) - own.a,
                          arctangent(std::abs(cross(w, u)), -dot(w, u)) - own.b,
                          arctangent(std::abs(cross(u, v)), -dot(u, v)) - own.c});
            ratio.set(t, {std::sqrt(dot(u, u)) / std::sqrt(dot(p, p)), std::sqrt(dot(v, v)) / std::sqrt(dot(q, q)),
                          std::sqrt(dot(w, w)) / length});
            signed_area[t] = signed_double;
            // columns c1 and c2 of the Jacobian, with side 0-1 as x axis: w = length c1, -v = (x c1 + area c2) / length
            const Complex first = 1 / length * w, second = 1 / area * ((-length) * v - x * first);
            const Complex plus{first.x + second.y, first.y - second.x}, minus{first.x - second.y, first.y + second.x};
            const double most = (std::sqrt(dot(plus, plus)) + std::sqrt(dot(minus, minus))) / 2;
            larger[t] = most;
            smaller[t] = most > 0 ? std::abs(cross(first, second)) / most : 0.0;
        }
    });
    return {std::move(angle), std::move(more),  std::move(signed_double_area),
            std::move(major), std::move(minor), std::move(sides)};
}

}  // namespace angles
