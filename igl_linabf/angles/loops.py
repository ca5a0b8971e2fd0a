"""The loops of holes, drawn from the angles at them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._types import ComplexArray, FloatArray, IntArray
from ..surface import Topology


@dataclass(frozen=True, eq=False)
class Closure:
    """The loops of the holes, drawn from the angles (docs/holes.md).

    First the exterior angles are shifted to sum to -2 pi, and the logarithms of the length ratios to
    sum to 0, evenly over a loop. The derivative is averaged over all starting vertices, so the
    result does not depend on the start.

    Attributes
    ----------
    gap : (#holes,) complex128
        tau: vector from the start to the end of each loop, in units of its length.
    vertex, hole : (#L,) int64
        The vertices of all these loops, and the hole of each.
    q : (#L,) complex128
        Derivative of the gap with respect to log_ratio + i turning at the vertex: the vector from
        the vertex to the loop's end, minus its mean over the loop.
    """

    gap: ComplexArray
    vertex: IntArray
    hole: IntArray
    q: ComplexArray


def closure_of(topology: Topology, turning: FloatArray, log_ratio: FloatArray) -> Closure:
    """Draw each hole's loop; `turning` and `log_ratio` as in `Residual`."""
    holes = topology.holes
    gap, q = np.zeros(len(holes), dtype=np.complex128), []
    for i, loop in enumerate(holes):
        angle, ratio = turning[loop], log_ratio[loop]
        angle = angle - (angle.sum() + 2 * np.pi) / len(loop)  # the mesh on the left: clockwise
        length = np.cumsum(ratio - ratio.mean())
        edge = np.exp(length - length.max() + 1j * np.cumsum(angle))  # it leaves the loop vertex
        edge /= np.abs(edge).sum()
        to_end = np.cumsum(edge[::-1])[::-1]
        gap[i] = to_end[0]
        to_end += gap[i] * np.arange(len(loop)) / len(loop)  # the mean over all beginnings
        q.append(to_end - to_end.mean())
    if not holes:
        return Closure(gap, np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), gap)
    hole = np.repeat(np.arange(len(holes)), [len(loop) for loop in holes])
    return Closure(gap, np.concatenate(holes), hole, np.concatenate(q))
