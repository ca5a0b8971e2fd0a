"""Isometric maps of disks side by side, from their maps by linear ABF."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from .._runtime import stopwatch, timed
from .._types import FloatArray, IntArray
from ..angles import DiskBlocks, Iterate, constraints_of
from ..layouts import isometric_together
from ..linalg import NotPositiveDefiniteError, Solvers
from ..surface import (
    bounded_ratio,
    complex_positions,
    coordinates,
    flat_angles,
    signed_double_areas,
    sound_disks,
)
from .fallbacks import by_newton
from .methods import Isometric
from .result import Attempt, Findings, Flattening, Residuals, Status, judge

Arrays = tuple[FloatArray, IntArray]


def isometric_maps(
    meshes: Sequence[Arrays], results: Sequence[Flattening], method: Isometric
) -> Iterator[tuple[int, Flattening]]:
    """The isometric maps of disks from their maps, and their places; those that need more are left out."""
    disks, found = sound_disks(meshes)
    if disks is None:
        return
    vertices, faces, corner = disks.vertices, disks.faces, disks.topology.corner
    start = complex_positions(np.concatenate([results[i].uv for i in found]))
    try:
        with stopwatch() as seconds, timed("isometric"):
            z, energy, steps, good = isometric_together(disks, start, method.weight, Solvers(method.solver))
    except NotPositiveDefiniteError:
        return
    alpha, constraints = flat_angles(z, corner), constraints_of(disks.topology)
    at = Iterate.of(constraints, alpha)
    after = DiskBlocks.of(constraints, disks).residuals(at.residual).T
    scale = signed_double_areas(z, corner) / disks.double_area
    ratio = bounded_ratio(faces.max(scale), faces.min(scale))
    uv, angles = coordinates(z), np.ascontiguousarray(alpha.T)
    for k in np.flatnonzero(good).tolist():
        linear = results[found[k]]
        how = by_newton(int(steps[k]), f"the map of the {linear.attempts[-1].name}", float(energy[k]))
        residuals = Residuals(*after[k].tolist())
        outcome, message = judge(
            Findings("isometric", how, float(ratio[k]), linear.flipped, residuals.largest)
        )
        share = seconds["isometric"] * float(faces.sizes[k] / faces.start[-1])
        yield (
            int(found[k]),
            replace(
                linear,
                uv=uv[vertices.start[k] : vertices.start[k + 1]],
                angles=angles[faces.start[k] : faces.start[k + 1]],
                method=method.name,
                outcome=outcome,
                message=message,
                attempts=(*linear.attempts, Attempt("isometric", Status.GOOD, 0, residuals.largest, "")),
                after=residuals,
                layout="isometric",
                layout_solver=how,
                seconds={**linear.seconds, "isometric": share, "total": linear.seconds["total"] + share},
            ),
        )
