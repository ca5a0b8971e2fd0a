"""Converged ABF: the flat mesh with the least relative change of the angles."""

from dataclasses import dataclass, replace

import numpy as np

from ..._runtime import advance
from ..._types import BoolArray, FloatArray
from ...errors import SingularSystemError
from ...surface import NEXT, PREV
from .conformal_corrections import correct_conformally, is_diverging, iterate_with_corrections
from .iterates import Kind, Step
from .iterations import State
from .linearisation import Direction, linearise, solve_for_errors

# Constants of anchored steps, which minimise the change from the initial estimate
ANCHORED_RTOL = 0.03  # relative residual of conjugate gradients in anchored steps
SLOW_STEP = 0.7  # a step is slow if its change exceeds this share of the smallest change so far
LEAST_ANCHORED_RTOL = 0.003  # lower bound to which slow steps reduce ANCHORED_RTOL
NEARLY_LINEAR = 1.0  # relative change of an angle below which slow steps are solved more accurately
MAX_ANCHORED_STEPS = 30  # maximum number of anchored steps; feasible steps may be twice as many
MAX_SLOW_STEPS = 9  # maximum number of consecutive slow steps

# Lower bounds that keep angles positive
ANGLE_BOUND = 0.01  # lower bound of an angle, relative to its initial value
BOUND_TOLERANCE = 1 + 1e-6  # an angle up to this multiple of its bound counts as being at the bound
HELD_WEIGHT = 1e-12  # weight of an angle that is fixed at its bound, relative to a free angle

# Constants of feasible steps, after each of which the constraints hold
FEASIBLE_RTOL = 0.01  # relative residual of conjugate gradients in feasible and restoration steps
LEAST_CURVATURE = 0.2  # lower bound of the curvature in the weights, relative to the objective's curvature
MAX_RESTORING_STEPS = 4  # bound per feasible step on restoration steps, and on updates of fixed angles
NEGLIGIBLE_GAIN = 1e-4  # relative decrease of the objective that is negligible, as a multiple of `tol`
NEGLIGIBLE_CHANGE = 4.0  # relative change of the angles that is negligible, as a multiple of `tol`
MAX_FEASIBLE_WORK = 2e7  # stop feasible steps at this work: triangles times (solves + inner steps)
ROUNDING = 1e-13  # relative rounding error of the objective
LEAST_STEP = 1e-7  # minimum step length of the line search, relative to the full step
START_RESIDUAL = 1e-9  # maximum residual before the first feasible step
MAX_START_STEPS = 20  # maximum number of steps to reduce the residual to START_RESIDUAL


@dataclass(frozen=True, eq=False)
class AbfResult:
    """The result of the iterations of converged ABF.

    Attributes
    ----------
    state : State
    converged : bool
        Whether the relative change of every angle and the residual are within the tolerance.
    held : (3, #F) bool
        Mask of the angles fixed at their lower bound; all False if the angles have no bounds.
    """

    state: State
    converged: bool
    held: BoolArray


def measure_objective(state: State) -> float:
    """Return sum ((alpha - alpha_0) / alpha_0)^2, eq. 1 with the weights of the paper."""
    anchor = state.problem.estimate
    return float((((state.at.alpha - anchor) / anchor) ** 2).sum())


def converge(state: State, tol: float) -> AbfResult:
    """Minimise sum ((alpha - alpha_0) / alpha_0)^2 over the angles of flat meshes, by anchored steps.

    This is the objective of Sheffer and de Sturler under their constraints (eq. 1-4), with the nonlinear
    wheel constraint. An *anchored* step is a step of linear ABF with weights alpha_0^2 and the change since
    alpha_0 as its gradient. It is a Gauss-Newton step of the constraints, and its fixed point is the
    minimiser. The steps use the factor of the Laplacian at alpha_0, and conjugate gradients start from the
    last multipliers.

    Parameters
    ----------
    state : State
        At the initial estimate alpha_0.
    tol : float
        The iterations end when the largest residual, and the predicted largest relative change of an angle
        in the next step, are at most `tol`. The change can be predicted, because changes decrease linearly.
    """
    return _take_anchored_steps(state, tol)


