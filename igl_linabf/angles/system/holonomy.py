"""HolonomyResidual rows of the angle system: translation of holes, scale and turning along closed paths."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy
from scipy import sparse

from ..._types import BoolArray, FloatArray, IntArray, Solve
from ...linalg import NotPositiveDefiniteError
from ...surface import NEXT, PREV
from .constraints import HolonomyResidual
from .patterns import Symmetric, by_pairs
from .reduced_system import System
from .schur_columns import Border, Columns, ColumnsOfGaps, ColumnsOfPaths, SchurColumns, Tall, tall

TOGETHER = 8  # gaps whose columns are solved for at a time


class HolonomyConstraints:
    """The closure rows T of holes and closed paths, and the angle system bordered by them.

    With q as in `HolonomyResidual`, a gap changes by

        d tau = sum_v q_v (d log-ratio_v + i d turning_v) = -sum_v q_v (wheel_v + i vertex_v) e,

    where wheel_v and vertex_v are the rows of the single loop vertices (docs/holes.md), or of all left
    fans of a path. So T^T y has the vertex rows Im(q conj(y)) and the wheel rows -Re(q conj(y)). Parts
    of a gap that are not asked for have no row. Where vertex_v is a row of S, too, it is taken out
    here, and what it is to be goes to the right-hand side. The system becomes

        [ S    B ] [x]        B = M P T^T,  D = T P T^T.
        [ B^T  D ] [y]

    In the conformal metric, with s_t K_t for P_t, S is close to diag(L_s, L_s); it is equal if all s_t
    are equal. So the factor of L_s and a dense matrix of the border's size precondition the system.
    """

    def __init__(self, system: System, holonomy: HolonomyResidual, *, conformal: bool = False) -> None:
        """With `conformal`, P is the conformal metric s K itself."""
        self._topology, self._cot, self._holonomy = system.topology, system.cot, holonomy
        # a site's vertex row is no part where that row is asked for by itself
        own = np.append(system.constraints.row, np.full(len(system.constraints.paths), -1))[holonomy.site]
        asked = own >= system.constraints.wheels
        self._share = np.where(asked, 0.0, 1.0)
        self._known = asked, own[asked]
        self._constraints, self._paths = system.constraints, system.constraints.paths
        self._asked = holonomy.asked.ravel()
        self.size = int(np.count_nonzero(self._asked))
        self._n = 2 * system.constraints.n
        self._faces, self._transposed, self._pairs, self._merged = _products(system, holonomy, self._share)
        self.B, self.D, self._errors = self._take(system.conformal if conformal else system.projection)

    def _take(self, metric: Callable[[IntArray], FloatArray]) -> tuple[Border, FloatArray, Tall]:
        """B, D and P T^T on the faces at these rows, in a metric P."""
        blocks, i = metric(self._faces), np.arange(len(self._faces) + 1)
        product = sparse.bsr_array((blocks, i[:-1], i), shape=(3 * len(blocks),) * 2) @ self._transposed
        D = self._transposed.T @ product
        D = D if isinstance(D, np.ndarray) else D.toarray()
        return Border(self._pairs, self._merged @ product), D, product

    def matvec(self, S: Solve, z: FloatArray) -> FloatArray:
        """The bordered matrix times z, from S's product."""
        x, y = z[: self._n], z[self._n :]
        product = np.concatenate((S(x), self.B.onto(x) + self.D @ y))
        product[self.B.rows] += self.B.values @ y
        return product

    def errors(self, y: FloatArray) -> tuple[IntArray, FloatArray]:
        """The faces where P T^T y is not zero, and its values there, (3, #faces)."""
        return self._faces, (self._errors @ y).reshape(-1, 3).T

    @property
    def vertices(self) -> BoolArray:
        """(#V,) bool: the vertices whose fans the rows sum over."""
        own = np.zeros(self._topology.n, dtype=bool)
        own[self._holonomy.site[self._holonomy.site < len(own)]] = True
        for path in self._paths:
            own[self._topology.corner.ravel()[path.corner]] = True
        return own

    def gap(self, holonomy: HolonomyResidual, vertex: FloatArray) -> FloatArray:
        """What the rows are to close, (size,), at angles of this closure and residuals of vertex rows."""
        c, (asked, row) = self._holonomy, self._known
        gap = holonomy.gap.copy()
        np.subtract.at(gap, c.row[asked], 1j * c.q[asked] * vertex[row])
        return np.column_stack((gap.real, gap.imag)).ravel()[self._asked]

    def at_sites(self, y: FloatArray) -> FloatArray:
        """Multipliers of the vertex and wheel rows of single sites, (#V + #paths, 2), that make up T^T y."""
        c, every = self._holonomy, np.zeros(len(self._asked))
        every[self._asked] = y
        product = c.q * (every[0::2] - 1j * every[1::2])[c.row]
        x = np.zeros((self._topology.n + len(self._paths), 2))
        x[c.site, 0], x[c.site, 1] = self._share * product.imag, -product.real
        return x

    def rows(self, e: FloatArray) -> FloatArray:
        """T e, (size,)."""
        return np.asarray(self._transposed.T @ e[:, self._faces].T.ravel())

    def solver(self, inner: Solve) -> Solve:
        """Solve the bordered system, given the `inner` solve of its first block, (2 #rows, k).

        Raises
        ------
        NotPositiveDefiniteError
            The rows depend on each other.
        """
        columns = Columns(np.ascontiguousarray(inner(self.B.whole(self._n)).T), self._holonomy, self.D)
        return self._bordered(inner, columns, self.D - columns.onto_border(self.B))

    def preconditioner(
        self, system: System, inverse: Solve, S: Symmetric | None, known: SchurColumns | None = None
    ) -> tuple[Solve, SchurColumns]:
        """Solve the bordered system approximately, by the `inverse` of the Laplacians, (#rows, k).

        With C = diag(L_s, L_s)^-1 B of the conformal metric, the rows T - C^T M close the same paths, and in
        that metric they have nothing in common with M. So they are solved for apart, in their own metric: by
        D - C^T B - B^T C + C^T S C, which is positive definite for any C. Where the turning of closed paths
        is free, D - C^T B of the conformal metric is as good. Without `S`, the metric is the
        conformal one of these rows. If that is K alone, S is diag(L, L) there, and this is exact. With `S`,
        columns that are `known` of an earlier system may serve as C. Returns C, too.

        Raises
        ------
        NotPositiveDefiniteError
            The rows depend on each other.
        """

        def inner(r: FloatArray) -> FloatArray:
            return by_pairs(inverse, r)

        columns: SchurColumns
        if S is None:
            columns, schur = self.conformal(inverse)
            return self._bordered(inner, columns, schur), columns
        if known is not None and known.serves(self._holonomy):
            columns = known
        else:
            columns = self._across(inverse, *self._take(system.conformal)[:2])
        if not self._holonomy.asked[len(self._holonomy.asked) - len(self._paths) :, 1].any():
            try:
                return self._bordered(inner, columns, columns.schur), columns
            except NotPositiveDefiniteError:
                pass  # the inverse is not exact, or the scales s_t differ too much
        mixed = columns.onto_border(self.B)
        schur = self.D - mixed - mixed.T + columns.within(S)
        return self._bordered(inner, columns, schur), columns

    def conformal(self, inverse: Solve) -> tuple[SchurColumns, FloatArray]:
        """C = diag(L, L)^-1 B and D - B^T C, in the conformal metric of these rows."""
        columns = self._across(inverse, self.B, self.D)
        return columns, columns.schur

    def _across(self, inverse: Solve, B: Border, D: FloatArray) -> SchurColumns:
        """diag(L_s, L_s)^-1 B, by one right-hand side a column.

        The metric is conformal: what a column has in vertex rows and in wheel rows are real and imaginary
        part of one complex number, and the other part of the gap has i times that.
        """
        constraints, asked = self._constraints, self._holonomy.asked
        columns: SchurColumns
        if constraints.wheels < constraints.n:
            whole = by_pairs(inverse, B.whole(self._n))
            columns = Columns(np.ascontiguousarray(whole.T), self._holonomy, D)
        elif len(self._paths) == len(asked):
            path, part = np.nonzero(asked)
            wheel = B.second(constraints.n, np.flatnonzero(part == 0))
            columns = ColumnsOfPaths(inverse(wheel), path, 1 - part, D)
        else:
            of_gap = np.zeros((len(asked), constraints.n), dtype=np.complex128)
            number = np.cumsum(self._asked).reshape(-1, 2) - 1
            for first in range(0, len(asked), TOGETHER):
                some = slice(first, first + TOGETHER)
                made = of_gap[some].view(np.float64).reshape(-1, constraints.n, 2).transpose(0, 2, 1)
                made[asked[some]] = inverse(B.second(constraints.n, number[some][asked[some]])).T
            columns = ColumnsOfGaps(of_gap, self._holonomy, D)
        return replace(columns, schur=D - columns.onto_border(B))

    def _bordered(self, inner: Solve, columns: SchurColumns, schur: FloatArray) -> Solve:
        try:
            factor = scipy.linalg.cho_factor((schur + schur.T) / 2)
        except scipy.linalg.LinAlgError:
            raise NotPositiveDefiniteError(self._n - 1) from None

        def solve(r: FloatArray) -> FloatArray:
            x = inner(r[: self._n, None])[:, 0]
            y = scipy.linalg.cho_solve(factor, r[self._n :] - columns.onto(r[: self._n]))
            return np.concatenate((x - columns.along(y), y))

        return solve


