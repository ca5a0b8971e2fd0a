"""Translation closure of holes: two closure rows of the angle system for each hole."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import linalg, sparse

from .._types import FloatArray
from ..linalg import NotPositiveDefiniteError
from ..surface import NEXT, PREV, Topology, sum_by
from .loops import Closure
from .reduced import System

Solve = Callable[[FloatArray], FloatArray]


class ClosingRows:
    """The closure rows T of the holes, and the angle system bordered by them.

    With q as in `Closure`, the gap of a hole changes by

        d tau = sum_v q_v (d log-ratio_v + i d turning_v) = -sum_v q_v (wheel_v + i vertex_v) e,

    where wheel_v and vertex_v are the rows of the single loop vertices (docs/holes.md). So T^T y
    has the vertex rows Im(q conj(y)) and the wheel rows -Re(q conj(y)). The system becomes

        [ S    B ] [x]        B = M P T^T,  D = T P T^T.
        [ B^T  D ] [y]

    In the conformal metric, with s_t K_t for P_t, S is close to diag(L_s, L_s); it is equal if all s_t
    are equal. The bordered system of that metric is the preconditioner. It is solved with the factor
    of L_s and a dense Schur complement.
    """

    def __init__(self, system: System, closure: Closure) -> None:
        self._topology, self._cot, self._closure = system.topology, system.cot, closure
        self.size = 2 * len(closure.gap)
        self._n = 2 * system.constraints.n
        self._metrics = _products(system, closure)
        self._shape = (self._n, self.size)
        self.B, self.D = self._take(system.projection)

    def _take(self, metric: Callable[..., FloatArray]) -> tuple[sparse.csr_array, FloatArray]:
        faces, transposed, merged, closing = self._metrics
        blocks = metric(faces)
        i = np.arange(len(faces))
        inner = sparse.bsr_array((blocks, i, np.arange(len(faces) + 1)), shape=(3 * len(faces),) * 2)
        product = (inner @ transposed).tocsr()
        return (merged @ product).tocsr(), (closing @ product).toarray()

    def matvec(self, S: Solve, z: FloatArray) -> FloatArray:
        """The bordered matrix times z, from S's product."""
        x, y = z[: self._n], z[self._n :]
        return np.concatenate((S(x) + self.B @ y, self.B.T @ x + self.D @ y))

    def at_vertices(self, y: FloatArray) -> FloatArray:
        """Multipliers of the vertex and wheel rows of single vertices, (#V, 2), that make up T^T y."""
        c = self._closure
        product = c.q * (y[0::2] - 1j * y[1::2])[c.hole]
        x = np.zeros((self._topology.n, 2))
        x[c.vertex, 0], x[c.vertex, 1] = product.imag, -product.real
        return x

    def rows(self, e: FloatArray) -> FloatArray:
        """T e, (2 #holes,)."""
        c, q = self._closure, self._cot * e
        vertex = self._topology.sum_at_vertices(e)[c.vertex]
        wheel = self._topology.sum_at_vertices(q[NEXT] - q[PREV])[c.vertex]
        moved = -c.q * (wheel + 1j * vertex)
        parts = [sum_by(c.hole, part, len(c.gap)) for part in (moved.real, moved.imag)]
        return np.column_stack(parts).ravel()

    def solver(self, inner: Solve, B: sparse.csr_array | None = None, D: FloatArray | None = None) -> Solve:
        """Solve the bordered system, given the `inner` solve of its first block, (2 #rows, k)."""
        B = self.B if B is None else B
        D = self.D if D is None else D
        across = inner(B.toarray())
        schur = D - B.T @ across
        try:
            factor = linalg.cho_factor((schur + schur.T) / 2)
        except linalg.LinAlgError:
            raise NotPositiveDefiniteError(self._n - 1) from None

        def solve(r: FloatArray) -> FloatArray:
            x = inner(r[: self._n, None])[:, 0]
            y = linalg.cho_solve(factor, r[self._n :] - B.T @ x)
            return np.concatenate((x - across @ y, y))

        return solve

    def preconditioner(self, system: System, inner: Solve) -> Solve:
        """Solve the bordered system of the conformal metric, by the Laplacian's `inner` solve."""
        return self.solver(inner, *self._take(system.conformal))


def _products(
    system: System, closure: Closure
) -> tuple[np.ndarray, sparse.csr_array, sparse.csr_array, sparse.csr_array]:
    """Factors of B and D, on the faces at holes' loops only.

    Returns these faces, T^T, M and T; errors are numbered 3 t + k over these faces.
    """
    topology: Topology = system.topology
    at_loop = np.zeros(topology.n, dtype=bool)
    at_loop[closure.vertex] = True
    faces = np.flatnonzero(at_loop[topology.corner].any(axis=0))
    corner, cot = topology.corner[:, faces], system.cot[:, faces]
    m = len(faces)
    error = (3 * np.arange(m) + np.arange(3)[:, None]).ravel()
    # vertex row of the corner's own vertex; wheel rows of those whose left or right angle it is
    column = np.concatenate((2 * corner, 2 * corner[PREV] + 1, 2 * corner[NEXT] + 1)).ravel()
    value = np.concatenate((np.ones_like(cot), cot, -cot)).ravel()
    single = sparse.csr_array((value, (np.tile(error, 3), column)), shape=(3 * m, 2 * topology.n))
    v, j, q = closure.vertex, closure.hole, closure.q
    weights = sparse.csr_array(
        (
            np.concatenate((q.imag, -q.real, -q.real, -q.imag)),
            (
                np.concatenate((2 * v, 2 * v, 2 * v + 1, 2 * v + 1)),
                np.concatenate((2 * j, 2 * j + 1, 2 * j, 2 * j + 1)),
            ),
        ),
        shape=(2 * topology.n, 2 * len(closure.gap)),
    )
    transposed = (single @ weights).tocsr()
    row_of = system.constraints.row
    inside = np.flatnonzero(row_of >= 0)
    pair = np.concatenate((2 * inside, 2 * inside + 1))
    row = np.concatenate((2 * row_of[inside], 2 * row_of[inside] + 1))
    merge = sparse.csr_array(
        (np.ones(len(pair)), (row, pair)), shape=(2 * system.constraints.n, 2 * topology.n)
    )
    return faces, transposed, (merge @ single.T).tocsr(), transposed.T.tocsr()
