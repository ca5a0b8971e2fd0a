"""The constraints on the angles of a flat mesh (eq. 5, 6, 10), and their residuals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .._types import FloatArray, IntArray
from ..kernels import angle_sums
from ..linalg import Pattern
from ..surface import Topology
from .loops import Closure, closure_of


@dataclass(frozen=True, eq=False)
class Constraints:
    """The vertex and wheel constraints of a surface (eq. 5 and 10); a row has one of each.

    Attributes
    ----------
    topology : Topology
    row : (#V,) int64
        The virtual-vertex map: the row of each vertex's constraints. An interior vertex has its own
        row. All vertices of a hole share one row. Vertices of the outer loop have -1.
    target : (#rows,) float64
        Target angle sum of each row: 2 pi at an interior vertex, (m + 2) pi around a hole of m
        vertices.
    """

    topology: Topology
    row: IntArray
    target: FloatArray

    @property
    def n(self) -> int:
        """Number of rows."""
        return len(self.target)

    @cached_property
    def pattern(self) -> Pattern:
        """The graph of the rows."""
        return Pattern(self.topology, self.row, self.n)

    def sum_at_rows(self, values: FloatArray) -> FloatArray:
        """Sum (#V,) values over the vertices of each row."""
        return np.asarray(np.bincount(self.row + 1, weights=values, minlength=self.n + 1)[1:])


def constraints_of(topology: Topology) -> Constraints:
    """A row for each interior vertex, and one for each hole as a virtual vertex.

    Around a hole of m vertices the angles sum to (m + 2) pi; m = 0 is an interior vertex.
    """
    holes = topology.holes
    row = np.where(topology.interior, np.cumsum(topology.interior) - 1, -1)
    n_interior = int(np.count_nonzero(topology.interior))
    for i, loop in enumerate(holes):
        row[loop] = n_interior + i
    target = np.full(n_interior + len(holes), 2 * np.pi)
    target[n_interior:] += [np.pi * len(loop) for loop in holes]
    return Constraints(topology, row, target)


@dataclass(frozen=True, eq=False)
class Residual:
    """Residuals of the constraints: the right-hand sides b of eq. 5, 6 and 10.

    Attributes
    ----------
    vertex, wheel : (#rows,) float64
        target - sum alpha, and sum log sin(gamma) - log sin(beta).
    triangle : (#F,) float64
        pi - sum alpha.
    turning, log_ratio : (#V,) float64
        At a vertex of a boundary loop, the mesh on the left: the exterior angle, and the
        logarithm of the next edge's length over the last one's.
    closure : Closure
        The holes' loops drawn from these.
    """

    vertex: FloatArray
    wheel: FloatArray
    triangle: FloatArray
    turning: FloatArray
    log_ratio: FloatArray
    closure: Closure

    @property
    def largest(self) -> float:
        """Largest absolute value: radians, logarithms, relative gaps of holes."""
        families = (self.vertex, self.wheel, self.triangle, self.closure.gap)
        return float(max(np.abs(r).max(initial=0.0) for r in families))


def residual(constraints: Constraints, alpha: FloatArray) -> Residual:
    """Residuals of the angle constraints at `alpha`, (3, #F) radians."""
    topology = constraints.topology
    # an angle of 0 or pi, as in a collapsed triangle, counts as the smallest there is
    log_sin = np.sin(alpha)
    np.abs(log_sin, out=log_sin)
    np.maximum(log_sin, np.finfo(np.float64).tiny, out=log_sin)
    np.log(log_sin, out=log_sin)  # eq. 7: the wheel constraint in logarithms
    total, log_ratio = angle_sums(topology.corner, alpha, log_sin, topology.n)
    turning = np.pi - total
    return Residual(
        vertex=constraints.target - constraints.sum_at_rows(total),  # eq. 5
        wheel=constraints.sum_at_rows(log_ratio),  # eq. 8-10
        triangle=np.pi - alpha.sum(axis=0),  # eq. 6
        turning=turning,
        log_ratio=log_ratio,
        closure=closure_of(topology, turning, log_ratio),
    )
