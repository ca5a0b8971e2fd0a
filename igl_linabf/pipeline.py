"""Linear and converged ABF of a checked mesh: how many steps, which layout, and how it ended."""

from __future__ import annotations

import operator
import warnings
from dataclasses import replace
from time import perf_counter
from typing import Literal

import numpy as np

from .abf import ABF
from .angles import corner_angles, initial_estimate, residual
from .errors import FallbackWarning, some, stack_level
from .layout import GAP, Layout, LayoutName, Pins, check_method, develop_boundary, lay_out
from .linabf import AngleSolver
from .mesh import Mesh, coordinates, signed_double_areas
from .result import Flattening, Hole, Outcome, Residuals
from .solver import SolverName, Solvers
from .topology import BoolArray, ComplexArray, FloatArray, IntArray

Iterations = int | Literal["auto"]

LOOSE = 0.1  # relative residual to which "auto" solves a step and its chord
TIGHT = 0.01  # and to which a step that stands alone is solved
MOST = 12  # re-anchored iterations after which "auto" gives up
HOLE_GAP = 0.1  # relative gap of a hole's loop up to which "auto" leaves it to the least squares
TOL = 1e-8  # residual of the constraints below which nothing is left to do
ABF_TOL = 1e-4  # tolerance of converged ABF below which F/3nt keeps its first five digits
SPAN = 1e12  # ratio of area scales above which double precision runs out


class Attempt:
    """What the angle based methods share: from the initial estimate to the report.

    Attributes
    ----------
    angles : AngleSolver
        At the initial estimate, until a method moves it.
    """

    def __init__(
        self,
        mesh: Mesh,
        pinned: Pins | None,
        layout: LayoutName,
        threshold: float,
        solver: SolverName,
        safeguard: bool = True,
    ) -> None:
        check_method(layout)
        if not threshold >= 0:
            raise ValueError(f"threshold is {threshold!r}: use a number of radians from 0 on")
        start = perf_counter()
        self.mesh, self._pinned, self._layout, self._solvers = mesh, pinned, layout, Solvers(solver)
        alpha = corner_angles(mesh)
        self._estimate = initial_estimate(mesh.topology, alpha, threshold, to_triangles=safeguard)
        self._seconds = {"estimate": perf_counter() - start, "layout": 0.0}
        self.angles = AngleSolver(mesh.topology, self._estimate, self._solvers, limit=safeguard)
        self._before = Residuals.of(self.angles.residual)

    def lay_out(self) -> Layout:
        """The map of the present angles."""
        start, angles = perf_counter(), self.angles
        alpha, missing, topology = angles.alpha, angles.residual, self.mesh.topology
        if angles.invalid.any():
            alpha = _repaired(alpha, self._estimate, angles.invalid)
            missing = residual(topology, alpha)
        made = lay_out(
            topology,
            alpha,
            missing,
            self._layout,
            self._pinned,
            self.mesh.area,
            self._solvers,
            angles.pattern,
            angles.laplacian,
        )
        self._seconds["layout"] += perf_counter() - start
        return made

    def report(self, method: str, made: Layout, reached: bool, tried: str = "") -> Flattening:
        """The result, from the map and whether the method's tolerance was reached.

        `tried` says what was done to reach it, where it was not and should have been.
        """
        angles = self.angles
        flipped = flipped_faces(made.z, self.mesh.topology.corner)
        outcome, message = _judge(angles, self.mesh, made.z, flipped, reached, tried)
        return Flattening(
            uv=coordinates(made.z),
            angles=np.ascontiguousarray(angles.alpha.T),
            method=method,
            outcome=outcome,
            message=message,
            flipped=flipped,
            steps=tuple(angles.steps),
            before=self._before,
            after=Residuals.of(angles.residual),
            holes=Hole.all_of(self.mesh, angles.residual),
            gap=made.gap,
            layout=made.method,
            solver=angles.solver,
            layout_solver=made.solver,
            seconds={**self._seconds, **angles.seconds},
        )


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
    if rtol is not None and not rtol > 0:
        raise ValueError(f"rtol is {rtol!r}: use a positive number")
    attempt = Attempt(mesh, pinned, layout, threshold, solver, safeguard)
    angles, topology = attempt.angles, mesh.topology

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
        went_on = angles.limited  # a chord from angles beside their bound ends with far smaller ones
        if not went_on:
            if len(topology.loops) == 1:
                angles.chord(rtol or LOOSE)
                gap, allowed = develop_boundary(topology, angles.residual).gap, GAP
            else:  # least squares lays out, which draws no loop
                angles.step(rtol or LOOSE)
                gap, allowed = float(np.abs(angles.residual.closure.gap).max()), HOLE_GAP
            went_on = angles.limited or gap > allowed
        if not went_on:
            made = attempt.lay_out()
            went_on = len(flipped_faces(made.z, topology.corner)) > 0
        if went_on:
            iterate(MOST)
            made = None
    reached = angles.residual.largest <= tol
    tried = f"after {MOST} iterations" if went_on and not reached else ""
    return attempt.report("linabf", made or attempt.lay_out(), reached, tried)


