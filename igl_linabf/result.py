"""What a flattening returns: the map, how it came about, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from .angles import Residual
from .linabf import Step
from .topology import FloatArray, IntArray


class Outcome(str, Enum):
    """How a flattening ended."""

    CONVERGED = "converged"
    """No triangle is flipped and the angles fit together to the tolerance."""
    VALID = "valid"
    """No triangle is flipped; the angles' residual is above the tolerance, as was asked for."""
    NOT_CONVERGED = "not converged"
    """No triangle is flipped, but the iterations ended above the tolerance."""
    FLIPPED = "flipped"
    """Some triangles are flipped or collapsed."""
    ANGLES_INVALID = "angles invalid"
    """Some target angles left (0, pi), which only the bare scheme allows."""

    @property
    def good(self) -> bool:
        """Whether the map has no flipped triangle."""
        return self in (Outcome.CONVERGED, Outcome.VALID, Outcome.NOT_CONVERGED)


@dataclass(frozen=True)
class Residuals:
    """Largest absolute residual of each constraint family.

    Attributes
    ----------
    vertex : float
        |2 pi - sum of the angles| around interior vertices, radians (eq. 5).
    triangle : float
        |pi - sum of the angles| in triangles, radians (eq. 6).
    wheel : float
        |sum log sin(gamma) - log sin(beta)| around interior vertices (eq. 10).
    """

    vertex: float
    triangle: float
    wheel: float

    @classmethod
    def of(cls, missing: Residual) -> Residuals:
        families = (missing.vertex, missing.triangle, missing.wheel)
        return cls(*(float(np.abs(r).max(initial=0.0)) for r in families))

    @property
    def largest(self) -> float:
        return max(self.vertex, self.triangle, self.wheel)


@dataclass(frozen=True, eq=False)
class Flattening:
    """A flat map and how it came about.

    Attributes
    ----------
    uv : (#V, 2) float64
        The map; NaN at vertices that no face refers to.
    angles : (#F, 3) float64
        Target angles in radians, from which the map was laid out.
    method : str
    outcome : Outcome
    message : str
        The outcome in a sentence: what is wrong, where, and what helps.
    flipped : (#flips,) int64
        Faces that are flipped or collapsed in the map.
    steps : tuple of Step
        The linear solves, in order.
    before, after : Residuals
        Constraint residuals of the initial estimate and of `angles`.
    gap : float
        By how much the boundary that `angles` draw fails to close, relative to its length.
    layout : {"boundary", "least-squares", "greedy"}
        The layout that ran.
    solver, layout_solver : str
        What solved the angle systems, and the layout's.
    seconds : dict of str to float
        Time by stage, and "total".
    """

    uv: FloatArray
    angles: FloatArray
    method: str
    outcome: Outcome
    message: str
    flipped: IntArray
    steps: tuple[Step, ...]
    before: Residuals
    after: Residuals
    gap: float
    layout: str
    solver: str
    layout_solver: str
    seconds: dict[str, float]

    @property
    def iterations(self) -> int:
        """Number of linear solves, chord steps included, and restoring ones not."""
        return sum(step.kind != "restoration" for step in self.steps)

    @property
    def inner_steps(self) -> int:
        """Conjugate gradient steps in all of them."""
        return sum(step.inner_steps for step in self.steps)

    @property
    def _kinds(self) -> list[str]:
        return list(dict.fromkeys(step.kind for step in self.steps))

    def __str__(self) -> str:
        runs = {kind: [s.inner_steps for s in self.steps if s.kind == kind] for kind in self._kinds}
        kinds = ", ".join(f"{len(inner)} {kind} ({sum(inner)})" for kind, inner in runs.items())
        rows = {
            "method": self.method,
            "outcome": f"{self.outcome.value}: {self.message}",
            "solves (inner steps)": kinds or "none needed",
            "angle residual": f"{self.before.largest:.2e} -> {self.after.largest:.2e}",
            "boundary gap": f"{self.gap:.2e}",
            "solver": self.solver,
            "layout": f"{self.layout} ({self.layout_solver})",
            "seconds": f"{self.seconds['total']:.3f}",
        }
        width = max(map(len, rows))
        return "\n".join(f"{name:<{width}}  {value}" for name, value in rows.items())
