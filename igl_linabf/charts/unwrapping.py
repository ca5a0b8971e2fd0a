"""Unwrap any surface: cut it, flatten chart by chart without overlaps, pack."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import Progress, part, reporting
from .._types import FloatArray, IntArray
from ..errors import FallbackWarning, MeshWarning, OutcomeWarning, some, stack_level
from ..flattening import Flattening, Isometric, Method, Outcome, flatten_together, guaranteed, method_of
from ..measures import (
    Quality,
    change_of,
    overlapping_pairs,
    overlapping_pairs_of_each,
    quality_of,
    quality_of_each,
)
from ..surface import (
    Cleaned,
    Submesh,
    as_it_is,
    check_finite,
    cleaned_surface,
    complex_positions,
    flipped_faces,
    seam_mask,
    signed_double_areas,
)
from .atlas import BEYOND_USE, ROUNDING, Atlas, Chart
from .composing import packed
from .coned import NO_CONES, ConeAngles, Coned, Cones, GivenCones, coned
from .given import given_back, sides_of_cleaned, without_charts
from .halving import halves
from .limbs import Flat, cut_for_fill
from .overlap_seams import MAX_SPLITS, seams_between
from .packing import Wish
from .period import with_period
from .pieces import flattened
from .polygons import in_polygons, mask_of_triangles, of_polygons, split_polygons, with_diagonals
from .scaf import moved_apart
from .seams import TRADE, seams_of
from .visibility import hiding

SEAMS_END, CHARTS_END = 0.3, 0.95  # of the progress told: when seams are found, when packing begins
DISK_GAIN = 0.05  # L2 stretch that seams must save, beyond their price, on a component that needs none
MANY = 8  # charts from which they are flattened and measured together
MAX_SPLITS_FOR_STRETCH = 64  # of one that is stretched more than is asked for, or beyond use
MAX_LEAF_ROUNDS = 8  # of more seams for that, before it is halved
MOST_TO_CUT = 30  # charts, from which on none is cut to fill a page
TRADE_DOUBLINGS = 12  # until a chart that flips is cut further


def unwrap(
    V: ArrayLike,
    F: ArrayLike,
    seams: ArrayLike | None = None,
    method: str | Method = "linabf",
    *,
    cones: GivenCones | None = None,
    cone_angles: ConeAngles = None,
    trade: float = TRADE,
    holes: bool = False,
    bijective: bool = False,
    margin: float = 0.005,
    resolution: int | None = None,
    padding: float = 2,
    texel_density: float | None = None,
    pages: int | None = None,
    period: float | None = None,
    max_stretch: float | None = None,
    complete: bool = False,
    hide: ArrayLike | None = None,
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
    seams : (#E, 2) int or (#F, 3) bool, optional
        Where to cut, as `cut` takes them; a mask has the shape of `F`. By default `find_seams`
        finds them. If a chart has flipped faces, its seams are extended; if that does not help,
        `guarantee="injective"` is used.
    method : str or method object
        As in `flatten`.
    cones : (#C,) int, int or "auto", optional
        Interior vertices that keep all curvature, or how many `find_cones` is to find on each
        component; "auto" is as many as pay. The seam is then a tree through them and the holes,
        with loops that open the handles, and in the map both sides of each seam edge are equally
        long (docs/cones.md). Needs "linabf" or "abf". Not with `seams`, `holes`,
        `bijective`, `max_stretch`, `complete`.
    cone_angles : (#C,) float or "quarter", optional
        Angle sums at the cones, radians. By default those of the conformal map that has one scale
        at all cones and the boundary. "quarter": multiples of 90 degrees that need little stretch.
        Then both sides of a seam also differ by turns of multiples of 90 degrees.
    trade : float
        As in `find_seams`: larger allows longer seams for less stretch.
    holes : bool
        Leave holes uncut, if `seams` is not given.
    bijective : bool
        If a chart overlaps itself, move its parts apart with `make_bijective` instead of splitting
        it. The chart's `cost` is the increase of F/3nt. Charts with holes are split.
    margin : float
        Distance between charts, and to the border, as a share of the unit square's side. If there are
        too many charts for it, a smaller one is used, with a warning.
    resolution : int, optional
        Texels along a page's side. Distances are then given by `padding`, not by `margin`, and charts of
        many limbs are cut further where a fuller page is worth the seam, as `trade` says.
    padding : float
        Texels between two charts, in u or in v, and half as many to the border. With 2 or more no two
        charts share a texel of a bilinear lookup.
    texel_density : float, optional
        Texels per unit of length of V, on average over a chart; needs `resolution`. By default charts
        are as large as the pages hold.
    pages : int, optional
        Pages to use; with `texel_density` at most, and by default as many as it takes. Page k is the
        unit square above and right of (k % 10, k // 10), as UDIM tile 1001 + k.
    period : float, optional
        That of a texture, as a share of the page's side, for cones in quarter turns: all seams then shift it
        by whole periods, so that it goes on across them. The map moves by about half a period.
    max_stretch : float, optional
        Cut or split charts, beyond given `seams`, too, until the L2 stretch of each is at most this.
        At least 1; by default stretch is only weighed against seam length.
    complete : bool
        `seams` are a beginning: the others that handles, closed pieces and stretch need are found.
    hide : (3,) or (#F,) float, optional
        As in `find_seams`: a direction, as `[0, -1, 0]` for what looks back if the front looks to +y, or
        a weight for each face. The seams that are found prefer the faces of that side.
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
        oriented manifold, or a face has no area. With `texel_density`, also: the charts do not fit on the
        pages.
    ValueError
        `trade`, `margin`, `period`, `max_stretch`, `weld` or a number of the packing is out of its range, or
        options do not go together.

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
    >>> atlas = unwrap(V, F, cones=4, cone_angles="quarter")
    >>> bool(atlas.seam_mismatch < 1e-6), float(atlas.cone_angles.sum() / np.pi)  # 4 x 2 pi, less 4 pi
    (True, 4.0)

    A cube of quadrangles comes back as quadrangles:

    >>> V = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    >>> F = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    >>> unwrap(V, F).FTC.shape
    (6, 4)
    """
    if cones is None and cone_angles is not None:
        raise ValueError("cone_angles are those of cones: give cones=, their vertices or a number of them")
    if cones is not None:
        asked = {"seams": seams is not None, "holes": holes, "bijective": bijective, "complete": complete}
        asked["max_stretch"] = max_stretch is not None
        if any(asked.values()):
            listed = ", ".join(name for name, given in asked.items() if given)
            raise ValueError(f"cones= does not go together with {listed}: its seams run through the cones")
    if period is not None and not (cones is not None and cone_angles is not None and 0 < period < 1):
        raise ValueError(
            f"period is {period!r}: give a share of the page's side, above 0 and below 1, with cones and "
            'cone_angles="quarter"'
        )
    if max_stretch is not None and not max_stretch >= 1:
        raise ValueError(f"max_stretch is {max_stretch!r}: give an L2 stretch from 1 (none) upwards")
    wish = Wish.of(margin, resolution, padding, texel_density, pages)
    if period is not None:
        wish = replace(wish, spacing=wish.spacing.wider(period))  # charts may move by about so much
    split = split_polygons(V, F)
    if split is not None:
        F, seams = split.F, None if seams is None else mask_of_triangles(seams, split, len(np.asarray(V)))
    if strict:
        surface = Submesh.checked_manifold(V, F)
        cleaned = as_it_is(surface)
    else:
        cleaned, surface = cleaned_surface(V, F, weld)
        cleaned = replace(cleaned, repairs=of_polygons(cleaned.repairs, split))
    as_given, given = surface.vertices is cleaned.origin, np.asarray(F).astype(np.int64)
    surface = with_diagonals(surface, cleaned, split)
    if cleaned.repairs:
        listed = "; ".join(map(str, cleaned.repairs))
        warnings.warn(f"the mesh is repaired: {listed}", MeshWarning, stacklevel=stack_level())
    if not len(surface.F):
        return in_polygons(without_charts(cleaned, given), split)
    hidden = hiding(surface, hide, np.arange(len(given)) if split is None else split.face)
    task = _Task(method_of(method), seams is None or complete, trade, holes, bijective, max_stretch, hidden)
    with reporting(progress):
        if cones is None:
            with part("seams", SEAMS_END):
                pieces = _pieces(surface, cleaned, seams, given, task)
            made = Coned(_charts(pieces, task), *NO_CONES)
        else:
            wanted = Cones.checked(cones, cone_angles, surface, cleaned)
            made = coned(surface, wanted, task.method, (SEAMS_END, CHARTS_END))
        with part("packing", 1.0):
            wish = replace(wish.in_units(2.0**cleaned.power), upright=cone_angles is not None)
            atlas = replace(packed(surface, made.charts, wish), cones=made.cones)
            if period is not None:
                atlas = with_period(surface, atlas, [piece for _, piece in made.charts], period)
            if resolution is not None and task.may_find_seams and cones is None:
                atlas = _fuller(surface, atlas, made.charts, wish, task)
    atlas = replace(atlas, max_stretch=max_stretch, cone_angles=made.angles)
    if not as_given:
        atlas = given_back(atlas, cleaned, given)
    atlas = in_polygons(atlas, split)
    for trouble in atlas.troubles:
        warnings.warn(trouble, OutcomeWarning, stacklevel=stack_level())
    return atlas


