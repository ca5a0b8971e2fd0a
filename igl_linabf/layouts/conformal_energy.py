"""Compute the least-squares layout: the least conformal energy from the target angles (section 5)."""

import numpy as np

from .._types import ComplexArray, FloatArray, IntArray
from ..angles import Pattern
from ..linalg import Solvers, solve_complex
from ..surface import Topology


def least_squares(
    topology: Topology, cot: FloatArray, pinned: IntArray, position: ComplexArray, solvers: Solvers
) -> tuple[ComplexArray, str]:
    """Minimise the conformal energy from triangles with the target angles (section 5 of the paper).

    E(z) = 1/4 sum cot(alpha) |z_i - z_j|^2 - area(z) = 1/2 z^H (L + i Q) z, where L is the cotangent
    Laplacian of the target angles, and Q is skew with entries on the boundary edges only. The pins, at least
    two, are eliminated, and a complex Hermitian system is factored. Returns the map and the name of the
    solver.
    """
    row = np.zeros(topology.n, dtype=np.int64)
    row[pinned] = -1
    free = row == 0
    row[free] = np.arange(np.count_nonzero(free))
    pattern = Pattern(topology, row, int(np.count_nonzero(free)))
    a, b = topology.edges.T
    i, j = pattern.edge_rows
    weight = topology.sum_at_edges(cot) / 2
    entry = -weight + 0.5j * (topology.sides[1] < 0)  # the mesh is on the left of the edge
    z = np.zeros(topology.n, dtype=np.complex128)
    z[pinned] = position
    if not free.any():
        return z, "none"
    rhs = [
        pattern.sum_at_rows(i, part(entry * z[b])) + pattern.sum_at_rows(j, part(entry.conj() * z[a]))
        for part in (np.real, np.imag)
    ]
    lower = pattern.build_hermitian_matrix(
        entry, pattern.sum_at_rows(i, weight) + pattern.sum_at_rows(j, weight)
    )
    factored = solvers.factor(lower)
    z[free] = solve_complex(factored, -rhs[0] - 1j * rhs[1])
    return z, factored.name


def find_far_points(points: FloatArray) -> IntArray:
    """Return two points that divide a closed polygon, (#P, dim), into halves of equal length.

    Among all these pairs, return the pair with the largest distance.
    """
    arc = np.concatenate(([0], np.cumsum(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1))))
    opposite = np.searchsorted(arc, (arc[:-1] + arc[-1] / 2) % arc[-1]) % len(points)
    i = int(np.argmax(np.linalg.norm(points - points[opposite], axis=1)))
    return np.array([i, opposite[i]])
