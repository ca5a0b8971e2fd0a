"""Linear ABF of a checked mesh: how many steps, which layout, and how it ended."""

from __future__ import annotations

import operator
import warnings
from time import perf_counter
from typing import Literal

import numpy as np

from .angles import corner_angles, initial_estimate, residual
from .errors import FallbackWarning, some, stack_level
from .layout import GAP, Layout, LayoutName, Pins, check_method, develop_boundary, lay_out
from .linabf import AngleSolver
from .mesh import Mesh, coordinates, signed_double_areas
from .result import Flattening, Outcome, Residuals
from .solver import SolverName, Solvers
from .topology import BoolArray, ComplexArray, FloatArray, IntArray

Iterations = int | Literal["auto"]

LOOSE = 0.1  # relative residual to which "auto" solves a step and its chord
TIGHT = 0.01  # and to which a step that stands alone is solved
MOST = 12  # re-anchored iterations after which "auto" gives up
TOL = 1e-8  # residual of the constraints below which nothing is left to do
SPAN = 1e12  # ratio of area scales above which double precision runs out


def linear_abf(
    mesh: Mesh,
    pinned: Pins | None,
    *,
    iterations: Iterations = "auto",
    layout: LayoutName = "auto",
    rtol: float | None = None,
    tol: float = TOL,
    threshold: float = 1.0,
    safeguard: bool = True,
    solver: SolverName = "auto",
) -> Flattening:
    """Linear ABF of a checked mesh; the options are those of `linabf`."""
    count = _count(iterations)
    check_method(layout)
    _check_positive(rtol=rtol, threshold=threshold)
    start = perf_counter()
    topology, solvers = mesh.topology, Solvers(solver)
    estimate = initial_estimate(topology, corner_angles(mesh), threshold, to_triangles=safeguard)
    seconds = {"estimate": perf_counter() - start, "layout": 0.0}
    angles = AngleSolver(topology, estimate, solvers, limit=safeguard)
    before = Residuals.of(angles.residual)

    def laid_out() -> Layout:
        began = perf_counter()
        alpha, missing = angles.alpha, angles.residual
        if angles.invalid.any():
            alpha = _repaired(alpha, estimate, angles.invalid)
            missing = residual(topology, alpha)
        made = lay_out(
            topology, alpha, missing, layout, pinned, mesh.area, solvers, angles.pattern, angles.laplacian
        )
        seconds["layout"] += perf_counter() - began
        return made

    def iterate(most: int) -> None:
        for _ in range(most):
            if angles.residual.largest <= tol or angles.invalid.any():
                return
            angles.step(rtol or TIGHT)

    made, went_on = None, False
    if count is not None:
        iterate(count)
    elif angles.residual.largest > tol:
        angles.step(rtol or LOOSE)
        angles.chord(rtol or LOOSE)
        went_on = angles.limited or develop_boundary(topology, angles.residual).gap > GAP
        if not went_on:
            made = laid_out()
            went_on = len(flipped_faces(made.z, topology.corner)) > 0
        if went_on:
            iterate(MOST)
            made = None
    made = made or laid_out()
    flipped = flipped_faces(made.z, topology.corner)
    outcome, message = _judge(angles, mesh, made.z, flipped, tol, went_on)
    return Flattening(
        uv=coordinates(made.z),
        angles=np.ascontiguousarray(angles.alpha.T),
        method="linabf",
        outcome=outcome,
        message=message,
        flipped=flipped,
        steps=tuple(angles.steps),
        before=before,
        after=Residuals.of(angles.residual),
        gap=made.gap,
        layout=made.method,
        solver=angles.solver,
        layout_solver=made.solver,
        seconds={**seconds, **angles.seconds},
    )


def flipped_faces(z: ComplexArray, corner: IntArray) -> IntArray:
    """Faces whose area in the map is not positive."""
    return np.flatnonzero(~(signed_double_areas(z, corner) > 0))


def _repaired(alpha: FloatArray, estimate: FloatArray, invalid: BoolArray) -> FloatArray:
    """The initial angles, as triangles', where the bare scheme left (0, pi)."""
    bad = np.flatnonzero(invalid)
    warnings.warn(
        f"the target angles of faces {some(bad)} are not within (0, pi): "
        "they are laid out with their initial angles",
        FallbackWarning,
        stacklevel=stack_level(),
    )
    return np.where(invalid, np.pi * estimate / estimate.sum(axis=0), alpha)


def _judge(
    angles: AngleSolver, mesh: Mesh, z: ComplexArray, flipped: IntArray, tol: float, went_on: bool
) -> tuple[Outcome, str]:
    """The outcome, and the sentence that says it."""
    missing = angles.residual.largest
    if angles.invalid.any():
        bad = np.flatnonzero(angles.invalid)
        return Outcome.ANGLES_INVALID, (
            f"the target angles of faces {some(bad)} left (0, pi), {len(flipped)} triangles of the map are "
            "flipped: use safeguard=True"
        )
    if not len(flipped):
        if missing <= tol:
            return Outcome.CONVERGED, f"no triangle is flipped, and the angles fit to {missing:.1e}"
        if went_on:
            return Outcome.NOT_CONVERGED, (
                f"no triangle is flipped, but after {MOST} iterations the angles still miss {missing:.1e}: "
                "look for degenerate faces, or cut the mesh"
            )
        return Outcome.VALID, f"no triangle is flipped; the angles fit to {missing:.1e}"
    where = f"faces {some(flipped)} are flipped or collapsed"
    if missing > tol:
        more = f"after {MOST} iterations the angles still miss" if went_on else "the angles miss"
        return Outcome.FLIPPED, f"{where}: {more} {missing:.1e}; take more iterations, or cut the mesh"
    scale = np.abs(signed_double_areas(z, mesh.topology.corner)) / mesh.double_area
    span = float(scale.max() / max(scale.min(), 1e-32 * scale.max()))
    if span > SPAN:
        return Outcome.FLIPPED, (
            f"{where}: the angles fit to {missing:.1e}, but the map's area scale varies by a factor of "
            f"{span:.0e} or more, which double precision does not hold; cut the mesh open towards "
            "these faces (igl.cut_mesh)"
        )
    return Outcome.FLIPPED, f"{where}, though the angles fit to {missing:.1e}: cut the mesh open towards them"


def _count(iterations: Iterations) -> int | None:
    if iterations == "auto":
        return None
    try:
        count = operator.index(iterations)
    except TypeError:
        count = 0
    if count < 1:
        raise ValueError(f"iterations is {iterations!r}: use 'auto' or an integer from 1 on")
    return count


def _check_positive(**values: float | None) -> None:
    for name, value in values.items():
        if value is not None and not value > 0:
            raise ValueError(f"{name} is {value!r}: use a positive number")
