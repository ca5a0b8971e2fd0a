"""One step of linear ABF: linearise the constraints, solve for the angle errors, add them.

    lin = linearise(problem, at)                                   # the system at the angles, factored
    direction = solve(lin, at, rtol)                               # the errors e
    at, step, limited = apply_direction(problem, at, direction, "step")    # the angles after the step

All of these objects are immutable. A chord, or simplified Newton step, is another solve with the same
`lin`.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from ... import _core
from ..._runtime import advance as report_progress
from ..._runtime import time_stage
from ..._types import BoolArray, FloatArray, IntArray, Solve
from ...errors import FallbackWarning, SingularSystemError, first_few, stack_level
from ...linalg import MAX_CG_STEPS, Analysis, Factor, NotPositiveDefiniteError, conjugate_gradients
from ..system import (
    HolonomyConstraints,
    SchurColumns,
    Slivers,
    Symmetric,
    System,
    factor_laplacians,
    make_sliver_preconditioner,
    solve_pairs,
)
from .iterates import AngleProblem, Iterate, Kind, Step

Closed = Literal["all", "paths", "none"]

MAX_SHARE_TO_ZERO = 0.7  # maximum step length, relative to the step that makes an angle zero

EMPTY_MATRIX = Symmetric((np.zeros(1, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty((0, 4))))


@dataclass(frozen=True, eq=False)
class Linearisation:
    """The constraints linearised at given angles, with a solver of the linear system.

    Attributes
    ----------
    problem : AngleProblem
    system : System
    S : Symmetric
        The reduced matrix.
    holonomy : HolonomyConstraints or None
        Constraints that close the loops of holes and the closed paths.
    laplacian : Analysis or None
        Analysis of the Laplacians over the pattern of the problem; the layout uses it, too.
    inverse : Factor or None
        The preconditioner diag(L_s+, L_s)^-1 of `factor_laplacians`.
    columns : SchurColumns or None
        Schur columns of the holonomy constraints, computed with `inverse`.
    slivers : Slivers or None
        Slivers with a correction of the preconditioner.
    precondition : callable or None
        The complete preconditioner: `inverse` with the border and the correction at slivers.
    whole : Factor or None
        The factor of S, if S was factored.
    how : str
        Name of the solver.
    fallback : str
        Why S was factored as a fallback, in this or an earlier system; "" without a fallback.
    """

    problem: AngleProblem
    system: System
    S: Symmetric
    holonomy: HolonomyConstraints | None
    laplacian: Analysis | None = None
    inverse: Factor | None = None
    columns: SchurColumns | None = None
    slivers: Slivers | None = None
    precondition: Solve | None = None
    whole: Factor | None = None
    solver_name: str = "none"
    fallback: str = ""

    @classmethod
    def from_factor(
        cls,
        problem: AngleProblem,
        system: System,
        laplacian: Analysis,
        inverse: Factor,
        columns: SchurColumns | None = None,
    ) -> Linearisation:
        """Return a linearisation without matrix, whose factor and columns precondition the first step."""
        return cls(problem, system, EMPTY_MATRIX, None, laplacian=laplacian, inverse=inverse, columns=columns)

    @property
    def without_matrix(self) -> Linearisation:
        """The linearisation without its matrix, but with a factor that can precondition the next system."""
        return replace(self, S=EMPTY_MATRIX, precondition=None, whole=None)

    def multiply(self, x: FloatArray) -> FloatArray:
        """Multiply the matrix of the linear system by x."""
        return self.S.matvec(x) if self.holonomy is None else self.holonomy.matvec(self.S.matvec, x)

    def multipliers_at_corners(self, x: FloatArray) -> FloatArray:
        """Return the multipliers of the vertex and wheel constraints of each corner's fan, (2, 3, #F)."""
        topology, n = self.problem.constraints.topology, 2 * self.problem.constraints.n_rows
        at_vertices = self.system.multipliers_at_vertices(x[:n].reshape(-1, 2))
        of_sites = (
            np.zeros((topology.n, 2))
            if self.holonomy is None
            else self.holonomy.rows.multipliers_at_sites(x[n:])
        )
        # `np.take` is much faster than indexing
        at_corners = (at_vertices + of_sites[: topology.n]).T.take(topology.corner, axis=1)
        if self.holonomy is not None:
            flat, of_paths = at_corners.reshape(2, -1), of_sites[topology.n :]
            for path, extra in zip(self.problem.constraints.paths, of_paths, strict=True):
                flat[:, path.corner] += extra[:, None]
        return at_corners


