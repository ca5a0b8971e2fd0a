"""Compute the energy of isometric maps per triangle: its value, its gradient, and its convex part.

The map w -> p w + q conj(w) of a triangle from its own plane has the singular values |p| + |q| and |p| - |q|.
Both terms of the energy (Degener, Meseth, Klein 2003) depend only on A = |p|^2 and B = |q|^2, with J = A - B:

    c = (A + B) / J        angles: 1 if they are preserved, infinite for a collapsed triangle
    a = (J + 1 / J) / 2    areas: 1 if they are preserved
    E = c a^weight

With weight 1, E is a quarter of the symmetric Dirichlet energy s1^2 + s2^2 + 1 / s1^2 + 1 / s2^2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..._core import collapse_lengths, isometric_derivatives, isometric_energy
from ..._types import ComplexArray, FloatArray, IntArray
from ...surface import NEXT, PREV, Ragged

MIN_HEIGHT_RATIO = 1e-6  # thinner triangles are opened to this ratio of height to longest side


@dataclass(frozen=True, eq=False)
class RestTriangles:
    """The triangles with their rest shapes, which are their shapes on the surface.

    Attributes
    ----------
    corner : (3, #F) int64
    gradient : (3, #F) complex128
        p is the sum of `gradient` z over the corners, and q the same sum with conjugate `gradient`.
    share : (#F,) float64
        Share of each triangle in the area of its chart.
    """

    corner: IntArray
    gradient: ComplexArray
    share: FloatArray

    @classmethod
    def from_charts(
        cls, corner: IntArray, double_area: FloatArray, dot: FloatArray, faces: Ragged
    ) -> RestTriangles:
        """Prepare the triangles of charts side by side, each chart scaled to area 1.

        The triangles are given as in `Mesh`. Triangles that are too thin for accurate derivatives are opened
        to a height of `MIN_HEIGHT_RATIO` times their longest side. The total area added to a chart is limited
        to `MIN_HEIGHT_RATIO` times the area of the chart.
        """
        area = faces.repeat(faces.sum(double_area) / 2)
        longest = (dot[NEXT] + dot[PREV]).max(axis=0)  # squared length of the longest side
        room = np.minimum(
            MIN_HEIGHT_RATIO * longest - double_area, 2 * MIN_HEIGHT_RATIO * area / faces.repeat(faces.sizes)
        )
        double_area = double_area + np.maximum(room, 0)
        top = dot.argmin(axis=0)  # corner opposite to the longest side; this choice avoids cancellation
        left, right = (top + 1) % 3, (top + 2) % 3
        face = np.arange(len(top))
        side = np.sqrt(dot[left, face] + dot[right, face])
        z = np.zeros(dot.shape, dtype=np.complex128)
        z[right, face] = side
        z[top, face] = (dot[left, face] + 1j * double_area) / side
        inward = 1j * (z[PREV] - z[NEXT]) / double_area  # gradients of the hat functions
        return cls(corner, inward.conj() * np.sqrt(area) / 2, double_area / (2 * area))

    def select_faces(self, rows: IntArray) -> RestTriangles:
        """Return the triangles with the indices `rows`."""
        return RestTriangles(
            np.ascontiguousarray(self.corner[:, rows]), self.gradient[:, rows], self.share[rows]
        )

    def measure_energies(self, z: ComplexArray, weight: float) -> FloatArray:
        """Return each triangle's energy times its area share; infinite for flipped or collapsed triangles."""
        return isometric_energy(self.corner, self.gradient, self.share, z, weight)

    def differentiate(self, z: ComplexArray, weight: float) -> tuple[FloatArray, FloatArray]:
        """Return the gradient of the energy, (6, #F), and the rows, (24, #F), of its convex part.

        The convex part is the sum of row row^T over four rows of six entries: x of the corners, then y. The
        Hessian with respect to p and q has the eigenvectors i p, i q and two vectors in the plane of p and q,
        because E is a function of |p| and |q|. Negative eigenvalues are omitted (Smith, De Goes, Kim 2019).
        """
        return isometric_derivatives(self.corner, self.gradient, self.share, z, weight)

    def collapse_lengths(self, z: ComplexArray, direction: ComplexArray) -> FloatArray:
        """Return, for each triangle, the step length that collapses it (|p|^2 = |q|^2), or infinity."""
        return collapse_lengths(self.corner, self.gradient, z, direction)