@dataclass(frozen=True)
class _Task:
    """Arguments of `unwrap`, and whether more seams may be found."""

    method: Method
    may_find_seams: bool
    trade: float
    holes: bool
    bijective: bool
    max_stretch: float | None
    hidden: FloatArray | None

    def seams_of(self, piece: Submesh, *, disks: bool = False, gain: float = 0.0) -> IntArray:
        """`seams_of` a piece, as the task wants them."""
        isometric = isinstance(self.method, Isometric)
        hidden, holes = self.hidden, self.holes
        return seams_of(
            piece, self.trade, holes=holes, disks=disks, gain=gain, hidden=hidden, isometric=isometric
        )

    @property
    def most_stretch(self) -> float:
        """Of a chart, in L2, from which on it is cut further."""
        if self.max_stretch is not None:
            return self.max_stretch * (1 + ROUNDING)
        return BEYOND_USE if self.may_find_seams else np.inf

    @property
    def most_splits(self) -> int:
        """Of a chart and its parts."""
        return MAX_SPLITS if self.max_stretch is None else MAX_SPLITS_FOR_STRETCH


def _pieces(
    surface: Submesh, cleaned: Cleaned, seams: ArrayLike | None, F: IntArray, task: _Task
) -> list[Submesh]:
    """The surface cut along the seams that are given, and those that are found."""
    pieces = [surface]
    if seams is not None:
        if surface.vertices is not cleaned.origin:
            mask = sides_of_cleaned(seam_mask(seams, F, len(cleaned.merged), as_marked=True), cleaned)
        else:
            mask = seam_mask(seams, surface.named_faces, surface.n_given)
        pieces = surface.cut(mask)
    if not task.may_find_seams:
        return pieces
    return [part for piece in pieces for part in piece.cut_along(_seams_worth(piece, task))]


