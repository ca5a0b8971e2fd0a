"""The linear angle system in reduced form, and the Laplacian that preconditions it."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy import sparse

from .._types import FloatArray, IntArray
from ..linalg import Symmetric, held
from ..surface import NEXT, PREV
from .constraints import Constraints

SLIVER = 10.0  # eigenvalue ratio of a triangle's P and s K above which it is corrected for


class System:
    """The reduced linear system of the angle errors at `alpha` (docs/method.md).

    The paper minimises sum (e / alpha)^2 subject to A e = b, that is (A W A^T) x = b and
    e = W A^T x with W = diag(alpha^2) (eq. 11-16). Its triangle rows are mutually W-orthogonal.
    Eliminating them leaves, with w = alpha^2, d = sum w, P = diag(w) - w w^T / d per triangle,

        S x = r - M e0,    S = sum_t M_t P_t M_t^T,    e = e0 + P M^T x,

    with e0 = w (pi - sum alpha) / d. M has the vertex and the wheel rows (eq. 5, 10); the two rows of
    a vertex are next to each other. Converged ABF uses the weights w = alpha_0^2. Where a row has no
    wheel constraint, S has the identity in its place, and the multiplier is zero.
    """

    def __init__(self, constraints: Constraints, alpha: FloatArray, w: FloatArray | None = None) -> None:
        self.constraints, self.topology, self.pattern = constraints, constraints.topology, constraints.pattern
        self.w = alpha**2 if w is None else w
        self.d = self.w.sum(axis=0)
        self.cot = 1 / np.tan(alpha)
        self._rows = constraints.row[self.topology.corner]

    def at_vertices(self, x: FloatArray) -> FloatArray:
        """Multipliers of each vertex, (#V, 2), from the multipliers of the rows, (#rows, 2)."""
        if self.constraints.wheels < self.constraints.n:
            x = x.copy()
            x[self.constraints.wheels :, 1] = 0.0
        return np.vstack((x, np.zeros((1, 2))))[self.constraints.row]  # a missing row, -1, reads the zeros

    def at_corners(self, x: FloatArray) -> FloatArray:
        """M^T x: (3, #F) values from the multipliers at each corner's vertex, (2, 3, #F)."""
        vertex, wheel = x
        return np.asarray(vertex + self.cot * (wheel[PREV] - wheel[NEXT]))

    def projected(self, y: FloatArray) -> FloatArray:
        """P y: (3, #F) angles that sum to zero in each triangle."""
        w, after, before = self.w, y[NEXT], y[PREV]
        return np.asarray(w * ((w[NEXT] * (y - after) + w[PREV] * (y - before)) / self.d))

    def projection(self, faces: IntArray) -> FloatArray:
        """P_t of some faces, (#faces, 3, 3)."""
        return self._from_pairs(self._pairs[:, faces])

    def conformal(self, faces: IntArray) -> FloatArray:
        """s_t K_t of some faces, (#faces, 3, 3)."""
        return self._from_pairs(self.cot[:, faces] * self._conformal_scale[faces] / 2)

    @staticmethod
    def _from_pairs(weight: FloatArray) -> FloatArray:
        """Element matrices (#faces, 3, 3) of sum weight_k (y_i - y_j)^2, k opposite to i and j."""
        K = np.empty((weight.shape[1], 3, 3))
        for k in range(3):
            i, j = NEXT[k], PREV[k]
            K[:, i, j] = K[:, j, i] = -weight[k]
            K[:, k, k] = weight[i] + weight[j]
        return K

    @cached_property
    def _pairs(self) -> FloatArray:
        """w_i w_j / d, (3, #F), k opposite to i and j: y^T P y sums this times (y_i - y_j)^2 over pairs.

        Near an angle of pi, w - w^2 / d would be rounding error only.
        """
        return np.asarray(self.w[NEXT] * self.w[PREV] / self.d)

    @cached_property
    def _conformal_scale(self) -> FloatArray:
        return np.asarray(2 * np.sqrt(self.w.prod(axis=0) / self.d))

    def rows(self, e: FloatArray) -> FloatArray:
        """M e: (#rows, 2) sums of (3, #F) angles."""
        t, q = self.topology, self.cot * e
        vertex = self.constraints.sum_at_rows(t.sum_at_vertices(e))  # eq. 5
        wheel = self.constraints.sum_at_wheels(t.sum_at_vertices(q[NEXT] - q[PREV]))  # eq. 8-10
        return np.column_stack((vertex, wheel))

    def matrix(self) -> Symmetric:
        """S, (2 #rows, 2 #rows)."""
        t, c, pair = self.topology, self.cot, self._pairs
        cn, cp, opposite = c[NEXT], c[PREV], pair
        beside_p, beside_n = pair[NEXT], pair[PREV]  # of corners k and k - 1, of k and k + 1
        # within a corner's own row: (vertex, vertex), (vertex, wheel), (wheel, wheel)
        own = (
            beside_n + beside_p,
            beside_p * cp - beside_n * cn,
            opposite * (cn + cp) ** 2 + beside_n * cn**2 + beside_p * cp**2,
        )
        vertex, mixed, wheel = (self.constraints.sum_at_rows(t.sum_at_vertices(values)) for values in own)
        diagonal = np.stack((vertex, mixed, mixed, wheel))
        # between the corners a, b at tail and head of the half-edge opposite to corner k, as
        # (vertex, vertex), (vertex, wheel), (wheel, vertex), (wheel, wheel)
        to_a, to_b = beside_n * (c + cn), beside_p * (c + cp)
        across = (
            -opposite,
            -opposite * cn - to_a,
            opposite * cp + to_b,
            opposite * cn * cp - c * (to_a + to_b),
        )
        vv, vw, wv, ww = (values.ravel() for values in across)
        h, r = self.pattern.upward  # r runs the other way, where the block is transposed
        if min(h.min(initial=0), r.min(initial=0)) < 0:  # edges of the boundary between two rows
            vv, vw, wv, ww = (np.append(values, 0.0) for values in (vv, vw, wv, ww))
        block = np.stack((vv[h] + vv[r], vw[h] + wv[r], wv[h] + vw[r], ww[h] + ww[r]))
        for side, rows in self.pattern.loops:  # edges within a hole's row
            for k, values in enumerate((2 * vv, vw + wv, vw + wv, 2 * ww)):
                diagonal[k] += self.pattern.row_sums(rows, values[side])
        if self.constraints.wheels < self.constraints.n:
            low, high = self.pattern.lows_and_highs >= self.constraints.wheels
            block[1, high] = block[2, low] = block[3, high] = 0.0
            diagonal[1:3, self.constraints.wheels :] = 0.0
            diagonal[3, self.constraints.wheels :] = 1.0
        return self.pattern.symmetric(block, diagonal)

    def laplacian(self) -> sparse.csc_array:
        """Lower triangle of L_s = sum_t s_t K_t, K_t the cotangent element matrix.

        With K_t for P_t, S would be diag(L, L) exactly: the two rows of a vertex are the parts
        of one complex number, the logarithm of an edge ratio, which is holomorphic in the
        triangle's shape. s_t = 2 sqrt(w0 w1 w2 / d) is the geometric mean of the two
        eigenvalue ratios of P_t and K_t.
        """
        return self.pattern.laplacian(self.topology.sum_at_edges(self.cot * self._conformal_scale) / 2)

    def wheel_laplacian(self, lower: sparse.csc_array) -> sparse.csc_array:
        """Lower triangle of L_s over the rows with a wheel constraint, the identity on the others."""
        return held(lower, self.constraints.wheels)

    def sliver_rows(self) -> IntArray:
        """Rows of the triangles in which P_t and s_t K_t differ by more than `SLIVER`."""
        w, c, d = self.w, self.cot, self.d
        # tr(K+ P) = (tr K tr P - tr K P) / (3/4), det = 4 w0 w1 w2 / d on the plane sum e = 0
        p = self._pairs[NEXT] + self._pairs[PREV]
        kp = 0.5 * ((c[NEXT] + c[PREV]) * p).sum(axis=0) + (c * self._pairs).sum(axis=0)
        trace = (c.sum(axis=0) * p.sum(axis=0) - kp) / 0.75
        ratio = trace**2 * d / (4 * w.prod(axis=0)) - 2  # rho + 1 / rho
        rows = self._rows[:, ratio > SLIVER + 1 / SLIVER]
        return np.unique(rows[rows >= 0])
