"""Place the pieces of a pattern: join, turn and enlarge them, add tabs or an allowance, and arrange them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from .._core import connected_labels
from .._types import ComplexArray, FloatArray, IntArray
from ..charts import Atlas, Packing, pack_charts
from ..errors import MeshError
from ..surface import (
    NEXT,
    Polygons,
    Triangles,
    complex_positions,
    map_array,
    real_coordinates,
    signed_double_areas,
    vertex_array,
)
from .cutting_lines import (
    build_piece_shapes,
    count_closed_holes,
    find_narrow_seams,
    grow_shapes,
    trace_outlines,
    trace_shapes,
    triangulate_shapes,
    triangulate_tabs,
)
from .folds import find_folds
from .grain_arrows import find_directions
from .joined_pieces import CutSurface, group_rows, join_pieces, measure_extents
from .options import PatternOptions
from .seam_pairs import OutlineSides, SeamSides, find_seams
from .tabs import TabPlace, place_tabs

PIECE_MARGIN = 0.005  # upper limit of the gaps between pieces, over the side of a square around the drawing
MAX_MARGIN_COVERAGE = 0.64  # maximum share of the square around the drawing that margins may cover


@dataclass(frozen=True, eq=False)
class PatternLayout:
    """The pieces of a pattern at their places, in millimetres.

    Attributes
    ----------
    cut : CutSurface
    sides : Sides
        The sides of all outlines.
    seams : tuple of SeamSides
    arrows : (#pieces,) complex128
        Direction of the grain on each piece.
    folds : ((#folds, 2) int64, (#folds,) float64)
        End vertices of the fold edges, and their angles in degrees.
    cut_lines : tuple of (n, 2) float64
        Lines along which the pieces are cut, with the material on their left.
    tabs : tuple of TabPlace
    seams_without_room : tuple of int
        Numbers of the seams without a tab, or with another part of the piece within their allowance.
    closed_holes : int
        Number of holes that the allowance covers.
    changes : (#E,) float64
        Relative change of the length of each edge, without its sign and without compensation.
    """

    cut: CutSurface
    sides: OutlineSides
    seams: tuple[SeamSides, ...]
    arrows: ComplexArray
    folds: tuple[IntArray, FloatArray]
    cut_lines: tuple[FloatArray, ...]
    tabs: tuple[TabPlace, ...]
    seams_without_room: tuple[int, ...]
    closed_holes: int
    changes: FloatArray


def lay_out(V: ArrayLike, F: ArrayLike, atlas: Atlas | ArrayLike, options: PatternOptions) -> PatternLayout:
    """Join, turn, enlarge, finish and arrange the pieces of a pattern."""
    cut, changes, arrows = _turn_pieces(V, F, atlas, options)
    options.check_widths(float(measure_extents(complex_positions(cut.flat), cut.piece).max()))
    loops, piece = cut.topology.loops, cut.piece
    sides = OutlineSides.from_loops(loops)
    seams, folds = find_seams(sides, cut.surface, piece), find_folds(cut, options.crease)
    tabs, without_room, closed = list[TabPlace](), tuple[int, ...](), 0
    if options.allowance:
        shapes = build_piece_shapes(cut)
        grown = grow_shapes(shapes, options.allowance)
        lines, of = trace_shapes(grown)
        triangles, of_triangle = triangulate_shapes(grown)
        without_room = find_narrow_seams(seams, sides, cut, shapes, 2 * options.allowance)
        closed = count_closed_holes(shapes, options.allowance)
    else:
        if options.tabs:
            tabs = place_tabs(cut, sides, seams, build_piece_shapes(cut), folds[0], options.tabs)
            having = {tab.seam for tab in tabs}
            without_room = tuple(i + 1 for i in range(len(seams)) if i not in having)
        lines = trace_outlines(loops, sides, cut.flat, tabs)
        of = np.array([piece[loop[0]] for loop in loops], dtype=np.int64)
        extra, of_extra = triangulate_tabs(tabs, sides, cut)
        triangles = np.concatenate((cut.flat[cut.F], extra))
        of_triangle = np.append(piece[cut.F[:, 0]], of_extra)
    shift = _arrange_pieces(triangles, of_triangle)
    return PatternLayout(
        replace(cut, flat=cut.flat + shift[piece]),
        sides,
        seams,
        arrows,
        folds,
        tuple(line + shift[i] for line, i in zip(lines, of.tolist(), strict=True)),
        tuple(replace(tab, top=tab.top + shift[piece[sides.start[tab.run[0]]]]) for tab in tabs),
        without_room,
        closed,
        changes,
    )


def _turn_pieces(
    V: ArrayLike, F: ArrayLike, atlas: Atlas | ArrayLike, options: PatternOptions
) -> tuple[CutSurface, FloatArray, ComplexArray]:
    """Join, turn and enlarge the pieces.

    Returns
    -------
    cut : CutSurface
    changes : (#E,) float64
        Relative change of the length of each edge, without its sign, before the pieces are enlarged.
    arrows : (#pieces,) complex128
        Direction of the grain on each piece.
    """
    cut = _build_cut_surface(V, F, atlas, options.unit_in_mm)
    if isinstance(atlas, Atlas):
        cut = join_pieces(cut, atlas.report.given_seams)
    pointing = find_directions(cut, options.grain)
    turn = pointing.upright_turn
    if options.up is not None:
        turn = 1j * find_directions(cut, options.up).towards.conj()
    edges = cut.topology.edges
    length, flat_length = (
        np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
        for points in (cut.surface, cut.flat)
    )
    changes = np.abs(flat_length / np.maximum(length, np.finfo(float).tiny) - 1)
    across, along = options.compensation
    local = complex_positions(cut.flat) * pointing.towards.conj()[cut.piece]
    arrows = pointing.towards * turn
    z = (along * local.real + across * local.imag * 1j) * arrows[cut.piece]
    return replace(cut, flat=real_coordinates(z)), changes, arrows


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
        split, origin = Polygons.from_faces(F).triangulate(points), np.arange(len(points))
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
    whole = np.abs(area).sum()
    if not whole > 0:
        raise MeshError("uv has no area: pass the map of V and F")
    inner = None if split is None else split.inner[solid]
    if not (isinstance(atlas, Atlas) and atlas.report.repairs):
        # reverse whole pieces that are mirrored in the map, to draw them as seen from the other side
        piece = connected_labels(faces[:, [0, 1, 1, 2]].reshape(-1, 2), len(flat))[faces[:, 0]]
        area = np.asarray(np.bincount(piece, area)[piece])
    # if `unwrap` has repaired the surface, reverse only the faces that it has reversed
    mirrored = area[:, None] < 0
    faces = np.where(mirrored, faces[:, [0, 2, 1]], faces)
    if inner is not None:
        inner = np.where(mirrored, inner[:, ::-1], inner)
    flat = flat * np.sqrt(on_surface / whole)
    return CutSurface(surface, flat, faces, used, origin[used], inner)


def _arrange_pieces(triangles: FloatArray, of: IntArray) -> FloatArray:
    """Return the translation of each piece, (#pieces, 2), that places the pieces side by side.

    `triangles` (n, 3, 2) cover the pieces, and `of` is the piece of each triangle. The lower left corner of
    the layout is at the origin.
    """
    charts = []
    for rows in group_rows(of):
        points, corner = np.unique(triangles[rows].reshape(-1, 2), axis=0, return_inverse=True)
        charts.append((points, corner.reshape(-1, 3)))
    margin = min(PIECE_MARGIN, np.sqrt(MAX_MARGIN_COVERAGE / len(charts)))
    placed = pack_charts(charts, Packing(margin=margin), rotate=False)
    corners = [points.min(axis=0) for points, _ in charts]
    at = np.array([chart.uv.min(axis=0) / abs(chart.ratio) for chart in placed])
    return np.asarray(at - at.min(axis=0) - corners)
