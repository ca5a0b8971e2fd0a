"""Steps of linear ABF: solve the angle system, add the errors, keep every triangle a triangle."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter
from typing import Literal

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from .._runtime import advance
from ..errors import FallbackWarning, MeshError, some, stack_level
from ..linalg import (
    MAX_CG_STEPS,
    Factor,
    NotPositiveDefiniteError,
    Pattern,
    Rows,
    Solvers,
    conjugate_gradients,
)
from ..surface import BoolArray, FloatArray, IntArray, Topology
from .closure import Border
from .constraints import Residual, residual
from .reduced import System

REACH = 0.7  # share of the way to a vanishing angle that a triangle's step may go

Kind = Literal["step", "chord", "anchored", "feasible", "restoration"]


@dataclass(frozen=True)
class Step:
    """What one linear solve did.

    Attributes
    ----------
    kind : str
        "step": the system was taken at the angles before it, which also weigh the errors; "chord":
        kept from the last step; "anchored", "feasible" and "restoration": converged ABF's.
    inner_steps : int
        Conjugate gradient steps; 0 where the system was factored.
    limited : int
        Triangles whose step was cut short because all of it would have taken an angle to zero.
    residual : float
        Largest residual of the three constraint families after it.
    """

    kind: Kind
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
        The present angles.
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
            self.pattern = Pattern(topology, topology.row, len(topology.target))
        self.laplacian: Factor | None = None
        self._whole: Factor | None = None
        self._corrector: Factor | None = None
        self._slivers: IntArray | None = None
        self._rows: Rows | None = None
        self._warned = False

    def step(self, rtol: float) -> None:
        """One linear step, the system taken at the present angles.

        From the second one on it closes the holes' loops, too; the first one makes them turn once
        and end at the scale at which they begin.
        """
        self.take_system(close=bool(self.steps))
        self.move("step", *self.direction(rtol)[:2])

    def chord(self, rtol: float) -> None:
        """Another step with the last system: nothing is assembled or factored."""
        self.move("chord", *self.direction(rtol)[:2])

    @property
    def limited(self) -> bool:
        """Whether some triangle's step was cut short since the start."""
        return any(step.limited for step in self.steps)

    @property
    def invalid(self) -> BoolArray:
        """Triangles with an angle outside (0, pi), which only the bare scheme makes."""
        if self._limit:
            return np.zeros(self.alpha.shape[1], dtype=bool)
        return np.asarray(~((self.alpha > 0) & (self.alpha < np.pi)).all(axis=0))

    def take_system(
        self,
        w: FloatArray | None = None,
        keep_factor: bool = False,
        keep_slivers: bool = True,
        close: bool = True,
    ) -> None:
        """Take the system at the present angles, with weights `w`, and prepare to solve it.

        `keep_factor` goes on with the last Laplacian's factor; `keep_slivers` with the rows that
        are corrected for, and the analysis of their small system; `close` has the rows in it that
        close the holes' loops.
        """
        if not len(self.topology.target):
            return  # every vertex is on the boundary: the estimate is flat
        with self._timed("assembly"):
            self.system = System(self.topology, self.pattern, self.alpha, w)
            self._matrix = self.system.matrix()
            closure = self.residual.closure
            self._border = Border(self.system, closure) if close and len(closure.gap) else None
        if not keep_slivers:
            self._slivers = self._rows = self._corrector = None
        self._direct = False
        if self._solvers.direct:
            self._factor_whole()
        else:
            self._prepare(keep_factor)

    def direction(
        self, rtol: float, gradient: FloatArray | None = None, start: FloatArray | None = None
    ) -> tuple[FloatArray, int, FloatArray]:
        """Solve for the errors p that the linearised constraints ask for at the present residual.

        They minimise sum p^2 / (2 w) + gradient p. Returns p, (3, #F), the inner steps, and the
        multipliers; conjugate gradients begin at those of `start`, and reduce what is missing there.
        """
        if not len(self.topology.target):
            return np.zeros_like(self.alpha), 0, np.empty(0)
        missing, system = self.residual, self.system
        with self._timed("assembly"):
            free = system.w * (missing.triangle / system.d)
            if gradient is not None:
                free = free - system.projected(gradient)
            rhs = (np.column_stack((missing.vertex, missing.wheel)) - system.rows(free)).ravel()
            if self._border is not None:
                gap = missing.closure.gap
                rhs = np.concatenate(
                    (rhs, -np.column_stack((gap.real, gap.imag)).ravel() - self._border.rows(free))
                )
            if start is not None:
                start = np.append(start, np.zeros(len(rhs) - len(start)))  # where the border is new
                rhs -= self._product(start)
        with self._timed("solve"):
            multipliers, inner = self._solve(rhs, rtol)
        with self._timed("assembly"):
            if start is not None:
                multipliers = start + multipliers
            p = free + system.projected(system.at_corners(self.at_vertices(multipliers)))
            return p, inner, multipliers

    def at_vertices(self, multipliers: FloatArray) -> FloatArray:
        """Multipliers of the vertex and the wheel row of each single vertex, (#V, 2)."""
        n = 2 * len(self.topology.target)
        x = self.system.at_vertices(multipliers[:n].reshape(-1, 2))
        return x if self._border is None else x + self._border.at_vertices(multipliers[n:])

    def move(self, kind: Kind, p: FloatArray, inner: int) -> None:
        """Add the errors, in each triangle as much of them as keeps its angles positive."""
        limited = 0
        with self._timed("assembly"):
            if self._limit:
                reach = self.reach(p)
                limited = int(np.count_nonzero(reach <= 1))
                p = p * np.minimum(REACH * reach, 1.0)
            self.alpha = self.alpha + p
            self.residual = residual(self.topology, self.alpha)
        self.steps.append(Step(kind, inner, limited, self.residual.largest))
        advance(kind, 0.2)

    def place(self, alpha: FloatArray, kind: Kind | None = None, inner: int = 0) -> None:
        """Go to given angles; with a `kind`, as a step."""
        self.alpha = alpha
        self.residual = residual(self.topology, alpha)
        if kind is not None:
            self.steps.append(Step(kind, inner, 0, self.residual.largest))
            advance(kind, 0.05)

    def reach(self, p: FloatArray) -> FloatArray:
        """How many times each triangle could take its errors before an angle vanishes, (#F,)."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.where(p < 0, self.alpha / -p, np.inf).min(axis=0))

    def _product(self, x: FloatArray) -> FloatArray:
        """The system's matrix times x."""
        S = self._matrix.matvec
        return S(x) if self._border is None else self._border.matvec(S, x)

    def _solve(self, rhs: FloatArray, rtol: float) -> tuple[FloatArray, int]:
        if not self._direct:
            matrix = linalg.LinearOperator((len(rhs),) * 2, matvec=self._product, dtype=np.float64)
            x, inner, converged = conjugate_gradients(matrix, rhs, self._precondition, rtol)
            if converged:
                return x, inner
            self._fall_back(f"conjugate gradients did not converge within {MAX_CG_STEPS} steps")
        assert self._whole is not None
        solve: Callable[[FloatArray], FloatArray] = self._whole.solve
        if self._border is not None:
            try:
                solve = self._border.solver(self._whole.solve)
            except NotPositiveDefiniteError:
                at_holes = np.isin(np.arange(self.topology.n), np.concatenate(self.topology.loops[1:]))
                raise self._singular(at_holes) from None
        return solve(rhs), 0

    def _prepare(self, keep_factor: bool) -> None:
        """Factor L_s, and make the preconditioner of it."""
        try:
            # the border's Schur complement needs the Laplacian of these very angles
            if self.laplacian is None or not keep_factor or self._border is not None:
                with self._timed("assembly"):
                    lower = self.system.laplacian()
                with self._timed("analysis"):
                    if self.laplacian is None:
                        self.laplacian = self._solvers.laplacian(lower)
                with self._timed("factor"):
                    self.laplacian.factor(lower)
            with self._timed("factor"):
                self._precondition = self._preconditioner(self.laplacian)
        except NotPositiveDefiniteError:
            self._fall_back("the preconditioner is singular in double precision")
        else:
            self.solver = f"conjugate gradients, {self.laplacian.name}"

    def _preconditioner(self, laplacian: Factor) -> Callable[[FloatArray], FloatArray]:
        """diag(L_s, L_s)^-1, bordered, and S^-1 on the rows of slivers before and after it (Schwarz)."""

        def scalar(r: FloatArray) -> FloatArray:
            pairs = r.reshape(len(r) // 2, -1)  # the two rows of a vertex, for each right-hand side
            return laplacian.precondition(pairs).reshape(r.shape)

        border = self._border
        conformal: Callable[[FloatArray], FloatArray] = scalar
        if border is not None:
            conformal = border.preconditioner(self.system, scalar)
        if self._slivers is None:
            rows = self.system.sliver_rows()
            self._slivers = np.sort(np.concatenate((2 * rows, 2 * rows + 1)))
        slivers = self._slivers
        if not len(slivers):
            return conformal
        if self._rows is None:
            self._rows = Rows(self._matrix, slivers)
        beside = self._rows.of(self._matrix)  # S is symmetric: its columns as well
        local = self._rows.lower(self._matrix)
        if border is not None:
            beside = sparse.hstack((beside, border.beside[slivers])).tocsr()
        if self._corrector is None:
            self._corrector = self._solvers.whole(local)
        corrector = self._corrector
        corrector.factor(local)

        def corrected(r: FloatArray) -> FloatArray:
            first = corrector.solve(r[slivers])
            z = conformal(r - beside.T @ first)
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
            lower = self._matrix.lower()
            if self._whole is None:
                self._whole = self._solvers.whole(lower)
        try:
            with self._timed("factor"):
                self._whole.factor(lower)
        except NotPositiveDefiniteError as error:
            raise self._singular(self.topology.row == error.row // 2) from None
        self._direct = True
        self.solver = f"direct, {self._whole.name}"

    def _singular(self, vertices: BoolArray) -> MeshError:
        """What is said where the rows of some vertices cannot be told apart in double precision."""
        faces = np.flatnonzero(vertices[self.topology.corner].any(axis=0))
        thin = faces[np.argsort(self.alpha[:, faces].min(axis=0), kind="stable")]
        return MeshError(
            f"the angle system is singular in double precision at faces {some(thin)} (the thinnest has an "
            f"angle of {self.alpha[:, thin[0]].min():.1e} rad): remove the degenerate ones, or cut the mesh"
        )

    @contextmanager
    def _timed(self, stage: str) -> Iterator[None]:
        start = perf_counter()
        yield
        self.seconds[stage] += perf_counter() - start
