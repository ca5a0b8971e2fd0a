"""The result of the candidates that were tried."""

import numpy as np

from ...surface import area_scale_ratio, coordinates, flipped_faces
from ..result import Flattening, Hole, Residuals, judge
from .attempts import Problem, Tried, best_of


def report(problem: Problem, method: str, tried: Tried, seconds: dict[str, float]) -> Flattening:
    """The result: the best map with its residuals, steps and outcome."""
    best, layout = best_of(tried)
    at, angles, ears = best.state.at, problem.angles, problem.ears
    mesh, z, alpha, flipped = problem.mesh, layout.z, at.alpha, best.flipped
    if ears is not None:
        mesh, z = ears.whole, ears.laid(z)
        alpha, flipped = ears.angles(alpha, z), flipped_faces(z, mesh.topology.corner)
    earlier = () if best.stage in ("injective", "isometric") else tried  # where these start is no matter
    note = best.note
    for made in earlier:
        note = note or made.note
    outcome, message = judge(
        area_scale_ratio(mesh, z),
        layout.method,
        layout.solver,
        flipped,
        at.residual.largest,
        np.flatnonzero(angles.invalid(at)),
        converged=best.converged,
        note=note,
        pins=0 if problem.pinned is None else len(problem.pinned[0]),
    )
    return Flattening(
        uv=coordinates(z),
        F=mesh.faces,
        angles=np.ascontiguousarray(alpha.T),
        method=method,
        outcome=outcome,
        message=message + best.remark,
        flipped=flipped,
        repaired=problem.repaired,
        attempts=tuple(made.summary for made in tried),
        steps=tried[-1].state.steps,
        before=Residuals.of(angles.start.residual),
        after=Residuals.of(at.residual),
        holes=Hole.all_of(problem.mesh, at.residual),
        gap=layout.gap,
        layout=layout.method,
        solver=tried[-1].state.how,
        layout_solver=layout.solver,
        seconds=seconds,
        boundary=problem.shape.name,
        corners=problem.mesh.vertices[problem.shape.corners],
    )
