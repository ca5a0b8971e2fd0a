"""Conjugate gradients."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import linalg

from .._types import FloatArray

MAX_CG_STEPS = 300  # after so many a factorisation is the better way


def conjugate_gradients(
    A: Any,
    b: FloatArray,
    precondition: Callable[[FloatArray], FloatArray],
    rtol: float,
    most: int = MAX_CG_STEPS,
) -> tuple[FloatArray, int, bool]:
    """Solve A x = b to |A x - b| <= rtol |b|; returns x, the steps taken and whether it got there."""
    steps = 0

    def count(_: FloatArray) -> None:
        nonlocal steps
        steps += 1

    M = linalg.LinearOperator(A.shape, matvec=precondition, dtype=np.float64)
    x, info = linalg.cg(A, b, rtol=rtol, atol=0.0, maxiter=most, M=M, callback=count)
    return x, steps, info == 0 and bool(np.isfinite(x).all())
