"""Converged ABF: the flat mesh with the least relative change of the angles."""

from dataclasses import dataclass, replace

import numpy as np

from ..._runtime import advance
from ..._types import BoolArray, FloatArray
from ...errors import SingularSystemError
from ...surface import NEXT, PREV
from .conformal_corrections import correct_conformally, diverges, iterate_with_corrections
from .constants import (
    ANCHORED_RTOL,
    ANGLE_BOUND,
    AT_BOUND,
    FEASIBLE_RTOL,
    HELD_WEIGHT,
    LEAST_ANCHORED_RTOL,
    LEAST_CURVATURE,
    LEAST_STEP,
    LEFT_GAIN,
    LEFT_TO_STEPS,
    MAX_ANCHORED_STEPS,
    MAX_FEASIBLE_WORK,
    MAX_RESTORING_STEPS,
    MAX_SLOW_STEPS,
    MAX_START_STEPS,
    NEARLY_LINEAR,
    ROUNDING,
    SLOW_STEP,
    START_RESIDUAL,
)
from .iterates import Kind, Step
from .iterations import State
from .linearisation import Direction, linearise, solve


@dataclass(frozen=True, eq=False)
class AbfResult:
    """Where the iterations of converged ABF ended.

    Attributes
    ----------
    state : State
    converged : bool
        Whether the change of every angle and the residual are within the tolerance.
    held : (3, #F) bool
        The angles at their lower bound; only the feasible form has one.
    """

    state: State
    converged: bool
    held: BoolArray


def objective(state: State) -> float:
    """sum ((alpha - alpha_0) / alpha_0)^2, eq. 1 with the paper's weights."""
    anchor = state.problem.estimate
    return float((((state.at.alpha - anchor) / anchor) ** 2).sum())


def converge(state: State, tol: float) -> AbfResult:
    """Minimise sum ((alpha - alpha_0) / alpha_0)^2 over the angles of flat meshes, by anchored steps.

    That is the objective of Sheffer and de Sturler under their constraints (eq. 1-4), with the wheel
    constraint not linearised. An *anchored* step is a step of linear ABF with weights alpha_0^2 and
    the change since alpha_0 as its gradient. It is a Gauss-Newton step of the constraints; its fixed
    point is the minimiser. The steps use the factor of the Laplacian at alpha_0, and conjugate gradients
    start from the last multipliers.

    Parameters
    ----------
    state : State
        At the initial estimate alpha_0.
    tol : float
        The iterations end when the largest relative change of an angle that another step would bring, and
        the largest residual, are at most this. Changes fall linearly, so the next one's is predicted.
    """
    return _anchored(state, tol)


def _anchored(state: State, tol: float, *, bounded: bool = False) -> AbfResult:
    """Anchored steps; with `bounded` an angle at its bound is held as long as a step would lower it."""
    start, problem, lin = state, state.problem, state.lin
    kind: Kind = "feasible" if bounded else "anchored"
    anchor, rtol = problem.estimate, ANCHORED_RTOL
    held, x, free = np.zeros(anchor.shape, dtype=bool), None, anchor**2
    best, stalled, before = np.inf, 0, 0.0
    for k in range(MAX_ANCHORED_STEPS):
        at, weights = state.at, np.where(held, HELD_WEIGHT * free, free) if held.any() else free
        try:
            lin = linearise(problem, at, weights, lin, close="all" if k else "paths", same_factor=k > 0)
            raw = solve(lin, at, rtol, _gradient(state), x)
        except SingularSystemError:
            break  # it left what double precision solves; the feasible form keeps away from there
        e = np.where(held, 0.0, raw.e) if bounded else raw.e
        change = _change(e, state)
        state, now = state.advanced(raw, kind), held
        if bounded:
            state = _move_into_bounds(state)
            now = (state.at.alpha <= AT_BOUND * ANGLE_BOUND * anchor) & (~held | (raw.e < 0))
        lin, x = raw.lin.without_matrix, raw.x
        state = replace(state, lin=lin)
        del at, raw, e  # their memory is for the next matrix, and the last factor
        residual, limited, same = state.at.residual.largest, state.steps[-1].limited, (now == held).all()
        ahead = change * min(change / before, 1.0) if before else change
        if same and max(ahead, residual) <= tol:
            return AbfResult(state.without_factors(), True, held)
        before, held, reached = change, now, max(change, residual)
        if not reached < SLOW_STEP * best:
            stalled += 1
            if not limited and change < NEARLY_LINEAR:
                rtol = max(rtol / 3, LEAST_ANCHORED_RTOL)
        else:
            best, stalled = reached, 0
        ends = _work_since(start, state) > MAX_FEASIBLE_WORK if bounded else limited and k > 1
        if ends or stalled > MAX_SLOW_STEPS:
            break
    return AbfResult(state.without_factors(), False, held)


