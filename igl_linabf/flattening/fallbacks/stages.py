"""The stages of linear and converged ABF. Each stage starts from the results of earlier stages.

The first two parameters of each function are those of a `Stage`; `functools.partial` sets all others.
"""

import warnings
from dataclasses import replace

import numpy as np

from ..._runtime import advance, time_stage
from ...angles import (
    AbfResult,
    Iterate,
    converge,
    converge_feasibly,
    iterate_to_prescribed_sums,
    iterate_with_corrections,
    run_active_set,
    take_linear_step,
    take_step_and_chord,
)
from ...errors import FallbackWarning, SingularSystemError, first_few, format_count, stack_level
from ...layouts import MAX_BOUNDARY_GAP, Boundary, LayoutOptions, develop_boundary, lay_out
from ...surface import find_chords, find_flipped_faces
from ..boundary_shapes import SPLIT_CHORDS_HINT
from ..constants import BOUNDARY_TOL
from ..result import StageName, Status
from .attempts import Problem, Stage, StageResult, StageResults

LARGEST_HOLE_GAP = 0.1  # maximum relative closure error of the loop of a hole after the linear step
# Relative residual of the solves for the linear step, its chord step, and steps to circles.
STEP_AND_CHORD_RTOL = 0.1
ACTIVE_SET_RTOL = 0.01  # relative residual of the solves for steps of the active set
CONTINUED_RTOL = 0.03  # maximum relative residual of the solves for steps before conformal corrections
MAX_ACTIVE_SET_STEPS = 12
MAX_STEPS_TO_SUMS = 25  # steps to prescribed angle sums are given up after this number of steps

NO_ABF_MAP = "converged ABF has no map in double precision: this is the map of linear ABF"


def add_layout(problem: Problem, made: StageResult, boundary: Boundary | None = None) -> StageResult:
    """Lay out the angles of a result. `boundary` is the outer loop laid out from these angles, or None."""
    mesh, angles, at, lin = problem.mesh, problem.angles, made.state.at, made.state.lin
    cut = problem.own is not angles.constraints
    with time_stage("layout"):
        alpha, invalid = at.alpha, angles.mask_invalid_triangles(at)
        if invalid.any():
            warnings.warn(
                f"the target angles of faces {first_few(np.flatnonzero(invalid))} are not within (0, pi): "
                "the layout uses their initial angles instead",
                FallbackWarning,
                stacklevel=stack_level(),
            )
            alpha = np.where(invalid, np.pi * angles.estimate / angles.estimate.sum(axis=0), alpha)
        same = not cut and not invalid.any()
        try:
            layout = lay_out(
                problem.own,
                at if same else Iterate.from_angles(problem.own, alpha),
                LayoutOptions(problem.layout, problem.pinned, mesh.area, problem.shape.corners[:2]),
                angles.solvers,
                None if lin is None or cut else lin.laplacian,
                boundary if same else None,
            )
        except SingularSystemError as error:
            if problem.layout != "auto":  # an explicitly requested layout is not replaced
                raise
            return StageResult(made.stage, made.state, Status.SINGULAR, str(error))
    advance("layout", 0.5)
    flipped = find_flipped_faces(layout.z, mesh.topology.corner)
    flips = len(flipped)
    status, detail = Status.GOOD, ""
    if flips:
        status, detail = Status.FLIPPED, f"{format_count(flips, 'flipped triangle')}"
    return replace(made, status=status, detail=detail, layout=layout, flipped=flipped)


def solve_one_system(problem: Problem, earlier: StageResults, rtol: float | None, tol: float) -> StageResult:
    """Take the linear step, followed by its chord step, or by another linear step on meshes with holes.

    Both steps are solved to the relative residual `rtol`, 0.1 by default.
    """
    enough = rtol or STEP_AND_CHORD_RTOL
    state, holes = problem.initial_state, len(problem.mesh.topology.loops) > 1
    boundary: Boundary | None = None
    if state.at.residual.max_magnitude > tol:
        if not holes:
            state = take_step_and_chord(state, enough, tol).state
        else:
            state = take_linear_step(state, enough, close=False, first_rtol=enough**2)
            if not state.steps[-1].limited:  # a limited step ends this stage
                state = take_linear_step(state, enough, same_factor=True)
        if state.steps and not state.steps[0].limited:
            if holes:
                gap, allowed = float(np.abs(state.at.residual.holonomy.gap).max()), LARGEST_HOLE_GAP
            else:
                boundary = develop_boundary(problem.angles.constraints, state.at.residual)
                gap, allowed = float(boundary.gaps.max()), MAX_BOUNDARY_GAP
            state = state.without_factors()
            if gap > allowed:
                detail = f"a boundary loop fails to close by {gap:.1%} of its length"
                return StageResult("linear step", state, Status.OPEN_LOOP, detail)
        if state.steps and (limited := state.steps[-1].limited):
            detail = (
                f"a full step would make an angle of {format_count(limited, 'triangle')} zero or negative"
            )
            return StageResult("linear step", state.without_factors(), Status.CUT_SHORT, detail)
    reached = state.at.residual.max_magnitude <= tol
    return add_layout(problem, StageResult("linear step", state, converged=reached), boundary)


