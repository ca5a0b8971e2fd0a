"""Represent an atlas: the charts of a surface and their texture coordinates."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..._notebook import arrange_html_row, draw_map_as_svg, format_html_table
from ..._runtime import align_columns
from ..._types import FloatArray, IntArray
from ...errors import first_few, format_count
from ...flattening import Flattening
from ...measures import Quality, format_pair_count
from ...surface import Repair, Triangles, complex_positions, has_distinct_corners, signed_double_areas
from ..cost import AtlasCost

MAX_LISTED_CHARTS = 20  # maximum number of charts in the table that a notebook shows
UNUSABLE_STRETCH = 10.0  # charts with more L2 stretch are cut further or, if that is not possible, reported
STRETCH_ROUNDING = 1e-9  # relative tolerance for rounding errors when `max_stretch` is checked
ISOMETRY_ENERGY = 4.0  # symmetric Dirichlet energy s1^2 + s2^2 + s1^-2 + s2^-2 of an isometry
MAX_SEAM_MISMATCH = 1e-4  # report seams of cones with a larger `seam_mismatch`: textures do not continue


@dataclass(frozen=True, eq=False, repr=False)
class Chart:
    """One chart of an atlas.

    Attributes
    ----------
    faces : (#f,) int64
        Faces of the chart: row indices into the surface's F. A polygon has a row for each of its triangles.
    result : Flattening
        Flattening of the chart before packing. Vertices and faces are numbered within the chart.
    quality : Quality
    n_splits : int
        Number of times the chart was cut after it had been flattened, because of overlaps, flips or stretch.
    overlapping : int
        Number of pairs of faces that still overlap.
    distortion_increase : float
        Increase of `Quality.angle_distortion` from moving overlapping parts apart; 0 if no parts were moved.
    scale : float
        Texel density of the chart relative to the atlas: `Packing.unseen` if the chart is invisible from
        outside, otherwise 1.
    split_reasons : tuple of str
        Reasons for the cuts that `n_splits` counts: some of "uneven texels", "flipped triangles", "overlaps",
        "stretch" and "the limits of double precision".
    """

    faces: IntArray
    result: Flattening
    quality: Quality
    n_splits: int
    overlapping: int
    distortion_increase: float
    scale: float = 1.0
    split_reasons: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"<Chart of {format_count(len(self.faces), 'triangle')}: {self.result.outcome.value}>"


@dataclass(frozen=True)
class AtlasBounds:
    """The bounds that were requested for an atlas, and the `trade` with which it was made.

    Attributes
    ----------
    max_stretch, max_dirichlet, max_charts : float or None
        The bounds in `ChartOptions`; `max_charts` is an integer.
    trade : float or None
        The `trade` with which the charts were made. With `max_dirichlet` or `max_charts`, a search determined
        it. None for an empty mesh.
    """

    max_stretch: float | None = None
    max_dirichlet: float | None = None
    max_charts: int | None = None
    trade: float | None = None


@dataclass(frozen=True, eq=False)
class AtlasReport:
    """How an atlas was made: repairs, scale, cones and seams.

    Attributes
    ----------
    seam_mismatch : float
        The largest `|log(a / b)|` over all seam edges, where a and b are the lengths of the edge's two sides
        in the map. With cones, only rounding errors contribute.
    n_splits : int
        Number of charts beyond one per component. Charts are split to remove overlaps and stretch, into the
        panels of hard surfaces, and along given seams.
    repairs : tuple of Repair
        Repairs that `unwrap` made to the mesh; empty if the mesh was clean.
    bounds : AtlasBounds
        The requested bounds, and the `trade` with which the charts were made.
    scale : float
        Page widths per unit of length of V, averaged over a chart with a `Chart.scale` of 1. Multiply by the
        page width in texels to get the texel density.
    cones : (#C,) int64
        The vertices that are cones; empty without cones.
    cone_angles : (#C,) float64
        Sum of the angles of the map's triangles at each cone, radians.
    coned : bool
        Whether cones were requested. If True, the sides of all seams must match, even if there are no cones.
    period : float or None
        Period of a texture that continues across the seams, measured from the origin of `TC`; None if no
        period was requested.
    split : Triangles or None
        The triangulation of the polygons; None if the faces are triangles.
    given_seams : (#G, 2) int64
        The edges given in `seams=`. `write_pattern` joins no pieces along these edges.
    aspect : float
        Height of a page divided by its width. `TC` is relative to height and width; `flat` has the true
        proportions.
    """

    seam_mismatch: float = 0.0
    n_splits: int = 0
    repairs: tuple[Repair, ...] = ()
    bounds: AtlasBounds = AtlasBounds()
    scale: float = 0.0
    cones: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    cone_angles: FloatArray = field(default_factory=lambda: np.zeros(0))
    coned: bool = False
    period: float | None = None
    split: Triangles | None = None
    given_seams: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    aspect: float = 1.0


@dataclass(frozen=True, eq=False, repr=False)
class Atlas:
    """The texture coordinates of a surface, in the format of `igl.writeOBJ`.

    Attributes
    ----------
    TC : (#TC, 2) float64
        Texture coordinates. Page k is the unit square with the lower left corner (k % 10, k // 10), UDIM tile
        1001 + k.
    FTC : (#F, 3) int64
        Rows of `TC` at the corners of the faces, in the shape of `F`: (#F, k) for faces with k corners, a
        tuple of arrays for faces of different sizes.
    origin : (#TC,) int64
        The vertex of each texture coordinate.
    chart : (#F,) int64
        The chart of each face.
    page : (#charts,) int64
        The page of each chart.
    charts : tuple of Chart
    seams : (#E, 2) int64
        The edges that were cut.
    seam_length : float
        Total length of the seams.
    fill : float
        Share of the pages that the charts cover.
    quality : Quality
        Quality of the whole atlas: angles at all corners, and stretch at the common scale of the charts,
        ignoring `Chart.scale`. Faces that the repair removed do not count.
    cost : AtlasCost
        Stretch, length of the seams and unused part of the pages, as weighed by `unwrap`.
    report : AtlasReport
        Repairs, scale, cones, and further facts about how the atlas was made.
    """

    TC: FloatArray
    FTC: Any  # IntArray or tuple of IntArray
    origin: IntArray
    chart: IntArray
    page: IntArray
    charts: tuple[Chart, ...]
    seams: IntArray
    seam_length: float
    fill: float
    quality: Quality
    cost: AtlasCost = field(default_factory=AtlasCost)
    report: AtlasReport = field(default_factory=AtlasReport)

    @property
    def pages(self) -> int:
        """Number of pages of the atlas."""
        return int(self.page.max(initial=0)) + 1

    @property
    def added_seams(self) -> IntArray:
        """The edges that were cut in addition to `report.given_seams`, (#A, 2)."""
        n = int(self.origin.max(initial=0)) + 1
        made, given = (np.sort(edges, axis=1) @ [n, 1] for edges in (self.seams, self.report.given_seams))
        return np.asarray(self.seams[~np.isin(made, given)])

    @property
    def flat(self) -> FloatArray:
        """Texture coordinates `TC` in units of the page width, (#TC, 2).

        Charts have their true angles, even if the pages are not square.
        """
        return np.asarray(self.TC * [1, self.report.aspect])

    @property
    def triangles(self) -> IntArray:
        """Rows of `TC` at the corners of triangles, (#T, 3): `FTC`, with polygons split into triangles."""
        if self.report.split is None:
            return np.asarray(self.FTC)
        return np.concatenate([np.ravel(row) for row in self.FTC])[self.report.split.place]

    @property
    def drawn(self) -> IntArray:
        """Rows of `triangles` that can be drawn, without triangles that repeat a corner.

        Triangles that `unwrap` turned to the orientation of their neighbours are turned here, too. Thus only
        the triangles that are flipped in their chart are clockwise.
        """
        F, flipped = self.triangles, np.zeros(len(self.triangles), dtype=bool)
        for chart in self.charts:
            flipped[chart.faces[chart.result.flipped]] = True
        clockwise = signed_double_areas(complex_positions(self.TC), F.T) < 0
        drawn = np.where((clockwise & ~flipped)[:, None], F[:, ::-1], F)
        return np.asarray(drawn[has_distinct_corners(drawn)])

    @property
    def good(self) -> bool:
        """Return True if no face is flipped, and no chart overlaps itself or is stretched beyond use."""
        return not self.troubles

    @property
    def troubles(self) -> list[str]:
        """One sentence for each chart that has flipped or overlapping faces, or too much stretch.

        A chart has too much stretch if its L2 stretch exceeds `max_stretch`, or 10 if `max_stretch` is None.
        Seams of cones whose sides do not match, faces that collapsed, and bounds on the whole atlas that are
        not met, are reported as well.
        """
        said, more = [], "give more cones there" if self.report.coned else ""
        most = UNUSABLE_STRETCH
        if self.report.bounds.max_stretch is not None:
            most = self.report.bounds.max_stretch * (1 + STRETCH_ROUNDING)
        for i, chart in enumerate(self.charts):
            stretched = not chart.quality.stretch_l2 <= most
            if chart.result.outcome.good and not chart.overlapping and not stretched:
                continue
            where = f"chart {i} (faces {first_few(chart.faces)})"
            if chart.overlapping and not len(chart.result.flipped):
                pairs = f"{format_pair_count(chart.overlapping)} pair{'s' * (chart.overlapping > 1)} of faces"
                said.append(f"{where} lies over itself in {pairs}: {more or 'give more seams there'}")
            elif not chart.result.outcome.good:
                flipped = first_few(chart.faces[chart.result.flipped])
                help_ = more or "give more seams there, or a larger trade"
                said.append(f"{where} has flipped faces, {flipped}: {help_}")
            else:
                said.append(
                    f"{where} has an L2 stretch of {chart.quality.stretch_l2:.3g}, beyond {most:.3g}: "
                    + (more or "give more seams there, extend=True, max_stretch or a larger trade")
                )
        if self.report.coned and self.report.seam_mismatch > MAX_SEAM_MISMATCH:
            factor = np.exp(min(self.report.seam_mismatch, np.log(np.finfo(float).max)))
            said.append(
                f"the sides of seams do not match: the two sides of an edge differ in length by a factor of "
                f"up to {factor:.4g}, because no angles were found for which they match: give more cones"
            )
        collapsed = self.quality.flips - sum(len(chart.result.flipped) for chart in self.charts)
        if collapsed > 0:
            said.append(
                f"faces {first_few(self._find_smallest_faces(collapsed))} are so small relative to the "
                "others that double precision cannot represent them on the same page: unwrap them separately"
            )
        return said + list_unmet_bounds(self)

    def _find_smallest_faces(self, number: int) -> IntArray:
        """Return the `number` smallest faces of the map, ignoring faces that repeat a corner."""
        F = self.triangles
        rows = np.flatnonzero(has_distinct_corners(F))
        area = np.abs(signed_double_areas(complex_positions(self.TC), F[rows].T))
        smallest = rows[np.argsort(area)[:number]]
        return np.unique(smallest if self.report.split is None else self.report.split.face[smallest])

    def __repr__(self) -> str:
        troubles = f", {len(self.troubles)} with troubles" * bool(self.troubles)
        charts = format_count(len(self.charts), "chart")
        faces = f"{'triangle' if self.report.split is None else 'face'}{'s' * (len(self.FTC) != 1)}"
        return f"<Atlas of {len(self.FTC):,} {faces}: {charts}{troubles}, {self.fill:.0%} filled>"

    def __str__(self) -> str:
        return "\n".join((align_columns(self._make_table_rows()), *self._describe_in_lines()))

    def _repr_html_(self) -> str:
        rows, most = self._make_table_rows(), MAX_LISTED_CHARTS
        if len(rows) > most + 2:
            left_out = (f"{len(rows) - 2 - most:,} more", *[""] * (len(rows[0]) - 1))
            rows = [*rows[: most + 1], left_out, rows[-1]]
        lines = [
            format_html_table([[line]], header=False)
            for line in (*self._describe_in_lines(), *self.troubles[:most])
        ]
        face = slice(None) if self.report.split is None else self.report.split.face
        picture = draw_map_as_svg(self.flat, self.triangles, self.chart[face])
        return arrange_html_row([("", picture), ("", format_html_table(rows) + "".join(lines))])

    def _describe_in_lines(self) -> list[str]:
        splits = format_count(self.report.n_splits, "split")
        seams = f"{len(self.seams):,} seam edges, {self.seam_length:.4g} long"
        spread = f"texel areas 99 % : 1 % {self.quality.texel_spread:.3g}"
        filled = f"{seams}; {splits}; {self.fill:.0%} of the square filled; {spread}"
        matching = []
        if len(self.report.cones):
            number = format_count(len(self.report.cones), "cone")
            matching = [f"{number}; the sides of seams are equally long to {self.report.seam_mismatch:.0e}"]
        small = [chart.scale for chart in self.charts if chart.scale < 1]
        if small:
            number = format_count(len(small), "chart")
            matching.append(
                f"{number} that no ray from outside reaches, at {small[0]:.3g} of the texel density"
            )
        return [filled, str(self.cost), *matching, *map(str, self.report.repairs)]

    def _make_table_rows(self) -> list[tuple[str, ...]]:
        def make_row(name: str, faces: int, of: Quality, overlapping: int, *rest: str) -> tuple[str, ...]:
            figures = (f"{of.angle_distortion:.4g}", f"{of.stretch_l2:.4g}", str(of.flips))
            return (name, f"{faces:,}", *figures, format_pair_count(overlapping), *rest)

        rows: list[tuple[str, ...]] = [
            ("chart", "faces", "F/3nt", "L2 stretch", "flips", "overlaps", "holes", "outcome")
        ]
        for i, chart in enumerate(self.charts):
            ended = (str(len(chart.result.holes)), chart.result.outcome.value)
            rows.append(
                make_row(str(i), len(np.unique(chart.faces)), chart.quality, chart.overlapping, *ended)
            )
        overlapping = sum(chart.overlapping for chart in self.charts)
        rows.append(make_row("all", len(self.FTC), self.quality, overlapping, "", ""))
        return rows


def mean_energy(atlas: Atlas) -> float:
    """Return the mean symmetric Dirichlet energy of an atlas, which is 4 for an isometry."""
    return ISOMETRY_ENERGY * atlas.quality.symmetric_dirichlet


def list_unmet_bounds(atlas: Atlas) -> list[str]:
    """Return one sentence for each bound on the whole atlas that is not met."""
    unmet, bounds, energy = [], atlas.report.bounds, mean_energy(atlas)
    if bounds.max_dirichlet is not None and not energy <= bounds.max_dirichlet:
        other = any(chart.result.method != "isometric" for chart in atlas.charts)
        unmet.append(
            f"the atlas has a mean symmetric Dirichlet energy of {energy:.6g}, beyond max_dirichlet = "
            f"{bounds.max_dirichlet:.6g}, for every trade tried: give a larger bound"
            + ", or method='isometric'"
            * other
        )
    if bounds.max_charts is not None and len(atlas.charts) > bounds.max_charts:
        unmet.append(
            f"the atlas has {len(atlas.charts):,} charts, more than max_charts = {bounds.max_charts:,}, for "
            "every trade tried that meets the other bounds: give a larger bound, or repair_overlaps=True if "
            "charts are split because they overlap themselves"
        )
    return unmet
