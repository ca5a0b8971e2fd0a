"""Pack charts onto pages at one common scale, with options such as the resolution of a texture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ..._core import min_rectangle_rotations
from ..._types import ComplexArray, FloatArray, IntArray
from ...errors import MeshError, first_few
from ...surface import (
    Ragged,
    Submesh,
    complex_positions,
    multiply_by_power_of_two,
    real_coordinates,
    signed_double_areas,
)
from .layout_search import OBLIQUE_GAIN, Layout, UnplacedCharts, find_fixed_layout, find_largest_layout
from .outlines import find_bounding_rectangles, make_outlines
from .spacing import Packing, Spacing, parse_page_size, resolve_packing

HALF_FULL = 0.5  # default of `Packing.cut_below` if no resolution is given
FIRST_UDIM_TILE = 1001
UDIM_ROW = 10  # number of pages in a row: UDIM tile 1001 + k is in column k % 10
SINGLE_CHART_TURNS = 1_000  # rotations within 90 degrees that are tried for a single chart
MAX_HULL_POINTS = 2_000  # maximum number of convex hull points that are rotated to size a page


@dataclass(frozen=True, eq=False)
class PackedChart:
    """A chart on its page. Its point u + iv is placed at `ratio * (u + iv) + shift`, in page widths.

    Attributes
    ----------
    ratio : complex
        Rotation and scale. The absolute value is the common scale of all charts.
    shift : complex
    uv : (#V, 2) float64
        Coordinates on the page, in page widths and heights; NaN at vertices without faces.
    area : float
        Area on the page, as a share of the page.
    page : int
        Index of the page. Page k is the unit square at (k % 10, k // 10), UDIM tile 1001 + k.
    """

    ratio: complex
    shift: complex
    uv: FloatArray
    area: float
    page: int = 0


def pack_charts(
    charts: Sequence[tuple[ArrayLike, ArrayLike]], packing: Packing | None = None, *, rotate: bool = True
) -> list[PackedChart]:
    """Pack charts into the unit square by similarities with one common scale, without mirroring.

    Parameters
    ----------
    charts : sequence of (uv, F)
        Coordinates (#V, 2) float and triangles (#F, 3) int of each chart, at the relative scale that
        they keep (usually the scale of their 3-D areas).
    packing : Packing, optional
        Packing options. The texel density is per unit of length of `uv`.
    rotate : bool
        Whether charts may be rotated. Otherwise they are only moved and scaled.

    Returns
    -------
    list of PackedChart
        In the order of `charts`. The result is deterministic.

    Raises
    ------
    MeshError
        A chart has no area or coordinates that are not finite, there are too many charts for the margin,
        or they do not fit on the pages at the texel density.
    ValueError
        A number is out of its range.

    Examples
    --------
    >>> import numpy as np
    >>> square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]), np.array([[0, 1, 2], [0, 2, 3]])
    >>> placed = pack_charts([square] * 4)
    >>> sum(chart.area for chart in placed) > 0.95
    True
    >>> [chart.page for chart in pack_charts([square] * 3, Packing(resolution=64, texel_density=40))]
    [0, 1, 2]
    """
    given = []
    for i, (uv, F) in enumerate(charts):
        try:
            given.append(Submesh.from_input(uv, F, 2, "uv"))
        except MeshError as error:
            raise MeshError(f"chart {i}: {error}") from None
    request = replace(PackingRequest.for_maps_without_surface(packing), fixed=not rotate)
    placed = pack_maps([(chart.V, chart.F) for chart in given], request)
    return [replace(p, uv=chart.scatter_to_input(p.uv)) for chart, p in zip(given, placed, strict=True)]


@dataclass(frozen=True)
class PackingRequest:
    """Packing options, converted to the charts' units of length.

    Attributes
    ----------
    spacing : Spacing
    side : float or None
        The width of a page; None for the shortest possible width.
    pages : int or None
        The maximum number of pages; None for any number.
    resolution : (int, int) or None
        Width and height of a page, in texels.
    upright : bool
        Turn charts by quarter turns only, if there are several.
    unit : float
        Length of the input's unit, in units of the charts.
    fixed : bool
        Do not turn charts.
    unseen : float
        Scale of charts that are invisible from outside, relative to all other charts.
    cut_below : float
        Cut charts further if they cover less than this share of the page.
    """

    spacing: Spacing
    side: float | None
    pages: int | None
    resolution: tuple[int, int] | None
    upright: bool = False
    unit: float = 1.0
    fixed: bool = False
    unseen: float = 1.0
    cut_below: float = 0.0

    @classmethod
    def for_maps_without_surface(cls, packing: Packing | None) -> PackingRequest:
        """Return the request for maps without a surface, for which `unseen` and `cut_below` are rejected."""
        request = cls.from_packing(packing)
        if packing is not None and packing.cut_below is not None:
            raise ValueError("cut_below is for unwrap, which can cut charts: leave it out")
        if request.unseen != 1:
            raise ValueError(
                "unseen is for unwrap and pack, which have the surface: leave it out, small charts stay small"
            )
        return request

    @classmethod
    def from_packing(cls, packing: Packing | None) -> PackingRequest:
        """Convert a `Packing` to a request; by default one page with a margin."""
        packing = resolve_packing(packing)
        size, pages = (
            None if packing.resolution is None else parse_page_size(packing.resolution),
            packing.pages,
        )
        if packing.texel_density is None or size is None:
            side, pages = None, 1 if pages is None else pages
        else:
            side = size[0] / packing.texel_density
        below = (HALF_FULL if size is None else 1.0) if packing.cut_below is None else packing.cut_below
        return cls(Spacing.from_packing(packing), side, pages, size, unseen=packing.unseen, cut_below=below)

    def scale_by_power(self, power: int) -> PackingRequest:
        """Return the request for charts that have been scaled by 2**power."""
        if self.side is None:
            return self
        side, unit = (multiply_by_power_of_two(number, power) for number in (self.side, self.unit))
        if not 0 < side < np.inf:
            raise MeshError(
                f"a page that is {self.side:g} units of length wide is out of all proportion to a surface of "
                f"about 2**{-power}: change texel_density"
            )
        return replace(self, side=side, unit=unit)


def pack_maps(maps: Sequence[tuple[FloatArray, IntArray]], request: PackingRequest) -> list[PackedChart]:
    """Pack charts like `pack_charts`, without checks; every vertex must have a face."""
    if not maps:
        return []
    request = replace(request, spacing=request.spacing.adapt_to_number_of_charts(len(maps)))
    z, area, turn, origin, vertices, charts = _prepare_charts(maps, request)
    layout = _find_layout(charts, request)
    z = z * vertices.repeat(layout.turn) + vertices.repeat(layout.corner)
    low, scale = _fit_to_pages(z, layout, vertices, request)
    page, aspect = layout.page, request.spacing.aspect
    tile = page % UDIM_ROW + 1j * aspect * (page // UDIM_ROW)
    at = tile - scale * low
    z = scale * z + vertices.repeat(at)
    ratio = scale * layout.turn * turn
    shift = scale * (layout.corner - layout.turn * origin) + at
    areas = area * scale**2 / aspect
    rows = zip(ratio.tolist(), shift.tolist(), areas.tolist(), page.tolist(), strict=True)
    bounds = pairwise(vertices.start.tolist())
    uv = real_coordinates(z) / [1, aspect]
    return [
        PackedChart(by, to, uv[slice(*span)], size, on)
        for span, (by, to, size, on) in zip(bounds, rows, strict=True)
    ]


def measure_fill(placed: Sequence[PackedChart]) -> float:
    """Return the share of the pages that charts cover."""
    return sum(chart.area for chart in placed) / (1 + max(chart.page for chart in placed))


def _prepare_charts(
    maps: Sequence[tuple[FloatArray, IntArray]], request: PackingRequest
) -> tuple[ComplexArray, FloatArray, ComplexArray, ComplexArray, Ragged, UnplacedCharts]:
    """Rotate charts to their narrowest bounding rectangles, and move the lower left corners to the origin.

    Returns
    -------
    z : (#V,) complex128
        The vertices of all charts, one chart after another.
    area : (#C,) float64
    turn : (#C,) complex128
    origin : (#C,) complex128
        The point of each rotated chart that was moved to the origin.
    vertices : Ragged
        The vertices of each chart, row indices into `z`.
    charts : Charts
    """
    positions, triangles = zip(*maps, strict=True)
    vertices, faces = (
        Ragged.from_sizes(list(map(len, positions))),
        Ragged.from_sizes(list(map(len, triangles))),
    )
    F = np.concatenate(triangles) + faces.repeat(vertices.start[:-1])[:, None]
    z = complex_positions(np.concatenate(positions))
    area = np.asarray(faces.sum(np.abs(signed_double_areas(z, np.ascontiguousarray(F.T))))) / 2
    extent = find_bounding_rectangles(z, vertices)[1]
    size = np.maximum(extent.real, extent.imag)
    flat = ~(area > 4 * np.finfo(float).eps * size * np.maximum(size, vertices.max(np.abs(z))))
    if flat.any():
        i = int(np.argmax(flat))
        raise MeshError(f"chart {i} has no area (its {len(triangles[i])} faces lie on a line): leave it out")
    if request.fixed or (request.upright and len(maps) > 1):
        turn = np.ones(len(maps), np.complex128)
    else:
        turn = min_rectangle_rotations(z, vertices.start)
        if len(maps) == 1:
            is_straight = make_outlines(z * turn, F, vertices, area)[0].is_straight
            turn = turn * _find_best_rotation(z * turn, request.spacing.aspect, is_straight)
    z = z * vertices.repeat(turn)
    origin, extent = find_bounding_rectangles(z, vertices)
    z -= vertices.repeat(origin)
    charts = UnplacedCharts(
        make_outlines(z, F, vertices, area), real_coordinates(extent), area, request.upright, request.fixed
    )
    return z, area, turn, origin, vertices, charts


def _find_layout(charts: UnplacedCharts, request: PackingRequest) -> Layout:
    """Find the layout of charts, or raise a `MeshError` that states why they do not fit."""
    n, spacing = len(charts.outlines), request.spacing
    if request.side is None:
        found = find_largest_layout(charts, spacing, request.pages or 1)
        if found is None:
            raise MeshError(f"{n} charts do not fit with a margin of {spacing.gap:g}: use a smaller one")
        return found
    found = find_fixed_layout(charts, request.side, spacing, request.pages)
    if found is not None:
        return found
    assert request.resolution is not None
    wide_page, high_page = request.resolution
    density = wide_page / request.side  # texels per unit of length of the charts
    asked = density * request.unit
    allowed = "a page" if request.pages in (None, 1) else f"{request.pages} pages"
    remedy = "use a smaller density or a larger resolution"
    if request.pages is not None:
        remedy = "use a smaller density, a larger resolution, or more pages"
    verb = "do" if n > 1 else "does"
    too_large = _find_charts_larger_than_page(charts, request.side, spacing)
    if len(too_large):
        wide, high = charts.sizes[too_large[0]] * density
        why = f"chart {too_large[0]} takes {wide:.0f} x {high:.0f}"
        if len(too_large) > 1:
            why = f"charts {first_few(too_large)} are too large for any page; {why}"
    else:
        share = float(charts.areas.sum()) / request.side**2 / spacing.aspect
        why = f"each one fits alone; together they cover {share:.3g} pages, without the gaps between them"
    raise MeshError(
        f"{n} chart{'s' * (n > 1)} at a texel density of {asked:g} {verb} not fit on {allowed} of "
        f"{wide_page} x {high_page} texels ({why}): {remedy}"
    )


def _find_charts_larger_than_page(charts: UnplacedCharts, side: float, spacing: Spacing) -> IntArray:
    """Return the charts that do not fit on an empty page of this side, longest first."""
    short = side * spacing.inner_width * min(1, spacing.aspect)
    long = np.flatnonzero(charts.sizes.max(axis=1) > short)  # shorter charts fit in any direction
    long = long[np.argsort(-charts.sizes[long].max(axis=1), kind="stable")]
    alone = (
        replace(
            charts,
            outlines=[charts.outlines[i]],
            sizes=charts.sizes[i : i + 1],
            areas=charts.areas[i : i + 1],
        )
        for i in long.tolist()
    )
    fits = [find_fixed_layout(chart, side, spacing, 1) is not None for chart in alone]
    return np.asarray(long[~np.array(fits, dtype=bool)])


def _fit_to_pages(
    z: ComplexArray, layout: Layout, vertices: Ragged, request: PackingRequest
) -> tuple[ComplexArray, float]:
    """Return for each chart the point at its page's lower left corner, and the scale of the charts.

    If the side of the pages is given, it determines the scale. Otherwise the pages shrink to the size of
    their charts, while the gaps keep their width.
    """
    spacing, diagonal = request.spacing, complex(1, request.spacing.aspect)
    if request.side is not None:
        inset = (spacing.gap / 2 - spacing.border) * request.side
        return np.full(len(vertices), inset * diagonal), 1 / request.side
    n = int(layout.page.max()) + 1
    lows, highs = find_bounding_rectangles(z, vertices)
    highs += lows
    low = np.full((n, 2), np.inf)
    high = np.full((n, 2), -np.inf)
    np.minimum.at(low, layout.page, real_coordinates(lows))
    np.maximum.at(high, layout.page, real_coordinates(highs))
    scale = spacing.inner_width / float(((high - low) / [1, spacing.aspect]).max())
    return (low @ [1, 1j] - spacing.border * diagonal / scale)[layout.page], scale


def _find_best_rotation(z: ComplexArray, aspect: float, is_straight: bool) -> complex:
    """Return the turn of a single chart that minimises the size of the page around it.

    A straight chart, whose sides are along the axes, stays there unless the turn saves `OBLIQUE_GAIN`.
    """
    points = np.column_stack((z.real, z.imag)) - [z.real.mean(), z.imag.mean()]
    axes, sizes, _ = np.linalg.svd(points.T, full_matrices=False)
    # Qhull treats long thin charts as flat. Scaling to equal variances keeps the vertices of the hull.
    hull = z[scipy.spatial.ConvexHull(points @ (axes / sizes)).vertices]
    edges = np.roll(hull, -1) - hull
    turns = edges.conj() / np.abs(edges)
    quarter = np.exp(0.5j * np.pi * np.arange(SINGLE_CHART_TURNS) / SINGLE_CHART_TURNS)
    turns = np.concatenate((quarter, turns[:: -(-len(turns) // SINGLE_CHART_TURNS)]))
    if aspect != 1:
        turns = np.concatenate((turns, 1j * turns))
    turned = hull[:: -(-len(hull) // MAX_HULL_POINTS), None] * turns
    width = np.maximum(np.ptp(turned.real, axis=0), np.ptp(turned.imag, axis=0) / aspect)
    if is_straight:
        along = np.minimum(np.abs(turns.real), np.abs(turns.imag)) < 1e-9
        width = np.where(along, width * np.sqrt(1 - OBLIQUE_GAIN), width)
    return complex(turns[int(width.argmin())])
