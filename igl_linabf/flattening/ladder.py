"""Linear and converged ABF of a checked mesh: how many steps, which layout, and how it ended."""

from __future__ import annotations

import operator
import warnings
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Literal

import numpy as np

from .._runtime import advance
from ..angles import ABF, CAP_ANGLE, AngleSolver, corner_angles, initial_estimate, opened, residual
from ..errors import FallbackWarning, MeshWarning, some, stack_level
from ..layouts import GAP, Layout, LayoutName, check_method, develop_boundary, injective, lay_out, placed
from ..linalg import SolverName, Solvers, memory
from ..surface import (
    ALL_DIGITS,
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    Mesh,
    Pins,
    coordinates,
    flat_angles,
    flipped_faces,
    span,
)
from .outcome import judge
from .result import Flattening, Guarantee, Hole, Residuals, Rung, RungName

Iterations = int | Literal["auto"]

LOOSE = 0.1  # relative residual to which "auto" solves a step and its chord
TIGHT = 0.01  # and to which a step that stands alone is solved
MOST = 12  # re-anchored iterations after which "auto" gives up
HOLE_GAP = 0.1  # relative gap of a hole's loop up to which "auto" leaves it to the least squares
TOL = 1e-8  # residual of the constraints below which nothing is left to do
DIVERGES = "it does not converge"
NOT_FEASIBLY = "it did not converge in its feasible form"
ABF_TOL = 1e-4  # tolerance of converged ABF below which F/3nt keeps its first five digits


@dataclass(frozen=True, eq=False)
class _Drawn:
    """A map, and the angles that it was laid out from."""

    layout: Layout
    alpha: FloatArray
    flipped: IntArray
    rung: Rung


