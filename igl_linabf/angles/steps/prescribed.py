"""Steps to angle sums that are prescribed at the boundary."""

from __future__ import annotations

from dataclasses import replace

from .conformal_corrections import correct_conformally
from .constants import CORRECTABLE, CORRECTABLE_PRESCRIBED, LOOPS_CLOSED, MANY_INNER_STEPS, ROUGH_RTOL
from .iterations import State
from .linearisation import linearise, solve


def iterate_to_prescribed_sums(state: State, rtol: float, tol: float, most: int) -> State:
    """Steps until the residual is at most `tol`, for sums prescribed at the boundary.

    These change angles more than a free boundary does, so there are more steps. They keep the first one's
    factor as the preconditioner, and end in conformal corrections. The sums of circles depend on the present
    lengths, and each step is to those that are predicted.
    """
    constraints = state.problem.constraints
    if len(constraints.circles) > 1:  # lengths around a hole mean little before its loop closes
        fixed = replace(state.problem, constraints=replace(constraints, circles=()))
        closed = iterate_to_prescribed_sums(
            State(fixed, fixed.at(state.at.alpha), state.steps), LOOPS_CLOSED, LOOPS_CLOSED, most
        )
        state = State(state.problem, state.problem.at(closed.at.alpha), closed.steps, closed.lin)
    for _ in range(most):
        if state.steps:
            early = constraints.circles or len(state.steps) > 1
            state = correct_conformally(state, tol, CORRECTABLE_PRESCRIBED if early else CORRECTABLE)
        if state.at.residual.largest <= tol:
            break
        first = not state.steps
        slow = not first and state.steps[-1].inner_steps >= MANY_INNER_STEPS
        at = state.at if first else replace(state.at, residual=constraints.predict(state.at.residual))
        lin = linearise(
            state.problem,
            at,
            reuse=state.lin,
            close="paths" if first else "all",
            same_factor=not (first or slow),
            same_slivers=False,
        )
        state = state.advanced(solve(lin, at, ROUGH_RTOL if first else rtol), "step")
    return state
