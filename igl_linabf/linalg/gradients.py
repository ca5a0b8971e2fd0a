"""Preconditioned conjugate gradients for one or more independent systems."""

import numpy as np

from .._core import block_dots, cg_step, update_cg_direction
from .._types import BoolArray, FloatArray, IntArray, Solve

MAX_CG_STEPS = 300  # after this many steps, give up conjugate gradients and factor the matrix


def conjugate_gradients(
    product: Solve,
    b: FloatArray,
    precondition: Solve,
    rtol: float,
    most: int = MAX_CG_STEPS,
    *,
    first_rtol: float | None = None,
    start: IntArray | None = None,
) -> tuple[FloatArray, IntArray, BoolArray]:
    """Solve A x = b to |A x - b| <= rtol |b| in each block of a block-diagonal system.

    A and its preconditioner have the same blocks. Each block has its own step lengths and stops when it has
    converged. Therefore, its iterates equal those of the block as a separate system. The scalar products
    avoid BLAS, because starting the threads of BLAS takes longer than they save.

    Parameters
    ----------
    product, precondition : callable
        Apply A, or the preconditioner, to a vector (n,) that contains all blocks.
    b : (n,) float64
    rtol : float
        Largest relative residual of a converged block.
    most : int
        Maximum number of steps.
    first_rtol : float, optional
        Maximum relative residual for a block to stop after the first step; `rtol` by default.
    start : (#blocks + 1,) int64, optional
        First row of each block, followed by n; by default there is a single block.

    Returns
    -------
    x : (n,) float64
    steps : (#blocks,) int64
        Number of steps of each block.
    converged : (#blocks,) bool
    """
    start = np.array([0, len(b)]) if start is None else start
    x, r, p = np.zeros(len(b)), np.array(b, dtype=np.float64), np.zeros(len(b))
    steps, last = np.zeros(len(start) - 1, dtype=np.int64), np.zeros(len(start) - 1)
    square = block_dots(start, r, r)
    size, going = np.sqrt(square), square > 0
    for step in range(most + 1):
        left, wanted = np.sqrt(square), rtol if first_rtol is None or step != 1 else first_rtol
        going &= (left > wanted * size) & (left < np.inf)
        if step == most or not going.any():
            break
        z = precondition(r)
        rho = np.where(going, block_dots(start, r, z), 0.0)
        update_cg_direction(start, rho, last, z, p)
        square = cg_step(start, rho, p, product(p), x, r)
        last = rho
        steps += going
    return x, steps, ~going & np.isfinite(square) & np.isfinite(block_dots(start, x, x))
