"""Solve the closest vector problem: find complex integers nearest to given numbers under a quadratic form."""

import numpy as np

from ..._types import ComplexArray, FloatArray, IntArray

BEAM_WIDTH = 256  # number of partial solutions that the beam search keeps

# The complex integer 0 and the 8 complex integers around it.
NEIGHBOURHOOD = np.array([a + 1j * b for a in (-1, 0, 1) for b in (-1, 0, 1)])


def find_nearest_integers(form: ComplexArray, wanted: ComplexArray) -> ComplexArray:
    """Return Gaussian integers `q` that make the Hermitian form small at the vector `q - wanted`.

    The numbers are rounded one after another. Each is corrected beforehand for the rounding errors of the
    previous numbers (Babai 1986). The numbers whose errors cost most are rounded first (Wolniansky et al.
    1998). A beam search keeps the best partial solutions.

    Parameters
    ----------
    form : (n, n) complex128
        Hermitian, positive definite.
    wanted : (n,) complex128
    """
    order = _order_by_cost(form)
    upper = np.linalg.cholesky(form[np.ix_(order, order)]).conj().T
    aim = wanted[order]
    chosen, cost = np.zeros((1, len(aim)), dtype=np.complex128), np.zeros(1)
    for j in reversed(range(len(aim))):
        best = aim[j] - (chosen[:, j + 1 :] - aim[j + 1 :]) @ upper[j, j + 1 :] / upper[j, j]
        tried = np.round(best)[:, None] + NEIGHBOURHOOD
        costs: FloatArray = cost[:, None] + np.abs(upper[j, j] * (tried - best[:, None])) ** 2
        kept = np.argsort(costs, axis=None, kind="stable")[:BEAM_WIDTH]
        chosen, cost = chosen[kept // len(NEIGHBOURHOOD)], costs.ravel()[kept]
        chosen[:, j] = tried.ravel()[kept]
    q = np.empty_like(wanted)
    q[order] = chosen[0]
    return q


def _order_by_cost(form: ComplexArray) -> IntArray:
    """Return an order of the numbers by the cost of their rounding errors, ascending.

    The cost of a number's error is the least value of the form over all errors of the numbers before it.
    """
    inverse = np.linalg.inv(form)
    left = np.ones(len(form), dtype=bool)
    order = np.empty(len(form), dtype=np.int64)
    for k in reversed(range(len(form))):
        j = int(np.argmin(np.where(left, inverse.diagonal().real, np.inf)))
        order[k], left[j] = j, False
        inverse = inverse - np.outer(inverse[:, j], inverse[j]) / inverse[j, j]
    return order