class Attempt:
    """What the angle based methods share: from the initial estimate up the ladder to the report.

    Attributes
    ----------
    angles : AngleSolver
        At the initial estimate, until a method moves it.
    ladder : list of Rung
        What was tried so far.
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
        least_squares = layout == "least-squares" or len(mesh.topology.loops) > 1
        factor = memory.factor_bytes(mesh.topology.n, 16) if least_squares else 0
        memory.check(len(mesh.double_area), factor)
        self.mesh, self._pinned, self._layout, self._solvers = mesh, pinned, layout, Solvers(solver)
        alpha, self._caps = opened(corner_angles(mesh))
        if len(self._caps):
            warnings.warn(
                f"faces {some(self._caps)} have an angle within {CAP_ANGLE:g} rad of pi: they are "
                "flattened as if it were that far from pi; collapse them, or flip their longest edges",
                MeshWarning,
                stacklevel=stack_level(),
            )
        self.estimate = initial_estimate(mesh.topology, alpha, threshold, to_triangles=safeguard)
        self._seconds = {"estimate": perf_counter() - start, "layout": 0.0}
        self.angles = AngleSolver(mesh.topology, self.estimate, self._solvers, limit=safeguard)
        self._before = Residuals.of(self.angles.residual)
        self.ladder: list[Rung] = []
        self._best: _Drawn | None = None

    def leave(self, rung: RungName, failed: str) -> None:
        """Give up a rung before its layout."""
        self.ladder.append(Rung(rung, None, self.angles.residual.largest, failed))

    def draw(self, rung: RungName) -> bool:
        """Lay out the present angles; whether no triangle is flipped.

        The map with the fewest flips is kept, of equal ones the latest, whose angles fit best.
        """
        layout, alpha = self._laid_out(), self.angles.alpha
        flipped = flipped_faces(layout.z, self.mesh.topology.corner)
        flips = len(flipped)
        failed = f"{flips} flipped triangle{'s' * (flips > 1)}" if flips else ""
        self.ladder.append(Rung(rung, flips, self.angles.residual.largest, failed))
        if self._best is None or flips <= len(self._best.flipped):
            self._best = _Drawn(layout, alpha, flipped, self.ladder[-1])
        return not flips

    def force(self) -> None:
        """Make a map without flipped triangles of the best one, if that has some."""
        best = self.settle()
        if not len(best.flipped):
            return
        start, mesh = perf_counter(), self.mesh

        def place(z: ComplexArray) -> ComplexArray:
            return placed(mesh.topology, z, mesh.area, self._pinned)

        made = injective(mesh, best.layout.z, place, self._solvers)
        self._seconds["injective"] = perf_counter() - start
        if made is None:
            self.leave("injective", "every start has flipped triangles in double precision")
            return
        alpha = flat_angles(made.z, mesh.topology.corner)
        how = f"{made.iterations} iterations from {made.start}"
        slim = replace(best.layout, z=made.z, method="SLIM", solver=f"igl's SLIM, {how}")
        self.angles.place(alpha)
        self.ladder.append(Rung("injective", 0, self.angles.residual.largest, ""))
        self._best = _Drawn(slim, alpha, np.empty(0, dtype=np.int64), self.ladder[-1])

    def settle(self) -> _Drawn:
        """The map with the fewest flipped triangles, to whose angles `angles` goes back."""
        assert self._best is not None
        if self.angles.alpha is not self._best.alpha:
            self.angles.place(self._best.alpha)
        return self._best

    def report(self, method: str, reached: bool, tried: str = "") -> Flattening:
        """The result, from the best map and whether the method's tolerance was reached.

        `tried` says what was done to reach it, where it was not and should have been.
        """
        angles, best = self.angles, self.settle()
        made = best.layout
        outcome, message = judge(angles, self.mesh, made, best.flipped, reached, tried)
        return Flattening(
            uv=coordinates(made.z),
            angles=np.ascontiguousarray(best.alpha.T),
            method=method,
            outcome=outcome,
            message=message,
            flipped=best.flipped,
            repaired=self._caps,
            ladder=tuple(self.ladder),
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

    def _laid_out(self) -> Layout:
        start, angles = perf_counter(), self.angles
        alpha, missing, topology = angles.alpha, angles.residual, self.mesh.topology
        if angles.invalid.any():
            alpha = _repaired(alpha, self.estimate, angles.invalid)
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
        advance("layout", 0.5)
        return made


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
    guarantee: Guarantee | None = None,
    solver: SolverName = "auto",
) -> Flattening:
    """Linear ABF of a checked mesh; the options are those of `linabf`."""
    count = _count(iterations)
    _check_guarantee(guarantee)
    if rtol is not None and not rtol > 0:
        raise ValueError(f"rtol is {rtol!r}: use a positive number")
    attempt = Attempt(mesh, pinned, layout, threshold, solver, safeguard)
    angles = attempt.angles

    def iterate(most: int) -> None:
        for _ in range(most):
            if angles.residual.largest <= tol or angles.invalid.any():
                return
            angles.step(rtol or TIGHT)

    tried, converged = "", False
    if count is not None:
        iterate(count)
        attempt.draw("linear step" if len(angles.steps) <= 1 else "active set")
    elif not _first_rung(attempt, rtol or LOOSE, tol):
        iterate(MOST)
        reached = angles.residual.largest <= tol
        tried = "converged angles flip more" if reached else f"it did not converge after {MOST} iterations"
        good = attempt.draw("active set")
        if not good and safeguard and not (reached and span(mesh, attempt.settle().layout.z) > ALL_DIGITS):
            angles.place(attempt.estimate)
            abf = ABF(angles, ABF_TOL)
            abf.run(feasibly=not reached)  # flips of converged angles are those of rounding
            if abf.converged or abf.feasible:
                attempt.draw("feasible ABF" if abf.feasible else "converged ABF")
            else:
                attempt.leave("converged ABF", DIVERGES)
            if attempt.settle().rung is attempt.ladder[-1]:
                tried, converged = NOT_FEASIBLY, abf.converged
    if guarantee:
        attempt.force()
    attempt.settle()
    reached = converged or angles.residual.largest <= tol
    return attempt.report("linabf", reached, "" if reached else tried)


def _first_rung(attempt: Attempt, rtol: float, tol: float) -> bool:
    """The linear step, and the second solve with its system; whether that is enough."""
    angles, topology = attempt.angles, attempt.mesh.topology
    if angles.residual.largest > tol:
        angles.step(rtol)
        # a chord that starts from cut-short steps ends with far smaller angles than a step
        if not angles.limited:
            if len(topology.loops) == 1:
                angles.chord(rtol)
                gap, allowed = develop_boundary(topology, angles.residual).gap, GAP
            else:  # least squares lays out, which draws no loop
                angles.step(rtol)
                gap, allowed = float(np.abs(angles.residual.closure.gap).max()), HOLE_GAP
            if gap > allowed:
                attempt.leave("linear step", f"a loop misses its beginning by {gap:.1%} of its length")
                return False
        limited = angles.steps[-1].limited
        if limited:
            attempt.leave("linear step", f"the whole of it takes angles of {limited} triangles to zero")
            return False
    return attempt.draw("linear step")


def converged_abf(
    mesh: Mesh,
    pinned: Pins | None,
    *,
    layout: LayoutName = "auto",
    tol: float = ABF_TOL,
    threshold: float = 1.0,
    guarantee: Guarantee | None = None,
    solver: SolverName = "auto",
) -> Flattening:
    """Converged ABF of a checked mesh; the options are those of `abf`."""
    _check_guarantee(guarantee)
    if not tol > 0:
        raise ValueError(f"tol is {tol!r}: use a positive number, 1e-10 at the least")
    attempt = Attempt(mesh, pinned, layout, threshold, solver)
    abf = ABF(attempt.angles, tol)
    abf.run()
    if abf.feasible:
        attempt.leave("converged ABF", DIVERGES)
    attempt.draw("feasible ABF" if abf.feasible else "converged ABF")
    if guarantee:
        attempt.force()
    result = attempt.report("abf", abf.converged, "" if abf.converged else NOT_FEASIBLY)
    held = np.flatnonzero(abf.bound.any(axis=0))
    if len(held) and result.layout != "SLIM":
        note = f"; angles of faces {some(held)} are held at a hundredth of their initial value"
        result = replace(result, message=result.message + note)
    return result


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


def _check_guarantee(guarantee: str | None) -> None:
    if guarantee not in (None, "injective"):
        raise ValueError(f"guarantee is {guarantee!r}: use 'injective' or None")
