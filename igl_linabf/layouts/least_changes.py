"""Converged ABF in the plane: from a map without flipped triangles to the one whose angles change least.

The unknowns are the positions, so every map on the way is flat. In angles the constraints curve as 1 / alpha
does, and steps near vanishing angles are short; the angles of a map are nearly linear in its positions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._runtime import advance
from .._types import BoolArray, ComplexArray, FloatArray
from ..linalg import Factor, NotPositiveDefiniteError, Solvers
from ..surface import Topology
from .constants import (
    BOUND_SHARE,
    BOUND_TOL,
    CURVED_CHANGE,
    CURVED_PATCH_RINGS,
    LARGEST_CURVED_PATCHES,
    LONG_STEP,
    MAX_BOUNDS,
    MAX_PATCH_STEPS,
    MAX_PLANE_HALVINGS,
    MAX_PLANE_STEPS,
    MAX_TRIAL_CORRECTIONS,
    PATCH_GAIN,
    PLANE_DAMPING,
    SHORTEST_TRIAL,
    SUFFICIENT_DECREASE,
    ZIGZAG_GAIN,
)
from .isometry import Hessians
from .plane_steps import BoundedStep, LinearAngles, Plane, bounded_step


@dataclass(frozen=True, eq=False)
class LeastChange:
    """Where the steps ended.

    Attributes
    ----------
    z : (#V,) complex128
    angles : (3, #F) float64
        Of the map.
    held : (3, #F) bool
        The angles at their lower bound.
    steps : int
    gain : float
        What another step promises, relative to the objective.
    """

    z: ComplexArray
    angles: FloatArray
    held: BoolArray
    steps: int
    gain: float


@dataclass(frozen=True, eq=False)
class _MapOnTheWay:
    """A map on the way: its positions, its angles, the objective, and the angles that are held there."""

    z: ComplexArray
    alpha: FloatArray
    value: float
    held: BoolArray


def least_change(
    topology: Topology,
    estimate: FloatArray,
    bound: FloatArray,
    start: ComplexArray,
    enough: float,
    solvers: Solvers,
) -> LeastChange | None:
    """Minimise sum ((alpha - alpha_0) / alpha_0)^2 over maps, from one without flipped triangles.

    Gauss-Newton steps with the angles' bounds as inequalities, each by one factor of the normal equations
    over the positions. A step takes no angle below its bound, nor more than a share of the way to zero. Where
    it changes a few angles by so much that they are not linear, further steps follow in patches around these.

    Parameters
    ----------
    topology : Topology
    estimate, bound : (3, #F) float64
        alpha_0, and the least angles.
    start : (#V,) complex128
    enough : float
        Relative gain of the objective that may be left to further steps.
    solvers : Solvers

    Returns
    -------
    LeastChange or None
        None if the normal equations are singular in double precision, or the positions' digits are too few.
    """
    plane = Plane(topology.corner, estimate, bound, topology.n)
    return _descend_in_plane(plane, plane.centred(start), enough, solvers)


def _descend_in_plane(
    plane: Plane, z: ComplexArray, enough: float, solvers: Solvers, *, whole: bool = True
) -> LeastChange | None:
    """`least_change` over the positions that move; in a patch, not the `whole`, there are no more patches."""
    hessians, last = Hessians(plane.corner, len(z), solvers, plane.free), np.inf
    past: list[ComplexArray] = []
    at = _MapOnTheWay(z, *plane.measured(z), np.zeros(plane.estimate.shape, dtype=bool))
    most = MAX_PLANE_STEPS if whole else MAX_PATCH_STEPS
    for k in range(most + 1):
        here = LinearAngles.of(plane, at.z, at.alpha)
        if here.rounding() > enough * at.value:
            return None
        try:
            rows = (here.rows / plane.estimate[:, None]).reshape(-1, plane.corner.shape[1])
            factor = hessians.factored(rows, here.springs(), PLANE_DAMPING)
            step = bounded_step(here, hessians, factor, at.held)
        except NotPositiveDefiniteError:
            return None
        promised = -float((here.gradient * step.e).sum())  # half the slope: what the model falls by
        done = LeastChange(at.z, at.alpha, step.held, k, promised / at.value)
        broken = plane.broken(at.alpha)  # a step that brings angles back to their bounds may go uphill
        if k == most or (promised <= enough * at.value and broken <= BOUND_TOL):
            return done
        found = _search_step(here, step, factor, at.value, promised, broken)
        if found is None:
            return done
        past, before = [at.z, *past][:2], at.value
        at, scale = found
        if len(past) > 1 and before - at.value > ZIGZAG_GAIN * last:
            at = _extrapolate(plane, at, at.z - past[1])
        if whole:
            at = _relax_patches(plane, at, here.alpha, enough, solvers)
        advance("feasible", 0.05)
        gain = before - at.value
        # the gains fall like a geometric series: what is left of it is foreseen
        foreseen = gain**2 / (last - gain) if 0 < gain < last < np.inf else np.inf
        last = gain
        if foreseen <= enough * at.value and scale >= LONG_STEP:
            return LeastChange(at.z, at.alpha, at.held, k + 1, foreseen / at.value)
    return done


def _search_step(
    here: LinearAngles, step: BoundedStep, factor: Factor, value: float, promised: float, broken: float
) -> tuple[_MapOnTheWay, float] | None:
    """The map after a step that lets the objective fall, and the step's scale; None if none does.

    Where bounds are `broken`, by the share that is missing to one, it may let that fall instead.
    """
    plane, scale = here.plane, 1.0
    least = np.minimum(plane.bound, here.alpha)
    for _ in range(MAX_PLANE_HALVINGS):
        z = here.z + scale * step.dz
        alpha, after = plane.measured(z)
        for _ in range(MAX_TRIAL_CORRECTIONS):
            # angles stray from their bounds by the square of the step, also of those that it does not meet
            below = np.flatnonzero(alpha < (1 - BOUND_TOL) * least)
            more = np.setdiff1d(below, step.index, assume_unique=True)
            if not (alpha > 0).all() or len(more) + len(step.index) > MAX_BOUNDS:
                break
            if len(more):
                step = step.with_more(more)
            if not len(step.index):
                break
            wanted = np.maximum(here.alpha + scale * step.e, least).ravel()[step.index]
            try:
                z = z + step.pushed(wanted - alpha.ravel()[step.index])
            except NotPositiveDefiniteError:
                break
            alpha, after = plane.measured(z)
            if (alpha >= (1 - BOUND_TOL) * least).all():
                break
        valid = bool((alpha > BOUND_SHARE * least).all())
        falls = after <= value - SUFFICIENT_DECREASE * scale * 2 * promised and promised > 0
        left = plane.broken(alpha)
        falls = falls and left <= max(broken, BOUND_TOL)
        if valid and (falls or (broken > BOUND_TOL and left <= BOUND_SHARE * broken)):
            return _MapOnTheWay(z, alpha, after, step.held), scale
        shorter = LONG_STEP
        if valid:  # where the parabola through both has its minimum
            shorter = scale * promised / (after - value + 2 * scale * promised)
        scale *= min(max(shorter, SHORTEST_TRIAL), LONG_STEP)
    return None


def _extrapolate(plane: Plane, at: _MapOnTheWay, way: ComplexArray) -> _MapOnTheWay:
    """As far along the way of the last two steps as the objective falls (parallel tangents)."""
    length, start, least = 1.0, at.z, (1 - BOUND_TOL) * np.minimum(plane.bound, at.alpha)
    while True:
        z = start + length * way
        alpha, value = plane.measured(z)
        if not (value < at.value and (alpha > least).all()):
            return at
        at, length = _MapOnTheWay(z, alpha, value, at.held), 2 * length


def _relax_patches(
    plane: Plane, at: _MapOnTheWay, before: FloatArray, enough: float, solvers: Solvers
) -> _MapOnTheWay:
    """The map after further steps in patches around the triangles that the last one changed most.

    Near vanishing angles a step is short, and its model is good for little else than the few triangles there.
    So they are brought to rest first, with the rim of the patch fixed (nonlinear elimination, Cai and Keyes
    2002). Where patches would be large, or nothing is gained, the map stays as it is.

    Parameters
    ----------
    plane : Plane
    at : _MapOnTheWay
    before : (3, #F) float64
        The angles before the last step.
    enough, solvers
        As for `least_change`.
    """
    corner, inside = plane.corner, np.zeros(len(at.z), dtype=bool)
    curved = (np.abs(at.alpha - before) > CURVED_CHANGE * np.minimum(at.alpha, before)).any(axis=0)
    if not curved.any():
        return at
    inside[corner[:, curved]] = True
    for _ in range(CURVED_PATCH_RINGS):
        inside[corner[:, inside[corner].any(axis=0)]] = True
        if np.count_nonzero(inside) > LARGEST_CURVED_PATCHES * len(at.z):
            return at
    faces = np.flatnonzero(inside[corner].any(axis=0))
    rim = np.zeros_like(inside)
    rim[corner[:, faces]] = True
    used = np.concatenate((np.flatnonzero(inside), np.flatnonzero(rim & ~inside)))
    number = np.empty(len(at.z), dtype=np.int64)
    number[used] = np.arange(len(used))
    patch = plane.part(faces, number[corner[:, faces]], int(np.count_nonzero(inside)), at.alpha, at.value)
    made = _descend_in_plane(patch, at.z[used], PATCH_GAIN * enough, solvers, whole=False)
    if made is None:
        return at
    z, held = at.z.copy(), at.held.copy()
    z[used], held[:, faces] = made.z, made.held
    after = _MapOnTheWay(z, *plane.measured(z), held)
    missing = plane.broken(at.alpha)
    repaired = missing > BOUND_TOL and plane.broken(after.alpha) <= BOUND_SHARE * missing
    return after if after.value < at.value or repaired else at
