"""Maps of a mesh with holes that are harmonic between their loops, by the positions on these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .._types import ComplexArray, FloatArray, IntArray, Solve
from ..angles import Constraints, HolonomyResidual
from ..surface import Ragged, complex_positions, coordinates
from .constants import RELAXED_ENERGY


@dataclass(frozen=True, eq=False)
class Harmonic:
    """A map that is harmonic between its loops, each hole's being where it takes no force to hold it.

    Attributes
    ----------
    along : (#rim,) complex128
        Positions on the loops, a hole's up to a translation.
    inside : (#rows + 1,) complex128
        Positions of the rows; of a hole's row, the translation; 0 after the last.
    """

    along: ComplexArray
    inside: ComplexArray

    def plus(self, share: complex, other: Harmonic) -> Harmonic:
        return Harmonic(self.along + share * other.along, self.inside + share * other.inside)


class Loops:
    """The boundary loops of a mesh with holes, and the maps that are harmonic between them.

    Parameters
    ----------
    constraints : Constraints
        Each row has its wheel constraint, each hole has a row.
    weight : (#E,) float64
        Of edges in the Laplacian L.
    solve : callable
        L^-1 over the rows, for (#rows, k).
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

    def on(self, which: int, values: ComplexArray) -> ComplexArray:
        """(#rim,): some values on one loop, the outer one being the first, and zero on the others."""
        made = np.zeros(len(self._rim), dtype=np.complex128)
        made[self._parts.start[which] : self._parts.start[which + 1]] = values
        return made

    def split(self, along: ComplexArray) -> list[ComplexArray]:
        """The values on each loop."""
        return self._parts.split(along)

    def harmonic(self, along: ComplexArray) -> Harmonic:
        """The harmonic map of positions on the loops."""
        return self.harmonics([along])[0]

    def harmonics(self, each: Sequence[ComplexArray]) -> list[Harmonic]:
        """Those of several such positions, solved for at once."""
        pulls = (self._weight * self._across(np.append(along, 0.0)) for along in each)
        rhs = np.hstack([-coordinates(self._sums(self._rows, pull, self._n)) for pull in pulls])
        inside = np.split(self._solve(np.ascontiguousarray(rhs)), len(each), axis=1)
        positions = (complex_positions(np.ascontiguousarray(own)) for own in inside)
        return [Harmonic(along, np.append(z, 0.0)) for along, z in zip(each, positions, strict=True)]

    def force(self, z: Harmonic) -> ComplexArray:
        """L z on the loops; inside it is zero."""
        at = np.append(z.along, 0.0)
        pull = self._weight * (self._across(at) + z.inside[self._rows[0]] - z.inside[self._rows[1]])
        return self._sums(self._ends, pull, len(self._rim))

    def _across(self, along: ComplexArray) -> ComplexArray:
        return np.asarray(along[self._ends[0]] - along[self._ends[1]])

    @staticmethod
    def _sums(ends: IntArray, values: ComplexArray, n: int) -> ComplexArray:
        """Sums of what edges pull at their ends, the other way at the second one; none at -1."""
        index = (ends + 1).ravel()
        both = np.concatenate((values, -values))
        real, imaginary = (np.bincount(index, part, n + 1)[1:] for part in (both.real, both.imag))
        return np.asarray(real + 1j * imaginary)

    def positions(self, z: Harmonic) -> ComplexArray:
        """(#V,) of all vertices."""
        made = z.inside[self._row]
        made[self._rim] += z.along
        return made

    def turned(self, z: Harmonic) -> ComplexArray:
        """Half the vector from the vertex before to the one after, on the loops."""
        at = self._at(z)
        before = np.empty_like(at)
        before[self._parts.following] = at
        return np.asarray((at[self._parts.following] - before) / 2)

    def _at(self, z: Harmonic) -> ComplexArray:
        return np.asarray(z.along + z.inside[self._row[self._rim]])

    def gradient(self, z: Harmonic) -> ComplexArray:
        """That of the conformal energy, 1/2 z^H L z - area(z), on the loops."""
        return self.force(z) + 1j * self.turned(z)

    def energy(self, z: Harmonic) -> tuple[float, float]:
        """The conformal energy, and the area."""
        at = self._at(z)
        area = float((at.conj() * self.turned(z)).imag.sum() / 2)
        return float((at.conj() * self.force(z)).real.sum() / 2) - area, area

    def long_waves(self, g: ComplexArray) -> ComplexArray:
        """A change of the loops that takes off the gradient g's long waves.

        Of a holomorphic map g is zero, and of the conjugate of one it is 2 i dz along the loop.
        """
        step = 0.25j * (g + g[self._parts.following])
        step -= self._mean(step)
        change = np.concatenate([np.cumsum(part) - part for part in self._parts.split(step)])
        return np.asarray(change - self._mean(change))

    def short_waves(self, g: ComplexArray) -> ComplexArray:
        """The same for its short waves: each vertex by itself."""
        index = (self._ends + 1).ravel()
        own = np.bincount(index, np.tile(self._weight, 2), len(self._rim) + 1)[1:]
        return np.asarray(-g / own)

    def _mean(self, values: ComplexArray) -> ComplexArray:
        return np.asarray(self._parts.repeat(self._parts.sum(values) / self._parts.sizes))


def draw_loops(loops: Loops, holonomy: HolonomyResidual, outer: ComplexArray) -> Harmonic:
    """Both coordinates harmonic between loops that have the shapes drawn from angles.

    The outer loop stays as it is drawn. Each hole's is drawn up to a similarity, z = a_h s + c_h: a_h and c_h
    are those of the least conformal energy. If z_0 has a_h = 0 for all holes, and z_h is the map with the
    outer loop at 0 and the loop of hole h at s_h, both with free c, these are harmonic with the holes as
    vertices, and z = z_0 + sum a_h z_h. The energy 1/2 z^H L z - area(z) is least where

        sum_h (z_g^H L z_h) a_h - 2 area(s_g) a_g = -z_g^H L z_0.

    L z_h sums to zero around a hole, and is zero inside: only the loop of hole g has to do with z_g^H L.

    Parameters
    ----------
    loops : Loops
    holonomy : HolonomyResidual
        Of the angles.
    outer : (#outer,) complex128
        Positions of the outer loop.
    """
    beside: ComplexArray = np.append(np.zeros_like(outer), -holonomy.q)  # q leads to the loop's end
    shapes = loops.split(beside)[1:]
    z, *holes = loops.harmonics([loops.on(h, shape) for h, shape in enumerate((outer, *shapes))])
    force = [loops.split(loops.force(each))[1:] for each in (z, *holes)]
    pulled = np.array([[s.conj() @ f for s, f in zip(shapes, each, strict=True)] for each in force]).T
    area = [(s.conj() * np.roll(s, -1)).imag.sum() / 2 for s in shapes]
    similar = np.linalg.solve(pulled[:, 1:] - 2 * np.diag(area), -pulled[:, 0])
    for share, each in zip(similar, holes, strict=True):
        z = z.plus(share, each)
    return z


def relax_loops(loops: Loops, z: Harmonic) -> Harmonic | None:
    """The map of nearly the least conformal energy, from one whose loops are nearly those of that map.

    Relative to L, the energy's matrix has eigenvalues near 0, of holomorphic maps, and near 2, of the
    conjugates of such maps: these are what a change of the loops has to take off. That has no system of its
    own. What the first change leaves is due to the mesh, and has short waves. The energy is made least over
    all sums of both. None if it stays large: least squares, by a factor of their own, take less then.
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