def _seams_worth(piece: Submesh, task: _Task) -> IntArray:
    """The seams that its components need, and those that their stretch is worth; of disks, too."""
    if not task.holes:
        return task.seams_of(piece, disks=True, gain=DISK_GAIN)
    parts = piece.components()
    disks = [len(part.topology.loops) == 1 for part in parts]  # others keep their holes as they are
    found = [task.seams_of(part, disks=disk, gain=DISK_GAIN) for part, disk in zip(parts, disks, strict=True)]
    return np.concatenate(found)


Known = tuple[Flattening, IntArray, Quality]  # a map, its pairs of overlapping faces, its figures


def _charts(pieces: list[Submesh], task: _Task) -> list[tuple[Chart, Submesh]]:
    """Flatten the pieces, and the parts of those that are cut further; all that wait at once."""
    waiting: list[tuple[tuple[int, ...], Submesh]] = [((i,), piece) for i, piece in enumerate(pieces)]
    total, reached, splits = sum(len(piece.F) for piece in pieces), 0, 0
    done: list[tuple[tuple[int, ...], Chart, Submesh]] = []
    while waiting:
        parts: list[tuple[tuple[int, ...], Submesh]] = []
        known = _known_together([piece for _, piece in waiting], task.method)
        for (key, piece), of_piece in zip(waiting, known, strict=True):
            reached += len(piece.F) if not splits else 0
            with part("charts", SEAMS_END + (CHARTS_END - SEAMS_END) * reached / total):
                made = _chart(piece, splits, task, of_piece)
            if isinstance(made, Chart):
                done.append((key, made, piece))
            else:
                parts += [((*key, k), smaller) for k, smaller in enumerate(made)]
        waiting, splits = parts, splits + 1
    done.sort(key=lambda entry: entry[0])  # parts stand where the piece was
    return [(chart, piece) for _, chart, piece in done]


def _known_together(pieces: list[Submesh], method: Method) -> list[Known | None]:
    """Maps of many small pieces, and what is measured of them; None: to be found alone."""
    known: list[Known | None] = [None] * len(pieces)
    if len(pieces) < MANY:
        return known
    results = flatten_together([(piece.V, piece.F) for piece in pieces], method)
    good = [(i, result) for i, result in enumerate(results) if result is not None]
    pairs = overlapping_pairs_of_each([(result.uv, pieces[i].F) for i, result in good])
    measured = [(pieces[i], result.uv, len(over)) for (i, result), over in zip(good, pairs, strict=True)]
    for (i, result), over, quality in zip(good, pairs, quality_of_each(measured), strict=True):
        known[i] = result, over, quality
    return known


