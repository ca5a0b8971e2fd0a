"""The preconditioner of the reduced system: a Laplacian with a border, and a correction at slivers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ... import _core
from ..._types import FloatArray, Solve
from ...linalg import Analysis, Factor, Solvers
from .holonomy import HolonomyConstraints
from .patterns import RowSubset, Symmetric, replace_rows_by_identity
from .reduced_system import System

MIN_SLIVER_RATIO = 10.0  # triangle t is a sliver from this eigenvalue ratio of P_t and s_t K_t
# Replaces MIN_SLIVER_RATIO in small systems, where inner steps are cheap.
MIN_SLIVER_RATIO_OF_SMALL_SYSTEM = 1000.0
LARGE_SYSTEM = 5_000  # minimum number of rows per disk of a large system


def factor_laplacians(system: System, laplacian: Analysis, lower: sparse.csc_array) -> Factor:
    """Return a solver of diag(L_s+, L_s) for right-hand sides, (#rows, 2 k).

    The first k right-hand sides belong to vertex constraints, the last k to wheel constraints. L_s+ covers
    all rows, and L_s only the rows with a wheel constraint. If every row has a wheel constraint, L_s+ equals
    L_s. Otherwise, L_s contains the identity for the other rows. Therefore, it has the pattern of L_s+, which
    `laplacian` has analysed.
    """
    vertex = laplacian.factor(lower.data)
    if system.constraints.wheels == system.constraints.n_rows:
        return vertex
    wheel = laplacian.factor(replace_rows_by_identity(lower, system.constraints.wheels).data)

    def solve_pairs(pairs: FloatArray) -> FloatArray:
        k = pairs.shape[1] // 2
        return np.hstack((vertex.solve(pairs[:, :k]), wheel.solve(pairs[:, k:])))

    return Factor(vertex.name, solve_pairs)


@dataclass(frozen=True, eq=False)
class Slivers:
    """The rows of S for sliver triangles, and the symbolic factorisation of their linear system.

    Attributes
    ----------
    rows : RowSubset or None
        None if there are no slivers.
    analysis : Analysis or None
    """

    rows: RowSubset | None = None
    analysis: Analysis | None = None

    @classmethod
    def find(cls, system: System, S: Symmetric, solvers: Solvers) -> Slivers:
        """Find the slivers of a system.

        A triangle is a sliver if the ratio of the eigenvalues of P_t and s_t K_t is large. The limit is lower
        where a correction saves more inner steps.
        """
        constraints, corner = system.constraints, system.topology.corner
        largest = MIN_SLIVER_RATIO
        if constraints.n_rows < LARGE_SYSTEM * max(system.topology.n_outer, 1):
            largest = MIN_SLIVER_RATIO_OF_SMALL_SYSTEM
        elif constraints.prescribes_sums:
            largest = MIN_SLIVER_RATIO / 2  # lower, because many steps reuse the correction
        faces = np.flatnonzero(
            _core.eigenvalue_disparity(system.w, system.d, system.cot) > largest + 1 / largest
        )
        rows = constraints.row[corner[:, faces]]
        pairs = np.unique(rows[rows >= 0])
        if not len(pairs):
            return cls()
        subset = RowSubset(S, pairs)
        return cls(subset, solvers.analyse(subset.indptr, subset.indices, 2))


def make_sliver_preconditioner(
    conformal: Solve, slivers: Slivers, S: Symmetric, holonomy: HolonomyConstraints | None
) -> Solve:
    """Return a preconditioner that applies S^-1 on the rows of slivers before and after `conformal`.

    This is a symmetric multiplicative Schwarz method with two subspaces.
    """
    if slivers.rows is None or slivers.analysis is None:
        return conformal
    blocks, pairs = (
        slivers.rows.extract_blocks(S),
        slivers.rows.pairs,
    )  # also columns of S, which is symmetric
    local = slivers.analysis.factor(blocks.blocks_for_factorisation()).solve
    index, n = (2 * pairs[:, None] + np.arange(2)).ravel(), S.n_rows
    border = None if holonomy is None else holonomy.B.select_rows(index)

    def apply_with_slivers(r: FloatArray) -> FloatArray:
        first = local(r[index])
        left = blocks.subtract_transposed(r, first)
        if border is not None:
            left[n:] -= border.T @ first
        z = conformal(left)
        z[index] += first
        rest = blocks.compute_residual(r, z)
        if border is not None:
            rest -= border @ z[n:]
        z[index] += local(rest)
        return z

    return apply_with_slivers