def converged_abf(
    mesh: Mesh,
    pinned: Pins | None,
    *,
    layout: LayoutName = "auto",
    tol: float = ABF_TOL,
    threshold: float = 1.0,
    solver: SolverName = "auto",
) -> Flattening:
    """Converged ABF of a checked mesh; the options are those of `abf`."""
    if not tol > 0:
        raise ValueError(f"tol is {tol!r}: use a positive number, 1e-10 at the least")
    attempt = Attempt(mesh, pinned, layout, threshold, solver)
    abf = ABF(attempt.angles, tol)
    abf.run()
    tried = "" if abf.converged else "in its feasible form"
    result = attempt.report("abf", attempt.lay_out(), abf.converged, tried)
    held = np.flatnonzero(abf.bound.any(axis=0))
    if len(held):
        note = f"; angles of faces {some(held)} are held at a hundredth of their initial value"
        result = replace(result, message=result.message + note)
    return result


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
    angles: AngleSolver, mesh: Mesh, z: ComplexArray, flipped: IntArray, reached: bool, tried: str
) -> tuple[Outcome, str]:
    """The outcome, and the sentence that says it."""
    fit = f"the angles fit to {angles.residual.largest:.1e}"
    if angles.invalid.any():
        bad = np.flatnonzero(angles.invalid)
        return Outcome.ANGLES_INVALID, (
            f"the target angles of faces {some(bad)} left (0, pi), {len(flipped)} triangles of the map are "
            "flipped: use linear ABF with its safeguard, or converged ABF"
        )
    if not len(flipped):
        if reached:
            return Outcome.CONVERGED, f"no triangle is flipped, and {fit}"
        if not tried:
            return Outcome.VALID, f"no triangle is flipped; {fit}"
        return Outcome.NOT_CONVERGED, (
            f"no triangle is flipped, but it did not converge {tried}, {fit}: look for degenerate faces, or "
            "cut the mesh"
        )
    where = f"faces {some(flipped)} are flipped or collapsed"
    if not reached:
        more = f"it did not converge {tried}" if tried else "take more iterations"
        return Outcome.FLIPPED, f"{where}: {fit} only; {more}, or cut the mesh"
    scale = np.abs(signed_double_areas(z, mesh.topology.corner)) / mesh.double_area
    span = float(scale.max() / max(scale.min(), 1e-32 * scale.max()))
    if span > SPAN:
        return Outcome.FLIPPED, (
            f"{where}: {fit}, but the map's area scale varies by a factor of {span:.0e} or more, which "
            "double precision does not hold; cut the mesh open towards these faces (igl.cut_mesh)"
        )
    return Outcome.FLIPPED, f"{where}, though {fit}: cut the mesh open towards them"


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
