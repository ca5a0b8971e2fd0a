"""Run the stages that attempt to find a map, and return the best map as a `Flattening`."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..._runtime import time_stage
from ..._types import IntArray
from ...angles import (
    CAP_ANGLE,
    AngleProblem,
    Constraints,
    State,
    build_constraints,
    corner_angles,
    initial_estimate,
    limit_obtuse_angles,
)
from ...errors import MeshWarning, SingularSystemError, first_few, stack_level
from ...layouts import Layout, LayoutName, check_pins
from ...linalg import SolverName, Solvers, check_memory, factor_bytes
from ...surface import (
    Mesh,
    Pins,
    compute_area_scale_ratio,
    find_flipped_faces,
    real_coordinates,
    shape_is_pinned,
)
from ..boundary_shapes import FREE, Shape, resolve_shape
from ..result import (
    NO_INDICES,
    Attempt,
    Findings,
    Flattening,
    FlatteningReport,
    Hole,
    Residuals,
    StageName,
    Status,
    determine_outcome,
)
from .ears import Ears


@dataclass(frozen=True)
class ProblemOptions:
    """Options of the methods that find angles; see `igl_linabf.linabf`."""

    layout: LayoutName = "auto"
    threshold: float = 1.0
    solver: SolverName = "auto"
    safeguard: bool = True


@dataclass(frozen=True, eq=False)
class Problem:
    """A checked mesh with the initial estimate of its angles.

    Attributes
    ----------
    mesh : Mesh
    pinned : Pins or None
    layout : str
        The method that turns angles into coordinates.
    angles : AngleProblem
        The problem in angles, with the initial estimate. Its constraints are `own`, or the constraints of the
        surface from which `mesh` was cut.
    repaired : (#caps,) int64
        Faces with an angle so close to pi that it was changed before flattening.
    own : Constraints
        Constraints of `mesh`.
    shape : Shape
        The prescribed shape of the boundary.
    ears : Ears or None
        Ears that were removed from `mesh`.
    """

    mesh: Mesh
    pinned: Pins | None
    layout: LayoutName
    angles: AngleProblem
    repaired: IntArray
    own: Constraints
    shape: Shape = FREE
    ears: Ears | None = None

    @property
    def initial_state(self) -> State:
        """The state at the initial estimate."""
        return State(self.angles, self.angles.initial_iterate)


@dataclass(frozen=True, eq=False)
class StageResult:
    """The result of a stage.

    Attributes
    ----------
    stage : str
    state : State
        The angles after the stage, with all steps from the initial estimate.
    status : Status
    detail : str
        The status in words; "" if it is good.
    converged : bool
        Whether the angles satisfy the constraints to the tolerance of the method.
    note : str
        Why the iterations did not help; part of the message of the result.
    remark : str
        A further remark on the map; part of the message of the result.
    layout : Layout or None
        None if the stage stopped before the layout.
    flipped : (#flips,) int64
    """

    stage: StageName
    state: State
    status: Status = Status.GOOD
    detail: str = ""
    converged: bool = False
    note: str = ""
    remark: str = ""
    layout: Layout | None = None
    flipped: IntArray = field(default_factory=NO_INDICES.copy)


StageResults = tuple[StageResult, ...]
Stage = Callable[[Problem, StageResults], StageResult | None]
"""Takes the problem and the results of earlier stages; returns None if the stage does not apply."""


def set_up_problem(
    mesh: Mesh,
    options: ProblemOptions,
    pinned: Pins | None = None,
    shape: Shape = FREE,
    uncut: Constraints | None = None,
) -> Problem:
    """Set up the problem of flattening a mesh, with the initial estimate of its angles (section 4.2).

    `uncut` are the constraints of the uncut surface, if the angles of that surface are to be found.

    Raises
    ------
    MemoryLimitError
        The computation would not fit into memory.

    Warns
    -----
    MeshWarning
        Some faces have an angle too close to pi.
    """
    ears = None
    with time_stage("estimate"):
        check_pins(options.layout, pinned)
        if shape.circles:
            ears = Ears.remove_from(mesh, pinned)
        if ears is not None:
            mesh, pinned = ears.rest, None
            shape = resolve_shape(mesh, shape.name, None)
        holes, rows = len(mesh.topology.loops) - 1, mesh.topology.n
        least_squares = options.layout == "least-squares" or holes > 0 or shape_is_pinned(pinned)
        factor = factor_bytes(rows, 2) if least_squares else 0
        check_memory(len(mesh.double_area), factor, holes, rows)
    with time_stage("assembly"):
        own = build_constraints(mesh.topology, shape.sums, circles=shape.circles)
        constraints = own if uncut is None else uncut
    with time_stage("estimate"):
        alpha, caps = limit_obtuse_angles(corner_angles(mesh))
        if len(caps):
            caps = caps if ears is None else ears.faces[caps]
            warnings.warn(
                f"faces {first_few(caps)} have an angle within {CAP_ANGLE:g} rad of pi: that angle is "
                f"changed to pi - {CAP_ANGLE:g} before flattening; collapse these faces, or flip their "
                "longest edges",
                MeshWarning,
                stacklevel=stack_level(),
            )
    with time_stage("assembly"):
        estimate = initial_estimate(
            constraints.topology, alpha, options.threshold, options.safeguard, constraints.sums
        )
        angles = AngleProblem(constraints, estimate, Solvers(options.solver), options.safeguard)
        return Problem(mesh, pinned, options.layout, angles, caps, own, shape, ears)


def run_stages(problem: Problem, stages: Sequence[Stage]) -> StageResults:
    """Run stages of increasing cost until the result of a stage is good; return the results of all stages."""
    results: StageResults = ()
    for stage in stages:
        made = stage(problem, results)
        if made is not None:
            results = (*results, made)
            if made.status is Status.GOOD:
                break
    return results


def select_best(results: StageResults) -> tuple[StageResult, Layout]:
    """Return the result and the layout with the fewest flips; among several, the latest.

    Raises
    ------
    SingularSystemError
        No stage made a map.
    """
    best: tuple[StageResult, Layout] | None = None
    for made in results:
        if made.layout is not None and (best is None or len(made.flipped) <= len(best[0].flipped)):
            best = made, made.layout
    if best is None:
        raise SingularSystemError(results[-1].detail)
    return best


def build_result(
    problem: Problem, method: str, results: StageResults, seconds: dict[str, float]
) -> Flattening:
    """Return the best map with its residuals, steps, outcome, and all attempts."""
    best, layout = select_best(results)
    at, angles, ears = best.state.at, problem.angles, problem.ears
    mesh, z, alpha, flipped = problem.mesh, layout.z, at.alpha, best.flipped
    if ears is not None:
        mesh, z = ears.whole, ears.add_to_map(z)
        alpha, flipped = ears.add_to_angles(alpha, z), find_flipped_faces(z, mesh.topology.corner)
    note, attempts = best.note, list[Attempt]()
    for made in results:
        flips = None if made.layout is None else len(made.flipped)
        attempts.append(
            Attempt(made.stage, made.status, flips, made.state.at.residual.max_magnitude, made.detail)
        )
        # notes are about the iterations for target angles; injective and isometric maps have other angles
        if best.stage not in ("injective", "isometric"):
            note = note or made.note
    outcome, message = determine_outcome(
        Findings(
            layout.method,
            layout.solver,
            compute_area_scale_ratio(mesh, z),
            flipped,
            at.residual.max_magnitude,
            np.flatnonzero(angles.mask_invalid_triangles(at)),
            best.converged,
            note,
            0 if problem.pinned is None else len(problem.pinned[0]),
        )
    )
    return Flattening(
        uv=real_coordinates(z),
        F=mesh.faces,
        angles=np.ascontiguousarray(alpha.T),
        method=method,
        outcome=outcome,
        message=message + best.remark,
        flipped=flipped,
        before=Residuals.from_residual(angles.initial_iterate.residual),
        after=Residuals.from_residual(at.residual),
        holes=Hole.list_all(problem.mesh, at.residual),
        seconds=seconds,
        report=FlatteningReport(
            repaired=problem.repaired,
            attempts=tuple(attempts),
            steps=results[-1].state.steps,
            gap=layout.gap,
            layout=layout.method,
            solver=results[-1].state.solver_name,
            layout_solver=layout.solver,
            boundary=problem.shape.name,
            corners=problem.mesh.vertices[problem.shape.corners],
        ),
    )
