"""Holonomy angles: what closed paths turn by, predicted to first order, and what other turnings cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..._runtime import timed
from ..._types import FloatArray, IntArray
from ..system import ClosedPath, HolonomyConstraints, System
from .constants import HOLONOMY_ROUNDING
from .iterates import AngleProblem, Iterate
from .linearisation import Linearised


@dataclass(frozen=True, eq=False)
class HolonomyAngles:
    """What the closed paths of a surface turn by once its constraints hold, to first order.

    In the metric of the cotangent matrices K, M K M^T is diag(L, L). With C = diag(L, L)^-1 B for the paths'
    rows T, the residual r of the constraints changes scale and turning along the paths by C^T r. A change of
    both by s takes errors e with e^T K^-1 e = s^T (D - B^T C)^-1 s. Another turning is cheap where the scale
    may change with it. Where it may not, it takes another conformal structure, and all triangles change.

    Attributes
    ----------
    angle : (#paths,) float64
        Radians.
    by_vertex : (#C, #paths) float64
        The change by one radian more of the angle sum at some vertices.
    cost : (#paths, #paths) float64
        Turnings that change by c add about c^T cost c to F/3nt.
    """

    angle: FloatArray
    by_vertex: FloatArray
    cost: FloatArray

    @classmethod
    def predicted(
        cls, problem: AngleProblem, vertices: IntArray, surface: FloatArray, known: Linearised | None
    ) -> tuple[HolonomyAngles, Linearised]:
        """At the angles of the surface, (3, #F); and a system whose factor preconditions the first step, too.

        Its factor and its columns C are those of `known`, a system at these angles, if that has them.

        Raises
        ------
        NotPositiveDefiniteError
            The Laplacian is singular in double precision.
        """
        asked = problem.constraints
        turning = replace(problem, constraints=asked.with_prescribed(turnings=np.zeros(len(asked.paths))))
        with timed("assembly"):
            at = turning.at(surface)
            system = System(turning.constraints, at.alpha, cot=at.cot, scaled=False)
            holonomy = HolonomyConstraints(system, at.residual.holonomy, conformal=True)
        laplacian, inverse = (None, None) if known is None else (known.laplacian, known.inverse)
        if laplacian is None or inverse is None:
            lower = system.laplacian()
            with timed("analysis"):
                laplacian = asked.pattern.analysis(problem.solvers)
            with timed("factor"):
                inverse = laplacian.factor(lower.data)
        with timed("factor"):
            columns = None if known is None else known.columns
            if columns is None:
                columns = holonomy.conformal_columns(inverse.solve)
            schur = columns.schur
            b, rows = at.residual, asked.row[vertices]
            change = columns.transposed_times(np.column_stack((b.vertex, b.wheel)).ravel())
            gap = holonomy.rows.gap(b.holonomy, b.vertex) + change
            scale, turn = slice(0, None, 2), slice(1, None, 2)
            closed = np.linalg.solve(schur[scale, scale], schur[scale, turn])  # turning as the scale closes
            size, axes = np.linalg.eigh(schur[turn, turn] - schur[turn, scale] @ closed)
            norm = (axes / np.maximum(size, HOLONOMY_ROUNDING * np.abs(schur).max())) @ axes.T
            by_vertex = np.where(rows[:, None] >= 0, columns.vertex_rows(rows)[:, turn], 0.0)
        # in an equilateral triangle K is sqrt(3) / 2 on angles that sum to zero
        share = np.sqrt(3) / 2 * np.mean(1 / at.alpha**2) / at.alpha.size
        lin = Linearised.preconditioned(problem, system, laplacian, inverse, columns)
        return cls(gap[turn] - gap[scale] @ closed, by_vertex, share * norm), lin

    @classmethod
    def measured(cls, at: Iterate, paths: Sequence[ClosedPath], vertices: IntArray) -> HolonomyAngles:
        """At angles that nearly satisfy the constraints. Nothing is known of how they change."""
        alpha, number = at.alpha.ravel(), len(paths)
        turned = np.array([path.size * np.pi - alpha[path.corner].sum() for path in paths])
        return cls(turned, np.zeros((len(vertices), number)), np.eye(number))