@dataclass(frozen=True, eq=False)
class Direction:
    """The errors that satisfy the linearised constraints.

    Attributes
    ----------
    e : (3, #F) float64
    x : (2 #rows + #holonomy constraints,) float64
        The multipliers.
    lin : Linearisation
        The system for the next solve, including any fallback of its solver.
    each : (#disks,) int64
        Inner steps of each disk of the problem.
    converged : (#disks,) bool
        Whether conjugate gradients converged for the disk.
    """

    e: FloatArray
    x: FloatArray
    lin: Linearisation
    each: IntArray
    converged: BoolArray

    @property
    def max_inner_steps(self) -> int:
        """Maximum number of conjugate gradient steps over all disks."""
        return int(self.each.max(initial=0))


def linearise(
    problem: AngleProblem,
    at: Iterate,
    weights: FloatArray | None = None,
    reuse: Linearisation | None = None,
    *,
    close: Closed = "all",
    same_factor: bool = False,
    same_slivers: bool = True,
) -> Linearisation:
    """Linearise the constraints at some angles, and prepare to solve for errors weighted by `weights`.

    Parameters
    ----------
    problem : AngleProblem
    at : Iterate
    weights : (3, #F) float64, optional
        The weights w in sum e^2 / w; alpha^2 by default (eq. 11).
    reuse : Linearisation, optional
        An earlier system whose symbolic analyses are reused.
    close : {"all", "paths", "none"}
        The holonomy constraints to include: loops of holes and closed paths, paths only, or none.
    same_factor : bool
        Use the factor of `reuse` as the preconditioner.
    same_slivers : bool
        Correct the preconditioner at the slivers of `reuse`.

    Raises
    ------
    SingularSystemError
    NotPositiveDefiniteError
        The preconditioner of one of several disks is singular. For a single disk, the whole system is
        factored instead.
    """
    with time_stage("assembly"):
        system = System(problem.constraints, at.alpha, weights, at.cot)
        S = system.build_matrix() if problem.constraints.n_rows else EMPTY_MATRIX
        open_by, paths = at.residual.holonomy, problem.constraints.paths
        if close != "all" and len(open_by.constrained):
            open_by = open_by.restrict_to_paths(len(paths) if close == "paths" else 0)
        holonomy = HolonomyConstraints(system, open_by) if open_by.constrained.any() else None
    lin = Linearisation(problem, system, S, holonomy)
    if not problem.constraints.n_rows and not paths:
        return lin  # no constraints: the estimate is flat
    if reuse is not None:
        slivers = reuse.slivers if same_slivers else None
        lin = replace(
            lin,
            laplacian=reuse.laplacian,
            inverse=reuse.inverse if same_factor else None,
            columns=reuse.columns,
            slivers=slivers,
            fallback=reuse.fallback,
        )
    if problem.solvers.solver == "direct":
        return _add_factor(lin, at)
    try:
        return _add_preconditioner(lin)
    except NotPositiveDefiniteError:
        if len(problem.disks.faces) > 1:
            raise
        return _fall_back_to_factor(lin, at, "the preconditioner is singular in double precision")


