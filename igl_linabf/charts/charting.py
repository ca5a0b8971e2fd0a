"""The charts of a surface: pieces, flattened, and cut further where they flip, overlap or stretch."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
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
from .atlas import Chart, flatten_piece, open_slivers, sides_of_cleaned, uv_of_part
from .constants import DISK_GAIN, FEW_TRIANGLES, NEEDLE_AREA, PROGRESS, SEAM_ROUNDS, TRADE_DOUBLINGS
from .features import extent
from .options import ChartOptions
from .seams import FEW_BODIES, MEDIUM_BODY
from .splitting import (
    FEW_FACES,
    REUSED_STRETCH,
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
_Part = tuple[Submesh, KnownMap | None]  # a piece, and its map, if it has one


def pieces_of(
    surface: Submesh, cleaned: Cleaned, seams: ArrayLike | None, F: IntArray, options: ChartOptions
) -> tuple[list[Submesh], IntArray]:
    """The surface cut along given seams and those that are found; and the edges of the given ones."""
    pieces, given = [surface], _NO_SEAM
    if seams is not None:
        if surface.vertices is not cleaned.origin:
            mask = sides_of_cleaned(seam_mask(seams, F, len(cleaned.merged), as_marked=True), cleaned)
        else:
            mask = seam_mask(seams, surface.vertices[surface.F], surface.n_given)
        face, k = np.nonzero(mask)
        given = surface.vertices[surface.F[face[:, None], np.column_stack((k, (k + 1) % 3))]]
        pieces = surface.cut(mask)
    if not options.may_find_seams:
        return pieces, given
    return [part for piece in pieces for part in piece.cut_along(_seams_for_stretch(piece, options))], given


def charts_of(pieces: list[Submesh], given: IntArray, options: ChartOptions) -> list[tuple[Chart, Submesh]]:
    """Flatten the pieces round by round: in each, all pieces that the round before has left or cut.

    No two charts are merged along edges that are `given` as seams.
    """
    # the key of a part is that of its piece and its number there
    waiting: list[tuple[tuple[int, ...], Submesh, KnownMap | None]]
    waiting = [((i,), piece, None) for i, piece in enumerate(pieces)]
    done: list[tuple[tuple[int, ...], Chart, Submesh]] = []
    total, reached, splits = sum(len(piece.F) for piece in pieces), 0, 0
    while waiting:
        keys, cut, maps = zip(*waiting, strict=True)
        own, waiting = open_slivers(list(cut)), []
        for key, piece, known in zip(keys, own, _maps_together(own, maps, options.method), strict=True):
            reached += len(piece.F) if not splits else 0
            upto = PROGRESS["seams"] + (PROGRESS["charts"] - PROGRESS["seams"]) * reached / total
            with progress_part("charts", upto) if known is None else nullcontext():
                made = _chart_or_parts(piece, splits, options, known)
            if isinstance(made, Chart):
                done.append((key, made, piece))
            else:
                waiting += [((*key, k), *part) for k, part in enumerate(made)]
        splits += 1
    done.sort(key=itemgetter(0))  # parts stand where the piece was
    if options.may_find_seams:
        done = merge_small_charts(done, options.most_stretch, given)
    unmeasured = [i for i, (_, chart, _) in enumerate(done) if not chart.quality.faces]
    table = [(done[i][2], done[i][1].result.uv, done[i][1].overlapping) for i in unmeasured]
    figures = dict(zip(unmeasured, quality_of_each(table), strict=True))
    return [
        (replace(chart, quality=figures[i]) if i in figures else chart, piece)
        for i, (_, chart, piece) in enumerate(done)
    ]


def _maps_together(
    pieces: list[Submesh], maps: Sequence[KnownMap | None], method: Method
) -> list[KnownMap | None]:
    """The maps, and those of small pieces or of many, all at once; None: to be flattened alone.

    Of many pieces that is all of them. Of few it is the smallest ones, as long as they have few triangles.
    """
    known = list(maps)
    asked = np.array([i for i, one in enumerate(maps) if one is None], dtype=np.int64)
    if len(asked) < FEW_BODIES:
        size = np.array([len(pieces[i].F) for i in asked.tolist()])
        order = np.argsort(size, kind="stable")
        asked = np.sort(asked[order[np.cumsum(size[order]) <= FEW_TRIANGLES]])
    if not len(asked):
        return known
    advance("charts", 0.0)
    rows = asked.tolist()
    results = flatten_together([(pieces[i].V, pieces[i].F) for i in rows], method)
    good = [(i, result) for i, result in zip(rows, results, strict=True) if result is not None]
    pairs = overlapping_pairs_of_each([(result.uv, pieces[i].F) for i, result in good])
    valid = [(i, result) for (i, result), over in zip(good, pairs, strict=True) if not len(over)]
    measured = quality_of_each([(pieces[i], result.uv, 0) for i, result in valid])
    figures = dict(zip((i for i, _ in valid), measured, strict=True))
    for (i, result), over in zip(good, pairs, strict=True):
        known[i] = KnownMap(result, over, figures.get(i))
    return known


@dataclass(frozen=True, eq=False)
class _PieceMap:
    """A piece's map, and what is known of it.

    Attributes
    ----------
    result : Flattening
    pairs : (#pairs, 2) int64
        Faces that overlap.
    measure : MapMeasure
    quality : Quality or None
        None if it is not known yet.
    without_tips : bool
        Whether no tip in it is worth a seam.
    cost : float
        Increase of F/3nt by moving overlapping parts apart.
    """

    result: Flattening
    pairs: IntArray
    measure: MapMeasure
    quality: Quality | None = None
    without_tips: bool = False
    cost: float = 0.0

    def moved(self, result: Flattening, pairs: IntArray, cost: float = 0.0) -> _PieceMap:
        """With another map, of which nothing is measured yet."""
        measure = MapMeasure(self.measure.piece, result.uv)
        return replace(self, result=result, pairs=pairs, measure=measure, quality=None, cost=cost)


def _chart_or_parts(
    piece: Submesh, splits: int, options: ChartOptions, known: KnownMap | None
) -> Chart | list[_Part]:
    """The flattened piece; or its parts, if it has to be cut further."""
    made = _map_or_parts(piece, splits, options, known)
    if isinstance(made, _PieceMap) and len(made.pairs):
        made = _resolve_overlaps(piece, made, splits, options)
    if not isinstance(made, _PieceMap):
        return made
    stretch = made.measure.stretch if made.quality is None else made.quality.stretch_l2
    weighed = options.weighs_stretch and not made.without_tips
    if weighed and len(seams := _seams_for_map(piece, stretch, made.measure, splits, options)):
        return _unmapped(piece.cut_along(seams))
    if stretch > options.most_stretch and (parts := _split_for_stretch(piece, splits, options)):
        return _unmapped(parts)
    quality = made.quality
    if quality is None:
        quality = quality_of(piece, made.result.uv, len(made.pairs), made.measure.at_triangles)
    return Chart(piece.faces, made.result, quality, splits, len(made.pairs), made.cost)


def _map_or_parts(
    piece: Submesh, splits: int, options: ChartOptions, known: KnownMap | None
) -> _PieceMap | list[_Part]:
    """The piece's map; or its parts, if a seam is worth it, or if double precision does not hold the map."""
    try:
        result, seams = _flatten(piece, splits, options) if known is None else (known.result, _NO_SEAM)
    except SingularSystemError:  # faces of no size beside others of the chart
        if parts := bisect(piece):
            return _unmapped(parts)
        raise
    if len(seams):
        return _unmapped(piece.cut_along(seams))
    if len(result.flipped) and options.may_find_seams:
        if parts := _split_for_flips(piece, splits, options):
            return _unmapped(parts)
        result, known = _flatten_without_flips(piece, result, options), None
    if known is None:
        check_finite(result.uv, piece.vertices, "uv")
    # double precision hardly tells such a map from a line: no packing could turn it
    is_needle = float(piece.measured[0].sum()) <= NEEDLE_AREA * extent(result.uv) ** 2
    if is_needle and (parts := bisect(piece)):
        return _unmapped(parts)
    measure = MapMeasure(piece, result.uv)
    if known is None:
        return _PieceMap(result, overlapping_pairs_of_chart(piece.topology, result.uv), measure)
    return _PieceMap(known.result, known.pairs, measure, known.quality, known.without_tips)


def _flatten(piece: Submesh, splits: int, options: ChartOptions) -> tuple[Flattening, IntArray]:
    """The piece's map, and seams to tips that a rough map shrinks.

    If there are such seams, or many faces flip, the map is a rough one, as the piece is then cut further.
    """
    method, seams = options.method, _NO_SEAM

    def shrinks_tips(uv: FloatArray) -> bool:
        nonlocal seams
        seams = _seams_for_tips(piece, MapMeasure(piece, uv), splits, options)
        return len(seams) > 0

    if type(method) is LinABF and method.iterations == "auto" and options.may_find_seams:
        is_enough = shrinks_tips if options.weighs_stretch and not splits else None
        sketch = flatten_piece(piece, Sketch(**vars(method), is_enough=is_enough))
        if len(seams) or not 0 < len(sketch.flipped) <= FEW_FACES * len(piece.F):
            return sketch, seams
    try:
        return flatten_piece(piece, method), seams
    except SingularSystemError as error:
        if isinstance(method, LinABF | ABF | Isometric):
            raise
        warnings.warn(
            f"the chart of faces {some(piece.faces)} is flattened by linear ABF: {error}",
            FallbackWarning,
            stacklevel=stack_level(),
        )
        return flatten_piece(piece, LinABF()), seams


def _flatten_without_flips(piece: Submesh, result: Flattening, options: ChartOptions) -> Flattening:
    """The map with guarantee='injective', for a piece that no seam keeps from flipping."""
    method = guaranteed(options.method)
    if method is None:
        return result
    warnings.warn(
        f"no seams were found that prevent flips in the chart of faces {some(piece.faces)}: it is flattened "
        "with guarantee='injective', at more distortion",
        FallbackWarning,
        stacklevel=stack_level(),
    )
    return flatten_piece(piece, method)


def _resolve_overlaps(
    piece: Submesh, made: _PieceMap, splits: int, options: ChartOptions
) -> _PieceMap | list[_Part]:
    """A map with overlaps moved apart or laid out narrower; else the piece's parts; else the same map."""
    result, pairs = made.result, made.pairs
    few = len(np.unique(pairs)) < FEW_FACES * len(piece.F)
    if options.bijective and not result.holes and (apart := _move_apart(piece, made, few)) is not None:
        return apart
    if splits >= options.most_splits:
        parts = bisect(piece)
        return _unmapped(parts) if parts else made
    if result.holes:  # first to a disk
        return _unmapped(_open_holes(piece, options))
    made = replace(made, without_tips=options.weighs_stretch and few)
    if made.without_tips and len(seams := _seams_for_tips(piece, made.measure, splits, options)):
        return _unmapped(piece.cut_along(seams))
    if few:
        narrower, left = _relayout(piece, result, pairs)
        if narrower is not result:
            made = made.moved(narrower, left)
        if not len(left):
            return made
    return _split_at_overlaps(piece, made, few, splits, options) or made


def _move_apart(piece: Submesh, made: _PieceMap, few: bool) -> _PieceMap | None:
    """A map without overlaps, by narrower faces or SCAF; None if neither makes one."""
    if few:
        narrower, left = _relayout(piece, made.result, made.pairs)
        if not len(left):
            return made.moved(narrower, left)
    bijective = move_parts_apart(piece, made.result, made.measure)
    if bijective is None:
        return None
    apart, cost = bijective
    return made.moved(apart, overlapping_pairs_of_chart(piece.topology, apart.uv), cost)


def _relayout(piece: Submesh, result: Flattening, pairs: IntArray) -> tuple[Flattening, IntArray]:
    """The map with some faces laid out narrower, and the pairs that still overlap; not of isometric ones."""
    if not result.outcome.good or is_isometric(piece, result.uv):
        return result, pairs
    return relayout_locally(piece, result, pairs)


def _split_at_overlaps(
    piece: Submesh, made: _PieceMap, few: bool, splits: int, options: ChartOptions
) -> list[_Part]:
    """The parts of a piece, cut where its map overlaps itself; nothing if it cannot be cut there.

    Where only `few` of its faces overlap, its tips have been looked at. Otherwise those of a part that is to
    be flattened anew are cut open here, as the piece's map shows them.
    """
    result, pairs = made.result, made.pairs
    parts = [d for part in split_at_creases(piece, result.uv, pairs) for d in _open_holes(part, options)]
    parts = parts or split_overlaps(piece, piece.faces[pairs])
    if len(parts) <= 1:
        return []
    split: list[_Part] = []
    with_tips = options.weighs_stretch and not few and result.outcome.good
    for part, known in zip(parts, reuse_maps(piece, result, parts, pairs, made.without_tips), strict=True):
        if with_tips and known is None and len(part.F) >= FEW_FACES * len(piece.F):
            measure = MapMeasure(part, uv_of_part(result.uv, piece, part))
            if measure.stretch > REUSED_STRETCH:
                seams = _seams_for_tips(part, measure, splits, options)
                if len(seams):
                    split += _unmapped(part.cut_along(seams))
                    continue
        split.append((part, known))
    return split


def _seams_for_map(
    piece: Submesh, stretch: float, measure: MapMeasure, splits: int, options: ChartOptions
) -> IntArray:
    """Seams that the stretch of a map is worth, beyond what was expected of it."""
    if stretch <= TIP_STRETCH:
        return _NO_SEAM
    if splits < options.most_splits and len(piece.F) <= MEDIUM_BODY:
        if splits:  # a part of a chart, whose seams were not for it
            seams = _seams_for_stretch(piece, options)
        else:  # its seams may have been found together with those of others
            seams = options.seams_of(piece, disks=True, gain=DISK_GAIN)
        if len(seams):
            return seams
    return _seams_for_tips(piece, measure, splits, options)


def _seams_for_stretch(piece: Submesh, options: ChartOptions) -> IntArray:
    """The seams that its components need, and those that their stretch is worth; of disks, too."""
    if not options.holes:
        return options.seams_of(piece, disks=True, gain=DISK_GAIN, part_overlaps=True, panels=True)
    found = [
        # other components keep their holes as they are
        options.seams_of(part, disks=len(part.topology.loops) == 1, gain=DISK_GAIN)
        for part in piece.components()
    ]
    return np.concatenate(found)


def _seams_for_tips(piece: Submesh, measure: MapMeasure, splits: int, options: ChartOptions) -> IntArray:
    """Seams to tips that the map shrinks, in the first rounds."""
    if splits >= SEAM_ROUNDS:
        return _NO_SEAM
    return seams_to_tips(piece, measure.at_triangles, options.trade, options.hidden)


def _split_for_flips(piece: Submesh, splits: int, options: ChartOptions) -> list[Submesh]:
    """The piece cut further, and after some rounds in halves; nothing where no seam is found."""
    if splits < SEAM_ROUNDS:
        seams = _longer_seams(piece, options)
        return piece.cut_along(seams) if len(seams) else []
    return bisect(piece) if splits < options.most_splits else []


def _split_for_stretch(piece: Submesh, splits: int, options: ChartOptions) -> list[Submesh]:
    """The piece cut further, and after some rounds in halves; nothing where that cannot be."""
    if splits < SEAM_ROUNDS and len(seams := _longer_seams(piece, options)):
        return piece.cut_along(seams)
    return bisect(piece)


def _longer_seams(piece: Submesh, options: ChartOptions) -> IntArray:
    """Seams at the least doubling of `trade` that finds some."""
    trades = max(options.trade, 1.0) * 2.0 ** np.arange(TRADE_DOUBLINGS)
    found = (replace(options, trade=trade).seams_of(piece, disks=True) for trade in trades)
    return next((seams for seams in found if len(seams)), _NO_SEAM)


def _open_holes(piece: Submesh, options: ChartOptions) -> list[Submesh]:
    """The piece with its holes joined by the shortest seams."""
    if len(piece.topology.loops) == 1:
        return [piece]
    return piece.cut_along(replace(options, trade=0.0, holes=False).seams_of(piece))


def _unmapped(parts: list[Submesh]) -> list[_Part]:
    """Parts that are flattened again."""
    return [(part, None) for part in parts]
