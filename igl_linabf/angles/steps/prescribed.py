"""Take steps to angle sums that are prescribed at the boundary."""

from __future__ import annotations

from dataclasses import replace

from .conformal_corrections import correct_conformally
from .constants import CORRECTABLE, CORRECTABLE_PRESCRIBED, ROUGH_RTOL
from .iterations import State
from .linearisation import linearise, solve_for_errors

CLOSED_LOOP_RESIDUAL = 0.3  # edge lengths around holes are meaningful below this residual
MANY_INNER_STEPS = 30  # compute a new factor after a step with at least this many inner steps


def iterate_to_prescribed_sums(state: State, rtol: float, tol: float, most: int) -> State:
    """Take steps to the angle sums prescribed at the boundary, until the residual is at most `tol`.

    Prescribed sums change the angles more than a free boundary does, and therefore need more steps. The steps
    use the factor of the first step as the preconditioner, and end in conformal corrections. The angle sums
    on circles depend on the current edge lengths. Therefore, each step aims at the predicted sums.
    """
    constraints = state.problem.constraints
    # close the loops of holes first, because the sums on their circles depend on edge lengths
    if len(constraints.circles) > 1:
        fixed = replace(state.problem, constraints=replace(constraints, circles=()))
        closed = iterate_to_prescribed_sums(
            State(fixed, fixed.evaluate(state.at.alpha), state.steps),
            CLOSED_LOOP_RESIDUAL,
            CLOSED_LOOP_RESIDUAL,
            most,
        )
        state = State(state.problem, state.problem.evaluate(closed.at.alpha), closed.steps, closed.lin)
    for _ in range(most):
        if state.steps:
            early = constraints.circles or len(state.steps) > 1
            state = correct_conformally(state, tol, CORRECTABLE_PRESCRIBED if early else CORRECTABLE)
        if state.at.residual.max_magnitude <= tol:
            break
        first = not state.steps
        slow = not first and state.steps[-1].inner_steps >= MANY_INNER_STEPS
        at = (
            state.at if first else replace(state.at, residual=constraints.predict_residual(state.at.residual))
        )
        lin = linearise(
            state.problem,
            at,
            reuse=state.lin,
            close="paths" if first else "all",
            same_factor=not (first or slow),
            same_slivers=False,
        )
        state = state.take_step(solve_for_errors(lin, at, ROUGH_RTOL if first else rtol), "step")
    return state
