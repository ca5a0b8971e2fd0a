"""Closure rows of the angle system: translation of holes, scale and turning along closed paths."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy import linalg, sparse

from .._types import BoolArray, FloatArray, IntArray, Solve
from ..linalg import NotPositiveDefiniteError
from ..surface import NEXT, PREV, Topology, sum_by
from .loops import Closure
from .reduced import System


class ClosingRows:
    """The closure rows T of holes and closed paths, and the angle system bordered by them.

    With q as in `Closure`, a gap changes by

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

    def __init__(self, system: System, closure: Closure, *, conformal: bool = False) -> None:
        """With `conformal`, P is the conformal metric s K itself."""
        self._topology, self._cot, self._closure = system.topology, system.cot, closure
        # a site's vertex row is no part where that row is asked for by itself
        own = np.append(system.constraints.row, np.full(len(system.constraints.paths), -1))[closure.site]
        asked = own >= system.constraints.wheels
        self._share = np.where(asked, 0.0, 1.0)
        self._known = asked, own[asked]
        self._constraints, self._paths = system.constraints, system.constraints.paths
        self._asked = closure.asked.ravel()
        self.size = int(np.count_nonzero(self._asked))
        self._n = 2 * system.constraints.n
        self._metrics = _products(system, closure, self._share)
        self._shape = (self._n, self.size)
        self.B, self.D, self._errors = self._take(system.conformal if conformal else system.projection)

    def _take(
        self, metric: Callable[..., FloatArray]
    ) -> tuple[sparse.csr_array, FloatArray, sparse.csr_array]:
        """B, D and P T^T on the faces at these rows, in a metric P."""
        faces, transposed, merged, closing = self._metrics
        blocks = metric(faces)
        i = np.arange(len(faces))
        inner = sparse.bsr_array((blocks, i, np.arange(len(faces) + 1)), shape=(3 * len(faces),) * 2)
        product = (inner @ transposed).tocsr()
        return (merged @ product).tocsr(), (closing @ product).toarray(), product

    def matvec(self, S: Solve, z: FloatArray) -> FloatArray:
        """The bordered matrix times z, from S's product."""
        x, y = z[: self._n], z[self._n :]
        return np.concatenate((S(x) + self.B @ y, self.B.T @ x + self.D @ y))

    def errors(self, y: FloatArray) -> tuple[IntArray, FloatArray]:
        """The faces where P T^T y is not zero, and its values there, (3, #faces)."""
        return self._metrics[0], (self._errors @ y).reshape(-1, 3).T

    @property
    def vertices(self) -> BoolArray:
        """(#V,) bool: the vertices whose fans the rows sum over."""
        own = np.zeros(self._topology.n, dtype=bool)
        own[self._closure.site[self._closure.site < len(own)]] = True
        for path in self._paths:
            own[self._topology.corner.ravel()[path.corner]] = True
        return own

    def gap(self, closure: Closure, vertex: FloatArray) -> FloatArray:
        """What the rows are to close, (size,), at angles of this closure and residuals of vertex rows."""
        c, (asked, row) = self._closure, self._known
        gap = closure.gap.copy()
        np.subtract.at(gap, c.row[asked], 1j * c.q[asked] * vertex[row])
        return np.column_stack((gap.real, gap.imag)).ravel()[self._asked]

    def at_sites(self, y: FloatArray) -> FloatArray:
        """Multipliers of the vertex and wheel rows of single sites, (#V + #paths, 2), that make up T^T y."""
        c, every = self._closure, np.zeros(len(self._asked))
        every[self._asked] = y
        product = c.q * (every[0::2] - 1j * every[1::2])[c.row]
        x = np.zeros((self._topology.n + len(self._paths), 2))
        x[c.site, 0], x[c.site, 1] = self._share * product.imag, -product.real
        return x

    def rows(self, e: FloatArray) -> FloatArray:
        """T e, (size,)."""
        c, q = self._closure, self._cot * e
        vertex, wheel = (self._at_sites(values)[c.site] for values in (e, q[NEXT] - q[PREV]))
        moved = -c.q * (wheel + 1j * (self._share * vertex))
        parts = [sum_by(c.row, part, len(c.gap)) for part in (moved.real, moved.imag)]
        return np.column_stack(parts).ravel()[self._asked]

    def _at_sites(self, values: FloatArray) -> FloatArray:
        """Sum (3, #F) corner values over the corners of each vertex, and over the left fans of each path."""
        fans = [values.ravel()[path.corner].sum() for path in self._paths]
        return np.concatenate((self._topology.sum_at_vertices(values), fans))

    def solver(self, inner: Solve) -> Solve:
        """Solve the bordered system, given the `inner` solve of its first block, (2 #rows, k).

        Raises
        ------
        NotPositiveDefiniteError
            The rows depend on each other.
        """
        across = _Columns(inner(self.B.toarray()))
        return self._bordered(inner, across, self.D - across.onto(self.B))

    def preconditioner(
        self, system: System, inverse: Solve, S: Solve | None, known: Across | None = None
    ) -> tuple[Solve, Across]:
        """Solve the bordered system approximately, by the `inverse` of the Laplacians, (#rows, k).

        With C = diag(L_s, L_s)^-1 B of the conformal metric, the rows T - C^T M close the same paths, and in
        that metric they have nothing in common with M. So they are solved for apart, in their own metric: by
        D - C^T B - B^T C + C^T S C, which is positive definite for any C. Without `S`, the metric is the
        conformal one of these rows. If that is K alone, S is diag(L, L) there, and this is exact. With `S`,
        columns that are `known` of an earlier system may serve as C. Returns C, too.

        Raises
        ------
        NotPositiveDefiniteError
            The rows depend on each other.
        """
        across: Across
        if S is None:
            across, schur = self.conformal(inverse)
        else:
            if isinstance(known, _OfPaths) and known.scale.shape[1] == len(self._paths):
                across = self._of_paths(known.scale)
            else:
                across = self._across(inverse, self._take(system.conformal)[0])
            mixed = across.onto(self.B)
            schur = self.D - mixed - mixed.T + np.array([across.onto(S(c)) for c in across.each()])
        return self._bordered(lambda r: by_pairs(inverse, r), across, schur), across

    def conformal(self, inverse: Solve) -> tuple[Across, FloatArray]:
        """C = diag(L, L)^-1 B and D - B^T C, in the conformal metric of these rows."""
        across = self._across(inverse, self.B)
        return across, self.D - across.onto(self.B)

    def _across(self, inverse: Solve, B: sparse.csr_array) -> Across:
        """diag(L_s, L_s)^-1 B, by one right-hand side a column.

        The metric is conformal: what a column has in vertex rows and in wheel rows are real and imaginary
        part of one complex number, and the other part of the gap has i times that.
        """
        constraints, holes = self._constraints, len(self._closure.gap) - len(self._paths)
        if constraints.wheels < constraints.n:
            return _Columns(by_pairs(inverse, B.toarray()))
        asked, wheel = np.flatnonzero(self._asked), B[1::2]
        if not holes:
            return self._of_paths(inverse(wheel[:, np.flatnonzero(asked % 2 == 0)].toarray()))
        both = np.zeros((constraints.n, 2, len(self._asked)))
        both[:, 1, asked] = inverse(wheel.toarray())
        both[:, 0, 0::2], both[:, 0, 1::2] = -both[:, 1, 1::2], both[:, 1, 0::2]
        return _Columns(both[:, :, asked].reshape(self._shape))

    def _of_paths(self, scale: FloatArray) -> _OfPaths:
        path, part = np.divmod(np.flatnonzero(self._asked), 2)
        return _OfPaths(scale, path, 1 - part)

    def _bordered(self, inner: Solve, across: Across, schur: FloatArray) -> Solve:
        try:
            factor = linalg.cho_factor((schur + schur.T) / 2)
        except linalg.LinAlgError:
            raise NotPositiveDefiniteError(self._n - 1) from None

        def solve(r: FloatArray) -> FloatArray:
            x = inner(r[: self._n, None])[:, 0]
            y = linalg.cho_solve(factor, r[self._n :] - across.onto(r[: self._n]))
            return np.concatenate((x - across.along(y), y))

        return solve


