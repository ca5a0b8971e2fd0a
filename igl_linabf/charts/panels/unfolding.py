"""Panels laid flat: where each lies in the plane, and where two of them may be joined."""

import numpy as np

from ..._core import DEPTH, forest_parents, normals, spanning_forest
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import Ragged, connected_labels, index_and_rank, sum_by
from ..features import CreasedSurface
from . import constants

MAX_PROJECTED_LOSS = 1e-4  # share of its area that a plane may lose when it is projected
MIN_OVERLAPPING_HEIGHT = 1e-12  # height of a face over the body's extent up to which it overlaps nothing
MAX_CREASES_OF_PAIR = 8  # number of creases between two panels along which they are tried
UNFILLED_SHARE = 0.0015  # price of a seam over the area of the page that it is worth, relative to E
PAGE_OVER_AREA = 2.0  # area of the page over that of the body for charts that may be as long as the page
PAGE_OVER_SQUARED_LENGTH = 0.6  # area of the page over the squared length of the longest panel


def unfold(creased: CreasedSurface, joined: BoolArray) -> ComplexArray:
    """The corners of the faces, (#F, 3), each panel unfolded to a plane across the edges within it."""
    m = len(creased.surface.F)
    z, plane = _in_planes(creased, joined)
    rows = np.flatnonzero(joined)
    flat = np.equal(*plane[creased.faces[rows]].T)
    rows = rows[np.lexsort((-creased.length[rows], ~flat))]  # those within planes first, then the longest
    tree = spanning_forest(creased.faces, rows, m)
    one, other = (z.ravel()[side] for side in creased.sides(tree))
    turn, shift = _motions(one, other)
    pairs = creased.faces[tree]
    parent = forest_parents(pairs, m)
    by, to = np.ones(m, dtype=np.complex128), np.zeros(m, dtype=np.complex128)
    down = parent[pairs[:, 1]] == pairs[:, 0]  # motions are those of the second face to the first
    child = np.where(down, pairs[:, 1], pairs[:, 0])
    by[child] = np.where(down, turn, turn.conj())
    to[child] = np.where(down, shift, -turn.conj() * shift)
    while (parent[parent] != parent).any():  # each round halves the ways to the roots
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
    even = total >= (1 - MAX_PROJECTED_LOSS) * sum_by(plane, double_area, number)
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


def upright_turns(z: ComplexArray, order: IntArray, panel: IntArray) -> ComplexArray:
    """The turn of each panel that brings its longest side along the first axis."""
    side = np.roll(z, -1, axis=1) - z
    longest = side[np.arange(len(side)), np.abs(side.T).argmax(axis=0)]
    by_length = order[np.lexsort((np.abs(longest)[order], panel[order]))]
    last = by_length[np.append(np.diff(panel[by_length]) != 0, True)]
    return np.asarray(longest[last].conj() / np.abs(longest[last]))


def _longest(creased: CreasedSurface, z: ComplexArray, panel: IntArray) -> FloatArray:
    """The width of the widest panel of each component along the first axis."""
    order = np.argsort(panel, kind="stable")
    panels = Ragged(np.searchsorted(panel[order], np.arange(int(panel.max()) + 2)))
    x = np.ascontiguousarray(z.real.T)[:, order]
    long = panels.max(x.max(axis=0)) - panels.min(x.min(axis=0))
    longest = np.zeros(len(creased.extent))
    np.maximum.at(longest, creased.label[order[panels.start[:-1]]], long)
    return longest


def overlap_depths(
    triangle: ComplexArray,
    extent: FloatArray,
    most: float,
    shallow: float | FloatArray = constants.MAX_DEPTH_OF_HEIGHT,
) -> FloatArray:
    """Return the depth to which each triangle may overlap others; negative for slivers, which are ignored.

    That is a share `most` of the extent, and `shallow` of its height, at most.
    """
    side = np.roll(triangle, -1, axis=1) - triangle
    longest = np.maximum(np.abs(side.T).max(axis=0), np.finfo(float).tiny)
    height = -(side[:, 0].conj() * side[:, 2]).imag / longest
    depth = np.maximum(DEPTH * height, np.minimum(shallow * height, most * extent))
    return np.where(height > MIN_OVERLAPPING_HEIGHT * extent, depth, -1.0)


def _few_of_each(label: IntArray) -> IntArray:
    """A few rows of each label, spread evenly over all of its rows, in order."""
    order = np.argsort(label, kind="stable")
    sizes = np.diff(np.flatnonzero(np.diff(label[order], prepend=-1, append=-1)))
    own, rank = index_and_rank(sizes)
    last, most = np.maximum(sizes - 1, 1)[own], MAX_CREASES_OF_PAIR - 1
    step, before = (most * of // last for of in (rank, rank - 1))
    return np.sort(order[step > before])


_Joints = tuple[IntArray, ComplexArray, ComplexArray, FloatArray, FloatArray]  # as `merge_regions` takes them


def joints(
    creased: CreasedSurface, fold: BoolArray, panel: IntArray, z: ComplexArray, same: float, trade: float
) -> _Joints:
    """Where panels may be joined across edges that part them, the dearest creases first.

    Edges at which one motion joins two panels, up to `same`, are one crease. Joining is worth as much area of
    the page as a seam along the crease costs.
    """
    rows = np.flatnonzero(fold)
    rows = rows[np.not_equal(*panel[creased.faces[rows]].T)]
    pairs = panel[creased.faces[rows]]
    one, other = (z.ravel()[side] for side in creased.sides(rows))
    back = pairs[:, 0] > pairs[:, 1]
    pairs[back] = pairs[back, ::-1]
    turn, shift = _motions(np.where(back, other, one), np.where(back, one, other))
    price = creased.price[rows]
    step = same * creased.edge_extent[rows]
    rounded = (np.round(part) for part in (turn / same, shift / step))
    keys = (*pairs.T, *(part for values in rounded for part in (values.real, values.imag)))
    order = np.lexsort((-price, *keys))
    new = np.zeros(len(rows), dtype=bool)
    new[:1] = True
    for key in keys:
        new[1:] |= np.diff(key[order]) != 0
    first = np.flatnonzero(new)
    total = np.add.reduceat(price[order], first) if len(first) else price
    by_length = np.argsort(-total, kind="stable")
    by_length = by_length[_few_of_each(pairs[order[first][by_length]] @ np.array([len(panel), 1]))]
    chosen = order[first][by_length]
    body = creased.label[creased.faces[rows[chosen], 0]]
    area = sum_by(creased.label, creased.surface.measured[0], len(creased.extent)) / 2
    squared_length = _longest(creased, z, panel) ** 2
    page = np.maximum(PAGE_OVER_AREA * area, PAGE_OVER_SQUARED_LENGTH * squared_length)
    worth = total[by_length] * np.sqrt(area)[body] / (UNFILLED_SHARE * trade)
    return pairs[chosen], turn[chosen], shift[chosen], worth, page[body]
