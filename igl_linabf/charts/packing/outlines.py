"""The outlines of charts: their boundary sides, turned and placed, without the triangles inside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..._types import ComplexArray, FloatArray, IntArray
from ...surface import Ragged


@dataclass(frozen=True, eq=False)
class Outline:
    """The sides of a chart's triangles that do not cancel out.

    Attributes
    ----------
    start, end : (#S,) complex128
        The chart lies on their left.
    weight : (#S,) int64
        How often each counts; 1 in an oriented manifold.
    area : float
        The chart's.
    """

    start: ComplexArray
    end: ComplexArray
    weight: IntArray
    area: float


def extents(z: ComplexArray, charts: Ragged) -> tuple[ComplexArray, ComplexArray]:
    """Lower left corners of the rectangles around charts, and their extents."""
    low = charts.min(z.real) + 1j * charts.min(z.imag)
    return low, charts.max(z.real) + 1j * charts.max(z.imag) - low


def outlines_of(
    z: ComplexArray, F: IntArray, vertices: Ragged, faces: Ragged, area: FloatArray
) -> list[Outline]:
    """The outlines of charts whose vertices and faces stand one after the other."""
    tail, head = F.ravel(), F[:, [1, 2, 0]].ravel()
    key = np.sort((np.minimum(tail, head) * len(z) + np.maximum(tail, head)) * 2 + (tail > head))
    first = np.flatnonzero(np.diff(key // 2, prepend=-1))
    net = np.add.reduceat(1 - 2 * (key % 2), first) if len(key) else key  # how often each edge runs upwards
    left = net != 0
    (low, high), net = np.divmod(key[first[left]] // 2, len(z)), net[left]
    start, end = np.where(net > 0, low, high), np.where(net > 0, high, low)
    bounds = np.searchsorted(low, vertices.start)  # edges are sorted by their lower vertex
    weight = np.abs(net)
    return [
        Outline(z[start[i:j]], z[end[i:j]], weight[i:j], float(a))
        for i, j, a in zip(bounds[:-1].tolist(), bounds[1:].tolist(), area, strict=True)
    ]
