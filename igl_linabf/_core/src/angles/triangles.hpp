// Computations in each triangle, and sums over the corners at each vertex.
// Arrays over corners are (3, #F).
// The corners k, k + 1 and k + 2 are in counter-clockwise order, and side k is opposite to corner k.
#pragma once
#include <limits>
#include <stdexcept>

#include "../threads.hpp"

namespace angles {

using Corners = Matrix<const Index>;
using Values = Matrix<const double>;
using Numbers = View<const double>;

constexpr double EPS = std::numeric_limits<double>::epsilon(), TINY = std::numeric_limits<double>::min();
constexpr double LARGEST_COT = 1e75;  // clamp cotangents so that squares of products are finite

// The values at the three corners of one triangle.
template <class T>
struct Three {
    T a, b, c;
};
using Triple = Three<double>;

// The three rows of an array over corners, (3, #F).
template <class T>
struct CornerRows {
    T *a, *b, *c;

    explicit CornerRows(Matrix<T> m) : a(m[0]), b(m[1]), c(m[2]) {}
    Three<std::remove_const_t<T>> operator[](Index t) const { return {a[t], b[t], c[t]}; }
    void set(Index t, Triple v) const { a[t] = v.a, b[t] = v.b, c[t] = v.c; }
};

// Return an array of n values. `at(i)` returns value i.
template <class At>
Array<double> tabulate(Index n, const At& at) {
    Array<double> result(n);
    parallel_for_pieces(n, [&](Index first, Index last) {
        const At own = at;
        double* to = result.data();
        INDEPENDENT for (Index i = first; i < last; ++i) to[i] = own(i);
    });
    return result;
}

// Return an array over the corners, (3, #F). `at(t)` returns the three values of triangle t.
template <class At>
Grid<double> tabulate_corners(Index m, const At& at) {
    Grid<double> result(3, m);
    parallel_for_pieces(m, [&](Index first, Index last) {
        const At own = at;
        const CornerRows<double> to(result.matrix());
        INDEPENDENT for (Index t = first; t < last; ++t) to.set(t, own(t));
    });
    return result;
}

template <class Made = Array<double>, class... Shape>
Made zeros(Shape... shape) {
    Made result(shape...);
    std::fill_n(result.data(), result.size(), 0.0);
    return result;
}

// Sum the values that have the same index, for each index 0 .. n - 1.
inline Array<double> sum_by_index(View<const Index> index, Numbers values, Index n) {
    Array<double> result = zeros(n);
    for (Index i = 0; i < index.size; ++i) {
        if (std::uint64_t(index[i]) >= std::uint64_t(n))
            throw std::invalid_argument("sum_by_index: an index is not below n");
        result[index[i]] += values[i];
    }
    return result;
}

struct Point {
    double x, y, z;
};
inline Point point(Values V, Index v) {
    check_index(v, V.rows);
    return {V.data[3 * v], V.data[3 * v + 1], V.data[3 * v + 2]};
}
inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline double dot(Point a, Point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Point cross(Point a, Point b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double largest_coordinate(Point a) { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); }

// Compute twice the area of each triangle, the scalar products of the sides at its corners,
// and a bound of the rounding error of the double area:
// the longest side times the rounding error eps |x| of the largest coordinate.
inline std::tuple<Array<double>, Grid<double>, Array<double>> side_products(Values V, Corners corner) {
    const Index m = corner.columns;
    Array<double> double_area(m), least(m);
    Grid<double> products(3, m);
    parallel_for_pieces(m, [&](Index first, Index last) {
        const CornerRows at(corner);
        const CornerRows to(products.matrix());
        double *area = double_area.data(), *tiny = least.data();
        INDEPENDENT for (Index t = first; t < last; ++t) {
            const auto [a, b, c] = at[t];
            const Point A = point(V, a), B = point(V, b), C = point(V, c), p = C - B, q = A - C, r = B - A;
            to.set(t, {-dot(q, r), -dot(r, p), -dot(p, q)});
            const Point normal = cross(p, q);
            area[t] = std::sqrt(dot(normal, normal));
            const double longest = std::sqrt(std::max({dot(p, p), dot(q, q), dot(r, r)}));
            const double farthest = std::max({largest_coordinate(A), largest_coordinate(B), largest_coordinate(C)});
            tiny[t] = 4 * EPS * longest * std::max(longest, farthest);
        }
    });
    return {std::move(double_area), std::move(products), std::move(least)};
}

// Return the unit normals of triangles, (#F, 3).
// Rounding decides whether the normal of a degenerate triangle is zero or has an arbitrary direction.
inline Grid<double> normals(Values V, Corners corner) {
    Grid<double> result(corner.columns, 3);
    parallel_for_pieces(corner.columns, [&](Index first, Index last) {
        for (Index t = first; t < last; ++t) {
            const Point A = point(V, corner[0][t]);
            const Point n = cross(point(V, corner[1][t]) - A, point(V, corner[2][t]) - A);
            const double share = 1 / std::max(std::sqrt(dot(n, n)), TINY);
            double* to = result.data() + 3 * t;
            to[0] = n.x * share, to[1] = n.y * share, to[2] = n.z * share;
        }
    });
    return result;
}

// Return the lengths of edges, given by their end vertices (#E, 2), in space or in the plane.
inline Array<double> lengths(Values V, Matrix<const Index> edges) {
    return tabulate(edges.rows, [=](Index e) {
        const double *a = V[edges[e][0]], *b = V[edges[e][1]];
        double squared = 0;
        for (Index j = 0; j < V.columns; ++j) squared += (a[j] - b[j]) * (a[j] - b[j]);
        return std::sqrt(squared);
    });
}

// Return cot x by the rational approximation of the tangent in Cephes (Moshier 1989), which compilers can vectorize.
inline double cotangent(double x) {
    const double quarter = std::floor(x * (2 / PI) + 0.5), y = x - quarter * (PI / 2), z = y * y;
    const double p = (-1.30936939181383734205e4 * z + 1.15351664838587416140e6) * z - 1.79565251976484877988e7;
    const double q = ((z + 1.36812963470692954678e4) * z - 1.32089234440210967447e6) * z + 2.50083801823357915839e7;
    const double tangent = y + y * (z * p / (q * z - 5.38695755929454629881e7));
    return quarter == 2 * std::floor(quarter / 2) ? 1 / tangent : -tangent;
}

// Return the angle of x + i y in [0, pi] for y >= 0, by the approximation of the arctangent in Cephes (Moshier 1989).
// The angle is 0 if x = y = 0.
inline double arctangent(double y, double x) {
    const double low = std::min(y, std::abs(x)), high = std::max(y, std::abs(x));
    const bool steep = low > 0.66 * high;
    const double u = (steep ? low - high : low) / (steep ? low + high : std::max(high, TINY)), z = u * u;
    const double p = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z -
                       7.500855792314704667340e1) * z - 1.228866684490136173410e2) * z - 6.485021904942025371773e1;
    const double q = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z +
                       4.328810604912902668951e2) * z + 4.853903996359136964868e2) * z + 1.945506571482613964425e2;
    const double angle = u + u * (z * p / q) + (steep ? PI / 4 : 0.0);
    const double acute = y > std::abs(x) ? PI / 2 - angle : angle;
    return x < 0 ? PI - acute : acute;
}

