"""The energy of isometric maps, triangle by triangle: its value, its slope, its convex part.

A triangle's map w -> p w + q conj(w) from its own plane has the singular values |p| + |q| and |p| - |q|. Both
terms of the energy (Degener, Meseth, Klein 2003) depend on A = |p|^2 and B = |q|^2 alone, J = A - B:

    c = (A + B) / J        angles: 1 where they stay, infinite at a collapsed triangle
    a = (J + 1 / J) / 2    areas: 1 where they stay
    E = c a^weight

With weight 1 it is a quarter of the symmetric Dirichlet energy s1^2 + s2^2 + 1 / s1^2 + 1 / s2^2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..._core import collapse_lengths, isometric_energy, isometric_rows
from ..._types import ComplexArray, FloatArray, IntArray
from ...surface import NEXT, PREV, Ragged
from .constants import OPENING


@dataclass(frozen=True, eq=False)
class Rest:
    """Triangles as they are on the surface.

    Attributes
    ----------
    corner : (3, #F) int64
    gradient : (3, #F) complex128
        p is the sum of `gradient` z over the corners, q that of its conjugate.
    share : (#F,) float64
        Of each triangle in the area of its chart.
    """

    corner: IntArray
    gradient: ComplexArray
    share: FloatArray

    @classmethod
    def of(cls, corner: IntArray, double_area: FloatArray, dot: FloatArray, faces: Ragged) -> Rest:
        """Triangles as a `Mesh` has them, of charts side by side, scaled so that each has the area one.

        Triangles too thin for the derivatives' digits are opened: to `OPENING` times their longest side in
        height, as far as `OPENING` times the chart's area is enough for all of them.
        """
        area = faces.repeat(faces.sum(double_area) / 2)
        longest = (dot[NEXT] + dot[PREV]).max(axis=0)  # squared
        room = np.minimum(OPENING * longest - double_area, 2 * OPENING * area / faces.repeat(faces.sizes))
        double_area = double_area + np.maximum(room, 0)
        top = dot.argmin(axis=0)  # opposite to the longest side, whose length has no cancellation
        left, right = (top + 1) % 3, (top + 2) % 3
        face = np.arange(len(top))
        side = np.sqrt(dot[left, face] + dot[right, face])
        z = np.zeros(dot.shape, dtype=np.complex128)
        z[right, face] = side
        z[top, face] = (dot[left, face] + 1j * double_area) / side
        inward = 1j * (z[PREV] - z[NEXT]) / double_area  # gradients of the hat functions
        return cls(corner, inward.conj() * np.sqrt(area) / 2, double_area / (2 * area))

    def energy(self, z: ComplexArray, weight: float) -> FloatArray:
        """Of each triangle, times its share; infinite where a triangle is not upright."""
        return isometric_energy(self.corner, self.gradient, self.share, z, weight)

    def expanded(self, z: ComplexArray, weight: float) -> tuple[FloatArray, FloatArray]:
        """The slope of the energy, (6, #F), and `rows`, (24, #F): its convex part is the sum of row row^T.

        Four rows of six: by x of the corners, then y. The Hessian by p and q has the eigenvectors i p, i q
        and two in the plane of p and q, as E is a function of |p| and |q|; negative eigenvalues are left out
        (Smith, De Goes, Kim 2019).
        """
        return isometric_rows(self.corner, self.gradient, self.share, z, weight)

    def collapse_lengths(self, z: ComplexArray, direction: ComplexArray) -> FloatArray:
        """The step length at which each triangle collapses, |p|^2 = |q|^2; infinite where none does."""
        return collapse_lengths(self.corner, self.gradient, z, direction)
