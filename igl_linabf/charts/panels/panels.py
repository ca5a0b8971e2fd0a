"""Panels: what lies between creases, each laid flat alone, and joined edge to edge.

Where all that is curved is on sharp creases, panels are planes, cylinders and cones. Their net is found at
once: two panels are joined along their common crease, the longest creases first, as long as no face lies
over another one. A crease along which they are not joined is a seam.

Machine parts have fillets, too. A fillet ends in corners that are curved a little at each of many vertices,
and no net goes through all of these. But the planes on its two sides are panels: each takes half of the
fillet, whose middle is a crease between them. Panels are joined along these as along sharp creases, with some
play. What is curved then comes to the boundaries of charts, which are flattened.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..._core import merge_regions, nearest_sources, shortest_pairs
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import NEXT, Submesh, compact, connected_labels, cut_faces, face_components, sum_by
from ..cut_graphs import ClosedSurface, join_terminals, open_handles
from ..features import PLANAR_SHARE, TIP_CURVATURE, CreasedSurface
from . import constants
from .unfolding import joints, overlap_depths, unfolded, upright_turns


@dataclass(frozen=True, eq=False)
class Panels:
    """The panels of a surface with sharp creases.

    Attributes
    ----------
    creased : CreasedSurface
    same_motion : float
        Difference over the extent, and in radians, up to which two motions that join panels are one.
    opens_handles : bool
        Whether panels may have handles, which seams then open.
    max_cost : float
        Cost of a component's seams from which it is cut in another way.
    """

    creased: CreasedSurface
    same_motion: ClassVar[float] = constants.SAME_MOTION
    opens_handles: ClassVar[bool] = False
    max_cost: ClassVar[float] = np.inf

    @cached_property
    def fold(self) -> BoolArray:
        """Which edges part panels."""
        return np.asarray(self.creased.crease_angle >= constants.PANEL_ANGLE)

    @cached_property
    def terminals(self) -> BoolArray:
        """Which vertices seams have to come to: those that are curved."""
        return np.asarray(self.creased.curvature > 0)

    def max_gaps(self, rows: IntArray | BoolArray) -> FloatArray:
        """The gap between the two sides of such edges up to which these are joined."""
        return np.asarray(constants.MAX_CREASE_GAP * self.creased.edge_extent[rows])

    def max_depths(self, z: ComplexArray) -> FloatArray:
        """The `overlap_depths` of the faces, laid flat."""
        extent = self.creased.extent[self.creased.label]
        return overlap_depths(z, extent, constants.MAX_OVERLAP_DEPTH)

    def made(self, trade: float) -> BoolArray:
        """Which components are made of panels: all that is curved is on sharp creases, or a tip.

        Seams there have to cost little, unless most of the area lies flat.
        """
        creased, bent = self.creased, self.creased.curvature
        smooth = (bent > 0) & ~creased.on_sharp
        made = np.asarray(creased.per_component(smooth & (bent <= TIP_CURVATURE)) == 0)
        if made.any():
            made &= creased.per_component(smooth & ~creased.is_apex) == 0
        if not made.any():
            return made
        # no tree through these vertices costs less: each has an edge, and an edge has two vertices
        least = np.full(len(bent), np.inf)
        price = creased.visible_length * np.where(creased.sharp, constants.SHARP_CREASE_PRICE, 1.0)
        np.minimum.at(least, creased.ends.ravel(), np.repeat(price, 2))
        cheap = self.cost(creased.per_component(bent > 0, least) / 2, trade) < constants.MAX_CREASED_COST
        if not cheap[made].all():
            cheap |= creased.flat_share >= PLANAR_SHARE
        made &= cheap & creased.may_fall_apart
        return made & ((creased.n_loops > 0) | (creased.per_component(creased.on_sharp) > 0))

    def cost(self, length: FloatArray, trade: float) -> FloatArray:
        """What seams on sharp creases of this length, times their price, cost in each component."""
        length = length / np.sqrt(self.creased.double_area / 2)
        return np.asarray(np.maximum(0.0, length - constants.SHARP_CREASE_PRICE * trade) / trade)


@dataclass(frozen=True, eq=False)
class RoundedPanels(Panels):
    """The panels of a surface with rounded creases."""

    same_motion: ClassVar[float] = constants.SAME_ROUNDED_MOTION
    opens_handles: ClassVar[bool] = True
    max_cost: ClassVar[float] = constants.MAX_ROUNDED_COST

    @cached_property
    def _plane(self) -> IntArray:
        """The plane of each face."""
        creased = self.creased
        return connected_labels(creased.faces[creased.in_one_plane], len(creased.surface.F))

    @cached_property
    def _large(self) -> BoolArray:
        """Which faces are in a plane that makes a panel."""
        creased, plane = self.creased, self._plane
        number = int(plane.max()) + 1
        area, whole = sum_by(plane, creased.surface.measured[0], number), np.empty(number)
        whole[plane] = creased.double_area[creased.label]
        pairs = plane[creased.faces[~creased.sharp]]
        pairs, beside = pairs[pairs[:, 0] != pairs[:, 1]], np.zeros(number)
        for one, other in (pairs.T, pairs[:, ::-1].T):
            np.maximum.at(beside, one, area[other])
        least = np.maximum(constants.MIN_PLANE_SHARE * whole, constants.PLANE_OVER_NEIGHBOURS * beside)
        return np.asarray((area >= least)[plane])

    @cached_property
    def fold(self) -> BoolArray:
        """Whether edges part panels: sharp creases, and those halfway between two large planes.

        A face goes with the large plane to which the surface turns least on a way there.
        """
        creased, smooth = self.creased, ~self.creased.sharp
        m, faces = len(creased.surface.F), self.creased.faces
        turn = constants.TURN_OF_EXTENT * creased.length / creased.edge_extent
        way = (creased.crease_angle + turn)[smooth]
        indptr, indices, edge = shortest_pairs(faces[smooth], way, m)
        everywhere = np.ones(m, dtype=bool)
        _, _, source = nearest_sources(
            indptr, indices, way[edge], np.flatnonzero(self._large), everywhere, constants.MAX_FILLET_TURN
        )
        panel = np.where(source >= 0, self._plane[source], -1)
        return np.asarray(creased.sharp | np.not_equal(*panel[faces].T))

    @cached_property
    def terminals(self) -> BoolArray:
        return np.asarray(self.creased.curvature > TIP_CURVATURE)

    def max_gaps(self, rows: IntArray | BoolArray) -> FloatArray:
        extent, length = self.creased.edge_extent[rows], self.creased.length[rows]
        play = np.minimum(constants.ROUNDED_PLAY * extent, constants.ROUNDED_PLAY_OF_EDGE * length)
        return np.maximum(super().max_gaps(rows), play)

    def max_depths(self, z: ComplexArray) -> FloatArray:
        shallow = np.where(self._large, constants.MAX_DEPTH_OF_HEIGHT, constants.ROUNDED_DEPTH_OF_HEIGHT)
        return overlap_depths(z, self.creased.extent[self.creased.label], constants.ROUNDED_PLAY, shallow)

    def made(self, trade: float) -> BoolArray:
        """Which components are made of panels: they have creases, and many faces are in large planes.

        None if seams are to be hidden, as seams around all planes show.
        """
        creased = self.creased
        made = creased.may_fall_apart & (creased.hidden is None)
        if made.any():
            large = np.where(self._large, creased.surface.measured[0], 0.0)
            least = constants.PLANAR_SHARE_OF_ROUNDED * creased.double_area
            made &= sum_by(creased.label, large, len(made)) >= least
        if made.any():
            made &= np.bincount(creased.label[creased.faces[self.fold, 0]], minlength=len(made)) > 0
        return made


class FlatPanels(Panels):
    """The panels between sharp creases of an isometric map."""

    @cached_property
    def fold(self) -> BoolArray:
        return self.creased.sharp

    def max_depths(self, z: ComplexArray) -> FloatArray:
        return overlap_depths(z, self.creased.extent[self.creased.label], 0.0)


def panel_seams(panels: Panels, trade: float) -> tuple[IntArray, BoolArray]:
    """The seams, by the caller's vertices, of components that are made of panels.

    Each chart is then a disk that its panels lay flat; but a panel may still lie over itself. A component
    whose panels have handles, or whose seams cost too much, gets no seams: also tells which faces are its.
    """
    creased, fold = panels.creased, panels.fold
    slit, handles = _slits(panels, fold)
    seam = slit | unjoined(panels, unfolded(creased, ~fold & ~slit), trade) if fold.any() else slit
    if seam.any():
        seam |= _slits(panels, seam)[0]
    body = creased.label[creased.faces[:, 0]]
    length = sum_by(body[seam], creased.visible_length[seam], len(creased.extent))
    dear = panels.cost(constants.SHARP_CREASE_PRICE * length, trade) > panels.max_cost
    dear[creased.label[handles]] = True
    return creased.surface.vertices[creased.ends[seam & ~dear[body]]], dear[creased.label]


def unjoined(panels: Panels, z: ComplexArray, trade: float) -> BoolArray:
    """The folds along which panels are not joined.

    `z` are the corners of the faces, (#F, 3), where each panel lies flat. With a `trade` of 0 panels are
    joined however they fill the page.
    """
    creased, fold = panels.creased, panels.fold
    panel = connected_labels(creased.faces[~fold], len(creased.surface.F))
    order = np.argsort(panel, kind="stable")
    start = np.searchsorted(panel[order], np.arange(int(panel.max()) + 2))
    z = z * upright_turns(z, order, panel)[panel, None]
    joins = joints(creased, fold, panel, z, panels.same_motion, trade)
    chart, turn, shift = merge_regions(z[order], panels.max_depths(z)[order], start, *joins)
    z = turn[panel, None] * z + shift[panel, None]
    one, other = creased.sides(fold)
    a, b = creased.faces[fold].T
    fits = chart[panel[a]] == chart[panel[b]]
    fits &= (np.abs(z.ravel()[one] - z.ravel()[other]) <= panels.max_gaps(fold)).all(axis=0)
    seam = np.zeros_like(fold)
    seam[np.flatnonzero(fold)[~fits]] = True
    return seam


def _slits(panels: Panels, cut: BoolArray) -> tuple[BoolArray, IntArray]:
    """Edges that open the parts of a cut surface to disks, all terminals on their boundaries.

    Also the faces of parts that have handles and are not opened.
    """
    creased, surface = panels.creased, panels.creased.surface
    slit, handles = np.zeros(len(cut), dtype=bool), np.zeros(0, dtype=np.int64)
    sides = creased.side_mask(cut)
    F, origin = cut_faces(surface.F, len(surface.V), surface.topology.sides, sides)
    n, sides = len(origin), sides | creased.boundary_sides
    label = face_components(F, n)
    of_vertex, tip = np.empty(n, dtype=np.int64), panels.terminals[origin]
    of_vertex[F], tip[F[sides]], tip[F[:, NEXT][sides]] = label[:, None], False, False
    vertices, faces, rim, tips = (
        np.bincount(of, minlength=int(label.max()) + 1)
        for of in (of_vertex, label, label[np.nonzero(sides)[0]], of_vertex[tip])
    )
    characteristic = vertices - (3 * faces + rim) // 2 + faces
    wanted = (characteristic != 1) | (tips > 0)
    if not wanted.any():
        return slit, handles
    rows = np.flatnonzero(wanted[label])
    used, F = compact(F[rows], n)
    inner = None if surface.inner is None else surface.inner[rows]
    part = Submesh(surface.V[origin[used]], F, rows, used, n, inner)
    first = used[np.array([loop[0] for loop in part.topology.loops], dtype=np.int64)]
    loops = np.bincount(of_vertex[first], minlength=len(vertices))
    handled, closed = wanted & (characteristic + loops != 2), loops == 0
    if panels.opens_handles:
        alone, stays = np.flatnonzero(handled), closed & ~handled
    else:
        alone, stays = np.zeros(0, dtype=np.int64), closed | handled
    handles, of = rows[stays[label[rows]]], label[rows]
    parts = [part.of_faces(np.flatnonzero(of == k)) for k in alone]
    if not len(alone):
        parts = [part]
    elif len(others := np.flatnonzero(~np.isin(of, alone))):
        parts.append(part.of_faces(others))
    ends, n = origin[np.concatenate([_opening(part, tip, creased.hidden) for part in parts])], len(surface.V)
    known, given = (np.minimum(*e.T) * n + np.maximum(*e.T) for e in (creased.ends, ends))
    slit[np.searchsorted(known, given)] = True
    return slit, handles


def _opening(part: Submesh, tip: BoolArray, hidden: FloatArray | None) -> IntArray:
    """The edges, as vertices (#E, 2), that open a part of several components, of which one may have handles.

    `tip` is the mask of vertices, (n,), to which they come.
    """
    piece = ClosedSurface.of(part, hidden)
    loops = open_handles(piece, 1) if piece.graph.genus else np.zeros(0, dtype=np.int64)
    seam = join_terminals(piece.graph, loops, piece.node[tip[part.vertices]])
    return part.vertices[piece.edges[seam]]
