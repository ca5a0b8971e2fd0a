"""Conjugate gradients: for one system, or for many side by side, with the iterates of separate runs."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import kernels
from .._runtime import unfilled
from .._types import BoolArray, FloatArray, IntArray, Solve

MAX_CG_STEPS = 300  # after so many a factorisation is the better way


def conjugate_gradients(
    product: Solve,
    b: FloatArray,
    precondition: Solve,
    rtol: float,
    most: int = MAX_CG_STEPS,
    *,
    first_rtol: float | None = None,
) -> tuple[FloatArray, int, bool]:
    """Solve A x = b to |A x - b| <= rtol |b|; returns x, the steps taken and whether it got there.

    A single step is enough to `first_rtol`, if that is given. The scalar products are not those of a BLAS,
    which wake its threads: that costs more than they save.
    """
    x, r, d = (unfilled(b.shape) for _ in range(3))
    x[:], r[:], d[:] = 0.0, b, 0.0
    square, last = kernels.dot(b, b), 1.0
    size = np.sqrt(square)
    for step in range(most + 1):
        wanted = rtol if first_rtol is None or step != 1 else first_rtol
        if not np.sqrt(square) > wanted * size:
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


def block_conjugate_gradients(
    product: Solve,
    b: FloatArray,
    precondition: Solve,
    blocks: Any,
    rtol: float,
    most: int,
    *,
    first_rtol: float | None = None,
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
    first_rtol : float, optional
        To which a single step is enough.

    Returns
    -------
    x : (n,) float64
    steps : (#blocks,) int64
        Those that each block took.
    converged : (#blocks,) bool
    """
    x, r, p, start = np.zeros_like(b), b.copy(), np.zeros_like(b), blocks.start
    steps = np.zeros(len(blocks), dtype=np.int64)
    whole = np.sqrt(kernels.block_dots(start, b, b))
    rho_before = np.ones(len(blocks))
    converged = whole == 0
    for step in range(most):
        size = np.sqrt(kernels.block_dots(start, r, r))
        converged |= size < (rtol if first_rtol is None or step != 1 else first_rtol) * whole
        going = ~converged & np.isfinite(size)
        if not going.any():
            break
        z = precondition(r)
        rho = kernels.block_dots(start, r, z)
        with np.errstate(divide="ignore", invalid="ignore"):
            # a block that is there does not move any more
            p = kernels.block_axpy(start, np.where(going, rho / rho_before, 0.0), p, z)
            q = product(p)
            length = np.where(going, rho / kernels.block_dots(start, p, q), 0.0)
        x = kernels.block_axpy(start, length, p, x)
        r = kernels.block_axpy(start, -length, q, r)
        rho_before = rho
        steps += going
    return x, steps, converged & blocks.min(np.isfinite(x)).astype(bool)