// Return the dihedral angle between the face normals at each edge, negative at concave edges.
// `sides`, (2, #E), are the half-edges of each edge.
inline Array<double> dihedrals(Values V, Corners corner, Matrix<const Index> sides, Values normal) {
    const Index m = corner.columns;
    return tabulate(sides.columns, [=](Index e) {
        const Index s = sides[0][e], t = sides[1][e];
        const Index i = (s >= m) + (s >= 2 * m), j = (t >= m) + (t >= 2 * m);
        const Point turned = point(normal, s - i * m) - point(normal, t - j * m);
        const double sine = std::min(std::sqrt(dot(turned, turned)) / 2, 1.0);
        const double angle = 2 * arctangent(sine, std::sqrt((1 - sine) * (1 + sine)));
        const Point across = point(V, corner.data[t]) - point(V, corner.data[s]);
        return dot(across, turned) > 0 ? -angle : angle;
    });
}

// Return cot alpha, which is infinite for angles of 0 in collapsed triangles.
inline Grid<double> cotangents(Values alpha) {
    return tabulate_corners(alpha.columns, [angle = CornerRows(alpha)](Index t) {
        const auto [a, b, c] = angle[t];
        return Triple{cotangent(a), cotangent(b), cotangent(c)};
    });
}

using FlaggedAngles = std::tuple<Grid<double>, Array<bool>>;  // an array over corners, and a mask of triangles

