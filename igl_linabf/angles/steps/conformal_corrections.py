"""Take steps of linear ABF, followed by corrections in the conformal metric, which take one solve each."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from ..._runtime import time_stage
from ..._types import FloatArray, Solve
from ...linalg import NotPositiveDefiniteError
from ..system import LARGE_SYSTEM, HolonomyConstraints, System, factor_laplacians, solve_pairs
from .constants import CORRECTABLE, CORRECTABLE_PRESCRIBED, ROUGH_RTOL
from .iterations import State
from .linearisation import (
    Linearisation,
    compute_angle_errors,
    linearise,
    make_exact_direction,
    solve_for_errors,
)

GROWING_STEPS = 4  # number of consecutive steps with growing residuals that count as divergence
MAX_CORRECTIONS = 12  # maximum number of consecutive corrections before the next step
INEFFECTIVE_CORRECTION = 0.5  # reject a correction that leaves at least this share of the residual
SLOW_CORRECTION = 0.2  # compute a new factor if a correction leaves more than this share of the residual


def iterate_with_corrections(
    state: State, rtol: float | None, tol: float, most: int, largest: float = ROUGH_RTOL
) -> State:
    """Take active-set steps, followed by conformal corrections, until the residual is at most `tol`.

    After a step, the residual is about the square of the previous residual. Therefore, each system is solved
    to a relative residual about as small as the current residual, and at most `largest`. Small residuals are
    corrected in the conformal metric, unless `rtol`, the relative residual of all steps, is given. Residuals
    along closed paths spread over all triangles, and conjugate gradients reduce such smooth residuals slowly.
    Therefore, corrections close the paths, and steps close the paths only if corrections fail.
    """
    paths, turned = state.problem.constraints.paths, _has_prescribed_turning(state)
    for _ in range(most):
        limited = any(step.limited for step in state.steps)
        if turned and not limited:
            below = np.inf
        elif turned or (paths and not limited):
            below = CORRECTABLE_PRESCRIBED
        else:
            below = CORRECTABLE
        close = not paths or rtol is not None or limited
        if state.steps and rtol is None and state.at.residual.max_magnitude_without_holonomy < below:
            before = state.at
            state = correct_conformally(state, tol, np.inf if paths else CORRECTABLE)
            close = close or state.at is before
        residual = state.at.residual.max_magnitude
        if residual <= tol or is_diverging(state):
            break
        enough = min(largest, max(residual, tol / (2 * residual))) if rtol is None else rtol
        state = step_with_known_factor(state, enough, close=close)
    return state


def is_diverging(state: State) -> bool:
    """Return True if the surface has closed paths, and each of the last steps increased the residual."""
    last = [step.residual for step in state.steps[-1 - GROWING_STEPS :]]
    growing = len(last) > GROWING_STEPS and all(after > before for before, after in pairwise(last))
    return growing and len(state.problem.constraints.paths) > 0


def _has_prescribed_turning(state: State) -> bool:
    """Return True if the turning of any closed path is prescribed."""
    return any(not np.isnan(path.turning) for path in state.problem.constraints.paths)


def step_with_known_factor(state: State, rtol: float, *, close: bool = False) -> State:
    """Take a step with the factor of an earlier step.

    A new factor is computed after the first step and after limited steps. With `close`, the step also closes
    the paths. If turnings are prescribed, each step on a large surface searches for slivers again.
    """
    turned = _has_prescribed_turning(state)
    last = state.steps[-1] if state.steps else None
    same = last is None or last.kind != "step" or not last.limited
    lin = linearise(
        state.problem,
        state.at,
        reuse=state.lin,
        close="all" if close else "none",
        same_factor=same and len(state.steps) != 1,
        same_slivers=state.problem.constraints.n_rows < LARGE_SYSTEM or not turned,
    )
    return state.take_step(solve_for_errors(lin, state.at, rtol), "step")


def step_from_surface(state: State, surface: FloatArray, rtol: float) -> State:
    """Take a step that closes paths, to the angles closest to the angles of the `surface`, (3, #F).

    The step uses the factor of an earlier step, which is then discarded.
    """
    lin = linearise(state.problem, state.at, surface**2, state.lin, same_factor=True)
    direction = solve_for_errors(lin, state.at, rtol, (state.at.alpha - surface) / surface**2)
    return state.take_step(direction, "step").without_factors()


def correct_conformally(state: State, tol: float, below: float = CORRECTABLE) -> State:
    """Correct the angles until the residual is at most `tol` or corrections become ineffective.

    A least-norm step is e = P M^T x with (M P M^T) x = r. If the cotangent element matrices K replace P, then
    M K M^T is diag(L+, L), which is solved by a factor of the Laplacian. Therefore, e = K M^T x satisfies the
    linearised constraints after a single solve. This e is minimal in another norm, which does not matter if e
    is small.

    Parameters
    ----------
    state : State
        A state after at least one step.
    tol : float
        Corrections end at this residual.
    below : float
        Corrections begin if the residual is smaller.
    """
    least_norm, conformal = state.lin, None
    if not state.at.residual.max_magnitude < below:
        return state
    for _ in range(MAX_CORRECTIONS):
        missing = state.at.residual.max_magnitude
        if missing <= tol or state.steps[-1].limited:
            break
        fresh = conformal is None
        if conformal is None:
            conformal = _linearise_in_conformal_metric(state)
        if conformal is None:
            break
        made = _correct_once(state, conformal)
        left = made.at.residual.max_magnitude / missing
        if left < INEFFECTIVE_CORRECTION and not made.steps[-1].limited:
            state = made
        elif fresh:
            break
        if not left <= SLOW_CORRECTION:
            conformal = None
    return replace(state, lin=least_norm)


def _correct_once(state: State, conformal: Linearisation) -> State:
    """Return the state after one correction with the system of `_linearise_in_conformal_metric`."""
    assert conformal.precondition is not None
    b, holonomy = conformal.problem.constraints.predict_residual(state.at.residual), conformal.holonomy
    rhs = np.column_stack((b.vertex, b.wheel)).ravel()  # the triangle residuals are 0
    if holonomy is not None:
        rhs = np.concatenate((rhs, -holonomy.rows.compute_residuals(b.holonomy, b.vertex)))
    with time_stage("solve"):
        x = conformal.precondition(rhs)
    with time_stage("assembly"):
        direction = make_exact_direction(compute_angle_errors(conformal, x, conformal=True), x, conformal)
    return state.take_step(direction, "conformal")


def _linearise_in_conformal_metric(state: State) -> Linearisation | None:
    """Linearise the constraints at the current angles, with the inverse in the conformal metric.

    Return None if the Laplacian is singular, or if the last system was not preconditioned by a Laplacian.
    """
    lin, at, constraints = state.lin, state.at, state.problem.constraints
    if lin is None or lin.laplacian is None:
        return None
    with time_stage("assembly"):
        system = System(constraints, at.alpha, cot=at.cot, scaled=False)
        open_by = at.residual.holonomy
        closed = open_by.constrained.any()
        holonomy = HolonomyConstraints(system, open_by, conformal=True) if closed else None
        lower = system.build_laplacian()
    try:
        with time_stage("factor"):
            inverse = factor_laplacians(system, lin.laplacian, lower)
            precondition: Solve = partial(solve_pairs, inverse.solve)
            if holonomy is not None:
                precondition, _ = holonomy.make_preconditioner(system, inverse.solve, None)
    except NotPositiveDefiniteError:
        return None
    return replace(lin, system=system, holonomy=holonomy, inverse=inverse, precondition=precondition)
