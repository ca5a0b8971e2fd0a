"""Conjugate gradients for many systems side by side: the iterates are those of separate runs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .._types import BoolArray, FloatArray, IntArray
from ..kernels import block_axpy, block_dots
from ..surface import Parts

Product = Callable[[FloatArray], FloatArray]


def block_conjugate_gradients(
    product: Product, b: FloatArray, precondition: Product, blocks: Parts, rtol: float, most: int
) -> tuple[FloatArray, IntArray, BoolArray]:
    """Solve A x = b, A and its preconditioner block-diagonal, to |A x - b| <= rtol |b| in each block.

    Every block has step lengths of its own, and stops when it is there.

    Parameters
    ----------
    product, precondition : callable
        Of all blocks at once, (n,).
    b : (n,) float64
    blocks : Parts
        Of the rows.
    rtol : float
    most : int
        Steps at most.

    Returns
    -------
    x : (n,) float64
    steps : (#blocks,) int64
        Those that each block took.
    converged : (#blocks,) bool
    """
    x, r, p, start = np.zeros_like(b), b.copy(), np.zeros_like(b), blocks.start
    steps = np.zeros(len(blocks), dtype=np.int64)
    goal = rtol * np.sqrt(block_dots(start, b, b))
    rho_before = np.ones(len(blocks))
    converged = goal == 0
    for _ in range(most):
        size = np.sqrt(block_dots(start, r, r))
        converged |= size < goal
        going = ~converged & np.isfinite(size)
        if not going.any():
            break
        z = precondition(r)
        rho = block_dots(start, r, z)
        with np.errstate(divide="ignore", invalid="ignore"):
            # a block that is there does not move any more
            p = block_axpy(start, np.where(going, rho / rho_before, 0.0), p, z)
            q = product(p)
            length = np.where(going, rho / block_dots(start, p, q), 0.0)
        x = block_axpy(start, length, p, x)
        r = block_axpy(start, -length, q, r)
        rho_before = rho
        steps += going
    return x, steps, converged & blocks.min(np.isfinite(x)).astype(bool)
