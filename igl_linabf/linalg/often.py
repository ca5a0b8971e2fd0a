"""A pattern that is factored often, and solved with once each time: what takes least time for that."""

from __future__ import annotations

from functools import cache

from scipy import sparse

from .choice import Solvers, blas_of_cholmod
from .factors import Analysis, Cholmod

SUPERNODAL_FROM = 10_000  # rows: with a good BLAS a supernodal factor takes a third of the time


def factored_often(lower: sparse.csc_array) -> Analysis:
    """The analysis of a scalar Laplacian, given by its lower triangle, that is factored often."""
    analysis = Solvers().laplacian(lower)
    if type(analysis) is Cholmod and lower.shape[0] > SUPERNODAL_FROM and _good_blas():
        return Cholmod(lower, simplicial_up_to=0)
    return analysis


@cache
def _good_blas() -> bool:
    blas = blas_of_cholmod()
    return blas is not None and "reference" not in blas
