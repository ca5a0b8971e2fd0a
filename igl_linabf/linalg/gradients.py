"""Conjugate gradients, for any number of systems side by side."""

import numpy as np

from .._core import block_dots, block_step, block_turn
from .._types import BoolArray, FloatArray, IntArray, Solve
from .constants import MAX_CG_STEPS


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
    """Solve A x = b, A and its preconditioner block-diagonal, to |A x - b| <= rtol |b| in each block.

    Each block has step lengths of its own, and takes no more steps once it has converged: its iterates are
    those of a system by itself. The scalar products are not a BLAS's: to wake its threads costs more than
    they save.

    Parameters
    ----------
    product, precondition : callable
        Of all blocks at once, (n,).
    b : (n,) float64
    rtol : float
    most : int
        Steps at most.
    first_rtol : float, optional
        Relative residual that is enough after a single step.
    start : (#blocks + 1,) int64, optional
        Where each block begins, and the last one ends; by default there is one block.

    Returns
    -------
    x : (n,) float64
    steps : (#blocks,) int64
        Those that each block took.
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
        block_turn(start, rho, last, z, p)
        square = block_step(start, rho, p, product(p), x, r)
        last = rho
        steps += going
    return x, steps, ~going & np.isfinite(square) & np.isfinite(block_dots(start, x, x))
