"""Whole numbers near given ones, where some combinations of differences matter more than others."""

import numpy as np

from ..._types import ComplexArray, FloatArray, IntArray
from . import constants

NEAR = np.array([a + 1j * b for a in (-1, 0, 1) for b in (-1, 0, 1)])


def nearest_whole(form: ComplexArray, wanted: ComplexArray) -> ComplexArray:
    """Complex integers q near `wanted` for which the Hermitian form of q - wanted is small.

    They are chosen one after another, with regard to what is missing to those before (Babai 1986). Those on
    which most depends come first (Wolniansky et al. 1998), and the best partial choices are kept on the way.

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
        tried = np.round(best)[:, None] + NEAR
        costs: FloatArray = cost[:, None] + np.abs(upper[j, j] * (tried - best[:, None])) ** 2
        kept = np.argsort(costs, axis=None, kind="stable")[: constants.BEAM_WIDTH]
        chosen, cost = chosen[kept // len(NEAR)], costs.ravel()[kept]
        chosen[:, j] = tried.ravel()[kept]
    q = np.empty_like(wanted)
    q[order] = chosen[0]
    return q


def _weakest_first(form: ComplexArray) -> IntArray:
    """An order whose last one costs most if it is off, however the others fit it; then the one before."""
    inverse = np.linalg.inv(form)
    left = np.ones(len(form), dtype=bool)
    order = np.empty(len(form), dtype=np.int64)
    for k in reversed(range(len(form))):
        j = int(np.argmin(np.where(left, inverse.diagonal().real, np.inf)))
        order[k], left[j] = j, False
        inverse = inverse - np.outer(inverse[:, j], inverse[j]) / inverse[j, j]
    return order
