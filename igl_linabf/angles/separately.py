"""The linear step and its chord for disks side by side: one system, each disk with an end of its own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from .. import kernels
from .._runtime import timed
from .._types import BoolArray, FloatArray, IntArray, Solve
from ..linalg import Analysis, Factored, Multigrid, conjugate_gradients
from ..surface import Disks, Parts
from .constraints import Constraints
from .iterates import REACH, AngleProblem, Iterate
from .linearised import linearise
from .preconditioner import conformal_inverse
from .reduced import System

MOST_STEPS = 60  # of conjugate gradients; a disk that takes more is no longer held up for


@dataclass(frozen=True, eq=False)
class Separate:
    """Where the angles of disks side by side ended.

    Attributes
    ----------
    at : Iterate
        All of them.
    how : str
        What solved the system.
    stepped : (#disks,) bool
        Whose angles were not flat from the start.
    good : (#disks,) bool
        Whose two solves came to an end with no triangle cut short.
    thin : (#disks,) bool
        Those among others that have slivers: to be solved with each other.
    inner_steps : (2, #disks) int64
        Of the step and of the chord.
    families : (3, 3, #disks) float64
        By `families_of` at the start, after the step, and after the chord.
    """

    at: Iterate
    how: str
    stepped: BoolArray
    good: BoolArray
    thin: BoolArray
    inner_steps: IntArray
    families: FloatArray


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
    families = [families_of(at, rows, disks.faces)]
    stepped = families[0].max(axis=0) > tol
    good = ~stepped | (rows.sizes > 0)
    inner_steps, thin = np.zeros((2, len(disks)), dtype=np.int64), np.zeros(len(disks), dtype=bool)
    if (stepped & good).any():
        solver, thin = _solver(problem, rows, ~stepped)
        if isinstance(solver.laplacian, Multigrid):
            return None
        moving = disks.faces.spread(np.where(stepped, 1.0, 0.0))
        for k in range(2):  # one inner step of the first has to leave far less
            e, inner_steps[k], converged = _errors(solver, at, rows, rtol, rtol ** (2 - k))
            with timed("assembly"):
                e, cut = kernels.cut_short(at.alpha, e * moving, REACH)
                good &= ~stepped | (converged & ~disks.faces.any(cut))
                at = problem.at(at.alpha + e)
            families.append(families_of(at, rows, disks.faces))
    families += families[-1:] * (3 - len(families))
    how = "none" if solver is None else solver.how
    return Separate(at, how, stepped, good & ~thin, thin, inner_steps, np.array(families))


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


def _solver(problem: AngleProblem, rows: Parts, flat: BoolArray) -> tuple[_Solver, BoolArray]:
    """Linearise at the start; which disks are not to be solved with it, as they have slivers.

    S is needed as a matrix for slivers only, or to be factored: a few products take less time than that.
    So disks without slivers do not wait for those that have some. Disks that are `flat` take no step.
    """
    fans = _Fans(System(problem.constraints, problem.start.alpha, cot=problem.start.cot))
    sliver = np.zeros(problem.constraints.n, dtype=bool)
    sliver[fans.system.sliver_rows()] = True
    thin = rows.any(sliver) & ~flat
    none = np.zeros(len(rows), dtype=bool)
    if problem.solvers.direct or (thin | flat).all():
        lin = linearise(problem, problem.start, fall_back=False)
        solver = _Solver(fans, lin.product, lin.precondition, lin.whole, lin.laplacian, lin.how)
        return solver, none
    with timed("assembly"):
        lower = fans.system.laplacian()
    with timed("analysis"):
        laplacian = problem.constraints.pattern.analysis(problem.solvers, lower)
    with timed("factor"):
        inverse = laplacian.preconditioner(lower)
        precondition, _ = conformal_inverse(fans.system, None, inverse.solve)
    how = f"conjugate gradients, {inverse.name}"
    return _Solver(fans, fans.product, precondition, None, laplacian, how), thin


class _Fans:
    """The rows M of the constraints and the projection P of a system, without their matrices."""

    def __init__(self, system: System) -> None:
        self.system, self._n = system, system.constraints.n
        row = system.constraints.row[system.topology.corner]
        self._row = np.where(row < 0, self._n, row)  # one more row for those on the boundary
        self._pair = kernels.pair_weights(system.w, system.d)

    def errors(self, x: FloatArray) -> FloatArray:
        """P M^T x, (3, #F)."""
        vertex, wheel = (np.append(x[k::2], 0.0) for k in (0, 1))
        s = self.system
        return kernels.errors(self._row, s.w, s.d, s.cot, vertex, wheel)

    def rows(self, e: FloatArray) -> FloatArray:
        """M e, (2 #rows,)."""
        vertex, wheel = kernels.row_sums(self._row, self.system.cot, e, self._n + 1)
        return np.column_stack((vertex[:-1], wheel[:-1])).ravel()

    @cached_property
    def _root(self) -> sparse.csr_array:
        """N^T, (2 #F, 2 #rows + 2), of S = N N^T.

        P of a triangle, y^T P y = f (y1 - y2)^2 + g (y2 - y0)^2 + h (y0 - y1)^2, is the sum of two squares.
        """
        (f, g, h), (a, b, c) = self._pair, self.system.cot
        along = f * h + f * g + g * h
        share, first, second = h / (g + h), np.sqrt(g + h), np.sqrt(along / (g + h))
        ones = np.ones_like(a)
        to_first = (ones, -share, share - 1, c - share * (b + c), share * c - a - c, a + share * b)
        to_second = (0 * ones, ones, -ones, b + c, -c, -b)
        data = np.stack(
            (*(first * values for values in to_first), *(second * values for values in to_second))
        )
        columns = np.concatenate((2 * self._row, 2 * self._row + 1)).T
        shape = (2 * len(a), 2 * self._n + 2)
        indptr = np.arange(0, 12 * len(a) + 1, 6)
        return sparse.csr_array((data.T.ravel(), np.hstack((columns, columns)).ravel(), indptr), shape=shape)

    def product(self, x: FloatArray) -> FloatArray:
        """S x = M P M^T x."""
        return np.asarray(self._root.T @ (self._root @ np.append(x, np.zeros(2))))[:-2]


def rows_of(constraints: Constraints, disks: Disks) -> Parts:
    """The rows of each disk: those of its interior vertices, which come in their order."""
    before = np.concatenate(([0], np.cumsum(disks.topology.interior)))
    assert before[-1] == constraints.n
    return Parts(before[disks.vertices.start])


def families_of(at: Iterate, rows: Parts, faces: Parts) -> FloatArray:
    """The largest absolute residual of each disk: of its vertices, triangles and wheels, (3, #disks)."""
    b = at.residual
    return np.stack((rows.max(np.abs(b.vertex)), faces.max(np.abs(b.triangle)), rows.max(np.abs(b.wheel))))


def _errors(
    solver: _Solver, at: Iterate, rows: Parts, rtol: float, first_rtol: float
) -> tuple[FloatArray, IntArray, BoolArray]:
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
            x, steps, converged = conjugate_gradients(
                solver.product,
                rhs,
                solver.precondition,
                rtol,
                MOST_STEPS,
                first_rtol=first_rtol,
                start=2 * rows.start,
            )
    with timed("assembly"):
        return e0 + fans.errors(x), steps, converged
