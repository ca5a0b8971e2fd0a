"""The charts of a surface: pieces, flattened, and cut further where they flip, overlap or stretch."""

from __future__ import annotations

import warnings
from bisect import bisect_left
from contextlib import nullcontext
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import advance, progress_part
from .._types import FloatArray, IntArray
from ..errors import FallbackWarning, SingularSystemError, some, stack_level
from ..flattening import ABF, Flattening, Isometric, LinABF, Method, Sketch, flatten_together, guaranteed
from ..measures import (
    Quality,
    overlapping_pairs_of_chart,
    overlapping_pairs_of_each,
    quality_of,
    quality_of_each,
)
from ..surface import Cleaned, Submesh, check_finite, seam_mask
from . import constants
from .atlas import Chart, flatten_piece, open_slivers, sides_of_cleaned
from .costing import priced_seams, stretch_weight
from .cut_graphs import ClosedSurface, isometric_stretch
from .features import CreasedSurface, extent
from .options import ChartOptions
from .seams import MAX_FACES_OF_MEDIUM_BODY, TRADE
from .splitting import (
    TIP_STRETCH,
    KnownMap,
    MapMeasure,
    bisect,
    is_isometric,
    merge_small_charts,
    move_parts_apart,
    relayout_locally,
    reuse_maps,
    seams_to_tips,
    split_at_creases,
    split_overlaps,
)

_NO_SEAM = np.zeros((0, 2), dtype=np.int64)


def pieces_of(
    surface: Submesh,
    cleaned: Cleaned,
    seams: ArrayLike | None,
    F: IntArray,
    labels: IntArray | None,
    options: ChartOptions,
) -> tuple[list[Submesh], IntArray]:
    """The surface cut along given seams and those that are found; also the vertices of the given, (#E, 2).

    Edges between triangles of different labels are given ones.
    """
    pieces, given, mask = [surface], _NO_SEAM, None
    if seams is not None:
        if surface.vertices is not cleaned.origin:
            mask = sides_of_cleaned(seam_mask(seams, F, len(cleaned.merged), as_marked=True), cleaned)
        else:
            mask = seam_mask(seams, surface.vertices[surface.F], surface.n_given)
    if labels is not None:
        between = surface.sides_between(labels[surface.faces])
        mask = between if mask is None else mask | between
    if mask is not None:
        face, k = np.nonzero(mask)
        given = surface.vertices[surface.F[face[:, None], np.column_stack((k, (k + 1) % 3))]]
        pieces = surface.cut(mask)
    if not options.may_find_seams:
        return pieces, given
    return [part for piece in pieces for part in piece.cut_along(_seams_worth(piece, options))], given


def _seams_worth(piece: Submesh, options: ChartOptions) -> IntArray:
    """The seams that its components need, and those that are worth the stretch they save, on disks, too."""
    gain = options.worth(constants.DISK_SEAM)
    if not options.holes:
        return options.seams_of(piece, disks=True, gain=gain, part_overlaps=True, panels=True)
    parts = piece.components()
    disks = [len(part.topology.loops) == 1 for part in parts]  # others keep their holes as they are
    found = [options.seams_of(part, disks=disk, gain=gain) for part, disk in zip(parts, disks, strict=True)]
    return np.concatenate(found)


_Cut = tuple[Submesh, KnownMap | None]  # a piece, and its map, if it has one
_Part = tuple[tuple[int, ...], Submesh, KnownMap | None]  # its place among the pieces, too
_Done = tuple[tuple[int, ...], Chart, Submesh]


