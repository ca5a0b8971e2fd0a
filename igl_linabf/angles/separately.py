"""The linear step and its chord for disks side by side: one system, each disk with an end of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .. import kernels
from .._runtime import timed
from .._types import BoolArray, FloatArray, IntArray
from ..linalg import Analysis, Factored, Multigrid, block_conjugate_gradients
from ..surface import Disks, Parts
from .constraints import Constraints
from .linearised import AngleProblem, Iterate, cut_short, linearise
from .preconditioner import Solve, conformal_inverse
from .reduced import System

MOST_STEPS = 60  # of conjugate gradients; a disk that takes more is no longer held up for


@dataclass(frozen=True, eq=False)
class Separate:
    """Where the angles of disks side by side ended.

    Attributes
    ----------
    at : Iterate
        All of them.
    laplacian : Analysis or None
        Of the Laplacians over the rows; None where all were flat from the start.
    how : str
        What solved the system.
    stepped : (#disks,) bool
        Whose angles were not flat from the start.
    good : (#disks,) bool
        Whose two solves came to an end with no triangle cut short.
    inner_steps : (2, #disks) int64
        Of the step and of the chord.
    residual : (3, #disks) float64
        The largest of each disk at the start, after the step, and after the chord.
    """

    at: Iterate
    laplacian: Analysis | None
    how: str
    stepped: BoolArray
    good: BoolArray
    inner_steps: IntArray
    residual: FloatArray


def step_and_chord(problem: AngleProblem, disks: Disks, rtol: float, tol: float) -> Separate | None:
    """The linear step and its chord for each disk whose residual is above `tol`.

    None where the preconditioner is no exact inverse, and one disk's iterates depend on the others.

    Raises
    ------
    NotPositiveDefiniteError, SingularSystemError
        The system of one of the disks is singular in double precision.
    """
    rows = rows_of(problem.constraints, disks)
    at, solver = problem.start, None
    residual = [largest_of(at, rows, disks.faces)]
    stepped = residual[0] > tol
    good = ~stepped | (rows.sizes > 0)
    inner_steps = np.zeros((2, len(disks)), dtype=np.int64)
    if (stepped & good).any():
        solver = _solver(problem)
        if isinstance(solver.laplacian, Multigrid):
            return None
        moving = disks.faces.spread(np.where(stepped, 1.0, 0.0))
        for k in range(2):
            e, inner_steps[k], converged = _errors(solver, at, rows, rtol)
            with timed("assembly"):
                e, cut = cut_short(at.alpha, e * moving)
                good &= ~stepped | (converged & ~disks.faces.any(cut))
                at = problem.at(at.alpha + e)
            residual.append(largest_of(at, rows, disks.faces))
    residual += residual[-1:] * (3 - len(residual))
    laplacian, how = (None, "none") if solver is None else (solver.laplacian, solver.how)
    return Separate(at, laplacian, how, stepped, good, inner_steps, np.array(residual))


@dataclass(frozen=True, eq=False)
class _Solver:
    """The system of all disks, and what solves it.

    Attributes
    ----------
    fans : _Fans
    product : callable
        S times x.
    precondition : callable or None
    whole : Factored or None
        Of S, where that was asked for.
    laplacian : Analysis or None
    how : str
    """

    fans: _Fans
    product: Solve
    precondition: Solve | None
    whole: Factored | None
    laplacian: Analysis | None
    how: str


def _solver(problem: AngleProblem) -> _Solver:
    """Linearise at the start.

    S is needed as a matrix for slivers only, or to be factored: a few products take less time than that.
    """
    fans = _Fans(System(problem.constraints, problem.start.alpha, cot=problem.start.cot))
    if problem.solvers.direct or len(fans.system.sliver_rows()):
        lin = linearise(problem, problem.start, fall_back=False)
        return _Solver(fans, lin.product, lin.precondition, lin.whole, lin.laplacian, lin.how)
    with timed("assembly"):
        lower = fans.system.laplacian()
    with timed("analysis"):
        laplacian = problem.solvers.laplacian(lower)
    with timed("factor"):
        precondition = conformal_inverse(fans.system, None, laplacian.preconditioner(lower))
    how = f"conjugate gradients, {laplacian.name}"
    return _Solver(fans, fans.product, precondition, None, laplacian, how)


class _Fans:
    """The rows M of the constraints and the projection P of a system, without their matrices."""

    def __init__(self, system: System) -> None:
        self.system, self._n = system, system.constraints.n
        row = system.constraints.row[system.topology.corner]
        self._row = np.where(row < 0, self._n, row)  # one more row for those on the boundary

    def errors(self, x: FloatArray) -> FloatArray:
        """P M^T x, (3, #F)."""
        vertex, wheel = (np.append(x[k::2], 0.0) for k in (0, 1))
        s = self.system
        return kernels.errors(self._row, s.w, s.d, s.cot, vertex, wheel)

    def rows(self, e: FloatArray) -> FloatArray:
        """M e, (2 #rows,)."""
        vertex, wheel = kernels.row_sums(self._row, self.system.cot, e, self._n + 1)
        return np.column_stack((vertex[:-1], wheel[:-1])).ravel()

    def product(self, x: FloatArray) -> FloatArray:
        """S x = M P M^T x."""
        s = self.system
        return kernels.fan_product(self._row, s.w, s.d, s.cot, x)


def rows_of(constraints: Constraints, disks: Disks) -> Parts:
    """The rows of each disk: those of its interior vertices, which come in their order."""
    before = np.concatenate(([0], np.cumsum(disks.topology.interior)))
    assert before[-1] == constraints.n
    return Parts(before[disks.vertices.start])


def families_of(at: Iterate, rows: Parts, faces: Parts) -> FloatArray:
    """The largest absolute residual of each disk: of its vertices, triangles and wheels, (3, #disks)."""
    b = at.residual
    return np.stack((rows.max(np.abs(b.vertex)), faces.max(np.abs(b.triangle)), rows.max(np.abs(b.wheel))))


def largest_of(at: Iterate, rows: Parts, faces: Parts) -> FloatArray:
    """The largest absolute residual of each disk."""
    return np.asarray(families_of(at, rows, faces).max(axis=0))


def _errors(solver: _Solver, at: Iterate, rows: Parts, rtol: float) -> tuple[FloatArray, IntArray, BoolArray]:
    """The errors that the linearised constraints ask for, the inner steps, and who converged."""
    b, fans = at.residual, solver.fans
    with timed("assembly"):
        e0 = fans.system.w * (b.triangle / fans.system.d)
        rhs = np.column_stack((b.vertex, b.wheel)).ravel() - fans.rows(e0)
    with timed("solve"):
        if solver.whole is not None:
            x = solver.whole.solve(rhs)
            steps, converged = np.zeros(len(rows), dtype=np.int64), rows.min(np.isfinite(x[::2]))
        else:
            assert solver.precondition is not None
            x, steps, converged = block_conjugate_gradients(
                solver.product, rhs, solver.precondition, Parts(2 * rows.start), rtol, MOST_STEPS
            )
    with timed("assembly"):
        return e0 + fans.errors(x), steps, converged
