"""Flatten surfaces with cones: find the angles on the uncut surface, and lay them out on the cut surface."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from .._runtime import stopwatch, time_stage
from .._types import FloatArray, IntArray
from ..angles import (
    ROUGH_RTOL,
    SMALLEST_SINE,
    AngleProblem,
    ClosedPath,
    HolonomyAngles,
    Linearisation,
    State,
    System,
    build_constraints,
    compute_rescaled_angles,
    corner_angles,
    initial_estimate,
    is_diverging,
    iterate_with_corrections,
    limit_obtuse_angles,
    run_active_set,
    step_from_surface,
    step_with_known_factor,
)
from ..linalg import Factor, NotPositiveDefiniteError, Solvers
from ..surface import Mesh, Topology
from .constants import ABF_TOL, TOL
from .fallbacks import (
    ACTIVE_SET_RTOL,
    MAX_ACTIVE_SET_STEPS,
    Problem,
    ProblemOptions,
    Stage,
    StageResult,
    StageResults,
    add_layout,
    build_result,
    iterate_active_set,
    make_injective_map,
    run_anchored_abf,
    run_feasible_abf,
    run_stages,
    set_up_problem,
)
from .methods import ABF, STAGES, LinABF, Method
from .result import Flattening

LARGEST_SCALED_ANGLE = 2.0  # maximum angle of a conformally scaled triangle, in radians
LARGEST_WIDENING = 0.2  # maximum increase of a triangle's largest angle by scaling, in radians
MAX_STEPS_TO_SEAMS = 3  # maximum number of steps after converged ABF to make both sides of seams match


class DivergedError(ArithmeticError):
    """The steps diverge from the angles that have the prescribed sums and holonomy."""


@dataclass(frozen=True, eq=False)
class PrescribedHolonomy:
    """The prescribed turning of closed paths of the surface.

    Attributes
    ----------
    vertices : (#C,) int64
        Vertices whose angle sums may be chosen to reach the turnings.
    choose : callable
        Takes the `HolonomyAngles` of the current sums. Returns the angle sums of `vertices`; the turnings of
        the paths, radians; and the logarithm of the scale at all vertices that leads to these sums, or None
        if it is unknown.
    """

    vertices: IntArray
    choose: Callable[[HolonomyAngles], tuple[FloatArray, FloatArray, FloatArray | None]]


@dataclass(frozen=True, eq=False)
class KnownLaplacian:
    """The Laplacian of the surface, factored earlier to place cones.

    Attributes
    ----------
    inverse : Factor or None
        Factor of the Laplacian over the interior vertices except `left_out`.
    left_out : int or None
        The vertex of a closed surface that the factor omits.
    even : bool
        Whether the surface is large with few thin triangles. Otherwise, a factor in the metric of the first
        step is a better preconditioner.
    """

    inverse: Factor | None
    left_out: int | None
    even: bool


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
        Topology of the uncut surface, with the faces of `cut` in the same order.
    sums : (#V,) float64
        Angle sums of the vertices of the uncut surface, radians; NaN at the boundary, which is free.
    paths : sequence of ClosedPath
        Paths along which the scale returns to its initial value.
    prescribed : PrescribedHolonomy or None
        The prescribed turnings of the paths; None if they are free.
    method : Method
        Linear ABF or converged ABF.
    known : KnownLaplacian, optional
        Preconditioner of the first step, if the method allows any solver.

    Raises
    ------
    ValueError
        The method is neither linear ABF nor converged ABF.
    DivergedError
        Steps move away from the prescribed holonomy angles. Other stages would take far longer without
        success.
    """
    if not isinstance(method, LinABF | ABF):
        raise ValueError(
            f"method is {method.name!r}: cones require a method that finds angles, 'linabf' or 'abf'"
        )
    uncut = replace(topology, n_outer=len(topology.loops))  # all boundary loops are free

    with stopwatch(*STAGES) as seconds:
        safeguard = method.safeguard if isinstance(method, LinABF) else True
        known = known if Solvers(method.solver).allows_shared_factors else None
        asked = build_constraints(uncut, sums, paths, left_out=None if known is None else known.left_out)
        options = ProblemOptions(method.layout, method.threshold, method.solver, safeguard)
        problem = set_up_problem(cut, options, uncut=asked)
        begun = problem.initial_state
        if known is not None and (known.even or prescribed is not None):
            begun = replace(begun, lin=_make_known_linearisation(problem.angles, known))
        if prescribed is not None:
            problem, begun = _prescribe_holonomy(problem, begun, prescribed)
        results = run_stages(problem, _list_stages(method, begun, prescribed is not None))
        return build_result(problem, method.name, results, seconds)


def _make_known_linearisation(angles: AngleProblem, known: KnownLaplacian) -> Linearisation | None:
    """Return a linearisation that preconditions a step from the estimate, if its factor is known."""
    if known.inverse is None:
        return None
    system = System(angles.constraints, angles.estimate, cot=angles.initial_iterate.cot)
    analysis = angles.constraints.pattern.get_analysis(angles.solvers)
    return Linearisation.from_factor(angles, system, analysis, known.inverse)


def _prescribe_holonomy(
    problem: Problem, begun: State, prescribed: PrescribedHolonomy
) -> tuple[Problem, State]:
    """Return the problem with prescribed holonomy angles along its paths, and the state to continue from.

    Holonomy changes the angles least if the surface is already nearly flat. Therefore the first step starts
    from the conformally scaled angles of the surface, and minimises the change from the unscaled angles.
    """
    surface = limit_obtuse_angles(corner_angles(problem.mesh))[0]
    try:
        holonomy, lin = HolonomyAngles.predict(problem.angles, prescribed.vertices, surface, begun.lin)
    except NotPositiveDefiniteError:
        after = step_with_known_factor(begun, ROUGH_RTOL)
        holonomy = HolonomyAngles.measure(after.at, problem.angles.constraints.paths, prescribed.vertices)
        angles, _ = _choose_sums(problem.angles, prescribed, holonomy)
        state = State(angles, angles.evaluate(after.at.alpha), after.steps, after.lin)
        return replace(problem, angles=angles), state
    angles, log_scale = _choose_sums(problem.angles, prescribed, holonomy)
    start = _scale_conformally(angles, surface, log_scale, lin)
    return replace(problem, angles=angles), step_from_surface(start, surface, ROUGH_RTOL)


def _choose_sums(
    angles: AngleProblem, prescribed: PrescribedHolonomy, holonomy: HolonomyAngles
) -> tuple[AngleProblem, FloatArray | None]:
    """Return the problem with the chosen sums and holonomy, and the logarithm of its scale."""
    sums, wanted, log_scale = prescribed.choose(holonomy)
    asked = angles.constraints.sums.copy()
    changed = np.full(len(asked), np.nan)
    asked[prescribed.vertices] = changed[prescribed.vertices] = sums
    constraints = angles.constraints.replace_targets(asked, wanted)
    with time_stage("assembly"):
        estimate = initial_estimate(
            constraints.topology, angles.estimate, to_triangles=angles.safeguard, sums=changed
        )
    return replace(angles, constraints=constraints, estimate=estimate), log_scale


def _scale_conformally(
    angles: AngleProblem, surface: FloatArray, u: FloatArray | None, lin: Linearisation
) -> State:
    """Scale the surface conformally, so that it is nearly flat except at the cones; return its angles.

    If r is the difference from the prescribed sums, the logarithm of the scale is u = -L^-1 r. The scaled
    angles belong to edge lengths. Therefore, the wheel constraints hold, and the scale returns along closed
    paths. Triangles at cones whose scaled sides form no triangle, or an obtuse one, keep their estimate.
    """
    constraints = angles.constraints
    with time_stage("estimate"):
        if u is None:
            assert lin.inverse is not None
            sums = constraints.sum_at_rows(constraints.topology.sum_at_vertices(surface))
            u = np.append(-lin.inverse.solve(constraints.target - sums), 0.0)[constraints.row]
        sine = np.maximum(np.sin(surface), SMALLEST_SINE)  # proportional to the opposite side
        alpha, bad = compute_rescaled_angles(constraints.topology, sine, u)
        bad |= alpha.max(axis=0) > np.maximum(LARGEST_SCALED_ANGLE, surface.max(axis=0) + LARGEST_WIDENING)
        at = angles.evaluate(np.where(bad, angles.estimate, alpha))
    return State(angles, at, lin=lin)


def _list_stages(method: LinABF | ABF, begun: State, prescribed: bool) -> list[Stage]:
    """Return the stages of a method for a surface with cones."""
    stages: list[Stage]
    if isinstance(method, LinABF) and method.iterations != "auto":
        rtol = method.rtol or ACTIVE_SET_RTOL
        stages = [partial(iterate_active_set, rtol=rtol, tol=method.tol, max_steps=method.iterations)]
    else:
        stages, tol, residual_tol = [], method.tol, 0.0
        if isinstance(method, LinABF):
            only = prescribed and not method.guarantee
            stages = [partial(_iterate_from, begun=begun, rtol=method.rtol, tol=method.tol, only=only)]
            tol, residual_tol = ABF_TOL, method.tol
        for form in (run_anchored_abf, run_feasible_abf):
            stage = partial(form, tol=tol, residual_tol=residual_tol)
            stages.append(partial(_run_until_sides_match, stage=stage, tol=method.tol))
    return [*stages, make_injective_map] if method.guarantee else stages


def _iterate_from(
    problem: Problem, earlier: StageResults, begun: State, rtol: float | None, tol: float, only: bool
) -> StageResult:
    """Take active-set steps until both sides of the seam match.

    If `only`, there is no other stage, and divergence raises a `DivergedError`.
    """
    state = iterate_with_corrections(begun, rtol, tol, MAX_ACTIVE_SET_STEPS)
    if only and is_diverging(state):
        raise DivergedError(
            f"steps lead to angle sums {state.at.residual.max_magnitude:.2g} away from the given ones"
        )
    reached = state.at.residual.max_magnitude <= tol
    note = "" if reached else f"the iterations did not converge within {MAX_ACTIVE_SET_STEPS} steps"
    return add_layout(problem, StageResult("active set", state, converged=reached, note=note))


def _run_until_sides_match(
    problem: Problem, earlier: StageResults, stage: Stage, tol: float
) -> StageResult | None:
    """Run a stage, followed by active-set steps until both sides of the seam match."""
    made = stage(problem, earlier)
    if made is None or made.layout is None or made.state.at.residual.max_magnitude <= TOL:
        return made
    state = run_active_set(made.state, ACTIVE_SET_RTOL, TOL, MAX_STEPS_TO_SEAMS)
    converged = made.converged and state.at.residual.max_magnitude <= tol
    matching = add_layout(problem, replace(made, state=state, converged=converged))
    return made if len(matching.flipped) > len(made.flipped) else matching
