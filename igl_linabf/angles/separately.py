"""The linear step and its chord for disks side by side: one system, each disk with an end of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._runtime import timed
from .._types import BoolArray, FloatArray, IntArray
from ..linalg import Multigrid, block_conjugate_gradients
from ..surface import Disks, Parts
from .linearised import AngleProblem, Iterate, Linearised, cut_short, errors, linearise, right_side

MOST_STEPS = 60  # of conjugate gradients; a disk that takes more is no longer held up for


@dataclass(frozen=True, eq=False)
class Separate:
    """Where the angles of disks side by side ended.

    Attributes
    ----------
    at : Iterate
        All of them.
    lin : Linearised or None
        The system; None where all were flat from the start.
    stepped : (#disks,) bool
        Whose angles were not flat from the start.
    good : (#disks,) bool
        Whose two solves came to an end with no triangle cut short.
    inner_steps : (2, #disks) int64
        Of the step and of the chord.
    residual : (3, #disks) float64
        The largest of each disk at the start, after the step, and after the chord.
    """

    at: Iterate
    lin: Linearised | None
    stepped: BoolArray
    good: BoolArray
    inner_steps: IntArray
    residual: FloatArray


def step_and_chord(problem: AngleProblem, disks: Disks, rtol: float, tol: float) -> Separate | None:
    """The linear step and its chord for each disk whose residual is above `tol`.

    None where the preconditioner is no exact inverse, and one disk's iterates depend on the others.

    Raises
    ------
    NotPositiveDefiniteError, SingularSystemError
        The system of one of the disks is singular in double precision.
    """
    rows = rows_of(problem, disks)
    at, lin = problem.start, None
    residual = [largest_of(at, rows, disks.faces)]
    stepped = residual[0] > tol
    good = ~stepped | (rows.sizes > 0)
    inner_steps = np.zeros((2, len(disks)), dtype=np.int64)
    if (stepped & good).any():
        lin = linearise(problem, at, fall_back=False)
        if isinstance(lin.laplacian, Multigrid):
            return None
        for k in range(2):
            e, inner_steps[k], converged = _errors(lin, at, rows, rtol)
            with timed("assembly"):
                e, cut = cut_short(at.alpha, e * disks.faces.spread(np.where(stepped, 1.0, 0.0)))
                good &= ~stepped | (converged & ~disks.faces.any(cut))
                at = problem.at(at.alpha + e)
            residual.append(largest_of(at, rows, disks.faces))
    residual += residual[-1:] * (3 - len(residual))
    return Separate(at, lin, stepped, good, inner_steps, np.array(residual))


def rows_of(problem: AngleProblem, disks: Disks) -> Parts:
    """The rows of each disk: those of its interior vertices, which come in their order."""
    before = np.concatenate(([0], np.cumsum(disks.topology.interior)))
    assert before[-1] == problem.constraints.n
    return Parts(before[disks.vertices.start])


def families_of(at: Iterate, rows: Parts, faces: Parts) -> FloatArray:
    """The largest absolute residual of each disk: of its vertices, triangles and wheels, (3, #disks)."""
    b = at.residual
    return np.stack((rows.max(np.abs(b.vertex)), faces.max(np.abs(b.triangle)), rows.max(np.abs(b.wheel))))


def largest_of(at: Iterate, rows: Parts, faces: Parts) -> FloatArray:
    """The largest absolute residual of each disk."""
    return np.asarray(families_of(at, rows, faces).max(axis=0))


def _errors(lin: Linearised, at: Iterate, rows: Parts, rtol: float) -> tuple[FloatArray, IntArray, BoolArray]:
    """The errors that the linearised constraints ask for, the inner steps, and who converged."""
    with timed("assembly"):
        e0, rhs = right_side(lin, at)
    with timed("solve"):
        if lin.whole is not None:
            x = lin.whole.solve(rhs)
            steps, converged = np.zeros(len(rows), dtype=np.int64), rows.min(np.isfinite(x[::2]))
        else:
            assert lin.precondition is not None
            x, steps, converged = block_conjugate_gradients(
                lin.product, rhs, lin.precondition, Parts(2 * rows.start), rtol, MOST_STEPS
            )
    with timed("assembly"):
        return errors(lin, e0, x), steps, converged