// Compute, by half-angle formulas, the angles of triangles after each side is multiplied
// by the factor of its opposite vertex.
// Also mark the triangles whose sides violate the triangle inequality; their angles are meaningless.
inline FlaggedAngles rescaled_angles(Corners corner, Values length, Numbers factor) {
    const Index m = corner.columns;
    Grid<double> alpha(3, m);
    Array<bool> impossible(m);
    parallel_for_pieces(m, [&](Index first, Index last) {
        const CornerRows at(corner);
        const CornerRows side(length);
        const CornerRows to(alpha.matrix());
        const double* scale = factor.data;
        bool* bad = impossible.data();
        INDEPENDENT for (Index t = first; t < last; ++t) {
            const auto [i, j, k] = at[t];
            double a = side.a[t] * scale[i], b = side.b[t] * scale[j], c = side.c[t] * scale[k];
            const double size = std::max(a, std::max(b, c));
            a /= size, b /= size, c /= size;
            const double p = (b + c - a) / 2, q = (c + a - b) / 2, r = (a + b - c) / 2;
            bad[t] = !((p > 0) & (q > 0) & (r > 0));
            const double x = std::max(p, 0.0), y = std::max(q, 0.0), z = std::max(r, 0.0);
            const double inradius = std::sqrt(x * y * z / ((a + b + c) / 2));
            to.set(t, {2 * arctangent(inradius, x), 2 * arctangent(inradius, y), 2 * arctangent(inradius, z)});
        }
    });
    return {std::move(alpha), std::move(impossible)};
}

using ConstraintSums = std::tuple<Array<double>, Array<double>>;  // sums for vertex and wheel constraints

// Compute, for each vertex, the sum of its angles and the sum of log sin(gamma) - log sin(beta) over the right
// and left angles of its wheel (eq. 5 and 10).
// For speed, the sines are multiplied before the logarithm is taken,
// as long as the product can neither overflow nor underflow.
inline ConstraintSums angle_sums(Corners corner, Values alpha, Values cot, Index n) {
    Array<double> vertex = zeros(n), wheel = zeros(n), ratio(n);
    std::fill_n(ratio.data(), n, 1.0);
    const CornerRows at(corner);
    const CornerRows angle(alpha), cotangent(cot);
    const auto add = [&](Index v, double angle, double above, double below) {
        vertex[v] += angle;
        ratio[v] *= above / below;
        if (!(ratio[v] > 1e-150 && ratio[v] < 1e150)) {  // the next product could overflow
            wheel[v] += std::log(ratio[v]);
            ratio[v] = 1;
        }
    };
    const auto squared_cosecant = [](double cot) {
        const double c = std::min(std::abs(cot), LARGEST_COT);
        return 1 + c * c;
    };
    for (Index t = 0; t < corner.columns; ++t) {
        const auto [i, j, k] = at[t];
        const auto [a, b, c] = angle[t];
        const double p = squared_cosecant(cotangent.a[t]), q = squared_cosecant(cotangent.b[t]);
        const double r = squared_cosecant(cotangent.c[t]);
        add(i, a, q, r);
        add(j, b, r, p);
        add(k, c, p, q);
    }
    for (Index v = 0; v < n; ++v) wheel[v] = 0.5 * (wheel[v] + std::log(ratio[v]));
    return {std::move(vertex), std::move(wheel)};
}

// Return M e: the change of the vertex and the wheel constraint of each vertex by the errors e (eq. 5 and 8 to 10).
inline ConstraintSums constraint_changes(Corners corner, Values cot, Values e, Index n) {
    Array<double> vertex = zeros(n), wheel = zeros(n);
    const CornerRows at(corner);
    const CornerRows cotangent(cot), error(e);
    for (Index t = 0; t < corner.columns; ++t) {
        const auto [i, j, k] = at[t];
        const auto [a, b, c] = error[t];
        const double p = cotangent.a[t] * a, q = cotangent.b[t] * b, r = cotangent.c[t] * c;
        vertex[i] += a, vertex[j] += b, vertex[k] += c;
        wheel[i] += q - r, wheel[j] += r - p, wheel[k] += p - q;
    }
    return {std::move(vertex), std::move(wheel)};
}

