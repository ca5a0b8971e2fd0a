"""Unwrap any surface: cut it, flatten its charts without overlaps, and pack them."""

from __future__ import annotations

import sys
import warnings
from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from .._core import lengths
from .._runtime import Progress, progress_part, show_progress
from .._types import FloatArray, IntArray
from ..errors import (
    FallbackWarning,
    MeshWarning,
    OutcomeWarning,
    first_few,
    format_count,
    stack_level,
    takes_vertices_and_faces,
)
from ..flattening import Method, MethodOptions
from ..measures import measure_quality
from ..surface import (
    Cleaned,
    Ragged,
    Submesh,
    clean_surface,
    complex_positions,
    find_flipped_faces,
    mark_coincident_edges,
    wrap_sound_surface,
)
from . import constants
from .atlas import (
    Atlas,
    AtlasBounds,
    AtlasReport,
    Chart,
    compute_division_price,
    convert_repairs_to_polygons,
    convert_seams_to_triangles,
    convert_to_given_mesh,
    convert_to_polygons,
    find_seams_and_mismatch,
    make_empty_atlas,
    mark_diagonals,
    split_polygons,
)
from .charting import cut_into_pieces, make_charts
from .cones import NO_CONES, ConeCharts, Cones, GivenCones, SurfaceCones, make_charts_with_cones
from .costing import measure_cost
from .features import CreasedSurface, compute_hiding_weights, find_unseen_charts
from .options import ChartOptions, ChartRules, resolve_method_of_charts, resolve_options
from .packing import (
    MOST_TRIAL_CHARTS,
    PackedChart,
    Packing,
    PackingRequest,
    cut_for_fill,
    cut_to_fit,
    measure_fill,
    pack_maps,
)
from .periodic import shift_by_period
from .trade_search import search_trade

if sys.version_info >= (3, 11):
    from typing import Unpack
elif TYPE_CHECKING:
    from typing_extensions import Unpack

MAX_MARGIN_SHARE = 0.64  # maximum share of a page that the margins around charts may cover
SEARCHED_OVER_TRIAL = 0.88  # a full search makes a page smaller than a quick trial, at most by this factor
MAX_SPARSE_FILL = 0.57  # with many charts, do not cut charts if they cover more than this share of the page
MIN_FILL_GAIN = 1.25  # with `cut_below` below 1, cuts must make the page fuller by this factor


