"""Define `Pattern`, and build it from a surface and its map."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import align_columns
from .._types import FloatArray, IntArray
from ..charts import Atlas
from ..errors import MeshWarning, OutcomeWarning, first_few, format_count, stack_level
from .folds import find_seam_angles
from .grain_arrows import place_arrows
from .options import PatternOptions
from .pieces import PatternLayout, lay_out
from .seam_pairs import PatternSeam, measure_seams
from .tabs import PatternTab

MAX_CHANGE = 0.05  # relative change of an edge from which pieces are reported not to fit


@dataclass(frozen=True)
class PatternReport:
    """How a pattern was made.

    Attributes
    ----------
    crease : float
        Smallest angle of a fold, in degrees.
    tab_width, allowance : float
        Requested width of the tabs, and width of the seam allowance, in millimetres; 0 for none.
    compensation : (float, float)
        Factors that enlarge the pieces across and along their arrows. The lengths of seams, and all lines,
        include them.
    seams_without_room : tuple of int
        Numbers of the seams without a tab, or with another part of the piece within their allowance.
    """

    crease: float
    tab_width: float
    allowance: float
    compensation: tuple[float, float]
    seams_without_room: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Pattern:
    """The outlines of a flattened surface at true scale, in millimetres, with y pointing up.

    Attributes
    ----------
    size : (float, float)
        Width and height of all pieces together, including tabs and allowance.
    outlines : tuple of (n, 2) float64
        Closed lines with the material on their left, including the outlines of holes. With a seam allowance,
        these are the sewing lines.
    piece : (#outlines,) int64
        Piece of each outline.
    cut_lines : tuple of (n, 2) float64
        Closed lines along which the pieces are cut: the outlines, with tabs or at the distance of the
        allowance.
    seams : tuple of PatternSeam
    folds : (#folds, 2, 2) float64
        Edges with a crease inside a piece.
    fold_angles : (#folds,) float64
        Angle between the normals of the two faces at each fold, in degrees. Positive angles are mountain
        folds (fold away from the viewer), negative angles are valley folds (fold towards the viewer). The
        viewer sees the outside of the surface, where the normals point.
    grain : (#pieces, 2, 2) float64
        Tail and head of the arrow of each piece.
    tabs : tuple of PatternTab
        Glue tabs.
    error : float
        Largest relative change of the length of an edge by the map, without compensation.
    units : str
        Unit of length of the surface.
    report : PatternReport
    """

    size: tuple[float, float]
    outlines: tuple[FloatArray, ...]
    piece: IntArray
    cut_lines: tuple[FloatArray, ...]
    seams: tuple[PatternSeam, ...]
    folds: FloatArray
    fold_angles: FloatArray
    grain: FloatArray
    tabs: tuple[PatternTab, ...]
    error: float
    units: str
    report: PatternReport

    @property
    def pieces(self) -> int:
        """Number of pieces."""
        return len(self.grain)

    def __str__(self) -> str:
        rows: list[tuple[str, ...]] = [("seam", "pieces", "side 1", "side 2", "surface", "sides differ")]
        for seam in self.seams:
            pieces = "{} {}".format(*seam.pieces)
            lengths = [f"{length:.2f}" for length in (*seam.lengths, seam.length)]
            rows.append((str(seam.number), pieces, *lengths, f"{round(seam.difference, 4) + 0.0:+.2%}"))
        width, height = self.size
        mountain = int((self.fold_angles > 0).sum())
        facts = [
            f"{format_count(self.pieces, 'piece')}, {width:.1f} x {height:.1f} mm, "
            f"{len(self.folds)} fold edges ({mountain} mountain, {len(self.folds) - mountain} valley)"
        ]
        if self.report.tab_width:
            facts.append(f"{format_count(len(self.tabs), 'tab')} of at most {self.report.tab_width:g} mm")
        if self.report.allowance:
            facts.append(f"a seam allowance of {self.report.allowance:g} mm")
        if self.report.compensation != (1, 1):
            facts.append("enlarged by {:g} across and {:g} along the grain".format(*self.report.compensation))
        facts += [f"edges change by {self.error:.2%} at most", f"the surface is in {self.units}"]
        return f"{align_columns(rows)}\n{'; '.join(facts)}"


def build_pattern(V: ArrayLike, F: ArrayLike, atlas: Atlas | ArrayLike, options: PatternOptions) -> Pattern:
    """Build the pattern of a surface. The arguments are as in `write_pattern`."""
    layout = lay_out(V, F, atlas, options)
    cut, sides = layout.cut, layout.sides
    piece, loops = cut.piece, cut.topology.loops
    folds, fold_angles = layout.folds
    _warn_about_seams(layout, options)
    _warn_about_changes(layout)
    corners = np.concatenate(layout.cut_lines)
    return Pattern(
        size=(float(corners[:, 0].max()), float(corners[:, 1].max())),
        outlines=tuple(cut.flat[loop] for loop in loops),
        piece=np.array([piece[loop[0]] for loop in loops], dtype=np.int64),
        cut_lines=layout.cut_lines,
        seams=measure_seams(layout.seams, sides, cut.surface, cut.flat, piece),
        folds=cut.flat[folds],
        fold_angles=fold_angles,
        grain=place_arrows(cut, loops, piece, layout.arrows),
        tabs=_describe_tabs(layout),
        error=float(np.max(layout.changes, initial=0)),
        units=options.units,
        report=PatternReport(
            options.crease, options.tabs, options.allowance, options.compensation, layout.seams_without_room
        ),
    )


def _describe_tabs(layout: PatternLayout) -> tuple[PatternTab, ...]:
    """Return the tabs with their lines and angles."""
    if not layout.tabs:
        return ()
    cut, sides = layout.cut, layout.sides
    angle, length = find_seam_angles(cut, sides, layout.seams), sides.measure_lengths(cut.surface)
    return tuple(
        PatternTab(
            seam=tab.seam + 1,
            piece=int(cut.piece[sides.start[tab.run[0]]]),
            base=cut.flat[sides.get_vertices_along(tab.run)],
            top=tab.top,
            angle=float(angle[tab.run] @ length[tab.run] / length[tab.run].sum()),
        )
        for tab in layout.tabs
    )


def _warn_about_seams(layout: PatternLayout, options: PatternOptions) -> None:
    """Warn about seams without a tab, and about seams and holes without room for their allowance."""
    seams, number, messages = layout.seams_without_room, len(layout.seams), []
    if seams and options.tabs:
        messages.append(
            f"no tab fits beside {len(seams)} of {number} seams ({first_few(seams)}): use narrower tabs, or "
            "glue a strip of paper behind these seams"
        )
    elif seams:
        messages.append(
            f"another part of the piece is closer than twice the allowance at {len(seams)} of {number} seams "
            f"({first_few(seams)}): fold these seams as darts, or use a smaller allowance"
        )
    if layout.closed_holes:
        messages.append(
            f"the allowance covers holes ({layout.closed_holes}), which therefore have no cutting line: use "
            "a smaller allowance, or cut along their outlines"
        )
    for message in messages:
        warnings.warn(message, MeshWarning, stacklevel=stack_level())


def _warn_about_changes(layout: PatternLayout) -> None:
    """Warn if edges become so much longer or shorter that the pieces cannot be sewn or bent."""
    much = layout.changes > MAX_CHANGE
    if much.any():
        warnings.warn(
            f"the pattern changes the lengths of {much.mean():.1%} of the edges by more than "
            f"{MAX_CHANGE:.0%}, and at most by {layout.changes.max():.0%}: the pieces do not fit the surface "
            "there. Cut more with charts=ChartOptions(max_stretch=1.0001), with 1.001 for fewer pieces, or "
            "along your own seams",
            OutcomeWarning,
            stacklevel=stack_level(),
        )
