// Closed loops drawn one edge after another, by the turning and the change of length at each vertex.
#pragma once
#include <algorithm>
#include <cmath>
#include <complex>

#include "arrays.hpp"

using Complex = std::complex<double>;

// The gaps of loops that turn by -2 pi, in units of their length, and the derivatives by log_ratio + i turning at
// their vertices: the vector from the vertex to the loop's end, minus its mean, over all vertices as the loop's start.
// What a loop turns by too much and the change of scale are spread evenly over it first.
inline std::pair<Array<Complex>, Array<Complex>> drawn_loops(View<const Index> vertex, View<const Index> start,
                                                             View<const double> turning,
                                                             View<const double> log_ratio) {
    Array<Complex> gap(start.size - 1), q(vertex.size);
    std::vector<double> length(vertex.size);
    for (Index i = 0; i < gap.size(); ++i) {
        const Index first = start[i], end = start[i + 1];
        const double size = double(end - first);
        double angle = 2 * std::acos(-1.0), ratio = 0, total = 0;
        for (Index k = first; k < end; ++k) angle += turning[vertex[k]], ratio += log_ratio[vertex[k]];
        angle /= size, ratio /= size;
        double at = 0, largest = -INFINITY;
        for (Index k = first; k < end; ++k) {
            length[k] = at += log_ratio[vertex[k]] - ratio;
            largest = std::max(largest, at);
        }
        at = 0;
        for (Index k = first; k < end; ++k) {
            const double edge = std::exp(length[k] - largest);
            total += edge;
            at += turning[vertex[k]] - angle;
            q[k] = {edge * std::cos(at), edge * std::sin(at)};
        }
        Complex to_end = 0, mean = 0;
        for (Index k = end - 1; k >= first; --k) q[k] = to_end += q[k] / total;
        gap[i] = to_end;
        for (Index k = first; k < end; ++k) mean += q[k] += to_end * (double(k - first) / size);
        mean /= size;
        for (Index k = first; k < end; ++k) q[k] -= mean;
    }
    return {std::move(gap), std::move(q)};
}