@dataclass(frozen=True, eq=False)
class _Columns:
    """A dense matrix C of the border's columns, (2 #rows, size)."""

    columns: FloatArray

    def along(self, y: FloatArray) -> FloatArray:
        """C y."""
        return np.asarray(self.columns @ y)

    def onto(self, r: FloatArray | sparse.csr_array) -> FloatArray:
        """C^T r of a vector or a sparse matrix."""
        return np.asarray((r.T @ self.columns).T)

    def vertex_rows(self, rows: IntArray) -> FloatArray:
        """Some rows of C, those of vertex constraints."""
        return np.asarray(self.columns[2 * rows])

    def each(self) -> Iterator[FloatArray]:
        """The columns."""
        yield from np.ascontiguousarray(self.columns.T)


@dataclass(frozen=True, eq=False)
class _OfPaths:
    """The same of closed paths alone: a column for the scale of a path is one for its turning, too.

    Attributes
    ----------
    scale : (#rows, #paths) float64
    path, kind : (size,) int64
        Of each column the path, and 0 if it is for vertex rows, 1 if it is for wheel rows.
    """

    scale: FloatArray
    path: IntArray
    kind: IntArray

    def along(self, y: FloatArray) -> FloatArray:
        both = np.zeros((self.scale.shape[1], 2))
        both[self.path, self.kind] = y
        return np.asarray(self.scale @ both).ravel()

    def onto(self, r: FloatArray | sparse.csr_array) -> FloatArray:
        if sparse.issparse(r):
            both = np.stack([np.asarray(r[k::2].T @ self.scale).T for k in range(2)], axis=1)
        else:
            both = self.scale.T @ r.reshape(-1, 2)
        return both[self.path, self.kind]

    def vertex_rows(self, rows: IntArray) -> FloatArray:
        return np.where(self.kind == 0, self.scale[rows][:, self.path], 0.0)

    def each(self) -> Iterator[FloatArray]:
        for path, kind in zip(self.path, self.kind, strict=True):
            column = np.zeros((len(self.scale), 2))
            column[:, kind] = self.scale[:, path]
            yield column.ravel()


