"""The paper's full system (eq. 11-16), written out to be read beside it.

The angles are alpha + e. A disk is flat if its angles fulfil, at each interior vertex v and in
each triangle t, the errors e and the angles alpha summed over the corners of v or of t,

    sum e                          = 2 pi - sum alpha                           (eq. 5, vertex)
    e_1 + e_2 + e_3                = pi - (alpha_1 + alpha_2 + alpha_3)         (eq. 6, triangle)
    sum cot(b) e_b - cot(c) e_c    = sum log sin(c) - log sin(b)                (eq. 10, wheel)

b is the *left* angle of a corner of v's fan, c the *right* one. These are fewer equations A e = b
than angles. Of all solutions the paper takes the one of the least relative change (eq. 11-16).

What the package solves is the reduced system (`igl_linabf.angles.System`), which is much smaller. The
tests hold it against this one. In all matrices column 3 t + k is corner k of triangle t; arrays of
angles are (3, #F).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse

from ..linalg import Solvers
from ..surface import FloatArray, IntArray, Topology

OWN, LEFT, RIGHT = 0, 1, 2  # of corner k of a triangle: its angle, that at k + 1, that at k + 2


def fan_rows(topology: Topology, values: FloatArray, which: int) -> sparse.csr_array:
    """Rows that sum over the fan of each interior vertex, (#rows, 3 #F).

    Parameters
    ----------
    topology : Topology
        The mesh. The vertices of a hole share a row, which sums over all their fans.
    values : (3, #F) float64
        What the errors are multiplied with.
    which : int
        `OWN` sums over the vertex's own angles, `LEFT` over the left ones, `RIGHT` over the right ones.

    Returns
    -------
    (#rows, 3 #F) sparse array
    """
    row, target = _constraints(topology)
    k, t = np.nonzero(row >= 0)
    j = (k + which) % 3
    return sparse.csr_array((values[j, t], (row[k, t], 3 * t + j)), shape=(len(target), values.size))


def vertex_rows(topology: Topology) -> sparse.csr_array:
    """Left side of eq. 5: sum e around each interior vertex."""
    return fan_rows(topology, np.ones(topology.corner.shape), OWN)  # eq. 5


def wheel_rows(topology: Topology, alpha: FloatArray) -> sparse.csr_array:
    """Left side of eq. 10: sum cot(left) e_left - cot(right) e_right around each interior vertex."""
    cot = 1 / np.tan(alpha)
    return fan_rows(topology, cot, LEFT) - fan_rows(topology, cot, RIGHT)  # eq. 10


def triangle_rows(topology: Topology) -> sparse.csr_array:
    """Left side of eq. 6: e_1 + e_2 + e_3 in each triangle."""
    return sparse.kron(sparse.eye_array(topology.corner.shape[1]), np.ones((1, 3))).tocsr()  # eq. 6


def interior_rows(topology: Topology, alpha: FloatArray) -> sparse.csr_array:
    """Left sides of eq. 5 and 10, the vertex row and the wheel row of a vertex next to each other."""
    both = sparse.vstack((vertex_rows(topology), wheel_rows(topology, alpha))).tocsr()
    return both[np.arange(both.shape[0]).reshape(2, -1).T.ravel()]


def right_hand_sides(topology: Topology, alpha: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Right sides of the rows of `interior_rows` (eq. 5 and 10), and of `triangle_rows` (eq. 6)."""
    log_sin = np.log(np.sin(alpha))
    _, target = _constraints(topology)
    vertex = target - vertex_rows(topology) @ alpha.T.ravel()  # eq. 5
    wheel = fan_rows(topology, log_sin, RIGHT) - fan_rows(topology, log_sin, LEFT)  # eq. 10
    triangle = np.pi - alpha.sum(axis=0)  # eq. 6
    return np.column_stack((vertex, wheel.sum(axis=1))).ravel(), triangle


def least_norm(
    A: sparse.csr_array, alpha: FloatArray, solvers: Solvers
) -> Callable[[FloatArray], FloatArray]:
    """Minimise sum (e / alpha)^2 subject to A e = b, for any b.

    With C = A diag(alpha) and f = e / alpha that is the least norm solution of C f = b.

    Parameters
    ----------
    A : (n, 3 #F) sparse array
        Rows of full rank.
    alpha : (3, #F) float64
        The angles that the errors are relative to.
    solvers : Solvers
        Factors the system.

    Returns
    -------
    callable
        From b, (n,), to e, (3 #F,).

    Raises
    ------
    NotPositiveDefiniteError
        The rows are not of full rank in double precision.
    """
    scale = sparse.diags_array(alpha.T.ravel())
    C = A @ scale  # eq. 11-16
    lower = sparse.tril(C @ C.T).tocsc()
    factor = solvers.whole(lower)
    factor.factor(lower)

    def errors(b: FloatArray) -> FloatArray:
        x = factor.solve(b)  # eq. 16: (C C^T) x = b
        return np.asarray(scale @ (C.T @ x))  # f = C^T x, e = diag(alpha) f

    return errors


def full_step(topology: Topology, alpha: FloatArray) -> FloatArray:
    """One step of linear ABF, by the paper's full system.

    Parameters
    ----------
    topology : Topology
        The mesh.
    alpha : (3, #F) float64
        The angles at which the system is taken, radians.

    Returns
    -------
    (3, #F) float64
        The errors e. Exact but for rounding: the solution is refined once.
    """
    A = sparse.vstack((interior_rows(topology, alpha), triangle_rows(topology))).tocsr()
    b = np.concatenate(right_hand_sides(topology, alpha))
    errors = least_norm(A, alpha, Solvers("direct"))
    e = errors(b)
    e = e + errors(b - A @ e)
    return np.asarray(e.reshape(-1, 3).T)


def _constraints(topology: Topology) -> tuple[IntArray, FloatArray]:
    """The row of each corner's vertex, (3, #F), -1 where it has none; the angle sum that a row asks for."""
    return topology.row[topology.corner], topology.target
