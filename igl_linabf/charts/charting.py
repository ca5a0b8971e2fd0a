"""Make the charts of a surface: flatten its pieces, and cut pieces whose maps are not good enough."""

from __future__ import annotations

import warnings
from bisect import bisect_left
from collections import Counter
from contextlib import nullcontext
from dataclasses import dataclass, replace
from enum import Enum
from operator import itemgetter

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import advance, progress_part
from .._types import IntArray
from ..errors import FallbackWarning, SingularSystemError, first_few, stack_level
from ..flattening import (
    ABF,
    Flattening,
    Isometric,
    LinABF,
    Method,
    flatten_batch,
    get_guaranteed_method,
    report_overlaps,
)
from ..measures import (
    NO_PAIRS,
    Quality,
    find_overlapping_pairs_of_chart,
    find_overlapping_pairs_of_charts,
    measure_qualities,
    measure_quality,
)
from ..surface import Cleaned, Submesh, check_finite, make_seam_mask
from . import constants
from .atlas import Chart, compute_division_price, flatten_piece, map_sides_to_cleaned, open_slivers
from .cut_graphs import ClosedSurface, get_stretch_weight, predict_isometric_stretch
from .features import CreasedSurface, measure_extent
from .options import ChartRules
from .splitting import (
    TIP_STRETCH,
    MapDistortion,
    bisect_piece,
    find_seams_to_tips,
    merge_small_charts,
    move_parts_apart,
    split_overlaps,
)

MIN_PIECES_TOGETHER = 8  # from this number of pieces, all pieces are flattened in one batch
MAX_FACES_TOGETHER = 4_000  # of fewer pieces, the smallest are batched, with this many faces in total
# A map is practically a line up to this ratio of its double area to its squared extent.
NEEDLE_AREA = 1e-13
POINT_SIZE = 1e-13  # a triangle is a point if its longest side divided by the map's extent is at most this
MAX_TIP_FLIPS = 0.05  # up to this share of flipped faces, shrunk tips are the likely cause
MAX_SEAM_ROUNDS = 8  # times that seams are added against flips or stretch, before a piece is halved
MAX_SEAM_ROUNDS_WITH_MANY_FLIPS = 2  # replaces `MAX_SEAM_ROUNDS` above `MAX_TIP_FLIPS`
MAX_TRADE_DOUBLINGS = 12  # maximum number of times that `trade` is doubled to find more seams
# Search for more seams only if the stretch is worth a seam of this length, in square roots of the area.
MIN_SOUGHT_SEAM_LENGTH = 1.0
MAX_EVEN_ROUNDS = 3  # maximum number of times seams are added for an even texel density
MAX_FLIP_ROUNDS = 20  # maximum number of cuts against flips; the last cuts halve the piece
MAX_STRETCH_ROUNDS = 64  # maximum number of cuts against stretch; the last cuts halve the piece

_NO_SEAM = np.zeros((0, 2), dtype=np.int64)


class Reason(Enum):
    """A reason to cut a piece further. There is a maximum number of cuts for each reason."""

    UNEVEN = "uneven texels"
    FLIPS = "flipped triangles"
    OVERLAP = "overlaps"
    STRETCH = "stretch"
    THIN = "the limits of double precision"


def cut_into_pieces(
    surface: Submesh,
    cleaned: Cleaned,
    seams: ArrayLike | None,
    F: IntArray,
    labels: IntArray | None,
    rules: ChartRules,
) -> tuple[list[Submesh], IntArray]:
    """Cut the surface along the given seams and along further seams.

    Edges between triangles of different labels count as given seams. Also return the vertices of the given
    seams, (#E, 2).
    """
    pieces, given, mask = [surface], _NO_SEAM, None
    if seams is not None:
        if surface.vertices is not cleaned.origin:
            mask = map_sides_to_cleaned(
                make_seam_mask(seams, F, len(cleaned.merged), as_marked=True), cleaned
            )
        else:
            mask = make_seam_mask(seams, surface.vertices[surface.F], surface.n_given)
    if labels is not None:
        between = surface.mask_sides_between(labels[surface.faces])
        mask = between if mask is None else mask | between
    if mask is not None:
        face, k = np.nonzero(mask)
        given = surface.vertices[surface.F[face[:, None], np.column_stack((k, (k + 1) % 3))]]
        pieces = surface.cut(mask)
    if not rules.may_find_seams:
        return pieces, given
    search = rules.seam_search
    found = [piece.cut_along(search.find_seams(piece)) for piece in pieces]
    return [part for parts in found for part in parts], given


Key = tuple[int, ...]  # position in the tree of cuts: index of a piece, of a part of the piece, and so on
_FinishedChart = tuple[Key, Chart, Submesh]


