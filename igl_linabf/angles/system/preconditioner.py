"""The preconditioner of the reduced system: a scalar Laplacian, closing rows, a local correction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy import sparse

from ..._types import FloatArray, Solve
from ...linalg import Analysis, Factor, Solvers
from .holonomy import HolonomyConstraints
from .patterns import Rows, Symmetric, by_pairs
from .reduced_system import System
from .schur_columns import SchurColumns


def laplacian_inverse(system: System, laplacian: Analysis, lower: sparse.csc_array) -> Factor:
    """diag(L_s+, L_s)^-1 of (#rows, 2 k): k right-hand sides of vertex rows, then k of wheel rows.

    L_s+ is over all rows, L_s over those with a wheel constraint. Where each row has one, the two are one.
    Else L_s has the identity on the others, so that the pattern and its `laplacian` analysis serve both.
    """
    vertex = laplacian.factor(lower.data)
    if system.constraints.wheels == system.constraints.n:
        return vertex
    wheel = laplacian.factor(system.wheel_laplacian(lower).data)

    def both(pairs: FloatArray) -> FloatArray:
        k = pairs.shape[1] // 2
        return np.hstack((vertex.solve(pairs[:, :k]), wheel.solve(pairs[:, k:])))

    return Factor(vertex.name, both)


def conformal_inverse(
    system: System,
    holonomy: HolonomyConstraints | None,
    inverse: Solve,
    S: Symmetric | None = None,
    known: SchurColumns | None = None,
) -> tuple[Solve, SchurColumns | None]:
    """diag(L_s+, L_s)^-1 from `laplacian_inverse`; with closing rows, that of the bordered system.

    With `S` these have the paper's metric, and else that of K alone. Also returns the border's columns, which
    may be `known` of an earlier system.
    """
    if holonomy is None:
        return partial(by_pairs, inverse), None
    return holonomy.preconditioner(system, inverse, S, known)


@dataclass(frozen=True, eq=False)
class SliverRows:
    """The rows at slivers, where P_t and s_t K_t differ a lot, and the analysis of their small system.

    Attributes
    ----------
    rows : Rows or None
        These rows of S; None if there are no slivers.
    analysis : Analysis or None
    """

    rows: Rows | None = None
    analysis: Analysis | None = None

    @classmethod
    def of(cls, system: System, S: Symmetric, solvers: Solvers) -> SliverRows:
        pairs = system.sliver_rows()
        if not len(pairs):
            return cls()
        rows = Rows(S, pairs)
        return cls(rows, solvers.analyse(rows.indptr, rows.indices, 2))


def corrected(
    conformal: Solve, slivers: SliverRows, S: Symmetric, holonomy: HolonomyConstraints | None
) -> Solve:
    """The `conformal` preconditioner with S^-1 on the rows of slivers before and after it (Schwarz)."""
    if slivers.rows is None or slivers.analysis is None:
        return conformal
    beside, pairs = slivers.rows.of(S), slivers.rows.pairs  # S is symmetric: its columns as well
    local = slivers.analysis.factor(beside.values()).solve
    index, n = (2 * pairs[:, None] + np.arange(2)).ravel(), S.size
    border = None if holonomy is None else holonomy.B.at(index)

    def apply(r: FloatArray) -> FloatArray:
        first = local(r[index])
        left = beside.taken_off(first, r)
        if border is not None:
            left[n:] -= border.T @ first
        z = conformal(left)
        z[index] += first
        rest = beside.left(r, z)
        if border is not None:
            rest -= border @ z[n:]
        z[index] += local(rest)
        return z

    return apply