@takes_vertices_and_faces
def unwrap(
    V: ArrayLike,
    F: ArrayLike,
    seams: ArrayLike | None = None,
    *,
    charts: ChartOptions | None = None,
    method: str | Method | None = None,
    cones: Cones | GivenCones | None = None,
    packing: Packing | None = None,
    weld: float | Literal[False] | None = None,
    strict: bool = False,
    progress: Progress = None,
    **options: Unpack[MethodOptions],
) -> Atlas:
    """Cut any surface into charts, flatten them without overlaps, and pack them.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions, finite at all vertices of faces.
    F : (#F, 3) or (#F, k) int, or list of lists of int
        Any triangles, quadrangles or polygons. A mesh that is not a clean oriented manifold is repaired by
        `clean`. Seams follow the edges of polygons, never the diagonals that split them.
    seams : (#E, 2) int or (#F, 3) bool, optional
        The edges to cut, in the formats of `cut`; a mask has the shape of `F`. By default `find_seams` finds
        the seams. Only given seams are cut, unless the map of a chart overlaps or exceeds `max_stretch`. Such
        charts are split along further edges, with a warning; `atlas.added_seams` has these edges.
    charts : ChartOptions, optional
        How charts are made: how long seams may be to reduce stretch (`ChartOptions(trade=30)`), where they
        are hidden, whether given seams are extended, and how holes, stretch and overlaps are treated.
    method : str or method object, optional
        The method that flattens the charts, see `flatten`; by default "isometric", and "linabf" with `cones`.
    cones : Cones, (#C,) int, int or "auto", optional
        Vertices that keep all curvature, or the number of cones to find on each component, or `Cones` with
        their angles and the period of a texture. Needs "linabf" or "abf". Cannot be combined with `seams`
        or `charts`.
    packing : Packing, optional
        The texture's resolution, distances between charts, texel density and pages. By default charts fill
        one page with a margin.
    weld : float or False, optional
        Distance up to which vertices are merged, see `clean`.
    strict : bool
        Raise an error if the mesh is not a clean oriented manifold, instead of repairing it.
    progress : callable or False, optional
        Progress bar, see `flatten`.
    **options
        Options of the method, see `flatten`.

    Returns
    -------
    Atlas

    Raises
    ------
    MeshError
        The arrays are malformed, a coordinate at a face is NaN or infinite, a seam is not an edge, or a chart
        has handles or no boundary after cutting the given seams, and `ChartOptions.extend` is False. A cone
        is not an interior vertex, there are too few cones, or their angles violate Gauss-Bonnet; the message
        has the required numbers. The period is too long for the distances of the cones; the message has a
        shorter period. With `strict`, also: the surface is not an oriented manifold, or a face has no area.
        With a texel density, also: the charts do not fit on the pages.
    ValueError
        `weld` is out of its range, options cannot be combined, or an option is unknown; the message says
        whether it is an option of `charts`, `packing` or `cones`.

    Warns
    -----
    FallbackWarning
        Edges are cut in addition to the given seams; the message has their number and the reasons. Or charts
        are flattened with `guarantee="injective"`, because no seams were found that prevent flips.
    MeshWarning
        The mesh was repaired, or its vertices were welded; `atlas.report.repairs` has the details. Or fewer
        than half of the boundary edges coincide with other boundary edges. Charts end there unless `weld=0`.
    OutcomeWarning
        A chart has flipped faces, still overlaps itself, or is stretched beyond use. Or no atlas was found
        that meets `max_dirichlet` and `max_charts`.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> atlas = unwrap(V, F)
    >>> len(atlas.charts), atlas.good, atlas.FTC.shape
    (1, True, (20, 3))
    >>> atlas = unwrap(V, F, packing=Packing(resolution=1024, padding=2))

    The texture coordinates of quadrangles have the shape of the quadrangles:

    >>> V = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    >>> F = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    >>> unwrap(V, F).FTC.shape
    (6, 4)
    """
    chosen = resolve_method_of_charts(method, cones, options)
    asked, wanted, request = resolve_options(seams, charts, cones, packing)
    split = split_polygons(V, F)
    if split is not None:
        F = split.F
        if seams is not None:
            seams = convert_seams_to_triangles(seams, split, len(np.asarray(V)))
    if strict:
        surface = Submesh.manifold_from_input(V, F)
        cleaned = wrap_sound_surface(surface)
    else:
        cleaned, surface = clean_surface(V, F, weld)
    as_given, given = surface.vertices is cleaned.origin, np.asarray(F).astype(np.int64)
    if split is not None:
        surface = mark_diagonals(surface, cleaned, split)
        cleaned = replace(cleaned, repairs=convert_repairs_to_polygons(cleaned.repairs, split))
    _warn_of_repairs(cleaned)
    if not len(surface.F):
        atlas = make_empty_atlas(cleaned, given)
        return atlas if split is None else convert_to_polygons(atlas, split)
    if weld is None:
        _warn_of_doubled_edges(surface, cleaned)
    face = np.arange(len(given)) if split is None else split.face
    source = _Source(surface, cleaned, seams, given, asked.label_faces(face))
    hidden = compute_hiding_weights(surface, asked.hide, face)
    rules = ChartRules.from_options(chosen, asked, seams is not None, hidden)
    creased = CreasedSurface(surface, rules.hidden)

    def make_atlas(trade: float) -> Atlas:
        atlas = _unwrap_surface(source, creased, wanted, request, replace(rules, trade=trade))
        bounds = AtlasBounds(asked.max_stretch, asked.max_dirichlet, asked.max_charts, trade)
        return replace(atlas, report=replace(atlas.report, bounds=bounds))

    with show_progress(progress):
        atlas = search_trade(make_atlas, asked) if asked.bounds_atlas else make_atlas(asked.trade)
    if not as_given:
        atlas = convert_to_given_mesh(atlas, cleaned, given)
    if split is not None:
        atlas = convert_to_polygons(atlas, split)
    if seams is not None and not asked.extend:
        _warn_of_added_seams(atlas)
    for trouble in atlas.troubles:
        warnings.warn(trouble, OutcomeWarning, stacklevel=stack_level())
    return atlas


@dataclass(frozen=True, eq=False)
class _Source:
    """The repaired surface of a call of `unwrap`, and the edges that charts must not cross."""

    surface: Submesh
    cleaned: Cleaned
    seams: ArrayLike | None
    F: IntArray  # the triangles before the repair
    labels: IntArray | None


def _unwrap_surface(
    source: _Source, creased: CreasedSurface, wanted: Cones | None, request: PackingRequest, rules: ChartRules
) -> Atlas:
    """Cut, flatten and pack the repaired surface; return an atlas of the repaired surface."""
    surface, cleaned = source.surface, source.cleaned
    kept = np.zeros((0, 2), dtype=np.int64)
    if wanted is None:
        with progress_part("seams", constants.SEAMS_END):
            pieces, kept = cut_into_pieces(surface, cleaned, source.seams, source.F, source.labels, rules)
        made = ConeCharts(make_charts(pieces, kept, rules), *NO_CONES)
    else:
        placed = SurfaceCones.from_options(wanted, surface, cleaned)
        ends = constants.SEAMS_END, constants.CHARTS_END
        made = make_charts_with_cones(surface, placed, rules.method, ends)
    with progress_part("packing", 1.0):
        atlas = _pack_charts(creased, made, request.scale_by_power(cleaned.power), wanted, rules)
    report = replace(
        atlas.report, given_seams=kept, cones=made.cones, cone_angles=made.angles, coned=wanted is not None
    )
    return replace(atlas, cost=measure_cost(creased, atlas, rules), report=report)


