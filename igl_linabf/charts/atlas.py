"""Any surface as an atlas: cut, flattened chart by chart, without overlaps, packed."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import Progress, aligned, part, reporting
from ..errors import FallbackWarning, MeshError, OutcomeWarning, some, stack_level
from ..flattening import Flattening, Method, Outcome, flatten, guaranteed, method_of
from ..measures import Quality, overlaps, quality
from ..measures import charts as components
from ..surface import (
    FloatArray,
    IntArray,
    check_finite,
    compact,
    complex_positions,
    face_array,
    flipped_faces,
    measure,
    signed_double_areas,
    topology_of,
    vertex_array,
)
from .overlap_seams import separating_seams
from .packing import pack
from .scaf import moved_apart
from .seams import TRADE, cut, find_seams, texture_seams

SEAMS, PACKING = 0.3, 0.95  # of the progress told: when seams are found, when packing begins
ROUNDS = 8  # of splitting what overlaps and flattening the parts anew
DOUBLINGS = 12  # of the trade, until a chart that flips is cut further


@dataclass(frozen=True, eq=False)
class Chart:
    """One chart of an atlas.

    Attributes
    ----------
    faces : (#f,) int64
        Its faces, as rows of the surface's F.
    result : Flattening
        How it was flattened, before it was packed; its vertices are numbered for itself.
    quality : Quality
    splits : int
        How many times a chart was split for overlaps before this one was whole.
    overlapping : int
        Pairs of its faces that overlap still.
    cost : float
        What F/3nt rose by to be bijective in one piece; 0 where that was not needed or asked for.
    """

    faces: IntArray
    result: Flattening
    quality: Quality
    splits: int
    overlapping: int
    cost: float


@dataclass(frozen=True, eq=False)
class Atlas:
    """A surface's texture coordinates, as `igl.writeOBJ` takes them.

    Attributes
    ----------
    TC : (#TC, 2) float64
        Texture coordinates in the unit square.
    FTC : (#F, 3) int64
        Their rows at the corners of the faces.
    origin : (#TC,) int64
        The vertex that each is of.
    chart : (#F,) int64
        The chart of each face.
    charts : tuple of Chart
    seams : (#E, 2) int64
        The edges that were cut.
    seam_length : float
        Their length.
    splits : int
        How many charts were split because they lay over themselves.
    fill : float
        Share of the unit square that the charts cover.
    quality : Quality
        Of the whole: angles of all corners, stretch at the charts' common scale.
    """

    TC: FloatArray
    FTC: IntArray
    origin: IntArray
    chart: IntArray
    charts: tuple[Chart, ...]
    seams: IntArray
    seam_length: float
    splits: int
    fill: float
    quality: Quality

    @property
    def good(self) -> bool:
        """Whether no face is flipped and no chart overlaps itself."""
        return not self.troubles

    @property
    def troubles(self) -> list[str]:
        """A sentence on each chart with flipped or overlapping faces."""
        said = []
        for i, chart in enumerate(self.charts):
            where = f"chart {i} (faces {some(chart.faces)})"
            if not chart.result.outcome.good:
                flipped = some(chart.faces[chart.result.flipped])
                said.append(f"{where} has flipped faces, {flipped}: give more seams there, or a larger trade")
            elif chart.overlapping:
                pairs = f"{chart.overlapping} pair{'s' * (chart.overlapping > 1)} of faces"
                said.append(f"{where} lies over itself in {pairs}: give more seams there")
        return said

    def __str__(self) -> str:
        rows = [("chart", "faces", "F/3nt", "L2 stretch", "flips", "overlaps", "holes", "outcome")]
        for i, chart in enumerate(self.charts):
            q, result = chart.quality, chart.result
            rows.append(
                (
                    str(i),
                    f"{len(chart.faces):,}",
                    f"{q.angle_distortion:.4g}",
                    f"{q.stretch_l2:.4g}",
                    str(q.flips),
                    str(chart.overlapping),
                    str(len(result.holes)),
                    result.outcome.value,
                )
            )
        q = self.quality
        overlapping = str(sum(chart.overlapping for chart in self.charts))
        whole = (f"{q.angle_distortion:.4g}", f"{q.stretch_l2:.4g}", str(q.flips), overlapping)
        rows.append(("all", f"{len(self.FTC):,}", *whole, "", ""))
        splits = f"{self.splits} split{'s' * (self.splits != 1)} for overlaps"
        seams = f"{len(self.seams):,} seam edges, {self.seam_length:.4g} long"
        return f"{aligned(rows)}\n{seams}; {splits}; {self.fill:.0%} of the square filled"


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
        Where to cut, as `cut` takes them; by default what `find_seams` finds, and more of it where
        a chart comes out with flipped faces, and `guarantee="injective"` where none helps.
    method : str or method object
        As in `flatten`.
    trade : float
        Of `find_seams`: seam length against distortion.
    holes : bool
        Leave holes uncut, where `seams` are to be found.
    bijective : bool
        Do not split a chart that lies over itself: `make_bijective` moves its parts from each
        other, at the price in F/3nt that the chart's `cost` says. Charts with holes are split.
    margin : float
        Between charts, and at the border, as a share of the unit square's side.
    progress : callable or False, optional
        As in `flatten`.

    Returns
    -------
    Atlas

    Raises
    ------
    MeshError
        The surface is no oriented manifold, a face is degenerate, a seam is no edge, or given
        seams leave a chart with handles or without a boundary.

    Warns
    -----
    OutcomeWarning
        A chart has flipped faces, or lies over itself still.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> atlas = unwrap(V, F)
    >>> len(atlas.charts), atlas.good, atlas.FTC.shape
    (1, True, (20, 3))
    """
    positions, faces = vertex_array(V), face_array(F)
    vertices, packed = compact(faces, len(positions))
    check_finite(positions[vertices], vertices)
    measure(positions[vertices], packed.T, vertices)
    grow = seams is None
    with reporting(progress):
        if seams is None:
            with part("seams", SEAMS):
                seams = find_seams(positions, faces, trade=trade, holes=holes)
        waiting = _pieces(positions, faces, np.arange(len(faces)), np.arange(len(positions)), seams, 0)
        done, pieces = _charts(
            list(waiting), method_of(method), trade=trade, grow=grow, holes=holes, bijective=bijective
        )
        with part("packing", 1.0):
            atlas = _packed(positions, faces, done, pieces, margin)
    for trouble in atlas.troubles:
        warnings.warn(trouble, OutcomeWarning, stacklevel=stack_level())
    return atlas


@dataclass(frozen=True, eq=False)
class _Piece:
    """A part of the surface on its way to a chart: its faces in F, its own arrays, vertices in V."""

    faces: IntArray
    V: FloatArray
    F: IntArray
    origin: IntArray
    splits: int


def _pieces(
    V: FloatArray, F: IntArray, faces: IntArray, origin: IntArray, seams: ArrayLike, splits: int
) -> Iterator[_Piece]:
    """The components that are left after a cut."""
    V, F, index = cut(V, F, seams)
    origin = origin[index]
    label = components(F, len(V))
    order = np.argsort(label, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(label[order])) + 1):
        vertices, own = compact(F[rows], len(V))
        yield _Piece(faces[rows], V[vertices], own, origin[vertices], splits)


def _parts(piece: _Piece, seams: IntArray) -> Iterator[_Piece]:
    """The piece cut further."""
    return _pieces(piece.V, piece.F, piece.faces, piece.origin, seams, piece.splits + 1)


def _charts(
    waiting: list[_Piece],
    method: Method,
    *,
    trade: float,
    grow: bool,
    holes: bool,
    bijective: bool,
) -> tuple[list[Chart], list[_Piece]]:
    """Flatten the pieces, and the parts of those that flip or overlap."""
    total = sum(len(piece.faces) for piece in waiting)
    done: list[Chart] = []
    pieces: list[_Piece] = []
    while waiting:
        piece = waiting.pop(0)
        reached = total - sum(len(other.faces) for other in waiting)
        with part("charts", SEAMS + (PACKING - SEAMS) * reached / total):
            result = _flatten(piece, method)
            if len(result.flipped) and grow:  # double precision does not hold the map so little cut
                if piece.splits < ROUNDS and len(opened := _leaves(piece, trade, holes)):
                    waiting = [*_parts(piece, opened), *waiting]
                    continue
                result = _forced(piece, result, method)
            pairs, cost = overlaps(result.uv, piece.F), 0.0
            if len(pairs) and bijective and not result.holes:
                result, cost = _apart(piece, result)
                pairs = overlaps(result.uv, piece.F)
            elif len(pairs) and piece.splits < ROUNDS:
                parts = list(_split(piece, pairs, bool(result.holes)))
                if len(parts) > 1 or result.holes:
                    waiting = [*parts, *waiting]
                    continue
            measured = quality(piece.V, piece.F, result.uv)
            done.append(Chart(piece.faces, result, measured, piece.splits, len(pairs), cost))
            pieces.append(piece)
    return done, pieces


def _flatten(piece: _Piece, method: Method) -> Flattening:
    where = f"the chart of faces {some(piece.faces)}"
    topology = topology_of(piece.F, piece.origin)
    loops = len(topology.loops)
    genus = (2 - loops - (topology.n - len(topology.edges) + len(piece.F))) // 2
    if not loops:
        raise MeshError(f"{where} is closed: give more seams, or none, so that they are found")
    if genus:
        raise MeshError(f"{where} has {genus} handles: give more seams, or none, so that they are found")
    return flatten(piece.V, piece.F, method)


def _leaves(piece: _Piece, trade: float, holes: bool) -> IntArray:
    """Seams that open a flipping piece further, at the first of doubled trades that finds some."""
    trades = max(trade, 1.0) * 2.0 ** np.arange(DOUBLINGS)
    found = (find_seams(piece.V, piece.F, trade=t, holes=holes, disks=True) for t in trades)
    return next((seams for seams in found if len(seams)), np.zeros((0, 2), dtype=np.int64))


def _forced(piece: _Piece, result: Flattening, method: Method) -> Flattening:
    """The map without flipped triangles where no seam is found that would help."""
    surer = guaranteed(method)
    if surer is None:
        return result
    warnings.warn(
        f"no seams keep the chart of faces {some(piece.faces)} from flipping: it is flattened with "
        "guarantee='injective', to more distortion",
        FallbackWarning,
        stacklevel=stack_level(),
    )
    return _flatten(piece, surer)


def _split(piece: _Piece, pairs: IntArray, holes: bool) -> Iterator[_Piece]:
    """The piece cut where that takes its overlapping parts from each other; to a disk, first."""
    seams = find_seams(piece.V, piece.F, trade=0) if holes else separating_seams(piece.V, piece.F, pairs)
    return _parts(piece, seams)


def _apart(piece: _Piece, result: Flattening) -> tuple[Flattening, float]:
    """The map without overlaps in one piece, and what F/3nt rose by."""
    uv, _ = moved_apart(result.uv, piece.F)  # what is wrong is told of the atlas
    areas = [np.abs(signed_double_areas(complex_positions(m), piece.F.T)).sum() for m in (result.uv, uv)]
    uv *= np.sqrt(areas[0] / areas[1])
    flipped = flipped_faces(complex_positions(uv), piece.F.T)
    before, after = (quality(piece.V, piece.F, m).angle_distortion for m in (result.uv, uv))
    outcome = Outcome.FLIPPED if len(flipped) else result.outcome
    message = f"{result.message}; moved apart to be bijective: F/3nt {before:.4g} -> {after:.4g}"
    return replace(result, uv=uv, flipped=flipped, outcome=outcome, message=message), after - before


def _packed(V: FloatArray, F: IntArray, done: list[Chart], pieces: list[_Piece], margin: float) -> Atlas:
    placed = pack(
        [(chart.result.uv, piece.F) for chart, piece in zip(done, pieces, strict=True)], margin=margin
    )
    FTC, label, base = np.empty_like(F), np.empty(len(F), dtype=np.int64), 0
    for i, piece in enumerate(pieces):
        FTC[piece.faces], label[piece.faces] = piece.F + base, i
        base += len(piece.V)
    TC, origin = np.concatenate([p.uv for p in placed]), np.concatenate([piece.origin for piece in pieces])
    seams = texture_seams(F, FTC)
    return Atlas(
        TC=TC,
        FTC=FTC,
        origin=origin,
        chart=label,
        charts=tuple(done),
        seams=seams,
        seam_length=float(np.linalg.norm(V[seams[:, 0]] - V[seams[:, 1]], axis=1).sum()),
        splits=len(done) - len(set(components(F, len(V)).tolist())),
        fill=sum(p.area for p in placed),
        quality=quality(V[origin], FTC, TC),
    )
