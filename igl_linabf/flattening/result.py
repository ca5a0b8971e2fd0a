"""What a flattening returns: the map, how it came about, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Literal

import numpy as np

from .._types import FloatArray, IntArray
from ..angles import Constraints, Residual, Step
from ..errors import some
from ..surface import Mesh

Guarantee = Literal["injective"]
RungName = Literal["linear step", "active set", "converged ABF", "feasible ABF", "injective"]


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
        """Whether the map has no flipped triangle, and its target angles are those of triangles."""
        return self in (Outcome.CONVERGED, Outcome.VALID, Outcome.NOT_CONVERGED)


@dataclass(frozen=True)
class Residuals:
    """Largest absolute residual of each constraint family.

    Attributes
    ----------
    vertex : float
        `|2 pi - sum of the angles|` around interior vertices, radians (eq. 5).
    triangle : float
        `|pi - sum of the angles|` in triangles, radians (eq. 6).
    wheel : float
        `|sum log sin(gamma) - log sin(beta)|` around interior vertices (eq. 10).
    closure : float
        Distance by which a hole's loop fails to close, over its length; 0 without holes. The
        angles and the wheel around a hole as a whole count as those of one more interior vertex.
    """

    vertex: float
    triangle: float
    wheel: float
    closure: float

    @classmethod
    def of(cls, b: Residual) -> Residuals:
        families = (b.vertex, b.triangle, b.wheel, b.closure.gap)
        return cls(*(float(np.abs(r).max(initial=0.0)) for r in families))

    @property
    def largest(self) -> float:
        return max(self.vertex, self.triangle, self.wheel, self.closure)


class Status(Enum):
    """What came of one rung of the ladder."""

    GOOD = "a map without flipped triangles"
    FLIPPED = "a map with flipped triangles"
    OPEN_LOOP = "the target angles draw a boundary loop that does not close"
    CUT_SHORT = "the full step would take some angles to zero"
    DIVERGED = "the angles do not converge"
    NO_VALID_START = "no map without flipped triangles was found to start from"


@dataclass(frozen=True)
class Rung:
    """One rung of the ladder: what was tried, and why it was not enough.

    Attributes
    ----------
    name : {"linear step", "active set", "converged ABF", "feasible ABF", "injective"}
    status : Status
    flips : int or None
        Flipped triangles of its map; None where the stage ended before its layout.
    residual : float
        Largest residual of its angles.
    failed : str
        The status in words; "" where it is good.
    """

    name: RungName
    status: Status
    flips: int | None
    residual: float
    failed: str

    def __str__(self) -> str:
        return f"{self.name} ({self.failed or 'no flips'})"


@dataclass(frozen=True)
class Hole:
    """What the target angles miss around one hole.

    Attributes
    ----------
    vertex : int
        A vertex of its boundary loop.
    size : int
        The loop's number of vertices.
    rotation : float
        `|(m + 2) pi - sum of the angles at its m vertices|`, radians: the loop turns once.
    scale : float
        `|sum log sin(gamma) - log sin(beta)|` over them: it ends at the length at which it began.
    translation : float
        Distance from its end to its beginning, over its length.
    """

    vertex: int
    size: int
    rotation: float
    scale: float
    translation: float

    @property
    def largest(self) -> float:
        return max(self.rotation, self.scale, self.translation)

    @classmethod
    def all_of(cls, mesh: Mesh, constraints: Constraints, b: Residual) -> tuple[Hole, ...]:
        """Every hole of the mesh, the residual of the angles being `b`."""
        loops = mesh.topology.holes
        row = [constraints.row[loop[0]] for loop in loops]
        parts = (b.vertex[row], b.wheel[row], b.closure.gap)
        return tuple(
            cls(int(mesh.vertices[loop[0]]), len(loop), *(float(abs(part[i])) for part in parts))
            for i, loop in enumerate(loops)
        )


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
    repaired : (#caps,) int64
        Faces with an angle so near pi that another one was flattened in their stead.
    ladder : tuple of Rung
        What was tried, the next one only when the one before had failed; the last one that made a
        map without flipped triangles, or else the one with the fewest, made this one.
    steps : tuple of Step
        The linear solves, in order.
    before, after : Residuals
        Constraint residuals of the initial estimate and of `angles`.
    holes : tuple of Hole
        The closure residuals of `angles` around each hole; the outer loop is none of them.
    gap : float
        By how much the boundary that `angles` draw fails to close, relative to its length.
    layout : {"boundary", "least-squares", "greedy", "SLIM"}
        The layout that ran; after "SLIM" `angles` are the map's own.
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
    repaired: IntArray
    ladder: tuple[Rung, ...]
    steps: tuple[Step, ...]
    before: Residuals
    after: Residuals
    holes: tuple[Hole, ...]
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
            "tried": ", then ".join(map(str, self.ladder)) or self.method,
            "solves (inner steps)": kinds or "none needed",
            "angle residual": f"{self.before.largest:.2e} -> {self.after.largest:.2e}",
            "boundary gap": f"{self.gap:.2e}",
            "holes' closure": ", ".join(f"{hole.largest:.1e}" for hole in self.holes) or "no holes",
            "solver": self.solver,
            "layout": f"{self.layout} ({self.layout_solver})",
            "seconds": f"{self.seconds['total']:.3f}",
        }
        if len(self.repaired):
            rows["repaired faces"] = some(self.repaired)
        width = max(map(len, rows))
        return "\n".join(f"{name:<{width}}  {value}" for name, value in rows.items())
