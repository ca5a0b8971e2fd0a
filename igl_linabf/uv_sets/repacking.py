"""The charts of texture coordinates that a mesh has, packed anew."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..charts import Packing, are_unseen, given_packing, pack_charts, page_size
from ..errors import MeshError, MeshWarning, some, stack_level
from ..surface import complex_positions, coordinates, vertex_array
from .constants import ROUNDING
from .uv_charts import UVCharts

ScaleName = Literal["keep", "even"]
SCALES: tuple[ScaleName, ...] = get_args(ScaleName)


@dataclass(frozen=True, eq=False, repr=False)
class PackedUV:
    """Texture coordinates whose charts were packed anew.

    Attributes
    ----------
    TC : (#TC, 2) float64
        Texture coordinates; of page k in the unit square above and right of (k % 10, k // 10), as UDIM tile
        1001 + k.
    FTC : (#F, 3) int64
        Their rows at the corners of the faces, in the shape of `F`; -1 where there were none.
    chart : (#F,) int64
        The chart of each face; -1 without one.
    page : (#charts,) int64
    fill : float
        Share of the pages that charts cover; of a stack one counts.
    scale : float
        Page widths per unit of length of V, on average over charts that are not `unseen`. Times the width in
        texels it is the texel density.
    unseen : (#charts,) bool
        Which charts are smaller as no ray from outside reaches them; none if `Packing.unseen` is 1.
    """

    TC: FloatArray
    FTC: Any  # IntArray, or a tuple of them
    chart: IntArray
    page: IntArray
    fill: float
    scale: float
    unseen: BoolArray

    @property
    def pages(self) -> int:
        """Their number."""
        return int(self.page.max(initial=0)) + 1

    def __repr__(self) -> str:
        return f"<PackedUV of {self!s}>"

    def __str__(self) -> str:
        charts, pages = len(self.page), self.pages
        said = f"{charts:,} chart{'s' * (charts != 1)} on {pages} page{'s' * (pages != 1)}"
        inside = f", {np.count_nonzero(self.unseen):,} unseen and smaller" * bool(self.unseen.any())
        return f"{said}, {self.fill:.0%} filled{inside}"


def pack(
    V: ArrayLike,
    F: ArrayLike,
    TC: ArrayLike,
    FTC: ArrayLike,
    packing: Packing | None = None,
    *,
    rotate: bool = True,
    scale: ScaleName = "keep",
) -> PackedUV:
    """Pack the charts of texture coordinates that a mesh has anew, without changing their shapes.

    No chart is mirrored or cut. Charts that lie on each other, as halves that share their texture, stay so.

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
    packing : Packing, optional
        The texture's resolution, distances between charts, texel density and pages. By default charts fill
        one page with a margin. Charts of a page that is not square are taken from one of the same aspect.
    rotate : bool
        Turn charts where they then fit better. Otherwise they are moved and scaled alone, as wood grain or
        text in a texture needs.
    scale : {"keep", "even"}
        "keep": the charts' sizes relative to each other stay. "even": each gets as many texels per unit of
        length of V as the others. `Packing.unseen` makes charts smaller than that in both cases, and
        stacks of which all charts are unseen.

    Returns
    -------
    PackedUV

    Raises
    ------
    MeshError
        The arrays are malformed or do not fit together, no face has texture coordinates with an area, there
        are too many charts for the margin, or they do not fit on the pages at the texel density.
    ValueError
        `scale` or `packing` is none of the above.

    Warns
    -----
    MeshWarning
        Charts without an area in the map were left at the corner of the first page.

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F)
    >>> packed = pack(V, F, atlas.TC, atlas.FTC, igl_linabf.Packing(resolution=512, padding=8), rotate=False)
    >>> packed.pages, packed.FTC.shape
    (1, (20, 3))
    >>> igl_linabf.check_uv(V, F, packed.TC, packed.FTC, resolution=512, min_margin=8).good
    True
    """
    if scale not in SCALES:
        raise ValueError(f"scale is {scale!r}: use one of {', '.join(map(repr, SCALES))}")
    charts = UVCharts.of(V, F, TC, FTC)
    packing = given_packing(packing)
    width, height = page_size(packing.resolution or 1)
    aspect = height / width
    flat = np.bincount(charts.chart, np.abs(charts.double_area) / 2, charts.number) * aspect
    area = np.bincount(charts.chart, charts.area, charts.number)
    sizes = _sizes(charts)
    solid = flat > ROUNDING * sizes**2
    if not solid.any():
        raise MeshError("no face has texture coordinates with an area: unwrap the mesh")
    even = np.full(charts.number, np.sqrt(area[solid].sum() / flat[solid].sum()))
    if scale == "even":
        even[solid] = np.sqrt(area[solid] / flat[solid])
    first = charts.overlaps[1]
    rows = np.split(np.argsort(charts.chart, kind="stable"), np.cumsum(np.bincount(charts.chart))[:-1])
    unseen = _unseen(V, charts, rows, first) if packing.unseen != 1 else np.zeros(charts.number, dtype=bool)
    even[unseen] *= packing.unseen
    own = np.flatnonzero(solid & (first == np.arange(charts.number)))
    z = complex_positions(charts.uv * [1, aspect])
    maps = []
    for i in own.tolist():
        used, local = np.unique(charts.upright[rows[i]], return_inverse=True)
        corner = z[used].real.min() + 1j * z[used].imag.min()
        maps.append((coordinates(even[i] * (z[used] - corner)), local.reshape(-1, 3), corner))
    placed = pack_charts([(uv, faces) for uv, faces, _ in maps], replace(packing, unseen=1.0), rotate=rotate)
    turn, shift = np.zeros((2, charts.number), dtype=np.complex128)
    page = np.zeros(charts.number, dtype=np.int64)
    stack = np.where(solid, first, np.arange(charts.number))
    for i, new, (_, _, corner) in zip(own.tolist(), placed, maps, strict=True):
        turn[i] = new.ratio * even[i]
        shift[i], page[i] = new.shift - turn[i] * corner, new.page
    lost = charts.faces_of(~solid[charts.chart])
    if len(lost):
        said = f"the charts of faces {some(lost)} have no area in the map and are left at the page's corner"
        warnings.warn(f"{said}: unwrap the mesh to give them one", MeshWarning, stacklevel=stack_level())
    fill = sum(new.area for new in placed) / (1 + max(new.page for new in placed))
    turned = z, turn[stack], shift[stack]
    return _packed_uv(charts, turned, aspect, page[stack], fill, abs(placed[0].ratio), unseen)


def _unseen(V: ArrayLike, charts: UVCharts, rows: list[IntArray], first: IntArray) -> BoolArray:
    """Which charts no ray from outside reaches, nor any of their stack, of which `first` is the first."""
    seen = ~are_unseen(vertex_array(V), charts.split.F, [charts.rows[own] for own in rows])
    return np.asarray(np.bincount(first, seen, charts.number)[first] == 0)


def _sizes(charts: UVCharts) -> FloatArray:
    """The largest coordinate of each chart, against which areas are told from rounding."""
    size = np.zeros(charts.number)
    np.maximum.at(size, charts.chart, np.abs(charts.uv[charts.F]).max(axis=(1, 2)))
    return size


def _packed_uv(
    charts: UVCharts,
    turned: tuple[ComplexArray, ComplexArray, ComplexArray],
    aspect: float,
    page: IntArray,
    fill: float,
    scale: float,
    unseen: BoolArray,
) -> PackedUV:
    """The charts moved; a row of `TC` is of one chart, and of one place in the map.

    `turned` are the old places in page widths, and turn and shift of each chart.
    """
    old, turn, shift = turned
    key = np.column_stack((charts.chart.repeat(3), charts.F.ravel()))
    pairs, corner = np.unique(key, axis=0, return_inverse=True)
    z = old[pairs[:, 1]] * turn[pairs[:, 0]] + shift[pairs[:, 0]]
    polygons = charts.split.polygons
    at, faces = np.full((len(charts.split.F), 3), -1), np.full(len(polygons), -1)
    at[charts.rows] = corner.reshape(-1, 3)
    # what has no area in space is where its neighbours are, or anywhere
    place = np.zeros(len(charts.uv), dtype=np.int64)
    place[pairs[::-1, 1]] = np.arange(len(pairs))[::-1]
    at[charts.rows_aside] = place[charts.F_aside]
    faces[charts.split.face[charts.rows][::-1]] = charts.chart[::-1]
    known = charts.split.at_corners(at)
    return PackedUV(coordinates(z) / [1, aspect], polygons.shape(known), faces, page, fill, scale, unseen)
