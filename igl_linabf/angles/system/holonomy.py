"""Holonomy constraints: the loops of holes close, and closed paths keep their scale and direction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy
from scipy import sparse

from ..._types import BoolArray, FloatArray, IntArray, Solve
from ...linalg import NotPositiveDefiniteError
from ...surface import NEXT, PREV
from .constraints import Constraints, HolonomyResidual
from .patterns import Symmetric, solve_pairs
from .reduced_system import System
from .schur_columns import Border, NarrowMatrix, SchurColumns, build_narrow_matrix, solve_for_columns


@dataclass(frozen=True, eq=False)
class HolonomyRows:
    """The rows T of the holonomy constraints at some angles, on the faces along loops and paths.

    With q as in `HolonomyResidual`, a closure error tau changes by

        d tau = sum_v q_v (d log-ratio_v + i d turning_v) = -sum_v q_v (wheel_v + i vertex_v) e,

    where wheel_v and vertex_v are the rows of a single vertex of the loop (docs/holes.md), or of all left
    fans of a path. Therefore T^T y combines the vertex rows with coefficients Im(q conj(y)) and the wheel
    rows with coefficients -Re(q conj(y)). A part of a closure error that is not constrained has no row. If
    vertex_v is also a row of M because its sum is prescribed, it is omitted from T, and its contribution
    moves to the right-hand side.

    Attributes
    ----------
    constraints : Constraints
    drawn : HolonomyResidual
        The loops and paths at these angles.
    faces : (#f,) int64
        Faces where T is not zero.
    transposed : (3 #f, #T) matrix
        T^T, with errors numbered 3 t + k over `faces`.
    pairs : (#p,) int64
        Indices r of the rows 2 r and 2 r + 1 of M that are not zero on `faces`; ascending.
    row_pairs : (2 #p, 3 #f) sparse array
        The rows of M at `pairs`.
    """

    constraints: Constraints
    drawn: HolonomyResidual
    faces: IntArray
    transposed: NarrowMatrix
    pairs: IntArray
    row_pairs: sparse.csr_array

    @classmethod
    def from_system(cls, system: System, drawn: HolonomyResidual) -> HolonomyRows:
        """Return the rows of the holonomy constraints at the angles of a system."""
        topology, constraints, cot = system.topology, system.constraints, system.cot
        paths, n_faces = constraints.paths, topology.corner.shape[1]
        touched: BoolArray = np.zeros(n_faces, dtype=bool)
        loops = drawn.site[drawn.site < topology.n]
        if len(loops):
            at_loop = np.zeros(topology.n, dtype=bool)
            at_loop[loops] = True
            touched |= at_loop[topology.corner].any(axis=0)
        for path in paths:
            touched[path.corner % n_faces] = True
        faces = np.flatnonzero(touched)
        corner, cot_here = topology.corner[:, faces], cot[:, faces]
        m = len(faces)
        error = np.tile((3 * np.arange(m) + np.arange(3)[:, None]).ravel(), 3)
        # entries in the vertex row of the corner, and in the wheel rows of the next and the previous corner
        site = np.concatenate((corner, corner[PREV], corner[NEXT])).ravel()
        wheel = np.repeat([False, True], [3 * m, 6 * m])
        value = np.concatenate((np.ones_like(cot_here), cot_here, -cot_here)).ravel()
        row, n_wheels = constraints.row[site], constraints.wheels
        has_row = (row >= 0) & ~(wheel & (row >= n_wheels))
        pairs, place = np.unique(row[has_row], return_inverse=True)
        entries = value[has_row], (2 * place + wheel[has_row], error[has_row])
        row_pairs = sparse.csr_array(entries, shape=(2 * len(pairs), 3 * m))
        for i, path in enumerate(paths):  # the left fans of a path form a single site
            k, t = np.divmod(path.corner, n_faces)
            t, left, right = 3 * np.searchsorted(faces, t), (k + 1) % 3, (k + 2) % 3
            error = np.concatenate((error, t + k, t + left, t + right))
            site = np.append(site, np.full(3 * len(k), topology.n + i))
            wheel = np.append(wheel, np.repeat([False, True], [len(k), 2 * len(k)]))
            cots = cot[left, faces[t // 3]], -cot[right, faces[t // 3]]
            value = np.concatenate((value, np.ones(len(k)), *cots))
        transposed = _transposed_rows(constraints, drawn, m, (error, site, wheel, value))
        return cls(constraints, drawn, faces, transposed, pairs, row_pairs)

    @property
    def n_constraints(self) -> int:
        """Number of holonomy constraints, which are the rows of T."""
        return int(self.transposed.shape[1])

    @property
    def vertex_mask(self) -> BoolArray:
        """Mask, (#V,), of the vertices whose fans the rows sum over."""
        corner = self.constraints.topology.corner
        summed = np.zeros(self.constraints.topology.n, dtype=bool)
        summed[self.drawn.site[self.drawn.site < len(summed)]] = True
        for path in self.constraints.paths:
            summed[corner.ravel()[path.corner]] = True
        return summed

    def compute_residuals(self, drawn: HolonomyResidual, vertex: FloatArray) -> FloatArray:
        """Return the residuals of the constraint rows, (#T,), at the given angles.

        `vertex` are the residuals of the vertex constraints at these angles.
        """
        prescribed = mask_prescribed_sites(self.constraints, self.drawn)
        rows = self.constraints.row[self.drawn.site[prescribed]]
        gap = drawn.gap.copy()
        np.subtract.at(gap, self.drawn.row[prescribed], 1j * self.drawn.q[prescribed] * vertex[rows])
        return np.column_stack((gap.real, gap.imag)).ravel()[self.drawn.constrained.ravel()]

    def multiply(self, e: FloatArray) -> FloatArray:
        """Multiply the holonomy rows T by angle errors e, (3, #F)."""
        return np.asarray(self.transposed.T @ e[:, self.faces].T.ravel())

    def multipliers_at_sites(self, y: FloatArray) -> FloatArray:
        """Return the multipliers of the vertex and wheel rows of each site, (#V + #paths, 2), in T^T y."""
        drawn, both = self.drawn, np.zeros(self.drawn.constrained.size)
        both[drawn.constrained.ravel()] = y
        product = drawn.q * (both[0::2] - 1j * both[1::2])[drawn.row]
        x = np.zeros((self.constraints.topology.n + len(self.constraints.paths), 2))
        own = np.where(mask_prescribed_sites(self.constraints, drawn), 0.0, 1.0)
        x[drawn.site, 0], x[drawn.site, 1] = own * product.imag, -product.real
        return x

    def build_border(
        self, metric: Callable[[IntArray], FloatArray]
    ) -> tuple[Border, FloatArray, NarrowMatrix]:
        """Return the border M P T^T, the block T P T^T, and P T^T on the faces of the rows, for a metric P.

        `metric` returns the element matrices of P.
        """
        blocks, i = metric(self.faces), np.arange(len(self.faces) + 1)
        product = sparse.bsr_array((blocks, i[:-1], i), shape=(3 * len(blocks),) * 2) @ self.transposed
        D = self.transposed.T @ product
        D = D if isinstance(D, np.ndarray) else D.toarray()
        return Border(self.pairs, self.row_pairs @ product), D, product


def mask_prescribed_sites(constraints: Constraints, drawn: HolonomyResidual) -> BoolArray:
    """Return a mask of the sites whose vertex row is a row of M because their angle sum is prescribed."""
    row = np.append(constraints.row, np.full(len(constraints.paths), -1))
    return np.asarray(row[drawn.site] >= constraints.wheels)


def _transposed_rows(
    constraints: Constraints,
    drawn: HolonomyResidual,
    n_faces: int,
    single: tuple[IntArray, IntArray, BoolArray, FloatArray],
) -> NarrowMatrix:
    """Return T^T from the entries of the rows of single sites.

    `single` contains the error, the site, a flag for wheel rows and the value of each entry.
    """
    error, site, wheel, value = single
    index = np.full(constraints.topology.n + len(constraints.paths), -1)
    index[drawn.site] = np.arange(len(drawn.site))
    at = index[site]
    found = np.flatnonzero(at >= 0)
    at, error, wheel, value = at[found], error[found], wheel[found], value[found]
    q, gap = drawn.q[at], drawn.row[at]
    own = np.where(mask_prescribed_sites(constraints, drawn), 0.0, 1.0)[at]
    real = np.where(wheel, -q.real, own * q.imag) * value
    imaginary = np.where(wheel, -q.imag, -own * q.real) * value
    constrained = drawn.constrained.ravel()
    number = np.cumsum(constrained) - 1
    column = np.append(2 * gap, 2 * gap + 1)
    chosen = np.flatnonzero(constrained[column])
    entries = np.append(real, imaginary)[chosen], np.append(error, error)[chosen], number[column[chosen]]
    return build_narrow_matrix(*entries, (3 * n_faces, int(np.count_nonzero(constrained))))


class HolonomyConstraints:
    """The angle system bordered by the rows T of the holonomy constraints.

        [ S    B ] [x]        B = M P T^T,  D = T P T^T.
        [ B^T  D ] [y]

    In the conformal metric, where s_t K_t replaces P_t, S is close to diag(L_s, L_s), and equal to it if all
    s_t are equal. Therefore the factor of L_s and a dense matrix of the size of the border precondition the
    system.

    Attributes
    ----------
    rows : HolonomyRows
    B : Border
    D : (#T, #T) float64
    """

    def __init__(self, system: System, drawn: HolonomyResidual, *, conformal: bool = False) -> None:
        """Set up the border B and D; with `conformal`, the metric P is the conformal metric s K."""
        self.rows = HolonomyRows.from_system(system, drawn)
        metric = system.conformal_matrices if conformal else system.projection_matrices
        self.B, self.D, self._errors = self.rows.build_border(metric)
        self._n = 2 * system.constraints.n_rows

    def matvec(self, S: Solve, z: FloatArray) -> FloatArray:
        """Multiply the bordered matrix by z, given the product with S."""
        x, y = z[: self._n], z[self._n :]
        product = np.concatenate((S(x), self.B.multiply_transposed(x) + self.D @ y))
        product[self.B.row_indices] += self.B.values @ y
        return product

    def compute_angle_errors(self, y: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the angle errors P T^T y: the faces where they are not zero, and the values, (3, #faces)."""
        return self.rows.faces, (self._errors @ y).reshape(-1, 3).T

    def make_solver(self, inner: Solve) -> Solve:
        """Return a solver of the bordered system, given a solver `inner` of its first block, (2 #rows, k).

        Raises
        ------
        NotPositiveDefiniteError
            The rows are linearly dependent.
        """
        columns = self._solve_for_columns(inner)
        return self._make_bordered_solver(inner, columns, columns.schur)

    def make_preconditioner(
        self, system: System, inverse: Solve, S: Symmetric | None, known: SchurColumns | None = None
    ) -> tuple[Solve, SchurColumns]:
        """Return a preconditioner of the bordered system, given the `inverse` of `factor_laplacians`, and C.

        C = diag(L_s, L_s)^-1 B of the conformal metric. The rows T - C^T M close the same loops as T, and are
        orthogonal to M in the conformal metric. Therefore, they are solved separately, with the matrix D -
        C^T B - B^T C + C^T S C, which is positive definite for any C. If the turning of all closed paths is
        free, the matrix D - C^T B of the conformal metric is used instead.

        Without `S`, these constraints use the conformal metric, and the result is exact if K is this metric.
        With `S`, the columns `known` of an earlier system may replace C.

        Raises
        ------
        NotPositiveDefiniteError
            The rows are linearly dependent.
        """

        inner = partial(solve_pairs, inverse)
        n, drawn = self.rows.constraints.n_rows, self.rows.drawn
        if S is None:
            columns = self._solve_for_columns(inner)
            return self._make_bordered_solver(inner, columns, columns.schur), columns
        if known is not None and known.is_reusable(drawn):
            columns = known
        else:
            columns = solve_for_columns(
                inner, *self.rows.build_border(system.conformal_matrices)[:2], n, drawn
            )
        if not drawn.constrained[len(drawn.constrained) - len(self.rows.constraints.paths) :, 1].any():
            try:
                return self._make_bordered_solver(inner, columns, columns.schur), columns
            except NotPositiveDefiniteError:
                pass  # the approximation fails if the inverse is inexact or the scales s_t differ too much
        mixed = columns.multiply_transposed_by_border(self.B)
        return self._make_bordered_solver(
            inner, columns, self.D - mixed - mixed.T + columns.galerkin_product(S)
        ), columns

    def solve_conformal_columns(self, inverse: Solve) -> SchurColumns:
        """Return C = diag(L, L)^-1 B with D - B^T C, if the constraints use the conformal metric."""
        return self._solve_for_columns(partial(solve_pairs, inverse))

    def _solve_for_columns(self, inner: Solve) -> SchurColumns:
        """Return A^-1 B for the border B, given a solver `inner` of A."""
        return solve_for_columns(inner, self.B, self.D, self.rows.constraints.n_rows, self.rows.drawn)

    def _make_bordered_solver(self, inner: Solve, columns: SchurColumns, schur: FloatArray) -> Solve:
        """Return a solver of the bordered system from its Schur complement."""
        try:
            factor = scipy.linalg.cho_factor((schur + schur.T) / 2)
        except scipy.linalg.LinAlgError:
            raise NotPositiveDefiniteError(self._n - 1) from None

        def solve_bordered(r: FloatArray) -> FloatArray:
            x = inner(r[: self._n, None])[:, 0]
            y = scipy.linalg.cho_solve(factor, r[self._n :] - columns.multiply_transposed(r[: self._n]))
            return np.concatenate((x - columns.multiply(y), y))

        return solve_bordered