def iterate_active_set(
    problem: Problem, earlier: StageResults, rtol: float, tol: float, max_steps: int
) -> StageResult:
    """Take active-set steps from the initial estimate (section 6 of the paper)."""
    state = run_active_set(problem.initial_state, rtol, tol, max_steps).without_factors()
    name: StageName = "active set" if len(state.steps) > 1 else "linear step"
    return add_layout(problem, StageResult(name, state, converged=state.at.residual.max_magnitude <= tol))


def continue_active_set(
    problem: Problem, earlier: StageResults, rtol: float | None, tol: float
) -> StageResult:
    """Continue from the angles of the last stage by active-set steps.

    With the safeguard, conformal corrections reduce small residuals, unless `rtol` is given.
    """
    state, most = earlier[-1].state, MAX_ACTIVE_SET_STEPS
    if problem.angles.safeguard:
        state = iterate_with_corrections(state, rtol, tol, most, CONTINUED_RTOL)
    else:
        state = run_active_set(state, rtol or ACTIVE_SET_RTOL, tol, most)
    state = state.without_factors()
    reached = state.at.residual.max_magnitude <= tol
    failed = f"the iterations did not converge within {most} steps"
    note = "further iterations flip more triangles" if reached else failed
    return add_layout(problem, StageResult("active set", state, converged=reached, note=note))


def reach_prescribed_sums(problem: Problem, earlier: StageResults, rtol: float, tol: float) -> StageResult:
    """Take steps to the angle sums that are prescribed at the boundary."""
    # the outer loop is always laid out on its circle, but the loops of holes need a smaller residual
    enough = {"circle": max(tol, BOUNDARY_TOL), "circles": tol / 10}.get(problem.shape.name, tol)
    state = iterate_to_prescribed_sums(
        problem.initial_state, rtol, enough, MAX_STEPS_TO_SUMS
    ).without_factors()
    reached = state.at.residual.max_magnitude <= enough
    note = "" if reached else f"the iterations did not converge within {MAX_STEPS_TO_SUMS} steps"
    whole = problem.mesh if problem.ears is None else problem.ears.whole
    if not reached and len(chords := find_chords(whole.topology)):
        across = format_count(len(chords), "edge")
        note += f" with {across} across, between boundary vertices: {SPLIT_CHORDS_HINT}"
    return add_layout(problem, StageResult("active set", state, converged=reached, note=note))


def run_anchored_abf(
    problem: Problem, earlier: StageResults, tol: float, residual_tol: float = 0.0, largest: float = np.inf
) -> StageResult | None:
    """Run converged ABF by anchored steps; return None for meshes with more than `largest` triangles."""
    if not problem.angles.safeguard or len(problem.mesh.double_area) > largest:
        return None
    result = converge(earlier[-1].state.reset_to_estimate() if earlier else problem.initial_state, tol)
    if not result.converged:
        failed = "the iterations do not converge"
        return StageResult("converged abf", result.state, Status.DIVERGED, failed)
    return _add_abf_layout(problem, "converged abf", result, residual_tol)


def run_feasible_abf(
    problem: Problem, earlier: StageResults, tol: float, residual_tol: float = 0.0
) -> StageResult | None:
    """Run converged ABF in its feasible form if anchored steps diverged."""
    # do not run if angles have converged: flips of their maps are due to rounding
    if earlier[-1].status is not Status.DIVERGED or any(made.converged for made in earlier):
        return None
    state = earlier[-1].state
    try:
        result = converge_feasibly(state, tol)
    except SingularSystemError as error:
        return StageResult("feasible abf", state, Status.SINGULAR, str(error))
    return _add_abf_layout(problem, "feasible abf", result, residual_tol)


def fall_back_to_linear(problem: Problem, earlier: StageResults, linear: Stage) -> StageResult | None:
    """Run a stage of linear ABF if no stage of converged ABF has found a map in double precision.

    Prescribed angle sums can flatten triangles so much that the system at the minimum is singular. Linear ABF
    also ends near the minimum, but at angles that can be laid out.
    """
    if any(made.layout is not None for made in earlier):
        return None
    made = linear(problem, earlier)
    return None if made is None else replace(made, converged=False, note=NO_ABF_MAP)


def _add_abf_layout(
    problem: Problem, stage: StageName, result: AbfResult, residual_tol: float
) -> StageResult:
    """Lay out the angles of converged ABF, with a remark on angles fixed at their bounds."""
    held = np.flatnonzero(result.held.any(axis=0))
    remark = f"; some angles of faces {first_few(held)} are held at a hundredth of their initial value"
    made = StageResult(
        stage,
        result.state,
        converged=result.converged or result.state.at.residual.max_magnitude <= residual_tol,
        note="converged ABF did not converge in its feasible form",
        remark=remark if len(held) else "",
    )
    return add_layout(problem, made)
