"""The full linear system of the paper (eq. 11-16), in the paper's own form.

Let alpha be the current angles and alpha + e the angles of a flat mesh. At each corner in the fan of an
interior vertex, the triangle has a *left* angle beta and a *right* angle gamma. The errors e satisfy

    sum e                                      =  2 pi - sum alpha                      vertex (eq. 5)
    e_1 + e_2 + e_3                            =  pi - (alpha_1 + alpha_2 + alpha_3)    triangle (eq. 6)
    sum e_beta cot(beta) - e_gamma cot(gamma)  =  sum log sin(gamma) - log sin(beta)    wheel (eq. 10)

The sums run over the fan. The system A e = b has fewer equations than angles. The paper takes the solution
with the least relative change e / alpha (eq. 11-16).

The package solves an equivalent smaller system, `igl_linabf.angles.System`, and the tests compare the two. In
the matrices of this module, column 3 t + k is corner k of triangle t. Arrays of angles are (3, #F).
"""

from collections.abc import Callable
from enum import IntEnum

import numpy as np
from scipy import sparse

from .._types import FloatArray, IntArray
from ..linalg import Solvers
from .system import Constraints


class Corner(IntEnum):
    """The three corners of a triangle, as index offsets from its corner at the centre of a fan."""

    OWN = 0  # the angle alpha at the centre of the fan
    LEFT = 1  # the left angle beta
    RIGHT = 2  # the right angle gamma


def build_fan_rows(
    constraints: Constraints, values: FloatArray, which: Corner, most: int | None = None
) -> sparse.csr_array:
    """Build a matrix with one row for each interior vertex, which sums over the fan of the vertex.

    Parameters
    ----------
    constraints : Constraints
        Constraints of the mesh. The vertices of a hole share one row, which sums over all their fans.
    values : (3, #F) float64
        Coefficients of the errors.
    which : Corner
        The angle of each corner in the fan that is summed.
    most : int, optional
        Number of rows to build; all by default.

    Returns
    -------
    (#rows, 3 #F) sparse array
    """
    row = constraints.row[constraints.topology.corner]
    most = constraints.n_rows if most is None else most
    k, t = np.nonzero((row >= 0) & (row < most))
    j = (k + which) % 3
    return sparse.csr_array((values[j, t], (row[k, t], 3 * t + j)), shape=(most, values.size))


def vertex_rows(constraints: Constraints) -> sparse.csr_array:
    """Return the matrix of eq. 5, (#rows, 3 #F). Each row sums the angle errors at one vertex."""
    return build_fan_rows(constraints, np.ones(constraints.topology.corner.shape), Corner.OWN)


def wheel_rows(constraints: Constraints, alpha: FloatArray) -> sparse.csr_array:
    """Return the left-hand side of eq. 8-10, (#wheels, 3 #F): sum e_beta cot(beta) - e_gamma cot(gamma)."""
    cot, n = 1 / np.tan(alpha), constraints.wheels
    left, right = (build_fan_rows(constraints, cot, which, n) for which in (Corner.LEFT, Corner.RIGHT))
    return left - right


def triangle_rows(constraints: Constraints) -> sparse.csr_array:
    """Return the left-hand side of eq. 6, (#F, 3 #F): e_1 + e_2 + e_3."""
    each = sparse.eye_array(constraints.topology.corner.shape[1])
    return sparse.kron(each, np.ones((1, 3))).tocsr()


def build_interior_rows(constraints: Constraints, alpha: FloatArray) -> sparse.csr_array:
    """Return the left-hand sides of eq. 5 and 10, (#rows + #wheels, 3 #F).

    The two rows of a vertex are adjacent.
    """
    both = sparse.vstack((vertex_rows(constraints), wheel_rows(constraints, alpha))).tocsr()
    return both[_interleave_rows(constraints)]


def _interleave_rows(constraints: Constraints) -> IntArray:
    """Return the permutation of vertex rows and wheel rows that makes the two rows of a vertex adjacent."""
    rows, wheels = np.arange(constraints.n_rows), np.arange(constraints.wheels)
    return np.argsort(np.concatenate((2 * rows, 2 * wheels + 1)))


def compute_right_hand_sides(constraints: Constraints, alpha: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the right-hand sides of `build_interior_rows` (eq. 5, 10) and `triangle_rows`, (#F,) (eq. 6)."""
    log_sin = np.log(np.sin(alpha))
    vertex = constraints.target - vertex_rows(constraints) @ alpha.T.ravel()  # right-hand side of eq. 5
    n = constraints.wheels
    left, right = (build_fan_rows(constraints, log_sin, which, n) for which in (Corner.LEFT, Corner.RIGHT))
    wheel = right - left  # right-hand side of eq. 10
    triangle = np.pi - alpha.sum(axis=0)  # right-hand side of eq. 6
    return np.concatenate((vertex, wheel.sum(axis=1)))[_interleave_rows(constraints)], triangle


def least_norm(
    A: sparse.csr_array, alpha: FloatArray, solvers: Solvers
) -> Callable[[FloatArray], FloatArray]:
    """Return a solver that minimises sum (e / alpha)^2 subject to A e = b, for any b.

    With C = A diag(alpha) and f = e / alpha, this is the least-norm solution of C f = b.

    Parameters
    ----------
    A : (n, 3 #F) sparse array
        Rows of full rank.
    alpha : (3, #F) float64
        The reference angles of the relative errors.
    solvers : Solvers
        Factors the matrix C C^T.

    Returns
    -------
    callable
        Maps b, (n,), to e, (3 #F,).

    Raises
    ------
    NotPositiveDefiniteError
        The rows do not have full rank in double precision.
    """
    scale = sparse.diags_array(alpha.T.ravel())
    C = A @ scale  # relative errors as unknowns, eq. 11-16
    lower = sparse.tril(C @ C.T).tocsc()
    factored = solvers.factor(lower)

    def compute_errors(b: FloatArray) -> FloatArray:
        x = factored.solve(b)  # eq. 16: (C C^T) x = b
        return np.asarray(scale @ (C.T @ x))  # f = C^T x, e = diag(alpha) f

    return compute_errors


def take_full_system_step(constraints: Constraints, alpha: FloatArray) -> FloatArray:
    """Compute one step of linear ABF with the full system.

    Parameters
    ----------
    constraints : Constraints
    alpha : (3, #F) float64
        The angles of the linearisation, radians.

    Returns
    -------
    (3, #F) float64
        The errors e, exact up to rounding: the solution is refined once.
    """
    A = sparse.vstack((build_interior_rows(constraints, alpha), triangle_rows(constraints))).tocsr()
    b = np.concatenate(compute_right_hand_sides(constraints, alpha))
    errors = least_norm(A, alpha, Solvers("direct"))
    e = errors(b)
    e = e + errors(b - A @ e)
    return np.asarray(e.reshape(-1, 3).T)
