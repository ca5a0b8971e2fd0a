"""Linear ABF's two solves and a drawn boundary, for many disks side by side."""

from dataclasses import dataclass

import numpy as np

from .._core import centred
from .._runtime import timed
from .._types import BoolArray, FloatArray, IntArray
from ..angles import (
    AngleProblem,
    DiskBlocks,
    State,
    StepAndChord,
    constraints_of,
    initial_estimate,
    open_caps,
    step_and_chord,
)
from ..layouts import develop_boundary, harmonic
from ..linalg import Solvers
from ..surface import Disks, bounded_ratio, coordinates, signed_double_areas
from .fallbacks import STEP_AND_CHORD_RTOL
from .methods import LinABF


@dataclass(frozen=True, eq=False)
class LinearBatch:
    """Disks after linear ABF's step and chord, laid out.

    Attributes
    ----------
    disks : Disks
    stepped : StepAndChord
    good : (#disks,) bool
        Those for which this is enough.
    uv : (#V, 2) float64
    F, angles : (#F, 3) int64 and float64
        Of each disk for itself.
    gap, ratio : (#disks,) float64
        Of the developed boundary; of the largest area scale to the smallest one.
    solver : str
        Of the layout.
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


def linear_batch(disks: Disks, method: LinABF) -> LinearBatch:
    """Flatten disks side by side, as far as a step and a chord of each do.

    Raises
    ------
    NotPositiveDefiniteError, SingularSystemError
        The system of one of the disks is singular in double precision.
    """
    solvers, vertices, faces, topology = Solvers(method.solver), disks.vertices, disks.faces, disks.topology
    with timed("estimate"):
        alpha, caps = open_caps(np.arctan2(disks.double_area, disks.dot))
        estimate = initial_estimate(topology, alpha, method.threshold)
    with timed("assembly"):
        constraints = constraints_of(topology)
        problem = AngleProblem(constraints, estimate, solvers, side_by_side=DiskBlocks.of(constraints, disks))
    stepped = step_and_chord(State(problem, problem.start), method.rtol or STEP_AND_CHORD_RTOL, method.tol)
    at, lin = stepped.state.at, stepped.state.lin
    with (
        timed("layout"),
        np.errstate(divide="ignore", invalid="ignore"),
    ):  # of angles that are not to be drawn
        boundary = develop_boundary(constraints, at.residual)
        z, solver = harmonic(boundary, at, constraints, None if lin is None else lin.laplacian, solvers)
        areas = signed_double_areas(z, topology.corner)
        scale = np.abs(areas)
        z = centred(z, topology.corner, scale, disks.area, vertices.start, faces.start)
        scale /= disks.double_area
    good = stepped.good & ~faces.any(~(areas > 0)) & (boundary.gaps <= method.gap)
    good[np.searchsorted(faces.start, caps, side="right") - 1] = False  # that is to be warned of
    return LinearBatch(
        disks=disks,
        stepped=stepped,
        good=good,
        uv=coordinates(z),
        F=topology.corner.T - faces.repeat(vertices.start[:-1])[:, None],
        angles=np.ascontiguousarray(at.alpha.T),
        gap=boundary.gaps,
        ratio=bounded_ratio(faces.max(scale), faces.min(scale)),
        solver=solver,
    )