def charts_of(pieces: list[Submesh], given: IntArray, options: ChartOptions) -> list[tuple[Chart, Submesh]]:
    """Flatten the pieces, then all parts of those that are cut further, and so on.

    At the end small charts are joined with others, but not across edges that are `given` as seams.
    """
    waiting: list[_Part] = [((i,), piece, None) for i, piece in enumerate(pieces)]
    total, reached, splits = sum(len(piece.F) for piece in pieces), 0, 0
    done, uncut = list[_Done](), list[_Done]()
    while waiting:
        parts: list[_Part] = []
        own = open_slivers([piece for _, piece, _ in waiting])
        waiting = [(key, piece, known) for (key, _, known), piece in zip(waiting, own, strict=True)]
        together = iter(
            _known_together([piece for _, piece, kept in waiting if kept is None], options.method)
        )
        for key, piece, kept in waiting:
            known = next(together) if kept is None else kept
            reached += len(piece.F) if not splits else 0
            upto = constants.SEAMS_END + (constants.CHARTS_END - constants.SEAMS_END) * reached / total
            with progress_part("charts", upto) if known is None else nullcontext():
                made = _chart(piece, splits, options, known)
            if isinstance(made, Chart):
                done.append((key, made, piece))
                continue
            if isinstance(made, _Worth):
                uncut.append((key, made.uncut, piece))
                made = made.parts
            parts += [((*key, k), *smaller) for k, smaller in enumerate(made)]
        waiting, splits = parts, splits + 1
    done.sort(key=lambda entry: entry[0])  # parts stand where the piece was
    done = _cheaper(_measured(done), uncut, pieces, options)
    if options.may_find_seams:
        done = merge_small_charts(done, options.most_stretch, given)
    return [(chart, piece) for _, chart, piece in done]


@dataclass(frozen=True, eq=False)
class _Worth:
    """Parts along seams that seem to be worth the stretch that they save of a chart.

    Attributes
    ----------
    parts : list of _Cut
    uncut : Chart
        What stays if they are not.
    """

    parts: list[_Cut]
    uncut: Chart


def _measured(done: list[_Done]) -> list[_Done]:
    """The charts with all their figures; of those that kept a map only some are known."""
    rows = [i for i, (_, chart, _) in enumerate(done) if not chart.quality.faces]
    table = [(done[i][2], done[i][1].result.uv, done[i][1].overlapping) for i in rows]
    for i, quality in zip(rows, quality_of_each(table), strict=True):
        key, chart, piece = done[i]
        done[i] = key, replace(chart, quality=quality), piece
    return done


def _cheaper(
    done: list[_Done], uncut: list[_Done], pieces: list[Submesh], options: ChartOptions
) -> list[_Done]:
    """The charts; uncut ones instead of their parts where these cost more by their own maps and seams."""
    for key, chart, piece in reversed(uncut):  # parts of parts first
        first, last = (bisect_left(done, at, key=itemgetter(0)) for at in (key, (*key[:-1], key[-1] + 1)))
        parts, whole = done[first:last], pieces[key[0]].measured[0].sum()
        area = np.array([part.measured[0].sum() for _, _, part in parts]) / whole
        saved = area @ [chart.quality.stretch_l2 - part.quality.stretch_l2 for _, part, _ in parts]
        seams = priced_seams(CreasedSurface(piece, options.hidden), _parted_faces(piece, parts))[1]
        length = float(seams.sum() / np.sqrt(whole / 2))
        if not saved * stretch_weight(options.method) > options.worth(length):
            done[first:last] = [(key, chart, piece)]
    return done


def _parted_faces(piece: Submesh, parts: list[_Done]) -> IntArray:
    """The faces of a piece with vertices of their own in each part, (#F, 3)."""
    F, first = np.empty_like(piece.F), 0
    for _, _, part in parts:
        F[np.searchsorted(piece.faces, part.faces)] = part.F + first
        first += len(part.V)
    return F


def _known_together(pieces: list[Submesh], method: Method) -> list[KnownMap | None]:
    """The maps of pieces that are flattened together, small ones or many; None for the others."""
    known: list[KnownMap | None] = [None] * len(pieces)
    asked = list(range(len(pieces)))
    if len(pieces) < constants.MIN_PIECES_TOGETHER:  # only the smallest ones
        size = np.array([len(piece.F) for piece in pieces])
        order = np.argsort(size, kind="stable")
        asked = sorted(order[np.cumsum(size[order]) <= constants.MAX_FACES_TOGETHER].tolist())
    if not asked:
        return known
    advance("charts", 0.0)
    results = flatten_together([(pieces[i].V, pieces[i].F) for i in asked], method)
    good = [(i, result) for i, result in zip(asked, results, strict=True) if result is not None]
    pairs = overlapping_pairs_of_each([(result.uv, pieces[i].F) for i, result in good])
    whole = [(i, result) for (i, result), over in zip(good, pairs, strict=True) if not len(over)]
    measured = quality_of_each([(pieces[i], result.uv, 0) for i, result in whole])
    figures = dict(zip((i for i, _ in whole), measured, strict=True))
    for (i, result), over in zip(good, pairs, strict=True):
        known[i] = KnownMap(result, over, figures.get(i))
    return known