def _work_since(start: State, state: State) -> int:
    """Triangles times solves and inner steps after `start`."""
    made = state.steps[len(start.steps) :]
    return int(state.at.alpha.shape[1]) * sum(1 + step.inner_steps for step in made)


def _move_into_bounds(state: State) -> State:
    """The state with no angle below its bound: the others of its triangle make up for it."""
    alpha, least = state.at.alpha, ANGLE_BOUND * state.problem.estimate
    low = alpha < least
    faces = np.flatnonzero(low.any(axis=0))
    if not len(faces):
        return state
    here, low = alpha[:, faces], low[:, faces]
    free = np.where(low, 0.0, here)
    here = np.where(
        low, least[:, faces], free * ((np.pi - (low * least[:, faces]).sum(axis=0)) / free.sum(axis=0))
    )
    alpha = alpha.copy()
    alpha[:, faces] = here
    return replace(state, at=state.problem.at(alpha))


def converge_feasibly(state: State, tol: float) -> AbfResult:
    """The same minimum (eq. 1-4) with bounds, for when anchored steps do not converge.

    First anchored steps hold the angles that come to their bound. If these do not
    converge, feasible steps start from a converged active set.

    The weights include the curvature of the wheel constraints, which is diagonal:
    |1 / alpha_0^2 + (x_right - x_left) / sin^2(alpha)|, with the multipliers of the two wheels of an
    angle. Each step is followed by corrections that restore the constraints, and halved until the
    objective falls. They end where their gains, predicted as a geometric series, are too small to matter.
    Angles are bounded below by a hundredth of alpha_0, since some angles vanish at the minimum on hard
    meshes. On large meshes the steps end after a fixed amount of work, and have then not converged.

    Parameters
    ----------
    state, tol
        As for `converge`.
    """
    start = state
    result = _anchored(state.back_to_start(), tol, bounded=True)
    if result.converged:
        return result
    state, held = result.state, np.zeros(state.at.alpha.shape, dtype=bool)
    state = iterate_with_corrections(
        state.back_to_start(), None, START_RESIDUAL, MAX_START_STEPS, ANCHORED_RTOL
    )
    if diverges(state):
        return AbfResult(state.without_factors(), False, held)
    x: FloatArray | None = None
    scale, value, gain = 1.0, objective(state), np.inf
    for _ in range(2 * MAX_ANCHORED_STEPS):
        last = gain
        direction, inner_steps, held = _feasible_direction(state, x, held)
        state, x = replace(state, lin=direction.lin), direction.x
        change = _change(np.where(held, 0.0, direction.e), state)
        if change <= tol and state.at.residual.largest <= tol:
            return AbfResult(state.without_factors(), True, held)
        state, scale = _line_search(state, direction.e, inner_steps, held, min(1.0, 2 * scale))
        after = objective(state)
        gain = value - after
        # the gains fall like a geometric series
        gain_left = gain**2 / (last - gain) if ROUNDING * value < gain < last else np.inf
        if gain_left <= max(LEFT_GAIN * tol, (LEFT_TO_STEPS * tol) ** 2) * value and last < np.inf:
            return AbfResult(state.without_factors(), True, held)
        if scale < LEAST_STEP or _work_since(start, state) > MAX_FEASIBLE_WORK:
            break
        value = after
    return AbfResult(state.without_factors(), False, held)


