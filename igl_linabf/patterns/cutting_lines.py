"""Build the lines along which the pieces are cut: the outlines, with glue tabs or a seam allowance."""

from __future__ import annotations

import numpy as np
import shapely

from .._types import FloatArray, IntArray
from ..surface import normalize_vectors
from .joined_pieces import CutSurface, group_rows
from .seam_pairs import OutlineSides, SeamSides
from .tabs import TabPlace

MITRE_LIMIT = 4.0  # maximum length of a sharp corner of the cutting line, relative to the allowance
RAY_START = 1e-6  # distance of the start of a ray from its seam, relative to the length of the ray


def build_piece_shapes(cut: CutSurface) -> list[shapely.Geometry]:
    """Return the region that each piece covers."""
    triangles = shapely.polygons(cut.flat[cut.F])
    return [shapely.unary_union(triangles[rows]) for rows in group_rows(cut.piece[cut.F[:, 0]])]


def trace_outlines(
    loops: tuple[IntArray, ...], sides: OutlineSides, flat: FloatArray, tabs: list[TabPlace]
) -> list[FloatArray]:
    """Return the outlines of the pieces together with their tabs."""
    at_start = {int(place.run[0]): place for place in tabs}
    within = np.zeros(len(sides.start), dtype=bool)
    for place in tabs:
        within[place.run[1:]] = True
    lines, first = [], 0
    for loop in loops:
        # start at a side that is not in the middle of a tab
        side = first + int(np.argmin(within[first : first + len(loop)]))
        first += len(loop)
        points, left = list[FloatArray](), len(loop)
        while left > 0:
            tab = at_start.get(side)
            points.append(flat[sides.start[side]][None])
            if tab is not None:
                points.append(tab.top)
                side = int(tab.run[-1])
            left -= 1 if tab is None else len(tab.run)
            side = int(sides.after[side])
        lines.append(np.concatenate(points))
    return lines


def triangulate_tabs(
    tabs: list[TabPlace], sides: OutlineSides, cut: CutSurface
) -> tuple[FloatArray, IntArray]:
    """Return triangles (n, 3, 2) that cover the tabs, and the piece of each triangle."""
    fans, piece = [np.empty((0, 3, 2))], list[int]()
    for tab in tabs:
        base = sides.get_vertices_along(tab.run)
        ring = np.concatenate((tab.top, cut.flat[base[::-1]]))
        fans.append(np.stack((np.broadcast_to(ring[0], ring[2:].shape), ring[1:-1], ring[2:]), axis=1))
        piece += [int(cut.piece[base[0]])] * (len(ring) - 2)
    return np.concatenate(fans), np.array(piece, dtype=np.int64)


def grow_shapes(shapes: list[shapely.Geometry], allowance: float) -> list[shapely.Geometry]:
    """Return the shapes of the pieces with an allowance along their outlines, including holes."""
    grown = shapely.buffer(shapes, allowance, join_style="mitre", mitre_limit=MITRE_LIMIT)
    return list(shapely.orient_polygons(grown))


def trace_shapes(shapes: list[shapely.Geometry]) -> tuple[list[FloatArray], IntArray]:
    """Return the closed lines around shapes, with the shapes on their left, and the shape of each line."""
    parts, of_part = shapely.get_parts(shapes, return_index=True)
    rings, of_ring = shapely.get_rings(parts, return_index=True)
    return [shapely.get_coordinates(ring)[:-1] for ring in rings], of_part[of_ring]


def triangulate_shapes(shapes: list[shapely.Geometry]) -> tuple[FloatArray, IntArray]:
    """Return triangles (n, 3, 2) that cover shapes, and the shape of each triangle."""
    parts, of = shapely.get_parts(shapely.constrained_delaunay_triangles(shapes), return_index=True)
    return shapely.get_coordinates(shapely.orient_polygons(parts)).reshape(-1, 4, 2)[:, :3], of


def find_narrow_seams(
    seams: tuple[SeamSides, ...],
    sides: OutlineSides,
    cut: CutSurface,
    shapes: list[shapely.Geometry],
    gap: float,
) -> tuple[int, ...]:
    """Return the numbers of the seams that are closer than `gap` to another part of their piece."""
    narrow = list[int]()
    for number, seam in enumerate(seams, 1):
        for run in seam.runs:
            side = run[len(run) // 2]
            tail, head = cut.flat[sides.start[side]], cut.flat[sides.end[side]]
            along = normalize_vectors(head - tail)
            outward = np.array([along[1], -along[0]]) * gap
            ray = (tail + head) / 2 + np.outer([RAY_START, 1], outward)
            shape = shapes[int(cut.piece[sides.start[side]])]
            if shapely.intersects(shape, shapely.linestrings(ray)):
                narrow.append(number)
                break
    return tuple(narrow)


def count_closed_holes(shapes: list[shapely.Geometry], allowance: float) -> int:
    """Return the number of holes that are covered by the allowance along their outlines."""
    rings = [ring for shape in shapes for part in shapely.get_parts(shape) for ring in part.interiors]
    holes = shapely.polygons(rings) if rings else np.array([])
    left = shapely.buffer(holes, -allowance, join_style="mitre", mitre_limit=MITRE_LIMIT)
    return int(shapely.is_empty(left).sum())
