"""Define the problem of finding the angles of a flat mesh, its iterates, and the steps between iterates."""

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
class DiskRanges:
    """The rows and faces of each disk in a linear system of one or several disks.

    Attributes
    ----------
    rows, faces : Ragged
        Rows and faces of each disk.
    """

    rows: Ragged
    faces: Ragged

    @classmethod
    def from_disks(cls, constraints: Constraints, disks: Disks) -> DiskRanges:
        """Return the rows and faces of several disks; there is a row for each interior vertex, in order."""
        before = np.concatenate(([0], np.cumsum(disks.topology.is_interior)))
        return cls(Ragged(before[disks.vertices.start]), disks.faces)

    def residuals(self, b: Residual) -> FloatArray:
        """Return the largest vertex, triangle and wheel residual of each disk, (3, #disks)."""
        vertex, wheel = self.rows.max(np.abs(b.vertex)), self.rows.max(np.abs(b.wheel))
        return np.stack((vertex, self.faces.max(np.abs(b.triangle)), wheel))


@dataclass(frozen=True, eq=False)
class AngleProblem:
    """The problem of finding the angles of a flat mesh near an initial estimate.

    Attributes
    ----------
    constraints : Constraints
    estimate : (3, #F) float64
        The initial estimate alpha_0, radians.
    solvers : Solvers
    safeguard : bool
        Whether the step of each triangle is limited so that its angles stay positive; False is the unmodified
        scheme of the paper.
    side_by_side : DiskRanges or None
        The disks, if there are several. Each disk has its own steps, and its own number of iterations of the
        linear solver.
    """

    constraints: Constraints
    estimate: FloatArray
    solvers: Solvers
    safeguard: bool = True
    side_by_side: DiskRanges | None = None

    @cached_property
    def disks(self) -> DiskRanges:
        """The blocks of all disks of the problem, or of its only disk."""
        if self.side_by_side is not None:
            return self.side_by_side
        m = self.constraints.topology.corner.shape[1]
        return DiskRanges(Ragged(np.array([0, self.constraints.n_rows])), Ragged(np.array([0, m])))

    @cached_property
    def initial_iterate(self) -> Iterate:
        """The `Iterate` of the initial estimate."""
        return self.evaluate(self.estimate)

    def evaluate(self, alpha: FloatArray) -> Iterate:
        """Return the angles, (3, #F) radians, together with their residuals and cotangents."""
        return Iterate.from_angles(self.constraints, alpha)

    def mask_invalid_triangles(self, at: Iterate) -> BoolArray:
        """Return a mask, (#F,), of triangles with an angle outside (0, pi); all False with the safeguard."""
        if self.safeguard:
            return np.zeros(at.alpha.shape[1], dtype=bool)
        return np.asarray(~((at.alpha > 0) & (at.alpha < np.pi)).all(axis=0))


@dataclass(frozen=True, eq=False)
class Iterate:
    """The current angles, (3, #F) radians, with their cotangents and residuals."""

    alpha: FloatArray
    cot: FloatArray
    residual: Residual

    @classmethod
    def from_angles(cls, constraints: Constraints, alpha: FloatArray) -> Iterate:
        cot = _core.cotangents(alpha)
        return cls(alpha, cot, residual(constraints, alpha, cot))


@dataclass(frozen=True)
class Step:
    """A linear solve and the step along its solution.

    Attributes
    ----------
    kind : str
        "step": the system and the weights belong to the angles before the step. "chord": the system of the
        previous step is reused, as in a simplified Newton step. "conformal": a correction in the conformal
        metric. "anchored", "feasible", "restoration": steps of converged ABF.
    inner_steps : int
        Conjugate gradient steps; 0 if the system was factored.
    limited : int
        Number of triangles whose step was limited because the full step would have made an angle zero or
        negative.
    residual : float
        Largest residual of the constraints after the step.
    """

    kind: Kind
    inner_steps: int
    limited: int
    residual: float