def _take_anchored_steps(state: State, tol: float, *, bounded: bool = False) -> AbfResult:
    """Take anchored steps until they converge or become slow.

    With `bounded`, an angle at its bound is fixed as long as a step would decrease the angle.
    """
    start, problem, lin = state, state.problem, state.lin
    kind: Kind = "feasible" if bounded else "anchored"
    anchor, rtol = problem.estimate, ANCHORED_RTOL
    held, x, free = np.zeros(anchor.shape, dtype=bool), None, anchor**2
    best, stalled, before = np.inf, 0, 0.0
    for k in range(MAX_ANCHORED_STEPS):
        at, weights = state.at, np.where(held, HELD_WEIGHT * free, free) if held.any() else free
        try:
            lin = linearise(problem, at, weights, lin, close="all" if k else "paths", same_factor=k > 0)
            raw = solve_for_errors(lin, at, rtol, _compute_gradient(state), x)
        except SingularSystemError:
            break  # the system is too ill-conditioned for double precision; feasible steps avoid such angles
        e = np.where(held, 0.0, raw.e) if bounded else raw.e
        change = _find_largest_change(e, state)
        state, now = state.take_step(raw, kind), held
        if bounded:
            state = _move_into_bounds(state)
            now = (state.at.alpha <= BOUND_TOLERANCE * ANGLE_BOUND * anchor) & (~held | (raw.e < 0))
        lin, x = raw.lin.without_matrix, raw.x
        state = replace(state, lin=lin)
        del at, raw, e  # free the memory for the next matrix
        residual, limited, same = (
            state.at.residual.max_magnitude,
            state.steps[-1].limited,
            (now == held).all(),
        )
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
        ends = _count_work(start, state) > MAX_FEASIBLE_WORK if bounded else limited and k > 1
        if ends or stalled > MAX_SLOW_STEPS:
            break
    return AbfResult(state.without_factors(), False, held)


def _count_work(start: State, state: State) -> int:
    """Return the number of triangles times the number of solves and inner steps since `start`."""
    made = state.steps[len(start.steps) :]
    return int(state.at.alpha.shape[1]) * sum(1 + step.inner_steps for step in made)


def _move_into_bounds(state: State) -> State:
    """Raise angles to their bounds, and scale the other angles of the same triangles to compensate."""
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
    return replace(state, at=state.problem.evaluate(alpha))


def converge_feasibly(state: State, tol: float) -> AbfResult:
    """Minimise the objective of `converge` (eq. 1-4) under lower bounds of the angles, by feasible steps.

    This is the fallback if the anchored steps of `converge` do not converge. First, anchored steps are taken,
    and angles that reach their bounds are fixed. If these steps do not converge either, feasible steps start
    from a converged active set.

    The weights of feasible steps include the curvature of the wheel constraints, which is diagonal: |1 /
    alpha_0^2 + (x_right - x_left) / sin^2(alpha)|, where x_right and x_left are the multipliers of the two
    wheels that contain the angle. After each step, corrections restore the constraints. A step is
    halved until the objective decreases. The steps end when their gains, predicted as a geometric series,
    become negligible. Every angle is bounded below by a hundredth of alpha_0, because some angles vanish at
    the minimum on hard meshes. On large meshes, the steps end without convergence after a fixed amount of
    work.

    Parameters
    ----------
    state, tol
        As in `converge`.
    """
    start = state
    result = _take_anchored_steps(state.reset_to_estimate(), tol, bounded=True)
    if result.converged:
        return result
    state, held = result.state, np.zeros(state.at.alpha.shape, dtype=bool)
    state = iterate_with_corrections(
        state.reset_to_estimate(), None, START_RESIDUAL, MAX_START_STEPS, ANCHORED_RTOL
    )
    if is_diverging(state):
        return AbfResult(state.without_factors(), False, held)
    x: FloatArray | None = None
    scale, value, gain = 1.0, measure_objective(state), np.inf
    for _ in range(2 * MAX_ANCHORED_STEPS):
        last = gain
        direction, inner_steps, held = _find_feasible_direction(state, x, held)
        state, x = replace(state, lin=direction.lin), direction.x
        change = _find_largest_change(np.where(held, 0.0, direction.e), state)
        if change <= tol and state.at.residual.max_magnitude <= tol:
            return AbfResult(state.without_factors(), True, held)
        state, scale = _line_search(state, direction.e, inner_steps, held, min(1.0, 2 * scale))
        after = measure_objective(state)
        gain = value - after
        # predict all further gains: successive gains decrease like a geometric series
        gain_left = gain**2 / (last - gain) if ROUNDING * value < gain < last else np.inf
        if gain_left <= max(NEGLIGIBLE_GAIN * tol, (NEGLIGIBLE_CHANGE * tol) ** 2) * value and last < np.inf:
            return AbfResult(state.without_factors(), True, held)
        if scale < LEAST_STEP or _count_work(start, state) > MAX_FEASIBLE_WORK:
            break
        value = after
    return AbfResult(state.without_factors(), False, held)