@dataclass(frozen=True, eq=False)
class _PendingPiece:
    """A piece that is still to be flattened.

    Attributes
    ----------
    key : Key
    piece : Submesh
    rounds : Counter of Reason
        Number of cuts, for each reason, that led from the original piece to this part.
    """

    key: Key
    piece: Submesh
    rounds: Counter[Reason]

    def divide(self, parts: list[Submesh], reason: Reason) -> list[_PendingPiece]:
        """Return a `_PendingPiece` for each part of the piece, after a cut for `reason`."""
        rounds = self.rounds + Counter([reason])
        return [_PendingPiece((*self.key, k), part, rounds) for k, part in enumerate(parts)]


@dataclass(frozen=True, eq=False)
class _FlattenedPiece:
    """The result of flattening a piece: a chart, the parts of the piece, or both.

    Attributes
    ----------
    chart : Chart or None
        None if the map is not good enough for a chart.
    parts : list of Submesh
        The parts that the piece is cut into. They replace the chart, if there is one, only if they cost less.
    reason : Reason or None
        The reason for the cut; None if the piece is not cut.
    """

    chart: Chart | None
    parts: list[Submesh]
    reason: Reason | None


@dataclass(frozen=True, eq=False)
class _PieceMap:
    """The map of a piece.

    Attributes
    ----------
    result : Flattening
    pairs : (#P, 2) int64
        The pairs of faces that overlap.
    quality : Quality or None
        None before the quality is measured.
    cost : float
        Increase of `Quality.angle_distortion` from moving overlapping parts apart.
    """

    result: Flattening
    pairs: IntArray
    quality: Quality | None = None
    cost: float = 0.0


def make_charts(pieces: list[Submesh], given: IntArray, rules: ChartRules) -> list[tuple[Chart, Submesh]]:
    """Flatten pieces, cut those whose maps are not good enough, and treat the parts in the same way.

    Finally, small charts are merged into adjacent charts, except across the seams `given`.
    """
    waiting = [_PendingPiece((i,), piece, Counter()) for i, piece in enumerate(pieces)]
    total, reached = sum(len(piece.F) for piece in pieces), 0
    done, uncut = list[_FinishedChart](), list[_FinishedChart]()
    while waiting:
        opened = open_slivers([work.piece for work in waiting])
        waiting = [replace(work, piece=piece) for work, piece in zip(waiting, opened, strict=True)]
        parts = list[_PendingPiece]()
        for work, made in zip(waiting, _flatten_together(opened, rules.method), strict=True):
            reached += len(work.piece.F) if len(work.key) == 1 else 0
            upto = constants.SEAMS_END + (constants.CHARTS_END - constants.SEAMS_END) * reached / total
            with progress_part("charts", upto) if made is None else nullcontext():
                tried = _try_piece(work, rules, made)
            if tried.reason is None:
                assert tried.chart is not None
                done.append((work.key, tried.chart, work.piece))
                continue
            if tried.chart is not None:
                uncut.append((work.key, tried.chart, work.piece))
            parts += work.divide(tried.parts, tried.reason)
        waiting = parts
    done.sort(key=lambda entry: entry[0])  # parts of a piece become consecutive
    done = _undo_costly_cuts(done, uncut, pieces, rules)
    done = merge_small_charts(done, rules.stretch_limit, given)
    return [(chart, piece) for _, chart, piece in done]


def _undo_costly_cuts(
    done: list[_FinishedChart], uncut: list[_FinishedChart], pieces: list[Submesh], rules: ChartRules
) -> list[_FinishedChart]:
    """Replace the parts of a piece by its chart in `uncut` if the saved stretch is not worth the seams."""
    for key, chart, piece in reversed(uncut):  # undo the last cuts first
        first, last = (bisect_left(done, at, key=itemgetter(0)) for at in (key, (*key[:-1], key[-1] + 1)))
        parts, whole = done[first:last], pieces[key[0]].areas_and_products[0].sum()
        area = np.array([part.areas_and_products[0].sum() for _, _, part in parts]) / whole
        saved = area @ [chart.quality.stretch_l2 - part.quality.stretch_l2 for _, part, _ in parts]
        price = compute_division_price(CreasedSurface(piece, rules.hidden), [part for _, _, part in parts])
        length = price / np.sqrt(whole / 2)
        if not saved * get_stretch_weight(rules.method) > rules.get_required_gain(length):
            done[first:last] = [(key, chart, piece)]
    return done


