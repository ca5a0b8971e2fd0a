"""Build the pieces of a pattern: outlines at true scale, with seams, folds and grain arrows."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import align_columns
from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..charts import Atlas, Packing, pack_charts
from ..errors import MeshError
from ..surface import (
    NEXT,
    Polygons,
    Topology,
    Triangles,
    complex_positions,
    coordinates,
    direction_in_space,
    map_array,
    signed_double_areas,
    vertex_array,
)
from .grain_arrows import find_directions, place_arrows
from .joined_pieces import CutSurface, join_pieces
from .seam_pairs import PatternSeam, pair_seams

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8, "um": 1e-3}
DEFAULT_UNITS = "mm"  # unit of length if the file of a surface does not state a unit
PIECE_MARGIN = 0.005  # distance between a few pieces, as a share of the side of the drawing
MAX_MARGIN_COVERAGE = 0.64  # largest share of the drawing's square that margins may cover


@dataclass(frozen=True, eq=False)
class Pattern:
    """The outlines of a flattened surface at true scale, in millimetres, with y pointing up.

    Attributes
    ----------
    size : (float, float)
        Width and height of all pieces together.
    outlines : tuple of (n, 2) float64
        Closed lines with the material on their left, including the outlines of holes.
    piece : (#outlines,) int64
        Piece of each outline.
    seams : tuple of PatternSeam
    folds : (#folds, 2, 2) float64
        Edges with a crease inside a piece.
    grain : (#pieces, 2, 2) float64
        Tail and head of the arrow of each piece.
    error : float
        Largest relative change of the length of an edge.
    units : str
        Unit of length of the surface.
    """

    size: tuple[float, float]
    outlines: tuple[FloatArray, ...]
    piece: IntArray
    seams: tuple[PatternSeam, ...]
    folds: FloatArray
    grain: FloatArray
    error: float
    units: str

    @property
    def pieces(self) -> int:
        """Number of pieces."""
        return len(self.grain)

    def __str__(self) -> str:
        rows: list[tuple[str, ...]] = [("seam", "pieces", "mm", "mm", "on the surface", "change")]
        for seam in self.seams:
            pieces = "{} {}".format(*seam.pieces)
            lengths = [f"{length:.2f}" for length in (*seam.lengths, seam.length)]
            rows.append((str(seam.number), pieces, *lengths, f"{round(seam.change, 4) + 0.0:+.2%}"))
        width, height = self.size
        pieces = f"{self.pieces} piece{'s' * (self.pieces != 1)}"
        summary = f"{pieces}, {width:.1f} x {height:.1f} mm, {len(self.folds)} fold edges"
        change = f"edges change by {self.error:.2%} at most"
        return f"{align_columns(rows)}\n{summary}; {change}; the surface is in {self.units}"


def build_pattern(
    V: ArrayLike,
    F: ArrayLike,
    atlas: Atlas | ArrayLike,
    units: str | None,
    crease: float,
    grain: ArrayLike,
    up: ArrayLike | None = None,
) -> Pattern:
    """Build the pattern of a surface. The arguments are as in `write_pattern`."""
    units = units or DEFAULT_UNITS
    if units not in MILLIMETRES:
        raise ValueError(f"units is {units!r}: use one of {', '.join(MILLIMETRES)}")
    upwards = None if up is None else direction_in_space(up, "up")
    cut, arrows = lay_out(V, F, atlas, MILLIMETRES[units], direction_in_space(grain, "grain"), upwards)
    topology, piece = cut.topology, cut.piece
    loops = topology.loops
    length, flat_length = (
        np.linalg.norm(points[topology.edges[:, 0]] - points[topology.edges[:, 1]], axis=1)
        for points in (cut.surface, cut.flat)
    )
    return Pattern(
        size=(float(cut.flat[:, 0].max()), float(cut.flat[:, 1].max())),
        outlines=tuple(cut.flat[loop] for loop in loops),
        piece=np.array([piece[loop[0]] for loop in loops], dtype=np.int64),
        seams=pair_seams(cut.surface, cut.flat, loops, piece),
        folds=cut.flat[_find_creases(cut.surface, topology, cut.inner, crease)],
        grain=place_arrows(cut, loops, piece, arrows),
        error=float(np.max(np.abs(flat_length / np.maximum(length, np.finfo(float).tiny) - 1), initial=0)),
        units=units,
    )


def lay_out(
    V: ArrayLike,
    F: ArrayLike,
    atlas: Atlas | ArrayLike,
    unit: float,
    grain: FloatArray,
    up: FloatArray | None = None,
) -> tuple[CutSurface, ComplexArray]:
    """Join, rotate and arrange the pieces; also return the direction of the grain on each piece."""
    cut = _build_cut_surface(V, F, atlas, unit)
    if isinstance(atlas, Atlas):
        cut = join_pieces(cut, atlas.report.given_seams)
    pointing = find_directions(cut, grain)
    turn = pointing.upright_turn if up is None else 1j * find_directions(cut, up).towards.conj()
    return _rotate_and_pack(cut, turn), pointing.towards * turn


def _build_cut_surface(V: ArrayLike, F: ArrayLike, atlas: Atlas | ArrayLike, unit: float) -> CutSurface:
    """Return the surface and its map in millimetres; `unit` is the length of V's unit in millimetres."""
    points = vertex_array(V)
    split: Triangles | None
    if isinstance(atlas, Atlas):
        TC, FTC, origin, split = atlas.flat, atlas.triangles, atlas.origin, atlas.report.split
        if origin.max() >= len(points):
            raise MeshError(
                f"the atlas refers to vertex {origin.max()} of {len(points)}: pass the unwrapped V and F"
            )
    else:
        split, origin = Polygons.of(F).split(points), np.arange(len(points))
        TC, FTC = map_array(atlas, len(points)), split.F
    solid = (FTC[:, NEXT] != FTC).all(axis=1)
    used, corner = np.unique(FTC[solid], return_inverse=True)
    faces = corner.reshape(-1, 3)
    surface, flat = points[origin[used]] * unit, TC[used]
    if not np.isfinite(flat).all():
        raise MeshError("coordinates in uv are NaN or infinite: pass a map of all faces")
    a, b, c = surface[faces.T]
    on_surface = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    if not np.isfinite(on_surface):
        raise MeshError(f"the surface has an area of {on_surface} square millimetres: scale V")
    area = signed_double_areas(complex_positions(flat), faces.T)
    if not np.abs(area).sum() > 0:
        raise MeshError("uv has no area: pass the map of V and F")
    if (
        isinstance(atlas, Atlas) and atlas.report.repairs
    ):  # restore the given orientation of faces that `unwrap` reversed
        faces = np.where(area[:, None] < 0, faces[:, [0, 2, 1]], faces)
    flat = flat * np.sqrt(on_surface / np.abs(area).sum())
    return CutSurface(surface, flat, faces, used, origin[used], None if split is None else split.inner[solid])


def _rotate_and_pack(cut: CutSurface, turn: ComplexArray) -> CutSurface:
    """Rotate the pieces, and place them side by side, with the lower left corner of the layout at 0."""
    z, piece = complex_positions(cut.flat) * turn[cut.piece], cut.piece
    flat, of = coordinates(z), piece[cut.F[:, 0]]
    number, local = len(turn), np.empty(len(piece), dtype=np.int64)
    rows = [np.flatnonzero(piece == i) for i in range(number)]
    for own in rows:
        local[own] = np.arange(len(own))
    charts = [(flat[own], local[cut.F[of == i]]) for i, own in enumerate(rows)]
    margin = min(PIECE_MARGIN, np.sqrt(MAX_MARGIN_COVERAGE / number))
    made = flat.copy()
    for own, placed in zip(rows, pack_charts(charts, Packing(margin=margin), rotate=False), strict=True):
        made[own] = placed.uv / abs(placed.ratio)
    return replace(cut, flat=made - made.min(axis=0))


def _find_creases(
    surface: FloatArray, topology: Topology, inner: BoolArray | None, crease: float
) -> IntArray:
    """Return the edges inside pieces with a dihedral angle of at least `crease` degrees, except diagonals."""
    first, second = topology.sides
    inside = np.flatnonzero(second >= 0)
    if inner is not None:
        half = inner[:, NEXT].T.ravel()
        inside = inside[~(half[first[inside]] & half[second[inside]])]
    F = topology.corner.T
    a, b, c = surface[F.T]
    normal = np.cross(b - a, c - a)
    m = len(F)
    one, other = normal[first[inside] % m], normal[second[inside] % m]
    angle = np.arctan2(np.linalg.norm(np.cross(one, other), axis=1), (one * other).sum(axis=1))
    return np.asarray(topology.edges[inside[angle >= np.deg2rad(crease)]])
