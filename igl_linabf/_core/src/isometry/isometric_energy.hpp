// The distortion energy of nearly isometric maps: its value in each triangle, gradient, convexified Hessian, and the
// step sizes at which triangles degenerate.
//
// The map w -> p w + q conj(w) of a triangle from its own plane has the singular values |p| + |q| and |p| - |q|.
// With A = |p|^2, B = |q|^2 and J = A - B, the energy is E = c a^weight.
// The factor c = (A + B) / J measures angle distortion.
// The factor a = (J + 1 / J) / 2 measures area distortion (Degener, Meseth, Klein 2003).
#pragma once
#include "../angles/triangles.hpp"

namespace isometry {

using angles::Corners, angles::Numbers, angles::CornerRows, angles::Values;
using Gradients = Matrix<const Complex>;  // (3, #F): p is the sum of gradient times z over the corners
using Map = View<const Complex>;

inline Complex conjugate(Complex a) { return {a.x, -a.y}; }
inline double squared(Complex a) { return dot(a, a); }

// The Wirtinger derivatives p and q of the map of each triangle, by w and conj(w), which are linear in the positions z.
struct WirtingerDerivatives {
    CornerRows<const Index> corner;
    CornerRows<const Complex> gradient;
    Map z;

    WirtingerDerivatives(Corners corner, Gradients gradient, Map z) : corner(corner), gradient(gradient), z(z) {}

    std::pair<Complex, Complex> operator[](Index t) const {
        const auto [i, j, k] = corner[t];
        const auto [f, g, h] = gradient[t];
        const Complex a = z[i], b = z[j], c = z[k];
        return {times(f, a) + times(g, b) + times(h, c),
                times(conjugate(f), a) + times(conjugate(g), b) + times(conjugate(h), c)};
    }
};

inline double power(double area, double weight) { return weight == 1 ? area : std::pow(area, weight); }

// Return the isometric energy of each triangle times its weight in `share`.
// The energy of flipped and collapsed triangles is infinite.
inline Array<double> isometric_energy(Corners corner, Gradients gradient, Numbers share, Map z, double weight) {
    return angles::tabulate(corner.columns, [=, of = WirtingerDerivatives(corner, gradient, z)](Index t) {
        const auto [p, q] = of[t];
        const double a = squared(p), b = squared(q), j = a - b;
        const double value = share[t] * ((a + b) / j * power((j + 1 / j) / 2, weight));
        return j > 0 ? value : INFINITY;
    });
}

// The first and second derivatives of the isometric energy E with respect to A = |p|^2 and B = |q|^2.
struct EnergyDerivatives {
    double a, b, aa, ab, bb;

