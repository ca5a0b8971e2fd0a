"""Any surface as an atlas: cut, flattened chart by chart, without overlaps, packed."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import Progress, advance, part, reporting
from .._types import IntArray
from ..errors import FallbackWarning, MeshError, MeshWarning, OutcomeWarning, some, stack_level
from ..flattening import Flattening, Method, Outcome, guaranteed, method_of
from ..measures import change_of, overlapping_pairs, quality_of
from ..surface import (
    Cleaned,
    Submesh,
    as_it_is,
    check_finite,
    cleaned_surface,
    complex_positions,
    flipped_faces,
    planar_mesh,
    seam_mask,
    signed_double_areas,
)
from .atlas import BEYOND_USE, ROUNDING, Atlas, Chart
from .given import given_back, sides_of_cleaned, without_charts
from .halving import halves
from .overlap_seams import seams_between
from .packing import pack_maps
from .scaf import moved_apart
from .seams import TRADE, edges_between_textures, seams_of

SEAMS_END, CHARTS_END = 0.3, 0.95  # of the progress told: when seams are found, when packing begins
DISK_GAIN = 0.05  # L2 stretch that seams must save, beyond their price, on a component that needs none
MAX_SPLITS = 8  # of a chart that flips or overlaps, and of its parts
MAX_SPLITS_FOR_STRETCH = 64  # of one that is stretched more than is asked for, or beyond use
MAX_LEAF_ROUNDS = 8  # of more seams for that, before it is halved
MARGINS = 0.64  # share of the square that margins around all charts may take
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
    max_stretch: float | None = None,
    complete: bool = False,
    weld: float | None = None,
    strict: bool = False,
    progress: Progress = None,
) -> Atlas:
    """Cut any surface into charts, flatten them without overlaps, and pack them.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions, finite where a face is.
    F : (#F, 3) int
        Any triangles. Those that are no clean oriented manifold are made one, as `clean` does.
    seams : (#E, 2) int or (#F, 3) bool, optional
        Where to cut, as `cut` takes them; by default what `find_seams` finds, and more of it where
        a chart comes out with flipped faces, and `guarantee="injective"` where none helps.
    method : str or method object
        As in `flatten`.
    trade : float
        Of `find_seams`: seam length against distortion, of disks, too.
    holes : bool
        Leave holes uncut, where `seams` are to be found.
    bijective : bool
        Do not split a chart that lies over itself: `make_bijective` moves its parts from each
        other, at the price in F/3nt that the chart's `cost` says. Charts with holes are split.
    margin : float
        Between charts, and at the border, as a share of the unit square's side. Less, with a
        warning, where the charts are too many for it.
    max_stretch : float, optional
        Cut or split charts, beyond given `seams`, too, until the L2 stretch of each is at most this.
        At least 1; by default stretch is only weighed against seam length.
    complete : bool
        `seams` are a beginning: the others that handles, closed pieces and stretch need are found.
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
        With `strict`, also: the surface is no oriented manifold, or a face has no area.
    ValueError
        `trade`, `margin`, `max_stretch` or `weld` is out of its range.

    Warns
    -----
    MeshWarning
        The mesh was repaired; `atlas.repairs` has the details.
    OutcomeWarning
        A chart has flipped faces, lies over itself still, or is stretched beyond use.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> atlas = unwrap(V, F)
    >>> len(atlas.charts), atlas.good, atlas.FTC.shape
    (1, True, (20, 3))
    """
    if max_stretch is not None and not max_stretch >= 1:
        raise ValueError(f"max_stretch is {max_stretch!r}: give an L2 stretch from 1 (none) upwards")
    if strict:
        surface = Submesh.checked_manifold(V, F)
        cleaned = as_it_is(surface)
    else:
        cleaned, surface = cleaned_surface(V, F, weld)
    as_given = surface.vertices is cleaned.origin
    given = np.asarray(F).astype(np.int64)
    if cleaned.repairs:
        listed = "; ".join(map(str, cleaned.repairs))
        warnings.warn(f"the mesh is repaired: {listed}", MeshWarning, stacklevel=stack_level())
    if not len(surface.F):
        return without_charts(cleaned, given)
    task = _Task(method_of(method), seams is None or complete, trade, holes, bijective, max_stretch)
    with reporting(progress):
        with part("seams", SEAMS_END):
            pieces = _pieces(surface, cleaned, seams, given, task)
        done = _charts(pieces, task)
        with part("packing", 1.0):
            atlas = _packed(surface, done, margin)
    atlas = replace(atlas, max_stretch=max_stretch)
    if not as_given:
        atlas = given_back(atlas, cleaned, given)
    for trouble in atlas.troubles:
        warnings.warn(trouble, OutcomeWarning, stacklevel=stack_level())
    return atlas


@dataclass(frozen=True)
class _Task:
    """How the charts are to be made: the arguments of `unwrap`, and whether more seams may be found."""

    method: Method
    may_find_seams: bool
    trade: float
    holes: bool
    bijective: bool
    max_stretch: float | None

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
            mask = sides_of_cleaned(seam_mask(seams, F, len(cleaned.merged)), cleaned)
        else:
            mask = seam_mask(seams, surface.named_faces, surface.n_given)
        pieces = surface.cut(mask)
    if not task.may_find_seams:
        return pieces
    return [part for piece in pieces for part in piece.cut_along(_seams_worth(piece, task))]


def _seams_worth(piece: Submesh, task: _Task) -> IntArray:
    """The seams that its components need, and those that their stretch is worth; of disks, too."""
    if not task.holes:
        return seams_of(piece, task.trade, disks=True, gain=DISK_GAIN)
    parts = piece.components()
    disks = [len(part.topology.loops) == 1 for part in parts]  # others keep their holes as they are
    found = [
        seams_of(part, task.trade, holes=True, disks=disk, gain=DISK_GAIN)
        for part, disk in zip(parts, disks, strict=True)
    ]
    return np.concatenate(found)


def _charts(pieces: list[Submesh], task: _Task) -> list[tuple[Chart, Submesh]]:
    """Flatten the pieces, and the parts of those that flip or overlap."""
    waiting = [(piece, 0) for piece in pieces]
    total = sum(len(piece.F) for piece in pieces)
    done: list[tuple[Chart, Submesh]] = []
    while waiting:
        piece, splits = waiting.pop(0)
        reached = total - sum(len(other.F) for other, _ in waiting)
        with part("charts", SEAMS_END + (CHARTS_END - SEAMS_END) * reached / total):
            made = _chart(piece, splits, task)
        if isinstance(made, Chart):
            done.append((made, piece))
        else:
            waiting = [(smaller, splits + 1) for smaller in made] + waiting
    return done


def _chart(piece: Submesh, splits: int, task: _Task) -> Chart | list[Submesh]:
    """The piece flattened; or its parts, where it is to be cut further."""
    result = _flattened(piece, task.method)
    if len(result.flipped) and task.may_find_seams:  # double precision does not hold the map so little cut
        if splits < task.most_splits and len(leaves := _more_leaves(piece, task)):
            return piece.cut_along(leaves)
        result = _flattened_without_flips(piece, result, task)
    check_finite(result.uv, piece.vertices, "uv")
    pairs, cost = overlapping_pairs(result.uv, piece.F), 0.0
    if len(pairs) and task.bijective and not result.holes:
        result, cost = _made_bijective(piece, result)
        pairs = overlapping_pairs(result.uv, piece.F)
    elif len(pairs) and splits < task.most_splits:
        if result.holes:  # first to a disk
            return piece.cut_along(seams_of(piece, trade=0))
        parts = piece.cut_along(seams_between([piece], piece.faces[pairs]))
        if len(parts) > 1:
            return parts
    quality = quality_of(piece, result.uv)
    if quality.stretch_l2 > task.most_stretch and (parts := _less_stretched(piece, splits, task)):
        return parts
    return Chart(piece.faces, result, quality, splits, len(pairs), cost)


def _less_stretched(piece: Submesh, splits: int, task: _Task) -> list[Submesh]:
    """The piece cut further, and from some number of cuts on halved; nothing where that cannot be."""
    if splits < MAX_LEAF_ROUNDS and len(leaves := _more_leaves(piece, task)):
        return piece.cut_along(leaves)
    return halves(piece) if splits < MAX_SPLITS_FOR_STRETCH and len(piece.F) > 1 else []


def _flattened(piece: Submesh, method: Method) -> Flattening:
    """The piece by a method of `flatten`; faces and vertices of the result are numbered for themselves."""
    start, topology = perf_counter(), piece.topology
    if topology.genus or not topology.loops:
        what = f"has {topology.genus} handles" if topology.loops else "is closed"
        which = f"the chart of faces {some(piece.faces)} {what}"
        raise MeshError(f"{which}: give more seams, or complete=True, so that they are found")
    n = len(piece.V)
    mesh = replace(planar_mesh(piece), vertices=np.arange(n), n_given=n)
    checked = perf_counter() - start
    advance("check", 0.05)
    made = method.run(mesh, None)
    return replace(made, seconds={"check": checked, **made.seconds, "total": perf_counter() - start})


def _more_leaves(piece: Submesh, task: _Task) -> IntArray:
    """Seams that open a flipping piece further, at the first of doubled trades that finds some."""
    trades = max(task.trade, 1.0) * 2.0 ** np.arange(TRADE_DOUBLINGS)
    found = (seams_of(piece, t, holes=task.holes, disks=True) for t in trades)
    return next((seams for seams in found if len(seams)), np.zeros((0, 2), dtype=np.int64))


def _flattened_without_flips(piece: Submesh, result: Flattening, task: _Task) -> Flattening:
    """The map without flipped triangles where no seam is found that would help."""
    surer = guaranteed(task.method)
    if surer is None:
        return result
    warnings.warn(
        f"no seams keep the chart of faces {some(piece.faces)} from flipping: it is flattened with "
        "guarantee='injective', to more distortion",
        FallbackWarning,
        stacklevel=stack_level(),
    )
    return _flattened(piece, surer)


def _made_bijective(piece: Submesh, result: Flattening) -> tuple[Flattening, float]:
    """The map without overlaps in one piece, and what F/3nt rose by."""
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
    most = np.sqrt(MARGINS / len(done))
    if most < margin <= 0.1:
        what = f"a margin of {margin:g} leaves no room for {len(done):,} charts: it is {most:.2g}"
        warnings.warn(what, FallbackWarning, stacklevel=stack_level())
        margin = float(most)
    placed = pack_maps([(chart.result.uv, piece.F) for chart, piece in done], margin)
    FTC, label, base = np.empty_like(surface.F), np.empty(len(surface.F), dtype=np.int64), 0
    for i, (_, piece) in enumerate(done):
        rows = np.searchsorted(surface.faces, piece.faces)
        FTC[rows], label[rows] = piece.F + base, i
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