def _gradient(state: State) -> FloatArray:
    anchor = state.problem.estimate
    return np.asarray((state.at.alpha - anchor) / anchor**2)


def _change(e: FloatArray, state: State) -> float:
    """Largest relative change of an angle by errors `e`."""
    return float(np.abs(e / state.at.alpha).max())


def _feasible_direction(
    state: State, x: FloatArray | None, held: BoolArray
) -> tuple[Direction, int, BoolArray]:
    """Direction at feasible angles; an angle at its bound is held if the direction would lower it."""
    anchor, alpha = state.problem.estimate, state.at.alpha
    gradient, inner_steps, lin = _gradient(state), 0, state.lin
    curvature = 1 / anchor**2
    if x is not None and lin is not None:
        wheel = lin.at_corners(x)[1]
        curvature += (wheel[PREV] - wheel[NEXT]) / np.sin(alpha) ** 2
    weights = 1 / np.maximum(np.abs(curvature), LEAST_CURVATURE / anchor**2)
    low = alpha <= AT_BOUND * ANGLE_BOUND * anchor
    held = held & low
    for _ in range(MAX_RESTORING_STEPS):
        w = np.where(held, HELD_WEIGHT * weights, weights)
        lin = linearise(state.problem, state.at, w, lin, same_slivers=False)
        direction = solve(lin, state.at, FEASIBLE_RTOL, gradient, x)
        lin, x = direction.lin, direction.x
        inner_steps += direction.inner_steps
        falling = low & (direction.e < 0)
        if (falling == held).all():
            break
        held = falling
    return direction, inner_steps, held


def _line_search(
    state: State, e: FloatArray, inner_steps: int, held: BoolArray, scale: float
) -> tuple[State, float]:
    """Line search: go along `e`, restore the constraints, until the objective falls."""
    problem, start, before = state.problem, state.at, objective(state)
    anchor, alpha = problem.estimate, start.alpha
    slope = 2 * float((_gradient(state) * e).sum())
    # so exactly that what is missing does not hide the change of the objective
    exact = max(1e-11, 1e-3 * min(float(np.abs(e / alpha).max()), 1e-3) ** 2)
    while scale >= LEAST_STEP:
        trial = np.maximum(alpha + scale * e, np.minimum(alpha, ANGLE_BOUND * anchor))
        at = problem.at(trial * (np.pi / trial.sum(axis=0)))
        step = Step("feasible", inner_steps, 0, at.residual.largest)
        advance("feasible", 0.05)
        state = _restore_constraints(
            replace(state, at=at, steps=(*state.steps, step)), held, exact, MAX_RESTORING_STEPS
        )
        after = objective(state)
        if after <= before + 1e-4 * scale * slope or abs(after - before) <= ROUNDING * before:
            return state, scale
        inner_steps, scale = 0, scale / 2
    return replace(state, at=start), scale


def _restore_constraints(state: State, held: BoolArray, exact: float, most: int) -> State:
    """Corrections, and active-set steps where these do not serve, until the residual is at most `exact`."""
    if not held.any():
        state = correct_conformally(state, exact)  # they hold no angle
    for _ in range(most):
        if state.at.residual.largest <= exact:
            break
        weights = np.where(held, HELD_WEIGHT, 1.0) * state.at.alpha**2
        lin = linearise(state.problem, state.at, weights, state.lin, same_slivers=False)
        state = state.advanced(solve(lin, state.at, FEASIBLE_RTOL), "restoration")
    return state
