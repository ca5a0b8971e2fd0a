"""Newton's method from a map without flipped triangles to the isometric map nearest to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..._core import entries, outer_products, undirected
from ..._runtime import advance
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...linalg import Analysis, Factor, NotPositiveDefiniteError, Solvers
from ...surface import NEXT, PREV, Ragged
from ..constants import MAX_HALVINGS, SHORT_OF_COLLAPSE, SUFFICIENT_DECREASE
from .constants import DAMPING, GROWTH, MAX_NEWTON_STEPS, NEGLIGIBLE_FALL, STALLED_FALL
from .energy import Rest


@dataclass(frozen=True, eq=False)
class Springs:
    """What draws vertices to positions: the energy is the sum of `stiffness` |z - to|^2, (#V,) each."""

    stiffness: FloatArray
    to: ComplexArray

    def energy(self, z: ComplexArray) -> FloatArray:
        d = z - self.to
        return np.asarray(self.stiffness * (d.real**2 + d.imag**2))


@dataclass(frozen=True, eq=False)
class IsometricEnergy:
    """The energy of charts side by side, which do not depend on each other.

    Attributes
    ----------
    rest : Rest
        Their triangles.
    vertices, faces : Ragged
        Those of each chart.
    weight : float
        Of areas against angles.
    springs : Springs or None
    """

    rest: Rest
    vertices: Ragged
    faces: Ragged
    weight: float
    springs: Springs | None = None

    def of_charts(self, z: ComplexArray) -> FloatArray:
        """(#charts,): 1 for an isometry, infinite where a triangle is not upright."""
        energy = np.asarray(self.faces.sum(self.rest.energy(z, self.weight)))
        return energy if self.springs is None else energy + self.vertices.sum(self.springs.energy(z))


class Hessians:
    """The pattern of the energy's Hessian, x and y of each vertex side by side; analysed once."""

    def __init__(self, corner: IntArray, n: int, solvers: Solvers) -> None:
        self._index, self._n = np.concatenate((2 * corner, 2 * corner + 1)).ravel(), n
        ends, sides, _ = undirected(corner, n)
        indptr, indices, slot = entries(np.ascontiguousarray(ends.T), n)
        self._across = np.empty(corner.shape, dtype=np.int64)
        for side in sides:
            self._across.ravel()[side[side >= 0]] = slot[side >= 0]
        self._across[corner[NEXT] > corner[PREV]] ^= -1  # ~, where the block is that of the lower triangle
        self._diagonal = indptr[:-1]
        self._own = self._diagonal[corner]
        self._entries = len(indices)
        self._analysis: Analysis = solvers.analyse(indptr, indices, 2)

    def slope(self, by_corner: FloatArray, springs: Springs | None, z: ComplexArray) -> FloatArray:
        """The gradient, (2 #V,), from that of the triangles, (6, #F)."""
        slope = np.asarray(np.bincount(self._index, by_corner.ravel(), 2 * self._n), dtype=np.float64)
        if springs is not None:
            slope += _interleaved(2 * springs.stiffness * (z - springs.to))
        return slope

    def factored(self, rows: FloatArray, springs: Springs | None) -> Factor:
        """The factor of the sum of row row^T over the triangles, six `rows` for each, and the springs."""
        blocks = outer_products(rows, self._own, self._across, self._entries)
        own = blocks[self._diagonal][:, ::3]
        if springs is not None:
            own += 2 * springs.stiffness[:, None]
        damping = DAMPING
        while True:
            own *= 1 + damping
            blocks[self._diagonal, 0], blocks[self._diagonal, 3] = own.T
            try:
                return self._analysis.factor(blocks)
            except NotPositiveDefiniteError:
                if damping > 1:
                    raise
                damping *= 100


def descend(
    energy: IsometricEnergy,
    z: ComplexArray,
    hessians: Hessians,
    tol: float = STALLED_FALL,
    max_steps: int = MAX_NEWTON_STEPS,
) -> tuple[ComplexArray, IntArray, BoolArray]:
    """The map at which the energy of every chart stalls, its steps, and whether it does within them.

    Each chart has a step length of its own, and stays as it is from where further steps lower its energy by
    less than `tol` of it: so the maps are those of one chart after the other. No triangle can flip: it would
    collapse first, and a step is shorter than to the first collapse. A single chart ends where double
    precision holds no further step.

    Raises
    ------
    NotPositiveDefiniteError
        Double precision holds no step of one of several charts.
    """
    value, n = energy.of_charts(z), len(energy.faces)
    steps, moving, last = np.zeros(n, dtype=np.int64), np.ones(n, dtype=bool), np.full(n, np.inf)
    for _ in range(max_steps):
        by_corner, rows = energy.rest.expanded(z, energy.weight)
        slope = hessians.slope(by_corner, energy.springs, z)
        try:
            x = -hessians.factored(rows, energy.springs).solve(slope)
        except NotPositiveDefiniteError:
            if n > 1:
                raise
            break
        promised = -energy.vertices.sum((slope * x).reshape(-1, 2).sum(axis=1))
        moving &= promised > NEGLIGIBLE_FALL * value
        if not moving.any():
            break
        line = Line(energy, z, x[0::2] + 1j * x[1::2], value, promised)
        z, reached, length = line.search(moving)
        advance("isometric", 0.1)
        steps[moving] += 1
        fall = value - reached
        # the falls of whole steps are like a geometric series: what is left of it is foreseen
        with np.errstate(divide="ignore", invalid="ignore"):
            left = np.where(fall < last, fall * np.maximum(fall / (last - fall), 1.0), np.inf)
        moving &= (fall > STALLED_FALL * value) & ((left > tol * value) | (length < 1))
        value, last = reached, fall
        if not moving.any():
            break
    return z, steps, ~moving


@dataclass(frozen=True, eq=False)
class Line:
    """A step of charts side by side, each of which has a length of its own.

    Attributes
    ----------
    energy : IsometricEnergy
    z, direction : (#V,) complex128
    value, promised : (#charts,) float64
        The energies at `z`, and how fast they fall from there.
    """

    energy: IsometricEnergy
    z: ComplexArray
    direction: ComplexArray
    value: FloatArray
    promised: FloatArray

    def search(self, moving: BoolArray) -> tuple[ComplexArray, FloatArray, FloatArray]:
        """The map after a step of the charts that move, its energies, and the lengths of the steps."""
        first = self.energy.faces.min(self.energy.rest.collapse_lengths(self.z, self.direction))
        most = SHORT_OF_COLLAPSE * first
        length = np.where(moving, np.minimum(1.0, most), 0.0)
        for _ in range(MAX_HALVINGS):
            reached = self._energies(length)
            short = ~(reached <= self.value - SUFFICIENT_DECREASE * length * self.promised)
            if not short.any():
                break
            length[short] /= 2
        else:
            length[short] = 0.0
            reached = np.where(short, self.value, reached)
        growing = moving & ~short
        while growing.any():  # the model's Hessian is too large where triangles grow
            tried = np.where(growing, np.minimum(GROWTH * length, most), length)
            after = self._energies(tried)
            growing &= (tried > length) & (after < reached)
            length, reached = np.where(growing, tried, length), np.where(growing, after, reached)
        return self._at(length), reached, length

    def _at(self, length: FloatArray) -> ComplexArray:
        return np.asarray(self.z + self.energy.vertices.repeat(length) * self.direction)

    def _energies(self, length: FloatArray) -> FloatArray:
        return self.energy.of_charts(self._at(length))


def _interleaved(z: ComplexArray) -> FloatArray:
    return np.column_stack((z.real, z.imag)).ravel()
