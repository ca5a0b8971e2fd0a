"""Flatten many disks with a single linear system, by linear ABF or to isometric maps."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .._core import normalize_maps
from .._runtime import stopwatch, time_stage
from .._types import BoolArray, FloatArray, IntArray
from ..angles import (
    AngleProblem,
    DiskRanges,
    Iterate,
    State,
    StepAndChord,
    build_constraints,
    initial_estimate,
    limit_obtuse_angles,
    take_step_and_chord,
)
from ..layouts import MAX_BOUNDARY_GAP, compute_harmonic_map, develop_boundary, flatten_isometrically
from ..linalg import NotPositiveDefiniteError, Solvers
from ..measures import find_crossed_loops, find_overlapping_pairs
from ..surface import (
    Disks,
    complex_positions,
    compute_bounded_ratio,
    compute_flat_angles,
    concatenate_sound_disks,
    real_coordinates,
    signed_double_areas,
)
from .fallbacks import STEP_AND_CHORD_RTOL, describe_newton_steps
from .methods import Isometric, LinABF
from .result import Attempt, Findings, Flattening, Residuals, Status, determine_outcome, report_overlaps


@dataclass(frozen=True, eq=False)
class LinearBatch:
    """Disks after a linear step and a chord step with the same matrix, with their maps.

    Attributes
    ----------
    disks : Disks
    stepped : StepAndChord
    good : (#disks,) bool
        Whether the map of the disk is final, so that no further attempts are needed.
    uv : (#V, 2) float64
    F, angles : (#F, 3) int64 and float64
        Triangles with the vertex numbers of each disk, and their target angles.
    gap, ratio : (#disks,) float64
        Relative closure error of the boundary, and ratio of the largest to the smallest area scale.
    solver : str
        Solver of the layout.
    """

    disks: Disks
    stepped: StepAndChord
    good: BoolArray
    uv: FloatArray
    F: IntArray
    angles: FloatArray
    gap: FloatArray
    ratio: FloatArray
    solver: str


def flatten_linear_batch(disks: Disks, method: LinABF) -> LinearBatch:
    """Flatten disks with a single linear system, by a linear step and a chord.

    Raises
    ------
    NotPositiveDefiniteError, SingularSystemError
        The system of one of the disks is singular in double precision.
    """
    solvers, vertices, faces, topology = Solvers(method.solver), disks.vertices, disks.faces, disks.topology
    with time_stage("estimate"):
        alpha, caps = limit_obtuse_angles(np.arctan2(disks.double_area, disks.dot))
        estimate = initial_estimate(topology, alpha, method.threshold)
    with time_stage("assembly"):
        constraints = build_constraints(topology)
        problem = AngleProblem(
            constraints, estimate, solvers, side_by_side=DiskRanges.from_disks(constraints, disks)
        )
    stepped = take_step_and_chord(
        State(problem, problem.initial_iterate), method.rtol or STEP_AND_CHORD_RTOL, method.tol
    )
    at, lin = stepped.state.at, stepped.state.lin
    with (
        time_stage("layout"),
        np.errstate(divide="ignore", invalid="ignore"),
    ):  # disks that are not solved well have invalid angles; their maps are discarded
        boundary = develop_boundary(constraints, at.residual)
        z, solver = compute_harmonic_map(
            boundary, at, constraints, None if lin is None else lin.laplacian, solvers
        )
        areas = signed_double_areas(z, topology.corner)
        scale = np.abs(areas)
        z = normalize_maps(z, topology.corner, scale, disks.area, vertices.start, faces.start)
        scale /= disks.double_area
    good = stepped.good & ~faces.any(~(areas > 0)) & (boundary.gaps <= MAX_BOUNDARY_GAP)
    good[np.searchsorted(faces.start, caps, side="right") - 1] = False  # let `flatten` warn of caps
    return LinearBatch(
        disks=disks,
        stepped=stepped,
        good=good,
        uv=real_coordinates(z),
        F=topology.corner.T - faces.repeat(vertices.start[:-1])[:, None],
        angles=np.ascontiguousarray(at.alpha.T),
        gap=boundary.gaps,
        ratio=compute_bounded_ratio(faces.max(scale), faces.min(scale)),
        solver=solver,
    )


Arrays = tuple[FloatArray, IntArray]


def iterate_isometric_maps(
    meshes: Sequence[Arrays], results: Sequence[Flattening], method: Isometric
) -> Iterator[tuple[int, Flattening]]:
    """Yield the index and the isometric map of each disk whose map is final after the common Newton steps."""
    disks, found = concatenate_sound_disks(meshes)
    if disks is None:
        return
    vertices, faces, corner = disks.vertices, disks.faces, disks.topology.corner
    start = complex_positions(np.concatenate([results[i].uv for i in found]))
    try:
        with stopwatch() as seconds, time_stage("isometric"):
            z, energy, steps, good = flatten_isometrically(
                disks, start, method.weight, Solvers(method.solver), method.tol
            )
    except NotPositiveDefiniteError:
        return
    alpha, constraints = compute_flat_angles(z, corner), build_constraints(disks.topology)
    at = Iterate.from_angles(constraints, alpha)
    after = DiskRanges.from_disks(constraints, disks).residuals(at.residual).T
    scale = signed_double_areas(z, corner) / disks.double_area
    ratio = compute_bounded_ratio(faces.max(scale), faces.min(scale))
    uv, angles = real_coordinates(z), np.ascontiguousarray(alpha.T)
    crossed = set(find_crossed_loops(z, *disks.boundary_loops).tolist())
    for k in np.flatnonzero(good).tolist():
        linear = results[found[k]]
        first = linear.report.attempts[-1].name
        how = describe_newton_steps(int(steps[k]), f"the map of the {first}", float(energy[k]))
        residuals = Residuals(*after[k].tolist())
        outcome, message = determine_outcome(
            Findings("isometric", how, float(ratio[k]), linear.flipped, residuals.largest)
        )
        share = seconds["isometric"] * float(faces.sizes[k] / faces.start[-1])
        attempts = (*linear.report.attempts, Attempt("isometric", Status.GOOD, 0, residuals.largest, ""))
        result = replace(
            linear,
            uv=uv[vertices.start[k] : vertices.start[k + 1]],
            angles=angles[faces.start[k] : faces.start[k + 1]],
            method=method.name,
            outcome=outcome,
            message=message,
            after=residuals,
            seconds={**linear.seconds, "isometric": share, "total": linear.seconds["total"] + share},
            report=replace(linear.report, attempts=attempts, layout="isometric", layout_solver=how),
        )
        if k in crossed:
            result = report_overlaps(result, find_overlapping_pairs(result.uv, result.F))
        yield int(found[k]), result