def _pack_charts(
    creased: CreasedSurface,
    made: ConeCharts,
    request: PackingRequest,
    wanted: Cones | None,
    rules: ChartRules,
) -> Atlas:
    """Pack charts. Without cones, first cut charts that are larger than a page or waste much of it."""
    surface = creased.surface
    done = _set_scales(surface, made.charts, request.unseen)
    if wanted is not None:
        request = replace(request, upright=wanted.angles is not None)
        if wanted.period is not None:
            return _pack_with_period(surface, done, request, wanted.period)
    elif rules.may_find_seams and request.side is None:
        if request.cut_below > 0:
            return _pack_fully(creased, done, request, rules)
    elif rules.may_find_seams:
        done = cut_to_fit(creased, done, request)
    return _make_atlas(surface, done, request)


def _pack_with_period(
    surface: Submesh, charts: list[tuple[Chart, Submesh]], request: PackingRequest, period: float
) -> Atlas:
    """Pack charts so that seams of cones match after shifts by multiples of a period."""
    spacing = request.spacing.adapt_to_number_of_charts(len(charts))

    def pack_with_room(room: float) -> Atlas:
        return _make_atlas(surface, charts, replace(request, spacing=spacing.widen(room)))

    return shift_by_period(surface, pack_with_room, [piece for _, piece in charts], period, spacing.gap)


def _set_scales(
    surface: Submesh, done: list[tuple[Chart, Submesh]], unseen: float
) -> list[tuple[Chart, Submesh]]:
    """Set `Chart.scale` to `unseen` for the charts that are invisible from outside."""
    if unseen == 1:
        return done
    rows = [np.searchsorted(surface.faces, piece.faces) for _, piece in done]
    hidden = find_unseen_charts(surface.V, surface.F, rows).tolist()
    return [
        (replace(chart, scale=unseen) if inside else chart, piece)
        for (chart, piece), inside in zip(done, hidden, strict=True)
    ]


def _warn_of_repairs(cleaned: Cleaned) -> None:
    """Issue a `MeshWarning` that lists the repairs."""
    if cleaned.repairs:
        listed = "; ".join(map(str, cleaned.repairs))
        warnings.warn(f"the mesh is repaired: {listed}", MeshWarning, stacklevel=stack_level())


def _warn_of_doubled_edges(surface: Submesh, cleaned: Cleaned) -> None:
    """Warn if boundary edges coincide, usually because vertices are duplicated at seams of an older map."""
    rim = surface.topology.boundary_edges
    # an edge that the repair has cut is counted once
    given, first = np.unique(np.sort(cleaned.origin[rim], axis=1), axis=0, return_index=True)
    doubled = np.unique(given[mark_coincident_edges(surface.V, rim[first])])
    if len(doubled):
        warnings.warn(
            f"vertices {first_few(doubled)} of the boundary are doubled along edges, as programs do at the "
            "seams of a map: charts end there; weld=0 joins them",
            MeshWarning,
            stacklevel=stack_level(),
        )


def _warn_of_added_seams(atlas: Atlas) -> None:
    """Warn if charts were cut along edges that are not in `seams=`."""
    added = atlas.added_seams
    if len(added):
        counts = Counter(reason for chart in atlas.charts for reason in chart.split_reasons)
        reasons = ", ".join(f"{reason} (of {format_count(n, 'chart')})" for reason, n in counts.items())
        warnings.warn(
            f"{len(added):,} edge{' is' if len(added) == 1 else 's are'} cut in addition to the given seams, "
            f"because of {reasons}: {first_few(added)}; atlas.added_seams has them. Give more seams there, "
            "extend=True to add the shortest seams, or repair_overlaps=True, which cuts overlapping parts "
            "only if they cannot be moved apart",
            FallbackWarning,
            stacklevel=stack_level(),
        )


