"""Closed loops drawn one edge after another, by the turning and the change of length at each vertex."""

import numpy as np

from .._types import ComplexArray, FloatArray, IntArray
from .choice import with_loops


def _drawn_loops(
    vertex: IntArray, start: IntArray, turning: FloatArray, log_ratio: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    gap, q = np.empty(len(start) - 1, dtype=np.complex128), np.empty(len(vertex), dtype=np.complex128)
    length = np.empty(len(vertex))
    for i in range(len(gap)):
        first, end = start[i], start[i + 1]
        size, angle, ratio = end - first, 2 * np.pi, 0.0
        for k in range(first, end):
            angle += turning[vertex[k]]
            ratio += log_ratio[vertex[k]]
        angle, ratio = angle / size, ratio / size
        at, largest = 0.0, -np.inf
        for k in range(first, end):
            at += log_ratio[vertex[k]] - ratio
            length[k] = at
            largest = max(largest, at)
        at, total = 0.0, 0.0
        for k in range(first, end):
            at += turning[vertex[k]] - angle
            edge = np.exp(length[k] - largest)
            total += edge
            q[k] = complex(edge * np.cos(at), edge * np.sin(at))
        to_end, mean = 0j, 0j
        for k in range(end - 1, first - 1, -1):
            to_end += q[k] / total
            q[k] = to_end
        gap[i] = to_end
        for k in range(first, end):
            q[k] += to_end * ((k - first) / size)
            mean += q[k]
        mean /= size
        for k in range(first, end):
            q[k] -= mean
    return gap, q


@with_loops(_drawn_loops)
def drawn_loops(
    vertex: IntArray, start: IntArray, turning: FloatArray, log_ratio: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """The gaps of loops that turn by -2 pi, and their derivatives by the vertices; see `Closure`.

    Parameters
    ----------
    vertex : (#L,) int64
        The vertices of the loops, one after another.
    start : (#loops + 1,) int64
        Where each begins.
    turning, log_ratio : (#V,) float64
        As in `Residual`.

    Returns
    -------
    gap : (#loops,) complex128
    q : (#L,) complex128
    """
    gap, q = np.zeros(len(start) - 1, dtype=np.complex128), np.empty(len(vertex), dtype=np.complex128)
    for i in range(len(gap)):
        own = slice(start[i], start[i + 1])
        angle, ratio = turning[vertex[own]], log_ratio[vertex[own]]
        angle = angle - (angle.sum() + 2 * np.pi) / len(angle)  # the mesh on the left: clockwise
        length = np.cumsum(ratio - ratio.mean())
        edge = np.exp(length - length.max() + 1j * np.cumsum(angle))  # it leaves the loop vertex
        edge /= np.abs(edge).sum()
        to_end = np.cumsum(edge[::-1])[::-1]
        gap[i] = to_end[0]
        to_end += gap[i] * np.arange(len(angle)) / len(angle)  # the mean over all beginnings
        q[own] = to_end - to_end.mean()
    return gap, q
