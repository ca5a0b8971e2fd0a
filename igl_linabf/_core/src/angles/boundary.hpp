// Layout of boundary loops, edge by edge, from the turning angle and the length ratio at each vertex.
#pragma once
#include "../arrays.hpp"

namespace angles {

// Compute the edges of a loop of n vertices, divided by their total length. Edge k starts at vertex k.
//
// The logarithm of the length increases by log_ratio(k) minus the mean of log_ratio,
// so that the loop begins and ends with the same scale.
// The direction turns by turning(k).
template <class Ratio, class Turning>
void develop_loop(Index n, const Ratio& log_ratio, const Turning& turning, Complex* edge) {
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

// Return the reciprocal of the length of an edge, or 0 for an edge of zero length.
inline double inverse_length(Complex edge) {
    const double length = std::hypot(edge.x, edge.y);
    return length > 0 ? 1 / length : 0;
}

// Lay out outer boundary loops from the exterior angles and the logarithms of length ratios at their vertices.
// Returns the positions of the vertices, starting at 0,
// and the closure error of each loop before the correction, relative to its length.
//
// The difference of the angle sum from 2 pi is distributed equally over the angles marked in `movable`.
// The edge lengths l are corrected by the smallest changes delta, which minimize sum delta^2 / l.
// The minimizer is delta = Re(conj(edge) mu), where mu is the solution of a 2 by 2 system.
inline std::tuple<Array<Complex>, Array<double>> develop_loops(View<const Index> start, View<const double> turning,
                                                               View<const double> log_ratio,
                                                               View<const bool> movable) {
    Array<Complex> z(turning.size);
    Array<double> gaps(start.size - 1);
    for (Index i = 0; i < gaps.size(); ++i) {
        const Index first = start[i], n = start[i + 1] - first;
        double missing = 2 * PI, free = 0;
        for (Index k = first; k < first + n; ++k) missing -= turning[k], free += movable[k];
        Complex* edge = z.data() + first;
        develop_loop(n, [&](Index k) { return log_ratio[first + k]; },
                     [&](Index k) { return turning[first + k] + (movable[first + k] ? missing / free : 0.0); }, edge);
        Complex gap{0, 0}, at{0, 0};
        double xx = 0, xy = 0, yy = 0;
        for (Index k = 0; k < n; ++k) {
            const double x = edge[k].x, y = edge[k].y, over = inverse_length(edge[k]);
            gap = gap + edge[k];
            xx += x * x * over, xy += x * y * over, yy += y * y * over;
        }
        gaps[i] = std::hypot(gap.x, gap.y);
        const double det = xx * yy - xy * xy;  // 0 if all edges are parallel; the positions are then infinite or NaN
        const double u = (xy * gap.y - yy * gap.x) / det, v = (xy * gap.x - xx * gap.y) / det;
        for (Index k = 0; k < n; ++k) {
            const Complex next = edge[k];
            edge[k] = at;
            at = at + (1 + (u * next.x + v * next.y) * inverse_length(next)) * next;
        }
    }
    return {std::move(z), std::move(gaps)};
}

// Compute the closure error of each loop, relative to the length of the loop,
// and the derivatives of the error with respect to log_ratio + i turning at each vertex.
// A derivative is the vector from the vertex to the end of the loop, minus the mean of these vectors.
// It is averaged over all choices of the start vertex.
// The loops turn by -2 pi: the difference of the total turning
// from -2 pi is first distributed equally over the vertices.
inline std::tuple<Array<Complex>, Array<Complex>> loop_gaps(View<const Index> vertex, View<const Index> start,
                                                            View<const double> turning,
                                                            View<const double> log_ratio) {
    Array<Complex> gap(start.size - 1), q(vertex.size);
    for (Index i = 0; i < gap.size(); ++i) {
        const Index first = start[i], n = start[i + 1] - first;
        double angle = 2 * PI;
        for (Index k = first; k < first + n; ++k) angle += turning[vertex[k]];
        angle /= double(n);
        Complex* edge = q.data() + first;
        develop_loop(n, [&](Index k) { return log_ratio[vertex[first + k]]; },
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