def _pack_fully(
    creased: CreasedSurface, done: list[tuple[Chart, Submesh]], request: PackingRequest, rules: ChartRules
) -> Atlas:
    """Pack charts. First cut charts with many limbs if the fuller page is worth the seams.

    Nothing is cut if the charts cover enough of the page. The required share is lower for many charts,
    because small charts fill the gaps between large charts.
    """
    surface, placed = creased.surface, None
    enough = min(request.cut_below, MAX_SPARSE_FILL if len(done) > MOST_TRIAL_CHARTS else 1.0)
    if enough < 1:
        placed = _place_charts(done, request)
        if measure_fill(placed) > enough:
            return _make_atlas(surface, done, request, placed)
    parts, whole = cut_for_fill(creased, done, request, rules.trade, rules.stretch_limit)
    if len(parts) == len(done):
        return _make_atlas(surface, done, request, placed)
    fuller = _place_charts(parts, request)
    size = float(np.sqrt(surface.areas_and_products[0].sum() / 2))
    dearer, cheaper = (
        compute_division_price(creased, [piece for _, piece in charts]) for charts in (parts, done)
    )
    # size of the page at which the uncut charts would cost as much as the cut charts
    worth = 1 / measure_fill(fuller) + (dearer - cheaper) / size / rules.trade
    if request.cut_below < 1:
        worth = max(worth, MIN_FILL_GAIN / measure_fill(fuller))
    if placed is None and SEARCHED_OVER_TRIAL * whole <= worth:
        placed = _place_charts(done, request)
    if placed is None or 1 / measure_fill(placed) > worth:
        return _make_atlas(surface, parts, request, fuller)
    return _make_atlas(surface, done, request, placed)


def _scale_maps(done: list[tuple[Chart, Submesh]]) -> list[tuple[FloatArray, IntArray]]:
    """Return the map of each chart, multiplied by `Chart.scale`, and its triangles."""
    return [(chart.scale * chart.result.uv, piece.F) for chart, piece in done]


def _place_charts(done: list[tuple[Chart, Submesh]], request: PackingRequest) -> list[PackedChart]:
    """Place charts on pages; reduce the margin if it leaves no room for the charts."""
    closer = request.spacing.adapt_to_number_of_charts(len(done)).limit_gap(_find_widest_gap(len(done)))
    return pack_maps(_scale_maps(done), replace(request, spacing=closer))


def _find_widest_gap(number: int) -> float:
    """Return the maximum gap that leaves room for `number` charts, as a share of the page's width."""
    return float(np.sqrt(MAX_MARGIN_SHARE / number))


def _warn_of_narrow_gaps(number: int, request: PackingRequest) -> None:
    """Warn if the margin was reduced, because it left no room for the charts."""
    spacing, widest = request.spacing, _find_widest_gap(number)
    if spacing.adapt_to_number_of_charts(number).gap > widest:
        too_wide = f"a margin of {spacing.gap:g} leaves no room for {format_count(number, 'chart')}"
        warnings.warn(f"{too_wide}: it is reduced to {widest:.2g}", FallbackWarning, stacklevel=stack_level())


def _make_atlas(
    surface: Submesh,
    done: list[tuple[Chart, Submesh]],
    request: PackingRequest,
    placed: list[PackedChart] | None = None,
) -> Atlas:
    """Return the atlas of the charts `done`; pack them unless `placed` has their positions."""
    if placed is None:
        placed = _place_charts(done, request)
    _warn_of_narrow_gaps(len(done), request)
    charts, pieces = [chart for chart, _ in done], [piece for _, piece in done]
    arrays = [(piece.V, piece.F, piece.faces, piece.vertices) for piece in pieces]
    V, F, faces, origin = map(np.concatenate, zip(*arrays, strict=True))
    vertices = Ragged.from_sizes([len(piece.V) for piece in pieces])
    of = np.repeat(np.arange(len(pieces)), [len(piece.F) for piece in pieces])
    FTC, label, rows = np.empty_like(surface.F), np.empty_like(of), np.searchsorted(surface.faces, faces)
    FTC[rows], label[rows] = F + vertices.start[of, None], of
    TC, page = np.concatenate([p.uv for p in placed]), np.array([p.page for p in placed])
    flat = TC * [1, request.spacing.aspect]  # in units of the page width
    seams, mismatch = find_seams_and_mismatch(surface.topology, flat, FTC)
    if len(charts) > 1:
        whole = Submesh(V, FTC, surface.faces, origin, surface.n_given)
        scale = vertices.repeat(np.array([chart.scale for chart in charts]))[:, None]
        quality = measure_quality(whole, flat / scale, sum(chart.overlapping for chart in charts))
    else:  # a single chart has the same quality, except for faces that collapse
        quality = replace(charts[0].quality, flips=len(find_flipped_faces(complex_positions(TC), FTC.T)))
    return Atlas(
        TC=TC,
        FTC=FTC,
        origin=origin,
        chart=label,
        page=page,
        charts=tuple(charts),
        seams=surface.vertices[seams],
        seam_length=float(lengths(surface.V, seams).sum()),
        fill=measure_fill(placed),
        quality=quality,
        report=AtlasReport(
            seam_mismatch=mismatch,
            n_splits=len(done) - int(surface.component_of_face.max() + 1),
            scale=abs(placed[0].ratio),
            aspect=request.spacing.aspect,
        ),
    )
