"""Unfold panels to the plane, and find the rigid motions that join two panels along a crease."""

import numpy as np

from ..._core import DEPTH, forest_parents, normals, spanning_forest
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import Ragged, connected_labels, index_and_rank, sum_by_index
from ..features import CreasedSurface
from . import constants

MAX_PROJECTED_LOSS = 1e-4  # maximum loss of a plane's area by projecting its faces to the mean plane
MIN_OVERLAPPING_HEIGHT = 1e-12  # ignore overlaps of triangles whose height over the extent is less
MAX_CREASES_OF_PAIR = 8  # try to join two panels at up to this many of their common creases
UNFILLED_SHARE = 0.0015  # weight of unused page area in joining panels, relative to `AtlasCost`
PAGE_OVER_AREA = 2.0  # expected area of the page, relative to the area of the component
PAGE_OVER_SQUARED_LENGTH = 0.6  # minimum ratio of the page's area to the longest panel's squared length


def unfold_panels(creased: CreasedSurface, joined: BoolArray) -> ComplexArray:
    """Unfold each panel to the plane across the edges in `joined`; return its faces' corners, (#F, 3)."""
    m = len(creased.surface.F)
    z, plane = _project_to_planes(creased, joined)
    rows = np.flatnonzero(joined)
    flat = np.equal(*plane[creased.faces_of_edges[rows]].T)
    rows = rows[np.lexsort((-creased.edge_length[rows], ~flat))]  # edges within planes first, then by length
    tree = spanning_forest(creased.faces_of_edges, rows, m)
    one, other = (z.ravel()[side] for side in creased.get_corners_at_edges(tree))
    turn, shift = _find_motions(one, other)
    pairs = creased.faces_of_edges[tree]
    parent = forest_parents(pairs, m)
    by, to = np.ones(m, dtype=np.complex128), np.zeros(m, dtype=np.complex128)
    down = parent[pairs[:, 1]] == pairs[:, 0]  # a motion maps the second face to the frame of the first
    child = np.where(down, pairs[:, 1], pairs[:, 0])
    by[child] = np.where(down, turn, turn.conj())
    to[child] = np.where(down, shift, -turn.conj() * shift)
    while (parent[parent] != parent).any():  # pointer doubling: each round halves the depth of the trees
        by, to, parent = by[parent] * by, by[parent] * to + to[parent], parent[parent]
    by /= np.abs(by)
    return np.asarray(by[:, None] * z + to[:, None])


def _project_to_planes(creased: CreasedSurface, joined: BoolArray) -> tuple[ComplexArray, IntArray]:
    """Return complex coordinates of each face's corners within its plane, (#F, 3), and the plane's index."""
    surface, m = creased.surface, len(creased.surface.F)
    double_area = surface.areas_and_products[0]
    plane = connected_labels(creased.faces_of_edges[joined & creased.is_coplanar], m)
    normal = normals(surface.V, surface.topology.corner)
    number = int(plane.max()) + 1
    summed = np.stack([sum_by_index(plane, double_area * x, number) for x in normal.T], axis=1)
    total = np.linalg.norm(summed, axis=1)
    even = total >= (1 - MAX_PROJECTED_LOSS) * sum_by_index(plane, double_area, number)
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


