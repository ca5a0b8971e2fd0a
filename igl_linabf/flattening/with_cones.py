"""A surface with cones: its angles are found before it is cut, and laid out on the cut surface."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .._runtime import stopwatch
from .._types import FloatArray
from ..angles import (
    ROUGH_RTOL,
    ClosedPath,
    State,
    active_set,
    conformal_step,
    constraints_of,
    corrected_steps,
    step_by_same_factor,
)
from ..surface import Mesh, Topology
from .ladder import (
    ACTIVE_SET_RTOL,
    MAX_ACTIVE_SET,
    Candidate,
    Problem,
    Stage,
    Tried,
    anchored,
    climb,
    drawn,
    feasible,
    iterated,
    posed,
)
from .methods import ABF, ABF_TOL, STAGES, LinABF, Method
from .reported import report
from .result import Flattening
from .without_flips import injective_map

SEAM_TOL = 1e-8  # residual of the angles of converged ABF at which the sides of the seams match
MORE_STEPS = 3  # to that


def flatten_with_cones(
    cut: Mesh,
    topology: Topology,
    sums: FloatArray,
    paths: Sequence[ClosedPath],
    quarter: bool,
    method: Method,
) -> Flattening:
    """Flatten a surface with prescribed angle sums.

    Parameters
    ----------
    cut : Mesh
        The surface cut to a disk, along a seam through all vertices whose sum is not 2 pi.
    topology : Topology
        Of the surface before that; its faces are those of `cut`, in the same order.
    sums : (#V,) float64
        Angle sums of its vertices, radians; NaN at the boundary, which is free.
    paths : sequence of ClosedPath
        Along which the scale comes back.
    quarter : bool
        They also turn by multiples of 90 degrees: the nearest ones to what they turn by otherwise.
    method : Method
        Linear ABF or converged ABF.

    Raises
    ------
    ValueError
        Another method.
    """
    if not isinstance(method, LinABF | ABF):
        raise ValueError(f"method is {method.name!r}: cones need one that finds angles, 'linabf' or 'abf'")
    uncut = replace(topology, n_outer=len(topology.loops))  # no loop is a hole that keeps its turning

    with stopwatch(*STAGES) as seconds:
        safeguard = method.safeguard if isinstance(method, LinABF) else True
        asked = constraints_of(uncut, sums, paths)
        problem = posed(cut, None, method.layout, method.threshold, method.solver, safeguard, asked)
        begun = problem.start
        if quarter and paths:
            problem, begun = _in_quarters(problem)
        return report(problem, method.name, climb(problem, _stages(method, begun)), seconds)


def _in_quarters(problem: Problem) -> tuple[Problem, State]:
    """The problem with turnings in multiples of 90 degrees along its paths, and a state to go on from.

    They are the nearest ones to what the paths turn by after the first step. What is missing to them is
    spread over all triangles, too smoothly for conjugate gradients: the next step is in the conformal metric.
    """
    state = step_by_same_factor(problem.start, ROUGH_RTOL)
    alpha, asked = state.at.alpha, problem.angles.constraints
    turning = [path.size * np.pi - alpha.ravel()[path.corner].sum() for path in asked.paths]
    quarters = np.round(np.array(turning) / (np.pi / 2)) * (np.pi / 2)
    paths = [replace(path, turning=float(q)) for path, q in zip(asked.paths, quarters, strict=True)]
    angles = replace(problem.angles, constraints=replace(asked, paths=tuple(paths)))
    turned = State(angles, angles.at(alpha), state.steps, state.lin)
    return replace(problem, angles=angles), conformal_step(turned)


def _stages(method: LinABF | ABF, begun: State) -> list[Stage]:
    if isinstance(method, LinABF) and method.iterations != "auto":
        stages = [iterated(method.rtol or ACTIVE_SET_RTOL, method.tol, method.iterations)]
    else:
        first, tols = list[Stage](), [method.tol]
        if isinstance(method, LinABF):
            first, tols = [_exact(begun, method.rtol, method.tol)], [ABF_TOL, method.tol]
        stages = [*first, *(_settled(make(*tols), method.tol) for make in (anchored, feasible))]
    return [*stages, injective_map] if method.guarantee else stages


def _exact(begun: State, rtol: float | None, tol: float) -> Stage:
    """Active-set iterations until both sides of the seam agree."""

    def stage(problem: Problem, tried: Tried) -> Candidate:
        state = corrected_steps(begun, rtol, tol, MAX_ACTIVE_SET)
        reached = state.at.residual.largest <= tol
        note = "" if reached else f"the iterations did not converge within {MAX_ACTIVE_SET} steps"
        return drawn(problem, "active set", state, converged=reached, note=note)

    return stage


def _settled(stage: Stage, tol: float) -> Stage:
    """A stage, and then active-set steps from where it ends until both sides of the seam agree."""

    def settled(problem: Problem, tried: Tried) -> Candidate | None:
        made = stage(problem, tried)
        if made is None or made.layout is None or made.state.at.residual.largest <= SEAM_TOL:
            return made
        state = active_set(made.state, ACTIVE_SET_RTOL, SEAM_TOL, MORE_STEPS)
        converged = made.converged and state.at.residual.largest <= tol
        exact = drawn(problem, made.stage, state, converged=converged, note=made.note, remark=made.remark)
        return made if len(exact.flipped) > len(made.flipped) else exact

    return settled