@dataclass(frozen=True, eq=False)
class _Mapped:
    """A piece's map, and what is known of it.

    Attributes
    ----------
    result : Flattening
    pairs : (#pairs, 2) int64
        Faces that overlap.
    change : MapMeasure
    quality : Quality or None
        None if it is not known yet.
    without_tips : bool
        Whether no tip in it is worth a seam.
    cost : float
        Increase of F/3nt by moving overlapping parts apart.
    """

    result: Flattening
    pairs: IntArray
    change: MapMeasure
    quality: Quality | None = None
    without_tips: bool = False
    cost: float = 0.0

    @classmethod
    def of(cls, piece: Submesh, known: KnownMap) -> _Mapped:
        change = MapMeasure(piece, known.result.uv)
        return cls(known.result, known.pairs, change, known.quality, known.without_tips)

    def moved(self, piece: Submesh, result: Flattening, pairs: IntArray, cost: float = 0.0) -> _Mapped:
        """With another map, of which nothing is measured yet."""
        change = MapMeasure(piece, result.uv)
        return replace(self, result=result, pairs=pairs, change=change, quality=None, cost=cost)


def _chart(
    piece: Submesh, splits: int, options: ChartOptions, known: KnownMap | None
) -> Chart | _Worth | list[_Cut]:
    """The flattened piece; or its parts, if it has to be cut further, or that seems to be worth it."""
    if splits < constants.MAX_EVEN_ROUNDS and len(seams := _to_even_texels(piece, options)):
        return _anew(piece.cut_along(seams))
    made = _mapped(piece, splits, options, known)
    if isinstance(made, _Mapped) and len(made.pairs):
        made = _without_overlaps(piece, made, splits, options)
    if not isinstance(made, _Mapped):
        return made
    stretch = made.change.stretch if made.quality is None else made.quality.stretch_l2
    seams = _NO_SEAM
    if options.weighs_stretch and not made.without_tips:
        seams = _worth_of_map(piece, stretch, made.change, splits, options)
    if stretch > options.most_stretch:
        parts = piece.cut_along(seams) if len(seams) else _less_stretched(piece, splits, options)
        if parts:
            return _anew(parts)
    quality = made.quality
    if quality is None:
        quality = quality_of(piece, made.result.uv, len(made.pairs), made.change.at_triangles)
    chart = Chart(piece.faces, made.result, quality, splits, len(made.pairs), made.cost)
    if not len(seams):
        return chart
    cuts, good = _anew(piece.cut_along(seams)), made.result.outcome.good and not len(made.pairs)
    return _Worth(cuts, chart) if good else cuts


def _mapped(
    piece: Submesh, splits: int, options: ChartOptions, known: KnownMap | None
) -> _Mapped | list[_Cut]:
    """The piece's map; or its parts, if a seam is worth it or double precision does not hold the map."""
    try:
        result, seams = _flattened(piece, splits, options) if known is None else (known.result, _NO_SEAM)
    except SingularSystemError:  # faces of no size beside others of the chart
        if parts := bisect(piece):
            return _anew(parts)
        raise
    if len(seams):
        return _anew(piece.cut_along(seams))
    if len(result.flipped) and options.may_find_seams:
        if parts := _less_flipped(piece, len(result.flipped), splits, options):
            return _anew(parts)
        result, known = _flattened_without_flips(piece, result, options), None
    if known is None:
        check_finite(result.uv, piece.vertices, "uv")
    needle = float(piece.measured[0].sum()) <= constants.NEEDLE_AREA * extent(result.uv) ** 2
    if needle and (parts := bisect(piece)):
        return _anew(parts)
    if known is None:
        known = KnownMap(result, overlapping_pairs_of_chart(piece.topology, result.uv), None)
    return _Mapped.of(piece, known)


