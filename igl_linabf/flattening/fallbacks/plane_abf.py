"""Converged ABF in the plane, where the steps in angles do not converge."""

from __future__ import annotations

from dataclasses import replace

from ..._runtime import timed
from ...angles import ANGLE_BOUND, ROUGH_RTOL, AbfResult, Constraints, State, Step, iterate_with_corrections
from ...errors import SingularSystemError
from ...layouts import FLAT_RESIDUAL, Layout, LayoutOptions, lay_out, least_change, place_map
from ...surface import Mesh, Pins, flipped_faces, shape_is_pinned
from .constants import MAX_ACTIVE_SET_STEPS, PLANE_ABF_GAIN


def converge_in_plane(
    mesh: Mesh, own: Constraints, state: State, pinned: Pins | None, tol: float
) -> tuple[AbfResult, Layout] | None:
    """Minimise sum ((alpha - alpha_0) / alpha_0)^2 over the maps of a surface with a free boundary.

    Parameters
    ----------
    mesh : Mesh
    own : Constraints
        Of `mesh`.
    state : State
        Where the steps in angles ended: near the minimum, even if they do not converge.
    pinned : Pins or None
        Two of them place the map.
    tol : float
        As for `igl_linabf.angles.converge_feasibly`.

    Returns
    -------
    (AbfResult, Layout) or None
        The map is that of the steps: drawn from its angles it would lose digits where its scale varies a lot.
        None where more is asked for than a flat map, or where no map without flipped triangles is found to
        start from, or where the steps do not converge.
    """
    problem = state.problem
    if problem.constraints is not own or not own.plain:
        return None
    for begin in (state, state.back_to_start()):
        try:
            flat = iterate_with_corrections(begin, None, FLAT_RESIDUAL, MAX_ACTIVE_SET_STEPS, ROUGH_RTOL)
        except SingularSystemError:
            continue
        start = _map_without_flips(mesh, flat)
        if start is not None:
            break
    else:
        return None
    with timed("solve"):
        bound, gain = ANGLE_BOUND * problem.estimate, PLANE_ABF_GAIN * tol
        made = least_change(mesh.topology, problem.estimate, bound, start.z, gain, problem.solvers)
    if made is None or made.gain > gain:
        return None
    at = problem.at(made.angles)
    step = Step("feasible", 0, int(made.held.any(axis=0).sum()), at.residual.largest)
    state = replace(flat, at=at, steps=(*flat.steps, *(made.steps * (step,))))
    z = place_map(mesh.topology, made.z, mesh.area, None if shape_is_pinned(pinned) else pinned)
    return AbfResult(state.without_factors(), True, made.held), replace(start, z=z)


def _map_without_flips(mesh: Mesh, state: State) -> Layout | None:
    """A map of the angles of a state; None if it has flipped triangles."""
    problem, lin = state.problem, state.lin
    with timed("layout"):
        try:
            layout = lay_out(
                problem.constraints,
                state.at,
                LayoutOptions(area=mesh.area),
                problem.solvers,
                None if lin is None else lin.laplacian,
            )
        except SingularSystemError:
            return None
    return None if len(flipped_faces(layout.z, mesh.topology.corner)) else layout
