"""Conjugate gradients."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .._types import FloatArray

MAX_CG_STEPS = 300  # after so many a factorisation is the better way

Product = Callable[[FloatArray], FloatArray]


def conjugate_gradients(
    product: Product, b: FloatArray, precondition: Product, rtol: float, most: int = MAX_CG_STEPS
) -> tuple[FloatArray, int, bool]:
    """Solve A x = b to |A x - b| <= rtol |b|; returns x, the steps taken and whether it got there.

    The scalar products are NumPy's own. Those of a BLAS wake its threads, which costs more than they save.
    """
    x, r, d = np.zeros_like(b), b.copy(), np.zeros_like(b)
    enough, last = rtol * np.sqrt(_dot(b, b)), 1.0
    for step in range(most + 1):
        if not np.sqrt(_dot(r, r)) > enough:
            return x, step, bool(np.isfinite(x).all())
        if step == most:
            break
        z = precondition(r)
        rho = _dot(r, z)
        d *= rho / last
        d += z
        q = product(d)
        along = rho / _dot(d, q)
        x += along * d
        r -= along * q
        last = rho
    return x, most, False


def _dot(a: FloatArray, b: FloatArray) -> float:
    return float(np.einsum("i,i->", a, b))
