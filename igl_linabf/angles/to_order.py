"""Steps to angle sums that are prescribed at the boundary."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .._types import FloatArray, IntArray
from .iterates import Iterate
from .iterations import State, chord_step
from .last_steps import conformal_steps, conformal_system, corrected
from .linearised import linearise, solve

FIRST_RTOL = 0.1  # relative residual to which the first step towards prescribed sums is solved
CHORD_BELOW = 3e-2  # residual below which corrections in the conformal metric end the steps to circles
CIRCLE_CHORD_BELOW = 0.1  # and to one circle
HELPS = 0.5  # share of the residual down to which a correction that is cut short has to bring it
SLOW = 30  # inner steps from which a new factor pays
MEMORY, MIX_BELOW = 5, 0.1  # of the circle's extrapolation: earlier steps, residual from which on


def prescribed_steps(state: State, rtol: float, tol: float, most: int) -> State:
    """Steps until the residual is at most `tol`, for sums prescribed at the boundary.

    These change angles more than a free boundary does, and more steps are needed. So the steps keep
    the first one's factor as the preconditioner, and end in corrections in the conformal metric. The sums of
    circles depend on the present lengths; they are extrapolated from those of the last steps (Anderson
    1965). A correction that cuts angles short, at ears, and gains little is followed by a step.
    """
    constraints = state.problem.constraints
    if len(constraints.circles) > 1:  # lengths around a hole mean little before its loop closes
        fixed = replace(state.problem, constraints=replace(constraints, circles=()))
        closed = prescribed_steps(State(fixed, fixed.at(state.at.alpha), state.steps), rtol, MIX_BELOW, most)
        state = State(state.problem, state.problem.at(closed.at.alpha), closed.steps, closed.lin)
    on_circles = [constraints.row[constraints.topology.loops[i]] for i in constraints.circles]
    rows = np.concatenate(on_circles) if on_circles else np.empty(0, dtype=np.int64)
    sought = _Sought(rows[rows >= 0])
    one, stuck, conformal = len(constraints.circles) == 1, False, None
    for _ in range(most):
        if state.steps and not len(sought.rows):
            state = conformal_steps(state, tol)
        missing = state.at.residual.largest
        if missing <= tol:
            break
        first, cut_short = not state.steps, bool(state.steps) and state.steps[-1].limited > 0
        small = missing < CIRCLE_CHORD_BELOW if one else missing < CHORD_BELOW and not cut_short
        sought, towards = sought.extrapolated(state)
        here, made = replace(state, at=towards), None
        if len(state.steps) > 1 and small and not stuck:
            conformal = conformal or conformal_system(state)
            made = state if conformal is None else corrected(here, conformal)
            left = made.at.residual.largest / missing
            stuck = left >= HELPS and made.steps[-1].limited > 0
            if left >= 1:
                made = None if cut_short else chord_step(here, rtol)
        if made is not None:
            state = replace(made, lin=state.lin)
        else:
            slow, stuck = not first and state.steps[-1].inner_steps >= SLOW, False
            lin = linearise(
                state.problem,
                towards,
                reuse=state.lin,
                close=not first,
                same_factor=not (first or slow),
                same_slivers=False,
            )
            state = here.advanced(solve(lin, towards, FIRST_RTOL if first else rtol), "step")
    return state


@dataclass(frozen=True, eq=False)
class _Sought:
    """The sums of circles that the last steps reached, and those that their lengths then asked for.

    Attributes
    ----------
    rows : (#c,) int64
        The rows of vertices on circles.
    reached, missing : tuple of (#c,) float64
    """

    rows: IntArray
    reached: tuple[FloatArray, ...] = ()
    missing: tuple[FloatArray, ...] = ()

    def extrapolated(self, state: State) -> tuple[_Sought, Iterate]:
        """These with the present ones, and the present angles with the sums to go to."""
        b, constraints = state.at.residual, state.problem.constraints
        usable = bool(state.steps) and b.largest < MIX_BELOW
        if not (len(self.rows) and usable):
            return self, state.at
        missing = b.vertex[self.rows]
        total = constraints.sum_at_rows(np.pi - b.turning)[self.rows]
        known = _Sought(self.rows, (*self.reached[-MEMORY:], total), (*self.missing[-MEMORY:], missing))
        if len(known.missing) == 1:
            return known, state.at
        change = np.diff(np.array(known.missing), axis=0).T
        along = np.diff(np.array(known.reached), axis=0).T + change
        share = np.linalg.lstsq(change, missing, rcond=1e-6)[0]
        vertex = b.vertex.copy()
        vertex[self.rows] -= along @ share
        return known, replace(state.at, residual=replace(b, vertex=vertex))
