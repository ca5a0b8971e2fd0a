"""The linear angle system in reduced form, and the Laplacian that preconditions it."""

import numpy as np
from scipy import sparse

from ... import _core
from ..._types import FloatArray, IntArray
from ...surface import NEXT, PREV
from .constraints import Constraints
from .patterns import Symmetric


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

    def __init__(
        self,
        constraints: Constraints,
        alpha: FloatArray,
        w: FloatArray | None = None,
        cot: FloatArray | None = None,
        *,
        scaled: bool = True,
    ) -> None:
        """With `scaled`, the conformal metric is s_t K_t, else K_t."""
        self.constraints, self.topology, self.pattern = constraints, constraints.topology, constraints.pattern
        self._scaled = scaled
        self.w = alpha**2 if w is None else w
        self.d = self.w.sum(axis=0)
        self.cot = _core.cotangents(alpha) if cot is None else cot

    def at_vertices(self, x: FloatArray) -> FloatArray:
        """Multipliers of each vertex, (#V, 2), from the multipliers of the rows, (#rows, 2)."""
        if self.constraints.wheels < self.constraints.n:
            x = x.copy()
            x[self.constraints.wheels :, 1] = 0.0
        row = self.constraints.row
        made, some = np.empty((len(row), 2)), np.empty((len(x) + 1, 2))
        some[:-1], some[-1] = x, 0.0  # a missing row, -1, reads the zeros
        return some.take(row, axis=0, out=made, mode="wrap")

    def errors(self, x: FloatArray) -> FloatArray:
        """P M^T x, (3, #F), of the multipliers of each vertex, (#V, 2)."""
        return _core.errors(self.topology.corner, self.w, self.d, self.cot, *np.ascontiguousarray(x.T))

    def at_corners(self, x: FloatArray) -> FloatArray:
        """M^T x: (3, #F) values from the multipliers at each corner's vertex, (2, 3, #F)."""
        vertex, wheel = x
        return np.asarray(vertex + self.cot * (wheel[PREV] - wheel[NEXT]))

    def projected(self, y: FloatArray) -> FloatArray:
        """P y: (3, #F) angles that sum to zero in each triangle."""
        return _core.projected(self.w, self.d, y)

    def conformal_errors(self, x: FloatArray) -> FloatArray:
        """K M^T x, (3, #F), of the multipliers of each vertex, (#V, 2)."""
        return _core.conformal_errors(self.topology.corner, self.cot, *np.ascontiguousarray(x.T))

    def conformally(self, y: FloatArray) -> FloatArray:
        """K y: (3, #F) angles that sum to zero in each triangle."""
        return _core.conformally(self.cot, y)

    def projection(self, faces: IntArray) -> FloatArray:
        """P_t of some faces, (#faces, 3, 3)."""
        # near an angle of pi, w - w^2 / d would be rounding error only
        return self._from_pairs(_core.pair_weights(self.w[:, faces], self.d[faces]))

    def conformal(self, faces: IntArray) -> FloatArray:
        """s_t K_t of some faces, (#faces, 3, 3)."""
        return self._from_pairs(self._conformal(self.w[:, faces], self.d[faces], self.cot[:, faces]))

    @staticmethod
    def _from_pairs(weight: FloatArray) -> FloatArray:
        """Element matrices (#faces, 3, 3) of sum weight_k (y_i - y_j)^2, k opposite to i and j."""
        K = np.empty((weight.shape[1], 3, 3))
        for k in range(3):
            i, j = NEXT[k], PREV[k]
            K[:, i, j] = K[:, j, i] = -weight[k]
            K[:, k, k] = weight[i] + weight[j]
        return K

    def _conformal(self, w: FloatArray, d: FloatArray, cot: FloatArray) -> FloatArray:
        """What the half-edges of some faces give to s K or K, (3, #faces), k opposite to i and j."""
        if not self._scaled:
            return cot / 2
        return _core.conformal_weights(w, d, cot)

    def rows(self, e: FloatArray) -> FloatArray:
        """M e: (#rows, 2) sums of (3, #F) angles."""
        sums = _core.row_sums(self.topology.corner, self.cot, e, self.topology.n)
        made = np.empty((self.constraints.n, 2))
        made[:, 0] = self.constraints.sum_at_rows(sums[0])  # eq. 5
        made[:, 1] = self.constraints.sum_at_rows(sums[1])  # eq. 8-10
        made[self.constraints.wheels :, 1] = 0.0
        return made

    def matrix(self) -> Symmetric:
        """S, (2 #rows, 2 #rows)."""
        topology, pattern, wheels = self.topology, self.pattern, self.constraints.wheels
        graph = pattern.indptr, pattern.indices
        edges, faces = (pattern.slot, pattern.ends, topology.sides), (topology.corner, pattern.row)
        block = _core.system_blocks(*graph, *edges, *faces, wheels, self.w, self.d, self.cot)
        return Symmetric((*graph, block))

    def laplacian(self) -> sparse.csc_array:
        """Lower triangle of L_s = sum_t s_t K_t, K_t the cotangent element matrix.

        With K_t for P_t, S would be diag(L, L) exactly: the two rows of a vertex are the parts
        of one complex number, the logarithm of an edge ratio, which is holomorphic in the
        triangle's shape. s_t = 2 sqrt(w0 w1 w2 / d) is the geometric mean of the two
        eigenvalue ratios of P_t and K_t.
        """
        return self.pattern.laplacian(self.topology.sum_at_edges(self._conformal(self.w, self.d, self.cot)))
