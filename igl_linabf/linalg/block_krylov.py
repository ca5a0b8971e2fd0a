"""Conjugate gradients for many systems side by side: the iterates are those of separate runs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .._types import BoolArray, FloatArray, IntArray
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
    x, r, p = np.zeros_like(b), b.copy(), np.zeros_like(b)
    steps = np.zeros(len(blocks), dtype=np.int64)
    goal = rtol * np.sqrt(blocks.sum(b * b))
    rho_before = np.ones(len(blocks))
    converged = goal == 0
    for _ in range(most):
        size = np.sqrt(blocks.sum(r * r))
        converged |= size < goal
        going = ~converged & np.isfinite(size)
        if not going.any():
            break
        z = precondition(r)
        rho = blocks.sum(r * z)
        with np.errstate(divide="ignore", invalid="ignore"):
            # a block that is there does not move any more
            p = z + blocks.spread(np.where(going, rho / rho_before, 0.0)) * p
            q = product(p)
            length = blocks.spread(np.where(going, rho / blocks.sum(p * q), 0.0))
        x += length * p
        r -= length * q
        rho_before = rho
        steps += going
    return x, steps, converged & blocks.min(np.isfinite(x)).astype(bool)
