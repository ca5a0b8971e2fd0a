"""Unwrap any surface: cut it, flatten chart by chart without overlaps, pack."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from .._core import lengths
from .._runtime import Progress, progress_part, reporting
from .._types import FloatArray, IntArray
from ..errors import FallbackWarning, MeshWarning, OutcomeWarning, stack_level
from ..flattening import Method, method_of
from ..measures import quality_of
from ..surface import Ragged, Submesh, cleaned_surface, complex_positions, signed_double_areas, unrepaired
from .atlas import (
    Atlas,
    Chart,
    atlas_of_given_mesh,
    atlas_of_polygons,
    empty_atlas,
    mark_diagonals,
    mask_of_triangles,
    repairs_of_polygons,
    seams_and_mismatch,
    split_polygons,
)
from .charting import charts_of, pieces_of
from .cones import NO_CONES, ConeCharts, Cones, GivenCones, SurfaceCones, charts_with_cones
from .constants import FULL_PAGE, LEAST_PAGE, MARGIN_SHARE, PROGRESS
from .features import hiding_weights
from .options import ChartOptions, Seams, asked_for
from .packing import (
    FEW_CHARTS,
    PackedChart,
    Packing,
    Wish,
    cut_for_fill,
    cut_to_fit,
    fill_of,
    pack_maps,
    pack_quickly,
)
from .periodic import with_period

Charts = list[tuple[Chart, Submesh]]  # each with its piece of the surface


def unwrap(
    V: ArrayLike,
    F: ArrayLike,
    seams: Seams | ArrayLike | None = None,
    method: str | Method = "linabf",
    *,
    cones: Cones | GivenCones | None = None,
    packing: Packing | None = None,
    weld: float | None = None,
    strict: bool = False,
    progress: Progress = None,
) -> Atlas:
    """Cut any surface into charts, flatten them without overlaps, and pack them.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions, finite where a face is.
    F : (#F, 3) or (#F, k) int, or list of lists of int
        Any triangles, quadrangles or polygons. Those that are no clean oriented manifold are made one, as
        `clean` does. Seams run along the edges of polygons, never along the diagonals that split them.
    seams : Seams, (#E, 2) int or (#F, 3) bool, optional
        Where to cut, as `cut` takes edges and masks, or `Seams` with options: how long seams may be for less
        stretch (`Seams(trade=30)`), where they hide, and what happens to holes, stretch and overlaps. By
        default `find_seams` finds them.
    method : str or method object
        As in `flatten`.
    cones : Cones, (#C,) int, int or "auto", optional
        Vertices that keep all curvature, or how many are to be found on each component, or `Cones` with
        their angles and the period of a texture. Needs "linabf" or "abf". Not with `seams`.
    packing : Packing, optional
        The texture's resolution, distances between charts, texel density and pages. By default charts fill
        one page with a margin.
    weld : float, optional
        As in `clean`.
    strict : bool
        Refuse what is no clean oriented manifold, instead of repairing it.
    progress : callable or False, optional
        As in `flatten`.

    Returns
    -------
    Atlas

    Raises
    ------
    MeshError
        The arrays are malformed, a coordinate at a face is NaN or infinite, a seam is no edge, or
        given seams leave a chart with handles or without a boundary and are not to be completed.
        A cone is no interior vertex, or the cones are too few, or their angles do not obey
        Gauss-Bonnet; the message has the numbers that do. The period is too long for the distances of
        the cones; the message has one that is not. With `strict`, also: the surface is no
        oriented manifold, or a face has no area. With a texel density, also: the charts do not fit on the
        pages.
    ValueError
        `weld` is out of its range, or options do not go together.

    Warns
    -----
    MeshWarning
        The mesh was repaired; `atlas.repairs` has the details.
    OutcomeWarning
        A chart has flipped faces, still overlaps itself, or is stretched beyond use.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> atlas = unwrap(V, F)
    >>> len(atlas.charts), atlas.good, atlas.FTC.shape
    (1, True, (20, 3))
    >>> atlas = unwrap(V, F, packing=Packing(resolution=1024, padding=2))

    A cube of quadrangles comes back as quadrangles:

    >>> V = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    >>> F = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    >>> unwrap(V, F).FTC.shape
    (6, 4)
    """
    asked, wanted, wish = asked_for(seams, cones, packing)
    split, given_seams = split_polygons(V, F), asked.at
    if split is not None:
        F = split.F
        if given_seams is not None:
            given_seams = mask_of_triangles(given_seams, split, len(np.asarray(V)))
    if strict:
        surface = Submesh.checked_manifold(V, F)
        cleaned = unrepaired(surface)
    else:
        cleaned, surface = cleaned_surface(V, F, weld)
        cleaned = replace(cleaned, repairs=repairs_of_polygons(cleaned.repairs, split))
    as_given, given = surface.vertices is cleaned.origin, np.asarray(F).astype(np.int64)
    surface = mark_diagonals(surface, cleaned, split)
    if cleaned.repairs:
        listed = "; ".join(map(str, cleaned.repairs))
        warnings.warn(f"the mesh is repaired: {listed}", MeshWarning, stacklevel=stack_level())
    if not len(surface.F):
        return atlas_of_polygons(empty_atlas(cleaned, given), split)
    face = np.arange(len(given)) if split is None else split.face
    options = ChartOptions.of(method_of(method), asked, hiding_weights(surface, asked.hide, face))
    with reporting(progress):
        if wanted is None:
            with progress_part("seams", PROGRESS["seams"]):
                pieces, kept = pieces_of(surface, cleaned, given_seams, given, options)
            made = ConeCharts(charts_of(pieces, kept, options), *NO_CONES)
        else:
            placed = SurfaceCones.of(wanted, surface, cleaned)
            ends = PROGRESS["seams"], PROGRESS["charts"]
            made = charts_with_cones(surface, placed, options.method, ends)
        with progress_part("packing", PROGRESS["packing"]):
            upright = wanted is not None and wanted.angles is not None
            wish = replace(wish.in_units(2.0**cleaned.power), upright=upright)
            charts, packed = made.charts, None
            if wanted is None and wish.resolution is not None and options.may_find_seams:
                charts, packed = _cut_for_pages(charts, wish, options)
            if wanted is None or wanted.period is None:
                atlas = _atlas_on_pages(surface, charts, wish, packed)
            else:

                def pack(room: float) -> Atlas:
                    roomy = replace(wish, spacing=wish.spacing.wider(room))
                    return replace(_atlas_on_pages(surface, charts, roomy), cones=made.cones)

                pieces = [piece for _, piece in charts]
                atlas = with_period(surface, pack, pieces, wanted.period, wish.spacing.gap)
    atlas = replace(
        atlas,
        max_stretch=asked.max_stretch,
        cones=made.cones,
        cone_angles=made.angles,
        coned=wanted is not None,
    )
    if not as_given:
        atlas = atlas_of_given_mesh(atlas, cleaned, given)
    atlas = atlas_of_polygons(atlas, split)
    for trouble in atlas.troubles:
        warnings.warn(trouble, OutcomeWarning, stacklevel=stack_level())
    return atlas


def _cut_for_pages(
    charts: Charts, wish: Wish, options: ChartOptions
) -> tuple[Charts, list[PackedChart] | None]:
    """Charts that are cut where their pages ask for it, and where they are on the pages, if that is known.

    If the charts' scale is given, those that are larger than a page are cut. Otherwise charts of many limbs
    are cut, if the fuller page is worth the seams. Many charts mostly fill the gaps of each other, so their
    page is looked at first.
    """
    if wish.side is not None:
        return cut_to_fit(charts, wish), None
    packed, moves = None, False
    if len(charts) > FEW_CHARTS:
        packed = _pack_charts(charts, wish)
        if fill_of(packed) > FULL_PAGE:
            return charts, packed
    parts, page = cut_for_fill(charts, wish, options.trade, options.most_stretch)
    if len(parts) == len(charts):
        return charts, packed
    fuller = _pack_charts(parts, wish)
    kept = {id(piece) for _, piece in charts}.intersection(id(piece) for _, piece in parts)
    longer, shorter = (
        _boundary_length([piece for _, piece in some if id(piece) not in kept]) for some in (parts, charts)
    )
    size = np.sqrt(sum(float(piece.measured[0].sum()) / 2 for _, piece in charts))
    # the page of uncut charts, over their area, that costs as much as the fuller page and its seams
    as_good = 1 / fill_of(fuller) + (longer - shorter) / 2 / size / options.trade
    if packed is None and LEAST_PAGE * page <= as_good:
        packed, moves = pack_quickly(_maps_of(charts), wish)
    if packed is None or 1 / fill_of(packed) > as_good:
        return parts, fuller
    return charts, None if moves else packed


def _boundary_length(pieces: list[Submesh]) -> float:
    """The length of the boundaries of pieces."""
    rims = ((piece.V, piece.topology.edges[piece.topology.sides[1] < 0]) for piece in pieces)
    return float(sum(lengths(V, rim).sum() for V, rim in rims))


def _maps_of(charts: Charts) -> list[tuple[FloatArray, IntArray]]:
    return [(chart.result.uv, piece.F) for chart, piece in charts]


def _pack_charts(charts: Charts, wish: Wish) -> list[PackedChart]:
    """Charts on pages; the margins are made smaller if they would leave the charts no room."""
    widest = float(np.sqrt(MARGIN_SHARE / len(charts)))
    spacing = wish.spacing.at_most(widest)
    if spacing != wish.spacing:
        said = (
            f"a margin of {wish.spacing.gap:g} leaves no room for {len(charts):,} charts: it is {widest:.2g}"
        )
        warnings.warn(said, FallbackWarning, stacklevel=stack_level())
    return pack_maps(_maps_of(charts), replace(wish, spacing=spacing))


def _atlas_on_pages(
    surface: Submesh, done: Charts, wish: Wish, packed: list[PackedChart] | None = None
) -> Atlas:
    """The atlas of charts on pages; where they are may be known."""
    if packed is None:
        packed = _pack_charts(done, wish)
    charts, pieces = zip(*done, strict=True)
    columns = list(zip(*((piece.V, piece.F, piece.faces, piece.vertices) for piece in pieces), strict=True))
    V, F, own, origin = map(np.concatenate, columns)
    vertices, faces = (Ragged.of_sizes(list(map(len, column))) for column in columns[:2])
    FTC, label = np.empty_like(surface.F), np.empty(len(surface.F), dtype=np.int64)
    rows = np.searchsorted(surface.faces, own)
    FTC[rows] = F + faces.repeat(vertices.start[:-1])[:, None]
    label[rows] = faces.repeat(np.arange(len(done)))
    uv, page, ratio = zip(*((chart.uv, chart.page, chart.ratio) for chart in packed), strict=True)
    TC = np.concatenate(uv)
    seams, mismatch = seams_and_mismatch(surface.topology, TC, FTC)
    if len(done) > 1:
        overlaps = sum(chart.overlapping for chart in charts)  # in their places, charts are what they were
        quality = quality_of(Submesh(V, FTC, surface.faces, origin, surface.n_given), TC, overlaps)
    else:  # it is known, but for faces that have collapsed
        flips = ~(signed_double_areas(complex_positions(TC), FTC.T) > 0)
        quality = replace(charts[0].quality, flips=int(np.count_nonzero(flips)))
    return Atlas(
        TC=TC,
        FTC=FTC,
        origin=origin,
        chart=label,
        charts=charts,
        seams=surface.vertices[seams],
        seam_length=float(lengths(surface.V, seams).sum()),
        seam_mismatch=mismatch,
        splits=len(done) - int(surface.label.max() + 1),
        fill=fill_of(packed),
        page=np.array(page),
        scale=abs(ratio[0]),
        quality=quality,
    )
