"""The boundary layout: the boundary loop is drawn from its angles, both coordinates are harmonic inside."""

from dataclasses import dataclass

import numpy as np

from .._types import ComplexArray, FloatArray
from ..angles import Constraints, Iterate, Residual, central_angles, held
from ..linalg import Analysis, Solvers
from ..surface import Disks, complex_positions, flipped_faces
from .around_holes import Loops, drawn, relaxed


@dataclass(frozen=True, eq=False)
class Boundary:
    """The outer loop drawn from its angles.

    Attributes
    ----------
    z : (#loop,) complex128
        Positions of the vertices of `topology.loops[0]`, closed.
    gap : float
        By how much the loop failed to close, relative to its length.
    """

    z: ComplexArray
    gap: float


def develop_boundary(constraints: Constraints, b: Residual) -> Boundary:
    """Draw the outer loop from its exterior angles and the ratios of its successive edges.

    The exterior angles are shifted to sum to 2 pi, the logarithms of the ratios to sum to 0. The gap
    that remains is closed by the smallest change of lengths, min sum delta^2 / l. Prescribed angles
    stay: what is missing goes to the others. A loop on a circle is drawn with the ratios only.
    """
    loop = constraints.topology.loops[0]
    turning, log_ratio, asked = b.turning[loop], b.log_ratio[loop], constraints.sums[loop]
    free = np.isnan(asked)
    circle = 0 in constraints.circles
    if not circle:
        turning = np.where(free, turning, np.pi - asked)
    movable = free if free.any() else ~free
    turning = turning + np.where(movable, (2 * np.pi - turning.sum()) / np.count_nonzero(movable), 0.0)
    log_length = np.cumsum(log_ratio - log_ratio.mean())
    length = np.exp(log_length - log_length.max())
    edge = np.exp(1j * np.cumsum(turning))  # edge i leaves loop vertex i
    gap = (length * edge).sum()
    relative = float(abs(gap) / length.sum())
    if circle:
        at = np.concatenate(([0.0], np.cumsum(central_angles(log_ratio))[:-1]))
        return Boundary(np.exp(1j * at), relative)
    # delta = l Re(conj(edge) mu) closes it: a 2 by 2 system for mu
    u = np.stack((edge.real, edge.imag))
    mu = np.linalg.solve((u * length) @ u.T, -np.array([gap.real, gap.imag]))
    ends = np.cumsum(length * (1 + mu @ u) * edge)
    return Boundary(np.concatenate(([0], ends[:-1])), relative)


def develop_boundaries(disks: Disks, b: Residual) -> tuple[ComplexArray, FloatArray]:
    """`develop_boundary` of disks side by side: z at the vertices of `Disks.rim`, and the gaps."""
    vertices, loops = disks.rim
    turning, log_ratio = b.turning[vertices], b.log_ratio[vertices]
    turning = turning + loops.spread((2 * np.pi - loops.sum(turning)) / loops.sizes)
    log_length = loops.cumsum(log_ratio - loops.spread(loops.sum(log_ratio) / loops.sizes))
    length = np.exp(log_length - loops.spread(loops.max(log_length)))
    edge = np.exp(1j * loops.cumsum(turning))  # edge i leaves loop vertex i
    gap = loops.sum(length * edge)
    u = edge.real, edge.imag
    xx, xy, yy = (loops.sum(length * (p * q)) for p, q in ((u[0], u[0]), (u[0], u[1]), (u[1], u[1])))
    with np.errstate(divide="ignore", invalid="ignore"):  # where all edges are parallel
        det = xx * yy - xy * xy
        mu = (xy * gap.imag - yy * gap.real) / det, (xy * gap.real - xx * gap.imag) / det
    step = length * (1 + loops.spread(mu[0]) * u[0] + loops.spread(mu[1]) * u[1]) * edge
    # each loop begins at 0: its last step is not taken
    step[loops.start[1:] - 1] = 0.0
    ends = np.concatenate(([0.0], step[:-1]))
    return np.asarray(loops.cumsum(ends)), np.asarray(np.abs(gap) / loops.sum(length))


def harmonic(
    boundary: Boundary, at: Iterate, constraints: Constraints, laplacian: Analysis | None, solvers: Solvers
) -> tuple[ComplexArray, str]:
    """Both coordinates harmonic inside the drawn boundary, by the target angles' Laplacian.

    Holes' loops are drawn, too, from angles that are flat. Returns the map and the solver's name.
    """
    topology, pattern, n = constraints.topology, constraints.pattern, constraints.wheels
    z = np.zeros(topology.n, dtype=np.complex128)
    z[topology.loops[0]] = boundary.z
    if not n:
        return z, "none"
    weight = topology.sum_at_edges(at.cot)
    weight /= 2
    lower = held(pattern.laplacian(weight), n)  # a boundary vertex with a prescribed sum has a row, too
    analysis = laplacian or pattern.analysis(solvers)

    factored = analysis.factor(lower.data)
    if topology.holes:
        loops = Loops(constraints, weight, factored.solve)
        return loops.positions(drawn(loops, at.residual.closure, boundary.z)), factored.name
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
    made = relaxed(loops, drawn(loops, at.residual.closure, boundary.z))
    if made is None or len(flipped_faces(z := loops.positions(made), topology.corner)):
        return None
    return z, factored.name
