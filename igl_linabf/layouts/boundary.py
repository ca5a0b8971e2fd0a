"""Lay out the boundary loop from its angles; in the interior, both coordinates are harmonic."""

from dataclasses import dataclass

import numpy as np

from .. import _core
from .._types import ComplexArray, FloatArray, IntArray
from ..angles import Constraints, Iterate, Residual, compute_central_angles, replace_rows_by_identity
from ..linalg import Analysis, Solvers
from ..surface import complex_positions


@dataclass(frozen=True, eq=False)
class Boundary:
    """The outer boundary loops of independent disks, laid out in the plane.

    Attributes
    ----------
    vertices : (#rim,) int64
        Vertices of the loops, one loop after the other.
    z : (#rim,) complex128
        Positions of `vertices`; each loop is closed.
    gaps : (#disks,) float64
        Distance between the ends of each loop before it was closed, relative to the loop's length.
    """

    vertices: IntArray
    z: ComplexArray
    gaps: FloatArray


def develop_boundary(constraints: Constraints, b: Residual) -> Boundary:
    """Lay out the outer loops from their exterior angles and the length ratios of successive edges.

    The exterior angles are shifted to sum to 2 pi, and the logarithms of the ratios to sum to 0. The
    remaining closure error is removed by the smallest changes delta of the lengths l, which minimise sum
    delta^2 / l. Only free angles are shifted; prescribed angles do not change. A loop on a circle is laid out
    from the ratios only.
    """
    vertices, start = constraints.topology.outer_boundaries
    turning, log_ratio, asked = b.turning[vertices], b.log_ratio[vertices], constraints.sums[vertices]
    free, circle = np.isnan(asked), 0 in constraints.circles
    if not circle:
        turning = np.where(free, turning, np.pi - asked)
    z, gaps = _core.develop_loops(start, turning, log_ratio, free if free.any() else ~free)
    if circle:
        z = np.exp(1j * np.append(0.0, np.cumsum(compute_central_angles(log_ratio))[:-1]))
    return Boundary(vertices, z, gaps)


def compute_harmonic_map(
    boundary: Boundary, at: Iterate, constraints: Constraints, laplacian: Analysis | None, solvers: Solvers
) -> tuple[ComplexArray, str]:
    """Compute a map with harmonic coordinates, given the positions of the boundary loops.

    The Laplacian belongs to the target angles. Returns the map and the name of the solver.

    Raises
    ------
    NotPositiveDefiniteError
        The Laplacian is singular in double precision.
    """
    topology, pattern, n = constraints.topology, constraints.pattern, constraints.wheels
    z = np.zeros(topology.n, dtype=np.complex128)
    z[boundary.vertices] = boundary.z
    if not n:
        return z, "none"
    weight = topology.sum_at_edges(at.cot)
    weight /= 2
    # boundary vertices with prescribed sums have rows, too: replace these rows by the identity
    lower = replace_rows_by_identity(pattern.build_laplacian(weight), n)
    factored = (laplacian or pattern.get_analysis(solvers)).factor(lower.data)
    rhs = pattern.sum_fixed_vertex_terms(weight, z)
    rhs[n:] = 0.0
    z[topology.is_interior] = complex_positions(factored.solve(rhs)[:n])
    return z, factored.name
