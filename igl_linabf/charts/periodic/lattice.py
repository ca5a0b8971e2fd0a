"""Complex integers that are nearest to given numbers by a quadratic form: the closest vector problem."""

import numpy as np

from ..._types import ComplexArray, FloatArray, IntArray
from . import constants

NEIGHBOURHOOD = np.array([a + 1j * b for a in (-1, 0, 1) for b in (-1, 0, 1)])  # of 0 in the lattice


def nearest_whole(form: ComplexArray, wanted: ComplexArray) -> ComplexArray:
    """Complex integers q for which the Hermitian form of q - wanted is small.

    They are rounded one after another, each moved by how far those before it are off (Babai 1986). Those that
    cost most if they are off come first (Wolniansky et al. 1998). The best partial choices are kept: a beam
    search.

    Parameters
    ----------
    form : (n, n) complex128
        Hermitian, positive definite.
    wanted : (n,) complex128
    """
    order = _weakest_first(form)
    upper = np.linalg.cholesky(form[np.ix_(order, order)]).conj().T
    aim = wanted[order]
    chosen, cost = np.zeros((1, len(aim)), dtype=np.complex128), np.zeros(1)
    for j in reversed(range(len(aim))):
        best = aim[j] - (chosen[:, j + 1 :] - aim[j + 1 :]) @ upper[j, j + 1 :] / upper[j, j]
        tried = np.round(best)[:, None] + NEIGHBOURHOOD
        costs: FloatArray = cost[:, None] + np.abs(upper[j, j] * (tried - best[:, None])) ** 2
        kept = np.argsort(costs, axis=None, kind="stable")[: constants.BEAM_WIDTH]
        chosen, cost = chosen[kept // len(NEIGHBOURHOOD)], costs.ravel()[kept]
        chosen[:, j] = tried.ravel()[kept]
    q = np.empty_like(wanted)
    q[order] = chosen[0]
    return q


def _weakest_first(form: ComplexArray) -> IntArray:
    """An order whose last one costs most if it is off, at the best of the others; then the one before it."""
    inverse = np.linalg.inv(form)
    left = np.ones(len(form), dtype=bool)
    order = np.empty(len(form), dtype=np.int64)
    for k in reversed(range(len(form))):
        j = int(np.argmin(np.where(left, inverse.diagonal().real, np.inf)))
        order[k], left[j] = j, False
        inverse = inverse - np.outer(inverse[:, j], inverse[j]) / inverse[j, j]
    return order
