"""Converged ABF in the plane: the quadratic model over the positions, and its minimum under the bounds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..linalg import Factor, NotPositiveDefiniteError
from ..surface import NEXT, PREV
from .constants import BOUND_DAMPING, MAX_BOUND_ROUNDS, MAX_BOUNDS, SHORT_OF_COLLAPSE
from .isometry import Hessians, Springs

EPSILON = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class Plane:
    """The objective over the positions.

    Attributes
    ----------
    corner : (3, #F) int64
    estimate, bound : (3, #F) float64
    free : int
        So many vertices move, the first ones.
    outside : float
        The objective of triangles beyond, which do not move.
    """

    corner: IntArray
    estimate: FloatArray
    bound: FloatArray
    free: int
    outside: float = 0.0

    def sides(self, z: ComplexArray) -> ComplexArray:
        """(3, #F): the side opposite to each corner, counterclockwise."""
        return np.asarray(z[self.corner[PREV]] - z[self.corner[NEXT]])

    def centred(self, z: ComplexArray) -> ComplexArray:
        """The map moved so that the smallest triangle is at the origin, where positions have most digits."""
        smallest = np.abs(self.sides(z)).max(axis=0).argmin()
        return np.asarray(z - z[self.corner[0, smallest]])

    def part(self, faces: IntArray, corner: IntArray, free: int, alpha: FloatArray, value: float) -> Plane:
        """That of some faces, with `corner` numbered anew; `alpha` and `value` are those of the whole map."""
        estimate = self.estimate[:, faces]
        inside = float((((alpha[:, faces] - estimate) / estimate) ** 2).sum())
        return Plane(corner, estimate, self.bound[:, faces], free, value - inside)

    def broken(self, alpha: FloatArray) -> float:
        """The largest share of its bound that is missing to an angle; negative where none is."""
        return float((1 - alpha / self.bound).max())

    def measured(self, z: ComplexArray) -> tuple[FloatArray, float]:
        """The angles, negative in flipped triangles, and the objective."""
        side = self.sides(z)
        turn = -side[NEXT] * side[PREV].conj()
        alpha = np.arctan2(turn.imag, turn.real)
        return alpha, self.outside + float((((alpha - self.estimate) / self.estimate) ** 2).sum())


@dataclass(frozen=True, eq=False)
class LinearAngles:
    """The angles as linear functions of the positions.

    Attributes
    ----------
    rows : (3, 6, #F) float64
        The slope of each angle by x of its triangle's corners, then by y.
    gradient : (3, #F) float64
        Half the objective's, by the angles.
    """

    plane: Plane
    z: ComplexArray
    alpha: FloatArray
    inverse: ComplexArray
    rows: FloatArray
    gradient: FloatArray

    @classmethod
    def of(cls, plane: Plane, z: ComplexArray, alpha: FloatArray) -> LinearAngles:
        inverse = 1 / plane.sides(z)
        slope = np.empty((3, 3, alpha.shape[1]), dtype=np.complex128)  # d alpha_k = Im sum slope[k, j] dz_j
        for k in range(3):
            slope[k, k] = inverse[NEXT[k]] + inverse[PREV[k]]
            slope[k, PREV[k]] = -inverse[NEXT[k]]
            slope[k, NEXT[k]] = -inverse[PREV[k]]
        rows = np.concatenate((slope.imag, slope.real), axis=1)
        return cls(plane, z, alpha, inverse, rows, (alpha - plane.estimate) / plane.estimate**2)

    def springs(self) -> Springs | None:
        """Two that are at rest: the objective does not change when a map is moved, turned or scaled.

        None where vertices are fixed.
        """
        if self.plane.free < len(self.z):
            return None
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
        """Of some angles, flat indices: the six positions that each depends on, and the slopes by them.

        They are zero by the positions that do not move.
        """
        k, t = np.divmod(index, self.alpha.shape[1])
        corner = self.plane.corner[:, t]
        place = np.concatenate((2 * corner, 2 * corner + 1))
        return place, np.where(place < 2 * self.plane.free, self.rows[k, :, t].T, 0.0)

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
class Pushes:
    """Forces on some angles.

    Attributes
    ----------
    here : LinearAngles
    factor : Factor
        Of the model's Hessian.
    index : (#p,) int64
        The angles.
    columns : (2 #V, #p) float64
        The change of the positions by a force on each.
    """

    here: LinearAngles
    factor: Factor
    index: IntArray
    columns: FloatArray

    @classmethod
    def none(cls, here: LinearAngles, factor: Factor) -> Pushes:
        return cls(here, factor, np.empty(0, dtype=np.int64), np.empty((2 * len(here.z), 0)))

    @cached_property
    def system(self) -> FloatArray:
        """The change of each of these angles by a force on each, (#p, #p)."""
        return self.here.changes(self.index, self.columns)

    def with_more(self, more: IntArray) -> Pushes:
        """On further angles, too."""
        columns = np.column_stack((self.columns, self.factor.solve(self.here.columns(more))))
        return replace(self, index=np.concatenate((self.index, more)), columns=columns)

    def on(self, which: BoolArray) -> Pushes:
        """On some of the angles only."""
        return replace(self, index=self.index[which], columns=self.columns[:, which])

    def moved(self, force: FloatArray) -> FloatArray:
        """What they change at the positions, (2 #V,)."""
        return np.asarray(self.columns @ force)


@dataclass(frozen=True, eq=False)
class BoundedStep:
    """A step, and the bounds that it meets.

    Attributes
    ----------
    dz : (#V,) complex128
    e : (3, #F) float64
        The angles' linear change.
    held : (3, #F) bool
    pushes : Pushes
        Those of these bounds.
    """

    dz: ComplexArray
    e: FloatArray
    held: BoolArray
    pushes: Pushes

    @property
    def index(self) -> IntArray:
        """The angles at these bounds, flat indices."""
        return self.pushes.index

    def with_more(self, more: IntArray) -> BoundedStep:
        """The same with further bounds, too."""
        return replace(self, pushes=self.pushes.with_more(more))

    def pushed(self, by: FloatArray) -> ComplexArray:
        """Changes of the positions that change these angles `by`; raises as `bounded_step`."""
        return complex_pairs(
            self.pushes.moved(scipy.linalg.cho_solve((_cholesky(self.pushes.system), True), by))
        )


def bounded_step(here: LinearAngles, hessians: Hessians, factor: Factor, held: BoolArray) -> BoundedStep:
    """The minimum of the quadratic model under the bounds (Lawson, Hanson 1974, for the multipliers).

    Those of the last step and those that the step breaks so far come in.

    Raises
    ------
    NotPositiveDefiniteError
        In double precision some bounds are one.
    """
    least = np.maximum(-SHORT_OF_COLLAPSE * here.alpha, here.plane.bound - here.alpha).ravel()
    free = -factor.solve(hessians.slope((here.gradient[:, None] * here.rows).sum(axis=0), None, here.z))
    free_e = here.change(complex_pairs(free)).ravel()
    pushes, force = Pushes.none(here, factor), np.empty(0)
    x, e, more = free, free_e, np.flatnonzero(held)
    more = more if len(more) else _broken_bounds(e, least, more)
    for _ in range(MAX_BOUND_ROUNDS):
        if not len(more):
            break
        pushes = pushes.with_more(more)
        force = _bound_forces(pushes.system, least[pushes.index] - free_e[pushes.index])
        x = free + pushes.moved(force)
        e = here.change(complex_pairs(x)).ravel()
        more = _broken_bounds(e, least, pushes.index)
    pushes = pushes.on(force > 0)
    now = np.zeros(len(e), dtype=bool)
    now[pushes.index] = True
    return BoundedStep(complex_pairs(x), e.reshape(here.alpha.shape), now.reshape(here.alpha.shape), pushes)


def _broken_bounds(e: FloatArray, least: FloatArray, known: IntArray) -> IntArray:
    """The bounds that a step breaks, the worst first where they are too many."""
    broken = np.flatnonzero(e < least - 1e-6 * np.abs(least))
    broken = np.setdiff1d(broken, known, assume_unique=True)
    most = MAX_BOUNDS - len(known)
    if len(broken) > most:
        broken = np.sort(broken[np.argsort(e[broken] - least[broken], kind="stable")[:most]])
    return broken


def _bound_forces(system: FloatArray, wanted: FloatArray) -> FloatArray:
    """Forces of bounds, at least zero: the least f^T system f / 2 - f^T wanted."""
    lower = _cholesky(system)
    try:
        return np.asarray(
            scipy.optimize.nnls(lower.T, np.linalg.solve(lower, wanted), maxiter=100 * len(wanted))[0]
        )
    except RuntimeError:  # it goes to and fro between bounds that are nearly one
        raise NotPositiveDefiniteError(len(system)) from None


def _cholesky(system: FloatArray) -> FloatArray:
    """The Cholesky factor of the forces' system."""
    system = (system + system.T) / 2
    try:
        return np.asarray(
            np.linalg.cholesky(system + BOUND_DAMPING * np.diag(np.diag(system))), dtype=np.float64
        )
    except np.linalg.LinAlgError:
        raise NotPositiveDefiniteError(len(system)) from None


def complex_pairs(x: FloatArray) -> ComplexArray:
    return np.asarray(x[0::2] + 1j * x[1::2])
