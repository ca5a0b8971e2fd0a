"""The energy of displacements of a map."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy import sparse

from ..._types import BoolArray, ComplexArray, FloatArray, IntArray, Solve
from ...linalg import Solvers, solve_complex
from ...surface import NEXT, PREV, signed_double_areas
from . import constants


@dataclass(frozen=True, eq=False)
class Stiffness:
    """An energy of displacements, and its inverse.

    Attributes
    ----------
    of_copies : (#TC, #TC) complex128
        The energy by the displacements of all rows of the map.
    of_vertices : (#V, #V) complex128
        The energy by the displacements of the vertices, whose copies move alike but for their turns.
    inner : (#V,) bool
        The vertices that are not held in place.
    solve : callable
        The inverse of `of_vertices` at these.
    """

    of_copies: sparse.csr_array
    of_vertices: sparse.csr_array
    inner: BoolArray
    solve: Solve

    @classmethod
    def of(cls, of_copies: sparse.csr_array, turn: sparse.csr_array, held: IntArray) -> Stiffness:
        """Of an energy and the vertices that are held; `turn` gives copies by vertices, (#TC, #V)."""
        A = turn.conj().T @ of_copies @ turn
        A = (A + A.conj().T) / 2  # its diagonal is real to the last bit
        A = (A + sparse.diags_array(constants.PULL_TO_PLACE * A.diagonal())).tocsr()
        inner = np.ones(A.shape[0], dtype=bool)
        inner[held] = False
        lower = sparse.tril(A[inner][:, inner]).tocsc()
        return cls(of_copies, A, inner, partial(solve_complex, Solvers().factor(lower)))


def energy(z: ComplexArray, corner: IntArray, weight: FloatArray) -> sparse.csr_array:
    """The sum over triangles of 4 |dbar d|^2 + 4 `SCALE_WEIGHT` |del d|^2, (#TC, #TC), of displacements d.

    The first term is the distortion of angles that they add, the second the change of scale and direction.
    `corner` are the rows of the triangles, (3, #F).
    """
    side, area = _sides_and_areas(z, corner)
    i, j = (a.ravel() for a in np.meshgrid(range(3), range(3), indexing="ij"))
    product = side[i].conj() * side[j]
    entries = (product + constants.SCALE_WEIGHT * product.conj()) * (weight / area**2)
    return sparse.csr_array((entries.ravel(), (corner[i].ravel(), corner[j].ravel())), shape=(len(z),) * 2)


def changes(z: ComplexArray, d: ComplexArray, corner: IntArray) -> FloatArray:
    """How much the displacement d changes the triangles of a map, (#F,): (|dbar d|^2 + |del d|^2)^(1/2)."""
    side, area = _sides_and_areas(z, corner)
    both = (side * d[corner]).sum(axis=0), (side.conj() * d[corner]).sum(axis=0)
    return np.asarray(np.hypot(np.abs(both[0]), np.abs(both[1])) / (2 * area))


def _sides_and_areas(z: ComplexArray, corner: IntArray) -> tuple[ComplexArray, FloatArray]:
    """The sides opposite to corners, (3, #F), and twice the areas."""
    area = np.abs(signed_double_areas(z, corner))
    return z[corner[PREV]] - z[corner[NEXT]], np.maximum(area, constants.MIN_AREA_OVER_LARGEST * area.max())
