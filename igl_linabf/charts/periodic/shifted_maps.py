"""Shift the seams of a map by whole periods of a texture; seam sides differ by quarter turns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from ..._types import ComplexArray, FloatArray, IntArray
from ...surface import Submesh, complex_positions, connected_labels, real_coordinates, signed_double_areas
from .lattice import find_nearest_integers
from .seam_shifts import FreeShifts, SeamSides, find_fans
from .stiffness import Stiffness, build_displacement_energy, measure_triangle_changes

COST_OF_SHIFT = 0.01  # regularisation: energy added for each shift, relative to the mean energy of a shift
# Lower bound of the mean energy of a shift, relative to the energy if only points at the seam move.
MIN_SHIFT_COST = 1e-7
COLUMNS_AT_ONCE = 32  # number of right-hand sides in one call of the linear solver
MAX_WEIGHTINGS = 4  # maximum number of solves with increased weights, if triangles flip
DOUBLING_CHANGE = 0.3  # a triangle that changes by this relative amount gets twice the weight


@dataclass(frozen=True, eq=False)
class ShiftedMaps:
    """The maps that result from a given map if its seams are shifted.

    The sides of a seam edge are at z and i^k z + t. If each shift t is a whole number of periods along both
    axes, a periodic texture continues across the seam. The shifts determine the position of each cone, which
    is the fixed point of the turns around it. All other points are displaced with the least energy, and
    `find_nearest_integers` chooses whole periods that keep this energy small. The energy is a
    quadratic form of the shifts. Computing it takes one linear solve for each free shift, independent of the
    period. If triangles flip, the weights of the triangles that change most are increased.

    Attributes
    ----------
    z : (#TC,) complex128
        The map.
    component : (#V,) int64
        The component of the surface that contains each vertex.
    sides : SeamSides
    free : FreeShifts
    first : (#V,) complex128
        The position of each vertex, or of its first copy if it has several.
    turn : (#TC, #V) complex128
        The positions of all copies as functions of the first copies, without shifts.
    shift_matrix : (#TC, #S) complex128
        The contribution of the shifts of the seam edges to the positions of all copies.
    corner : (3, #F) int64
        The row indices of the triangles' corners.
    """

    z: ComplexArray
    component: IntArray
    sides: SeamSides
    free: FreeShifts
    first: ComplexArray
    turn: sparse.csr_array
    shift_matrix: sparse.csr_array
    corner: IntArray

    @classmethod
    def from_map(cls, surface: Submesh, TC: FloatArray, FTC: IntArray) -> ShiftedMaps:
        """Prepare the shifts of a map that has at least one seam edge.

        Raises
        ------
        MeshError
            The two sides of a seam do not differ by a rotation by a multiple of 90 degrees.
        """
        z, n = complex_positions(TC), len(surface.V)
        sides = SeamSides.from_map(surface, z, FTC)
        fans = [fan for fan in find_fans(sides) if fan.copies]
        origin, first = np.empty(len(z), dtype=np.int64), np.empty(n, dtype=np.complex128)
        origin[FTC] = surface.F
        first[origin] = z
        first[[fan.vertex for fan in fans]] = z[[fan.copies[0] for fan in fans]]
        turn = np.ones(len(z), dtype=np.complex128)
        sums = list[tuple[int, int, complex]]()
        for fan in fans:
            for copy, by, own in zip(fan.copies, fan.turns, fan.sums, strict=True):
                turn[copy] = by
                sums += [(copy, e, factor) for e, factor in own]
        copy, edge = np.array([(copy, e) for copy, e, _ in sums]).T
        factor = np.array([factor for *_, factor in sums])
        return cls(
            z,
            connected_labels(surface.topology.edges, n),
            sides,
            FreeShifts.from_seam_sides(sides, fans),
            first,
            sparse.csr_array((turn, (np.arange(len(z)), origin)), shape=(len(z), n)),
            sparse.csr_array((factor, (copy, edge)), shape=(len(z), len(sides.turn))),
            np.ascontiguousarray(FTC.T),
        )

    def shift_seams(self, period: float) -> FloatArray:
        """Return the texture coordinates after shifting the seams by whole periods, (#TC, 2)."""
        q, area = self._choose_seam_shifts(period), signed_double_areas(self.z, self.corner)
        moved, weight = self._displace_map(q, period, self._uniform_stiffness), np.ones(len(area))
        for _ in range(MAX_WEIGHTINGS):
            if not (signed_double_areas(moved, self.corner) * area < 0).any():
                break
            weight = weight * (
                1 + measure_triangle_changes(self.z, moved - self.z, self.corner) / DOUBLING_CHANGE
            )
            moved = self._displace_map(q, period, self._build_stiffness(weight))
        return real_coordinates(moved)

    def _displace_map(self, q: ComplexArray, period: float, stiffness: Stiffness) -> ComplexArray:
        """Return the map in which the free shifts are `q` times the period."""
        shift, cones = period * np.round(self.free.shifts @ q), self.free.cones
        d = np.zeros(len(self.first), dtype=np.complex128)
        d[cones] = period * (self.free.places @ q) - self.first[cones]
        shifted = self.turn @ self.first + self.shift_matrix @ shift
        force = self.turn.conj().T @ (stiffness.of_copies @ (shifted - self.z)) + stiffness.of_vertices @ d
        d[stiffness.inner] = stiffness.solve(-force[stiffness.inner])
        return np.asarray(shifted + self.turn @ d)

    def _choose_seam_shifts(self, period: float) -> ComplexArray:
        """Choose the free shifts, as complex integers in units of the period."""
        wanted = self.sides.shift[self.free.edges] / period
        q = np.zeros(len(wanted), dtype=np.complex128)
        for own, form in self._shift_energies:
            q[own] = find_nearest_integers(form, wanted[own])
        return q

    @cached_property
    def _uniform_stiffness(self) -> Stiffness:
        """The `Stiffness` with equal weights for all triangles."""
        return self._build_stiffness(np.ones(self.corner.shape[1]))

    def _build_stiffness(self, weight: FloatArray) -> Stiffness:
        """Return the `Stiffness` with the given weights of triangles."""
        return Stiffness.from_energy(
            build_displacement_energy(self.z, self.corner, weight), self.turn, self.free.cones
        )

    @cached_property
    def _shift_energies(self) -> list[tuple[IntArray, ComplexArray]]:
        """The free shifts of each component of the surface, and their energy as a Hermitian form.

        Components do not interact. Therefore each right-hand side combines one free shift of every component.
        """
        stiffness = self._uniform_stiffness
        label = self.component[self.sides.vertex[self.free.edges, 0]]
        order = np.argsort(label, kind="stable")
        groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1) if len(order) else []
        column = np.empty(len(label), dtype=np.int64)
        for own in groups:
            column[own] = np.arange(len(own))
        shape = len(label), max(map(len, groups), default=0)
        compressed = sparse.csr_array((np.ones(len(label)), (np.arange(len(label)), column)), shape=shape)
        alone = self.shift_matrix @ self.free.shifts + self.turn[:, self.free.cones] @ self.free.places
        pushed = stiffness.of_copies @ alone
        force = (self.turn.conj().T @ pushed).tocsr()[stiffness.inner]
        forms = (alone.conj().T @ pushed @ compressed).toarray()
        least = MIN_SHIFT_COST * np.abs(forms).max(initial=0.0)
        for k in range(0, forms.shape[1], COLUMNS_AT_ONCE):
            at_once = slice(k, k + COLUMNS_AT_ONCE)
            columns = np.asfortranarray((force @ compressed[:, at_once]).toarray())
            forms[:, at_once] -= force.conj().T @ stiffness.solve(columns)
        return [(own, _make_definite(forms[own, : len(own)], least)) for own in groups]


def _make_definite(form: ComplexArray, least: float) -> ComplexArray:
    """Make a Hermitian form of shifts positive definite by adding a small cost to each shift."""
    values, vectors = np.linalg.eigh((form + form.conj().T) / 2)
    size = max(float(values.mean()), least)
    return np.asarray((vectors * (np.maximum(values, 0) + COST_OF_SHIFT * size)) @ vectors.conj().T)
