"""Sequences of steps: the chord, the paper's active-set iterations (section 6)."""

from __future__ import annotations

from dataclasses import dataclass, replace

from .iterates import AngleProblem, Iterate, Kind, Step
from .linearised import Direction, Linearised, advance, linearise, solve
from .reduced import FINE

MOST_OF_FINE = 12  # inner steps of a fine mesh's chord: ten more change F/3nt by less than a hundredth


@dataclass(frozen=True, eq=False)
class State:
    """The present angles and the steps so far.

    Attributes
    ----------
    problem : AngleProblem
    at : Iterate
    steps : tuple of Step
        The linear solves so far.
    lin : Linearised or None
        The last system; the next one reuses its analyses.
    """

    problem: AngleProblem
    at: Iterate
    steps: tuple[Step, ...] = ()
    lin: Linearised | None = None

    @property
    def how(self) -> str:
        """Name of the solver of the last system."""
        return "none" if self.lin is None else self.lin.how

    def at_rest(self) -> State:
        """The same state with the analyses, but without the factors, which take most of the memory."""
        return self if self.lin is None else replace(self, lin=self.lin.without_factors)

    def back_to_start(self) -> State:
        """The state at the initial estimate, with the steps and analyses so far."""
        return replace(self, at=self.problem.start)

    def advanced(self, direction: Direction, kind: Kind) -> State:
        """The state after a step along a direction."""
        at, step = advance(self.problem, self.at, direction, kind)
        return State(self.problem, at, (*self.steps, step), direction.lin)


def linear_step(
    state: State,
    rtol: float,
    *,
    close: bool = True,
    same_factor: bool = False,
    first_rtol: float | None = None,
) -> State:
    """One step with the system at the present angles; with `close` it also closes the holes' loops.

    With `same_factor`, the factor of the last system is the preconditioner. `first_rtol` as of `solve`.
    """
    lin = linearise(state.problem, state.at, reuse=state.lin, close=close, same_factor=same_factor)
    return state.advanced(solve(lin, state.at, rtol, first_rtol=first_rtol), "step")


def chord_step(state: State, rtol: float, *, quick: bool = False) -> State:
    """Another step with the last system, without assembly or factorisation.

    With `quick`, it ends early on a fine mesh, where thin regions let conjugate gradients creep.
    """
    assert state.lin is not None
    most = MOST_OF_FINE if quick and state.problem.constraints.n >= FINE else None
    return state.advanced(solve(state.lin, state.at, rtol, most=most), "chord")


def active_set(state: State, rtol: float, tol: float, most: int) -> State:
    """Steps, each with the system at the present angles, until the residual is at most `tol` (section 6).

    The very first step makes the loops of holes turn once and end at the scale at which they begin. The
    later steps also close them.
    """
    for _ in range(most):
        if state.at.residual.largest <= tol or state.problem.invalid(state.at).any():
            break
        state = linear_step(state, rtol, close=bool(state.steps))
    return state
