"""Converged ABF in the plane: from a map without flipped triangles to the one whose angles change least.

The unknowns are the positions, so every map on the way is flat. In angles the constraints curve as 1 / alpha
does, and steps near vanishing angles are short; the angles of a map are nearly linear in its positions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from .._runtime import advance
from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..linalg import Factored, NotPositiveDefiniteError, Solvers
from ..surface import NEXT, PREV, Topology
from .newton import Hessians, Springs

SLOW = 0.3  # share of the last step's gain, above which the steps zigzag along a valley
MAX_STEPS = 60
REACH = 0.9  # share of the way to a vanishing angle that a step may go
MOST_BOUNDS = 200  # angles at most that a step keeps from falling further; for others it is shortened
ROUNDS = 4  # in which these are found
KEPT = 0.9  # share of its bound below which rounding and curvature may let no angle fall
LESS = 0.9  # of what is missing to a bound may be left by a step that lets the objective rise
AT_BOUND = 1e-4  # share of its bound that may be missing to an angle
SUFFICIENT = 1e-4  # share of the promised fall that a step has to bring (Armijo)
HALVINGS = 25
FAR = 0.1  # scale of a step from which its gain tells of the next ones
SHORTEST, LONGEST = 0.1, 0.5  # share of a step's length that may be tried next
DAMPING = 1e-14  # of the diagonal: two springs hold the map, and far parts may be very small
REGULAR = 1e-12  # of the diagonal of the bounds' system: they may depend on each other
EPSILON = 2.0**-52


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
    over the positions. A step takes no angle below its bound, nor more than a share of the way to zero.

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
    plane = _Plane(topology.corner, estimate, bound)
    hessians = Hessians(topology.corner, topology.n, solvers)
    z, last = plane.centred(start), np.inf
    past: list[ComplexArray] = []
    held = np.zeros(estimate.shape, dtype=bool)
    alpha, value = plane.measured(z)
    for k in range(MAX_STEPS + 1):
        here = _Linear.of(plane, z, alpha)
        if here.rounding() > enough * value:
            return None
        try:
            factor = hessians.factored(here.rows / estimate[:, None], here.springs(), DAMPING)
        except NotPositiveDefiniteError:
            return None
        step = _bounded_step(here, hessians, factor, held)
        held = step.held
        promised = -float((here.gradient * step.e).sum())  # half the slope: what the model falls by
        done = LeastChange(z, alpha, held, k, promised / value)
        broken = plane.broken(alpha)  # a step that brings angles back to their bounds may go uphill
        if k == MAX_STEPS or (promised <= enough * value and broken <= AT_BOUND):
            return done
        found = _searched(plane, here, step, value, promised, broken)
        if found is None:
            return done
        past = [z, *past][:2]
        z, alpha, after, scale = found
        if len(past) > 1 and value - after > SLOW * last:
            z, alpha, after = _further(plane, z, z - past[1], alpha, after)
        advance("feasible", 0.05)
        gain, value = value - after, after
        # the gains fall like a geometric series: what is left of it is foreseen
        foreseen = gain**2 / (last - gain) if 0 < gain < last < np.inf else np.inf
        last = gain
        if foreseen <= enough * value and scale >= FAR:
            return LeastChange(z, alpha, held, k + 1, foreseen / value)
    return done


@dataclass(frozen=True, eq=False)
class _Plane:
    """The objective over the positions."""

    corner: IntArray
    estimate: FloatArray
    bound: FloatArray

    def sides(self, z: ComplexArray) -> ComplexArray:
        """(3, #F): the side opposite to each corner, counterclockwise."""
        return np.asarray(z[self.corner[PREV]] - z[self.corner[NEXT]])

    def centred(self, z: ComplexArray) -> ComplexArray:
        """The map moved so that the smallest triangle is at the origin, where positions have most digits."""
        smallest = np.abs(self.sides(z)).max(axis=0).argmin()
        return np.asarray(z - z[self.corner[0, smallest]])

    def broken(self, alpha: FloatArray) -> float:
        """The largest share of its bound that is missing to an angle; negative where none is."""
        return float((1 - alpha / self.bound).max())

    def measured(self, z: ComplexArray) -> tuple[FloatArray, float]:
        """The angles, negative in flipped triangles, and the objective."""
        side = self.sides(z)
        turn = -side[NEXT] * side[PREV].conj()
        alpha = np.arctan2(turn.imag, turn.real)
        return alpha, float((((alpha - self.estimate) / self.estimate) ** 2).sum())


@dataclass(frozen=True, eq=False)
class _Linear:
    """The angles as linear functions of the positions.

    Attributes
    ----------
    rows : (3, 6, #F) float64
        The slope of each angle by x of its triangle's corners, then by y.
    gradient : (3, #F) float64
        Half the objective's, by the angles.
    """

    plane: _Plane
    z: ComplexArray
    alpha: FloatArray
    inverse: ComplexArray
    rows: FloatArray
    gradient: FloatArray

    @classmethod
    def of(cls, plane: _Plane, z: ComplexArray, alpha: FloatArray) -> _Linear:
        inverse = 1 / plane.sides(z)
        slope = np.empty((3, 3, alpha.shape[1]), dtype=np.complex128)  # d alpha_k = Im sum slope[k, j] dz_j
        for k in range(3):
            slope[k, k] = inverse[NEXT[k]] + inverse[PREV[k]]
            slope[k, PREV[k]] = -inverse[NEXT[k]]
            slope[k, NEXT[k]] = -inverse[PREV[k]]
        rows = np.concatenate((slope.imag, slope.real), axis=1)
        return cls(plane, z, alpha, inverse, rows, (alpha - plane.estimate) / plane.estimate**2)

    def springs(self) -> Springs:
        """Two that are at rest: the objective does not change when a map is moved, turned or scaled."""
        ends = [self.z.real.argmin(), self.z.real.argmax()]
        stiffness = np.zeros(len(self.z))
        corner, size = self.plane.corner, (np.abs(self.inverse) ** 2).max(axis=0)
        for end in ends:
            stiffness[end] = size[(corner == end).any(axis=0)].max()
        return Springs(stiffness, self.z)

    def change(self, dz: ComplexArray) -> FloatArray:
        """Of the angles, (3, #F)."""
        side = (self.plane.sides(dz) * self.inverse).imag
        return np.asarray(side[NEXT] - side[PREV])

    def slopes(self, index: IntArray) -> tuple[IntArray, FloatArray]:
        """Of some angles, flat indices: the six positions that each depends on, and the slopes by them."""
        k, t = np.divmod(index, self.alpha.shape[1])
        corner = self.plane.corner[:, t]
        return np.concatenate((2 * corner, 2 * corner + 1)), self.rows[k, :, t].T

    def columns(self, index: IntArray) -> FloatArray:
        """The same by all positions: (2 #V, #index)."""
        place, slope = self.slopes(index)
        made = np.zeros((2 * len(self.z), len(index)))
        made[place, np.arange(len(index))] = slope
        return made

    def changes(self, index: IntArray, columns: FloatArray) -> FloatArray:
        """Of these angles by columns of positions, (#index, #columns)."""
        place, slope = self.slopes(index)
        return np.asarray((slope[:, :, None] * columns[place]).sum(axis=0))

    def rounding(self) -> float:
        """What rounding of the positions does to the objective, about."""
        far = EPSILON * np.abs(self.z[self.plane.corner]).max(axis=0) * np.abs(self.inverse).max(axis=0)
        return float(2 * np.sqrt(((self.gradient * far) ** 2).sum()))


@dataclass(frozen=True, eq=False)
class _BoundedStep:
    """A step, and what its bounds push: `columns` of positions for each of the bounds that it meets.

    Attributes
    ----------
    dz : (#V,) complex128
    e : (3, #F) float64
        The angles' linear change.
    held : (3, #F) bool
    index : (#held,) int64
    columns : (2 #V, #held) float64
    system : (#held, #held) float64
        The change of each of these angles by each of the columns.
    """

    dz: ComplexArray
    e: FloatArray
    held: BoolArray
    index: IntArray
    columns: FloatArray
    system: FloatArray


def _bounded_step(here: _Linear, hessians: Hessians, factor: Factored, held: BoolArray) -> _BoundedStep:
    """The minimum of the quadratic model under the bounds (Lawson, Hanson 1974, for the multipliers).

    Those of the last step and those that the step breaks so far come in.
    """
    least = np.maximum(-REACH * here.alpha, here.plane.bound - here.alpha).ravel()
    free = -factor.solve(hessians.slope((here.gradient[:, None] * here.rows).sum(axis=0), None, here.z))
    free_e = here.change(_complex(free)).ravel()
    index, columns, force = np.flatnonzero(held), np.empty((len(free), 0)), np.empty(0)
    x, e, system = free, free_e, np.empty((0, 0))
    more = index if len(index) else _broken(e, least, index)
    index = index[:0]
    for _ in range(ROUNDS):
        if not len(more):
            break
        columns = np.column_stack((columns, factor.solve(here.columns(more))))
        index = np.concatenate((index, more))
        system = here.changes(index, columns)
        force = _forces(system, least[index] - free_e[index])
        x = free + columns @ force
        e = here.change(_complex(x)).ravel()
        more = _broken(e, least, index)
    at = force > 0
    now = np.zeros(len(e), dtype=bool)
    now[index[at]] = True
    return _BoundedStep(
        _complex(x),
        e.reshape(here.alpha.shape),
        now.reshape(here.alpha.shape),
        index[at],
        columns[:, at],
        system[np.ix_(at, at)],
    )


def _broken(e: FloatArray, least: FloatArray, known: IntArray) -> IntArray:
    """The bounds that a step breaks, the worst first where they are too many."""
    broken = np.flatnonzero(e < least - 1e-6 * np.abs(least))
    broken = np.setdiff1d(broken, known, assume_unique=True)
    most = MOST_BOUNDS - len(known)
    if len(broken) > most:
        broken = np.sort(broken[np.argsort(e[broken] - least[broken], kind="stable")[:most]])
    return broken


def _forces(system: FloatArray, wanted: FloatArray) -> FloatArray:
    """Forces of bounds, at least zero: the least f^T system f / 2 - f^T wanted."""
    system = (system + system.T) / 2
    system = system + REGULAR * np.diag(np.diag(system))
    lower = np.linalg.cholesky(system)
    return np.asarray(nnls(lower.T, np.linalg.solve(lower, wanted), maxiter=100 * len(wanted))[0])


def _searched(
    plane: _Plane, here: _Linear, step: _BoundedStep, value: float, promised: float, broken: float
) -> tuple[ComplexArray, FloatArray, float, float] | None:
    """Positions, angles, objective and scale of a step that lets it fall; None if none does.

    Where bounds are `broken`, by the share that is missing to one, it may let that fall instead.
    """
    scale = 1.0
    for _ in range(HALVINGS):
        z = here.z + scale * step.dz
        alpha, after = plane.measured(z)
        if len(step.index) and (alpha > 0).all():
            # the angles at their bounds stray from there by the square of the step
            missing = (here.alpha + scale * step.e - alpha).ravel()[step.index]
            z = z + _complex(step.columns @ np.linalg.solve(step.system, missing))
            alpha, after = plane.measured(z)
        valid = bool((alpha > KEPT * np.minimum(plane.bound, here.alpha)).all())
        good = after <= value - SUFFICIENT * scale * 2 * promised and promised > 0
        if valid and (good or (broken > AT_BOUND and plane.broken(alpha) <= LESS * broken)):
            return z, alpha, after, scale
        shorter = LONGEST
        if valid:  # where the parabola through both has its minimum
            shorter = scale * promised / (after - value + 2 * scale * promised)
        scale *= min(max(shorter, SHORTEST), LONGEST)
    return None


def _further(
    plane: _Plane, z: ComplexArray, way: ComplexArray, alpha: FloatArray, value: float
) -> tuple[ComplexArray, FloatArray, float]:
    """As far along the way of the last two steps as the objective falls (parallel tangents)."""
    length, start, least = 1.0, z, KEPT * np.minimum(plane.bound, alpha)
    while True:
        trial = start + length * way
        there, after = plane.measured(trial)
        if not (after < value and (there > least).all()):
            return z, alpha, value
        z, alpha, value, length = trial, there, after, 2 * length


def _complex(x: FloatArray) -> ComplexArray:
    return np.asarray(x[0::2] + 1j * x[1::2])
