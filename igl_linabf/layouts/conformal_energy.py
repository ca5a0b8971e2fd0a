"""The least-squares layout: the conformal energy of triangles with the target angles (section 5)."""

import numpy as np

from .._types import ComplexArray, FloatArray, IntArray
from ..angles import Pattern
from ..linalg import Solvers, solve_complex
from ..surface import Topology


def least_squares(
    topology: Topology, cot: FloatArray, pinned: IntArray, position: ComplexArray, solvers: Solvers
) -> tuple[ComplexArray, str]:
    """Minimise the conformal energy from triangles with the target angles (the paper's section 5).

    E(z) = 1/4 sum cot(alpha) |z_i - z_j|^2 - area(z) = 1/2 z^H (L + i Q) z, L the cotangent
    Laplacian of the target angles and Q skew, on the boundary edges only; the pins, at least two,
    are eliminated and one complex Hermitian system is factored. Returns the map and the solver's name.
    """
    row = np.zeros(topology.n, dtype=np.int64)
    row[pinned] = -1
    free = row == 0
    row[free] = np.arange(np.count_nonzero(free))
    pattern = Pattern(topology, row, len(row) - len(pinned))
    a, b = topology.edges.T
    i, j = pattern.ends
    weight = topology.sum_at_edges(cot) / 2
    entry = -weight + 0.5j * (topology.sides[1] < 0)  # the mesh is on the left of the edge
    z = np.zeros(topology.n, dtype=np.complex128)
    z[pinned] = position
    if not free.any():
        return z, "none"
    rhs = [
        pattern.row_sums(i, part(entry * z[b])) + pattern.row_sums(j, part(entry.conj() * z[a]))
        for part in (np.real, np.imag)
    ]
    lower = pattern.hermitian(entry, pattern.row_sums(i, weight) + pattern.row_sums(j, weight))
    factored = solvers.factor(lower)
    z[free] = solve_complex(factored, -rhs[0] - 1j * rhs[1])
    return z, factored.name


def far_apart(points: FloatArray) -> IntArray:
    """Two points of a closed polygon (#P, dim) half its length apart; of such pairs the most distant."""
    arc = np.concatenate(([0], np.cumsum(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1))))
    opposite = np.searchsorted(arc, (arc[:-1] + arc[-1] / 2) % arc[-1]) % len(points)
    i = int(np.argmax(np.linalg.norm(points - points[opposite], axis=1)))
    return np.array([i, opposite[i]])
