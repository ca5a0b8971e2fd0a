"""Newton's method from a map without flipped triangles to the isometric map nearest to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from .._runtime import advance
from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..linalg import Analysis, Factored, NotPositiveDefiniteError, Solvers, held
from ..surface import NEXT, PREV, Parts
from .isometric_energy import Rest

MAX_STEPS = 200
STALL = 1e-6  # fall of the energy, as a share of it, that a step has to bring
PROMISE = 1e-9  # and that it has to promise
SHORT_OF_FLIP = 0.9  # of the way to the first collapsed triangle
SUFFICIENT = 1e-4  # share of the promised fall that a step has to bring (Armijo)
HALVINGS = 40
DAMPING = 1e-9  # of the diagonal: the energy does not change when a map is moved or turned


@dataclass(frozen=True, eq=False)
class Charts:
    """Charts side by side, whose energies do not depend on each other.

    Attributes
    ----------
    rest : Rest
    vertices, faces : Parts
        Those of each chart.
    """

    rest: Rest
    vertices: Parts
    faces: Parts

    def energy(self, z: ComplexArray, weight: float, springs: Springs | None = None) -> FloatArray:
        """Of each chart; 1 for an isometry, infinite where a triangle is not upright."""
        energy = np.asarray(self.faces.sum(self.rest.energy(z, weight)))
        return energy if springs is None else energy + self.vertices.sum(springs.energy(z))


@dataclass(frozen=True, eq=False)
class Springs:
    """What draws vertices to positions: the energy is the sum of `stiffness` |z - to|^2, (#V,) each."""

    stiffness: FloatArray
    to: ComplexArray

    def energy(self, z: ComplexArray) -> FloatArray:
        d = z - self.to
        return np.asarray(self.stiffness * (d.real**2 + d.imag**2))


class Hessians:
    """The pattern of the energy's Hessian, x and y of each vertex side by side; analysed once.

    Only the first `free` vertices move, all of them if it is not given.
    """

    def __init__(self, corner: IntArray, n: int, solvers: Solvers, free: int | None = None) -> None:
        self._index, self._n = np.concatenate((2 * corner, 2 * corner + 1)).ravel(), n
        self._moving = 2 * (n if free is None else free)
        sides = np.sort((corner[NEXT], corner[PREV]), axis=0)
        keys, edge = np.unique((sides[0] * n + sides[1]).ravel(), return_inverse=True)
        low, high = keys // n, keys % n
        # a column has its vertex's own entries, then two for each edge to a later vertex
        first, vertices = np.searchsorted(low, np.arange(n + 1)), np.arange(n)
        start = 3 * np.arange(n + 1) + 4 * first
        second = start[:-1] + 2 * (1 + np.diff(first))
        rank = 2 * (np.arange(len(low)) - first[low])
        blocks = [
            [start[low] + 2 + rank, start[low] + 3 + rank],
            [second[low] + 1 + rank, second[low] + 2 + rank],
        ]
        self._row = np.empty(start[-1], dtype=np.int64)
        self._row[start[:-1]], self._row[start[:-1] + 1], self._row[second] = (
            2 * vertices,
            2 * vertices + 1,
            2 * vertices + 1,
        )
        for by_x_or_y in blocks:
            self._row[by_x_or_y[0]], self._row[by_x_or_y[1]] = 2 * high, 2 * high + 1
        self._start = np.append(np.column_stack((start[:-1], second)).ravel(), start[-1])
        self._own = self._start[:-1]
        self._pairs = np.tril_indices(6)
        self._slot = np.empty((len(self._pairs[0]), corner.shape[1]), dtype=np.int64)
        edge, own = edge.reshape(corner.shape), (start[:-1], start[:-1] + 1, second)
        for slot, i, j in zip(self._slot, *self._pairs, strict=True):
            (x, p), (y, q) = divmod(int(i), 3), divmod(int(j), 3)
            if p == q:
                slot[:] = own[x + y][corner[p]]
            else:
                at = edge[3 - p - q]
                slot[:] = np.where(corner[p] < corner[q], blocks[x][y][at], blocks[y][x][at])
        self._analysis: Analysis = solvers.whole(self._lower(np.ones(len(self._row))), often=True)

    def _lower(self, data: FloatArray) -> sparse.csc_array:
        return sparse.csc_array((data, self._row, self._start), shape=(2 * self._n, 2 * self._n))

    def slope(self, by_corner: FloatArray, springs: Springs | None, z: ComplexArray) -> FloatArray:
        """The gradient, (2 #V,), from that of the triangles, (6, #F)."""
        slope = np.asarray(np.bincount(self._index, by_corner.ravel(), 2 * self._n), dtype=np.float64)
        if springs is not None:
            slope += _interleaved(2 * springs.stiffness * (z - springs.to))
        slope[self._moving :] = 0.0
        return slope

    def factored(self, rows: FloatArray, springs: Springs | None, damping: float = DAMPING) -> Factored:
        """The factor of the sum of rows rows^T over the triangles, (#, 6, #F), and the springs."""
        values = np.empty(self._slot.shape)
        for value, i, j in zip(values, *self._pairs, strict=True):
            np.einsum("rf,rf->f", rows[:, i], rows[:, j], out=value)
        data = np.asarray(np.bincount(self._slot.ravel(), values.ravel(), len(self._row)), dtype=np.float64)
        if springs is not None:
            data[self._own] += np.repeat(2 * springs.stiffness, 2)
        while True:
            data[self._own] *= 1 + damping
            try:
                return self._analysis.factor(held(self._lower(data), self._moving))
            except NotPositiveDefiniteError:
                if damping > 1:
                    raise
                damping *= 100


def descend(
    charts: Charts,
    z: ComplexArray,
    weight: float,
    hessians: Hessians,
    springs: Springs | None = None,
    most: int = MAX_STEPS,
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
    energy = charts.energy(z, weight, springs)
    steps, moving = np.zeros(len(charts.faces), dtype=np.int64), np.ones(len(charts.faces), dtype=bool)
    for _ in range(most):
        by_corner, rows = charts.rest.expanded(z, weight)
        slope = hessians.slope(by_corner, springs, z)
        try:
            x = -hessians.factored(rows, springs).solve(slope)
        except NotPositiveDefiniteError:
            if len(moving) > 1:
                raise
            break
        promised = -charts.vertices.sum((slope * x).reshape(-1, 2).sum(axis=1))
        moving &= promised > PROMISE * energy
        if not moving.any():
            break
        z, reached = _searched(charts, z, x[0::2] + 1j * x[1::2], weight, springs, energy, promised, moving)
        advance("isometric", 0.1)
        steps[moving] += 1
        moving &= energy - reached > STALL * energy
        energy = reached
        if not moving.any():
            break
    return z, steps, ~moving


def _searched(
    charts: Charts,
    z: ComplexArray,
    direction: ComplexArray,
    weight: float,
    springs: Springs | None,
    energy: FloatArray,
    promised: FloatArray,
    moving: BoolArray,
) -> tuple[ComplexArray, FloatArray]:
    """The map and its energies after a step along `direction`, of each chart for itself."""
    first = charts.faces.min(_collapse(charts.rest, z, direction))
    length = np.where(moving, np.minimum(1.0, SHORT_OF_FLIP * first), 0.0)
    for _ in range(HALVINGS):
        tried = z + charts.vertices.spread(length) * direction
        reached = charts.energy(tried, weight, springs)
        short = ~(reached <= energy - SUFFICIENT * length * promised)
        if not short.any():
            return tried, reached
        length[short] /= 2
    length[short] = 0.0
    tried = z + charts.vertices.spread(length) * direction
    return tried, np.where(short, energy, reached)


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
