"""A surface with cones: its angles are found before it is cut, and laid out on the cut surface."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from .._runtime import stopwatch, timed
from .._types import FloatArray, IntArray
from ..angles import (
    ROUGH_RTOL,
    SMALLEST_SINE,
    AngleProblem,
    ClosedPath,
    HolonomyAngles,
    Linearised,
    SchurColumns,
    State,
    System,
    active_set,
    constraints_of,
    corner_angles,
    diverges,
    initial_estimate,
    iterate_with_corrections,
    open_caps,
    rescaled,
    step_from_surface,
    step_with_known_factor,
)
from ..linalg import Factor, NotPositiveDefiniteError, Solvers
from ..surface import Mesh, Topology
from .constants import ABF_TOL, LARGEST_SCALED_ANGLE, LARGEST_WIDENING, MAX_STEPS_TO_SEAMS, TOL
from .fallbacks import (
    ACTIVE_SET_RTOL,
    MAX_ACTIVE_SET_STEPS,
    Problem,
    ProblemOptions,
    Stage,
    StageResult,
    StageResults,
    anchored,
    build_result,
    feasible,
    initial_problem,
    injective_map,
    iterated,
    run_stages,
    with_layout,
)
from .methods import ABF, STAGES, LinABF, Method
from .result import Flattening


class DivergedError(ArithmeticError):
    """Steps lead away from all angles with these sums and holonomy."""


@dataclass(frozen=True, eq=False)
class PrescribedHolonomy:
    """By what angles closed paths of the surface are to turn.

    Attributes
    ----------
    vertices : (#C,) int64
        Vertices whose angle sums may be chosen for that.
    choose : callable
        Given `HolonomyAngles` of the sums so far: their angle sums; what the paths turn by, radians; and the
        logarithm of the scale at all vertices with which the surface has these sums, if that is known.
    """

    vertices: IntArray
    choose: Callable[[HolonomyAngles], tuple[FloatArray, FloatArray, FloatArray | None]]


@dataclass(frozen=True, eq=False)
class KnownLaplacian:
    """The surface's Laplacian, which is factored already where cones were placed.

    Attributes
    ----------
    inverse : Factor or None
        Over the interior vertices but `left_out`.
    left_out : int or None
        A vertex of a closed surface.
    even : bool
        Whether the surface is large, and few triangles are thin. Else a factor of the first step's own metric
        preconditions that better.
    columns : SchurColumns or None
        The columns of the closing rows of the paths, from `holonomy_angles_of` the surface with this inverse.
    """

    inverse: Factor | None
    left_out: int | None
    even: bool
    columns: SchurColumns | None = None


def flatten_with_cones(
    cut: Mesh,
    topology: Topology,
    sums: FloatArray,
    paths: Sequence[ClosedPath],
    prescribed: PrescribedHolonomy | None,
    method: Method,
    known: KnownLaplacian | None = None,
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
    prescribed : PrescribedHolonomy or None
        By what they also turn; None if it is as it comes.
    method : Method
        Linear ABF or converged ABF.
    known : KnownLaplacian, optional
        It preconditions the first step, if the method leaves the choice of the solver.

    Raises
    ------
    ValueError
        Another method.
    DivergedError
        Holonomy angles are prescribed, and steps lead away from them. What is tried elsewhere after them
        would take far longer, and lead nowhere.
    """
    if not isinstance(method, LinABF | ABF):
        raise ValueError(f"method is {method.name!r}: cones need one that finds angles, 'linabf' or 'abf'")
    uncut = replace(topology, n_outer=len(topology.loops))  # no loop is a hole that keeps its turning

    with stopwatch(*STAGES) as seconds:
        safeguard = method.safeguard if isinstance(method, LinABF) else True
        known = known if Solvers(method.solver).shared else None
        asked = constraints_of(uncut, sums, paths, left_out=None if known is None else known.left_out)
        options = ProblemOptions(method.layout, method.threshold, method.solver, safeguard)
        problem = initial_problem(cut, options, uncut=asked)
        begun = problem.start
        if known is not None and (known.even or prescribed is not None):
            begun = replace(begun, lin=_known_linearisation(problem.angles, known))
        if prescribed is not None:
            problem, begun = _with_holonomy(problem, begun, prescribed)
        results = run_stages(problem, _stages(method, begun, prescribed is not None))
        return build_result(problem, method.name, results, seconds)


def holonomy_angles_of(
    topology: Topology,
    surface: FloatArray,
    sums: FloatArray,
    paths: Sequence[ClosedPath],
    known: KnownLaplacian | None = None,
) -> tuple[HolonomyAngles, SchurColumns | None] | None:
    """What closed paths of a surface of these angles turn by, and how a cone at any vertex changes that.

    With the columns of their closing rows, which serve for other cones with the same ground, too.

    None if its Laplacian is singular in double precision. The parameters are those of `flatten_with_cones`.
    """
    uncut = replace(topology, n_outer=len(topology.loops))
    constraints = constraints_of(uncut, sums, paths, left_out=None if known is None else known.left_out)
    angles, lin = AngleProblem(constraints, open_caps(surface)[0], Solvers()), None
    if known is not None:
        lin = _known_linearisation(angles, known)
    try:
        holonomy, lin = HolonomyAngles.predicted(angles, np.arange(topology.n), angles.estimate, lin)
    except NotPositiveDefiniteError:
        return None
    return holonomy, None if known is None or known.inverse is None else lin.columns


def _known_linearisation(angles: AngleProblem, known: KnownLaplacian) -> Linearised | None:
    """What preconditions a step from the estimate, if its factor is known."""
    if known.inverse is None:
        return None
    system = System(angles.constraints, angles.estimate, cot=angles.start.cot)
    analysis = angles.constraints.pattern.analysis(angles.solvers)
    return Linearised.preconditioned(angles, system, analysis, known.inverse, known.columns)


def _with_holonomy(problem: Problem, begun: State, prescribed: PrescribedHolonomy) -> tuple[Problem, State]:
    """The problem with prescribed holonomy angles along its paths, and a state to go on from.

    Holonomy changes angles least where the surface is flat already. So the first step starts from its angles
    scaled conformally, and goes to those of least change from the surface itself.
    """
    surface = open_caps(corner_angles(problem.mesh))[0]
    try:
        holonomy, lin = HolonomyAngles.predicted(problem.angles, prescribed.vertices, surface, begun.lin)
    except NotPositiveDefiniteError:
        after = step_with_known_factor(begun, ROUGH_RTOL)
        holonomy = HolonomyAngles.measured(after.at, problem.angles.constraints.paths, prescribed.vertices)
        angles, _ = _with_chosen_sums(problem.angles, prescribed, holonomy)
        state = State(angles, angles.at(after.at.alpha), after.steps, after.lin)
        return replace(problem, angles=angles), state
    angles, log_scale = _with_chosen_sums(problem.angles, prescribed, holonomy)
    start = _scaled_conformally(angles, surface, log_scale, lin)
    return replace(problem, angles=angles), step_from_surface(start, surface, ROUGH_RTOL)


def _with_chosen_sums(
    angles: AngleProblem, prescribed: PrescribedHolonomy, holonomy: HolonomyAngles
) -> tuple[AngleProblem, FloatArray | None]:
    """The problem with the sums and the holonomy that are chosen, and the logarithm of its scale."""
    sums, wanted, log_scale = prescribed.choose(holonomy)
    asked = angles.constraints.sums.copy()
    changed = np.full(len(asked), np.nan)
    asked[prescribed.vertices] = changed[prescribed.vertices] = sums
    constraints = angles.constraints.with_prescribed(asked, wanted)
    with timed("assembly"):
        estimate = initial_estimate(
            constraints.topology, angles.estimate, to_triangles=angles.safeguard, sums=changed
        )
    return replace(angles, constraints=constraints, estimate=estimate), log_scale


def _scaled_conformally(
    angles: AngleProblem, surface: FloatArray, u: FloatArray | None, lin: Linearised
) -> State:
    """The angles of the surface scaled conformally, so that it is nearly flat but for the cones.

    With what is missing to the sums, r, the logarithm of the scale is u = -L^-1 r. As these are angles of
    lengths, the wheel constraints hold, and the scale comes back along closed paths. Triangles right at cones
    that cannot be scaled so, or become obtuse, keep their estimate.
    """
    constraints = angles.constraints
    with timed("estimate"):
        if u is None:
            assert lin.inverse is not None
            sums = constraints.sum_at_rows(constraints.topology.sum_at_vertices(surface))
            u = np.append(-lin.inverse.solve(constraints.target - sums), 0.0)[constraints.row]
        sine = np.maximum(np.sin(surface), SMALLEST_SINE)  # the sides, up to their scale
        alpha, bad = rescaled(constraints.topology, sine, u)
        bad |= alpha.max(axis=0) > np.maximum(LARGEST_SCALED_ANGLE, surface.max(axis=0) + LARGEST_WIDENING)
        at = angles.at(np.where(bad, angles.estimate, alpha))
    return State(angles, at, lin=lin)


def _stages(method: LinABF | ABF, begun: State, prescribed: bool) -> list[Stage]:
    stages: list[Stage]
    if isinstance(method, LinABF) and method.iterations != "auto":
        rtol = method.rtol or ACTIVE_SET_RTOL
        stages = [partial(iterated, rtol=rtol, tol=method.tol, max_steps=method.iterations)]
    else:
        stages, tol, residual_tol = [], method.tol, 0.0
        if isinstance(method, LinABF):
            only = prescribed and not method.guarantee
            stages = [partial(_iterate_from, begun=begun, rtol=method.rtol, tol=method.tol, only=only)]
            tol, residual_tol = ABF_TOL, method.tol
        for form in (anchored, feasible):
            stage = partial(form, tol=tol, residual_tol=residual_tol)
            stages.append(partial(_with_matching_sides, stage=stage, tol=method.tol))
    return [*stages, injective_map] if method.guarantee else stages


def _iterate_from(
    problem: Problem, earlier: StageResults, begun: State, rtol: float | None, tol: float, only: bool
) -> StageResult:
    """Active-set iterations until both sides of the seam agree; or, if `only` they may, an error."""
    state = iterate_with_corrections(begun, rtol, tol, MAX_ACTIVE_SET_STEPS)
    if only and diverges(state):
        raise DivergedError(f"steps lead to angle sums {state.at.residual.largest:.2g} away from them")
    reached = state.at.residual.largest <= tol
    note = "" if reached else f"the iterations did not converge within {MAX_ACTIVE_SET_STEPS} steps"
    return with_layout(problem, StageResult("active set", state, converged=reached, note=note))


def _with_matching_sides(
    problem: Problem, earlier: StageResults, stage: Stage, tol: float
) -> StageResult | None:
    """What a stage makes, after active-set steps until both sides of the seam agree."""
    made = stage(problem, earlier)
    if made is None or made.layout is None or made.state.at.residual.largest <= TOL:
        return made
    state = active_set(made.state, ACTIVE_SET_RTOL, TOL, MAX_STEPS_TO_SEAMS)
    converged = made.converged and state.at.residual.largest <= tol
    matching = with_layout(problem, replace(made, state=state, converged=converged))
    return made if len(matching.flipped) > len(made.flipped) else matching