def _products(
    system: System, holonomy: HolonomyResidual, share: FloatArray
) -> tuple[IntArray, Tall, IntArray, sparse.csr_array]:
    """Factors of B and D, on the faces at holes' loops and at paths only.

    Returns these faces, T^T, the numbers of the pairs of rows of M there, and these rows; errors are numbered
    3 t + k over these faces.
    """
    topology, constraints, cot = system.topology, system.constraints, system.cot
    paths, n_faces = constraints.paths, topology.corner.shape[1]
    touched: BoolArray = np.zeros(n_faces, dtype=bool)
    loops = holonomy.site[holonomy.site < topology.n]
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
    # vertex row of the corner's own vertex; wheel rows of those whose left or right angle it is
    site = np.concatenate((corner, corner[PREV], corner[NEXT])).ravel()
    wheel = np.repeat([False, True], [3 * m, 6 * m])
    value = np.concatenate((np.ones_like(cot_here), cot_here, -cot_here)).ravel()
    row, n_wheels = constraints.row[site], constraints.wheels
    known = (row >= 0) & ~(wheel & (row >= n_wheels))
    pairs, place = np.unique(row[known], return_inverse=True)
    shape = 2 * len(pairs), 3 * m
    merged = sparse.csr_array((value[known], (2 * place + wheel[known], error[known])), shape=shape)
    for i, path in enumerate(paths):  # likewise, the path's left fans being one site
        k, t = np.divmod(path.corner, n_faces)
        t, left, right = 3 * np.searchsorted(faces, t), (k + 1) % 3, (k + 2) % 3
        error = np.concatenate((error, t + k, t + left, t + right))
        site = np.append(site, np.full(3 * len(k), topology.n + i))
        wheel = np.append(wheel, np.repeat([False, True], [len(k), 2 * len(k)]))
        value = np.concatenate((value, np.ones(len(k)), cot[left, faces[t // 3]], -cot[right, faces[t // 3]]))
    of_site = np.full(topology.n + len(paths), -1)
    of_site[holonomy.site] = np.arange(len(holonomy.site))
    at = of_site[site]
    drawn = np.flatnonzero(at >= 0)
    at, error, wheel, value = at[drawn], error[drawn], wheel[drawn], value[drawn]
    q, gap = holonomy.q[at], holonomy.row[at]
    real = np.where(wheel, -q.real, share[at] * q.imag) * value
    imaginary = np.where(wheel, -q.imag, -share[at] * q.real) * value
    asked = holonomy.asked.ravel()
    number = np.cumsum(asked) - 1
    column = np.append(2 * gap, 2 * gap + 1)
    chosen = np.flatnonzero(asked[column])
    entries = np.append(real, imaginary)[chosen], np.append(error, error)[chosen], number[column[chosen]]
    return faces, tall(*entries, (3 * m, int(np.count_nonzero(asked)))), pairs, merged