Across = _Columns | _OfPaths


def by_pairs(inverse: Solve, r: FloatArray) -> FloatArray:
    """diag(L+, L)^-1 r, (2 #rows, k), the two rows of a vertex being next to each other."""
    return inverse(r.reshape(len(r) // 2, -1)).reshape(r.shape)


def _products(
    system: System, closure: Closure, share: FloatArray
) -> tuple[np.ndarray, sparse.csr_array, sparse.csr_array, sparse.csr_array]:
    """Factors of B and D, on the faces at holes' loops and at paths only.

    Returns these faces, T^T, M and T; errors are numbered 3 t + k over these faces.
    """
    topology: Topology = system.topology
    paths, n_faces = system.constraints.paths, topology.corner.shape[1]
    at_loop = np.zeros(topology.n, dtype=bool)
    at_loop[closure.site[closure.site < topology.n]] = True
    touched: BoolArray = np.asarray(at_loop[topology.corner].any(axis=0))
    for path in paths:
        touched[path.corner % n_faces] = True
    faces = np.flatnonzero(touched)
    corner, cot = topology.corner[:, faces], system.cot[:, faces]
    m, n_sites = len(faces), topology.n + len(paths)
    error = (3 * np.arange(m) + np.arange(3)[:, None]).ravel()
    # vertex row of the corner's own vertex; wheel rows of those whose left or right angle it is
    column = np.concatenate((2 * corner, 2 * corner[PREV] + 1, 2 * corner[NEXT] + 1)).ravel()
    value = np.concatenate((np.ones_like(cot), cot, -cot)).ravel()
    errors = np.tile(error, 3)
    for i, path in enumerate(paths):  # likewise, the path's left fans being one site
        k, t = np.divmod(path.corner, n_faces)
        t, column_here = np.searchsorted(faces, t), np.full(len(k), 2 * (topology.n + i))
        left, right = (k + 1) % 3, (k + 2) % 3
        errors = np.concatenate((errors, 3 * t + k, 3 * t + left, 3 * t + right))
        column = np.concatenate((column, column_here, column_here + 1, column_here + 1))
        value = np.concatenate((value, np.ones(len(k)), cot[left, t], -cot[right, t]))
    single = sparse.csr_array((value, (errors, column)), shape=(3 * m, 2 * n_sites))
    v, j, q = closure.site, closure.row, closure.q
    weights = sparse.csr_array(
        (
            np.concatenate((share * q.imag, -share * q.real, -q.real, -q.imag)),
            (
                np.concatenate((2 * v, 2 * v, 2 * v + 1, 2 * v + 1)),
                np.concatenate((2 * j, 2 * j + 1, 2 * j, 2 * j + 1)),
            ),
        ),
        shape=(2 * n_sites, 2 * len(closure.gap)),
    )
    asked = closure.asked.ravel()
    if not asked.all():
        weights = weights[:, np.flatnonzero(asked)]
    transposed = (single @ weights).tocsr()
    row_of = system.constraints.row
    inside = np.flatnonzero(row_of >= 0)
    wheels = np.flatnonzero((row_of >= 0) & (row_of < system.constraints.wheels))
    pair = np.concatenate((2 * inside, 2 * wheels + 1))
    row = np.concatenate((2 * row_of[inside], 2 * row_of[wheels] + 1))
    merge = sparse.csr_array((np.ones(len(pair)), (row, pair)), shape=(2 * system.constraints.n, 2 * n_sites))
    return faces, transposed, (merge @ single.T).tocsr(), transposed.T.tocsr()
