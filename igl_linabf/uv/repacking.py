"""Repack the charts of existing texture coordinates."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..charts import Packing, find_unseen_charts, pack_charts, parse_page_size, resolve_packing
from ..errors import MeshError, MeshWarning, first_few, format_count, stack_level
from ..surface import complex_positions, real_coordinates, vertex_array
from .uv_charts import UVCharts

ROUNDING = 1e-14  # maximum area of a chart that counts as zero, relative to its largest coordinate squared

ScaleName = Literal["keep", "even"]
SCALES: tuple[ScaleName, ...] = get_args(ScaleName)


@dataclass(frozen=True, eq=False, repr=False)
class PackedUV:
    """Repacked texture coordinates.

    Attributes
    ----------
    TC : (#TC, 2) float64
        Texture coordinates. Page k is the unit square with the lower left corner (k % 10, k // 10), which is
        the UDIM tile 1001 + k.
    FTC : (#F, 3) int64
        Rows of `TC` at the corners of the faces, in the shape of `F`; -1 at corners without coordinates.
    chart : (#F,) int64
        Chart of each face, or -1.
    page : (#charts,) int64
    fill : float
        Share of the pages that is covered by charts. Stacked charts count once.
    scale : float
        Mean number of page widths per unit of length of V, not counting `unseen` charts. The texel density
        is this number times the page width in texels.
    unseen : (#charts,) bool
        Whether each chart is smaller because it is invisible from outside. All False if `Packing.unseen` is
        1.
    unmapped : int
        Number of faces without texture coordinates. They are left unchanged.
    """

    TC: FloatArray
    FTC: Any  # IntArray or tuple of IntArray
    chart: IntArray
    page: IntArray
    fill: float
    scale: float
    unseen: BoolArray
    unmapped: int

    @property
    def pages(self) -> int:
        """Number of pages."""
        return int(self.page.max(initial=0)) + 1

    def __repr__(self) -> str:
        return f"<PackedUV of {self!s}>"

    def __str__(self) -> str:
        charts, pages = len(self.page), self.pages
        summary = f"{format_count(charts, 'chart')} on {format_count(pages, 'page')}"
        inside = f", {np.count_nonzero(self.unseen):,} unseen and smaller" * bool(self.unseen.any())
        left = f", {format_count(self.unmapped, 'face')} without texture coordinates" * bool(self.unmapped)
        return f"{summary}, {self.fill:.0%} filled{inside}{left}"


def pack(
    V: ArrayLike,
    F: ArrayLike,
    TC: ArrayLike,
    FTC: ArrayLike,
    packing: Packing | None = None,
    *,
    rotate: bool = True,
    scale: ScaleName = "keep",
    labels: ArrayLike | None = None,
) -> PackedUV:
    """Repack the charts of existing texture coordinates without changing their shapes.

    Charts are neither mirrored nor cut. Stacked charts, such as halves that share their texture, stay
    stacked.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) or (#F, k) int, or list of lists of int
        Any triangles or polygons.
    TC : (#TC, 2) float
        Texture coordinates.
    FTC : in the shape of `F`
        Rows of `TC` at the corners, as returned by `igl.readOBJ`; -1 at corners without coordinates.
    packing : Packing, optional
        Resolution of the texture, distances between charts, texel density and pages. By default charts fill
        one page with a margin. If pages are not square, the given coordinates refer to a page of the same
        aspect ratio.
    rotate : bool
        Rotate charts if they then fit better. Use False for textures with a direction, such as wood grain or
        text.
    scale : {"keep", "even"}
        "keep" preserves the relative sizes of charts. "even" gives all charts the same number of texels per
        unit of length of V. In both cases `Packing.unseen` reduces unseen charts, and stacks whose charts are
        all unseen.
    labels : (#F,) int or str, optional
        The image of each face, as in `check_uv`. Charts on different images are not stacked.

    Returns
    -------
    PackedUV

    Raises
    ------
    MeshError
        The arrays are malformed or do not match, no face has texture coordinates with an area, there are too
        many charts for the margin, or the charts do not fit on the pages at the texel density.
    ValueError
        `scale` or `packing` has an invalid value.

    Warns
    -----
    MeshWarning
        Charts without an area in the map are left at the corner of the first page.

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
    charts = UVCharts.from_arrays(V, F, TC, FTC, labels)
    packing = resolve_packing(packing)
    width, height = parse_page_size(packing.resolution or 1)
    aspect = height / width
    flat = np.bincount(charts.chart_of_triangle, np.abs(charts.double_area) / 2, charts.n_charts) * aspect
    area = np.bincount(charts.chart_of_triangle, charts.area_in_space, charts.n_charts)
    sizes = _measure_sizes(charts)
    solid = flat > ROUNDING * sizes**2
    if not solid.any():
        raise MeshError("no face has texture coordinates with an area: unwrap the mesh")
    even = np.full(charts.n_charts, np.sqrt(area[solid].sum() / flat[solid].sum()))
    if scale == "even":
        even[solid] = np.sqrt(area[solid] / flat[solid])
    first = charts.accidental_overlaps[1]
    rows = np.split(
        np.argsort(charts.chart_of_triangle, kind="stable"),
        np.cumsum(np.bincount(charts.chart_of_triangle))[:-1],
    )
    unseen = (
        _find_unseen(V, charts, rows, first) if packing.unseen != 1 else np.zeros(charts.n_charts, dtype=bool)
    )
    even[unseen] *= packing.unseen
    own = np.flatnonzero(solid & (first == np.arange(charts.n_charts)))
    z = complex_positions(charts.uv * [1, aspect])
    maps = []
    for i in own.tolist():
        used, local = np.unique(charts.upright_triangles[rows[i]], return_inverse=True)
        corner = z[used].real.min() + 1j * z[used].imag.min()
        maps.append((real_coordinates(even[i] * (z[used] - corner)), local.reshape(-1, 3), corner))
    placed = pack_charts([(uv, faces) for uv, faces, _ in maps], replace(packing, unseen=1.0), rotate=rotate)
    turn, shift = np.zeros((2, charts.n_charts), dtype=np.complex128)
    page = np.zeros(charts.n_charts, dtype=np.int64)
    stack = np.where(solid, first, np.arange(charts.n_charts))
    for i, new, (_, _, corner) in zip(own.tolist(), placed, maps, strict=True):
        turn[i] = new.ratio * even[i]
        shift[i], page[i] = new.shift - turn[i] * corner, new.page
    lost = charts.get_input_faces(~solid[charts.chart_of_triangle])
    if len(lost):
        text = (
            f"the charts of faces {first_few(lost)} have no area in the map and are left at the page's corner"
        )
        warnings.warn(f"{text}: unwrap the mesh to give them an area", MeshWarning, stacklevel=stack_level())
    fill = sum(new.area for new in placed) / (1 + max(new.page for new in placed))
    turned = z, turn[stack], shift[stack]
    return _build_packed_uv(charts, turned, aspect, page[stack], fill, abs(placed[0].ratio), unseen)


def _find_unseen(V: ArrayLike, charts: UVCharts, rows: list[IntArray], first: IntArray) -> BoolArray:
    """Return a mask of the charts in invisible stacks; `first` is the first chart of each stack."""
    seen = ~find_unseen_charts(vertex_array(V), charts.split.F, [charts.rows[own] for own in rows])
    return np.asarray(np.bincount(first, seen, charts.n_charts)[first] == 0)


def _measure_sizes(charts: UVCharts) -> FloatArray:
    """Return the largest coordinate of each chart."""
    size = np.zeros(charts.n_charts)
    np.maximum.at(size, charts.chart_of_triangle, np.abs(charts.uv[charts.F]).max(axis=(1, 2)))
    return size


def _build_packed_uv(
    charts: UVCharts,
    turned: tuple[ComplexArray, ComplexArray, ComplexArray],
    aspect: float,
    page: IntArray,
    fill: float,
    scale: float,
    unseen: BoolArray,
) -> PackedUV:
    """Build the result with a row of `TC` for each distinct point of each chart.

    `turned` has the old positions in page widths, and the rotation and translation of each chart.
    """
    old, turn, shift = turned
    key = np.column_stack((charts.chart_of_triangle.repeat(3), charts.F.ravel()))
    pairs, corner = np.unique(key, axis=0, return_inverse=True)
    z = old[pairs[:, 1]] * turn[pairs[:, 0]] + shift[pairs[:, 0]]
    polygons = charts.split.polygons
    at, faces = np.full((len(charts.split.F), 3), -1), np.full(len(polygons), -1)
    at[charts.rows] = corner.reshape(-1, 3)
    # triangles without area in space get the coordinates of their neighbours
    place = np.zeros(len(charts.uv), dtype=np.int64)
    place[pairs[::-1, 1]] = np.arange(len(pairs))[::-1]
    at[charts.rows_aside] = place[charts.F_aside]
    faces[charts.split.face[charts.rows][::-1]] = charts.chart_of_triangle[::-1]
    known = charts.split.convert_to_polygon_corners(at)
    TC, FTC = real_coordinates(z) / [1, aspect], polygons.reshape_like_faces(known)
    return PackedUV(TC, FTC, faces, page, fill, scale, unseen, len(charts.unmapped))
