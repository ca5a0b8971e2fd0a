"""The first rung of the ladder, linear ABF's two solves and a drawn boundary, for many disks at a time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import kernels
from .._runtime import timed
from .._types import BoolArray, FloatArray, IntArray
from ..angles import (
    CAP_ANGLE,
    MOST_STEPS,
    REACH,
    SLIVER_OF_SMALL,
    AngleProblem,
    constraints_of,
    initial_estimate,
    opened,
    rows_of,
    step_and_chord,
)
from ..layouts import flat_disks
from ..linalg import Cholesky, Solvers
from ..surface import LARGEST_COORDINATE, SMALLEST_COORDINATE, Disks, Parts, coordinates
from .ladder import ONE_SYSTEM_RTOL
from .methods import LinABF


@dataclass(frozen=True, eq=False)
class FlatMany:
    """Disks after the first rung.

    Attributes
    ----------
    good, thin : (#disks,) bool
        Those for which it is enough; those among others that have slivers.
    has_rows : (#disks,) bool
        Those with interior vertices.
    vertices, faces : Parts
    uv : (#V, 2) float64
    F : (#F, 3) int64
        Of each disk for itself.
    angles : (#F, 3) float64
    families : (3, 3, #disks) float64
        Largest residuals of vertices, triangles and wheels at the start, after the step, after the chord.
    inner_steps : (2, #disks) int64
    gap, ratio : (#disks,) float64
        Of the developed boundary; of the largest area scale to the smallest one.
    how, solver : str
        What solved the steps, and the layout.
    """

    good: BoolArray
    thin: BoolArray
    has_rows: BoolArray
    vertices: Parts
    faces: Parts
    uv: FloatArray
    F: IntArray
    angles: FloatArray
    families: FloatArray
    inner_steps: IntArray
    gap: FloatArray
    ratio: FloatArray
    how: str
    solver: str


def by_loops(meshes: Sequence[tuple[FloatArray, IntArray]], method: LinABF) -> FlatMany:
    """By compiled loops, one small disk after the other. What is no disk is not good."""
    vertices, faces = (Parts.of_sizes([len(mesh[k]) for mesh in meshes]) for k in (0, 1))
    V, F = np.concatenate([V for V, _ in meshes]), np.concatenate([F for _, F in meshes])
    limits = kernels.Limits(
        smallest=SMALLEST_COORDINATE,
        largest=LARGEST_COORDINATE,
        cap=CAP_ANGLE,
        threshold=float(method.threshold),
        rtol=float(method.rtol or ONE_SYSTEM_RTOL),
        tol=float(method.tol),
        most_steps=MOST_STEPS,
        disparity=SLIVER_OF_SMALL + 1 / SLIVER_OF_SMALL,
        reach=REACH,
        gap=method.gap,
    )
    state, uv, angles, figures = kernels.flat_disks(V, F, vertices.start, faces.start, limits)
    families, inner_steps, (gap, ratio) = np.split(np.ascontiguousarray(figures.T), (9, 11))
    return FlatMany(
        good=(state == kernels.STILL) | (state == kernels.STEPPED),
        thin=state == kernels.THIN,
        has_rows=faces.sizes > vertices.sizes - 2,  # by Euler, of a disk
        vertices=vertices,
        faces=faces,
        uv=uv,
        F=F,
        angles=angles,
        families=families.reshape(3, 3, -1),
        inner_steps=inner_steps.astype(np.int64),
        gap=gap,
        ratio=ratio,
        how=f"conjugate gradients, {Cholesky.name}",
        solver=Cholesky.name,
    )


def by_one_system(disks: Disks, method: LinABF) -> FlatMany:
    """By one system for all.

    Raises
    ------
    NotPositiveDefiniteError, SingularSystemError
        The system of one of the disks is singular in double precision.
    """
    solvers, vertices, faces = Solvers(method.solver), disks.vertices, disks.faces
    with timed("estimate"):
        alpha, caps = opened(np.arctan2(disks.double_area, disks.dot))
        estimate = initial_estimate(disks.topology, alpha, method.threshold)
    with timed("assembly"):
        problem = AngleProblem(constraints_of(disks.topology), estimate, solvers)
    stepped = step_and_chord(problem, disks, method.rtol or ONE_SYSTEM_RTOL, method.tol)
    with timed("layout"):
        flat = flat_disks(disks, problem.constraints, stepped.at, solvers)
    good = stepped.good & ~flat.flipped & (flat.gap <= method.gap)
    good[np.searchsorted(faces.start, caps, side="right") - 1] = False  # that is to be warned of
    return FlatMany(
        good=good,
        thin=stepped.thin,
        has_rows=rows_of(problem.constraints, disks).sizes > 0,
        vertices=vertices,
        faces=faces,
        uv=coordinates(flat.z),
        F=disks.topology.corner.T - faces.spread(vertices.start[:-1])[:, None],
        angles=np.ascontiguousarray(stepped.at.alpha.T),
        families=stepped.families,
        inner_steps=stepped.inner_steps,
        gap=flat.gap,
        ratio=flat.ratio,
        how=stepped.how,
        solver=flat.solver,
    )
