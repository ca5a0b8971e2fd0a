"""The stages that cannot flip triangles: the guarantee, and the isometric map."""

from dataclasses import replace
from typing import Any

from ..._runtime import time_stage
from ..._types import ComplexArray
from ...errors import format_count
from ...layouts import embed_in_boundary, make_injective, make_isometric, place_map, pull_to_pins
from ...surface import Pins, compute_flat_angles, find_flipped_faces, shape_is_pinned
from ..result import Status
from .attempts import Problem, StageResult, StageResults, select_best


def make_injective_map(problem: Problem, earlier: StageResults) -> StageResult:
    """Make a map without flipped triangles from the best earlier map, by SLIM."""
    mesh, last, pinned = problem.mesh, earlier[-1], problem.pinned
    _, layout = select_best(earlier)
    held = shape_is_pinned(pinned)

    def place_at_pins(z: ComplexArray) -> ComplexArray:
        return place_map(mesh.topology, z, mesh.area, None if held else pinned)

    if problem.shape.sums is not None:
        circle, solvers = problem.shape.name == "circle", problem.angles.solvers
        with time_stage("injective"):
            found = embed_in_boundary(mesh, layout.z, circle, place_at_pins, solvers)
        if found is None:
            detail = "no embedding without flipped triangles inside this boundary was found"
            return StageResult("injective", last.state, Status.NO_VALID_START, detail)
        z, how = found
        state = replace(last.state, at=problem.angles.evaluate(compute_flat_angles(z, mesh.topology.corner)))
        inside = replace(layout, z=z, method="embedding", solver=how)
        return StageResult("injective", state, layout=inside)
    with time_stage("injective"):
        made = make_injective(mesh, layout.z, place_at_pins, problem.angles.solvers)
    if made is None:
        detail = "no embedding without flipped triangles was found in double precision"
        return StageResult("injective", last.state, Status.NO_VALID_START, detail)
    z, missed = made.z, 0.0
    if pinned is not None and held:
        z, missed = pull_to_pins(mesh, made.z, 0.0, pinned, problem.angles.solvers)
    how = f"igl's SLIM, {format_count(made.iterations, 'iteration')} from {made.start}"
    state = replace(last.state, at=problem.angles.evaluate(compute_flat_angles(z, mesh.topology.corner)))
    slim = replace(layout, z=z, method="SLIM", solver=how)
    return replace(StageResult("injective", state, layout=slim), **_report_missed_pins(missed))


def make_isometric_map(
    problem: Problem, earlier: StageResults, weight: float, tol: float, pinned: Pins | None
) -> StageResult | None:
    """Make the isometric map from the best earlier map; return None if the best map has flipped triangles."""
    mesh, last = problem.mesh, earlier[-1]
    best, layout = select_best(earlier)
    if len(best.flipped):
        return None
    with time_stage("isometric"):
        made = make_isometric(mesh, layout.z, weight, pinned, problem.angles.solvers, tol)
    flipped = find_flipped_faces(made.z, mesh.topology.corner)
    start = layout.solver if layout.method == "SLIM" else f"the map of the {best.stage}"
    how = describe_newton_steps(made.steps, start, made.energy)
    state = replace(last.state, at=problem.angles.evaluate(compute_flat_angles(made.z, mesh.topology.corner)))
    note = "" if made.stalled else f"the energy still falls after {made.steps} steps"
    placed = replace(layout, z=made.z, method="isometric", solver=how)
    result = StageResult("isometric", state, note=note, layout=placed, flipped=flipped)
    if len(flipped):
        detail = f"{format_count(len(flipped), 'triangle')} too small for double precision"
        return replace(result, status=Status.FLIPPED, detail=detail)
    return replace(result, **_report_missed_pins(made.missed))


def describe_newton_steps(steps: int, start: str, energy: float) -> str:
    """Return a text that describes how an isometric map was made."""
    return f"Newton's method, {steps} steps, from {start}; energy {energy:.4g} (1: an isometry)"


def _report_missed_pins(missed: float) -> dict[str, Any]:
    """Return the `StageResult` fields that report by how much a map misses its pins, relative to its size."""
    if not missed:
        return {}
    detail = f"pins are missed by up to {missed:.1e} of the map's size"
    return {"status": Status.PINS_MISSED, "detail": detail, "note": f"{detail}, because triangles would flip"}
