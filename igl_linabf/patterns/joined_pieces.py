"""Reduce the number of pieces: join pieces that fit along a seam, and close seams whose sides coincide."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .._core import merge_regions, min_rectangle_rotations
from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..charts import compute_overlap_depths
from ..surface import Ragged, Topology, build_topology, complex_positions, connected_labels, real_coordinates
from .seam_pairs import OutlineSides, find_partners

FIT_TOLERANCE = 1e-5  # maximum gap between sides that coincide, relative to the extent of their pieces
MIN_HINGE_LENGTH = 0.2  # minimum length of a joint of two pieces, relative to the width of the narrower piece
MAX_HINGES = 8  # maximum number of sides of a seam that are tried as joints, longest first


@dataclass(frozen=True, eq=False)
class CutSurface:
    """A surface cut along its seams, and its map, both in millimetres and without collapsed faces.

    Attributes
    ----------
    surface, flat : (#v, 3) and (#v, 2) float64
    F : (#f, 3) int64
    vertices : (#v,) int64
        Rows of the given map.
    origin : (#v,) int64
        Vertices of the given surface.
    inner : (#f, 3) bool, or None
        Whether the side from corner k to k + 1 is a diagonal of a polygon; None for a triangle mesh.
    """

    surface: FloatArray
    flat: FloatArray
    F: IntArray
    vertices: IntArray
    origin: IntArray
    inner: BoolArray | None

    @cached_property
    def topology(self) -> Topology:
        """The topology of the cut surface: its edges and boundary loops."""
        return build_topology(self.F, self.vertices)

    @cached_property
    def piece(self) -> IntArray:
        """The index of the piece of each vertex."""
        ends = self.F[:, [0, 1, 1, 2]].reshape(-1, 2)
        return np.asarray(np.unique(connected_labels(ends, len(self.flat)), return_inverse=True)[1])


def join_pieces(cut: CutSurface, kept: IntArray) -> CutSurface:
    """Join pieces that fit along a seam without overlaps, and close seams whose sides coincide in the map.

    As a consequence, a hole in a plate stays a hole. The edges `kept` (#G, 2), given by vertices of the
    original surface, remain seams.
    """
    if not cut.topology.loops:
        return cut
    rim, partner, joinable = _find_sides(cut, kept)
    return _close_seams(_assemble_pieces(cut, rim, partner, joinable), rim, partner, joinable)


def _find_sides(cut: CutSurface, kept: IntArray) -> tuple[OutlineSides, IntArray, BoolArray]:
    """Return the sides of all outlines, their partners across seams, and a mask of the joinable sides."""
    rim = OutlineSides.from_loops(cut.topology.loops)
    partner, twisted = find_partners(rim, cut.surface, cut.piece)
    n = int(cut.origin.max()) + 1
    ends = np.sort(np.column_stack((cut.origin[rim.start], cut.origin[rim.end])), axis=1)
    asked = np.isin(ends @ [n, 1], np.sort(kept[(kept < n).all(axis=1)], axis=1) @ [n, 1])
    return rim, partner, (partner >= 0) & ~twisted & ~asked


def _assemble_pieces(
    cut: CutSurface, rim: OutlineSides, partner: IntArray, joinable: BoolArray
) -> CutSurface:
    """Join the pieces of the map along common seams, longest first."""
    piece = cut.piece
    one = np.flatnonzero(joinable)
    one = one[piece[rim.start[one]] < piece[rim.start[partner[one]]]]
    if not len(one):
        return cut
    z, of = complex_positions(cut.flat), piece[cut.F[:, 0]]
    order = np.argsort(of, kind="stable")
    faces = Ragged(np.searchsorted(of[order], np.arange(int(of.max()) + 2)))
    extent = measure_extents(z, piece)
    other = partner[one]
    here, there = (
        z[np.stack(ends)] for ends in ((rim.start[one], rim.end[one]), (rim.end[other], rim.start[other]))
    )
    pairs = np.column_stack((piece[rim.start[one]], piece[rim.start[other]]))
    hinges = _find_hinges(here, there, pairs, extent, [z[rows] for rows in group_rows(piece)])
    if not len(hinges.pairs):
        return cut
    triangles = z[cut.F[order]]
    much = np.full(len(hinges.pairs), np.inf)
    _, turn, shift = merge_regions(
        triangles, compute_overlap_depths(triangles, extent[of[order]], FIT_TOLERANCE), faces.start,
        hinges.pairs, hinges.turn, hinges.shift, much, np.ones(len(much)),
    )  # fmt: skip
    return replace(cut, flat=real_coordinates(turn[piece] * z + shift[piece]))


@dataclass(frozen=True, eq=False)
class _Hinges:
    """Places where two pieces may be joined, longest first.

    Attributes
    ----------
    pairs : (#h, 2) int64
    turn, shift : (#h,) complex128
        The rotation and translation that move the second piece to the first.
    """

    pairs: IntArray
    turn: ComplexArray
    shift: ComplexArray


def _find_hinges(
    here: ComplexArray, there: ComplexArray, pairs: IntArray, extent: FloatArray, places: list[ComplexArray]
) -> _Hinges:
    """Find where pairs of pieces may be joined, given the ends (2, #s) of common sides in both pieces."""
    turn = (here[1] - here[0]) * (there[1] - there[0]).conj()
    turn /= np.maximum(np.abs(turn), np.finfo(float).tiny)
    shift = here.mean(axis=0) - turn * there.mean(axis=0)
    length = np.abs(here[1] - here[0])
    found = []
    order = np.lexsort((-length, *pairs.T[::-1]))
    first = np.flatnonzero(np.append(True, np.diff(pairs[order], axis=0).any(axis=1)))
    for rows in np.split(order, first[1:]):
        a, b = pairs[rows[0]].tolist()
        tried = rows[:MAX_HINGES]
        missed = np.abs(turn[tried, None, None] * there[:, rows] + shift[tried, None, None] - here[:, rows])
        total = (length[rows] * (missed <= FIT_TOLERANCE * max(extent[a], extent[b])).all(axis=1)).sum(axis=1)
        along = [
            np.ptp((places[i][:, None] * side.conj()).real, axis=0)
            for i, side in (
                (a, (here[1] - here[0])[tried] / length[tried]),
                (b, (there[1] - there[0])[tried] / length[tried]),
            )
        ]
        long_enough = total >= MIN_HINGE_LENGTH * np.minimum(*along)
        found += [(-float(total[k]), int(tried[k])) for k in np.flatnonzero(long_enough).tolist()]
    best = np.array([row for _, row in sorted(found)], dtype=np.int64)
    return _Hinges(pairs[best], turn[best], shift[best])


def _close_seams(cut: CutSurface, rim: OutlineSides, partner: IntArray, joinable: BoolArray) -> CutSurface:
    """Close the seams whose two sides coincide in the map."""
    z, one = complex_positions(cut.flat), np.flatnonzero(joinable)
    other, extent = partner[one], measure_extents(z, cut.piece)[cut.piece[rim.start[one]]]
    ends = np.stack((rim.start[one], rim.end[one])), np.stack((rim.end[other], rim.start[other]))
    met = (np.abs(z[ends[0]] - z[ends[1]]) <= FIT_TOLERANCE * extent).all(axis=0)
    if not met.any():
        return cut
    same = np.column_stack([rows[:, met].ravel() for rows in ends])
    _, first, vertex = np.unique(connected_labels(same, len(z)), return_index=True, return_inverse=True)
    number = np.bincount(vertex)
    flat = np.column_stack([np.bincount(vertex, x) / number for x in cut.flat.T])
    return CutSurface(
        cut.surface[first], flat, vertex[cut.F], cut.vertices[first], cut.origin[first], cut.inner
    )


def group_rows(of: IntArray) -> list[IntArray]:
    """Return, for each number 0, 1, ..., the indices at which `of` has this number."""
    order = np.argsort(of, kind="stable")
    return np.split(order, np.searchsorted(of[order], np.arange(1, int(of.max()) + 1)))


def find_narrowest_turns(z: ComplexArray, piece: IntArray) -> ComplexArray:
    """Return the rotation of each piece that makes its smallest bounding rectangle horizontal."""
    order = np.argsort(piece, kind="stable")
    pieces = Ragged(np.searchsorted(piece[order], np.arange(int(piece.max()) + 2)))
    turn = min_rectangle_rotations(z[order], pieces.start)
    turned = z[order] * pieces.repeat(turn)
    wide, high = (pieces.max(x) - pieces.min(x) for x in (turned.real, turned.imag))
    return np.where(wide >= high, turn, 1j * turn)


def measure_extents(z: ComplexArray, piece: IntArray) -> FloatArray:
    """Return the extent of each piece: the larger of its width and height."""
    low, high = np.full((2, int(piece.max()) + 1), np.inf), np.full((2, int(piece.max()) + 1), -np.inf)
    for k, x in enumerate((z.real, z.imag)):
        np.minimum.at(low[k], piece, x)
        np.maximum.at(high[k], piece, x)
    return np.asarray((high - low).max(axis=0))
