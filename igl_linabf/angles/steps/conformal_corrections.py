"""Steps that end in corrections in the conformal metric, which have no inner steps."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from ..._runtime import timed
from ..._types import FloatArray, Solve
from ...linalg import NotPositiveDefiniteError
from ..system import LARGE_SYSTEM, HolonomyConstraints, System, laplacian_inverse, solve_pairs
from .constants import (
    CORRECTABLE,
    CORRECTABLE_PRESCRIBED,
    FEW_INNER_STEPS,
    GROWING_STEPS,
    IN_VAIN,
    MAX_CORRECTIONS,
    ROUGH_RTOL,
    SLOW_CORRECTION,
)
from .iterations import State
from .linearisation import Linearised, errors, exact_direction, linearise, solve


def iterate_with_corrections(
    state: State, rtol: float | None, tol: float, most: int, largest: float = ROUGH_RTOL
) -> State:
    """Active-set steps until the residual is at most `tol`, the last of them corrections.

    A step leaves about the square of the residual, so each is solved no further than that, but to a relative
    residual of `largest` at least. A small residual is corrected in the conformal metric, unless `rtol`, the
    relative residual of all steps, is given. What is missing along closed paths is spread over all triangles,
    too smoothly for conjugate gradients: corrections close the paths, and steps only where these do not help.
    """
    paths, turned = state.problem.constraints.paths, _prescribes_turning(state)
    for _ in range(most):
        limited = any(step.limited for step in state.steps)
        if turned and not limited:
            below = np.inf
        elif turned or (paths and not limited):
            below = CORRECTABLE_PRESCRIBED
        else:
            below = CORRECTABLE
        close = not paths or rtol is not None or limited
        if state.steps and rtol is None and state.at.residual.at_vertices < below:
            before = state.at
            state = correct_conformally(state, tol, np.inf if paths else CORRECTABLE)
            close = close or state.at is before
        residual = state.at.residual.largest
        if residual <= tol or diverges(state):
            break
        enough = min(largest, max(residual, tol / (2 * residual))) if rtol is None else rtol
        state = step_with_known_factor(state, enough, close=close)
    return state


def diverges(state: State) -> bool:
    """Whether steps that close paths lead away from all solutions."""
    last = [step.residual for step in state.steps[-1 - GROWING_STEPS :]]
    growing = len(last) > GROWING_STEPS and all(after > before for before, after in pairwise(last))
    return growing and len(state.problem.constraints.paths) > 0


def _prescribes_turning(state: State) -> bool:
    """Whether the turning is prescribed along some paths."""
    return any(not np.isnan(path.turning) for path in state.problem.constraints.paths)


def step_with_known_factor(state: State, rtol: float, *, close: bool = False) -> State:
    """A step with the factor that is known, unless the last step was limited; `close`: also of paths.

    The factor that the first step began with serves on if that took few inner steps. Where turnings are
    prescribed, a step is limited near cones alone. So its factor serves on, too, if it took half as many. But
    on a large surface the slivers that it left there are looked for.
    """
    turned = _prescribes_turning(state)
    last = state.steps[-1] if state.steps else None
    same = last is None or last.kind != "step" or not last.limited
    if last is not None and turned:
        same = same or 2 * last.inner_steps <= FEW_INNER_STEPS
    if len(state.steps) == 1:
        same = same and state.steps[0].inner_steps <= FEW_INNER_STEPS
    lin = linearise(
        state.problem,
        state.at,
        reuse=state.lin,
        close="all" if close else "none",
        same_factor=same,
        same_slivers=state.problem.constraints.n < LARGE_SYSTEM or not turned,
    )
    return state.advanced(solve(lin, state.at, rtol), "step")


def step_from_surface(state: State, surface: FloatArray, rtol: float) -> State:
    """A step that also closes paths, to the angles of least change from those of the `surface`, (3, #F).

    It uses the factor that is known. Where that takes many inner steps, later steps do without it.
    """
    lin = linearise(state.problem, state.at, surface**2, state.lin, same_factor=True)
    direction = solve(lin, state.at, rtol, (state.at.alpha - surface) / surface**2)
    state = state.advanced(direction, "step")
    return state.without_factors() if direction.inner_steps > FEW_INNER_STEPS else state


def correct_conformally(state: State, tol: float, below: float = CORRECTABLE) -> State:
    """Correct the angles until their residual is at most `tol`, or corrections are in vain.

    A least-norm step is e = P M^T x with (M P M^T) x = r. Let the cotangent element matrices K stand for P.
    Then M K M^T is diag(L+, L), of which there is a factor: e = K M^T x satisfies the linearised constraints
    after one solve. This e is least in another norm, which does not matter where it is small.

    Parameters
    ----------
    state : State
        After a step.
    tol : float
        Largest residual.
    below : float
        Residual below which corrections begin.
    """
    least_norm, conformal = state.lin, None
    if not state.at.residual.largest < below:
        return state
    for _ in range(MAX_CORRECTIONS):
        missing = state.at.residual.largest
        if missing <= tol or state.steps[-1].limited:
            break
        fresh = conformal is None
        if conformal is None:
            conformal = _conformal_system(state)
        if conformal is None:
            break
        made = _correct_once(state, conformal)
        left = made.at.residual.largest / missing
        if left < IN_VAIN and not made.steps[-1].limited:
            state = made
        elif fresh:
            break
        if not left <= SLOW_CORRECTION:
            conformal = None
    return replace(state, lin=least_norm)


def _correct_once(state: State, conformal: Linearised) -> State:
    """The state after a correction with a `_conformal_system`."""
    assert conformal.precondition is not None
    b, holonomy = conformal.problem.constraints.predict(state.at.residual), conformal.holonomy
    rhs = np.column_stack((b.vertex, b.wheel)).ravel()  # after a step, each triangle's angles sum to pi
    if holonomy is not None:
        rhs = np.concatenate((rhs, -holonomy.rows.gap(b.holonomy, b.vertex)))
    with timed("solve"):
        x = conformal.precondition(rhs)
    with timed("assembly"):
        direction = exact_direction(errors(conformal, x, conformal=True), x, conformal)
    return state.advanced(direction, "conformal")


def _conformal_system(state: State) -> Linearised | None:
    """The constraints linearised at the present angles, with the inverse in the conformal metric.

    None if that is singular, or where no Laplacian preconditions.
    """
    lin, at, constraints = state.lin, state.at, state.problem.constraints
    if lin is None or lin.laplacian is None:
        return None
    with timed("assembly"):
        system = System(constraints, at.alpha, cot=at.cot, scaled=False)
        open_by = at.residual.holonomy
        closed = open_by.constrained.any()
        holonomy = HolonomyConstraints(system, open_by, conformal=True) if closed else None
        lower = system.laplacian()
    try:
        with timed("factor"):
            inverse = laplacian_inverse(system, lin.laplacian, lower)
            precondition: Solve = partial(solve_pairs, inverse.solve)
            if holonomy is not None:
                precondition, _ = holonomy.preconditioner(system, inverse.solve, None)
    except NotPositiveDefiniteError:
        return None
    return replace(lin, system=system, holonomy=holonomy, inverse=inverse, precondition=precondition)