// Return P y of one triangle, where P = diag(w) - w w^T / d.
// Differences avoid the cancellation of w - w^2 / d near an angle of pi.
inline Triple project_triangle(Triple w, double d, Triple y) {
    const double p = y.b - y.c, q = y.c - y.a, r = y.a - y.b;
    return {w.a * ((w.b * r - w.c * q) / d), w.b * ((w.c * p - w.a * r) / d), w.c * ((w.a * q - w.b * p) / d)};
}

// Return K y of one triangle, where K is its cotangent matrix.
inline Triple apply_cotangent_matrix(Triple cot, Triple y) {
    const double p = cot.a * (y.b - y.c) / 2, q = cot.b * (y.c - y.a) / 2, r = cot.c * (y.a - y.b) / 2;
    return {r - q, p - r, q - p};
}

// Return a function that computes the three entries of M^T x in a triangle.
// The vector x consists of the multipliers of the vertex constraints and of the wheel constraints, (n,) each.
inline auto transpose_product(Corners corner, Values cot, Numbers vertex, Numbers wheel) {
    return [at = CornerRows(corner), cot = CornerRows(cot), vertex, wheel](Index t) {
        const auto [i, j, k] = at[t];
        const double x = wheel[i], y = wheel[j], z = wheel[k];
        return Triple{vertex[i] + cot.a[t] * (z - y), vertex[j] + cot.b[t] * (x - z), vertex[k] + cot.c[t] * (y - x)};
    };
}

// Return P y, (3, #F). Its three values in each triangle sum to zero.
inline Grid<double> project_errors(Values w, Numbers d, Values y) {
    return tabulate_corners(w.columns, [w = CornerRows(w), d, y = CornerRows(y)](Index t) {
        return project_triangle(w[t], d[t], y[t]);
    });
}

// Return the angle errors P M^T x, (3, #F).
// The vector x consists of the multipliers of the vertex constraints and of the wheel constraints, (n,) each.
inline Grid<double> errors(Corners corner, Values w, Numbers d, Values cot, Numbers vertex, Numbers wheel) {
    const auto y = transpose_product(corner, cot, vertex, wheel);
    return tabulate_corners(corner.columns,
                            [y, w = CornerRows(w), d](Index t) { return project_triangle(w[t], d[t], y(t)); });
}

// Return the angle errors K M^T x, (3, #F), where K is the cotangent matrix of each triangle.
// The vector x consists of the multipliers of the vertex constraints and of the wheel constraints, (n,) each.
inline Grid<double> conformal_errors(Corners corner, Values cot, Numbers vertex, Numbers wheel) {
    const auto y = transpose_product(corner, cot, vertex, wheel);
    return tabulate_corners(corner.columns,
                            [y, cot = CornerRows(cot)](Index t) { return apply_cotangent_matrix(cot[t], y(t)); });
}

// Limit the step of each triangle to `reach` times the step length that makes its first angle zero.
// Also return a mask of the triangles whose full step would make an angle zero or negative.
inline FlaggedAngles limit_step(Values alpha, Values e, double reach) {
    const Index m = alpha.columns;
    Grid<double> result(3, m);
    Array<bool> vanishing(m);
    parallel_for_pieces(m, [&](Index first, Index last) {
        const CornerRows angle(alpha), error(e);
        const CornerRows to(result.matrix());
        bool* cut = vanishing.data();
        const auto times = [](double angle, double error) { return error < 0 ? angle / -error : INFINITY; };
        INDEPENDENT for (Index t = first; t < last; ++t) {
            const auto [x, y, z] = error[t];
            const double a = times(angle.a[t], x), b = times(angle.b[t], y), c = times(angle.c[t], z);
            const double least = std::min(a, std::min(b, c)), share = std::min(reach * least, 1.0);
            to.set(t, {x * share, y * share, z * share});
            cut[t] = least <= 1;
        }
    });
    return {std::move(result), std::move(vanishing)};
}

}  // namespace angles