def _without_overlaps(
    piece: Submesh, made: _Mapped, splits: int, options: ChartOptions
) -> _Mapped | list[_Cut]:
    """A map whose overlaps are moved apart or laid narrower; else the piece's parts; else the same map."""
    result, pairs = made.result, made.pairs
    few = len(np.unique(pairs)) < constants.FEW_OVERLAPPING * len(piece.F)
    if options.bijective and not result.holes and (apart := _moved_apart(piece, made, few)) is not None:
        return apart
    if splits >= options.most_splits:
        parts = bisect(piece)
        return _anew(parts) if parts else made
    if result.holes:  # first to a disk
        return _anew(_disks(piece, options))
    made = replace(made, without_tips=options.weighs_stretch and few)
    if made.without_tips and len(seams := _to_tips(piece, made.change, splits, options)):
        return _anew(piece.cut_along(seams))
    if few:
        narrower, left = _narrower(piece, result, pairs)
        if narrower is not result:
            made = made.moved(piece, narrower, left)
        if not len(left):
            return made
    return _cut_apart(piece, made, options) or made


def _moved_apart(piece: Submesh, made: _Mapped, few: bool) -> _Mapped | None:
    """A map without overlaps, by narrower faces or by SCAF; None if neither finds one."""
    if few:
        narrower, left = _narrower(piece, made.result, made.pairs)
        if not len(left):
            return made.moved(piece, narrower, left)
    bijective = move_parts_apart(piece, made.result, made.change)
    if bijective is None:
        return None
    apart, cost = bijective
    return made.moved(piece, apart, overlapping_pairs_of_chart(piece.topology, apart.uv), cost)


def _narrower(piece: Submesh, result: Flattening, pairs: IntArray) -> tuple[Flattening, IntArray]:
    """The map with some faces laid out narrower, and the pairs that still overlap; isometric ones stay."""
    if not result.outcome.good or is_isometric(piece, result.uv):
        return result, pairs
    return relayout_locally(piece, result, pairs)


def _cut_apart(piece: Submesh, made: _Mapped, options: ChartOptions) -> list[_Cut]:
    """The parts of a piece, cut where its map overlaps itself; nothing if it cannot be cut there."""
    result, pairs = made.result, made.pairs
    parts = [disk for part in split_at_creases(piece, result.uv) for disk in _disks(part, options)]
    parts = parts or split_overlaps(piece, piece.faces[pairs])
    if len(parts) <= 1:
        return []
    return list(zip(parts, reuse_maps(piece, result, parts, pairs, made.without_tips), strict=True))


@dataclass(eq=False)
class _SeamsToTips:
    """Tells whether a rough map shrinks tips that are worth seams, and keeps these seams."""

    piece: Submesh
    splits: int
    options: ChartOptions
    found: IntArray

    def __call__(self, uv: FloatArray) -> bool:
        self.found = _to_tips(self.piece, MapMeasure(self.piece, uv), self.splits, self.options)
        return len(self.found) > 0


def _flattened(piece: Submesh, splits: int, options: ChartOptions) -> tuple[Flattening, IntArray]:
    """A piece's map, and the seams that it is worth by a rough map.

    If there are such seams, or many faces flip, it is that rough map: the piece is then cut further.
    """
    method, tips = options.method, _SeamsToTips(piece, splits, options, _NO_SEAM)
    if type(method) is LinABF and method.iterations == "auto" and options.may_find_seams:
        looks = tips if options.weighs_stretch and not splits else None
        sketch = flatten_piece(piece, Sketch(**vars(method), is_enough=looks))
        if len(tips.found) or not 0 < len(sketch.flipped) <= constants.MAX_TIP_FLIPS * len(piece.F):
            return sketch, tips.found
    try:
        return flatten_piece(piece, method), tips.found
    except SingularSystemError as error:
        if isinstance(method, LinABF | ABF | Isometric):
            raise
        warnings.warn(
            f"the chart of faces {some(piece.faces)} is flattened by linear ABF: {error}",
            FallbackWarning,
            stacklevel=stack_level(),
        )
        return flatten_piece(piece, LinABF()), tips.found


