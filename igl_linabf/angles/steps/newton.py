"""Converged ABF: the flat mesh with the least relative change of the angles."""

from dataclasses import dataclass, replace

import numpy as np

from ..._runtime import advance
from ..._types import BoolArray, FloatArray
from ...errors import SingularSystemError
from ...surface import NEXT, PREV
from .acceleration import Visited, accelerated
from .conformal_corrections import conformal_steps, diverges, iterate_with_corrections
from .iterates import Kind, Step
from .iterations import State
from .linearisation import Direction, linearise, solve

ANCHORED_RTOL = 0.03  # relative reduction of what an anchored step's multipliers miss
LEAST_RTOL = 0.003  # and at least, where they shake the angles about
SLOW = 0.7  # share of the least change so far, above which they do, and steps are accelerated
TOIL = 12  # inner steps of a slow step, above which steps in the plane take less time
QUICK = 0.3  # share of the last step's change, below which few steps are to go: no other form pays
DIGITS = 1e-5  # tolerance for which positions in the plane mostly have enough digits
NEAR = 1.0  # where the change is below that, by
DEPTH = 2  # earlier ones
FEASIBLE_RTOL = 0.01  # and of a feasible or restoring step's
MAX_ANCHORED = 30  # anchored steps at most
STALLED = 9  # of them without progress before the feasible form takes over
MAX_FEASIBLE = 60  # steps of the feasible form at most
LEAST_SHARE = 0.01  # of its initial value, below which the feasible form lets no angle fall
AT_BOUND = 1 + 1e-6  # times that, below which an angle is at its bound
MAX_RESTORING = 4  # restoring steps at most after each
NEARLY = 4.0  # times the tolerance: share of all change of the angles that may be left to further steps
FURTHER = 2.0  # times that, a last correction may change them
LAST = 0.1  # of the tolerance: residual from which there is such a correction
HELD = 1e-12  # weight of an angle that is held at its bound, relative to a free one's
FORESEEN = 1e-4  # relative gain of the objective that may be left to further steps, times the tolerance
ROUNDING = 1e-13  # relative gain of the objective below which it is rounding
LEAST_SCALE = 1e-7  # of a feasible step
START_RESIDUAL, START_STEPS = 1e-9, 20  # residual of the start of the feasible form, steps to it at most
START_RTOL = 0.03  # relative residual to which these are solved
LEAST_CURVATURE = 0.2  # share of the objective's curvature below which none is believed


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
    start from the last multipliers. Slow steps are accelerated.

    Parameters
    ----------
    state : State
        At the initial estimate alpha_0.
    tol : float
        The iterations end when the largest relative change of an angle that another step would bring, and
        the largest residual, are at most this. Changes fall linearly: the next one's is foreseen. They end
        earlier where all further steps together would lower the objective by less than (`NEARLY` `tol`)^2
        of itself: then corrections do the rest, which have no inner steps.
    """
    return _anchored(state, tol)


def _anchored(state: State, tol: float, *, bounded: bool = False) -> AbfResult:
    """Anchored steps; with `bounded` an angle at its bound is held as long as a step would lower it."""
    problem, lin = state.problem, state.lin
    kind: Kind = "feasible" if bounded else "anchored"
    anchor, rtol = problem.estimate, ANCHORED_RTOL
    held, x, free = np.zeros(anchor.shape, dtype=bool), None, anchor**2
    past: tuple[Visited, ...] = ()
    best, stalled, before, size_before, slow = np.inf, 0, 0.0, 0.0, False
    in_plane = problem.constraints.plain and tol >= DIGITS
    for k in range(MAX_ANCHORED):
        at, weights = state.at, np.where(held, HELD * free, free) if held.any() else free
        try:
            lin = linearise(problem, at, weights, lin, close="all" if k else "paths", same_factor=k > 0)
            raw = solve(lin, at, rtol, _gradient(state), x)
        except SingularSystemError:
            break  # it left what double precision solves; the feasible form keeps away from there
        e = np.where(held, 0.0, raw.e) if bounded else raw.e
        change, size = _change(e, state), _size(e / anchor)
        direction = raw
        if slow:
            visited = Visited(at.alpha, raw, (raw.e / anchor).ravel())
            direction = accelerated(visited, past) if change < NEAR else raw
            past = (visited, *past)[:DEPTH]
        state, now = state.advanced(direction, kind), held
        if bounded:
            state = _within_bounds(state)
            now = (state.at.alpha <= AT_BOUND * LEAST_SHARE * anchor) & (~held | (raw.e < 0))
        lin, x = direction.lin.without_matrix, direction.x
        state = replace(state, lin=lin)
        del at, raw, direction, e  # their memory is for the next matrix, and the last factor
        residual, limited, same = state.at.residual.largest, state.steps[-1].limited, (now == held).all()
        ahead = change * min(change / before, 1.0) if before else change
        if same and max(ahead, residual) <= tol:
            return AbfResult(state.without_factors(), True, held)
        enough = NEARLY * tol * np.sqrt(objective(state))
        if same and not limited and not held.any() and _left(size, size_before) <= enough:
            lin, state = lin.without_factors, state.without_factors()
            ended = _ended(state, enough, tol)
            if ended is not None:
                return AbfResult(ended.without_factors(), True, held)
        quick = size < QUICK * size_before and not any(step.limited for step in state.steps[-2:])
        toilsome = in_plane and state.steps[-1].inner_steps > TOIL and not quick
        if limited or not same:
            past = ()  # after another set of constraints the steps lead elsewhere
        before, size_before, held, reached = change, size, now, max(change, residual)
        if not reached < SLOW * best:
            stalled, slow = stalled + 1, True
            if not limited and change < NEAR:
                rtol = max(rtol / 3, LEAST_RTOL)
        else:
            best, stalled = reached, 0
        if stalled > STALLED or (not bounded and ((slow and toilsome) or (limited and k > 1))):
            break
    return AbfResult(state.without_factors(), False, held)


def _left(size: float, before: float) -> float:
    """Relative change of all angles by all further steps: the sum of a geometric series.

    Parameters
    ----------
    size, before : float
        That by the last step, and by the one before; 0 if there was none.
    """
    return size**2 / (before - size) if size < before else np.inf


def _ended(state: State, enough: float, tol: float) -> State | None:
    """The state on the constraints, unless going there changes more angles than further steps would.

    Parameters
    ----------
    state : State
        After an anchored step.
    enough : float
        Relative change of all angles that further steps may leave.
    tol : float
    """
    made = conformal_steps(state, tol) if state.at.residual.largest > LAST * tol else state
    # the correction is least in another norm, and leads away from the minimum where triangles are thin
    moved = _size((made.at.alpha - state.at.alpha) / state.problem.estimate)
    return made if made.at.residual.largest <= tol and moved <= FURTHER * enough else None


def _size(change: FloatArray) -> float:
    """The norm of relative changes that is that of the objective."""
    flat = change.ravel()
    return float(np.sqrt(np.einsum("i,i->", flat, flat)))


def _within_bounds(state: State) -> State:
    """The state with no angle below its bound: the others of its triangle make up for it."""
    alpha, least = state.at.alpha, LEAST_SHARE * state.problem.estimate
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
    objective falls. Steps are accelerated, and end where their gains, foreseen as a geometric series, are
    too small to matter. Angles are bounded below by a hundredth of alpha_0, since on hard meshes some
    angles vanish at the minimum.

    Parameters
    ----------
    state, tol
        As for `converge`.
    """
    result = _anchored(state.back_to_start(), tol, bounded=True)
    if result.converged:
        return result
    state, held = result.state, np.zeros(state.at.alpha.shape, dtype=bool)
    state = iterate_with_corrections(state.back_to_start(), None, START_RESIDUAL, START_STEPS, START_RTOL)
    if diverges(state):
        return AbfResult(state.without_factors(), False, held)
    x: FloatArray | None = None
    past: tuple[Visited, ...] = ()
    scale, value, gain = 1.0, objective(state), np.inf
    for _ in range(MAX_FEASIBLE):
        before, last = held, gain
        raw, inner_steps, held = _feasible_direction(state, x, held)
        state, e = replace(state, lin=raw.lin), np.where(held, 0.0, raw.e)
        change = _change(e, state)
        visited = Visited(state.at.alpha, raw, (e / state.problem.estimate).ravel())
        if (held != before).any():
            past = ()
        direction = accelerated(visited, past) if change < NEAR else raw
        past, x = (visited, *past)[:DEPTH], direction.x
        if change <= tol and state.at.residual.largest <= tol:
            return AbfResult(state.without_factors(), True, held)
        state, scale = _searched(state, direction.e, inner_steps, held, min(1.0, 2 * scale))
        after = objective(state)
        gain = value - after
        # the gains fall like a geometric series: what is left of it is foreseen
        foreseen = gain**2 / (last - gain) if ROUNDING * value < gain < last else np.inf
        if foreseen <= max(FORESEEN * tol, (NEARLY * tol) ** 2) * value and last < np.inf:
            return AbfResult(state.without_factors(), True, held)
        if scale < LEAST_SCALE:
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
    low = alpha <= AT_BOUND * LEAST_SHARE * anchor
    held = held & low
    for _ in range(MAX_RESTORING):
        w = np.where(held, HELD * weights, weights)
        lin = linearise(state.problem, state.at, w, lin, same_slivers=False)
        direction = solve(lin, state.at, FEASIBLE_RTOL, gradient, x)
        lin, x = direction.lin, direction.x
        inner_steps += direction.inner_steps
        falling = low & (direction.e < 0)
        if (falling == held).all():
            break
        held = falling
    return direction, inner_steps, held


