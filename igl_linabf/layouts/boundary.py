"""The boundary layout: the boundary loop is drawn from its angles, both coordinates are harmonic inside."""

from dataclasses import dataclass

import numpy as np

from .. import _core
from .._types import ComplexArray, FloatArray, IntArray
from ..angles import Constraints, Iterate, Residual, central_angles, with_identity
from ..linalg import Analysis, Solvers
from ..surface import complex_positions, flipped_faces
from .around_holes import Loops, draw_loops, relax_loops


@dataclass(frozen=True, eq=False)
class Boundary:
    """The outer loops of disks side by side, or of the only one, drawn from their angles.

    Attributes
    ----------
    vertices : (#rim,) int64
        Those of the loops, one after the other.
    z : (#rim,) complex128
        Their positions; each loop is closed.
    gaps : (#disks,) float64
        By how much each loop failed to close, relative to its length.
    """

    vertices: IntArray
    z: ComplexArray
    gaps: FloatArray


def develop_boundary(constraints: Constraints, b: Residual) -> Boundary:
    """Draw the outer loops from their exterior angles and the ratios of their successive edges.

    The exterior angles are shifted to sum to 2 pi, the logarithms of the ratios to sum to 0. The gap
    that remains is closed by the smallest change of lengths, min sum delta^2 / l. Prescribed angles
    stay: what is missing goes to the others. A loop on a circle is drawn with the ratios only.
    """
    vertices, start = constraints.topology.rims
    turning, log_ratio, asked = b.turning[vertices], b.log_ratio[vertices], constraints.sums[vertices]
    free, circle = np.isnan(asked), 0 in constraints.circles
    if not circle:
        turning = np.where(free, turning, np.pi - asked)
    z, gaps = _core.developed_loops(start, turning, log_ratio, free if free.any() else ~free)
    if circle:
        z = np.exp(1j * np.append(0.0, np.cumsum(central_angles(log_ratio))[:-1]))
    return Boundary(vertices, z, gaps)


def harmonic(
    boundary: Boundary, at: Iterate, constraints: Constraints, laplacian: Analysis | None, solvers: Solvers
) -> tuple[ComplexArray, str]:
    """Both coordinates harmonic inside the drawn boundaries, by the target angles' Laplacian.

    Holes' loops are drawn, too, from angles that are flat. Returns the map and the solver's name.

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
    # a boundary vertex with a prescribed sum has a row, too
    lower = with_identity(pattern.laplacian(weight), n)
    factored = (laplacian or pattern.analysis(solvers)).factor(lower.data)
    if topology.holes:
        loops = Loops(constraints, weight, factored.solve)
        return loops.positions(draw_loops(loops, at.residual.holonomy, boundary.z)), factored.name
    rhs = pattern.pull(weight, z)
    rhs[n:] = 0.0
    z[topology.interior] = complex_positions(factored.solve(rhs)[:n])
    return z, factored.name


def by_relaxed_loops(
    boundary: Boundary, at: Iterate, constraints: Constraints, laplacian: Analysis | None, solvers: Solvers
) -> tuple[ComplexArray, str] | None:
    """Nearly the map of the least squares, and the solver's name, by the Laplacian of `harmonic`.

    All loops are drawn, and changed to where the conformal energy is nearly least. None if that is not so, or
    if triangles are flipped.
    """
    topology, pattern = constraints.topology, constraints.pattern
    weight = topology.sum_at_edges(at.cot) / 2
    lower = pattern.laplacian(weight)
    analysis = laplacian or pattern.analysis(solvers)
    factored = analysis.factor(lower.data)
    loops = Loops(constraints, weight, factored.solve)
    made = relax_loops(loops, draw_loops(loops, at.residual.holonomy, boundary.z))
    if made is None or len(flipped_faces(z := loops.positions(made), topology.corner)):
        return None
    return z, factored.name
