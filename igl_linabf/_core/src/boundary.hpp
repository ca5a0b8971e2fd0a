// Boundary loops drawn one edge after another, by the turning and the change of length at each vertex.
#pragma once
#include <algorithm>
#include <cmath>
#include <complex>
#include <tuple>

#include "arrays.hpp"

namespace angles {

using Complex = std::complex<double>;

constexpr double TURN = 6.283185307179586;  // 2 pi

// The edges of a loop of n vertices, of which edge k leaves vertex k, over their total length.
//
// The logarithms of the lengths grow by log_ratio(k), of which the mean is taken off, so that the loop ends at the
// scale at which it begins; directions turn by turning(k).
template <class Ratio, class Turning>
void develop(Index n, const Ratio& log_ratio, const Turning& turning, Complex* edge) {
    double mean = 0, at = 0, largest = -INFINITY, total = 0;
    for (Index k = 0; k < n; ++k) mean += log_ratio(k) / double(n);
    for (Index k = 0; k < n; ++k) {
        edge[k] = at += log_ratio(k) - mean;
        largest = std::max(largest, at);
    }
    at = 0;
    for (Index k = 0; k < n; ++k) {
        const double length = std::exp(edge[k].real() - largest);
        at += turning(k);
        total += length;
        edge[k] = {length * std::cos(at), length * std::sin(at)};
    }
    for (Index k = 0; k < n; ++k) edge[k] /= total;
}

inline double inverse_length(Complex edge) {  // 0 of an edge that has no length in double precision
    const double length = std::abs(edge);
    return length > 0 ? 1 / length : 0;
}

// Outer loops from the exterior angles and the logarithms of length ratios at their vertices, and their relative gaps.
//
// What angles miss of 2 pi is spread over those that are `movable`. A loop is closed by the smallest change of
// lengths, min sum delta^2 / l: delta = l Re(conj(edge) mu), a 2 by 2 system for mu. It begins at 0.
inline std::tuple<Array<Complex>, Array<double>> developed_loops(View<const Index> start, View<const double> turning,
                                                                 View<const double> log_ratio,
                                                                 View<const bool> movable) {
    Array<Complex> z(turning.size);
    Array<double> gaps(start.size - 1);
    for (Index i = 0; i < gaps.size(); ++i) {
        const Index first = start[i], n = start[i + 1] - first;
        double missing = TURN, free = 0;
        for (Index k = first; k < first + n; ++k) missing -= turning[k], free += movable[k];
        Complex* edge = z.data() + first;
        develop(n, [&](Index k) { return log_ratio[first + k]; },
                [&](Index k) { return turning[first + k] + (movable[first + k] ? missing / free : 0.0); }, edge);
        Complex gap = 0, at = 0;
        double xx = 0, xy = 0, yy = 0;
        for (Index k = 0; k < n; ++k) {
            const double x = edge[k].real(), y = edge[k].imag(), over = inverse_length(edge[k]);
            gap += edge[k];
            xx += x * x * over, xy += x * y * over, yy += y * y * over;
        }
        gaps[i] = std::abs(gap);
        const double det = xx * yy - xy * xy;  // 0, and all of it infinite, where all edges are parallel
        const double u = (xy * gap.imag() - yy * gap.real()) / det, v = (xy * gap.real() - xx * gap.imag()) / det;
        for (Index k = 0; k < n; ++k) {
            const Complex next = edge[k];
            edge[k] = at;
            at += next * (1 + (u * next.real() + v * next.imag()) * inverse_length(next));
        }
    }
    return {std::move(z), std::move(gaps)};
}

// The gaps of loops that turn by -2 pi, in units of their length, and the derivatives by log_ratio + i turning at
// their vertices: the vector from the vertex to the loop's end, minus its mean, over all vertices as the loop's start.
// What a loop turns by too much is spread evenly over it first.
inline std::tuple<Array<Complex>, Array<Complex>> drawn_loops(View<const Index> vertex, View<const Index> start,
                                                              View<const double> turning,
                                                              View<const double> log_ratio) {
    Array<Complex> gap(start.size - 1), q(vertex.size);
    for (Index i = 0; i < gap.size(); ++i) {
        const Index first = start[i], n = start[i + 1] - first;
        double angle = TURN;
        for (Index k = first; k < first + n; ++k) angle += turning[vertex[k]];
        angle /= double(n);
        Complex* edge = q.data() + first;
        develop(n, [&](Index k) { return log_ratio[vertex[first + k]]; },
                [&](Index k) { return turning[vertex[first + k]] - angle; }, edge);
        Complex to_end = 0, mean = 0;
        for (Index k = n - 1; k >= 0; --k) edge[k] = to_end += edge[k];
        gap[i] = to_end;
        for (Index k = 0; k < n; ++k) mean += edge[k] += to_end * (double(k) / double(n));
        mean /= double(n);
        for (Index k = 0; k < n; ++k) edge[k] -= mean;
    }
    return {std::move(gap), std::move(q)};
}

}  // namespace angles
