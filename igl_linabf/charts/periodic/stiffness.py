"""Compute the energy of displacements of a map."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy import sparse

from ..._types import BoolArray, ComplexArray, FloatArray, IntArray, Solve
from ...linalg import Solvers, solve_complex
from ...surface import NEXT, PREV, signed_double_areas

DIAGONAL_SHARE = 1e-8  # share of the energy matrix's diagonal that is added to make it definite
MIN_AREA_OVER_LARGEST = 1e-8  # smaller triangle areas, relative to the largest, are replaced by this
SCALE_WEIGHT = 0.1  # weight of changes of scale and direction, relative to changes of angles


@dataclass(frozen=True, eq=False)
class Stiffness:
    """The energy of displacements of a map, and its inverse.

    Attributes
    ----------
    of_copies : (#TC, #TC) complex128
        The energy as a quadratic form of the displacements of all rows of the map.
    of_vertices : (#V, #V) complex128
        The energy as a quadratic form of the displacements of the vertices. All copies of a vertex move by
        the same displacement, rotated by `turn`.
    inner : (#V,) bool
        The vertices that are not fixed.
    solve : callable
        The inverse of `of_vertices` at the vertices that are not fixed.
    """

    of_copies: sparse.csr_array
    of_vertices: sparse.csr_array
    inner: BoolArray
    solve: Solve

    @classmethod
    def from_energy(cls, of_copies: sparse.csr_array, turn: sparse.csr_array, held: IntArray) -> Stiffness:
        """Factor an energy with the vertices `held` fixed; `turn`, (#TC, #V), maps vertices to copies."""
        A = turn.conj().T @ of_copies @ turn
        A = (A + A.conj().T) / 2  # removes rounding errors: the diagonal becomes real
        A = (A + sparse.diags_array(DIAGONAL_SHARE * A.diagonal())).tocsr()
        inner = np.ones(A.shape[0], dtype=bool)
        inner[held] = False
        lower = sparse.tril(A[inner][:, inner]).tocsc()
        return cls(of_copies, A, inner, partial(solve_complex, Solvers().factor(lower)))


def build_displacement_energy(z: ComplexArray, corner: IntArray, weight: FloatArray) -> sparse.csr_array:
    """Return the energy of displacements d as a matrix, (#TC, #TC).

    The energy is the sum over triangles of 4 |dbar d|^2 + 4 `SCALE_WEIGHT` |del d|^2. The first term is the
    distortion of angles, the second the change of scale and direction. `corner` has the row indices of the
    triangles, (3, #F).
    """
    side, area = _compute_sides_and_areas(z, corner)
    i, j = (a.ravel() for a in np.meshgrid(range(3), range(3), indexing="ij"))
    product = side[i].conj() * side[j]
    entries = (product + SCALE_WEIGHT * product.conj()) * (weight / area**2)
    return sparse.csr_array((entries.ravel(), (corner[i].ravel(), corner[j].ravel())), shape=(len(z),) * 2)


def measure_triangle_changes(z: ComplexArray, d: ComplexArray, corner: IntArray) -> FloatArray:
    """Return how much the displacement d changes each triangle, (#F,): (|dbar d|^2 + |del d|^2)^(1/2)."""
    side, area = _compute_sides_and_areas(z, corner)
    both = (side * d[corner]).sum(axis=0), (side.conj() * d[corner]).sum(axis=0)
    return np.asarray(np.hypot(np.abs(both[0]), np.abs(both[1])) / (2 * area))


def _compute_sides_and_areas(z: ComplexArray, corner: IntArray) -> tuple[ComplexArray, FloatArray]:
    """Return the sides opposite to corners, (3, #F), and twice the areas."""
    area = np.abs(signed_double_areas(z, corner))
    return z[corner[PREV]] - z[corner[NEXT]], np.maximum(area, MIN_AREA_OVER_LARGEST * area.max())
