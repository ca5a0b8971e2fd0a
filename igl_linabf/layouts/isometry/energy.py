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

from ..._types import Array, ComplexArray, FloatArray, IntArray
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

    def derivatives(self, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """p and q of each triangle; linear in z."""
        at = z[self.corner]
        return (self.gradient * at).sum(axis=0), (self.gradient.conj() * at).sum(axis=0)

    def energy(self, z: ComplexArray, weight: float) -> FloatArray:
        """Of each triangle, times its share; infinite where a triangle is not upright."""
        p, q = self.derivatives(z)
        a, b = np.abs(p) ** 2, np.abs(q) ** 2
        upright = a > b
        value = np.full(len(a), np.inf)
        value[upright] = _value(a[upright], b[upright], weight)
        return np.asarray(self.share * value)

    def expanded(self, z: ComplexArray, weight: float) -> tuple[FloatArray, FloatArray]:
        """The slope of the energy, (6, #F), and `rows` (4, 6, #F): its convex part is sum rows rows^T.

        By x of the three corners, then y. The Hessian by p and q has the eigenvectors i p, i q and two in
        the plane of p and q, as E is a function of |p| and |q|; negative eigenvalues are left out (Smith,
        De Goes, Kim 2019).
        """
        p, q = self.derivatives(z)
        r, s = np.abs(p), np.abs(q)
        e_a, e_b, e_aa, e_ab, e_bb = _derivatives(r * r, s * s, weight)
        along, around = _rows_of(p / r, self.gradient)
        across, beside = _rows_of(np.where(s > 0, q, 1) / np.where(s > 0, s, 1), self.gradient.conj())
        slope = self.share * (2 * r * e_a * along + 2 * s * e_b * across)
        rr, rs, ss = 2 * e_a + 4 * r * r * e_aa, 4 * r * s * e_ab, 2 * e_b + 4 * s * s * e_bb
        middle, half, turn = (rr + ss) / 2, np.hypot((rr - ss) / 2, rs), np.arctan2(2 * rs, rr - ss) / 2
        cos, sin = np.cos(turn), np.sin(turn)
        rows = np.stack((cos * along + sin * across, cos * across - sin * along, around, beside))
        values = np.stack((middle + half, middle - half, 2 * e_a, 2 * e_b))
        rows *= np.sqrt(self.share * np.maximum(values, 0))[:, None]
        return slope, rows


def _rows_of(unit: Array, gradient: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Real and imaginary part of conj(unit) times sum gradient z, as rows by the corners' x and y."""
    turned = unit.conj() * gradient
    real, imag = turned.real, turned.imag
    return np.concatenate((real, -imag)), np.concatenate((imag, real))


def _value(a: FloatArray, b: FloatArray, weight: float) -> FloatArray:
    j = a - b
    return np.asarray((a + b) / j * ((j + 1 / j) / 2) ** weight)


def _derivatives(a: FloatArray, b: FloatArray, weight: float) -> tuple[FloatArray, ...]:
    """First and second derivatives of E by A and B: E_A, E_B, E_AA, E_AB, E_BB."""
    j = a - b
    c, c_a, c_b = (a + b) / j, -2 * b / j**2, 2 * a / j**2
    c_aa, c_ab, c_bb = 4 * b / j**3, -2 * (a + b) / j**3, 4 * a / j**3
    area, slope = (j + 1 / j) / 2, (1 - j**-2.0) / 2
    h, h_j = area**weight, weight * area ** (weight - 1) * slope
    h_jj = weight * ((weight - 1) * area ** (weight - 2) * slope**2 + area ** (weight - 1) / j**3)
    return (
        c_a * h + c * h_j,
        c_b * h - c * h_j,
        c_aa * h + 2 * c_a * h_j + c * h_jj,
        c_ab * h + (c_b - c_a) * h_j - c * h_jj,
        c_bb * h - 2 * c_b * h_j + c * h_jj,
    )
