"""Sequences of steps: a linear step followed by a chord step, and the active-set iteration of the paper."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..._runtime import time_stage
from ..._types import BoolArray, FloatArray, IntArray
from .iterates import AngleProblem, Iterate, Kind, Step
from .linearisation import Closed, Direction, Linearisation, apply_direction, linearise, solve_for_errors

KINDS: tuple[Kind, Kind] = "step", "chord"


@dataclass(frozen=True, eq=False)
class State:
    """The current angles and the steps that led to them.

    Attributes
    ----------
    problem : AngleProblem
    at : Iterate
    steps : tuple of Step
        All linear solves in order.
    lin : Linearisation or None
        The last linear system, whose symbolic analyses the next system reuses.
    """

    problem: AngleProblem
    at: Iterate
    steps: tuple[Step, ...] = ()
    lin: Linearisation | None = None

    @property
    def solver_name(self) -> str:
        """Name of the solver of the last linear system."""
        return "none" if self.lin is None else self.lin.solver_name

    def without_factors(self) -> State:
        """Return the state without factors, which take most of the memory, but with all symbolic analyses."""
        return self if self.lin is None else replace(self, lin=replace(self.lin.without_matrix, inverse=None))

    def reset_to_estimate(self) -> State:
        """Return the state at the initial estimate, with all steps and symbolic analyses."""
        return replace(self, at=self.problem.initial_iterate)

    def take_step(self, direction: Direction, kind: Kind) -> State:
        """Return the state after a step along a direction."""
        at, step, _ = apply_direction(self.problem, self.at, direction, kind)
        return State(self.problem, at, (*self.steps, step), direction.lin)


def take_linear_step(
    state: State,
    rtol: float,
    *,
    close: bool = True,
    same_factor: bool = False,
    first_rtol: float | None = None,
) -> State:
    """Take one step with the system at the current angles.

    With `close`, the step also closes the loops of holes. With `same_factor`, the factor of the last system
    preconditions the new one. `first_rtol` is passed to `solve_for_errors`.
    """
    closed: Closed = "all" if close else "paths"
    lin = linearise(state.problem, state.at, reuse=state.lin, close=closed, same_factor=same_factor)
    return state.take_step(solve_for_errors(lin, state.at, rtol, first_rtol=first_rtol), "step")


@dataclass(frozen=True, eq=False)
class StepAndChord:
    """The angles of several disks, solved in one system, after the linear step and the chord step.

    Attributes
    ----------
    state : State
        All disks, after the last solve.
    good : (#disks,) bool
        Whether the solver converged for the disk, and no step of any of its triangles was limited.
    inner_steps : (2, #disks) int64
        Numbers of conjugate gradient steps in the linear step and in the chord step.
    residuals : (3, 3, #disks) float64
        Results of `DiskRanges.residuals` at the start, after the linear step, and after the chord step.
    """

    state: State
    good: BoolArray
    inner_steps: IntArray
    residuals: FloatArray


def take_step_and_chord(start: State, rtol: float, tol: float) -> StepAndChord:
    """Take a linear step and a chord step for each disk with a residual above `tol`.

    The chord step is a second solve with the same system, without assembly or factorisation: a simplified
    Newton step. Both are solved to the relative residual `rtol`. On a nearly developable surface, a single
    inner step may reach `rtol` and leave most of the distortion. Therefore a single inner step has to reach
    `rtol` squared. A limited step is not followed by a chord step, which would lead to far smaller angles
    than another linear step.

    Raises
    ------
    NotPositiveDefiniteError, SingularSystemError
        The system of one of several disks is singular in double precision.
    """
    problem, state = start.problem, start
    disks = problem.disks
    residuals = [disks.residuals(start.at.residual)]
    moving = residuals[0].max(axis=0) > tol
    good = ~moving | (disks.rows.sizes > 0)
    inner_steps = np.zeros((2, len(good)), dtype=np.int64)
    if (moving & good).any():
        lin = linearise(problem, start.at, reuse=start.lin, close="paths")
        for k, kind in enumerate(KINDS):
            first_rtol = rtol**2 if kind == "step" else None
            direction = solve_for_errors(lin, state.at, rtol, first_rtol=first_rtol)
            if not moving.all():
                direction = replace(direction, e=direction.e * disks.faces.repeat(np.where(moving, 1.0, 0.0)))
            lin, inner_steps[k] = direction.lin, direction.each
            at, step, limited = apply_direction(problem, state.at, direction, kind)
            state = State(problem, at, (*state.steps, step), lin)
            with time_stage("assembly"):
                good &= ~moving | (direction.converged & ~disks.faces.any(limited))
                residuals.append(disks.residuals(at.residual))
            if not (moving & good).any():
                break
    residuals += residuals[-1:] * (3 - len(residuals))
    return StepAndChord(state, good, inner_steps, np.array(residuals))


def run_active_set(state: State, rtol: float, tol: float, most: int) -> State:
    """Take active-set steps (section 6 of the paper) until the residual is at most `tol`.

    Each step solves the linear system at the current angles.

    The first step only makes the loops of holes turn by -2 pi and return to their scale. Later steps also
    close the loops.
    """
    for _ in range(most):
        if state.at.residual.max_magnitude <= tol or state.problem.mask_invalid_triangles(state.at).any():
            break
        state = take_linear_step(state, rtol, close=bool(state.steps))
    return state
