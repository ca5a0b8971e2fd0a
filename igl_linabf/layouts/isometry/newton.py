"""Find the nearest isometric map by Newton's method, from a map without flipped triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..._core import find_edges, sum_outer_products, symmetric_pattern
from ..._runtime import advance
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...linalg import Analysis, Factor, NotPositiveDefiniteError, Solvers
from ...surface import NEXT, PREV, Ragged
from .energy import RestTriangles

MAX_NEWTON_STEPS = 200
STALLED_FALL = 1e-8  # the energy has stalled if a step decreases it by a smaller fraction
NEGLIGIBLE_FALL = 1e-10  # steps with a smaller predicted relative decrease are skipped
GROWTH = 1.5  # factor by which steps are lengthened as long as the energy decreases
DAMPING = 1e-9  # share of the diagonal that is added to the Hessian, which is singular for rigid motions
SUFFICIENT_DECREASE = 1e-4  # minimum ratio of actual to predicted decrease of the energy (Armijo's rule)
MAX_HALVINGS = 40  # maximum number of halvings of a step before it is rejected
SHORT_OF_COLLAPSE = 0.9  # maximum step length, relative to the step that collapses the first triangle


@dataclass(frozen=True, eq=False)
class Springs:
    """Springs with given stiffnesses, (#V,), that pull vertices to the positions `to`, (#V,).

    Their energy is the sum of stiffness |z - to|^2 over the vertices.
    """

    stiffness: FloatArray
    to: ComplexArray

    def measure_energies(self, z: ComplexArray) -> FloatArray:
        d = z - self.to
        return np.asarray(self.stiffness * (d.real**2 + d.imag**2))


@dataclass(frozen=True, eq=False)
class IsometricEnergy:
    """The isometric energy of independent charts that are minimised side by side.

    Attributes
    ----------
    rest : RestTriangles
        The triangles on the surface.
    vertices, faces : Ragged
        Vertices and faces of each chart.
    weight : float
        Exponent of the area term, which weights areas against angles.
    springs : Springs or None
    """

    rest: RestTriangles
    vertices: Ragged
    faces: Ragged
    weight: float
    springs: Springs | None = None

    def measure_chart_energies(self, z: ComplexArray) -> FloatArray:
        """Return the energy of each chart: 1 for an isometry, infinite with a flipped triangle."""
        energy = np.asarray(self.faces.sum(self.rest.measure_energies(z, self.weight)))
        return (
            energy if self.springs is None else energy + self.vertices.sum(self.springs.measure_energies(z))
        )


class Hessians:
    """Hessians of the isometric energy with the same pattern, which is analysed once."""

    def __init__(self, corner: IntArray, n: int, solvers: Solvers) -> None:
        self._corner, self._n = corner, n
        ends, sides, _ = find_edges(corner, n)
        indptr, indices, slot = symmetric_pattern(np.ascontiguousarray(ends.T), n)
        self._across = np.empty(corner.shape, dtype=np.int64)
        for side in sides:
            self._across.ravel()[side[side >= 0]] = slot[side >= 0]
        self._across[corner[NEXT] > corner[PREV]] ^= -1  # bitwise complement for blocks of the lower triangle
        self._diagonal = indptr[:-1]
        self._own = self._diagonal[corner]
        self._entries = len(indices)
        self._analysis: Analysis = solvers.analyse(indptr, indices, 2)

    def differentiate(
        self, rest: RestTriangles, z: ComplexArray, weight: float, springs: Springs | None
    ) -> tuple[FloatArray, Factor]:
        """Return the gradient, (2 #V,), and the factored Hessian: the sum of row row^T over the triangles."""
        by_corner, rows = rest.differentiate(z, weight)
        slope = sum_at_vertices(self._corner, by_corner, self._n)
        blocks = sum_outer_products(rows, self._own, self._across, self._entries)
        if springs is not None:
            slope += _interleave_coordinates(2 * springs.stiffness * (z - springs.to))
            blocks[self._diagonal, 0] += 2 * springs.stiffness
            blocks[self._diagonal, 3] += 2 * springs.stiffness
        return slope, factor_damped(self._analysis, blocks, self._diagonal)


def sum_at_vertices(corner: IntArray, by_corner: FloatArray, n: int) -> FloatArray:
    """Return the gradient with respect to all vertices, (2 #V,), as a sum of gradients of triangles."""
    slope = np.empty(2 * n)
    for axis in (0, 1):
        slope[axis::2] = np.bincount(corner.ravel(), by_corner[3 * axis : 3 * axis + 3].ravel(), n)
    return slope


def factor_damped(analysis: Analysis, blocks: FloatArray, diagonal: IntArray) -> Factor:
    """Factor a Hessian, given by its blocks; increase its diagonal until it is positive definite."""
    own, damping = blocks[diagonal][:, ::3], DAMPING
    while True:
        own *= 1 + damping
        blocks[diagonal, 0], blocks[diagonal, 3] = own.T
        try:
            return analysis.factor(blocks)
        except NotPositiveDefiniteError:
            if damping > 1:
                raise
            damping *= 100


class HessianModel(Protocol):
    """A model of the Hessian of the isometric energy, which `minimise_energy` uses for its steps."""

    def differentiate(
        self, rest: RestTriangles, z: ComplexArray, weight: float, springs: Springs | None
    ) -> tuple[FloatArray, Factor]: ...


def minimise_energy(
    energy: IsometricEnergy,
    z: ComplexArray,
    hessians: HessianModel,
    tol: float = STALLED_FALL,
    max_steps: int = MAX_NEWTON_STEPS,
) -> tuple[ComplexArray, IntArray, BoolArray]:
    """Reduce the energy of each chart until it stalls; return the map, the steps, and the stalled charts.

    Each chart has its own step length, and stops if further steps would reduce its energy by less than the
    share `tol`. Therefore, the maps are the same as for one chart at a time. No triangle can flip, because a
    triangle collapses before it flips, and a step ends before the first triangle collapses. A single chart
    stops if no further step is possible in double precision.

    Raises
    ------
    NotPositiveDefiniteError
        No step is possible in double precision for one of several charts.
    """
    value, n = energy.measure_chart_energies(z), len(energy.faces)
    steps, moving, last = np.zeros(n, dtype=np.int64), np.ones(n, dtype=bool), np.full(n, np.inf)
    for _ in range(max_steps):
        try:
            slope, factor = hessians.differentiate(energy.rest, z, energy.weight, energy.springs)
            x = -factor.solve(slope)
            del factor  # free its memory, the largest of all objects
        except NotPositiveDefiniteError:
            if n > 1:
                raise
            break
        promised = -energy.vertices.sum((slope * x).reshape(-1, 2).sum(axis=1))
        moving &= promised > NEGLIGIBLE_FALL * value
        if not moving.any():
            break
        line = LineSearch(energy, z, x[0::2] + 1j * x[1::2], value, promised)
        z, reached, length = line.search(moving)
        advance("isometric", 0.1)
        steps[moving] += 1
        fall = value - reached
        # the decreases of full steps are nearly a geometric series, whose remainder is predicted
        with np.errstate(divide="ignore", invalid="ignore"):
            left = np.where(fall < last, fall * np.maximum(fall / (last - fall), 1.0), np.inf)
        moving &= (fall > STALLED_FALL * value) & ((left > tol * value) | (length < 1))
        value, last = reached, fall
        if not moving.any():
            break
    return z, steps, ~moving


@dataclass(frozen=True, eq=False)
class LineSearch:
    """A line search for charts side by side, each with its own step length.

    Attributes
    ----------
    energy : IsometricEnergy
    z, direction : (#V,) complex128
    value, promised : (#charts,) float64
        Energies at `z`, and their predicted decrease per unit length.
    """

    energy: IsometricEnergy
    z: ComplexArray
    direction: ComplexArray
    value: FloatArray
    promised: FloatArray

    def search(self, moving: BoolArray) -> tuple[ComplexArray, FloatArray, FloatArray]:
        """Return the map after a step of the `moving` charts, its energies, and the step lengths."""
        first = self.energy.faces.min(self.energy.rest.collapse_lengths(self.z, self.direction))
        most = SHORT_OF_COLLAPSE * first
        length = np.where(moving, np.minimum(1.0, most), 0.0)
        for _ in range(MAX_HALVINGS):
            reached = self._measure_energies(length)
            short = ~(reached <= self.value - SUFFICIENT_DECREASE * length * self.promised)
            if not short.any():
                break
            length[short] /= 2
        else:
            length[short] = 0.0
            reached = np.where(short, self.value, reached)
        growing = moving & ~short
        while growing.any():  # try longer steps: the convexified Hessian is too large
            tried = np.where(growing, np.minimum(GROWTH * length, most), length)
            after = self._measure_energies(tried)
            growing &= (tried > length) & (after < reached)
            length, reached = np.where(growing, tried, length), np.where(growing, after, reached)
        return self._take_step(length), reached, length

    def _take_step(self, length: FloatArray) -> ComplexArray:
        return np.asarray(self.z + self.energy.vertices.repeat(length) * self.direction)

    def _measure_energies(self, length: FloatArray) -> FloatArray:
        return self.energy.measure_chart_energies(self._take_step(length))


def _interleave_coordinates(z: ComplexArray) -> FloatArray:
    return np.column_stack((z.real, z.imag)).ravel()