    EnergyDerivatives(double A, double B, double weight) {
        const double j = A - B, u = 1 / j, uu = u * u, uuu = uu * u, area = (j + u) / 2, slope = (1 - uu) / 2;
        const double c = (A + B) * u, c_a = -2 * B * uu, c_b = 2 * A * uu;
        const double c_aa = 4 * B * uuu, c_ab = -2 * (A + B) * uuu, c_bb = 4 * A * uuu;
        const double h = power(area, weight), part = weight * h / area;
        const double h_j = part * slope, h_jj = part * ((weight - 1) * slope * slope / area + uuu);
        a = c_a * h + c * h_j;
        b = c_b * h - c * h_j;
        aa = c_aa * h + 2 * c_a * h_j + c * h_jj;
        ab = c_ab * h + (c_b - c_a) * h_j - c * h_jj;
        bb = c_bb * h - 2 * c_b * h_j + c * h_jj;
    }
};

// Compute the gradient of the isometric energy, (6, #F), and four rows of six values per triangle, (24, #F).
// The sum of row row^T is the convexified Hessian.
// Derivatives are first by x of the three corners, then by y.
//
// Because E is a function of |p| and |q|, its Hessian with respect to p and q has the eigenvectors i p, i q,
// and two eigenvectors in the plane of p and q.
// Negative eigenvalues are clamped to 0 (Smith, De Goes, Kim 2019).
inline std::tuple<Grid<double>, Grid<double>> isometric_derivatives(Corners corner, Gradients gradient, Numbers share,
                                                                    Map z, double weight) {
    const Index m = corner.columns;
    Grid<double> slopes(6, m), rows(24, m);
    parallel_for_pieces(m, [&](Index first, Index last) {
        const WirtingerDerivatives of(corner, gradient, z);
        double *slope = slopes.data(), *row = rows.data();
        INDEPENDENT for (Index t = first; t < last; ++t) {
            const auto [p, q] = of[t];
            const double A = squared(p), B = squared(q), r = std::sqrt(A), s = std::sqrt(B), own = share[t];
            const EnergyDerivatives E(A, B, weight);
            const Complex up = 1 / r * p, uq = s > 0 ? 1 / s * q : Complex{1, 0};
            const double rr = 2 * E.a + 4 * A * E.aa, rs = 4 * r * s * E.ab, ss = 2 * E.b + 4 * B * E.bb;
            // the eigenvectors (cos, sin) and (-sin, cos) in the plane of p and q
            const double d = (rr - ss) / 2, half = std::sqrt(d * d + rs * rs);
            const double far = std::sqrt((1 + (half > 0 ? std::abs(d) / half : 1.0)) / 2);
            const double near = half > 0 ? std::abs(rs) / (2 * half * far) : 0.0;
            const double cos = d >= 0 ? far : near, sin = std::copysign(d >= 0 ? near : far, rs);
            const auto scale = [own](double value) { return std::sqrt(own * std::max(value, 0.0)); };
            const double major = scale((rr + ss) / 2 + half), minor = scale((rr + ss) / 2 - half);
            const double around = scale(2 * E.a), beside = scale(2 * E.b);
            const double by_r = own * 2 * r * E.a, by_s = own * 2 * s * E.b;
            for (int k = 0; k < 3; ++k) {
                const Complex g = gradient[k][t];
                const Complex u = times(conjugate(up), g), v = times(conjugate(uq), conjugate(g));
                const Index x = k * m + t, y = (k + 3) * m + t;
                slope[x] = by_r * u.x + by_s * v.x, slope[y] = -(by_r * u.y + by_s * v.y);
                row[x] = major * (cos * u.x + sin * v.x), row[y] = -major * (cos * u.y + sin * v.y);
                row[6 * m + x] = minor * (cos * v.x - sin * u.x), row[6 * m + y] = -minor * (cos * v.y - sin * u.y);
                row[12 * m + x] = around * u.y, row[12 * m + y] = around * u.x;
                row[18 * m + x] = beside * v.y, row[18 * m + y] = beside * v.x;
            }
        }
    });
    return {std::move(slopes), std::move(rows)};
}

// Assemble the 2 by 2 blocks, (entries, 4), of the sum of row row^T over the triangles.
// The six values of a row belong to the x coordinates of the corners, then to the y coordinates.
// The block of corner k is added to entry own[k]. The block of the side opposite to corner k is added to entry across[k]
// or, if across[k] is negative, transposed to entry ~across[k].
inline Grid<double> sum_outer_products(Values rows, Corners own, Corners across, Index entries) {
    const Index m = own.columns, ranks = rows.rows / 6;
    Grid<double> result = angles::zeros<Grid<double>>(entries, 4);
    for (Index t = 0; t < m; ++t) {
        double block[6][4] = {};  // blocks of the three corners, then of the three sides
        for (Index r = 0; r < ranks; ++r) {
            double x[3], y[3];
            for (int k = 0; k < 3; ++k) x[k] = rows[6 * r + k][t], y[k] = rows[6 * r + 3 + k][t];
            for (int k = 0; k < 3; ++k) {
                const int i = (k + 1) % 3, j = (k + 2) % 3;
                double *at = block[k], *beyond = block[k + 3];
                at[0] += x[k] * x[k], at[1] += x[k] * y[k], at[3] += y[k] * y[k];
                beyond[0] += x[i] * x[j], beyond[1] += x[i] * y[j], beyond[2] += y[i] * x[j], beyond[3] += y[i] * y[j];
            }
        }
        for (int k = 0; k < 3; ++k) {
            block[k][2] = block[k][1];
            const Index place = across[k][t], side = place < 0 ? ~place : place;
            if (std::uint64_t(own[k][t]) >= std::uint64_t(entries) || side >= entries)
                throw std::invalid_argument("a place is not below entries");
            if (place < 0) std::swap(block[k + 3][1], block[k + 3][2]);
            double *to = result.data() + 4 * own[k][t], *beyond = result.data() + 4 * side;
            for (int c = 0; c < 4; ++c) to[c] += block[k][c], beyond[c] += block[k + 3][c];
        }
    }
    return result;
}

// Return, for each triangle, the step length along `direction` that collapses the triangle (|p|^2 = |q|^2),
// or infinity if no step collapses it.
inline Array<double> collapse_lengths(Corners corner, Gradients gradient, Map z, Map direction) {
    const WirtingerDerivatives at(corner, gradient, z), change(corner, gradient, direction);
    return angles::tabulate(corner.columns, [at, change](Index t) {
        const auto [p, q] = at[t];
        const auto [dp, dq] = change[t];
        const double a = squared(dp) - squared(dq), b = dot(p, dp) - dot(q, dq), c = squared(p) - squared(q);
        const double sum = -(b + std::copysign(std::sqrt(b * b - a * c), b));  // avoids cancellation
        const double one = sum / a, other = c / sum;
        const double least = one > 0 ? one : INFINITY;  // NaN, if there is no real root, becomes infinity
        return other > 0 && other < least ? other : least;
    });
}

}  // namespace isometry
