"""Place glue tabs along one side of each seam, where they do not overlap a piece or another tab."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from .._types import FloatArray, IntArray
from .joined_pieces import CutSurface
from .seam_pairs import OutlineSides, SeamSides

Geometries = NDArray[np.object_]
DEPTHS = (1.0, 0.75, 0.5, 0.35, 0.25)  # depths of tabs that are tried, relative to the given width
TAPERS = (45.0, 60.0, 30.0, 20.0, 10.0)  # angles at the base that are tried for each depth, in degrees
MIN_TOP = 1 / 3  # least length of the top of a tab, relative to its base
MAX_SAGITTA = 0.1  # largest distance of a curved base from its chord, relative to the tab's width
CLEARANCE = 1e-3  # shrink tabs by this share of their width before overlap tests, because they may touch


@dataclass(frozen=True, eq=False)
class PatternTab:
    """A glue tab: a trapezoid beside one side of a seam, in millimetres.

    Attributes
    ----------
    seam : int
        Number of the seam.
    piece : int
    base : (n, 2) float64
        The part of the outline at which the tab is folded, with the material of the piece on the left.
    top : (2, 2) float64
        The free corners, from the start of the base to its end.
    angle : float
        Mean dihedral angle of the surface at the base, in degrees; positive if the tab is folded away from
        the viewer (mountain fold).
    """

    seam: int
    piece: int
    base: FloatArray
    top: FloatArray
    angle: float

    @property
    def outline(self) -> FloatArray:
        """The corners of the tab, (n + 2, 2), counterclockwise."""
        return np.vstack((self.top, self.base[::-1]))


@dataclass(frozen=True, eq=False)
class TabPlace:
    """A tab on the sides `run` of an outline, before the pieces are arranged.

    Attributes
    ----------
    seam : int
        Index of the seam.
    run : (n,) int64
        Consecutive sides of the outline.
    top : (2, 2) float64
        The free corners, from the start of the run to its end.
    shape : shapely.Polygon
        The tab without `CLEARANCE`.
    length : float
        Length of the base.
    """

    seam: int
    run: IntArray
    top: FloatArray
    shape: shapely.Polygon
    length: float


@dataclass(frozen=True, eq=False)
class _TabBase:
    """A straight part of a seam that may have a tab.

    Attributes
    ----------
    run : (n,) int64
        Sides with the tab.
    points, opposite : (n + 1, 2) float64
        Points along the run, and the points of the other side that they are joined with.
    piece, receiver : int
        The piece with the tab, and the piece behind the tab.
    twisted : bool
    """

    run: IntArray
    points: FloatArray
    opposite: FloatArray
    piece: int
    receiver: int
    twisted: bool


def place_tabs(
    cut: CutSurface,
    sides: OutlineSides,
    seams: tuple[SeamSides, ...],
    shapes: list[shapely.Geometry],
    folds: IntArray,
    width: float,
) -> list[TabPlace]:
    """Return tabs on one side of each seam: the side on which the tabs are longer.

    Long seams come first. Each tab is as deep as possible up to `width`, and does not stick out of the face
    behind it.

    Parameters
    ----------
    cut : CutSurface
    sides : Sides
    seams : tuple of SeamSides
    shapes : list of shapely.Geometry
        The region that each piece covers.
    folds : (#folds, 2) int64
        Fold edges, which a tab must not be glued across.
    width : float
    """
    length = sides.measure_lengths(cut.flat)
    shapely.prepare(shapes)
    lines = shapely.linestrings(cut.flat[folds])
    creases = [shapely.union_all(lines[cut.piece[folds[:, 0]] == i]) for i in range(len(shapes))]
    shapely.prepare(creases)
    placed: list[list[TabPlace]] = [[] for _ in shapes]
    for i in np.argsort([-length[seam.one].sum() for seam in seams], kind="stable").tolist():
        found = []
        for bases in _find_bases(cut, sides, seams[i], MAX_SAGITTA * width):
            tabs = list[TabPlace]()
            for base in bases:
                obstacles = [shapes[base.piece], *(tab.shape for tab in (*placed[base.piece], *tabs))]
                tabs += _fit_tab(
                    i, base, np.array(obstacles), (shapes[base.receiver], creases[base.receiver]), width
                )
            found.append(tabs)
        measures = [
            (
                round(sum(tab.length for tab in tabs) / width, 6),
                round(sum(tab.shape.area for tab in tabs) / width**2, 6),
            )
            for tabs in found
        ]
        best = int(measures[1] > measures[0])
        placed[int(cut.piece[sides.start[seams[i].runs[best][0]]])] += found[best]
    return [tab for own in placed for tab in own]


def _find_bases(
    cut: CutSurface, sides: OutlineSides, seam: SeamSides, tolerance: float
) -> tuple[list[_TabBase], list[_TabBase]]:
    """Split a seam where one of its sides, or the surface along it, turns.

    A tab across such a place could not be folded. Returns the bases of tabs on both sides of the seam.
    """
    one, other = seam.one, seam.other
    rows, opposite_rows = seam.get_vertex_paths(sides)
    here, there = cut.flat[rows], cut.flat[opposite_rows]
    pieces = [int(cut.piece[sides.start[part[0]]]) for part in (one, other)]
    step = 1 if seam.twisted else -1
    bases: tuple[list[_TabBase], list[_TabBase]] = ([], [])
    for j, k in _split_at_corners(np.hstack((cut.surface[rows], here, there)), tolerance):
        own, opposite = here[j : k + 1], there[j : k + 1]
        bases[0].append(_TabBase(one[j:k], own, opposite, pieces[0], pieces[1], seam.twisted))
        bases[1].append(
            _TabBase(other[j:k][::step], opposite[::step], own[::step], pieces[1], pieces[0], seam.twisted)
        )
    return bases


def _fit_tab(
    seam: int,
    base: _TabBase,
    obstacles: Geometries,
    receiver: tuple[shapely.Geometry, shapely.Geometry],
    width: float,
) -> list[TabPlace]:
    """Return the largest tab on a base that fits, or an empty list.

    The tab must not intersect the obstacles. `receiver` is the shape and the creases of the piece that the
    tab is glued on: the tab must lie within the shape, and must not cross a crease.
    """
    chords = [float(np.linalg.norm(points[-1] - points[0])) for points in (base.points, base.opposite)]
    depth = width * np.repeat(DEPTHS, len(TAPERS))
    inset = depth / np.tan(np.radians(np.tile(TAPERS, len(DEPTHS))))
    fits = 2 * inset <= (1 - MIN_TOP) * min(chords)
    if not fits.any():
        return []
    tops, shapes = _build_trapezoids(base.points, depth[fits], inset[fits])
    # the receiver is on the right of the opposite side, or on its left if the seam is twisted
    _, glued = _build_trapezoids(base.opposite, depth[fits] * (-1 if base.twisted else 1), inset[fits])
    tried, glued = (shapely.buffer(s, -CLEARANCE * width, join_style="mitre") for s in (shapes, glued))
    near = obstacles[shapely.intersects(shapely.box(*shapely.total_bounds(tried)), obstacles)]
    free = ~shapely.intersects(tried[:, None], near).any(axis=1)
    free &= ~shapely.is_empty(tried) & (shapely.get_num_geometries(tried) == 1)
    free &= shapely.covers(receiver[0], glued) & ~shapely.intersects(receiver[1], glued)
    if not free.any():
        return []
    best = int(np.argmax(free))
    length = float(np.linalg.norm(np.diff(base.points, axis=0), axis=1).sum())
    return [TabPlace(seam, base.run, tops[best], tried[best], length)]


def _build_trapezoids(
    base: FloatArray, depth: FloatArray, inset: FloatArray
) -> tuple[FloatArray, Geometries]:
    """Return the free corners, (n, 2, 2), and the shapes of tabs to the right of a base."""
    start, end = base[0], base[-1]
    along = (end - start) / np.linalg.norm(end - start)
    outward = np.array([along[1], -along[0]]) * depth[:, None]
    inward = inset[:, None] * along
    tops = np.stack((start + outward + inward, end + outward - inward), axis=1)
    rings = np.concatenate((np.broadcast_to(base, (len(tops), *base.shape)), tops[:, ::-1]), axis=1)
    return tops, shapely.polygons(rings)


def _split_at_corners(points: FloatArray, tolerance: float) -> list[tuple[int, int]]:
    """Split a line into nearly straight parts by the Douglas-Peucker method.

    Returns
    -------
    list of (int, int)
        Indices of the first and last point of each part, along the line.
    """
    parts, open_parts = [], [(0, len(points) - 1)]
    while open_parts:
        i, j = open_parts.pop()
        chord = points[j] - points[i]
        offset = points[i + 1 : j] - points[i]
        share = np.clip(offset @ chord / max(float(chord @ chord), np.finfo(float).tiny), 0, 1)
        distance = np.linalg.norm(offset - share[:, None] * chord, axis=1)
        if distance.max(initial=0) <= tolerance:
            parts.append((i, j))
            continue
        k = i + 1 + int(np.argmax(distance))
        open_parts += [(k, j), (i, k)]
    return parts
