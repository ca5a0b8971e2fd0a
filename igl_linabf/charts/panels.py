"""Panels: what lies between sharp creases, each laid flat for itself, and put together edge to edge.

Where all that is curved is on sharp creases, panels are planes, cylinders and cones. Their net is found at
once: two panels are joined along their common crease, the longest ones first, as long as nothing lies over
anything else. What is not joined is a seam.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..kernels import DEPTH, Hinges, above, assembled, lengths, normals, spanning_forest
from ..surface import (
    NEXT,
    PREV,
    Parts,
    Submesh,
    compact,
    connected_labels,
    cut_faces,
    face_components,
    sum_by,
)
from .creases import NOISE, SHARP, SOFT, TIP, all_bends, extents_of, flat_shares, sharpness, tips
from .cut_graph import closed_surface, join
from .nets import HARD, NEAR_CREASED, SHARP_SHARE

FOLD = np.deg2rad(5.0)  # bend from which on an edge is a crease between panels
EVEN, STEEP = 1e-3, 0.05  # radians that a plane may bend at an edge; and at one of a sliver, by rounding
PLANAR = 1e-4  # share of its area that a plane may lose when it is projected
FITS = 1e-5  # of the extent, by which two sides of a crease may miss each other when they are joined
ROUNDING = 1e-12  # of the extent: slivers of less height lie over nothing
SINGLE = 2e-6  # of the extent, by which triangles may reach into each other: single precision bends edges so
SHALLOW = 0.05  # of their height, by which they may at most
SAME = 1e-3  # of the extent, and radians: creases that two motions bring together by less are one
WASTED = 0.02  # of the area between charts that others do not fill
PAGE, LONGEST = 2.0, 0.6  # of the area, or of the squared length of a panel, that a page is meant to have
NEEDLE = 1e-12  # area over squared length, up to which no face may be a panel alone
GAIN = 0.02  # sum of squared curvatures, in full turns, from which on a disk gains by a seam


@dataclass(frozen=True, eq=False)
class Creased:
    """A surface of several components, and what tells which of them are made of panels."""

    surface: Submesh

    @property
    def label(self) -> IntArray:
        """The component of each face."""
        return self.surface.label

    @cached_property
    def extent(self) -> FloatArray:
        """Of each component."""
        return extents_of(self.surface, self.label)

    @property
    def inside(self) -> IntArray:
        """The edges with two faces."""
        return self.surface.topology.inside

    @property
    def faces(self) -> IntArray:
        """The two faces of each of these, (#E, 2)."""
        return self.surface.topology.faces_inside

    @property
    def ends(self) -> IntArray:
        """The vertices of each, (#E, 2)."""
        return self.surface.topology.edges_inside

    def sides(self, rows: IntArray | BoolArray) -> tuple[IntArray, IntArray]:
        """Where the ends of such edges are among the corners of all faces, (2, #E) in either face."""
        corner, face = np.divmod(self.surface.topology.sides[:, self.inside[rows]], len(self.surface.F))
        a, b = (3 * face + (corner + k) % 3 for k in (1, 2))
        return np.stack((a[0], b[0])), np.stack((b[1], a[1]))

    def marked(self, rows: IntArray | BoolArray | slice) -> BoolArray:
        """The mask, (#F, 3), of the sides from corner k to k + 1 that are such edges."""
        surface = self.surface
        corner, face = np.divmod(surface.topology.sides[:, self.inside[rows]], len(surface.F))
        sides = np.zeros(surface.F.shape, dtype=bool)
        sides[face, np.array(NEXT)[corner]] = True  # half-edge (k, t) is the side k + 1 of t
        return sides

    @cached_property
    def rim(self) -> BoolArray:
        """The mask of the sides on the boundary."""
        return ~self.marked(slice(None))

    @cached_property
    def length(self) -> FloatArray:
        """Of these edges."""
        return lengths(self.surface.V, self.ends)

    @cached_property
    def turned(self) -> FloatArray:
        """`all_bends`, at these edges."""
        return all_bends(self.surface, self.extent[self.label])

    @cached_property
    def bend(self) -> FloatArray:
        """The size of these; nothing at the diagonals of polygons."""
        size = np.abs(self.turned)
        if self.surface.inner is not None:
            size[~np.isin(self.inside, self.surface.cells[1])] = 0.0
        return np.asarray(size)

    @cached_property
    def sharp(self) -> BoolArray:
        """Whether these are sharp creases."""
        return np.asarray(self.bend >= SHARP)

    @cached_property
    def curvature(self) -> FloatArray:
        """The size of the angle defect at each vertex, beyond what rounding makes; zero on the boundary."""
        surface, n = self.surface, len(self.surface.V)
        size = np.abs(2 * np.pi - surface.angle_sums)
        size[np.concatenate([*surface.topology.loops, np.zeros(0, dtype=np.int64)])] = 0.0
        extent = NOISE * self.extent[self.label[self.faces[:, 0]]]
        turned = np.repeat(extent / np.maximum(self.length, np.finfo(float).tiny), 2)
        noise = np.bincount(self.ends.ravel(), turned, n)
        return np.where(size > noise, size, 0.0)

    def made_of_panels(self, trade: float) -> BoolArray:
        """Which components are: what is curved is on sharp creases, or a tip, and seams there cost little.

        Where most of the area lies flat, they may cost more. A disk has to gain by seams, unless nothing is
        curved.
        """
        surface, bent, ends, number = self.surface, self.curvature, self.ends, len(self.extent)
        of_vertex = np.empty(len(surface.V), dtype=np.int64)
        of_vertex[surface.F] = self.label[:, None]
        on_sharp, on_soft = np.zeros((2, len(surface.V)), dtype=bool)
        on_sharp[ends[self.sharp]] = True
        on_soft[ends[self.bend > SOFT]] = True
        smooth = (bent > 0) & ~on_sharp
        made = np.bincount(of_vertex[smooth & (bent <= TIP)], minlength=number) == 0
        if not made.any():
            return np.zeros(number, dtype=bool)
        smooth &= ~tips(bent, ends, on_sharp, on_soft)
        made = np.bincount(of_vertex[smooth], minlength=number) == 0
        if not made.any():
            return np.zeros(number, dtype=bool)
        # no tree through what is curved costs less: each node has an edge, and an edge has two nodes
        least, price = np.full(len(surface.V), np.inf), self.length * np.where(self.sharp, SHARP_SHARE, 1.0)
        np.minimum.at(least, ends.ravel(), np.repeat(price, 2))
        curved = np.flatnonzero(bent)
        size = np.sqrt(sum_by(self.label, surface.measured[0], number) / 2)
        length = np.bincount(of_vertex[curved], least[curved], number) / 2 / size
        cheap = np.maximum(0.0, length - SHARP_SHARE * trade) / trade < NEAR_CREASED
        if not cheap[made].all():
            cheap |= flat_shares(surface, self.label) >= HARD
        made &= cheap
        gain = np.bincount(of_vertex, (bent / (2 * np.pi)) ** 2, number)
        loops = np.bincount(of_vertex[[loop[0] for loop in surface.topology.loops]], minlength=number)
        made &= (loops > 1) | (gain == 0) | (gain > GAIN)
        double_area, dot = surface.measured
        needle = double_area <= NEEDLE * (dot[NEXT] + dot[PREV]).max(axis=0)  # it has no map of its own
        made &= np.bincount(self.label[needle], minlength=number) == 0
        return np.asarray(made & ((loops > 0) | (np.bincount(of_vertex[on_sharp], minlength=number) > 0)))


def seams_of_panels(creased: Creased, trade: float) -> tuple[IntArray, BoolArray]:
    """The edges, by the caller's vertices, along which components that are made of panels fall into charts.

    Each chart is a disk that its panels lay flat; but a panel may still lie over itself. Also tells which
    faces are of components where that cannot be: they have no seams.
    """
    surface, fold = creased.surface, creased.bend >= FOLD
    slit, handles = _slits(creased, fold)
    left = np.isin(creased.label, creased.label[handles])
    seam = slit | _unfit(creased, fold, slit, trade) if fold.any() else slit
    if seam.any():
        seam |= _slits(creased, seam)[0]
    seam &= ~left[creased.faces[:, 0]]
    return surface.vertices[creased.ends[seam]], left


def _unfit(creased: Creased, fold: BoolArray, slit: BoolArray, trade: float) -> BoolArray:
    """The folds along which panels are not joined."""
    panel = connected_labels(creased.faces[~fold], len(creased.surface.F))
    z = _laid_flat(creased, ~fold & ~slit)
    order = np.argsort(panel, kind="stable")
    start = np.searchsorted(panel[order], np.arange(int(panel.max()) + 2))
    z *= _upright(z, order, panel)[panel, None]
    extent = creased.extent[creased.label]
    hinges = _hinges(creased, fold, panel, z, trade)
    chart, turn, shift = assembled(z[order], _depths(z[order], extent[order]), start, hinges)
    z = turn[panel, None] * z + shift[panel, None]
    one, other = creased.sides(fold)
    a, b = creased.faces[fold].T
    fits = chart[panel[a]] == chart[panel[b]]
    fits &= (np.abs(z.ravel()[one] - z.ravel()[other]) <= FITS * extent[a]).all(axis=0)
    seam = np.zeros_like(fold)
    seam[np.flatnonzero(fold)[~fits]] = True
    return seam


def _slits(creased: Creased, cut: BoolArray) -> tuple[BoolArray, IntArray]:
    """Edges that open the parts of a cut surface to disks without tips; the faces of parts with handles."""
    surface, slit, handles = creased.surface, np.zeros(len(cut), dtype=bool), np.zeros(0, dtype=np.int64)
    sides = creased.marked(cut)
    F, origin = cut_faces(surface.F, len(surface.V), surface.topology.sides, sides)
    n, sides = len(origin), sides | creased.rim
    label = face_components(F, n)
    of_vertex, tip = np.empty(n, dtype=np.int64), creased.curvature[origin] > 0
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
    handles = rows[((loops == 0) | (characteristic + loops != 2))[label[rows]]]
    piece = closed_surface(part)
    seam = join(piece, np.zeros(0, dtype=np.int64), piece.node[tip[used]])
    ends, n = origin[used[piece.edges[seam]]], len(surface.V)
    known, given = (np.minimum(*e.T) * n + np.maximum(*e.T) for e in (creased.ends, ends))
    slit[np.searchsorted(known, given)] = True
    return slit, handles


def _laid_flat(creased: Creased, joined: BoolArray) -> ComplexArray:
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


def _in_planes(creased: Creased, joined: BoolArray) -> tuple[ComplexArray, IntArray]:
    """The corners of the faces in the planes that they lie in, and the plane of each face."""
    surface, m = creased.surface, len(creased.surface.F)
    double_area, dot = surface.measured
    longest = np.sqrt((dot[NEXT] + dot[PREV]).max(axis=0))
    height = np.minimum(*(double_area / longest)[creased.faces.T])
    noise = NOISE * creased.extent[creased.label[creased.faces[:, 0]]] / height
    flat = joined & (creased.bend <= np.minimum(np.maximum(EVEN, 4 * noise), STEEP))
    plane = connected_labels(creased.faces[flat], m)
    normal = normals(surface.V, surface.topology.corner)
    number = int(plane.max()) + 1
    summed = np.stack([sum_by(plane, double_area * x, number) for x in normal.T], axis=1)
    total = np.linalg.norm(summed, axis=1)
    even = total >= (1 - PLANAR) * sum_by(plane, double_area, number)
    common = even[plane] & (total[plane] > 0)
    normal = np.where(common[:, None], summed[plane] / np.maximum(total[plane], 1e-300)[:, None], normal)
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


def _longest(creased: Creased, z: ComplexArray, panel: IntArray) -> FloatArray:
    """The longest panel of each component, as it lies across."""
    order = np.argsort(panel, kind="stable")
    panels = Parts(np.searchsorted(panel[order], np.arange(int(panel.max()) + 2)))
    x = np.ascontiguousarray(z.real.T)[:, order]
    long = panels.max(x.max(axis=0)) - panels.min(x.min(axis=0))
    longest = np.zeros(len(creased.extent))
    np.maximum.at(longest, creased.label[order[panels.start[:-1]]], long)
    return longest


def _depths(triangle: ComplexArray, extent: FloatArray) -> FloatArray:
    """By how much triangles may reach into each other; negative for those that are slivers."""
    side = np.roll(triangle, -1, axis=1) - triangle
    height = -(side[:, 0].conj() * side[:, 2]).imag / np.maximum(np.abs(side.T).max(axis=0), 1e-300)
    depth = np.maximum(DEPTH * height, np.minimum(SHALLOW * height, SINGLE * extent))
    return np.where(height > ROUNDING * extent, depth, -1.0)


def _hinges(creased: Creased, fold: BoolArray, panel: IntArray, z: ComplexArray, trade: float) -> Hinges:
    """Where panels may be joined, the dearest creases first; edges that one motion joins are one crease.

    A crease is worth the page that its length costs: that of sharp creases on which a seam is as dear.
    """
    rows = np.flatnonzero(fold)
    rows = rows[np.not_equal(*panel[creased.faces[rows]].T)]
    pairs = panel[creased.faces[rows]]
    one, other = (z.ravel()[side] for side in creased.sides(rows))
    back = pairs[:, 0] > pairs[:, 1]
    pairs[back] = pairs[back, ::-1]
    turn, shift = _motions(np.where(back, other, one), np.where(back, one, other))
    length = creased.length[rows] * (1 - (1 - SHARP_SHARE) * sharpness(creased.bend[rows]))
    step = SAME * creased.extent[creased.label[creased.faces[rows, 0]]]
    rounded = (np.round(part) for part in (turn / SAME, shift / step))
    keys = (*pairs.T, *(part for values in rounded for part in (values.real, values.imag)))
    order = np.lexsort((-length, *keys))
    new = np.zeros(len(rows), dtype=bool)
    new[:1] = True
    for key in keys:
        new[1:] |= np.diff(key[order]) != 0
    first = np.flatnonzero(new)
    total = np.add.reduceat(length[order], first) if len(first) else length
    by_length = np.argsort(-total, kind="stable")
    chosen = order[first][by_length]
    body = creased.label[creased.faces[rows[chosen], 0]]
    area = sum_by(creased.label, creased.surface.measured[0], len(creased.extent)) / 2
    page = np.maximum(PAGE * area, LONGEST * _longest(creased, z, panel) ** 2)  # half its diagonal, squared
    worth = total[by_length] / SHARP_SHARE * np.sqrt(area)[body] / (WASTED * trade)
    return Hinges(pairs[chosen], turn[chosen], shift[chosen], worth, page[body])
