"""Panels: what lies between sharp creases, each laid flat for itself, and put together edge to edge.

Where all that is curved is on sharp creases, panels are planes, cylinders and cones. Their net is found at
once: two panels are joined along their common crease, the longest ones first, as long as nothing lies over
anything else. What is not joined is a seam.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..._core import DEPTH, above, assembled, normals, spanning_forest
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import (
    NEXT,
    Ragged,
    Submesh,
    compact,
    connected_labels,
    cut_faces,
    face_components,
    index_and_rank,
    sum_by,
)
from ..cut_graphs import ClosedSurface, join_terminals, open_handles
from ..features import PLANAR_SHARE, TIP_CURVATURE, CreasedSurface, sharpness
from . import constants


@dataclass(frozen=True, eq=False)
class Panels:
    """The panels of a surface with sharp creases.

    Attributes
    ----------
    creased : CreasedSurface
    same : float
        Of the extent, and radians, up to which two motions bring creases together alike.
    opens_handles : bool
        Whether panels may have handles, which seams then open.
    dearest : float
        Price of a component's seams, from which on they are sought in another way.
    """

    creased: CreasedSurface
    same: ClassVar[float] = constants.SAME_MOTION
    opens_handles: ClassVar[bool] = False
    dearest: ClassVar[float] = np.inf

    @cached_property
    def fold(self) -> BoolArray:
        """Whether edges part panels."""
        return np.asarray(self.creased.crease_angle >= constants.PANEL_ANGLE)

    @cached_property
    def opened(self) -> BoolArray:
        """Which vertices seams have to come to."""
        return np.asarray(self.creased.curvature > 0)

    def fits(self, rows: IntArray | BoolArray) -> FloatArray:
        """By how much the two sides of such edges may miss each other when they are joined."""
        return np.asarray(constants.MAX_CREASE_GAP * self.creased.edge_extent[rows])

    def depths(self, z: ComplexArray) -> FloatArray:
        """By how much the faces, laid flat, may reach into each other; negative for slivers."""
        extent = self.creased.extent[self.creased.label]
        return depths(z, extent, constants.MAX_OVERLAP_DEPTH, constants.MAX_DEPTH_OF_HEIGHT)

    def made(self, trade: float) -> BoolArray:
        """Which components are made of them: what is curved is on sharp creases, or a tip.

        Seams there have to cost little. Where most of the area lies flat, they may cost more.
        """
        creased, bent = self.creased, self.creased.curvature
        smooth = (bent > 0) & ~creased.on_sharp
        made = np.asarray(creased.per_component(smooth & (bent <= TIP_CURVATURE)) == 0)
        if made.any():
            made &= creased.per_component(smooth & ~creased.is_apex) == 0
        if not made.any():
            return made
        # no tree through what is curved costs less: each node has an edge, and an edge has two nodes
        least = np.full(len(bent), np.inf)
        price = creased.visible_length * np.where(creased.sharp, constants.SHARP_CREASE_PRICE, 1.0)
        np.minimum.at(least, creased.ends.ravel(), np.repeat(price, 2))
        cheap = self.price(creased.per_component(bent > 0, least) / 2, trade) < constants.MAX_CREASED_COST
        if not cheap[made].all():
            cheap |= creased.flat_share >= PLANAR_SHARE
        made &= cheap & creased.may_fall_apart
        return made & ((creased.n_loops > 0) | (creased.per_component(creased.on_sharp) > 0))

    def price(self, length: FloatArray, trade: float) -> FloatArray:
        """What seams on sharp creases cost, of which this length counts in each component."""
        length = length / np.sqrt(self.creased.double_area / 2)
        return np.asarray(np.maximum(0.0, length - constants.SHARP_CREASE_PRICE * trade) / trade)


def panel_seams(panels: Panels, trade: float) -> tuple[IntArray, BoolArray]:
    """The edges, by the caller's vertices, along which components that are made of panels fall into charts.

    Each chart is a disk that its panels lay flat; but a panel may still lie over itself. Also tells which
    faces are of components where that cannot be, or is too dear: they have no seams.
    """
    creased, fold = panels.creased, panels.fold
    slit, handles = _slits(panels, fold)
    seam = slit | _unfit(panels, slit, trade) if fold.any() else slit
    if seam.any():
        seam |= _slits(panels, seam)[0]
    body = creased.label[creased.faces[:, 0]]
    length = sum_by(body[seam], creased.visible_length[seam], len(creased.extent))
    dear = panels.price(constants.SHARP_CREASE_PRICE * length, trade) > panels.dearest
    dear[creased.label[handles]] = True
    left = dear[creased.label]
    seam &= ~dear[body]
    return creased.surface.vertices[creased.ends[seam]], left


def _unfit(panels: Panels, slit: BoolArray, trade: float) -> BoolArray:
    """The folds along which panels are not joined."""
    creased, fold = panels.creased, panels.fold
    panel = connected_labels(creased.faces[~fold], len(creased.surface.F))
    z = _laid_flat(creased, ~fold & ~slit)
    order = np.argsort(panel, kind="stable")
    start = np.searchsorted(panel[order], np.arange(int(panel.max()) + 2))
    z *= _upright(z, order, panel)[panel, None]
    chart, turn, shift = assembled(
        z[order], panels.depths(z)[order], start, *_hinges(panels, panel, z, trade)
    )
    z = turn[panel, None] * z + shift[panel, None]
    one, other = creased.sides(fold)
    a, b = creased.faces[fold].T
    fits = chart[panel[a]] == chart[panel[b]]
    fits &= (np.abs(z.ravel()[one] - z.ravel()[other]) <= panels.fits(fold)).all(axis=0)
    seam = np.zeros_like(fold)
    seam[np.flatnonzero(fold)[~fits]] = True
    return seam


def _slits(panels: Panels, cut: BoolArray) -> tuple[BoolArray, IntArray]:
    """Edges that open the parts of a cut surface to disks without tips; the faces of parts with handles."""
    creased, surface = panels.creased, panels.creased.surface
    slit, handles = np.zeros(len(cut), dtype=bool), np.zeros(0, dtype=np.int64)
    sides = creased.side_mask(cut)
    F, origin = cut_faces(surface.F, len(surface.V), surface.topology.sides, sides)
    n, sides = len(origin), sides | creased.boundary_sides
    label = face_components(F, n)
    of_vertex, tip = np.empty(n, dtype=np.int64), panels.opened[origin]
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
    """The edges, as vertices (#E, 2), that open a part of several components to disks; one has handles alone.

    `tip` are vertices, (n,), to which they come.
    """
    piece = ClosedSurface.of(part, hidden)
    loops = open_handles(piece, 1) if piece.graph.genus else np.zeros(0, dtype=np.int64)
    seam = join_terminals(piece.graph, loops, piece.node[tip[part.vertices]])
    return part.vertices[piece.edges[seam]]


def _laid_flat(creased: CreasedSurface, joined: BoolArray) -> ComplexArray:
    """The corners of the faces, (#F, 3), each panel in a plane of its own, unfolded across these edges."""
    m = len(creased.surface.F)
    z, plane = _in_planes(creased, joined)
    rows = np.flatnonzero(joined)
    flat = np.equal(*plane[creased.faces[rows]].T)
    rows = rows[np.lexsort((-creased.length[rows], ~flat))]  # planes first, and then the longest
    tree = spanning_forest(creased.faces, rows, m)
    one, other = (z.ravel()[side] for side in creased.sides(tree))
    turn, shift = _motions(one, other)
    pairs = creased.faces[tree]
    parent = above(pairs, m)
    by, to = np.ones(m, dtype=np.complex128), np.zeros(m, dtype=np.complex128)
    down = parent[pairs[:, 1]] == pairs[:, 0]  # the motion is that of the second face to the first
    child = np.where(down, pairs[:, 1], pairs[:, 0])
    by[child] = np.where(down, turn, turn.conj())
    to[child] = np.where(down, shift, -turn.conj() * shift)
    while (parent[parent] != parent).any():  # each way to the root is half as long
        by, to, parent = by[parent] * by, by[parent] * to + to[parent], parent[parent]
    by /= np.abs(by)
    return np.asarray(by[:, None] * z + to[:, None])


def _in_planes(creased: CreasedSurface, joined: BoolArray) -> tuple[ComplexArray, IntArray]:
    """The corners of the faces in the planes that they lie in, and the plane of each face."""
    surface, m = creased.surface, len(creased.surface.F)
    double_area = surface.measured[0]
    plane = connected_labels(creased.faces[joined & creased.in_one_plane], m)
    normal = normals(surface.V, surface.topology.corner)
    number = int(plane.max()) + 1
    summed = np.stack([sum_by(plane, double_area * x, number) for x in normal.T], axis=1)
    total = np.linalg.norm(summed, axis=1)
    even = total >= (1 - constants.MAX_PROJECTED_LOSS) * sum_by(plane, double_area, number)
    common = even[plane] & (total[plane] > 0)
    summed /= np.maximum(total, np.finfo(float).tiny)[:, None]
    normal = np.where(common[:, None], summed[plane], normal)
    plane = np.where(common, plane, number + np.arange(m))
    first = np.unique(plane, return_index=True, return_inverse=True)
    origin = surface.V[surface.F[first[1][first[2]], 0]]
    axis = np.zeros((m, 3))
    axis[np.arange(m), np.abs(normal.T).argmin(axis=0)] = 1.0
    u = np.cross(normal, axis)
    u /= np.linalg.norm(u, axis=1)[:, None]
    v = np.cross(normal, u)
    corners = surface.V[surface.F] - origin[:, None]
    return np.einsum("fkd,fd->fk", corners, u) + 1j * np.einsum("fkd,fd->fk", corners, v), plane


def _motions(one: ComplexArray, other: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """The motions, turns and shifts, that bring edges, (2, #E), from other frames to where one has them.

    An edge whose length is rounded away in its frame is not turned.
    """
    turn = (one[1] - one[0]) * (other[1] - other[0]).conj()
    size = np.abs(turn)
    turn = np.divide(turn, size, out=np.ones_like(turn), where=size > 0)
    return turn, one.mean(axis=0) - turn * other.mean(axis=0)


def _upright(z: ComplexArray, order: IntArray, panel: IntArray) -> ComplexArray:
    """The turn of each panel, by which its longest side comes to lie across."""
    side = np.roll(z, -1, axis=1) - z
    longest = side[np.arange(len(side)), np.abs(side.T).argmax(axis=0)]
    by_length = order[np.lexsort((np.abs(longest)[order], panel[order]))]
    last = by_length[np.append(np.diff(panel[by_length]) != 0, True)]
    return np.asarray(longest[last].conj() / np.abs(longest[last]))


def _longest(creased: CreasedSurface, z: ComplexArray, panel: IntArray) -> FloatArray:
    """The longest panel of each component, as it lies across."""
    order = np.argsort(panel, kind="stable")
    panels = Ragged(np.searchsorted(panel[order], np.arange(int(panel.max()) + 2)))
    x = np.ascontiguousarray(z.real.T)[:, order]
    long = panels.max(x.max(axis=0)) - panels.min(x.min(axis=0))
    longest = np.zeros(len(creased.extent))
    np.maximum.at(longest, creased.label[order[panels.start[:-1]]], long)
    return longest


def depths(
    triangle: ComplexArray, extent: FloatArray, most: float, shallow: float | FloatArray
) -> FloatArray:
    """By how much triangles may reach into each other; negative for slivers.

    That is a share `most` of the extent, and `shallow` of their height, at most.
    """
    side = np.roll(triangle, -1, axis=1) - triangle
    longest = np.maximum(np.abs(side.T).max(axis=0), np.finfo(float).tiny)
    height = -(side[:, 0].conj() * side[:, 2]).imag / longest
    depth = np.maximum(DEPTH * height, np.minimum(shallow * height, most * extent))
    return np.where(height > constants.MIN_OVERLAPPING_HEIGHT * extent, depth, -1.0)


def _few_of_each(label: IntArray) -> IntArray:
    """The rows of a few of each label, as far from each other among its rows as can be, in order."""
    order = np.argsort(label, kind="stable")
    sizes = np.diff(np.flatnonzero(np.diff(label[order], prepend=-1, append=-1)))
    own, rank = index_and_rank(sizes)
    last, most = np.maximum(sizes - 1, 1)[own], constants.MAX_CREASES_OF_PAIR - 1
    step, before = (most * of // last for of in (rank, rank - 1))
    return np.sort(order[step > before])


_Hinges = tuple[IntArray, ComplexArray, ComplexArray, FloatArray, FloatArray]  # as `assembled` takes them


def _hinges(panels: Panels, panel: IntArray, z: ComplexArray, trade: float) -> _Hinges:
    """Where panels may be joined, the dearest creases first; edges that one motion joins are one crease.

    A crease is worth the page that its length costs: that of sharp creases on which a seam is as dear.
    """
    creased = panels.creased
    rows = np.flatnonzero(panels.fold)
    rows = rows[np.not_equal(*panel[creased.faces[rows]].T)]
    pairs = panel[creased.faces[rows]]
    one, other = (z.ravel()[side] for side in creased.sides(rows))
    back = pairs[:, 0] > pairs[:, 1]
    pairs[back] = pairs[back, ::-1]
    turn, shift = _motions(np.where(back, other, one), np.where(back, one, other))
    price = 1 - (1 - constants.SHARP_CREASE_PRICE) * sharpness(creased.crease_angle[rows])
    length = creased.visible_length[rows] * price
    step = panels.same * creased.edge_extent[rows]
    rounded = (np.round(part) for part in (turn / panels.same, shift / step))
    keys = (*pairs.T, *(part for values in rounded for part in (values.real, values.imag)))
    order = np.lexsort((-length, *keys))
    new = np.zeros(len(rows), dtype=bool)
    new[:1] = True
    for key in keys:
        new[1:] |= np.diff(key[order]) != 0
    first = np.flatnonzero(new)
    total = np.add.reduceat(length[order], first) if len(first) else length
    by_length = np.argsort(-total, kind="stable")
    by_length = by_length[_few_of_each(pairs[order[first][by_length]] @ np.array([len(panel), 1]))]
    chosen = order[first][by_length]
    body = creased.label[creased.faces[rows[chosen], 0]]
    area = sum_by(creased.label, creased.surface.measured[0], len(creased.extent)) / 2
    squared_length = _longest(creased, z, panel) ** 2
    page = np.maximum(constants.PAGE_OVER_AREA * area, constants.PAGE_OVER_SQUARED_LENGTH * squared_length)
    sharp_length = total[by_length] / constants.SHARP_CREASE_PRICE
    worth = sharp_length * np.sqrt(area)[body] / (constants.UNFILLED_SHARE * trade)
    return pairs[chosen], turn[chosen], shift[chosen], worth, page[body]
