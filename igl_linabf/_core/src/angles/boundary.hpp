// Boundary loops drawn one edge after another, by the turning and the change of length at each vertex.
#pragma once
#include "../arrays.hpp"

namespace angles {

// The edges of a loop of n vertices, of which edge k leaves vertex k, over their total length.
//
// The logarithms of the lengths grow by log_ratio(k), of which the mean is taken off, so that the loop ends at the
// scale at which it begins; directions turn by turning(k).
template <class Ratio, class Turning>
void develop(Index n, const Ratio& log_ratio, const Turning& turning, Complex* edge) {
    double mean = 0, at = 0, largest = -INFINITY, total = 0;
    for (Index k = 0; k < n; ++k) mean += log_ratio(k) / double(n);
    for (Index k = 0; k < n; ++k) {
        edge[k] = {at += log_ratio(k) - mean, 0};
        largest = std::max(largest, at);
    }
    at = 0;
    for (Index k = 0; k < n; ++k) {
        const double length = std::exp(edge[k].x - largest);
        at += turning(k);
        total += length;
        edge[k] = length * direction(at);
    }
    for (Index k = 0; k < n; ++k) edge[k] = edge[k] / total;
}

inline double inverse_length(Complex edge) {  // 0 of an edge that has no length in double precision
    const double length = std::hypot(edge.x, edge.y);
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
        double missing = 2 * PI, free = 0;
        for (Index k = first; k < first + n; ++k) missing -= turning[k], free += movable[k];
        Complex* edge = z.data() + first;
        develop(n, [&](Index k) { return log_ratio[first + k]; },
                [&](Index k) { return turning[first + k] + (movable[first + k] ? missing / free : 0.0); }, edge);
        Complex gap{0, 0}, at{0, 0};
        double xx = 0, xy = 0, yy = 0;
        for (Index k = 0; k < n; ++k) {
            const double x = edge[k].x, y = edge[k].y, over = inverse_length(edge[k]);
            gap = gap + edge[k];
            xx += x * x * over, xy += x * y * over, yy += y * y * over;
        }
        gaps[i] = std::hypot(gap.x, gap.y);
        const double det = xx * yy - xy * xy;  // 0, and all of it infinite, where all edges are parallel
        const double u = (xy * gap.y - yy * gap.x) / det, v = (xy * gap.x - xx * gap.y) / det;
        for (Index k = 0; k < n; ++k) {
            const Complex next = edge[k];
            edge[k] = at;
            at = at + (1 + (u * next.x + v * next.y) * inverse_length(next)) * next;
        }
    }
    return {std::move(z), std::move(gaps)};
}

// The gaps of loops that turn by -2 pi, in units of their length, and the derivatives by log_ratio + i turning at
// their vertices: the vector from the vertex to the loop's end, minus its mean, over all vertices as the loop's start.
// What a loop turns by too much is spread evenly over it first.
inline std::tuple<Array<Complex>, Array<Complex>> lay_out_loops(View<const Index> vertex, View<const Index> start,
                                                              View<const double> turning,
                                                              View<const double> log_ratio) {
    Array<Complex> gap(start.size - 1), q(vertex.size);
    for (Index i = 0; i < gap.size(); ++i) {
        const Index first = start[i], n = start[i + 1] - first;
        double angle = 2 * PI;
        for (Index k = first; k < first + n; ++k) angle += turning[vertex[k]];
        angle /= double(n);
        Complex* edge = q.data() + first;
        develop(n, [&](Index k) { return log_ratio[vertex[first + k]]; },
                [&](Index k) { return turning[vertex[first + k]] - angle; }, edge);
        Complex to_end{0, 0}, mean{0, 0};
        for (Index k = n - 1; k >= 0; --k) edge[k] = to_end = to_end + edge[k];
        gap[i] = to_end;
        for (Index k = 0; k < n; ++k) mean = mean + (edge[k] = edge[k] + double(k) / double(n) * to_end);
        mean = mean / double(n);
        for (Index k = 0; k < n; ++k) edge[k] = edge[k] - mean;
    }
    return {std::move(gap), std::move(q)};
}

}  // namespace angles