def _chart(piece: Submesh, splits: int, task: _Task, known: Known | None) -> Chart | list[Submesh]:
    """The flattened piece; or its parts, if it has to be cut further."""
    result = flattened(piece, task.method) if known is None else known[0]
    if len(result.flipped) and task.may_find_seams:  # double precision does not hold the map so little cut
        if splits < task.most_splits and len(leaves := _more_leaves(piece, task)):
            return piece.cut_along(leaves)
        result, known = _flattened_without_flips(piece, result, task), None
    if known is None:
        check_finite(result.uv, piece.vertices, "uv")
    pairs, cost = overlapping_pairs(result.uv, piece.F) if known is None else known[1], 0.0
    if len(pairs) and task.bijective and not result.holes:
        result, cost = _made_bijective(piece, result)
        pairs, known = overlapping_pairs(result.uv, piece.F), None
    elif len(pairs) and splits < task.most_splits:
        if result.holes:  # first to a disk
            return piece.cut_along(replace(task, trade=0.0, holes=False).seams_of(piece))
        parts = piece.cut_along(seams_between([piece], piece.faces[pairs]))
        if len(parts) > 1:
            return parts
    quality = quality_of(piece, result.uv) if known is None else known[2]
    if quality.stretch_l2 > task.most_stretch and (parts := _less_stretched(piece, splits, task)):
        return parts
    return Chart(piece.faces, result, quality, splits, len(pairs), cost)


def _less_stretched(piece: Submesh, splits: int, task: _Task) -> list[Submesh]:
    """The piece cut further, and from some number of cuts on halved; nothing where that cannot be."""
    if splits < MAX_LEAF_ROUNDS and len(leaves := _more_leaves(piece, task)):
        return piece.cut_along(leaves)
    return halves(piece) if splits < MAX_SPLITS_FOR_STRETCH and piece.cells[0].any() else []


def _more_leaves(piece: Submesh, task: _Task) -> IntArray:
    """More seams for a piece with flips: `trade` is doubled until `find_seams` finds some."""
    trades = max(task.trade, 1.0) * 2.0 ** np.arange(TRADE_DOUBLINGS)
    found = (replace(task, trade=t).seams_of(piece, disks=True) for t in trades)
    return next((seams for seams in found if len(seams)), np.zeros((0, 2), dtype=np.int64))


def _flattened_without_flips(piece: Submesh, result: Flattening, task: _Task) -> Flattening:
    """The map with guarantee='injective', for a piece that no seam keeps from flipping."""
    surer = guaranteed(task.method)
    if surer is None:
        return result
    warnings.warn(
        f"no seams were found that prevent flips in the chart of faces {some(piece.faces)}: it is flattened "
        "with guarantee='injective', at more distortion",
        FallbackWarning,
        stacklevel=stack_level(),
    )
    return flattened(piece, surer)


def _made_bijective(piece: Submesh, result: Flattening) -> tuple[Flattening, float]:
    """The map with its overlapping parts moved apart, and the increase of F/3nt."""
    uv, _ = moved_apart(result.uv, piece.topology)  # what is wrong is told of the atlas
    corner = piece.topology.corner
    areas = [np.abs(signed_double_areas(complex_positions(m), corner)).sum() for m in (result.uv, uv)]
    uv *= np.sqrt(areas[0] / areas[1])
    flipped = flipped_faces(complex_positions(uv), corner)
    before, after = (float(change_of(piece, m).angle_distortion.mean()) for m in (result.uv, uv))
    outcome = Outcome.FLIPPED if len(flipped) else result.outcome
    message = f"{result.message}; moved apart to be bijective: F/3nt {before:.4g} -> {after:.4g}"
    return replace(result, uv=uv, flipped=flipped, outcome=outcome, message=message), after - before


def _fuller(
    surface: Submesh, atlas: Atlas, done: list[tuple[Chart, Submesh]], wish: Wish, task: _Task
) -> Atlas:
    """The atlas, or one with charts of many limbs cut further, if the fuller page is worth its seams."""
    given = [Flat(piece, chart.result.uv, i) for i, (chart, piece) in enumerate(done)]
    parts = cut_for_fill(given, wish, task.trade) if len(given) <= MOST_TO_CUT else given
    if len(parts) == len(given):
        return atlas
    numbers = np.bincount([part.parent for part in parts])
    waiting = [part.piece for part in parts if numbers[part.parent] > 1]
    kept = [pair for pair, number in zip(done, numbers, strict=True) if number == 1]
    fuller = packed(surface, kept + _charts(waiting, task), wish)
    size = np.sqrt(sum(float(chart.piece.measured[0].sum()) / 2 for chart in given))
    seam = (fuller.seam_length - atlas.seam_length) / size
    return fuller if task.trade * (atlas.fill**-0.5 - fuller.fill**-0.5) > seam else atlas
