"""Predict holonomy angles, which are the turnings of closed paths, and the cost of changing them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..._runtime import time_stage
from ..._types import FloatArray, IntArray
from ..system import ClosedPath, HolonomyConstraints, System
from .iterates import AngleProblem, Iterate
from .linearisation import Linearisation

HOLONOMY_ROUNDING = 1e-10  # lower bound of eigenvalues, relative to the largest matrix entry


@dataclass(frozen=True, eq=False)
class HolonomyAngles:
    """First-order prediction of the turning of closed paths at angles that satisfy the constraints.

    In the metric of the cotangent matrices K, M K M^T is diag(L, L). Let T be the rows of the paths, B = M K
    T^T, D = T K T^T and C = diag(L, L)^-1 B. The residual r of the constraints changes the scale and the
    turning along the paths by C^T r. A change s of scale and turning requires errors e with e^T K^-1 e = s^T
    (D - B^T C)^-1 s. A change of turning is cheap if the scale may also change. If the scale is fixed, the
    conformal structure has to change, and therefore all triangles change.

    Attributes
    ----------
    angle : (#paths,) float64
        The predicted turning of each path, radians.
    by_vertex : (#C, #paths) float64
        Derivative of the turning with respect to the angle sums of some vertices.
    cost : (#paths, #paths) float64
        A change c of the turnings adds about c^T cost c to F/3nt, the mean squared relative change of the
        angles.
    """

    angle: FloatArray
    by_vertex: FloatArray
    cost: FloatArray

    @classmethod
    def predict(
        cls, problem: AngleProblem, vertices: IntArray, surface: FloatArray, known: Linearisation | None
    ) -> tuple[HolonomyAngles, Linearisation]:
        """Predict the turnings of closed paths, given the angles of the surface, (3, #F).

        Also return a system whose factor can precondition the first step. If `known`, a system at the same
        angles, has a factor, it is reused.

        Raises
        ------
        NotPositiveDefiniteError
            The Laplacian is singular in double precision.
        """
        asked = problem.constraints
        turning = replace(problem, constraints=asked.replace_targets(turnings=np.zeros(len(asked.paths))))
        with time_stage("assembly"):
            at = turning.evaluate(surface)
            system = System(turning.constraints, at.alpha, cot=at.cot, scaled=False)
            holonomy = HolonomyConstraints(system, at.residual.holonomy, conformal=True)
        laplacian, inverse = (None, None) if known is None else (known.laplacian, known.inverse)
        if laplacian is None or inverse is None:
            lower = system.build_laplacian()
            with time_stage("analysis"):
                laplacian = asked.pattern.get_analysis(problem.solvers)
            with time_stage("factor"):
                inverse = laplacian.factor(lower.data)
        with time_stage("factor"):
            columns = holonomy.solve_conformal_columns(inverse.solve)
            schur = columns.schur
            b, rows = at.residual, asked.row[vertices]
            change = columns.multiply_transposed(np.column_stack((b.vertex, b.wheel)).ravel())
            gap = holonomy.rows.compute_residuals(b.holonomy, b.vertex) + change
            scale, turn = slice(0, None, 2), slice(1, None, 2)
            # if the scale is free: how much it changes along paths if the turning changes by 1
            closed = np.linalg.solve(schur[scale, scale], schur[scale, turn])
            size, axes = np.linalg.eigh(schur[turn, turn] - schur[turn, scale] @ closed)
            norm = (axes / np.maximum(size, HOLONOMY_ROUNDING * np.abs(schur).max())) @ axes.T
            by_vertex = np.where(rows[:, None] >= 0, columns.select_vertex_rows(rows)[:, turn], 0.0)
        # in an equilateral triangle, K is sqrt(3) / 2 times the identity on angles that sum to zero
        share = np.sqrt(3) / 2 * np.mean(1 / at.alpha**2) / at.alpha.size
        lin = Linearisation.from_factor(problem, system, laplacian, inverse, columns)
        return cls(gap[turn] - gap[scale] @ closed, by_vertex, share * norm), lin

    @classmethod
    def measure(cls, at: Iterate, paths: Sequence[ClosedPath], vertices: IntArray) -> HolonomyAngles:
        """Measure the turnings of closed paths at angles that nearly satisfy the constraints."""
        alpha, number = at.alpha.ravel(), len(paths)
        turned = np.array([path.size * np.pi - alpha[path.corner].sum() for path in paths])
        return cls(turned, np.zeros((len(vertices), number)), np.eye(number))
