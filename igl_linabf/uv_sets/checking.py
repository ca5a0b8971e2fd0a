"""Texture coordinates that a mesh has, measured and judged."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from .._notebook import html_row, html_table, map_svg
from .._runtime import aligned
from .._types import FloatArray, IntArray
from ..charts import page_size, texture_seams
from ..errors import MeshError, is_number, some
from ..measures import quality_of
from ..surface import Submesh, merge_coincident
from .constants import CHECKED_RESOLUTION, LIMIT_ROUNDING
from .margins import margins_of
from .uv_charts import UVCharts

NONE: IntArray = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False, repr=False)
class UVCheck:
    """What `check_uv` found; `print` shows it as a table.

    Attributes
    ----------
    faces : int
        That were given.
    unmapped : int
        Those without texture coordinates.
    charts : int
    mirrored : int
        Charts that are mirror images, as a half that shares its texture with the other one.
    stacked : int
        Charts that lie on another one, with nine tenths of both areas: they share their texture.
    flips : int
        Faces that are turned over within their chart, or have no area in the map.
    overlaps : int
        Pairs of triangles that lie over each other by accident: within a chart, or of charts that are no
        stack.
    seams : int
        Edges at which the map is cut.
    seam_length : float
        On the surface, in units of V.
    stretch_l2, stretch_linf, angle_distortion, conformal_distortion : float
        As in `Quality`, of all charts at their common scale.
    texel_density : float
        Texels per unit of length of V at the resolution, on average.
    least_density, most_density : float
        Of single charts.
    texel_spread : float
        As in `Quality`: the texels that one part of the surface gets, over those of another one; 1 is best.
    pages : int
        Unit squares, as UDIM tiles, that charts lie on.
    fill : float
        The share of these that charts cover; of a stack one counts.
    margin : float
        The least distance of two charts on a page, in texels; infinite for one chart, 0 where charts overlap.
    border : float
        The least distance of a chart to its page's border, in texels; negative if one reaches beyond.
    resolution : int or (int, int)
        Texels along a page's side, or its width and height.
    limits : dict of str to float
        What was asked for: `max_stretch`, `max_spread`, `min_margin`.
    flipped : (#flipped,) int64
        Faces.
    overlapping : (#overlaps, 2) int64
        Faces.
    chart : (#F,) int64
        The chart of each face; -1 without texture coordinates or area.
    uv, triangles, chart_of_triangle : (#C, 2) float64, (#T, 3) and (#T,) int64
        What a notebook draws.
    """

    faces: int
    unmapped: int
    charts: int
    mirrored: int
    stacked: int
    flips: int
    overlaps: int
    seams: int
    seam_length: float
    stretch_l2: float
    stretch_linf: float
    angle_distortion: float
    conformal_distortion: float
    texel_density: float
    least_density: float
    most_density: float
    texel_spread: float
    pages: int
    fill: float
    margin: float
    border: float
    resolution: int | tuple[int, int]
    limits: dict[str, float] = field(default_factory=dict)
    flipped: IntArray = field(default_factory=NONE.copy)
    overlapping: IntArray = field(default_factory=NONE.reshape(0, 2).copy)
    chart: IntArray = field(default_factory=NONE.copy)
    uv: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    triangles: IntArray = field(default_factory=NONE.reshape(0, 3).copy)
    chart_of_triangle: IntArray = field(default_factory=NONE.copy)

    @property
    def good(self) -> bool:
        """Whether all faces have coordinates, none is flipped or overlaps by accident, in all limits."""
        return not self.troubles

    @property
    def troubles(self) -> list[str]:
        """A sentence on each thing that is wrong."""
        said = []
        if self.unmapped:
            said.append(
                f"{self.unmapped:,} of {self.faces:,} faces have no texture coordinates: unwrap the mesh"
            )
        if self.flips:
            said.append(
                f"faces {some(self.flipped)} are flipped or collapsed in the map: unwrap their charts anew"
            )
        if self.overlaps:
            pairs = f"{self.overlaps:,} pair{'s' * (self.overlaps > 1)} of triangles"
            said.append(
                f"{pairs} overlap by accident, as of faces {some(self.overlapping[0])}: pack the charts "
                "anew, or unwrap charts that lie over themselves"
            )
        return said + [line for limit, asked in self.limits.items() for line in self._beyond(limit, asked)]

    def _beyond(self, limit: str, asked: float) -> list[str]:
        """What is said of a limit that is not kept."""
        said = []
        for name, share, help_ in LIMITS[limit]:
            value, least = getattr(self, name), limit.startswith("min")
            bound = share * asked
            kept = value >= bound * (1 - LIMIT_ROUNDING) if least else value <= bound * (1 + LIMIT_ROUNDING)
            if not kept:
                where = "below" if least else "above"
                said.append(f"{ROWS[name]}: {value:.4g}, {where} {bound:g}; {help_}")
        return said

    def __repr__(self) -> str:
        charts = f"{self.charts:,} chart{'s' * (self.charts != 1)}"
        wrong = f"{self.flips:,} flipped, {self.overlaps:,} overlaps"
        return f"<UVCheck of {self.faces:,} faces: {charts}, {wrong}, {self.fill:.0%} filled>"

    def __str__(self) -> str:
        return aligned(self._rows())

    def _repr_html_(self) -> str:
        troubles = html_table([[line] for line in self.troubles], header=False) if self.troubles else ""
        picture = map_svg(self.uv, self.triangles, self.chart_of_triangle)
        return html_row([("", picture), ("", html_table(self._rows(), header=False) + troubles)])

    def _rows(self) -> list[tuple[str, str]]:
        values = ((label, getattr(self, name)) for name, label in ROWS.items())
        return [(label, _written(v)) for label, v in values]


def _written(value: float | tuple[int, int]) -> str:
    if isinstance(value, tuple):
        return "x".join(map(str, value))
    return f"{value:,d}" if isinstance(value, int) else f"{value:.4g}"


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

MORE_PADDING = "pack the charts anew with more padding"
LIMITS = {  # the figures that they bound, at which share, and what helps
    "max_stretch": [("stretch_l2", 1.0, "unwrap the mesh with Seams(max_stretch=)")],
    "max_spread": [("texel_spread", 1.0, "pack the charts anew with scale='even', or unwrap by 'isometric'")],
    "min_margin": [("margin", 1.0, MORE_PADDING), ("border", 0.5, MORE_PADDING)],
}


def check_uv(
    V: ArrayLike,
    F: ArrayLike,
    TC: ArrayLike,
    FTC: ArrayLike,
    *,
    resolution: int | tuple[int, int] = CHECKED_RESOLUTION,
    max_stretch: float | None = None,
    max_spread: float | None = None,
    min_margin: float | None = None,
) -> UVCheck:
    """Measure and judge texture coordinates that a mesh has, from any program.

    Faces are flipped where they are turned over within their chart. A chart that is a mirror image is not.
    Charts that lie on each other share their texture: only other overlaps are accidents.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) or (#F, k) int, or list of lists of int
        Any triangles or polygons.
    TC : (#TC, 2) float
        Texture coordinates.
    FTC : in the shape of `F`
        Their rows at the corners, as `igl.readOBJ` returns them; -1 without.
    resolution : int or (int, int)
        Texels along a page's side, or its width and height, for densities and margins. On pages that are not
        square, charts are judged as they lie there in texels.
    max_stretch : float, optional
        The largest L2 stretch that is good.
    max_spread : float, optional
        The largest `texel_spread` that is good.
    min_margin : float, optional
        The least distance of two charts that is good, in texels; half as much to the border, as
        `Packing.padding` leaves it.

    Returns
    -------
    UVCheck
        `good` judges it, `troubles` says what is wrong.

    Raises
    ------
    MeshError
        The arrays are malformed or do not fit together, or no face has texture coordinates and an area.
    ValueError
        The resolution or a limit is out of its range.

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F)
    >>> check = check_uv(V, F, atlas.TC, atlas.FTC)
    >>> check.good, check.charts, check.flips, check.overlaps
    (True, 1, 0, 0)

    The same triangle twice in the map is a stack; one moved a little is an accident:

    >>> V, F = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]], [[0, 1, 2], [3, 4, 5]]
    >>> TC = [[0, 0], [0.5, 0], [0, 0.5], [0.1, 0], [0.6, 0], [0.1, 0.5]]
    >>> check_uv(V, F, TC, [[0, 1, 2], [0, 1, 2]]).stacked
    1
    >>> check_uv(V, F, TC, F).troubles[0][:43]
    '1 pair of triangles overlap by accident, as'
    """
    width, height = page_size(resolution)
    limits = {"max_stretch": max_stretch, "max_spread": max_spread, "min_margin": min_margin}
    for name, value in limits.items():
        if value is not None and not is_number(value, 0):
            raise ValueError(f"{name} is {value!r}: give a number from 0 upwards")
    charts = UVCharts.of(V, F, TC, FTC)
    if not len(charts.F):
        raise MeshError("no face has texture coordinates and an area: unwrap the mesh")
    asked = {name: float(value) for name, value in limits.items() if value is not None}
    return _checked(charts, width, height, asked)


def _checked(charts: UVCharts, width: int, height: int, limits: dict[str, float]) -> UVCheck:
    surface = Submesh.of_arrays(charts.V, charts.upright)
    aspect = height / width
    quality = quality_of(surface, charts.uv[surface.vertices] * [1, aspect], overlaps=0)
    pairs, stack = charts.overlaps
    ends = _seams(charts)
    flat, area = (np.bincount(charts.chart, x) for x in (np.abs(charts.double_area) / 2, charts.area))
    with np.errstate(divide="ignore"):
        density = np.sqrt(flat * aspect / area) * width
    own = stack == np.arange(charts.number)
    margins = margins_of(charts, own, bool(len(pairs)), (width, height))
    n = len(charts.split.polygons)
    chart = np.full(n, -1)
    chart[charts.split.face[charts.rows][::-1]] = charts.chart[::-1]
    face = charts.split.face[charts.rows]
    return UVCheck(
        faces=n,
        unmapped=len(charts.unmapped),
        charts=charts.number,
        mirrored=int(charts.mirrored.sum()),
        stacked=int((~own).sum()),
        flips=len(charts.faces_of(charts.flipped)),
        overlaps=len(pairs),
        seams=len(ends),
        seam_length=float(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum()),
        stretch_l2=quality.stretch_l2,
        stretch_linf=quality.stretch_linf,
        angle_distortion=quality.angle_distortion,
        conformal_distortion=quality.conformal_distortion,
        texel_density=float(np.sqrt(flat.sum() * aspect / area.sum()) * width),
        least_density=float(density.min()),
        most_density=float(density.max()),
        texel_spread=quality.texel_spread,
        pages=margins.pages,
        fill=float(flat[own].sum()) / margins.pages,
        margin=margins.between,
        border=margins.border,
        resolution=width if width == height else (width, height),
        limits=limits,
        flipped=charts.faces_of(charts.flipped),
        overlapping=face[pairs],
        chart=chart,
        uv=charts.uv,
        triangles=charts.upright,
        chart_of_triangle=charts.chart,
    )


def _seams(charts: UVCharts) -> FloatArray:
    """The ends of the edges at which the map is cut, (#E, 2, 3)."""
    vertex = merge_coincident(charts.V, np.arange(len(charts.V)))
    return charts.V[texture_seams(vertex[charts.F], charts.F)]