def _worth_of_map(
    piece: Submesh, stretch: float, change: MapMeasure, splits: int, options: ChartOptions
) -> IntArray:
    """Seams that are worth the stretch that they save of a map, which may be more than was expected."""
    most_faces = MAX_FACES_OF_MEDIUM_BODY / TRADE * options.trade
    if splits < options.most_splits and len(piece.F) <= most_faces:
        seams = _NO_SEAM
        if splits:  # a part of a chart, whose seams were not for it
            if stretch > 1 + options.worth(constants.SOUGHT_SEAM_OF_PART):
                seams = _seams_worth(piece, options)
        elif stretch > 1 + options.worth(constants.SOUGHT_SEAM):  # it was one of many
            seams = options.seams_of(piece, disks=True, gain=options.worth(constants.DISK_SEAM))
        if len(seams):
            return seams
    return _to_tips(piece, change, splits, options) if stretch > TIP_STRETCH else _NO_SEAM


def _to_tips(piece: Submesh, change: MapMeasure, splits: int, options: ChartOptions) -> IntArray:
    """Seams to tips that the map shrinks; none after some rounds."""
    if splits >= constants.MAX_LEAF_ROUNDS:
        return _NO_SEAM
    return seams_to_tips(piece, change.at_triangles, options.trade, options.hidden)


def _anew(parts: list[Submesh]) -> list[_Cut]:
    """Parts that have no map yet."""
    return [(part, None) for part in parts]


def _disks(piece: Submesh, options: ChartOptions) -> list[Submesh]:
    """The piece, opened to disks by the shortest seams between its holes."""
    if len(piece.topology.loops) == 1:
        return [piece]
    return piece.cut_along(replace(options, trade=0.0, holes=False).seams_of(piece))


def _less_flipped(piece: Submesh, flips: int, splits: int, options: ChartOptions) -> list[Submesh]:
    """The piece cut further, and after some rounds halved; nothing where no seam is found."""
    few = flips <= constants.MAX_TIP_FLIPS * len(piece.F)
    if splits < (constants.MAX_LEAF_ROUNDS if few else constants.MAX_LEAF_ROUNDS_OF_MANY_FLIPS):
        leaves = _more_leaves(piece, options)
        return piece.cut_along(leaves) if len(leaves) else []
    return bisect(piece) if splits < options.most_splits else []


def _less_stretched(piece: Submesh, splits: int, options: ChartOptions) -> list[Submesh]:
    """The piece cut further, and from some number of cuts on halved; nothing where that cannot be."""
    if splits < constants.MAX_LEAF_ROUNDS and len(leaves := _more_leaves(piece, options)):
        return piece.cut_along(leaves)
    return bisect(piece) if splits < constants.MAX_SPLITS_FOR_STRETCH else []


def _to_even_texels(piece: Submesh, options: ChartOptions) -> IntArray:
    """More seams for a piece that its isometric map would stretch too much; the more, the longer they may be.

    Seams of `trade` t leave a stretch beyond 1 that falls about like the root of t: hence the square. That
    map takes far longer than to expect its stretch.
    """
    if options.even_stretch == np.inf or not piece.topology.loops:
        return _NO_SEAM
    closed = ClosedSurface.of(piece, isometric=True)
    stretch = isometric_stretch(closed, np.arange(closed.graph.n_holes))
    uneven = (stretch - 1) / (options.even_stretch - 1)
    if uneven <= 1:
        return _NO_SEAM
    return replace(options, trade=uneven**2 * options.trade).seams_of(piece, disks=True)


def _more_leaves(piece: Submesh, options: ChartOptions) -> IntArray:
    """More seams for a piece with flips: `trade` is doubled until `find_seams` finds some."""
    trades = max(options.trade, 1.0) * 2.0 ** np.arange(constants.MAX_TRADE_DOUBLINGS)
    found = (replace(options, trade=t).seams_of(piece, disks=True) for t in trades)
    return next((seams for seams in found if len(seams)), np.zeros((0, 2), dtype=np.int64))


def _flattened_without_flips(piece: Submesh, result: Flattening, options: ChartOptions) -> Flattening:
    """The map with guarantee='injective', for a piece that no seam keeps from flipping."""
    surer = guaranteed(options.method)
    if surer is None:
        return result
    warnings.warn(
        f"no seams were found that prevent flips in the chart of faces {some(piece.faces)}: it is flattened "
        "with guarantee='injective', at more distortion",
        FallbackWarning,
        stacklevel=stack_level(),
    )
    return flatten_piece(piece, surer)
