"""Maps of a mesh with holes that are harmonic between their boundary loops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .._types import ComplexArray, FloatArray, IntArray, Solve
from ..angles import Constraints, HolonomyResidual
from ..surface import Ragged, complex_positions, coordinates

RELAXED_ENERGY = 3e-5  # largest accepted conformal energy of relaxed loops, divided by the area


@dataclass(frozen=True, eq=False)
class Harmonic:
    """A map that is harmonic between its loops, with no net force on the loop of each hole.

    Attributes
    ----------
    along : (#rim,) complex128
        Positions on the loops; for a hole, up to a translation.
    inside : (#rows + 1,) complex128
        Positions of the rows, and the translations for the rows of holes; followed by a 0.
    """

    along: ComplexArray
    inside: ComplexArray

    def plus(self, share: complex, other: Harmonic) -> Harmonic:
        """Return the map plus a multiple of another map."""
        return Harmonic(self.along + share * other.along, self.inside + share * other.inside)


class Loops:
    """The boundary loops of a mesh with holes, and the maps that are harmonic between them.

    Parameters
    ----------
    constraints : Constraints
        Constraints with a wheel constraint in each row, and with a row for each hole.
    weight : (#E,) float64
        Weights of the edges in the Laplacian L.
    solve : callable
        Applies L^-1 to right-hand sides, (#rows, k).
    """

    def __init__(self, constraints: Constraints, weight: FloatArray, solve: Solve) -> None:
        topology, self._row, self._solve = constraints.topology, constraints.row, solve
        loops = topology.loops[0], *topology.holes
        self._rim, self._parts = np.concatenate(loops), Ragged.of_sizes([len(loop) for loop in loops])
        place = np.full(topology.n, -1)
        place[self._rim] = np.arange(len(self._rim))
        near = np.flatnonzero((place[topology.edges] >= 0).any(axis=1))
        self._ends: IntArray = place[topology.edges[near].T]
        self._rows: IntArray = constraints.pattern.ends[:, near]
        self._weight, self._n = weight[near], constraints.pattern.n

    def on_loop(self, which: int, values: ComplexArray) -> ComplexArray:
        """Return values, (#rim,), on one loop and zeros on all other loops; loop 0 is the outer loop."""
        made = np.zeros(len(self._rim), dtype=np.complex128)
        made[self._parts.start[which] : self._parts.start[which + 1]] = values
        return made

    def split(self, along: ComplexArray) -> list[ComplexArray]:
        """Return the values on each loop."""
        return self._parts.split(along)

    def harmonic(self, along: ComplexArray) -> Harmonic:
        """Return the harmonic map of positions on the loops."""
        return self.harmonics([along])[0]

    def harmonics(self, each: Sequence[ComplexArray]) -> list[Harmonic]:
        """Return the harmonic maps of several positions on the loops, with a single solve."""
        pulls = (self._weight * self._across(np.append(along, 0.0)) for along in each)
        rhs = np.hstack([-coordinates(self._sums(self._rows, pull, self._n)) for pull in pulls])
        inside = np.split(self._solve(np.ascontiguousarray(rhs)), len(each), axis=1)
        positions = (complex_positions(np.ascontiguousarray(own)) for own in inside)
        return [Harmonic(along, np.append(z, 0.0)) for along, z in zip(each, positions, strict=True)]

    def force(self, z: Harmonic) -> ComplexArray:
        """Return L z on the loops; it is zero in the interior."""
        at = np.append(z.along, 0.0)
        pull = self._weight * (self._across(at) + z.inside[self._rows[0]] - z.inside[self._rows[1]])
        return self._sums(self._ends, pull, len(self._rim))

    def _across(self, along: ComplexArray) -> ComplexArray:
        return np.asarray(along[self._ends[0]] - along[self._ends[1]])

    @staticmethod
    def _sums(ends: IntArray, values: ComplexArray, n: int) -> ComplexArray:
        """Sum the pull of edges at their ends, with opposite signs; end -1 is ignored."""
        index = (ends + 1).ravel()
        both = np.concatenate((values, -values))
        real, imaginary = (np.bincount(index, part, n + 1)[1:] for part in (both.real, both.imag))
        return np.asarray(real + 1j * imaginary)

    def positions(self, z: Harmonic) -> ComplexArray:
        """Return the positions of all vertices, (#V,)."""
        made = z.inside[self._row]
        made[self._rim] += z.along
        return made

    def central_differences(self, z: Harmonic) -> ComplexArray:
        """Return half the vector from the previous to the next vertex, on the loops."""
        at = self._at(z)
        before = np.empty_like(at)
        before[self._parts.following] = at
        return np.asarray((at[self._parts.following] - before) / 2)

    def _at(self, z: Harmonic) -> ComplexArray:
        return np.asarray(z.along + z.inside[self._row[self._rim]])

    def gradient(self, z: Harmonic) -> ComplexArray:
        """Return the gradient of the conformal energy, 1/2 z^H L z - area(z), on the loops."""
        return self.force(z) + 1j * self.central_differences(z)

    def energy(self, z: Harmonic) -> tuple[float, float]:
        """Return the conformal energy and the area."""
        at = self._at(z)
        area = float((at.conj() * self.central_differences(z)).imag.sum() / 2)
        return float((at.conj() * self.force(z)).real.sum() / 2) - area, area

    def long_waves(self, g: ComplexArray) -> ComplexArray:
        """Return a change of the loops that removes the long waves of the gradient g.

        g is zero for a holomorphic map, and 2 i dz along the loop for the conjugate of a holomorphic map.
        """
        step = 0.25j * (g + g[self._parts.following])
        step -= self._mean(step)
        change = np.concatenate([np.cumsum(part) - part for part in self._parts.split(step)])
        return np.asarray(change - self._mean(change))

    def short_waves(self, g: ComplexArray) -> ComplexArray:
        """Return a change of the loops that removes the short waves of the gradient g, vertex by vertex."""
        index = (self._ends + 1).ravel()
        own = np.bincount(index, np.tile(self._weight, 2), len(self._rim) + 1)[1:]
        return np.asarray(-g / own)

    def _mean(self, values: ComplexArray) -> ComplexArray:
        return np.asarray(self._parts.repeat(self._parts.sum(values) / self._parts.sizes))


def draw_loops(loops: Loops, holonomy: HolonomyResidual, outer: ComplexArray) -> Harmonic:
    """Compute the map with harmonic coordinates between loops with the shapes drawn from angles.

    The outer loop is fixed. The loop of each hole is determined up to a similarity, z = a_h s + c_h, where
    a_h and c_h minimise the conformal energy. Let z_0 be the harmonic map with a_h = 0 for all holes, and z_h
    the harmonic map with the outer loop at 0 and the loop of hole h at s_h, both with free c. In these maps,
    the holes act as vertices, and z = z_0 + sum a_h z_h. The energy 1/2 z^H L z - area(z) is minimal if

        sum_h (z_g^H L z_h) a_h - 2 area(s_g) a_g = -z_g^H L z_0.

    L z_h sums to zero around a hole and is zero in the interior. Therefore only the loop of hole g
    contributes to z_g^H L.

    Parameters
    ----------
    loops : Loops
    holonomy : HolonomyResidual
        Holonomy residual of the angles.
    outer : (#outer,) complex128
        Positions of the outer loop.
    """
    beside: ComplexArray = np.append(np.zeros_like(outer), -holonomy.q)  # q points to the end of the loop
    shapes = loops.split(beside)[1:]
    z, *holes = loops.harmonics([loops.on_loop(h, shape) for h, shape in enumerate((outer, *shapes))])
    force = [loops.split(loops.force(each))[1:] for each in (z, *holes)]
    pulled = np.array([[s.conj() @ f for s, f in zip(shapes, each, strict=True)] for each in force]).T
    area = [(s.conj() * np.roll(s, -1)).imag.sum() / 2 for s in shapes]
    similar = np.linalg.solve(pulled[:, 1:] - 2 * np.diag(area), -pulled[:, 0])
    for share, each in zip(similar, holes, strict=True):
        z = z.plus(share, each)
    return z


def relax_loops(loops: Loops, z: Harmonic) -> Harmonic | None:
    """Minimise the conformal energy approximately, starting from loops close to the minimiser.

    Relative to L, the matrix of the energy has eigenvalues near 0 for holomorphic maps, and near 2 for
    conjugates of holomorphic maps. A change of the loops has to remove the latter, which requires no further
    system. The remainder after the first change is due to the mesh and has short waves. The energy is
    minimised over all linear combinations of both changes. Return None if the energy stays large, because
    least squares with a separate factor then take less time.
    """
    g = loops.gradient(z)
    changes: list[Harmonic] = []
    slopes: list[ComplexArray] = []
    for waves in (loops.long_waves, loops.short_waves):
        changes.append(loops.harmonic(waves(g)))
        slopes.append(loops.gradient(changes[-1]))
        along = np.array([change.along for change in changes]).conj()
        hessian = along @ np.array(slopes).T
        shares = np.linalg.lstsq((hessian + hessian.conj().T) / 2, -along @ g)[0]
        for share, change, slope in zip(shares, changes, slopes, strict=True):
            z, g = z.plus(share, change), g + share * slope
    energy, area = loops.energy(z)
    return z if energy <= RELAXED_ENERGY * area else None
