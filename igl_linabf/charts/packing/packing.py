"""Charts side by side on pages, at one common scale: what is asked for, and the charts in their places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ..._core import narrowest_turns
from ..._types import ComplexArray, FloatArray, IntArray
from ...errors import MeshError, some
from ...surface import (
    Ragged,
    Submesh,
    complex_positions,
    coordinates,
    signed_double_areas,
    times_power_of_two,
)
from .constants import MAX_HULL_POINTS, MAX_MOVED_CHARTS, SINGLE_CHART_TURNS, UDIM_ROW
from .layout_search import Charts, Layout, fixed_layout, largest_layout
from .outlines import outlines, rectangles
from .spacing import Packing, Spacing, given_packing, page_size


@dataclass(frozen=True, eq=False)
class PackedChart:
    """A chart on its page: the point u + iv of what it was is at `ratio * (u + iv) + shift`, in page widths.

    Attributes
    ----------
    ratio : complex
        Turn and scale. Its absolute value is the common scale, the same for all charts.
    shift : complex
    uv : (#V, 2) float64
        The chart's coordinates there, in page widths and heights; NaN at vertices that no face refers to.
    area : float
        Its area there, in pages.
    page : int
        Page k is the square above and right of (k % 10, k // 10), as UDIM tile 1001 + k.
    """

    ratio: complex
    shift: complex
    uv: FloatArray
    area: float
    page: int = 0


def pack_charts(
    charts: Sequence[tuple[ArrayLike, ArrayLike]], packing: Packing | None = None, *, rotate: bool = True
) -> list[PackedChart]:
    """Pack charts into the unit square by similarities of one common scale, without mirroring.

    Parameters
    ----------
    charts : sequence of (uv, F)
        Coordinates (#V, 2) float and triangles (#F, 3) int of each chart, at the relative scale
        they shall keep (that of their 3-D areas).
    packing : Packing, optional
        Its texel density is per unit of length of `uv`.
    rotate : bool
        Turn charts; otherwise they are moved and scaled alone.

    Returns
    -------
    list of PackedChart
        In the order of `charts`; the same for the same input.

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
            given.append(Submesh.checked(uv, F, 2, "uv"))
        except MeshError as error:
            raise MeshError(f"chart {i}: {error}") from None
    wish = replace(Wish.of_maps(packing), fixed=not rotate)
    placed = pack_maps([(chart.V, chart.F) for chart in given], wish)
    return [replace(p, uv=chart.scatter(p.uv)) for chart, p in zip(given, placed, strict=True)]


@dataclass(frozen=True)
class Wish:
    """What a caller asks of the packing, in units of the charts.

    Attributes
    ----------
    spacing : Spacing
    side : float or None
        The width of a page; None: as short as it can be.
    pages : int or None
        At most; None: as many as it takes.
    resolution : (int, int) or None
        Width and height of a page, in texels.
    upright : bool
        Turn several charts by quarter turns only.
    unit : float
        Units of the charts to a unit of the caller.
    fixed : bool
        Do not turn charts.
    unseen : float
        Scale of charts that no ray from outside reaches.
    """

    spacing: Spacing
    side: float | None
    pages: int | None
    resolution: tuple[int, int] | None
    upright: bool = False
    unit: float = 1.0
    fixed: bool = False
    unseen: float = 1.0

    @classmethod
    def of_maps(cls, packing: Packing | None) -> Wish:
        """What the caller asks for of maps without a surface."""
        wish = cls.of(packing)
        if wish.unseen != 1:
            raise ValueError(
                "unseen is for unwrap and pack, which have the surface: leave it out, small charts stay small"
            )
        return wish

    @classmethod
    def of(cls, packing: Packing | None) -> Wish:
        """What the caller asks for; by default one page with a margin."""
        packing = given_packing(packing)
        size, pages = None if packing.resolution is None else page_size(packing.resolution), packing.pages
        if packing.texel_density is None or size is None:
            side, pages = None, 1 if pages is None else pages
        else:
            side = size[0] / packing.texel_density
        return cls(Spacing.of(packing), side, pages, size, unseen=packing.unseen)

    def scaled(self, power: int) -> Wish:
        """The same, for charts that have been scaled by this power of two."""
        if self.side is None:
            return self
        side, unit = (times_power_of_two(number, power) for number in (self.side, self.unit))
        if not 0 < side < np.inf:
            raise MeshError(
                f"a page that is {self.side:g} units of length wide is out of all proportion to a surface of "
                f"about 2**{-power}: change texel_density"
            )
        return replace(self, side=side, unit=unit)


def pack_maps(maps: Sequence[tuple[FloatArray, IntArray]], wish: Wish) -> list[PackedChart]:
    """`pack_charts` of charts that are checked; every vertex has a face."""
    if not maps:
        return []
    z, area, turn, origin, vertices, charts = _prepared(maps, wish)
    layout = _layout(charts, wish)
    z = z * vertices.repeat(layout.turn) + vertices.repeat(layout.corner)
    low, scale = _fitted(z, layout, vertices, wish)
    page, aspect = layout.page, wish.spacing.aspect
    tile = page % UDIM_ROW + 1j * aspect * (page // UDIM_ROW)
    at = tile - scale * low
    z = scale * z + vertices.repeat(at)
    ratio = scale * layout.turn * turn
    shift = scale * (layout.corner - layout.turn * origin) + at
    areas = area * scale**2 / aspect
    rows = zip(ratio.tolist(), shift.tolist(), areas.tolist(), page.tolist(), strict=True)
    bounds = pairwise(vertices.start.tolist())
    uv = coordinates(z) / [1, aspect]
    return [
        PackedChart(by, to, uv[slice(*span)], size, on)
        for span, (by, to, size, on) in zip(bounds, rows, strict=True)
    ]


def pack_quickly(maps: Sequence[tuple[FloatArray, IntArray]], wish: Wish) -> tuple[list[PackedChart], bool]:
    """`pack_maps` by a search without moves; and whether a search has any for so many charts."""
    return pack_maps(maps, replace(wish, resolution=None)), len(maps) <= MAX_MOVED_CHARTS


def fill_of(placed: Sequence[PackedChart]) -> float:
    """The share of the pages that charts cover."""
    return sum(chart.area for chart in placed) / (1 + max(chart.page for chart in placed))


def _prepared(
    maps: Sequence[tuple[FloatArray, IntArray]], wish: Wish
) -> tuple[ComplexArray, FloatArray, ComplexArray, ComplexArray, Ragged, Charts]:
    """Charts turned to their narrowest rectangles, and moved so that these begin at the origin.

    Returns
    -------
    z : (#V,) complex128
        The vertices of all charts, one chart after another.
    area : (#C,) float64
    turn : (#C,) complex128
    origin : (#C,) complex128
        The point of the turned chart that came to the origin.
    vertices : Ragged
        A row of `z` for each chart.
    charts : Charts
    """
    positions, triangles = zip(*maps, strict=True)
    vertices, faces = Ragged.of_sizes(list(map(len, positions))), Ragged.of_sizes(list(map(len, triangles)))
    F = np.concatenate(triangles) + faces.repeat(vertices.start[:-1])[:, None]
    z = complex_positions(np.concatenate(positions))
    area = np.asarray(faces.sum(np.abs(signed_double_areas(z, np.ascontiguousarray(F.T))))) / 2
    extent = rectangles(z, vertices)[1]
    size = np.maximum(extent.real, extent.imag)
    flat = ~(area > 4 * np.finfo(float).eps * size * np.maximum(size, vertices.max(np.abs(z))))
    if flat.any():
        i = int(np.argmax(flat))
        raise MeshError(f"chart {i} has no area (its {len(triangles[i])} faces lie on a line): leave it out")
    if wish.fixed or (wish.upright and len(maps) > 1):
        turn = np.ones(len(maps), np.complex128)
    elif len(maps) == 1:
        turn = np.array([_fittest_turn(z, wish.spacing.aspect)])
    else:
        turn = narrowest_turns(z, vertices.start)
    z = z * vertices.repeat(turn)
    origin, extent = rectangles(z, vertices)
    z -= vertices.repeat(origin)
    charts = Charts(
        outlines(z, F, vertices, faces, area), coordinates(extent), area, wish.upright, wish.fixed
    )
    return z, area, turn, origin, vertices, charts


def _layout(charts: Charts, wish: Wish) -> Layout:
    n, spacing = len(charts.outlines), wish.spacing
    if wish.side is None:
        found = largest_layout(charts, spacing, wish.pages or 1, thorough=wish.resolution is not None)
        if found is None:
            raise MeshError(f"{n} charts do not fit with a margin of {spacing.gap:g}: use a smaller one")
        return found
    found = fixed_layout(charts, wish.side, spacing, wish.pages)
    if found is not None:
        return found
    assert wish.resolution is not None
    wide_page, high_page = wish.resolution
    density = wide_page / wish.side  # texels per unit of the charts
    asked = density * wish.unit
    allowed = "a page" if wish.pages in (None, 1) else f"{wish.pages} pages"
    remedy = "use a smaller density or a larger resolution"
    if wish.pages is not None:
        remedy = "use a smaller density, a larger resolution, or more pages"
    verb = "do" if n > 1 else "does"
    too_large = _too_large(charts, wish.side, spacing)
    if len(too_large):
        wide, high = charts.sizes[too_large[0]] * density
        why = f"chart {too_large[0]} takes {wide:.0f} x {high:.0f}"
        if len(too_large) > 1:
            why = f"charts {some(too_large)} are too large for any; {why}"
    else:
        share = float(charts.areas.sum()) / wish.side**2 / spacing.aspect
        why = f"each one does alone; together they cover {share:.3g} pages, without the gaps between them"
    raise MeshError(
        f"{n} chart{'s' * (n > 1)} at a texel density of {asked:g} {verb} not fit on {allowed} of "
        f"{wide_page} x {high_page} texels ({why}): {remedy}"
    )


def _too_large(charts: Charts, side: float, spacing: Spacing) -> IntArray:
    """The charts that do not fit on a page of this side alone, the longest ones first."""
    short = side * spacing.inner * min(1, spacing.aspect)
    long = np.flatnonzero(charts.sizes.max(axis=1) > short)  # others do as they are
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
    fits = [fixed_layout(chart, side, spacing, 1) is not None for chart in alone]
    return np.asarray(long[~np.array(fits, dtype=bool)])


def _fitted(z: ComplexArray, layout: Layout, vertices: Ragged, wish: Wish) -> tuple[ComplexArray, float]:
    """For each chart, the point that comes to its page's lower left corner; and the scale.

    Pages of a given side have that scale. Others are as large as their charts, which leaves gaps no narrower
    than they were.
    """
    spacing, diagonal = wish.spacing, complex(1, wish.spacing.aspect)
    if wish.side is not None:
        inset = (spacing.gap / 2 - spacing.border) * wish.side
        return np.full(len(vertices), inset * diagonal), 1 / wish.side
    n = int(layout.page.max()) + 1
    lows, highs = rectangles(z, vertices)
    highs += lows
    low = np.full((n, 2), np.inf)
    high = np.full((n, 2), -np.inf)
    np.minimum.at(low, layout.page, coordinates(lows))
    np.maximum.at(high, layout.page, coordinates(highs))
    scale = spacing.inner / float(((high - low) / [1, spacing.aspect]).max())
    return (low @ [1, 1j] - spacing.border * diagonal / scale)[layout.page], scale


def _fittest_turn(z: ComplexArray, aspect: float) -> complex:
    """The turn of a single chart that makes the upright page around it smallest."""
    points = np.column_stack((z.real, z.imag)) - [z.real.mean(), z.imag.mean()]
    axes, sizes, _ = np.linalg.svd(points.T, full_matrices=False)
    # Qhull takes long thin charts as flat: whiten them, which does not change what is on the hull
    hull = z[scipy.spatial.ConvexHull(points @ (axes / sizes)).vertices]
    edges = np.roll(hull, -1) - hull
    turns = edges.conj() / np.abs(edges)
    quarter = np.exp(0.5j * np.pi * np.arange(SINGLE_CHART_TURNS) / SINGLE_CHART_TURNS)
    turns = np.concatenate((turns[:: -(-len(turns) // SINGLE_CHART_TURNS)], quarter))
    if aspect != 1:
        turns = np.concatenate((turns, 1j * turns))
    turned = hull[:: -(-len(hull) // MAX_HULL_POINTS), None] * turns
    width = np.maximum(np.ptp(turned.real, axis=0), np.ptp(turned.imag, axis=0) / aspect)
    return complex(turns[int(width.argmin())])
