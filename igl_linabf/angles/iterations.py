"""Steps one after the other: the chord, and the paper's active-set iterations (section 6)."""

from __future__ import annotations

from dataclasses import dataclass, replace

from .linearised import AngleProblem, Direction, Iterate, Kind, Linearised, Step, advance, linearise, solve


@dataclass(frozen=True, eq=False)
class State:
    """How far the angles have come.

    Attributes
    ----------
    problem : AngleProblem
    at : Iterate
    steps : tuple of Step
        The linear solves so far.
    lin : Linearised or None
        The last system, whose analyses the next one keeps.
    """

    problem: AngleProblem
    at: Iterate
    steps: tuple[Step, ...] = ()
    lin: Linearised | None = None

    @property
    def how(self) -> str:
        """What solved the last system."""
        return "none" if self.lin is None else self.lin.how

    def back_to_start(self) -> State:
        """At the initial estimate again, with what was analysed so far."""
        return replace(self, at=self.problem.start)

    def advanced(self, direction: Direction, kind: Kind) -> State:
        """A direction further."""
        at, step = advance(self.problem, self.at, direction, kind)
        return State(self.problem, at, (*self.steps, step), direction.lin)


def linear_step(state: State, rtol: float, *, close: bool = True) -> State:
    """One step, the system taken at the present angles; `close` says whether holes' loops are closed."""
    lin = linearise(state.problem, state.at, reuse=state.lin, close=close)
    return state.advanced(solve(lin, state.at, rtol), "step")


def chord_step(state: State, rtol: float) -> State:
    """Another step with the last system: nothing is assembled or factored."""
    assert state.lin is not None
    return state.advanced(solve(state.lin, state.at, rtol), "chord")


def active_set(state: State, rtol: float, tol: float, most: int) -> State:
    """Steps from the present angles on, each with the system there, until the residual is `tol` (section 6).

    The first step of all makes the loops of holes turn once and end at the scale at which they begin; the
    later ones close them, too.
    """
    for _ in range(most):
        if state.at.residual.largest <= tol or state.problem.invalid(state.at).any():
            break
        state = linear_step(state, rtol, close=bool(state.steps))
    return state
