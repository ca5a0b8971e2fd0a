"""The result of a flattening: the map, the attempts, residuals, the outcome and its message."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Literal

import numpy as np

from .._notebook import arrange_html_row, draw_map_as_svg, format_html_table
from .._types import FloatArray, IntArray
from ..angles import Residual, Step, largest_magnitude
from ..errors import first_few, format_count
from ..surface import HOPELESS_AREA_RATIO, SAFE_AREA_RATIO, Mesh, Repair

MAX_COUNTED = 1000  # maximum number of overlapping pairs that are counted for the outcome
NO_INDICES: IntArray = np.empty(0, dtype=np.int64)
Guarantee = Literal["injective"]
StageName = Literal["linear step", "active set", "converged abf", "feasible abf", "injective", "isometric"]


class Outcome(str, Enum):
    """The outcome of a flattening."""

    CONVERGED = "converged"
    """No triangle is flipped, and the residual is at most the tolerance."""
    VALID = "valid"
    """No triangle is flipped; the method does not require the residual to reach a tolerance."""
    NOT_CONVERGED = "not converged"
    """No triangle is flipped, but the iterations ended above the tolerance."""
    OVERLAPPING = "overlapping"
    """No triangle is flipped, but parts of the map lie over each other."""
    FLIPPED = "flipped"
    """Some triangles are flipped or collapsed."""
    ANGLES_INVALID = "angles invalid"
    """Some target angles are outside (0, pi); only possible with `safeguard=False`."""

    @property
    def good(self) -> bool:
        """Whether the map is injective, and all target angles are within (0, pi)."""
        return self in (Outcome.CONVERGED, Outcome.VALID, Outcome.NOT_CONVERGED)


@dataclass(frozen=True, eq=False)
class Findings:
    """The measurements of a map and its angles that determine the outcome of the flattening.

    Attributes
    ----------
    layout, solver : str
        Names of the layout and of its solver.
    area_ratio : float
        Ratio of the largest to the smallest area scale of the map.
    flipped : (#flips,) int64
        Faces that are flipped in the map.
    residual : float
        Largest residual of the target angles.
    invalid : (#invalid,) int64
        Faces with a target angle outside (0, pi).
    converged : bool
        Whether the tolerance of the method was reached.
    note : str
        Why the tolerance was not reached; "" if the method does not require convergence.
    pins : int
        Number of pinned vertices.
    """

    layout: str
    solver: str
    area_ratio: float
    flipped: IntArray
    residual: float
    invalid: IntArray = field(default_factory=NO_INDICES.copy)
    converged: bool = False
    note: str = ""
    pins: int = 0


def determine_outcome(found: Findings) -> tuple[Outcome, str]:
    """Return the outcome and a sentence that explains it."""
    flipped, note = found.flipped, found.note
    fit = f"largest angle residual {found.residual:.1e}"
    if len(found.invalid):
        return Outcome.ANGLES_INVALID, (
            f"the target angles of faces {first_few(found.invalid)} are outside (0, pi), and {len(flipped)} "
            "triangles of the map are flipped: use safeguard=True, or abf"
        )
    wide = ""
    if found.area_ratio > SAFE_AREA_RATIO:
        more = " or more" if found.area_ratio > HOPELESS_AREA_RATIO else ""
        wide = f"area scale varies by a factor of {found.area_ratio:.0e}{more}"
    if not len(flipped):
        cut = "near the end of double precision: cut the mesh, for example by igl_linabf.unwrap"
        end = f"; the map's {wide}, {cut}" if wide else ""
        if found.layout in ("SLIM", "isometric", "embedding"):
            if note:
                return Outcome.NOT_CONVERGED, f"no triangle is flipped, but {note}, by {found.solver}{end}"
            return Outcome.VALID, f"no triangle is flipped, by {found.solver}{end}"
        if found.converged:
            return Outcome.CONVERGED, f"no triangle is flipped; {fit}{end}"
        if not note:
            return Outcome.VALID, f"no triangle is flipped; {fit}{end}"
        return Outcome.NOT_CONVERGED, (
            f"no triangle is flipped, but {note} ({fit}): look for degenerate faces, or cut the mesh{end}"
        )
    where = f"faces {first_few(flipped)} are flipped or collapsed"
    helps = (
        "cut the mesh towards them (igl_linabf.unwrap does this for you), or use guarantee='injective', "
        "which gives a map without flips, but with more distortion"
    )
    if found.pins > 2:
        return Outcome.FLIPPED, (
            f"{where}, which {found.pins} pins may require: pin fewer vertices, or use method='isometric', "
            "which comes as close to the pins as possible without flips"
        )
    if not found.converged:
        return Outcome.FLIPPED, f"{where}: {note or 'more iterations may help'} ({fit}); {helps}"
    if wide:
        return Outcome.FLIPPED, (
            f"{where}: the map's {wide}, more than double precision holds ({fit}); {helps}"
        )
    return Outcome.FLIPPED, f"{where}, though the angles converged ({fit}): {helps}"


def report_overlaps(made: Flattening, pairs: IntArray) -> Flattening:
    """Return the result with the outcome `OVERLAPPING` if pairs of its triangles overlap without flips."""
    number = len(pairs)
    if not number or not made.outcome.good:
        return made
    count = f"more than {MAX_COUNTED:,}" if number > MAX_COUNTED else f"{number:,}"
    message = (
        f"{made.message}; but the map overlaps itself in {count} pair{'s' * (number > 1)} of "
        f"triangles (faces {first_few(np.unique(pairs))}) and cannot carry a texture: igl_linabf.unwrap cuts "
        "it, or moves its parts apart with ChartOptions(repair_overlaps=True), and igl_linabf.overlaps lists "
        "the pairs"
    )
    return replace(made, outcome=Outcome.OVERLAPPING, message=message)


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
        Closure error of the loop of a hole, relative to its length; 0 without holes. `vertex` and `wheel`
        include the angle sum and the wheel around a hole.
    """

    vertex: float
    triangle: float
    wheel: float
    closure: float = 0.0

    @classmethod
    def from_residual(cls, b: Residual) -> Residuals:
        return cls(
            largest_magnitude(b.vertex),
            largest_magnitude(b.triangle),
            largest_magnitude(b.wheel),
            largest_magnitude(np.abs(b.holonomy.gap)),
        )

    @property
    def largest(self) -> float:
        return max(self.vertex, self.triangle, self.wheel, self.closure)


class Status(Enum):
    """The status of an attempt."""

    GOOD = "a map without flipped triangles"
    FLIPPED = "a map with flipped triangles"
    OPEN_LOOP = "the target angles draw a boundary loop that does not close"
    CUT_SHORT = "a full step would make some angles zero or negative"
    DIVERGED = "the angles do not converge"
    SINGULAR = "a system is singular in double precision"
    PINS_MISSED = "no map without flipped triangles meets the pins"
    NO_VALID_START = "no map without flipped triangles was found to start from"


@dataclass(frozen=True)
class Attempt:
    """An attempt to flatten a mesh, one of several that were made in turn.

    Attributes
    ----------
    name : {"linear step", "active set", "converged abf", "feasible abf", "injective", "isometric"}
    status : Status
    flips : int or None
        Flipped triangles of the map; None if the attempt stopped before the layout.
    residual : float
        Largest residual of the angles.
    failed : str
        Why the next attempt was made, or what is wrong with the final map; "" if the attempt is good.
    """

    name: StageName
    status: Status
    flips: int | None
    residual: float
    failed: str

    def __str__(self) -> str:
        return f"{self.name} ({self.failed or 'no flips'})"


@dataclass(frozen=True)
class Hole:
    """Residuals of the target angles around a hole.

    Attributes
    ----------
    vertex : int
        A vertex of the boundary loop.
    size : int
        Number of vertices of the loop.
    rotation : float
        `|(m + 2) pi - sum of the angles|` at the m vertices, in radians. Zero if the loop turns once.
    scale : float
        `|sum log sin(gamma) - log sin(beta)|` over the vertices of the loop. Zero if the loop starts and ends
        at the same scale.
    translation : float
        Distance from the end to the start of the loop when it is laid out, relative to its length.
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
    def list_all(cls, mesh: Mesh, b: Residual) -> tuple[Hole, ...]:
        """Return all holes of the mesh with their residuals, given the residual `b` of the angles."""
        loops = mesh.topology.holes
        if not loops:
            return ()
        rotation = [b.turning[loop].sum() + 2 * np.pi for loop in loops]
        scale = [b.log_ratio[loop].sum() for loop in loops]
        parts = (rotation, scale, b.holonomy.gap)
        return tuple(
            cls(int(mesh.vertices[loop[0]]), len(loop), *(float(abs(part[i])) for part in parts))
            for i, loop in enumerate(loops)
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class FlatteningReport:
    """How a map was computed: attempts, steps, layout and solvers.

    Attributes
    ----------
    repairs : tuple of Repair
        The repairs before flattening, with `flatten(..., clean=True)`.
    repaired : (#caps,) int64
        Faces with an angle so close to pi that it was changed before flattening.
    attempts : tuple of Attempt
        The attempts in order. The map is from the last attempt without flipped triangles, or otherwise from
        the attempt with the fewest flips.
    steps : tuple of Step
        The linear solves in order.
    gap : float
        Closure error of the boundary loop laid out from the target angles, relative to its length.
    layout : {"boundary", "least-squares", "greedy", "SLIM", "isometric", "embedding"}
        The layout of the map. With "isometric" and "embedding", the target angles are the angles of the map.
    solver, layout_solver : str
        Names of the solvers of the angle systems and of the layout.
    boundary : {"free", "circle", "circles", "rectangle", "angles"}
        The requested shape of the boundary.
    corners : (4,) or (0,) int64
        The vertices at the corners of the rectangle, counterclockwise from the lower left corner.
    """

    repairs: tuple[Repair, ...] = ()
    repaired: IntArray = field(default_factory=NO_INDICES.copy)
    attempts: tuple[Attempt, ...] = ()
    steps: tuple[Step, ...] = ()
    gap: float = 0.0
    layout: str
    solver: str = "none"
    layout_solver: str
    boundary: str = "free"
    corners: IntArray = field(default_factory=NO_INDICES.copy)

    @property
    def iterations(self) -> int:
        """Number of linear solves, including chord steps, without restoration steps."""
        return sum(step.kind != "restoration" for step in self.steps)

    @property
    def inner_steps(self) -> int:
        """Total number of conjugate gradient steps."""
        return sum(step.inner_steps for step in self.steps)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Flattening:
    """A flat map, with the angles, residuals and outcome of the computation.

    Attributes
    ----------
    uv : (#V, 2) float64
        The map; NaN at vertices that belong to no face.
    F : (#F, 3) int64
        The triangles.
    angles : (#F, 3) float64
        Target angles of the layout, in radians.
    method : str
    outcome : Outcome
    message : str
        The outcome in a sentence: what is wrong, where, and what to do.
    flipped : (#flips,) int64
        Faces that are flipped or collapsed in the map.
    before, after : Residuals
        Constraint residuals of the initial estimate and of `angles`.
    holes : tuple of Hole
        Residuals of `angles` at each hole, without the outer loop.
    seconds : dict of str to float
        Time by stage, and "total".
    report : FlatteningReport
        Attempts, steps, layout, solvers, and further facts about the computation.
    """

    uv: FloatArray
    F: IntArray
    angles: FloatArray
    method: str
    outcome: Outcome
    message: str
    flipped: IntArray
    before: Residuals
    after: Residuals
    holes: tuple[Hole, ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)
    report: FlatteningReport

    def __repr__(self) -> str:
        flips = f", {len(self.flipped):,} flipped" * bool(len(self.flipped))
        return (
            f"<Flattening of {format_count(len(self.F), 'triangle')} by {self.method}: "
            f"{self.outcome.value}{flips}>"
        )

    def __str__(self) -> str:
        rows = self._make_table_rows()
        width = max(map(len, rows))
        return "\n".join(f"{name:<{width}}  {value}" for name, value in rows.items())

    def _repr_html_(self) -> str:
        table = format_html_table(list(self._make_table_rows().items()), header=False)
        return arrange_html_row([("", draw_map_as_svg(self.uv, self.F)), ("", table)])

    def _make_table_rows(self) -> dict[str, str]:
        report = self.report
        kinds: dict[str, list[int]] = {}
        for step in report.steps:
            kinds.setdefault(step.kind, []).append(step.inner_steps)
        solves = ", ".join(f"{len(inner)} {kind} ({sum(inner)})" for kind, inner in kinds.items())
        rows = {
            "method": self.method,
            "outcome": f"{self.outcome.value}: {self.message}",
            "tried": ", then ".join(map(str, report.attempts)) or self.method,
            "linear solves (CG steps)": solves or "none needed",
            "angle residual": f"{self.before.largest:.2e} -> {self.after.largest:.2e}",
            "boundary gap": f"{report.gap:.2e}",
            "closure of holes": ", ".join(f"{hole.largest:.1e}" for hole in self.holes) or "no holes",
            "solver": report.solver,
            "layout": f"{report.layout} ({report.layout_solver})",
            "seconds": f"{self.seconds['total']:.3f}",
        }
        if report.repairs:
            rows["repairs"] = "; ".join(map(str, report.repairs))
        if len(report.repaired):
            rows["repaired faces"] = first_few(report.repaired)
        return rows
