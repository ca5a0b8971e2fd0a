"""The stages that let no triangle flip: the guarantee's map, and the isometric one."""

from dataclasses import replace
from typing import Any

from ..._runtime import timed
from ..._types import ComplexArray
from ...layouts import at_pins, embedded_inside, injective, isometric, place_map
from ...surface import Pins, flat_angles, flipped_faces, shape_is_pinned
from ..result import Status
from .attempts import Problem, StageResult, StageResults, best_of


def injective_map(problem: Problem, earlier: StageResults) -> StageResult:
    """A map without flipped triangles from the best one so far, by SLIM."""
    mesh, last, pinned = problem.mesh, earlier[-1], problem.pinned
    _, layout = best_of(earlier)
    held = shape_is_pinned(pinned)

    def place(z: ComplexArray) -> ComplexArray:
        return place_map(mesh.topology, z, mesh.area, None if held else pinned)

    if problem.shape.sums is not None:
        circle, solvers = problem.shape.name == "circle", problem.angles.solvers
        with timed("injective"):
            found = embedded_inside(mesh, layout.z, circle, place, solvers)
        if found is None:
            detail = "no embedding without flipped triangles inside this boundary was found"
            return StageResult("injective", last.state, Status.NO_VALID_START, detail)
        z, how = found
        state = replace(last.state, at=problem.angles.at(flat_angles(z, mesh.topology.corner)))
        inside = replace(layout, z=z, method="embedding", solver=how)
        return StageResult("injective", state, layout=inside)
    with timed("injective"):
        made = injective(mesh, layout.z, place, problem.angles.solvers)
    if made is None:
        detail = "no embedding without flipped triangles was found in double precision"
        return StageResult("injective", last.state, Status.NO_VALID_START, detail)
    z, missed = made.z, 0.0
    if pinned is not None and held:
        z, missed = at_pins(mesh, made.z, 0.0, pinned, problem.angles.solvers)
    how = f"igl's SLIM, {made.iterations} iterations from {made.start}"
    state = replace(last.state, at=problem.angles.at(flat_angles(z, mesh.topology.corner)))
    slim = replace(layout, z=z, method="SLIM", solver=how)
    return replace(StageResult("injective", state, layout=slim), **_missed(missed))


def isometric_map(
    problem: Problem, earlier: StageResults, weight: float, tol: float, pinned: Pins | None
) -> StageResult | None:
    """The isometric map from the best one so far; None if that has flipped triangles."""
    mesh, last = problem.mesh, earlier[-1]
    best, layout = best_of(earlier)
    if len(best.flipped):
        return None
    with timed("isometric"):
        made = isometric(mesh, layout.z, weight, pinned, problem.angles.solvers, tol)
    flipped = flipped_faces(made.z, mesh.topology.corner)
    start = layout.solver if layout.method == "SLIM" else f"the map of the {best.stage}"
    how = by_newton(made.steps, start, made.energy)
    state = replace(last.state, at=problem.angles.at(flat_angles(made.z, mesh.topology.corner)))
    note = "" if made.stalled else f"the energy still falls after {made.steps} steps"
    placed = replace(layout, z=made.z, method="isometric", solver=how)
    result = StageResult("isometric", state, note=note, layout=placed, flipped=flipped)
    if len(flipped):
        detail = f"{len(flipped)} triangles are too small for double precision"
        return replace(result, status=Status.FLIPPED, detail=detail)
    return replace(result, **_missed(made.missed))


def by_newton(steps: int, start: str, energy: float) -> str:
    """What made an isometric map."""
    return f"Newton's method, {steps} steps, from {start}; energy {energy:.4g} (1: an isometry)"


def _missed(missed: float) -> dict[str, Any]:
    """What a result says of pins that it misses by so much of the map's size."""
    if not missed:
        return {}
    detail = f"pins are missed by up to {missed:.1e} of the map's size"
    return {"status": Status.PINS_MISSED, "detail": detail, "note": f"{detail}, for triangles would flip"}
