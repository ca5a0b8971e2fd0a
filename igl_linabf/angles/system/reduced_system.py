"""The reduced linear system of the angles, and the Laplacian that preconditions it."""

import numpy as np
from scipy import sparse

from ... import _core
from ..._types import FloatArray, IntArray
from ...surface import NEXT, PREV
from .constraints import Constraints
from .patterns import Symmetric


class System:
    """The reduced linear system of the angle errors at `alpha` (docs/method.md).

    The paper minimises sum (e / alpha)^2 subject to A e = b. The solution is e = W A^T x with (A W A^T) x = b
    and W = diag(alpha^2) (eq. 11-16). The triangle rows of A are mutually W-orthogonal. Eliminating them
    leads, with w = alpha^2, d = sum w and P = diag(w) - w w^T / d per triangle, to

        S x = r - M e0,    S = sum_t M_t P_t M_t^T,    e = e0 + P M^T x,

    where e0 = w (pi - sum alpha) / d. M contains the vertex and wheel rows (eq. 5, 10), and the two rows of a
    vertex are adjacent. Converged ABF uses the weights w = alpha_0^2. For a row without a wheel constraint, S
    contains the identity, and the multiplier is zero.
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
        """Set up the system; with `scaled`, the conformal metric is s_t K_t, otherwise K_t."""
        self.constraints, self.topology, self.pattern = constraints, constraints.topology, constraints.pattern
        self._scaled = scaled
        self.w = alpha**2 if w is None else w
        self.d = self.w.sum(axis=0)
        self.cot = _core.cotangents(alpha) if cot is None else cot

    def multipliers_at_vertices(self, x: FloatArray) -> FloatArray:
        """Return the multipliers of each vertex, (#V, 2), from the multipliers of the rows, (#rows, 2)."""
        if self.constraints.wheels < self.constraints.n_rows:
            x = x.copy()
            x[self.constraints.wheels :, 1] = 0.0
        row = self.constraints.row
        made, some = np.empty((len(row), 2)), np.empty((len(x) + 1, 2))
        some[:-1], some[-1] = x, 0.0  # index -1 selects the zeros
        return some.take(row, axis=0, out=made, mode="wrap")

    def compute_angle_errors(self, x: FloatArray) -> FloatArray:
        """Return the angle errors P M^T x, (3, #F), for the multipliers of each vertex, (#V, 2)."""
        return _core.errors(self.topology.corner, self.w, self.d, self.cot, *np.ascontiguousarray(x.T))

    def multiply_transposed(self, x: FloatArray) -> FloatArray:
        """Multiply the transposed constraints M^T, (3, #F), by the multipliers at each corner, (2, 3, #F)."""
        vertex, wheel = x
        return np.asarray(vertex + self.cot * (wheel[PREV] - wheel[NEXT]))

    def project(self, y: FloatArray) -> FloatArray:
        """Return the projection P y of angles y: (3, #F) angles that sum to zero in each triangle."""
        return _core.project_errors(self.w, self.d, y)

    def compute_conformal_errors(self, x: FloatArray) -> FloatArray:
        """Return the angle errors K M^T x in the conformal metric, for multipliers of vertices, (#V, 2)."""
        return _core.conformal_errors(self.topology.corner, self.cot, *np.ascontiguousarray(x.T))

    def projection_matrices(self, faces: IntArray) -> FloatArray:
        """Return the projection matrices P_t of some faces, (#faces, 3, 3)."""
        # from differences of pairs: near an angle of pi, w - w^2 / d would leave only rounding errors
        return self._assemble_element_matrices(_core.pair_weights(self.w[:, faces], self.d[faces]))

    def conformal_matrices(self, faces: IntArray) -> FloatArray:
        """Return the conformal metric s_t K_t of some faces, (#faces, 3, 3)."""
        return self._assemble_element_matrices(
            self._half_edge_weights(self.w[:, faces], self.d[faces], self.cot[:, faces])
        )

    @staticmethod
    def _assemble_element_matrices(weight: FloatArray) -> FloatArray:
        """Return element matrices, (#faces, 3, 3), of sum weight_k (y_i - y_j)^2, k opposite to i and j."""
        K = np.empty((weight.shape[1], 3, 3))
        for k in range(3):
            i, j = NEXT[k], PREV[k]
            K[:, i, j] = K[:, j, i] = -weight[k]
            K[:, k, k] = weight[i] + weight[j]
        return K

    def _half_edge_weights(self, w: FloatArray, d: FloatArray, cot: FloatArray) -> FloatArray:
        """Return the half-edge weights of faces, (3, #faces): entries of s K, or of K if it is not scaled."""
        if not self._scaled:
            return cot / 2
        return _core.conformal_weights(w, d, cot)

    def compute_constraint_changes(self, e: FloatArray) -> FloatArray:
        """Return M e, (#rows, 2): how the angle errors e, (3, #F), change the two constraints of each row."""
        sums = _core.constraint_changes(self.topology.corner, self.cot, e, self.topology.n)
        made = np.empty((self.constraints.n_rows, 2))
        made[:, 0] = self.constraints.sum_at_rows(sums[0])  # vertex constraints, eq. 5
        made[:, 1] = self.constraints.sum_at_rows(sums[1])  # wheel constraints, eq. 8-10
        made[self.constraints.wheels :, 1] = 0.0
        return made

    def build_matrix(self) -> Symmetric:
        """Return the reduced matrix S, (2 #rows, 2 #rows)."""
        topology, pattern, wheels = self.topology, self.pattern, self.constraints.wheels
        graph = pattern.indptr, pattern.indices
        edges, faces = (pattern.slot, pattern.edge_rows, topology.sides), (topology.corner, pattern.row)
        block = _core.system_blocks(*graph, *edges, *faces, wheels, self.w, self.d, self.cot)
        return Symmetric((*graph, block))

    def build_laplacian(self) -> sparse.csc_array:
        """Return the lower triangle of L_s = sum_t s_t K_t, where K_t is the cotangent element matrix.

        With K_t instead of P_t, S would be exactly diag(L, L). The reason is that the two rows of a vertex
        are the parts of a complex number, the logarithm of an edge ratio, which is holomorphic in the shape
        of the triangle. s_t = 2 sqrt(w0 w1 w2 / d) is the geometric mean of the two eigenvalue ratios of P_t
        and K_t.
        """
        return self.pattern.build_laplacian(
            self.topology.sum_at_edges(self._half_edge_weights(self.w, self.d, self.cot))
        )
