"""Measure and judge existing texture coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._notebook import arrange_html_row, draw_map_as_svg, format_html_table
from .._runtime import align_columns
from .._types import FloatArray, IntArray
from ..charts import parse_page_size, texture_seams
from ..errors import MeshError, first_few, format_count, is_number, takes_vertices_and_faces
from ..measures import Quality, format_pair_count, measure_quality
from ..surface import Submesh, merge_coincident
from .margins import measure_margins
from .sheets import Sheet, list_sheets, measure_sheets
from .uv_charts import UVCharts

CHECKED_RESOLUTION = 1024  # default texels along the side of a page, for densities and margins
LIMIT_ROUNDING = 1e-6  # relative tolerance of limits, for rounding errors
MARGIN_ROUNDING = 1e-3  # tolerance of `min_margin` for the rounding of coordinates in files, in texels


@dataclass(frozen=True)
class TexelDensity:
    """Texels per unit of length of V, at the checked resolution.

    Attributes
    ----------
    mean : float
        Mean of all charts.
    least, most : float
        Smallest and largest density of a chart.
    """

    mean: float
    least: float
    most: float


@dataclass(frozen=True, eq=False)
class UVCheckReport:
    """Further figures of a check of texture coordinates, and the requested resolution and limits.

    Attributes
    ----------
    faces : int
        Number of faces.
    unmapped : int
        Number of faces without texture coordinates.
    mirrored : int
        Number of mirrored charts, for example the left half of an object if both halves share a texture.
    stacked : int
        Number of charts that are stacked on an earlier chart and share its texture. At least nine tenths of
        both areas overlap.
    seams : int
        Number of edges along which the map is cut.
    quality : Quality
        Distortion of all charts at their common scale; mirrored charts are reversed.
    texel_density : TexelDensity
        Texels per unit of length of V: the mean, and the extremes of single charts.
    border : float
        Smallest distance from a chart to the border of its page, in texels; negative if a chart crosses the
        border.
    resolution : int or (int, int)
        Texels along the side of a page, or its width and height.
    limits : dict of str to float
        The requested limits `max_stretch`, `max_spread` and `min_margin`.
    chart : (#F,) int64
        Chart of each face; -1 without texture coordinates or area.
    sheets : tuple of Sheet
        The figures of each page of each image.
    """

    faces: int
    unmapped: int
    mirrored: int
    stacked: int
    seams: int
    quality: Quality
    texel_density: TexelDensity
    border: float
    resolution: int | tuple[int, int]
    limits: dict[str, float]
    chart: IntArray
    sheets: tuple[Sheet, ...]


@dataclass(frozen=True, eq=False, repr=False)
class UVCheck:
    """The result of `check_uv`; `print` shows it as a table.

    Attributes
    ----------
    charts : int
        Number of charts.
    flips : int
        Number of faces that are flipped within their chart, or have no area in the map.
    overlaps : int
        Number of pairs of triangles that overlap by accident, within a chart or between charts of one image
        that are not stacked. If there are more than 5,000,000 pairs, the number is 5,000,001.
    seam_length : float
        Length of the seams on the surface, in units of V.
    stretch_l2 : float
        As in `Quality`, for all charts at their common scale.
    texel_spread : float
        As in `Quality`, the ratio between the texels of two parts of the surface; 1 is best.
    fill : float
        Share of the pages that is covered by charts. Stacked charts count once.
    margin : float
        Smallest distance between two charts on a page, in texels; infinite for one chart, 0 if charts
        overlap.
    pages : int
        Number of unit squares (UDIM tiles) with charts, of all images.
    flipped : (#flipped,) int64
        Flipped faces.
    overlapping : (#overlaps, 2) int64
        Pairs of overlapping faces.
    report : UVCheckReport
        Further figures, and the requested resolution and limits.
    """

    charts: int
    flips: int
    overlaps: int
    seam_length: float
    stretch_l2: float
    texel_spread: float
    fill: float
    margin: float
    pages: int
    flipped: IntArray
    overlapping: IntArray
    report: UVCheckReport
    _drawn: tuple[FloatArray, IntArray, IntArray]  # map, triangles and their charts, for a notebook

    @property
    def figures(self) -> dict[str, Any]:
        """All figures of the table, by the names that `igl-linabf check --json` uses."""
        density, quality = self.report.texel_density, self.report.quality
        grouped = {
            "texel_density": density.mean,
            "least_density": density.least,
            "most_density": density.most,
        }
        for name in ("stretch_linf", "angle_distortion", "conformal_distortion"):
            grouped[name] = getattr(quality, name)
        flat = {**vars(self.report), **vars(self), **grouped}
        return {name: flat[name] for name in ROWS}

    @property
    def good(self) -> bool:
        """Return True if no face is unmapped, flipped or overlapping by accident, and all limits are met."""
        return not self.troubles

    @property
    def troubles(self) -> list[str]:
        """Return a sentence about each defect."""
        lines = []
        if self.report.unmapped:
            lines.append(
                f"{format_count(self.report.unmapped, 'face')} of {self.report.faces:,} without texture "
                "coordinates: "
                "unwrap the mesh"
            )
        if self.flips:
            lines.append(
                f"faces {first_few(self.flipped)} are flipped or collapsed in the map: unwrap their charts "
                "again"
            )
        if self.overlaps:
            pairs = f"{format_pair_count(self.overlaps)} pair{'s' * (self.overlaps > 1)} of triangles"
            lines.append(
                f"{pairs} overlap by accident, such as faces {first_few(self.overlapping[0])}: repack the "
                "charts, or unwrap charts that overlap themselves"
            )
        return lines + [
            line for limit, asked in self.report.limits.items() for line in self._list_exceeded(limit, asked)
        ]

    def _list_exceeded(self, limit: str, asked: float) -> list[str]:
        """Return a sentence about each figure beyond a limit."""
        lines, figures = [], self.figures
        for name, share, help_ in LIMITS[limit]:
            value, least = figures[name], limit.startswith("min")
            bound = share * asked
            is_met = value >= bound - MARGIN_ROUNDING if least else value <= bound * (1 + LIMIT_ROUNDING)
            if not is_met:
                where = "below" if least else "above"
                lines.append(f"{ROWS[name]}: {value:.4g}, {where} {bound:g}; {help_}")
        return lines

    def __repr__(self) -> str:
        charts = format_count(self.charts, "chart")
        wrong = (
            f"{self.flips:,} flipped, {format_pair_count(self.overlaps)} overlap{'s' * (self.overlaps != 1)}"
        )
        return (
            f"<UVCheck of {format_count(self.report.faces, 'face')}: {charts}, {wrong}, {self.fill:.0%} "
            "filled>"
        )

    def __str__(self) -> str:
        text, sheets = align_columns(self._make_table_rows()), self.report.sheets
        return f"{text}\n\n{align_columns(list_sheets(sheets))}" if len(sheets) > 1 else text

    def _repr_html_(self) -> str:
        troubles = (
            format_html_table([[line] for line in self.troubles], header=False) if self.troubles else ""
        )
        picture = draw_map_as_svg(*self._drawn)
        return arrange_html_row(
            [("", picture), ("", format_html_table(self._make_table_rows(), header=False) + troubles)]
        )

    def _make_table_rows(self) -> list[tuple[str, str]]:
        return [(ROWS[name], _format_figure(name, value)) for name, value in self.figures.items()]


def _format_figure(name: str, value: float | tuple[int, int]) -> str:
    """Format a figure for the table."""
    if isinstance(value, tuple):
        return "x".join(map(str, value))
    if isinstance(value, int):
        return format_pair_count(value) if name == "overlaps" else f"{value:,d}"
    return f"{value:.4g}"


ROWS = {
    "faces": "faces",
    "unmapped": "without coordinates",
    "charts": "charts",
    "mirrored": "mirrored charts",
    "stacked": "stacked charts",
    "flips": "flipped faces",
    "overlaps": "accidental overlaps",
    "seams": "seam edges",
    "seam_length": "their length",
    "stretch_l2": "stretch, L2",
    "stretch_linf": "stretch, largest",
    "angle_distortion": "angle distortion F/3nt",
    "conformal_distortion": "conformal distortion, mean",
    "texel_density": "texels per unit of length",
    "least_density": "of the coarsest chart",
    "most_density": "of the finest chart",
    "texel_spread": "texel areas, 99 % : 1 %",
    "pages": "pages",
    "fill": "of the pages filled",
    "margin": "texels between charts, least",
    "border": "texels to the border, least",
    "resolution": "resolution",
}

MORE_PADDING = "repack the charts with more padding"
LIMITS = {  # for each limit: name of the bounded figure, factor that multiplies the limit, and remedy
    "max_stretch": [("stretch_l2", 1.0, "unwrap the mesh with ChartOptions(max_stretch=)")],
    "max_spread": [("texel_spread", 1.0, "repack the charts with scale='even', or unwrap by 'isometric'")],
    "min_margin": [("margin", 1.0, MORE_PADDING), ("border", 0.5, MORE_PADDING)],
}


@takes_vertices_and_faces
def check_uv(
    V: ArrayLike,
    F: ArrayLike,
    TC: ArrayLike,
    FTC: ArrayLike | None = None,
    *,
    labels: ArrayLike | None = None,
    resolution: int | tuple[int, int] = CHECKED_RESOLUTION,
    max_stretch: float | None = None,
    max_spread: float | None = None,
    min_margin: float | None = None,
) -> UVCheck:
    """Measure and judge existing texture coordinates from any program.

    Faces are flipped if their orientation differs from that in the rest of their chart. Faces of a mirrored
    chart are not flipped. Stacked charts share their texture, and all other overlaps are accidental.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) or (#F, k) int, or list of lists of int
        Any triangles or polygons.
    TC : (#TC, 2) float
        Texture coordinates.
    FTC : in the shape of `F`, optional
        Rows of `TC` at the corners, as returned by `igl.readOBJ`; -1 at corners without coordinates. By
        default `F`, for texture coordinates at vertices.
    labels : (#F,) int or str, optional
        The image of each face, by number or name, such as `mesh.extras.materials[1]` if each material has its
        own image. Charts on different images do not overlap. By default, all faces have the same image.
    resolution : int or (int, int)
        Texels along the side of a page, or its width and height, for densities and margins. If pages are not
        square, distortion is measured in texels.
    max_stretch : float, optional
        Largest accepted L2 stretch.
    max_spread : float, optional
        Largest accepted `texel_spread`.
    min_margin : float, optional
        Smallest accepted distance between two charts, in texels. Half of it is required at the border, as
        with `Packing.padding`.

    Returns
    -------
    UVCheck
        `good` is the verdict, and `troubles` lists the defects.

    Raises
    ------
    MeshError
        The arrays are malformed or do not match, or no face has texture coordinates and an area.
    ValueError
        The resolution or a limit is out of range.

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F)
    >>> check = check_uv(V, F, atlas.TC, atlas.FTC)
    >>> check.good, check.charts, check.flips, check.overlaps
    (True, 1, 0, 0)

    Two identical triangles in the map are stacked. If one is moved a little, they overlap by accident:

    >>> V, F = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]], [[0, 1, 2], [3, 4, 5]]
    >>> TC = [[0, 0], [0.5, 0], [0, 0.5], [0.1, 0], [0.6, 0], [0.1, 0.5]]
    >>> check_uv(V, F, TC, [[0, 1, 2], [0, 1, 2]]).report.stacked
    1
    >>> check_uv(V, F, TC).troubles[0][:39]
    '1 pair of triangles overlap by accident'
    """
    width, height = parse_page_size(resolution)
    limits = {"max_stretch": max_stretch, "max_spread": max_spread, "min_margin": min_margin}
    for name, value in limits.items():
        if value is not None and not is_number(value, 0):
            raise ValueError(f"{name} is {value!r}: give a number from 0 upwards")
    charts = UVCharts.from_arrays(V, F, TC, F if FTC is None else FTC, labels)
    if not len(charts.F):
        raise MeshError("no face has texture coordinates and an area: unwrap the mesh")
    asked = {name: float(value) for name, value in limits.items() if value is not None}
    return _measure_charts(charts, width, height, asked)


def _measure_charts(charts: UVCharts, width: int, height: int, limits: dict[str, float]) -> UVCheck:
    """Measure the charts on pages of the given size in texels."""
    surface = Submesh.from_arrays(charts.V, charts.upright_triangles)
    aspect = height / width
    pairs, stack = charts.accidental_overlaps
    quality = measure_quality(surface, charts.uv[surface.vertices] * [1, aspect], overlaps=len(pairs))
    ends = _find_seam_ends(charts)
    flat, area = (
        np.bincount(charts.chart_of_triangle, x)
        for x in (np.abs(charts.double_area) / 2, charts.area_in_space)
    )
    with np.errstate(divide="ignore"):
        density = np.sqrt(flat * aspect / area) * width
    own = stack == np.arange(charts.n_charts)
    margins = measure_margins(charts, own, bool(len(pairs)), (width, height))
    n = len(charts.split.polygons)
    chart, face, flipped = (
        np.full(n, -1),
        charts.split.face[charts.rows],
        charts.get_input_faces(charts.is_flipped),
    )
    chart[face[::-1]] = charts.chart_of_triangle[::-1]
    report = UVCheckReport(
        faces=n,
        unmapped=len(charts.unmapped),
        mirrored=int(charts.is_mirrored.sum()),
        stacked=int((~own).sum()),
        seams=len(ends),
        quality=quality,
        texel_density=TexelDensity(
            float(np.sqrt(flat.sum() * aspect / area.sum()) * width),
            float(density.min()),
            float(density.max()),
        ),
        border=margins.border,
        resolution=width if width == height else (width, height),
        limits=limits,
        chart=chart,
        sheets=tuple(measure_sheets(charts, own, pairs, aspect, width)),
    )
    return UVCheck(
        charts=charts.n_charts,
        flips=len(flipped),
        overlaps=len(pairs),
        seam_length=float(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum()),
        stretch_l2=quality.stretch_l2,
        texel_spread=quality.texel_spread,
        fill=float(flat[own].sum()) / margins.pages,
        margin=margins.between,
        pages=margins.pages,
        flipped=flipped,
        overlapping=face[pairs],
        report=report,
        _drawn=(charts.uv, charts.upright_triangles, charts.chart_of_triangle),
    )


def _find_seam_ends(charts: UVCharts) -> FloatArray:
    """Return the ends of the seam edges, (#E, 2, 3)."""
    vertex = merge_coincident(charts.V, np.arange(len(charts.V)))
    return charts.V[texture_seams(vertex[charts.F], charts.F)]
