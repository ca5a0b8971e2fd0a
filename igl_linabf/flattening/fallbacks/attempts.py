"""Fallbacks: stages of increasing cost, tried until a map has no flipped triangle.

A stage takes the problem and the candidates so far, and returns a `Candidate`. `climb` stops at the first
good one. The result is the candidate with the fewest flipped triangles.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..._runtime import advance, timed
from ..._types import IntArray
from ...angles import (
    CAP_ANGLE,
    AbfResult,
    AngleProblem,
    Constraints,
    Iterate,
    State,
    active_set,
    constraints_of,
    converge,
    converge_feasibly,
    corner_angles,
    initial_estimate,
    iterate_to_prescribed_sums,
    iterate_with_corrections,
    linear_step,
    open_caps,
    step_and_chord,
)
from ...errors import FallbackWarning, MeshWarning, SingularSystemError, some, stack_level
from ...layouts import GAP, Boundary, Layout, LayoutName, check_pins, develop_boundary, lay_out
from ...linalg import SolverName, Solvers, check_memory, factor_bytes
from ...surface import Mesh, Pins, area_scale_ratio, chords_of, flipped_faces, shape_is_pinned
from ..boundary_shapes import FREE, HELP, Shape, shape_of
from ..result import Attempt, StageName, Status
from .ears import Ears
from .plane_abf import converge_in_plane

ONE_SYSTEM_RTOL = 0.1  # relative residual to which "auto" solves a step and its chord
ACTIVE_SET_RTOL = 0.01  # relative residual to which a step without a chord is solved
CONTINUED_RTOL = 0.03  # and one that corrections follow
MAX_ACTIVE_SET = 12  # re-anchored iterations after which "auto" gives up
MAX_PRESCRIBED = 25  # steps to prescribed sums after which converged ABF takes over
ON_CIRCLE = 1e-6  # residual at which the steps to a circle end; the loop is on it to all digits
HOLE_GAP = 0.1  # relative gap of a hole's loop up to which "auto" leaves it to the least squares
FEW_DIGITS = 1e28  # span of areas above which fewer than two digits are left of some lengths
NO_FACES = np.empty(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Problem:
    """A checked mesh, and the initial estimate of its angles.

    Attributes
    ----------
    mesh : Mesh
    pinned : Pins or None
    layout : str
        How angles become coordinates.
    angles : AngleProblem
        With the initial estimate.
    repaired : (#caps,) int64
        Faces with an angle so close to pi that it was changed before flattening.
    cut : Constraints or None
        Of `mesh`, where the angles are those of the surface that `mesh` was cut from.
    shape : Shape
        What is asked of the boundary.
    ears : Ears or None
        Those that `mesh` is without.
    """

    mesh: Mesh
    pinned: Pins | None
    layout: LayoutName
    angles: AngleProblem
    repaired: IntArray
    cut: Constraints | None = None
    shape: Shape = FREE
    ears: Ears | None = None

    @property
    def start(self) -> State:
        """The state at the initial estimate."""
        return State(self.angles, self.angles.start)


@dataclass(frozen=True, eq=False)
class Candidate:
    """Result of a stage.

    Attributes
    ----------
    stage : str
    status : Status
    detail : str
        The status in words; "" if it is good.
    state : State
        Its angles, and all steps so far.
    converged : bool
        Whether its angles satisfy the constraints to the method's tolerance.
    note : str
        Why the iterations did not help, for the message.
    remark : str
        A further remark on the map, for the message.
    layout : Layout or None
        None if the stage stopped before its layout.
    flipped : (#flips,) int64
    """

    stage: StageName
    status: Status
    detail: str
    state: State
    converged: bool = False
    note: str = ""
    remark: str = ""
    layout: Layout | None = None
    flipped: IntArray = field(default_factory=lambda: NO_FACES)

    @property
    def summary(self) -> Attempt:
        """Its summary in the result."""
        flips = None if self.layout is None else len(self.flipped)
        return Attempt(self.stage, self.status, flips, self.state.at.residual.largest, self.detail)


Tried = tuple[Candidate, ...]
Stage = Callable[[Problem, Tried], Candidate | None]


def posed(
    mesh: Mesh,
    pinned: Pins | None,
    layout: LayoutName,
    threshold: float,
    solver: SolverName,
    safeguard: bool = True,
    uncut: Constraints | None = None,
    shape: Shape = FREE,
) -> Problem:
    """The problem at its initial estimate (section 4.2).

    `uncut` are the constraints of the surface that the mesh was cut from, if its angles are to be found.

    Raises
    ------
    MemoryLimitError
        The mesh would not fit into memory.

    Warns
    -----
    MeshWarning
        Some faces have an angle too near pi.
    """
    solvers, ears = Solvers(solver), None
    with timed("estimate"):
        check_pins(layout, pinned)
        if shape.circles:
            ears = Ears.of(mesh, pinned)
        if ears is not None:
            mesh, pinned = ears.rest, None
            shape = shape_of(mesh, shape.name, None)
        held = shape_is_pinned(pinned)
        least_squares = layout == "least-squares" or len(mesh.topology.loops) > 1 or held
        check_memory(len(mesh.double_area), factor_bytes(mesh.topology.n, 2) if least_squares else 0)
    with timed("assembly"):
        own = constraints_of(mesh.topology, shape.sums, circles=shape.circles)
        asked = own if uncut is None else uncut
    with timed("estimate"):
        alpha, caps = open_caps(corner_angles(mesh))
        if len(caps):
            caps = caps if ears is None else ears.faces[caps]
            warnings.warn(
                f"faces {some(caps)} have an angle within {CAP_ANGLE:g} rad of pi: that angle is changed to "
                f"pi - {CAP_ANGLE:g} before flattening; collapse these faces, or flip their longest edges",
                MeshWarning,
                stacklevel=stack_level(),
            )
    with timed("assembly"):
        estimate = initial_estimate(asked.topology, alpha, threshold, safeguard, asked.sums)
        angles = AngleProblem(asked, estimate, solvers, safeguard)
        return Problem(mesh, pinned, layout, angles, caps, None if uncut is None else own, shape, ears)


def climb(problem: Problem, stages: Sequence[Stage]) -> Tried:
    """Run the stages in order until one is good; return all candidates."""
    tried: Tried = ()
    for stage in stages:
        made = stage(problem, tried)
        if made is not None:
            tried = (*tried, made)
            if made.status is Status.GOOD:
                break
    return tried


def best_of(tried: Tried) -> tuple[Candidate, Layout]:
    """The map with the fewest flips; among equals the latest, which has the smallest residual.

    Raises
    ------
    SingularSystemError
        There is none.
    """
    best: tuple[Candidate, Layout] | None = None
    for made in tried:
        if made.layout is not None and (best is None or len(made.flipped) <= len(best[0].flipped)):
            best = made, made.layout
    if best is None:
        raise SingularSystemError(tried[-1].detail)
    return best


def drawn(
    problem: Problem,
    stage: StageName,
    state: State,
    *,
    converged: bool,
    note: str = "",
    remark: str = "",
    boundary: Boundary | None = None,
    layout: Layout | None = None,
) -> Candidate:
    """Lay out the angles of a state; `boundary` is their outer loop, `layout` their map, if it is known."""
    mesh, angles, at = problem.mesh, problem.angles, state.at
    with timed("layout"):
        constraints = angles.constraints if problem.cut is None else problem.cut
        alpha, invalid = at.alpha, angles.invalid(at)
        if invalid.any():
            warnings.warn(
                f"the target angles of faces {some(np.flatnonzero(invalid))} are not within (0, pi): "
                "the layout uses their initial angles instead",
                FallbackWarning,
                stacklevel=stack_level(),
            )
            alpha = np.where(invalid, np.pi * angles.estimate / angles.estimate.sum(axis=0), alpha)
        same = problem.cut is None and not invalid.any()
        try:
            layout = layout or lay_out(
                constraints,
                at if same else Iterate.of(constraints, alpha),
                problem.layout,
                problem.pinned,
                mesh.area,
                angles.solvers,
                None if state.lin is None or problem.cut is not None else state.lin.laplacian,
                problem.shape.corners[:2],
                boundary if same else None,
                in_turn=problem.cut is not None,  # the steps across the seam go on to convergence
            )
        except SingularSystemError as error:
            if problem.layout != "auto":  # a layout that is asked for is not replaced
                raise
            return Candidate(stage, Status.SINGULAR, str(error), state)
    advance("layout", 0.5)
    flipped = flipped_faces(layout.z, mesh.topology.corner)
    flips = len(flipped)
    status, detail = Status.GOOD, ""
    if flips:
        status, detail = Status.FLIPPED, f"{flips} flipped triangle{'s' * (flips > 1)}"
    return Candidate(stage, status, detail, state, converged, note, remark, layout, flipped)


def one_system(rtol: float | None, tol: float, most: float = GAP) -> Stage:
    """The linear step and a second solve with its system; with holes, the second solve is a step.

    Both are to the relative residual `rtol`; without one, a fine mesh's second solve may end before. A loop
    with a relative gap of at most `most` is drawn.
    """
    enough = rtol or ONE_SYSTEM_RTOL

    def stage(problem: Problem, tried: Tried) -> Candidate:
        state, holes = problem.start, len(problem.mesh.topology.loops) > 1
        boundary: Boundary | None = None
        if state.at.residual.largest > tol:
            if not holes:
                state = step_and_chord(state, enough, tol, quick=rtol is None).state
            else:
                state = linear_step(state, enough, close=False, first_rtol=enough**2)
                if not state.steps[-1].limited:  # least squares lays out, which draws no loop
                    state = linear_step(state, enough, same_factor=True)
            if state.steps and not state.steps[0].limited:
                if holes:
                    gap, allowed = float(np.abs(state.at.residual.holonomy.gap).max()), HOLE_GAP
                else:
                    boundary = develop_boundary(problem.angles.constraints, state.at.residual)
                    gap, allowed = boundary.gap, most
                state = state.without_factors()
                if gap > allowed:
                    detail = f"a boundary loop fails to close by {gap:.1%} of its length"
                    return Candidate("linear step", Status.OPEN_LOOP, detail, state)
            if state.steps and (limited := state.steps[-1].limited):
                detail = f"a full step would make an angle of {limited} triangles zero or negative"
                return Candidate("linear step", Status.CUT_SHORT, detail, state.without_factors())
        reached = state.at.residual.largest <= tol
        return drawn(problem, "linear step", state, converged=reached, boundary=boundary)

    return stage


def prescribed(rtol: float, tol: float) -> Stage:
    """Steps to the angle sums that are prescribed at the boundary."""

    def stage(problem: Problem, tried: Tried) -> Candidate:
        # the outer loop is drawn on its circle anyway, but small errors move those of holes a lot
        enough = {"circle": max(tol, ON_CIRCLE), "circles": tol / 10}.get(problem.shape.name, tol)
        state = iterate_to_prescribed_sums(problem.start, rtol, enough, MAX_PRESCRIBED).without_factors()
        reached = state.at.residual.largest <= enough
        note = "" if reached else f"the iterations did not converge within {MAX_PRESCRIBED} steps"
        whole = problem.mesh if problem.ears is None else problem.ears.whole
        if not reached and len(chords := chords_of(whole.topology)):
            note += f" with {len(chords)} edges across, between boundary vertices: {HELP}"
        return drawn(problem, "active set", state, converged=reached, note=note)

    return stage


def iterated(rtol: float, tol: float, most: int) -> Stage:
    """Active-set iterations from the start (section 6)."""

    def stage(problem: Problem, tried: Tried) -> Candidate:
        state = active_set(problem.start, rtol, tol, most).without_factors()
        name: StageName = "active set" if len(state.steps) > 1 else "linear step"
        return drawn(problem, name, state, converged=state.at.residual.largest <= tol)

    return stage


def continued(rtol: float | None, tol: float) -> Stage:
    """Active-set iterations from where the last stage ended; without an `rtol`, the last are corrections."""

    def stage(problem: Problem, tried: Tried) -> Candidate:
        state = tried[-1].state
        if problem.angles.safeguard:
            state = iterate_with_corrections(
                state, rtol, tol, MAX_ACTIVE_SET, CONTINUED_RTOL
            ).without_factors()
        else:
            state = active_set(state, rtol or ACTIVE_SET_RTOL, tol, MAX_ACTIVE_SET).without_factors()
        reached = state.at.residual.largest <= tol
        failed = f"the iterations did not converge within {MAX_ACTIVE_SET} steps"
        said = "further iterations flip more triangles" if reached else failed
        return drawn(problem, "active set", state, converged=reached, note=said)

    return stage


def anchored(tol: float, residual_tol: float = 0.0) -> Stage:
    """Converged ABF by anchored steps."""

    def stage(problem: Problem, tried: Tried) -> Candidate | None:
        if not problem.angles.safeguard:
            return None
        if tried and tried[-1].converged and area_scale_ratio(problem.mesh, best_of(tried)[1].z) > FEW_DIGITS:
            return None  # no angles help where lengths differ by nearly all digits
        result = converge(tried[-1].state.back_to_start() if tried else problem.start, tol)
        if not result.converged:
            return Candidate("converged ABF", Status.DIVERGED, "the iterations do not converge", result.state)
        return _abf_drawn(problem, "converged ABF", result, residual_tol)

    return stage


def feasible(tol: float, residual_tol: float = 0.0) -> Stage:
    """Converged ABF in its feasible form, where anchored steps diverged."""

    def stage(problem: Problem, tried: Tried) -> Candidate | None:
        # flips of converged angles are those of rounding
        if tried[-1].status is not Status.DIVERGED or any(made.converged for made in tried):
            return None
        state = tried[-1].state
        own = problem.angles.constraints if problem.cut is None else problem.cut
        try:
            in_plane = converge_in_plane(problem.mesh, own, state, problem.pinned, tol)
            if in_plane is not None:
                result, layout = in_plane
                return _abf_drawn(problem, "feasible ABF", result, residual_tol, layout)
            result = converge_feasibly(state, tol)
        except SingularSystemError as error:
            return Candidate("feasible ABF", Status.SINGULAR, str(error), state)
        return _abf_drawn(problem, "feasible ABF", result, residual_tol)

    return stage


def _abf_drawn(
    problem: Problem, stage: StageName, result: AbfResult, residual_tol: float, layout: Layout | None = None
) -> Candidate:
    if problem.layout != "auto" or shape_is_pinned(problem.pinned):
        layout = None
    held = np.flatnonzero(result.held.any(axis=0))
    remark = f"; some angles of faces {some(held)} are held at a hundredth of their initial value"
    return drawn(
        problem,
        stage,
        result.state,
        converged=result.converged or result.state.at.residual.largest <= residual_tol,
        note="converged ABF did not converge in its feasible form",
        remark=remark if len(held) else "",
        layout=layout,
    )