def _searched(
    state: State, e: FloatArray, inner_steps: int, held: BoolArray, scale: float
) -> tuple[State, float]:
    """Line search: go along `e`, restore the constraints, until the objective falls."""
    problem, start, before = state.problem, state.at, objective(state)
    anchor, alpha = problem.estimate, start.alpha
    slope = 2 * float((_gradient(state) * e).sum())
    # so exactly that what is missing does not hide the change of the objective
    exact = max(1e-11, 1e-3 * min(float(np.abs(e / alpha).max()), 1e-3) ** 2)
    while scale >= LEAST_SCALE:
        trial = np.maximum(alpha + scale * e, np.minimum(alpha, LEAST_SHARE * anchor))
        at = problem.at(trial * (np.pi / trial.sum(axis=0)))
        step = Step("feasible", inner_steps, 0, at.residual.largest)
        advance("feasible", 0.05)
        state = _restored(replace(state, at=at, steps=(*state.steps, step)), held, exact, MAX_RESTORING)
        after = objective(state)
        if after <= before + 1e-4 * scale * slope or abs(after - before) <= ROUNDING * before:
            return state, scale
        inner_steps, scale = 0, scale / 2
    return replace(state, at=start), scale


def _restored(state: State, held: BoolArray, exact: float, most: int) -> State:
    """Corrections, and active-set steps where these do not serve, until the residual is at most `exact`."""
    if not held.any():
        state = conformal_steps(state, exact)  # they hold no angle
    for _ in range(most):
        if state.at.residual.largest <= exact:
            break
        weights = np.where(held, HELD, 1.0) * state.at.alpha**2
        lin = linearise(state.problem, state.at, weights, state.lin, same_slivers=False)
        state = state.advanced(solve(lin, state.at, FEASIBLE_RTOL), "restoration")
    return state