def _flatten_together(pieces: list[Submesh], method: Method) -> list[_PieceMap | None]:
    """Flatten pieces in one batch; return None for each piece outside the batch.

    If there are few pieces, the batch contains only the smallest ones.
    """
    made: list[_PieceMap | None] = [None] * len(pieces)
    asked = list(range(len(pieces)))
    if len(pieces) < MIN_PIECES_TOGETHER:
        size = np.array([len(piece.F) for piece in pieces])
        order = np.argsort(size, kind="stable")
        asked = sorted(order[np.cumsum(size[order]) <= MAX_FACES_TOGETHER].tolist())
    if not asked:
        return made
    advance("charts", 0.0)
    results = flatten_batch([(pieces[i].V, pieces[i].F) for i in asked], method)
    good = [(i, result) for i, result in zip(asked, results, strict=True) if result is not None]
    doubtful = [(k, result) for k, (_, result) in enumerate(good) if not result.outcome.good]
    found = find_overlapping_pairs_of_charts([(result.uv, result.F) for _, result in doubtful])
    pairs = [NO_PAIRS] * len(good)
    for (k, _), over in zip(doubtful, found, strict=True):
        pairs[k] = over
    measured = measure_qualities(
        [(pieces[i], r.uv, len(over)) for (i, r), over in zip(good, pairs, strict=True)]
    )
    for (i, result), over, quality in zip(good, pairs, measured, strict=True):
        made[i] = _PieceMap(result, over, quality)
    return made


def _try_piece(work: _PendingPiece, rules: ChartRules, made: _PieceMap | None) -> _FlattenedPiece:
    """Make a chart of a piece, or cut the piece further.

    `made` is the map of the piece if it was flattened in a batch, otherwise None.
    """
    piece, rounds = work.piece, work.rounds
    seams = _find_seams_for_even_texels(piece, rules) if rounds[Reason.UNEVEN] < MAX_EVEN_ROUNDS else _NO_SEAM
    if len(seams):
        return _FlattenedPiece(None, piece.cut_along(seams), Reason.UNEVEN)
    try:
        made = _flatten_single_piece(piece, rules) if made is None else made
    except SingularSystemError:  # because some faces are negligibly small
        if parts := bisect_piece(piece):
            return _FlattenedPiece(None, parts, Reason.THIN)
        raise
    if len(made.result.flipped) and rules.may_find_seams:
        if parts := _cut_for_flips(piece, len(made.result.flipped), rounds[Reason.FLIPS], rules):
            return _FlattenedPiece(None, parts, Reason.FLIPS)
        made = _flatten_without_flips(piece, made, rules)
    if _exceeds_double_precision(piece, made.result) and (parts := bisect_piece(piece)):
        return _FlattenedPiece(None, parts, Reason.THIN)
    if len(made.pairs):
        made, parts = _resolve_overlaps(piece, made, rounds[Reason.OVERLAP], rules)
        if parts:
            return _FlattenedPiece(None, parts, Reason.OVERLAP)
    change = MapDistortion(piece, made.result.uv)
    quality = made.quality
    if quality is None:
        quality = measure_quality(piece, made.result.uv, len(made.pairs), change.triangle_changes)
    result = report_overlaps(made.result, piece.faces[made.pairs])
    reasons = tuple(reason.value for reason in rounds)
    chart = Chart(
        piece.faces, result, quality, rounds.total(), len(made.pairs), made.cost, split_reasons=reasons
    )
    parts = _cut_for_stretch(piece, change, quality.stretch_l2, rounds[Reason.STRETCH], rules)
    if not parts:
        return _FlattenedPiece(chart, [], None)
    usable = quality.stretch_l2 <= rules.stretch_limit and made.result.outcome.good and not len(made.pairs)
    return _FlattenedPiece(chart if usable else None, parts, Reason.STRETCH)


def _flatten_single_piece(piece: Submesh, rules: ChartRules) -> _PieceMap:
    """Flatten one piece; fall back to linear ABF if the linear system of another method is singular."""
    try:
        result = flatten_piece(piece, rules.method)
    except SingularSystemError as error:
        if isinstance(rules.method, LinABF | ABF | Isometric):
            raise
        warnings.warn(
            f"the chart of faces {first_few(piece.faces)} is flattened by linear ABF: {error}",
            FallbackWarning,
            stacklevel=stack_level(),
        )
        result = flatten_piece(piece, LinABF())
    check_finite(result.uv, piece.vertices, "uv")
    return _PieceMap(result, find_overlapping_pairs_of_chart(piece.topology, result.uv))


def _flatten_without_flips(piece: Submesh, made: _PieceMap, rules: ChartRules) -> _PieceMap:
    """Flatten a piece with guarantee='injective', if no seam was found that prevents flips."""
    surer = get_guaranteed_method(rules.method)
    if surer is None:
        return made
    warnings.warn(
        f"no seams were found that prevent flips in the chart of faces {first_few(piece.faces)}: it is "
        "flattened with guarantee='injective', at more distortion",
        FallbackWarning,
        stacklevel=stack_level(),
    )
    return _flatten_single_piece(piece, replace(rules, method=surer))


