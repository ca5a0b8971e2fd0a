"""A map whose seams turn by quarter turns, shifted by whole periods of a texture."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from ..._types import ComplexArray, FloatArray, IntArray
from ...surface import Submesh, complex_positions, connected_labels, coordinates, signed_double_areas
from . import constants
from .lattice import nearest_whole
from .seam_shifts import FreeShifts, SeamSides, fans_of
from .stiffness import Stiffness, changes, energy


@dataclass(frozen=True, eq=False)
class Shifted:
    """All ways to shift the seams of a map.

    The sides of a seam edge are at z and i^k z + t. If each shift t is whole periods along both axes, a
    periodic texture goes on across the seam. The shifts determine the place of each cone: the fixed point of
    the turns around it. All other points are displaced with the least energy, and the shifts are those whole
    periods for which this energy is small (`nearest_whole`). As a quadratic form of the shifts, it takes one
    solve for each shift that can be chosen, whatever the period. If triangles flip, those that change much
    are weighted more.

    Attributes
    ----------
    z : (#TC,) complex128
        The map.
    component : (#V,) int64
        The component of each of the surface's vertices.
    sides : SeamSides
    free : FreeShifts
    first : (#V,) complex128
        The place of each vertex: that of its first copy, if it has several.
    turn : (#TC, #V) complex128
        The places of all copies by those of the first copies, if no seam shifts.
    moved : (#TC, #S) complex128
        What the shifts of the seam edges add to these places.
    corner : (3, #F) int64
        The rows of the triangles.
    """

    z: ComplexArray
    component: IntArray
    sides: SeamSides
    free: FreeShifts
    first: ComplexArray
    turn: sparse.csr_array
    moved: sparse.csr_array
    corner: IntArray

    @classmethod
    def of(cls, surface: Submesh, TC: FloatArray, FTC: IntArray) -> Shifted:
        """The ways to shift a map that has a seam.

        Raises
        ------
        MeshError
            A seam turns by no multiple of 90 degrees.
        """
        z, n = complex_positions(TC), len(surface.V)
        sides = SeamSides.of(surface, z, FTC)
        fans = [fan for fan in fans_of(sides) if fan.copies]
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
            FreeShifts.of(sides, fans),
            first,
            sparse.csr_array((turn, (np.arange(len(z)), origin)), shape=(len(z), n)),
            sparse.csr_array((factor, (copy, edge)), shape=(len(z), len(sides.turn))),
            np.ascontiguousarray(FTC.T),
        )

    def by(self, period: float) -> FloatArray:
        """The texture coordinates whose seams shift by whole periods, (#TC, 2)."""
        q, area = self._whole(period), signed_double_areas(self.z, self.corner)
        moved, weight = self._moved(q, period, self._even), np.ones(len(area))
        for _ in range(constants.MAX_WEIGHTINGS):
            if not (signed_double_areas(moved, self.corner) * area < 0).any():
                break
            weight = weight * (1 + changes(self.z, moved - self.z, self.corner) / constants.DOUBLING_CHANGE)
            moved = self._moved(q, period, self._with(weight))
        return coordinates(moved)

    def _moved(self, q: ComplexArray, period: float, stiffness: Stiffness) -> ComplexArray:
        """The map whose shifts that can be chosen are q periods."""
        shift, cones = period * np.round(self.free.shifts @ q), self.free.cones
        d = np.zeros(len(self.first), dtype=np.complex128)
        d[cones] = period * (self.free.places @ q) - self.first[cones]
        shifted = self.turn @ self.first + self.moved @ shift
        force = self.turn.conj().T @ (stiffness.of_copies @ (shifted - self.z)) + stiffness.of_vertices @ d
        d[stiffness.inner] = stiffness.solve(-force[stiffness.inner])
        return np.asarray(shifted + self.turn @ d)

    def _whole(self, period: float) -> ComplexArray:
        """The chosen shifts, in periods."""
        wanted = self.sides.shift[self.free.edges] / period
        q = np.zeros(len(wanted), dtype=np.complex128)
        for own, form in self._forms:
            q[own] = nearest_whole(form, wanted[own])
        return q

    @cached_property
    def _even(self) -> Stiffness:
        """The stiffness in which all triangles count the same."""
        return self._with(np.ones(self.corner.shape[1]))

    def _with(self, weight: FloatArray) -> Stiffness:
        return Stiffness.of(energy(self.z, self.corner, weight), self.turn, self.free.cones)

    @cached_property
    def _forms(self) -> list[tuple[IntArray, ComplexArray]]:
        """For each component of the surface its shifts, and the energy as their Hermitian form.

        Components share the columns that are solved for.
        """
        stiffness = self._even
        label = self.component[self.sides.vertex[self.free.edges, 0]]
        order = np.argsort(label, kind="stable")
        groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1) if len(order) else []
        column = np.empty(len(label), dtype=np.int64)
        for own in groups:
            column[own] = np.arange(len(own))
        shape = len(label), max(map(len, groups), default=0)
        compressed = sparse.csr_array((np.ones(len(label)), (np.arange(len(label)), column)), shape=shape)
        alone = self.moved @ self.free.shifts + self.turn[:, self.free.cones] @ self.free.places
        pushed = stiffness.of_copies @ alone
        force = (self.turn.conj().T @ pushed).tocsr()[stiffness.inner]
        forms = (alone.conj().T @ pushed @ compressed).toarray()
        told = constants.MIN_COST_TOLD * np.abs(forms).max(initial=0.0)
        for k in range(0, forms.shape[1], constants.COLUMNS_AT_ONCE):
            at_once = slice(k, k + constants.COLUMNS_AT_ONCE)
            columns = np.asfortranarray((force @ compressed[:, at_once]).toarray())
            forms[:, at_once] -= force.conj().T @ stiffness.solve(columns)
        return [(own, _definite(forms[own, : len(own)], told)) for own in groups]


def _definite(form: ComplexArray, told: float) -> ComplexArray:
    """A Hermitian form, made positive definite: nothing below zero, and each shift has a cost of its own."""
    values, vectors = np.linalg.eigh((form + form.conj().T) / 2)
    size = max(float(values.mean()), told)
    return np.asarray((vectors * (np.maximum(values, 0) + constants.COST_OF_SHIFT * size)) @ vectors.conj().T)
