"""Conjugate gradients."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .. import kernels
from .._types import FloatArray

MAX_CG_STEPS = 300  # after so many a factorisation is the better way

Product = Callable[[FloatArray], FloatArray]


def conjugate_gradients(
    product: Product, b: FloatArray, precondition: Product, rtol: float, most: int = MAX_CG_STEPS
) -> tuple[FloatArray, int, bool]:
    """Solve A x = b to |A x - b| <= rtol |b|; returns x, the steps taken and whether it got there.

    The scalar products are not those of a BLAS, which wake its threads: that costs more than they save.
    """
    x, r, d = np.zeros_like(b), b.copy(), np.zeros_like(b)
    square, last = kernels.dot(b, b), 1.0
    enough = rtol * np.sqrt(square)
    for step in range(most + 1):
        if not np.sqrt(square) > enough:
            return x, step, bool(np.isfinite(x).all())
        if step == most:
            break
        z = precondition(r)
        rho = kernels.dot(r, z)
        kernels.turn(d, rho / last, z)
        q = product(d)
        square = kernels.move(x, r, rho / kernels.dot(d, q), d, q)
        last = rho
    return x, most, False
