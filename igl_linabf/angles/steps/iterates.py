"""The problem in angles, where an iteration stands, and how far a step may go."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from ... import _core
from ..._types import BoolArray, FloatArray
from ...linalg import Solvers
from ...surface import Disks, Ragged
from ..system import Constraints, Residual, residual

Kind = Literal["step", "chord", "conformal", "anchored", "feasible", "restoration"]


@dataclass(frozen=True, eq=False)
class DiskBlocks:
    """The disks of a problem side by side, or its only one.

    Attributes
    ----------
    rows, faces : Ragged
        Those of each disk.
    """

    rows: Ragged
    faces: Ragged

    @classmethod
    def of(cls, constraints: Constraints, disks: Disks) -> DiskBlocks:
        """Disks side by side: rows are those of interior vertices, which come in their order."""
        before = np.concatenate(([0], np.cumsum(disks.topology.interior)))
        return cls(Ragged(before[disks.vertices.start]), disks.faces)

    def residuals(self, b: Residual) -> FloatArray:
        """The largest absolute residual of each disk: of vertices, triangles and wheels, (3, #disks)."""
        vertex, wheel = self.rows.max(np.abs(b.vertex)), self.rows.max(np.abs(b.wheel))
        return np.stack((vertex, self.faces.max(np.abs(b.triangle)), wheel))


@dataclass(frozen=True, eq=False)
class AngleProblem:
    """The problem: find the angles of a flat mesh near an initial estimate.

    Attributes
    ----------
    constraints : Constraints
    estimate : (3, #F) float64
        The initial estimate alpha_0, radians.
    solvers : Solvers
    safeguard : bool
        Limit each triangle's step so that its angles stay positive; False is the paper's bare scheme.
    side_by_side : Blocks or None
        Several disks, whose linear systems have steps and ends of their own.
    """

    constraints: Constraints
    estimate: FloatArray
    solvers: Solvers
    safeguard: bool = True
    side_by_side: DiskBlocks | None = None

    @cached_property
    def disks(self) -> DiskBlocks:
        """Those side by side, or the only one."""
        if self.side_by_side is not None:
            return self.side_by_side
        m = self.constraints.topology.corner.shape[1]
        return DiskBlocks(Ragged(np.array([0, self.constraints.n])), Ragged(np.array([0, m])))

    @cached_property
    def start(self) -> Iterate:
        """The initial estimate."""
        return self.at(self.estimate)

    def at(self, alpha: FloatArray) -> Iterate:
        """The iterate at given angles, (3, #F) radians."""
        return Iterate.of(self.constraints, alpha)

    def invalid(self, at: Iterate) -> BoolArray:
        """(#F,) bool: triangles with an angle outside (0, pi); none with the safeguard."""
        if self.safeguard:
            return np.zeros(at.alpha.shape[1], dtype=bool)
        return np.asarray(~((at.alpha > 0) & (at.alpha < np.pi)).all(axis=0))


@dataclass(frozen=True, eq=False)
class Iterate:
    """Present angles, (3, #F) radians, their cotangents, and their residuals."""

    alpha: FloatArray
    cot: FloatArray
    residual: Residual

    @classmethod
    def of(cls, constraints: Constraints, alpha: FloatArray) -> Iterate:
        cot = _core.cotangents(alpha)
        return cls(alpha, cot, residual(constraints, alpha, cot))


@dataclass(frozen=True)
class Step:
    """One linear solve, and the step along its solution.

    Attributes
    ----------
    kind : str
        "step": the system and the weights are those of the angles before the step. "chord": the
        system of the last step, as in a simplified Newton step. "conformal": a correction in the conformal
        metric. "anchored", "feasible", "restoration": steps of converged ABF.
    inner_steps : int
        Conjugate gradient steps; 0 if the system was factored.
    limited : int
        Triangles whose step was limited because the full step would have made an angle zero or
        negative.
    residual : float
        Largest residual of the constraints after the step.
    """

    kind: Kind
    inner_steps: int
    limited: int
    residual: float
