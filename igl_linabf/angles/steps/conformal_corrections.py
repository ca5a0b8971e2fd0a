"""Steps that end in corrections in the conformal metric, which have no inner steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ..._runtime import timed
from ..._types import FloatArray
from ...linalg import NotPositiveDefiniteError
from ..system import HolonomyConstraints, System, conformal_inverse, laplacian_inverse
from .acceleration import shares_of
from .iterations import State
from .linearisation import Linearised, errors, exact_direction, linearise, solve
from .local_elimination import eliminate_locally

SMALL = 0.12  # residual below which they begin: F/3nt stays the same within a thousandth
EARLY_BELOW = 0.25  # and where angles change more than to a free boundary
SLOW = 0.2  # share of the residual left by a correction, above which a new factor pays
SLOW_OF_PATHS, MANY_PATHS = 0.4, 4  # and for so many paths, each with columns of a new factor to solve for
STALE = 1.5  # if it is so many times the share that the first correction with the factor left
IN_VAIN = 0.5  # and above which corrections do not help
MAX_CORRECTIONS = 12
FEW_INNER, MANY_INNER = 4, 8  # inner steps, up to which none pays after one cut short; above which one does
FAST = 0.02  # share left, above which earlier corrections tell more than they cost
MOST_CUT_SHORT = 2  # steps, above which what they leave is not at few triangles alone
RESTING = 0.5  # share of the last step's residual, above which a step brought little
FAR = 0.1  # share of the residual before a correction in vain, from which a patch is laid around a row
GROWING = 4  # steps in a row that leave more than the one before: along closed paths too much is asked
REMEMBERED = 3  # corrections with the same factor that say how the next one changes what is missing
LARGE = 5_000  # rows from which new slivers take less time than the inner steps that they save
ROUGH_RTOL = 0.1  # relative residual to which a step is solved that others follow


@dataclass(frozen=True, eq=False)
class Visit:
    """What a correction went by.

    Attributes
    ----------
    missing : (n,) float64
        To all constraints before it.
    reached : (n,) float64
        The sum of all multipliers up to the solution there.
    taken : (n,) float64
        Those by which it went, as earlier corrections say how the next one changes what is missing.
    """

    missing: FloatArray
    reached: FloatArray
    taken: FloatArray


def iterate_with_corrections(
    state: State, rtol: float | None, tol: float, most: int, largest: float = ROUGH_RTOL
) -> State:
    """Active-set steps until the residual is at most `tol`, the last of them corrections.

    A step leaves about the square of the residual, so each is solved no further than that, but to a relative
    residual of `largest` at least. What is small is corrected in the conformal metric, if no relative
    residual is asked for. What is missing along closed paths is spread over all triangles, too smoothly for
    conjugate gradients: the corrections close them, and steps only where these do not help.
    """
    paths, turned = state.problem.constraints.paths, _turned(state)
    for _ in range(most):
        cut_short = any(step.limited for step in state.steps)
        made_up = bool(state.steps) and state.steps[-1].kind == "patches"
        if turned and not cut_short:
            below = np.inf
        else:
            below = EARLY_BELOW if (turned and not made_up) or (paths and not cut_short) else SMALL
        close = not paths or rtol is not None or cut_short
        if state.steps and rtol is None and state.at.residual.at_vertices < below:
            before = state.at
            state = conformal_steps(state, tol, np.inf if paths else SMALL)
            close = close or state.at is before
        residual = state.at.residual.largest
        if residual <= tol or diverges(state):
            break
        enough = min(largest, max(residual, tol / (2 * residual))) if rtol is None else rtol
        state = step_with_known_factor(state, enough, close=close)
    return state


def diverges(state: State) -> bool:
    """Whether steps that close paths lead away from all solutions."""
    last = [step.residual for step in state.steps[-1 - GROWING :]]
    growing = len(last) > GROWING and all(after > before for before, after in pairwise(last))
    return growing and len(state.problem.constraints.paths) > 0


def _turned(state: State) -> bool:
    """Whether the turning is prescribed along some paths."""
    return any(not np.isnan(path.turning) for path in state.problem.constraints.paths)


def step_with_known_factor(state: State, rtol: float, *, close: bool = False) -> State:
    """A step with the factor that is known, if the last one was not cut short; `close`: also of paths.

    One that the first step began with serves on if that took few inner steps. Where paths turn, a step is cut
    short near cones only. So the factor serves on, unless that step took many inner steps. But on a large
    surface the slivers that it left there are looked for.
    """
    steps = [step for step in state.steps if step.kind != "patches"]
    last = steps[-1] if steps else None
    same = last is None or last.kind != "step" or not last.limited
    if last is not None and _turned(state):
        same = same or last.inner_steps <= FEW_INNER
    if len(steps) == 1:
        same = same and steps[0].inner_steps <= MANY_INNER
    lin = linearise(
        state.problem,
        state.at,
        reuse=state.lin,
        close="all" if close else "none",
        same_factor=same,
        same_slivers=state.problem.constraints.n < LARGE or not _turned(state),
    )
    return _made_up(state.advanced(solve(lin, state.at, rtol), "step"))


def _made_up(state: State) -> State:
    """The state after further steps within patches, where the last one left much at few triangles.

    That is where paths turn and it was cut short. Without paths, it is also where it brought little, unless
    steps are cut short again and again, and the steps within patches have to lead to where corrections begin.
    """
    constraints, (*_, last) = state.problem.constraints, state.steps
    if constraints.paths:
        return eliminate_locally(state) if last.limited and _turned(state) else state
    before = [step for step in state.steps[:-1] if step.kind == "step"]
    resting = before and last.residual > RESTING * before[-1].residual
    often = sum(step.limited > 0 for step in (*before, last)) > MOST_CUT_SHORT
    if not constraints.plain or often or not (last.limited or resting):
        return state
    made = eliminate_locally(state)
    return made if made.at.residual.at_vertices < SMALL else state


def step_from_surface(state: State, surface: FloatArray, rtol: float) -> State:
    """A step that also closes paths, to the angles of least change from those of the `surface`, (3, #F).

    It uses the factor that is known. Where that takes many inner steps, later steps do without it.
    """
    lin = linearise(state.problem, state.at, surface**2, state.lin, same_factor=True)
    direction = solve(lin, state.at, rtol, (state.at.alpha - surface) / surface**2)
    state = _made_up(state.advanced(direction, "step"))
    return state.without_factors() if direction.inner_steps > MANY_INNER else state


def conformal_steps(state: State, tol: float, below: float = SMALL) -> State:
    """Correct the angles, if their residual is small, until it is at most `tol` or that does not help.

    A least-norm step is e = P M^T x with (M P M^T) x = r. Let the cotangent element matrices K stand for P.
    Then M K M^T is diag(L+, L) itself, of which there is a factor: e = K M^T x fulfils the linearised
    constraints after one solve. This e is least in another norm, which does not matter where it is small.

    With a factor that is kept they are the iterations of a fixed point, which some of them foretell
    (Anderson 1965). Where one leaves much at few triangles, steps within patches around these follow.

    Parameters
    ----------
    state : State
        After a step.
    tol : float
        Largest residual.
    below : float
        Residual below which they begin.
    """
    least_norm, conformal = state.lin, None
    least = slow = SLOW_OF_PATHS if len(state.problem.constraints.paths) >= MANY_PATHS else SLOW
    earlier: tuple[Visit, ...] = ()
    gone: FloatArray | float = 0.0  # multipliers so far with the same factor
    if not state.at.residual.largest < below:
        return state
    for _ in range(MAX_CORRECTIONS):
        missing = state.at.residual.largest
        if missing <= tol or state.steps[-1].limited:
            break
        fresh = conformal is None
        if conformal is None:
            conformal, earlier, gone = conformal_system(state), (), 0.0
        if conformal is None:
            break
        made, visit = _corrected(state, conformal, gone, earlier)
        left = made.at.residual.largest / missing
        if left < IN_VAIN and not made.steps[-1].limited:
            state, gone = made, gone + visit.taken
            earlier = (*earlier[1 - REMEMBERED :], visit) if earlier or left > FAST else ()
        elif fresh:
            # it may serve all but the few triangles that it changes most
            made = eliminate_locally(made, FAR * missing) if state.problem.constraints.plain else made
            if made.steps[-1].limited or not made.at.residual.largest < IN_VAIN * missing:
                break
            state, left = made, np.inf
        if fresh:
            slow = min(max(least, STALE * left), IN_VAIN)
        if not left <= slow:
            conformal = None
    return replace(state, lin=least_norm)


def _corrected(
    state: State, conformal: Linearised, gone: FloatArray | float, earlier: Sequence[Visit]
) -> tuple[State, Visit]:
    """The state after a correction with a system of `conformal_system`, and what it went by.

    The errors are linear in the multipliers, as are those that led here: `gone` are their sum so far.
    """
    assert conformal.precondition is not None
    b, holonomy = conformal.problem.constraints.predict(state.at.residual), conformal.holonomy
    rhs = np.column_stack((b.vertex, b.wheel)).ravel()  # after a step, each triangle's angles sum to pi
    if holonomy is not None:
        rhs = np.concatenate((rhs, -holonomy.rows.gap(b.holonomy, b.vertex)))
    with timed("solve"):
        taken = conformal.precondition(rhs)
        reached = gone + taken
        shares = shares_of([visit.missing for visit in earlier], rhs)
        for share, visit in zip(shares, earlier if shares else (), strict=True):
            taken += share * (visit.reached - reached)
    with timed("assembly"):
        direction = exact_direction(errors(conformal, taken, conformal=True), taken, conformal)
    return state.advanced(direction, "conformal"), Visit(rhs, reached, taken)


def conformal_system(state: State) -> Linearised | None:
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
            precondition, _ = conformal_inverse(system, holonomy, inverse.solve)
    except NotPositiveDefiniteError:
        return None
    return replace(lin, system=system, holonomy=holonomy, inverse=inverse, precondition=precondition)