def _exceeds_double_precision(piece: Submesh, result: Flattening) -> bool:
    """Return True if a map is practically a line, or if flipped triangles have shrunk to points."""
    size, corners = measure_extent(result.uv), result.uv[piece.F[result.flipped]]
    is_line = float(piece.areas_and_products[0].sum()) <= NEEDLE_AREA * size**2
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    return is_line or bool((longest <= POINT_SIZE * size).any())


def _resolve_overlaps(
    piece: Submesh, made: _PieceMap, rounds: int, rules: ChartRules
) -> tuple[_PieceMap, list[Submesh]]:
    """Move overlapping parts of a map apart, or cut the piece between them.

    Return the map and a list of the parts, which is empty if the piece is not cut.
    """
    if rules.repair_overlaps and not made.result.holes:
        moved = move_parts_apart(piece, made.result, MapDistortion(piece, made.result.uv))
        if moved is not None:
            result, cost = moved
            return _PieceMap(
                result, find_overlapping_pairs_of_chart(piece.topology, result.uv), None, cost
            ), []
    if rounds >= constants.MAX_OVERLAP_ROUNDS:
        return made, bisect_piece(piece)
    parts = split_overlaps(piece, piece.faces[made.pairs])
    if len(parts) > 1:
        return made, parts
    return made, _cut_to_disk(piece, rules) if made.result.holes else []


def _cut_for_flips(piece: Submesh, flips: int, rounds: int, rules: ChartRules) -> list[Submesh]:
    """Cut a piece with flipped triangles along additional seams, or halve it.

    The list of parts is empty if no seam is found.
    """
    few = flips <= MAX_TIP_FLIPS * len(piece.F)
    if rounds < (MAX_SEAM_ROUNDS if few else MAX_SEAM_ROUNDS_WITH_MANY_FLIPS):
        leaves = _find_more_seams(piece, rules)
        return piece.cut_along(leaves) if len(leaves) else []
    return bisect_piece(piece) if rounds < MAX_FLIP_ROUNDS else []


def _cut_for_stretch(
    piece: Submesh, change: MapDistortion, stretch: float, rounds: int, rules: ChartRules
) -> list[Submesh]:
    """Cut a piece further if the saved stretch may be worth the seam, or if `max_stretch` requires it."""
    seams, too_much = _NO_SEAM, stretch > rules.stretch_limit
    if rules.weighs_stretch and rounds < MAX_SEAM_ROUNDS:
        if stretch > 1 + rules.get_required_gain(MIN_SOUGHT_SEAM_LENGTH):
            seams = rules.seam_search.find_seams(piece)
        if not len(seams) and stretch > TIP_STRETCH:
            seams = find_seams_to_tips(piece, change.triangle_changes, rules.trade, rules.hidden)
    if too_much and not len(seams) and rounds < MAX_SEAM_ROUNDS:
        seams = _find_more_seams(piece, rules)
    if len(seams):
        return piece.cut_along(seams)
    return bisect_piece(piece) if too_much and rounds < MAX_STRETCH_ROUNDS else []


def _cut_to_disk(piece: Submesh, rules: ChartRules) -> list[Submesh]:
    """Cut a piece into a disk along the shortest seams between its holes."""
    shortest = replace(rules, trade=0.0, keep_holes=False).seam_search
    return piece.cut_along(shortest.find_needed_seams(piece))


def _find_more_seams(piece: Submesh, rules: ChartRules) -> IntArray:
    """Find seams for a piece that can stay uncut, by doubling `trade` until seams are found."""
    for k in range(1, MAX_TRADE_DOUBLINGS + 1):
        search = replace(rules, trade=max(rules.trade, 1.0) * 2.0**k).seam_search
        if len(seams := search.find_seams(piece)):
            return seams
    return _NO_SEAM


def _find_seams_for_even_texels(piece: Submesh, rules: ChartRules) -> IntArray:
    """Find seams for a piece whose isometric map would be stretched too unevenly.

    The stretch is predicted, which takes far less time than flattening the piece. With seams for
    `trade` = t, the L2 stretch minus 1 is roughly proportional to t**-0.5.
    """
    if rules.even_stretch_limit == np.inf or not piece.topology.loops:
        return _NO_SEAM
    closed = ClosedSurface.from_submesh(piece, isometric=True)
    stretch = predict_isometric_stretch(closed, np.arange(closed.graph.n_holes))
    uneven = (stretch - 1) / (rules.even_stretch_limit - 1)
    if uneven <= 1:
        return _NO_SEAM
    return replace(rules, trade=uneven**2 * rules.trade).seam_search.find_seams(piece)
