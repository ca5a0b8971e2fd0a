"""The linear angle system in reduced form, its Laplacian, and the steps taken with them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from .angles import Residual, residual
from .errors import FallbackWarning, MeshError, some, stack_level
from .pattern import Pattern
from .solver import CAP, Factor, NotPositiveDefiniteError, Solvers, conjugate_gradients
from .topology import NEXT, PREV, FloatArray, IntArray, Topology

REACH = 0.7  # share of the way to a vanishing angle that a triangle's step may go
SLIVER = 10.0  # eigenvalue ratio of a triangle's P and s K above which it is corrected for


class System:
    """The reduced linear system of the angle errors at `alpha` (design, section 2).

    The paper minimises sum (e / alpha)^2 subject to A e = b, that is (A W A^T) x = b and
    e = W A^T x with W = diag(alpha^2) (eq. 11-16). Its triangle rows are mutually W-orthogonal.
    Eliminating them leaves, with w = alpha^2, d = sum w, P = diag(w) - w w^T / d per triangle,

        S x = r - M e0,    S = sum_t M_t P_t M_t^T,    e = e0 + P M^T x,

    e0 = w (pi - sum alpha) / d and M the vertex and the wheel rows (eq. 5, 10), whose two
    unknowns at a vertex are next to each other.
    """

    def __init__(self, topology: Topology, pattern: Pattern, alpha: FloatArray) -> None:
        self.topology, self.pattern = topology, pattern
        self.w = alpha**2
        self.d = self.w.sum(axis=0)
        self.cot = 1 / np.tan(alpha)
        self._rows = topology.row[topology.corner]

    def error(self, x: FloatArray) -> FloatArray:
        """P M^T x: (3, #F) angles from (#rows, 2) multipliers."""
        # a missing row, -1, reads the zero at the end
        vertex = np.append(x[:, 0], 0.0)[self._rows]
        wheel = np.append(x[:, 1], 0.0)[self._rows]
        y = self.w * (vertex + self.cot * (wheel[PREV] - wheel[NEXT]))
        return np.asarray(y - self.w * (y.sum(axis=0) / self.d))

    def rows(self, e: FloatArray) -> FloatArray:
        """M e: (#rows, 2) sums of (3, #F) angles."""
        t, q = self.topology, self.cot * e
        vertex = t.sum_at_rows(t.sum_at_vertices(e))
        wheel = t.sum_at_rows(t.sum_at_vertices(q[NEXT] - q[PREV]))
        return np.column_stack((vertex, wheel))

    def matrix(self) -> sparse.csr_array:
        """S, (2 #rows, 2 #rows)."""
        t, w, c, d = self.topology, self.w, self.cot, self.d
        q = w * c
        g = q[NEXT] - q[PREV]
        qc = q * c
        gd, wd = g / d, w / d
        # within a corner's own row: (vertex, vertex), (vertex, wheel), (wheel, vertex), (wheel, wheel)
        own = (w - w * wd, -w * gd, qc[NEXT] + qc[PREV] - g * gd)
        vertex, mixed, wheel = (t.sum_at_rows(t.sum_at_vertices(values)) for values in own)
        diagonal = np.stack((vertex, mixed, mixed, wheel))
        # between the corners a, b at tail and head of the half-edge opposite to corner k
        wa, wb, ga, gb = w[NEXT], w[PREV], gd[NEXT], gd[PREV]
        across = (-wa * wd[PREV], -q[NEXT] - wa * gb, q[PREV] - wb * ga, -qc - g[NEXT] * gb)
        back = (across[0], across[2], across[1], across[3])
        block = np.stack(
            [t.sum_at_edges(np.where(t.forward, *values)) for values in zip(across, back, strict=True)]
        )
        transposed = block[[0, 2, 1, 3]]
        i, j = self.pattern.ends
        loops = np.flatnonzero((i == j) & (i >= 0))  # edges within a hole's row
        for k, values in enumerate(block[:, loops] + transposed[:, loops]):
            diagonal[k] += self.pattern.row_sums(i[loops], values)
        return self.pattern.symmetric(block[:, self.pattern.pairs], diagonal)

    def laplacian(self) -> sparse.csc_array:
        """Lower triangle of L_s = sum_t s_t K_t, K_t the cotangent element matrix.

        With K_t for P_t, S would be diag(L, L) exactly: the two rows of a vertex are the parts
        of one complex number, the logarithm of an edge ratio, which is holomorphic in the
        triangle's shape. s_t = 2 sqrt(w0 w1 w2 / d) is the geometric mean of the two
        eigenvalue ratios of P_t and K_t.
        """
        scale = 2 * np.sqrt(self.w.prod(axis=0) / self.d)
        return self.pattern.laplacian(self.topology.sum_at_edges(self.cot * scale) / 2)

    def sliver_rows(self) -> IntArray:
        """Rows of the triangles in which P_t and s_t K_t differ by more than `SLIVER`."""
        w, c, d = self.w, self.cot, self.d
        # tr(K+ P) = (tr K tr P - tr K P) / (3/4), det = 4 w0 w1 w2 / d on the plane sum e = 0
        p = w - w**2 / d
        kp = 0.5 * ((c[NEXT] + c[PREV]) * p).sum(axis=0) + (c * w[NEXT] * w[PREV]).sum(axis=0) / d
        trace = (c.sum(axis=0) * p.sum(axis=0) - kp) / 0.75
        ratio = trace**2 * d / (4 * w.prod(axis=0)) - 2  # rho + 1 / rho
        rows = self._rows[:, ratio > SLIVER + 1 / SLIVER]
        return np.unique(rows[rows >= 0])


@dataclass(frozen=True)
class Step:
    """What one linear solve did.

    Attributes
    ----------
    kind : {"step", "chord"}
        Whether the system was taken at the angles before the step, or kept from the last one.
    inner_steps : int
        Conjugate gradient steps; 0 where the system was factored.
    limited : int
        Triangles whose step was cut short because all of it would have taken an angle to zero.
    residual : float
        Largest residual of the three constraint families after it.
    """

    kind: str
    inner_steps: int
    limited: int
    residual: float


class AngleSolver:
    """Angles on their way to a flat mesh.

    The pattern is analysed once; every step takes new values only.

    Parameters
    ----------
    topology : Topology
    alpha : (3, #F) float64
        Initial estimate.
    solvers : Solvers
    limit : bool
        Scale a triangle's step so that its angles stay positive (design, section 2); False is
        the paper's bare scheme.

    Attributes
    ----------
    alpha : (3, #F) float64
        The angles after the last step.
    residual : Residual
        What the constraints miss there.
    steps : list of Step
    laplacian : Factor
        Solves with Laplacians over `pattern`; the layout's is one of them.
    solver : str
        How the last system was solved.
    seconds : dict
        Time by stage.
    """

    def __init__(self, topology: Topology, alpha: FloatArray, solvers: Solvers, limit: bool = True) -> None:
        self.topology, self.alpha, self._limit, self._solvers = topology, alpha, limit, solvers
        self.steps: list[Step] = []
        self.solver = "none"
        self.seconds = {"assembly": 0.0, "analysis": 0.0, "factor": 0.0, "solve": 0.0}
        with self._timed("assembly"):
            self.residual: Residual = residual(topology, alpha)
            self.pattern = Pattern(topology.row[topology.edges.T], len(topology.target))
        self.laplacian: Factor | None = None
        self._whole: Factor | None = None
        self._corrector: Factor | None = None
        self._slivers: IntArray | None = None
        self._warned = False

    def step(self, rtol: float) -> None:
        """One linear step, the system taken at the present angles."""
        if len(self.topology.target):
            with self._timed("assembly"):
                self._system = System(self.topology, self.pattern, self.alpha)
                self._matrix = self._system.matrix()
                lower = self._system.laplacian()
            self._direct = False
            if self._solvers.direct:
                self._factor_whole()
            else:
                self._factor_laplacian(lower)
        self._advance("step", rtol)

    def chord(self, rtol: float) -> None:
        """Another step with the last system: nothing is assembled or factored."""
        self._advance("chord", rtol)

    @property
    def limited(self) -> bool:
        """Whether some triangle's step was cut short since the start."""
        return any(step.limited for step in self.steps)

    @property
    def invalid(self) -> NDArray[np.bool_]:
        """Triangles with an angle outside (0, pi), which only the bare scheme makes."""
        if self._limit:
            return np.zeros(self.alpha.shape[1], dtype=bool)
        return np.asarray(~((self.alpha > 0) & (self.alpha < np.pi)).all(axis=0))

    def _advance(self, kind: str, rtol: float) -> None:
        """Solve for the angle errors at the present residual, and add them."""
        inner = limited = 0
        if len(self.topology.target):  # else the estimate is flat: every vertex is on the boundary
            with self._timed("assembly"):
                missing, system = self.residual, self._system
                e0 = system.w * (missing.triangle / system.d)
                rhs = np.column_stack((missing.vertex, missing.wheel)) - system.rows(e0)
            with self._timed("solve"):
                x, inner = self._solve(rhs.ravel(), rtol)
            with self._timed("assembly"):
                e = e0 + system.error(x.reshape(-1, 2))
                if self._limit:
                    with np.errstate(divide="ignore"):
                        reach = np.where(e < 0, self.alpha / -e, np.inf).min(axis=0)
                    limited = int(np.count_nonzero(reach <= 1))
                    e *= np.minimum(REACH * reach, 1.0)
                self.alpha = self.alpha + e
                self.residual = residual(self.topology, self.alpha)
        self.steps.append(Step(kind, inner, limited, self.residual.largest))

    def _solve(self, rhs: FloatArray, rtol: float) -> tuple[FloatArray, int]:
        if not self._direct:
            x, inner, converged = conjugate_gradients(self._matrix, rhs, self._precondition, rtol)
            if converged:
                return x, inner
            self._fall_back(f"conjugate gradients did not converge within {CAP} steps")
        assert self._whole is not None
        return self._whole.solve(rhs), 0

    def _factor_laplacian(self, lower: sparse.csc_array) -> None:
        """Factor L_s, and make the preconditioner of it."""
        with self._timed("analysis"):
            if self.laplacian is None:
                self.laplacian = self._solvers.laplacian(lower)
        try:
            with self._timed("factor"):
                self.laplacian.factor(lower)
                self._precondition = self._preconditioner(self.laplacian)
        except NotPositiveDefiniteError:
            self._fall_back("the preconditioner is singular in double precision")
        else:
            self.solver = f"conjugate gradients, {self.laplacian.name}"

    def _preconditioner(self, laplacian: Factor) -> Callable[[FloatArray], FloatArray]:
        """diag(L_s, L_s)^-1, and S^-1 on the rows of slivers before and after it (Schwarz)."""

        def scalar(r: FloatArray) -> FloatArray:
            return laplacian.precondition(r.reshape(-1, 2)).ravel()

        if self._slivers is None:
            rows = self._system.sliver_rows()
            self._slivers = np.sort(np.concatenate((2 * rows, 2 * rows + 1)))
        slivers = self._slivers
        if not len(slivers):
            return scalar
        beside = self._matrix[slivers]  # S is symmetric: its columns as well as its rows
        local = sparse.tril(beside[:, slivers]).tocsc()
        if self._corrector is None:
            self._corrector = self._solvers.whole(local)
        corrector = self._corrector
        corrector.factor(local)

        def corrected(r: FloatArray) -> FloatArray:
            first = corrector.solve(r[slivers])
            z = scalar(r - beside.T @ first)
            z[slivers] += first
            z[slivers] += corrector.solve(r[slivers] - beside @ z)
            return z

        return corrected

    def _fall_back(self, reason: str) -> None:
        if not self._warned:
            self._warned = True
            warnings.warn(
                f"{reason}: the whole system is factored", FallbackWarning, stacklevel=stack_level()
            )
        self._factor_whole()
        self.solver += f", after {reason}"

    def _factor_whole(self) -> None:
        with self._timed("analysis"):
            lower = sparse.tril(self._matrix).tocsc()
            if self._whole is None:
                self._whole = self._solvers.whole(lower)
        try:
            with self._timed("factor"):
                self._whole.factor(lower)
        except NotPositiveDefiniteError as error:
            fan = np.flatnonzero(self.topology.row == error.row // 2)
            angles = self.alpha[np.isin(self.topology.corner, fan)]
            raise MeshError(
                f"the angle system is singular in double precision at vertices {some(fan)}, with angles "
                f"{some(angles)} rad: remove the degenerate faces there, or cut the mesh"
            ) from None
        self._direct = True
        self.solver = f"direct, {self._whole.name}"

    @contextmanager
    def _timed(self, stage: str) -> Iterator[None]:
        start = perf_counter()
        yield
        self.seconds[stage] += perf_counter() - start
