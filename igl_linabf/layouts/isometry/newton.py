"""Newton's method from a map without flipped triangles to the isometric map nearest to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..._runtime import advance
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...linalg import Analysis, Factor, NotPositiveDefiniteError, Solvers
from ...surface import NEXT, PREV, Ragged
from ..constants import MAX_HALVINGS, SHORT_OF_COLLAPSE, SUFFICIENT_DECREASE
from .constants import DAMPING, MAX_NEWTON_STEPS, NEGLIGIBLE_FALL, STALLED_FALL
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
    """The pattern of the energy's Hessian, x and y of each vertex side by side; analysed once.

    Only the first `free` vertices move, all of them if it is not given.
    """

    def __init__(self, corner: IntArray, n: int, solvers: Solvers, free: int | None = None) -> None:
        self._index, self._n = np.concatenate((2 * corner, 2 * corner + 1)).ravel(), n
        self._free = n if free is None else free
        sides = np.sort((corner[NEXT], corner[PREV]), axis=0)
        keys, edge = np.unique((sides[0] * n + sides[1]).ravel(), return_inverse=True)
        low, high = keys // n, keys % n
        # the lower triangle: a column has its vertex's own block, then one for each edge to a later vertex
        start = np.arange(n + 1) + np.searchsorted(low, np.arange(n + 1))
        self._own, of_edge = start[:-1], np.arange(len(low)) + low + 1
        indices = np.empty(start[-1], dtype=np.int64)
        indices[self._own], indices[of_edge] = np.arange(n), high
        self._fixed = np.flatnonzero(indices >= self._free)
        self._pairs = np.tril_indices(6)
        self._slot = np.empty((len(self._pairs[0]), corner.shape[1]), dtype=np.int64)
        edge = edge.reshape(corner.shape)
        for slot, i, j in zip(self._slot, *self._pairs, strict=True):
            (x, p), (y, q) = divmod(int(i), 3), divmod(int(j), 3)
            if p == q:
                slot[:] = 4 * self._own[corner[p]] + (3 if x and y else x + y)
            else:
                in_block = np.where(corner[p] < corner[q], 2 * x + y, 2 * y + x)
                slot[:] = 4 * of_edge[edge[3 - p - q]] + in_block
        self._analysis: Analysis = solvers.analyse(start, indices, 2)

    def slope(self, by_corner: FloatArray, springs: Springs | None, z: ComplexArray) -> FloatArray:
        """The gradient, (2 #V,), from that of the triangles, (6, #F)."""
        slope = np.asarray(np.bincount(self._index, by_corner.ravel(), 2 * self._n), dtype=np.float64)
        if springs is not None:
            slope += _interleaved(2 * springs.stiffness * (z - springs.to))
        slope[2 * self._free :] = 0.0
        return slope

    def factored(self, rows: FloatArray, springs: Springs | None, damping: float = DAMPING) -> Factor:
        """The factor of the sum of rows rows^T over the triangles, (#, 6, #F), and the springs."""
        values = np.empty(self._slot.shape)
        for value, i, j in zip(values, *self._pairs, strict=True):
            np.einsum("rf,rf->f", rows[:, i], rows[:, j], out=value)
        sums = np.bincount(self._slot.ravel(), values.ravel(), 4 * (self._own[-1] + 1))
        blocks = np.asarray(sums, dtype=np.float64).reshape(-1, 4)
        own = blocks[self._own][:, ::3]
        if springs is not None:
            own += 2 * springs.stiffness[:, None]
        blocks[self._fixed] = 0.0
        while True:
            own *= 1 + damping
            own[self._free :] = 1.0
            blocks[self._own, 0], blocks[self._own, 3] = own.T
            try:
                return self._analysis.factor(blocks)
            except NotPositiveDefiniteError:
                if damping > 1:
                    raise
                damping *= 100


def descend(
    energy: IsometricEnergy, z: ComplexArray, hessians: Hessians, max_steps: int = MAX_NEWTON_STEPS
) -> tuple[ComplexArray, IntArray, BoolArray]:
    """The map at which the energy of every chart stalls, its steps, and whether it does within them.

    Each chart has a step length of its own, and stays as it is from where it stalls: so the maps are those of
    one chart after the other. No triangle can flip: it would collapse first, and a step is shorter than to
    the first collapse. A single chart ends where double precision holds no further step.

    Raises
    ------
    NotPositiveDefiniteError
        Double precision holds no step of one of several charts.
    """
    value, n = energy.of_charts(z), len(energy.faces)
    steps, moving = np.zeros(n, dtype=np.int64), np.ones(n, dtype=bool)
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
        z, reached = _search_lengths(energy, z, x[0::2] + 1j * x[1::2], value, promised, moving)
        advance("isometric", 0.1)
        steps[moving] += 1
        moving &= value - reached > STALLED_FALL * value
        value = reached
        if not moving.any():
            break
    return z, steps, ~moving


def _search_lengths(
    energy: IsometricEnergy,
    z: ComplexArray,
    direction: ComplexArray,
    value: FloatArray,
    promised: FloatArray,
    moving: BoolArray,
) -> tuple[ComplexArray, FloatArray]:
    """The map and its energies after a step along `direction`, of each chart for itself."""
    first = energy.faces.min(_collapse(energy.rest, z, direction))
    length = np.where(moving, np.minimum(1.0, SHORT_OF_COLLAPSE * first), 0.0)
    for _ in range(MAX_HALVINGS):
        tried = z + energy.vertices.repeat(length) * direction
        reached = energy.of_charts(tried)
        short = ~(reached <= value - SUFFICIENT_DECREASE * length * promised)
        if not short.any():
            return tried, reached
        length[short] /= 2
    length[short] = 0.0
    tried = z + energy.vertices.repeat(length) * direction
    return tried, np.where(short, value, reached)


def _collapse(rest: Rest, z: ComplexArray, direction: ComplexArray) -> FloatArray:
    """The step length at which each triangle collapses, |p|^2 = |q|^2; infinite where none does."""
    (p, q), (dp, dq) = rest.derivatives(z), rest.derivatives(direction)
    a = np.abs(dp) ** 2 - np.abs(dq) ** 2
    b = (p.conj() * dp).real - (q.conj() * dq).real
    c = np.abs(p) ** 2 - np.abs(q) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        sum_ = -(b + np.copysign(np.sqrt(b * b - a * c), b))  # no cancellation
        roots = np.stack((sum_ / a, c / sum_))
    return np.asarray(np.where(roots > 0, roots, np.inf).min(axis=0))


def _interleaved(z: ComplexArray) -> FloatArray:
    return np.column_stack((z.real, z.imag)).ravel()
