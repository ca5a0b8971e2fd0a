"""The preconditioner of the reduced system: a scalar Laplacian, closing rows, a local correction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy import sparse

from .._runtime import unfilled
from .._types import FloatArray, IntArray, Solve
from ..linalg import Analysis, Factored, Rows, Solvers, Symmetric
from .across import Across, by_pairs
from .closure import ClosingRows
from .reduced import System


def laplacian_inverse(
    system: System, laplacian: Analysis, lower: sparse.csc_array, *, rough: bool = False
) -> Factored:
    """diag(L_s+, L_s)^-1 of (#rows, 2 k): k right-hand sides of vertex rows, then k of wheel rows.

    L_s+ is over all rows, L_s over those with a wheel constraint. Where each row has one, the two are one.
    Else L_s has the identity on the others, so that the pattern and its `laplacian` analysis serve both.
    With `rough`, factors may be in single precision.
    """
    vertex = laplacian.preconditioner(lower, rough=rough)
    if system.constraints.wheels == system.constraints.n:
        return vertex
    wheel = laplacian.preconditioner(system.wheel_laplacian(lower), rough=rough)

    def both(pairs: FloatArray) -> FloatArray:
        k = pairs.shape[1] // 2
        return np.hstack((vertex.solve(pairs[:, :k]), wheel.solve(pairs[:, k:])))

    names = dict.fromkeys((vertex.name, wheel.name))
    return Factored(", ".join(names), vertex.exact and wheel.exact, both, vertex.single or wheel.single)


def conformal_inverse(
    system: System,
    closing: ClosingRows | None,
    inverse: Solve,
    S: Symmetric | None = None,
    known: Across | None = None,
) -> tuple[Solve, Across | None]:
    """diag(L_s+, L_s)^-1 from `laplacian_inverse`; with closing rows, that of the bordered system.

    With `S` these have the paper's metric, and else that of K alone. Also returns the border's columns, which
    may be `known` of an earlier system.
    """
    if closing is None:
        return partial(by_pairs, inverse), None
    return closing.preconditioner(system, inverse, None if S is None else S.matvec, known)


@dataclass(frozen=True, eq=False)
class SliverRows:
    """The rows at slivers, where P_t and s_t K_t differ a lot, and the analysis of their small system.

    Attributes
    ----------
    index : (#s,) int64
    rows : Rows or None
        These rows of S; None if there are no slivers.
    analysis : Analysis or None
    """

    index: IntArray
    rows: Rows | None
    analysis: Analysis | None

    @classmethod
    def of(cls, system: System, S: Symmetric, solvers: Solvers) -> SliverRows:
        rows = system.sliver_rows()
        index = np.sort(np.concatenate((2 * rows, 2 * rows + 1)))
        if not len(index):
            return cls(index, None, None)
        own = Rows(S, index)
        return cls(index, own, solvers.whole(own.lower(S)))


def corrected(conformal: Solve, slivers: SliverRows, S: Symmetric, closing: ClosingRows | None) -> Solve:
    """The `conformal` preconditioner with S^-1 on the rows of slivers before and after it (Schwarz)."""
    index = slivers.index
    if slivers.rows is None or slivers.analysis is None:
        return conformal
    beside = slivers.rows.of(S)  # S is symmetric: its columns as well
    local = slivers.analysis.factor(slivers.rows.lower(S)).solve
    if closing is not None:
        beside = sparse.hstack((beside, closing.B.at(index))).tocsr()
    found = np.zeros(beside.shape[1], dtype=bool)
    found[beside.indices] = True
    touched, place = np.flatnonzero(found), np.cumsum(found) - 1
    at = place[beside.indices]
    beside = sparse.csr_array((beside.data, at, beside.indptr), shape=(len(index), len(touched)))
    below = beside.T

    def apply(r: FloatArray) -> FloatArray:
        first = local(r[index])
        left = unfilled(r.shape)
        left[:] = r
        left[touched] -= below @ first
        z = conformal(left)
        z[index] += first
        z[index] += local(r[index] - beside @ z[touched])
        return z

    return apply