def _add_preconditioner(lin: Linearisation) -> Linearisation:
    """Add the preconditioner: diag(L_s, L_s)^-1 with the holonomy border, corrected at slivers."""
    solvers, laplacian, inverse = lin.problem.solvers, lin.laplacian, lin.inverse
    if inverse is None:
        with time_stage("assembly"):
            lower = lin.system.build_laplacian()
        with time_stage("analysis"):
            laplacian = laplacian or lin.system.pattern.get_analysis(solvers)
        with time_stage("factor"):
            inverse = factor_laplacians(lin.system, laplacian, lower)
    with time_stage("factor"):
        columns = lin.columns
        precondition: Solve = partial(solve_pairs, inverse.solve)
        if lin.holonomy is not None:
            precondition, columns = lin.holonomy.make_preconditioner(
                lin.system, inverse.solve, lin.S, columns
            )
        slivers = lin.slivers or Slivers.find(lin.system, lin.S, solvers)
        precondition = make_sliver_preconditioner(precondition, slivers, lin.S, lin.holonomy)
    return replace(
        lin,
        laplacian=laplacian,
        inverse=inverse,
        columns=columns,
        slivers=slivers,
        precondition=precondition,
        solver_name=f"conjugate gradients, {inverse.name}",
    )


def _add_factor(lin: Linearisation, at: Iterate) -> Linearisation:
    """Factor the reduced matrix S, and add the factor to a linearisation."""
    with time_stage("analysis"):
        analysis = lin.system.pattern.get_analysis(lin.problem.solvers, 2)
    try:
        with time_stage("factor"):
            whole = analysis.factor(lin.S.blocks_for_factorisation())
    except NotPositiveDefiniteError as error:
        raise _make_singular_system_error(
            lin.problem, at, lin.problem.constraints.row == error.row // 2
        ) from None
    return replace(lin, whole=whole, solver_name=f"direct, {whole.name}")


def _fall_back_to_factor(lin: Linearisation, at: Iterate, reason: str) -> Linearisation:
    """Factor the whole system because the preconditioned solver failed, and warn once."""
    if not lin.fallback:
        warnings.warn(
            f"{reason}: the whole system is factored instead", FallbackWarning, stacklevel=stack_level()
        )
    lin = _add_factor(replace(lin, fallback=reason), at)
    return replace(lin, solver_name=f"{lin.solver_name}, after {reason}")


def _make_singular_system_error(
    problem: AngleProblem, at: Iterate, vertices: BoolArray
) -> SingularSystemError:
    """Return the error for a system that is singular at some vertices in double precision."""
    faces = np.flatnonzero(vertices[problem.constraints.topology.corner].any(axis=0))
    thin = faces[np.argsort(at.alpha[:, faces].min(axis=0), kind="stable")]
    return SingularSystemError(
        f"the angle system is singular in double precision at faces {first_few(thin)} (the thinnest has an "
        f"angle of {at.alpha[:, thin[0]].min():.1e} rad): remove degenerate faces, or cut the mesh"
    )


def solve_for_errors(
    lin: Linearisation,
    at: Iterate,
    rtol: float,
    gradient: FloatArray | None = None,
    start: FloatArray | None = None,
    first_rtol: float | None = None,
) -> Direction:
    """Solve for the errors e that satisfy the linearised constraints at the angles `at`.

    The errors minimise sum e^2 / (2 w) + gradient e subject to A e = b. The reduced form of this problem (eq.
    11-16) is S x = r - M e0, e = e0 + P M^T x.

    Parameters
    ----------
    lin : Linearisation
    at : Iterate
    rtol : float
        Relative residual of conjugate gradients.
    gradient : (3, #F) float64, optional
    start : float64 array, optional
        Initial multipliers; `rtol` is then relative to their residual.
    first_rtol : float, optional
        Maximum relative residual for conjugate gradients to end after a single step.
    """
    if lin.precondition is None and lin.whole is None:
        return make_exact_direction(np.zeros_like(at.alpha), np.empty(0), lin)
    with time_stage("assembly"):
        b, system = at.residual, lin.system
        e0 = _solve_triangle_constraints(system, at, gradient)
        rows = system.compute_constraint_changes(e0)
        for own, sums in zip(rows.T, (b.vertex, b.wheel), strict=True):
            np.subtract(sums, own, out=own)
        rhs = rows.ravel()
        if lin.holonomy is not None:
            rhs = np.concatenate(
                (
                    rhs,
                    -lin.holonomy.rows.compute_residuals(b.holonomy, b.vertex)
                    - lin.holonomy.rows.multiply(e0),
                )
            )
        if start is not None:
            start = np.append(start, np.zeros(len(rhs) - len(start)))  # zeros for new holonomy constraints
            rhs -= lin.multiply(start)
        del e0  # free the memory for conjugate gradients
    with time_stage("solve"):
        made = _solve_for_multipliers(lin, at, rhs, rtol, first_rtol)
    with time_stage("assembly"):
        x = made.x if start is None else start + made.x
        e = compute_angle_errors(made.lin, x)
        e += _solve_triangle_constraints(system, at, gradient)
    return replace(made, e=e, x=x)


