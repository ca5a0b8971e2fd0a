"""The loops of holes, as the angles at them draw them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._types import ComplexArray, FloatArray, IntArray
from ..surface import Topology


@dataclass(frozen=True, eq=False)
class Closure:
    """The loops of the holes, as the angles draw them (docs/holes.md).

    What is missing of the turning and of the logarithms of the lengths is spread evenly over a
    loop first, and the gap over the derivative, so that nothing depends on the vertex where the
    drawing begins.

    Attributes
    ----------
    gap : (#holes,) complex128
        tau, by which each loop fails to close, in units of its length.
    vertex, hole : (#L,) int64
        The vertices of all these loops, and which hole each belongs to.
    q : (#L,) complex128
        From each of them to its loop's end, less the mean of that over the loop: the gap's
        derivative by log_ratio + i turning there.
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