def _find_motions(one: ComplexArray, other: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return the rotations and translations that map the edges `other` to the edges `one`, (2, #E) each.

    The rotation is the identity for an edge whose two ends coincide after rounding.
    """
    turn = (one[1] - one[0]) * (other[1] - other[0]).conj()
    size = np.abs(turn)
    turn = np.divide(turn, size, out=np.ones_like(turn), where=size > 0)
    return turn, one.mean(axis=0) - turn * other.mean(axis=0)


def find_upright_turns(z: ComplexArray, order: IntArray, panel: IntArray) -> ComplexArray:
    """Return the rotation of each panel that aligns its longest side with the first axis."""
    side = np.roll(z, -1, axis=1) - z
    longest = side[np.arange(len(side)), np.abs(side.T).argmax(axis=0)]
    by_length = order[np.lexsort((np.abs(longest)[order], panel[order]))]
    last = by_length[np.append(np.diff(panel[by_length]) != 0, True)]
    return np.asarray(longest[last].conj() / np.abs(longest[last]))


def _measure_longest_panels(creased: CreasedSurface, z: ComplexArray, panel: IntArray) -> FloatArray:
    """Return the extent along the first axis of the longest panel of each component."""
    order = np.argsort(panel, kind="stable")
    panels = Ragged(np.searchsorted(panel[order], np.arange(int(panel.max()) + 2)))
    x = np.ascontiguousarray(z.real.T)[:, order]
    long = panels.max(x.max(axis=0)) - panels.min(x.min(axis=0))
    longest = np.zeros(len(creased.component_extent))
    np.maximum.at(longest, creased.component_of_face[order[panels.start[:-1]]], long)
    return longest


def compute_overlap_depths(
    triangle: ComplexArray,
    extent: FloatArray,
    most: float,
    shallow: float | FloatArray = constants.MAX_DEPTH_OF_HEIGHT,
) -> FloatArray:
    """Return the depth up to which an overlap of each triangle is ignored, and -1 for slivers.

    The depth is at most `most` times the extent and at most `shallow` times the height of the triangle.
    All overlaps of slivers are ignored.
    """
    side = np.roll(triangle, -1, axis=1) - triangle
    longest = np.maximum(np.abs(side.T).max(axis=0), np.finfo(float).tiny)
    height = -(side[:, 0].conj() * side[:, 2]).imag / longest
    depth = np.maximum(DEPTH * height, np.minimum(shallow * height, most * extent))
    return np.where(height > MIN_OVERLAPPING_HEIGHT * extent, depth, -1.0)


def _select_few_per_label(label: IntArray) -> IntArray:
    """Return at most `MAX_CREASES_OF_PAIR` evenly spaced rows of each label, in ascending order."""
    order = np.argsort(label, kind="stable")
    sizes = np.diff(np.flatnonzero(np.diff(label[order], prepend=-1, append=-1)))
    own, rank = index_and_rank(sizes)
    last, most = np.maximum(sizes - 1, 1)[own], MAX_CREASES_OF_PAIR - 1
    step, before = (most * of // last for of in (rank, rank - 1))
    return np.sort(order[step > before])


_Joints = tuple[IntArray, ComplexArray, ComplexArray, FloatArray, FloatArray]  # arguments of `merge_regions`


def find_joints(
    creased: CreasedSurface, fold: BoolArray, panel: IntArray, z: ComplexArray, same: float, trade: float
) -> _Joints:
    """Return pairs of panels that may be joined, and the rigid motions that join them, most valuable first.

    Edges belong to one crease if the same motion, up to the tolerance `same`, joins their panels. The value
    of joining two panels is the price of a seam along the crease, converted to page area.
    """
    rows = np.flatnonzero(fold)
    rows = rows[np.not_equal(*panel[creased.faces_of_edges[rows]].T)]
    pairs = panel[creased.faces_of_edges[rows]]
    one, other = (z.ravel()[side] for side in creased.get_corners_at_edges(rows))
    back = pairs[:, 0] > pairs[:, 1]
    pairs[back] = pairs[back, ::-1]
    turn, shift = _find_motions(np.where(back, other, one), np.where(back, one, other))
    price = creased.search_price[rows]
    step = same * creased.extent_at_edge[rows]
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
    by_length = by_length[_select_few_per_label(pairs[order[first][by_length]] @ np.array([len(panel), 1]))]
    chosen = order[first][by_length]
    body = creased.component_of_face[creased.faces_of_edges[rows[chosen], 0]]
    area = (
        sum_by_index(
            creased.component_of_face, creased.surface.areas_and_products[0], len(creased.component_extent)
        )
        / 2
    )
    squared_length = _measure_longest_panels(creased, z, panel) ** 2
    page = np.maximum(PAGE_OVER_AREA * area, PAGE_OVER_SQUARED_LENGTH * squared_length)
    worth = total[by_length] * np.sqrt(area)[body] / (UNFILLED_SHARE * trade)
    return pairs[chosen], turn[chosen], shift[chosen], worth, page[body]