def _solve_triangle_constraints(system: System, at: Iterate, gradient: FloatArray | None) -> FloatArray:
    """Return the errors e0 that satisfy the triangle constraints alone, (3, #F)."""
    e0: FloatArray = system.w * (at.residual.triangle / system.d)
    if gradient is not None:
        e0 -= system.project(gradient)
    return e0


def compute_angle_errors(lin: Linearisation, x: FloatArray, *, conformal: bool = False) -> FloatArray:
    """Return the angle errors P M^T x for the multipliers x, or K M^T x in the `conformal` metric."""
    system = lin.system
    n = 2 * system.constraints.n_rows
    own = system.multipliers_at_vertices(x[:n].reshape(-1, 2))
    e = system.compute_conformal_errors(own) if conformal else system.compute_angle_errors(own)
    if lin.holonomy is not None:
        faces, more = lin.holonomy.compute_angle_errors(x[n:])
        e[:, faces] += more
    return e


def make_exact_direction(e: FloatArray, x: FloatArray, lin: Linearisation) -> Direction:
    """Return the direction found by a direct solve with the factored system."""
    disks = len(lin.problem.disks.faces)
    return Direction(e, x, lin, np.zeros(disks, dtype=np.int64), np.ones(disks, dtype=bool))


def _solve_for_multipliers(
    lin: Linearisation, at: Iterate, rhs: FloatArray, rtol: float, first_rtol: float | None
) -> Direction:
    """Solve the linearised system for the multipliers; return a direction whose errors are not set."""
    none, rows = np.empty((3, 0)), lin.problem.disks.rows
    if lin.whole is None:
        assert lin.precondition is not None
        x, each, converged = conjugate_gradients(
            lin.multiply,
            rhs,
            lin.precondition,
            rtol,
            first_rtol=first_rtol,
            start=2 * rows.start if len(rows) > 1 else None,
        )
        finite = np.isfinite(x).all()
        if len(rows) > 1 or (finite and converged.all()):
            return Direction(none, x, lin, each, converged)
        lin = _fall_back_to_factor(
            lin, at, f"conjugate gradients did not converge within {MAX_CG_STEPS} steps"
        )
        assert lin.whole is not None
    by_factor = lin.whole.solve
    if lin.holonomy is not None:
        try:
            by_factor = lin.holonomy.make_solver(lin.whole.solve)
        except NotPositiveDefiniteError:
            raise _make_singular_system_error(lin.problem, at, lin.holonomy.rows.vertex_mask) from None
    return make_exact_direction(none, by_factor(rhs), lin)


def apply_direction(
    problem: AngleProblem, at: Iterate, direction: Direction, kind: Kind
) -> tuple[Iterate, Step, BoolArray]:
    """Add the errors to the angles, limited in each triangle so that its angles stay positive.

    Return the iterate, the step, and a mask of the limited triangles, (#F,).
    """
    e, limited = direction.e, np.zeros(at.alpha.shape[1], dtype=bool)
    with time_stage("assembly"):
        if problem.safeguard:
            e, limited = _core.limit_step(at.alpha, e, MAX_SHARE_TO_ZERO)
        at = problem.evaluate(np.add(at.alpha, e, out=e if problem.safeguard else None))
    report_progress(kind, 0.2)
    step = Step(kind, direction.max_inner_steps, int(np.count_nonzero(limited)), at.residual.max_magnitude)
    return at, step, limited