def _compute_gradient(state: State) -> FloatArray:
    """Return half the gradient of `measure_objective`, (3, #F)."""
    anchor = state.problem.estimate
    return np.asarray((state.at.alpha - anchor) / anchor**2)


def _find_largest_change(e: FloatArray, state: State) -> float:
    """Return the largest |e / alpha|: the relative change of an angle if `e` is added to the angles."""
    return float(np.abs(e / state.at.alpha).max())


def _find_feasible_direction(
    state: State, x: FloatArray | None, held: BoolArray
) -> tuple[Direction, int, BoolArray]:
    """Compute a descent direction of the objective at feasible angles.

    An angle at its bound is fixed if the direction would decrease the angle. Also return the number of inner
    steps and a mask of the fixed angles.
    """
    anchor, alpha = state.problem.estimate, state.at.alpha
    gradient, inner_steps, lin = _compute_gradient(state), 0, state.lin
    curvature = 1 / anchor**2
    if x is not None and lin is not None:
        wheel = lin.multipliers_at_corners(x)[1]
        curvature += (wheel[PREV] - wheel[NEXT]) / np.sin(alpha) ** 2
    weights = 1 / np.maximum(np.abs(curvature), LEAST_CURVATURE / anchor**2)
    low = alpha <= BOUND_TOLERANCE * ANGLE_BOUND * anchor
    held = held & low
    for _ in range(MAX_RESTORING_STEPS):
        w = np.where(held, HELD_WEIGHT * weights, weights)
        lin = linearise(state.problem, state.at, w, lin, same_slivers=False)
        direction = solve_for_errors(lin, state.at, FEASIBLE_RTOL, gradient, x)
        lin, x = direction.lin, direction.x
        inner_steps += direction.max_inner_steps
        falling = low & (direction.e < 0)
        if (falling == held).all():
            break
        held = falling
    return direction, inner_steps, held


def _line_search(
    state: State, e: FloatArray, inner_steps: int, held: BoolArray, scale: float
) -> tuple[State, float]:
    """Step along `e` and restore the constraints; halve the step until the objective decreases."""
    problem, start, before = state.problem, state.at, measure_objective(state)
    anchor, alpha = problem.estimate, start.alpha
    slope = 2 * float((_compute_gradient(state) * e).sum())
    # tolerance: a residual of this size changes the objective less than the step does
    exact = max(1e-11, 1e-3 * min(float(np.abs(e / alpha).max()), 1e-3) ** 2)
    while scale >= LEAST_STEP:
        trial = np.maximum(alpha + scale * e, np.minimum(alpha, ANGLE_BOUND * anchor))
        at = problem.evaluate(trial * (np.pi / trial.sum(axis=0)))
        step = Step("feasible", inner_steps, 0, at.residual.max_magnitude)
        advance("feasible", 0.05)
        state = _restore_constraints(
            replace(state, at=at, steps=(*state.steps, step)), held, exact, MAX_RESTORING_STEPS
        )
        after = measure_objective(state)
        if after <= before + 1e-4 * scale * slope or abs(after - before) <= ROUNDING * before:
            return state, scale
        inner_steps, scale = 0, scale / 2
    return replace(state, at=start), scale


def _restore_constraints(state: State, held: BoolArray, exact: float, most: int) -> State:
    """Reduce the residual to at most `exact` by corrections, then by active-set steps if needed."""
    if not held.any():
        state = correct_conformally(state, exact)  # only without fixed angles, which would change
    for _ in range(most):
        if state.at.residual.max_magnitude <= exact:
            break
        weights = np.where(held, HELD_WEIGHT, 1.0) * state.at.alpha**2
        lin = linearise(state.problem, state.at, weights, state.lin, same_slivers=False)
        state = state.take_step(solve_for_errors(lin, state.at, FEASIBLE_RTOL), "restoration")
    return state
