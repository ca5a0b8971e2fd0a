"""Unwrap any surface: cut it, flatten chart by chart without overlaps, pack."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import Progress, advance, part, reporting
from .._types import IntArray
from ..errors import FallbackWarning, MeshError, OutcomeWarning, some, stack_level
from ..flattening import Flattening, Method, Outcome, flatten_together, guaranteed, method_of
from ..measures import (
    Quality,
    change_of,
    overlapping_pairs,
    overlapping_pairs_of_each,
    quality_of,
    quality_of_each,
)
from ..surface import (
    Submesh,
    check_finite,
    complex_positions,
    flipped_faces,
    planar_mesh,
    seam_mask,
    signed_double_areas,
)
from .atlas import Atlas, Chart
from .overlap_seams import seams_between
from .packing import pack_maps
from .scaf import moved_apart
from .seams import TRADE, edges_between_textures, seams_of

SEAMS_END, CHARTS_END = 0.3, 0.95  # of the progress told: when seams are found, when packing begins
MAX_SPLITS = 8  # of a chart that flips or overlaps, and of its parts
MANY = 8  # charts from which they are flattened and measured together
TRADE_DOUBLINGS = 12  # until a chart that flips is cut further


def unwrap(
    V: ArrayLike,
    F: ArrayLike,
    seams: ArrayLike | None = None,
    method: str | Method = "linabf",
    *,
    trade: float = TRADE,
    holes: bool = False,
    bijective: bool = False,
    margin: float = 0.005,
    progress: Progress = None,
) -> Atlas:
    """Cut any surface into charts, flatten them without overlaps, and pack them.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles of any number of components, boundary loops and handles.
    seams : (#E, 2) int or (#F, 3) bool, optional
        Where to cut, as `cut` takes them. By default `find_seams` finds them. If a chart has flipped
        faces, its seams are extended; if that does not help, `guarantee="injective"` is used.
    method : str or method object
        As in `flatten`.
    trade : float
        As in `find_seams`: larger allows longer seams for less stretch.
    holes : bool
        Leave holes uncut, if `seams` is not given.
    bijective : bool
        If a chart overlaps itself, move its parts apart with `make_bijective` instead of splitting
        it. The chart's `cost` is the increase of F/3nt. Charts with holes are split.
    margin : float
        Distance between charts, and to the border, as a share of the unit square's side.
    progress : callable or False, optional
        As in `flatten`.

    Returns
    -------
    Atlas

    Raises
    ------
    MeshError
        The surface is not an oriented manifold, a face is degenerate, a seam is not an edge, or
        the given seams leave a chart with handles or without a boundary.

    Warns
    -----
    OutcomeWarning
        A chart has flipped faces, or still overlaps itself.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> atlas = unwrap(V, F)
    >>> len(atlas.charts), atlas.good, atlas.FTC.shape
    (1, True, (20, 3))
    """
    surface = Submesh.checked_manifold(V, F)
    task = _Task(method_of(method), seams is None, trade, holes, bijective)
    with reporting(progress):
        if seams is None:
            with part("seams", SEAMS_END):
                pieces = surface.cut_along(seams_of(surface, trade, holes=holes))
        else:
            pieces = surface.cut(seam_mask(seams, surface.named_faces, surface.n_given))
        done = _charts(pieces, task)
        with part("packing", 1.0):
            atlas = _packed(surface, done, margin)
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


@dataclass(frozen=True, eq=False)
class _Flat:
    """A piece whose map needs no further cut.

    `splits` and `cost` are as in `Chart`, and `overlapping` is the number of pairs of faces.
    """

    piece: Submesh
    result: Flattening
    splits: int
    overlapping: int
    cost: float


def _charts(pieces: list[Submesh], task: _Task) -> list[tuple[Chart, Submesh]]:
    """Flatten the pieces, and the parts of those that flip or overlap; all that wait at once."""
    waiting: list[tuple[tuple[int, ...], Submesh]] = [((i,), piece) for i, piece in enumerate(pieces)]
    total, reached = sum(len(piece.F) for piece in pieces), 0
    done: list[tuple[tuple[int, ...], _Flat]] = []
    for splits in range(MAX_SPLITS + 1):
        parts: list[tuple[tuple[int, ...], Submesh]] = []
        known = _flattened_together([piece for _, piece in waiting], task.method)
        for (key, piece), (result, pairs) in zip(waiting, known, strict=True):
            reached += len(piece.F) if not splits else 0
            with part("charts", SEAMS_END + (CHARTS_END - SEAMS_END) * reached / total):
                made = _chart(piece, splits, task, result, pairs)
            if isinstance(made, _Flat):
                done.append((key, made))
            else:
                parts += [((*key, k), smaller) for k, smaller in enumerate(made)]
        waiting = parts
    done.sort(key=lambda pair: pair[0])  # parts stand where the piece was
    flat = [made for _, made in done]
    return [(_told(made, quality), made.piece) for made, quality in zip(flat, _qualities(flat), strict=True)]


def _flattened_together(
    pieces: list[Submesh], method: Method
) -> list[tuple[Flattening | None, IntArray | None]]:
    """Maps of many small pieces and the pairs of faces that overlap in them; None: to be found alone."""
    found: list[tuple[Flattening | None, IntArray | None]] = [(None, None)] * len(pieces)
    if len(pieces) < MANY:
        return found
    results = flatten_together([(piece.V, piece.F) for piece in pieces], method)
    good = [(i, result) for i, result in enumerate(results) if result is not None]
    pairs = overlapping_pairs_of_each([(result.uv, pieces[i].F) for i, result in good])
    for (i, result), overlaps in zip(good, pairs, strict=True):
        found[i] = result, overlaps
    return found


def _qualities(flat: list[_Flat]) -> list[Quality]:
    if len(flat) < MANY:
        return [quality_of(made.piece, made.result.uv) for made in flat]
    return quality_of_each([(made.piece, made.result.uv, made.overlapping) for made in flat])


def _told(made: _Flat, quality: Quality) -> Chart:
    return Chart(made.piece.faces, made.result, quality, made.splits, made.overlapping, made.cost)


def _chart(
    piece: Submesh, splits: int, task: _Task, result: Flattening | None, pairs: IntArray | None
) -> _Flat | list[Submesh]:
    """The piece flattened; or its parts, where it is to be cut further.

    `result` and `pairs` are its map and the pairs of faces that overlap in it, where they are known.
    """
    if result is None:
        result = _flattened(piece, task.method)
    if len(result.flipped) and task.may_find_seams:  # double precision does not hold the map so little cut
        if splits < MAX_SPLITS and len(leaves := _more_leaves(piece, task)):
            return piece.cut_along(leaves)
        result = _flattened_without_flips(piece, result, task)
    cost = 0.0
    if pairs is None:
        check_finite(result.uv, piece.vertices, "uv")
        pairs = overlapping_pairs(result.uv, piece.F)
    if len(pairs) and task.bijective and not result.holes:
        result, cost = _made_bijective(piece, result)
        pairs = overlapping_pairs(result.uv, piece.F)
    elif len(pairs) and splits < MAX_SPLITS:
        if result.holes:  # first to a disk
            return piece.cut_along(seams_of(piece, trade=0))
        parts = piece.cut_along(seams_between([piece], piece.faces[pairs]))
        if len(parts) > 1:
            return parts
    return _Flat(piece, result, splits, len(pairs), cost)


def _flattened(piece: Submesh, method: Method) -> Flattening:
    """Flatten a piece; faces and vertices of the result are numbered within the piece."""
    start, topology = perf_counter(), piece.topology
    if topology.genus or not topology.loops:
        what = f"has {topology.genus} handle{'s' * (topology.genus > 1)}" if topology.loops else "is closed"
        which = f"the chart of faces {some(piece.faces)} {what}"
        raise MeshError(f"{which}: give more seams, or leave seams out and unwrap finds them")
    n = len(piece.V)
    mesh = replace(planar_mesh(piece), vertices=np.arange(n), n_given=n)
    checked = perf_counter() - start
    advance("check", 0.05)
    made = method.run(mesh, None)
    return replace(made, seconds={"check": checked, **made.seconds, "total": perf_counter() - start})


def _more_leaves(piece: Submesh, task: _Task) -> IntArray:
    """More seams for a piece with flips: `trade` is doubled until `find_seams` finds some."""
    trades = max(task.trade, 1.0) * 2.0 ** np.arange(TRADE_DOUBLINGS)
    found = (seams_of(piece, t, holes=task.holes, disks=True) for t in trades)
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
    return _flattened(piece, surer)


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


def _packed(surface: Submesh, done: list[tuple[Chart, Submesh]], margin: float) -> Atlas:
    placed = pack_maps([(chart.result.uv, piece.F) for chart, piece in done], margin)
    FTC, label, base = np.empty_like(surface.F), np.empty(len(surface.F), dtype=np.int64), 0
    for i, (_, piece) in enumerate(done):
        FTC[piece.faces], label[piece.faces] = piece.F + base, i
        base += len(piece.V)
    TC, origin = np.concatenate([p.uv for p in placed]), np.concatenate([piece.vertices for _, piece in done])
    V = np.concatenate([piece.V for _, piece in done])
    seams = edges_between_textures(surface.topology, FTC)
    return Atlas(
        TC=TC,
        FTC=FTC,
        origin=origin,
        chart=label,
        charts=tuple(chart for chart, _ in done),
        seams=surface.vertices[seams],
        seam_length=float(np.linalg.norm(surface.V[seams[:, 0]] - surface.V[seams[:, 1]], axis=1).sum()),
        splits=len(done) - len(surface.components()),
        fill=sum(p.area for p in placed),
        quality=quality_of(Submesh(V, FTC, surface.faces, origin, surface.n_given), TC),
    )
