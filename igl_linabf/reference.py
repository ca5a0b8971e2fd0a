"""Other methods, for comparison."""

from __future__ import annotations

from time import perf_counter

import igl
import numpy as np

from .angles import corner_angles, residual
from .errors import some
from .layout import Pins, centred, far_apart
from .mesh import Mesh, complex_positions, coordinates
from .pipeline import flipped_faces
from .result import Flattening, Outcome, Residuals
from .topology import NEXT, PREV


def lscm(mesh: Mesh, pinned: Pins | None) -> Flattening:
    """`igl.lscm` of a checked mesh, with two far boundary vertices as the default pins."""
    start = perf_counter()
    topology = mesh.topology
    if pinned is None:
        loop = topology.loops[0]
        b, bc = loop[far_apart(mesh.V[loop])], np.array([[0.0, 0.0], [1.0, 0.0]])
    else:
        b, bc = pinned
    uv, _ = igl.lscm(mesh.V, np.ascontiguousarray(topology.corner.T), b, bc)
    z = complex_positions(uv)
    if pinned is None:
        z = centred(topology, z, mesh.area)
    solved = perf_counter()
    before = Residuals.of(residual(topology, corner_angles(mesh)))
    a = z[topology.corner]
    right, left = a[PREV] - a, a[NEXT] - a
    alpha = np.abs(np.angle(right * left.conj()))
    flipped = flipped_faces(z, topology.corner)
    outcome = Outcome.FLIPPED if len(flipped) else Outcome.VALID
    message = f"faces {some(flipped)} are flipped" if len(flipped) else "no triangle is flipped"
    return Flattening(
        uv=coordinates(z),
        angles=np.ascontiguousarray(alpha.T),
        method="lscm",
        outcome=outcome,
        message=message,
        flipped=flipped,
        steps=(),
        before=before,
        after=Residuals.of(residual(topology, alpha)),
        gap=0.0,
        layout="least-squares",
        solver="none",
        layout_solver="igl.lscm",
        seconds={"layout": solved - start},
    )
