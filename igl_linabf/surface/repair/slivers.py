"""Repair faces without area: collapse short sides and open caps, without making holes."""

import numpy as np

from ..._types import BoolArray, FloatArray, IntArray
from ..areas import find_faces_without_area
from ..arrays import has_distinct_corners
from ..topology import connected_labels

COLLAPSED_LENGTH = 1e-9  # collapse sides up to this length, relative to the size of the face's coordinates
ROUNDING_MARGIN = 16.0  # areas up to this multiple of their rounding error count as zero

# Height of the arc to which caps are opened: the smaller of these shares of chord and shortest side.
ARC_HEIGHT = 0.02
ARC_HEIGHT_OF_SHORTEST_SIDE = 0.1

FIRST_SHAKE = 1e-4  # first random displacement, relative to the shortest side, if an arc does not suffice


def compute_side_lengths(V: FloatArray, F: IntArray) -> FloatArray:
    """Return the lengths (#F, 3) of the sides from corner k to k + 1."""
    return np.asarray(np.linalg.norm(V[F[:, [1, 2, 0]]] - V[F], axis=2))


def collapse_short_sides(V: FloatArray, F: IntArray) -> IntArray:
    """Collapse the short sides of faces without area; return the vertex that each vertex is merged into."""
    merged = np.arange(len(V))
    while True:
        now = merged[F]
        whole = np.flatnonzero(has_distinct_corners(now))
        flat = whole[find_faces_without_area(V, now[whole], ROUNDING_MARGIN)] if len(whole) else whole
        corners = now[flat]
        extent = np.abs(V[corners]).max(axis=(1, 2), initial=0)
        lengths = compute_side_lengths(V, corners)
        size = np.maximum(extent, lengths.max(axis=1, initial=0))
        t, k = np.nonzero(lengths <= COLLAPSED_LENGTH * size[:, None])
        if not len(t):
            return merged
        label = connected_labels(np.column_stack((corners[t, k], corners[t, (k + 1) % 3])), len(V))
        merged = np.unique(label, return_index=True)[1][label][merged]


def open_faces_without_area(V: FloatArray, F: IntArray) -> tuple[FloatArray, IntArray]:
    """Move the vertices of faces without area a little, such that these faces get an area.

    The caps at an edge triangulate a line segment. Their vertices move to a shallow arc in the plane of the
    face on the other side of the edge, bulging away from that face. This gives the caps an area, and flat
    surroundings stay flat. Where an arc does not suffice, vertices move in random directions by increasing
    distances. `F` must be a manifold.

    Returns
    -------
    V : (#V, 3) float64
    faces : (#,) int64
        The faces that had no area.
    """
    found = flat = find_faces_without_area(V, F)
    if not len(found):
        return V, found
    still = V = _move_to_arcs(V, F, found)
    flat = find_faces_without_area(V, F)
    random, step = np.random.default_rng(0), FIRST_SHAKE
    while len(flat) and step < 1:
        lengths = compute_side_lengths(still, F[flat])
        mover = F[flat, (lengths.argmax(axis=1) + 2) % 3]
        reach = np.full(len(V), np.inf)
        np.minimum.at(reach, mover, step * lengths.min(axis=1))
        middle = np.unique(mover)
        away = random.normal(size=(len(middle), 3))
        away /= np.linalg.norm(away, axis=1, keepdims=True)
        V = V.copy()
        V[middle] = still[middle] + reach[middle, None] * away
        step *= 2
        flat = find_faces_without_area(V, F)
    return V, found


def _move_to_arcs(V: FloatArray, F: IntArray, flat: IntArray) -> FloatArray:
    lengths = compute_side_lengths(V, F[flat])
    side = lengths.argmax(axis=1)
    order = (side[:, None] + np.arange(3)) % 3
    a, b, c = F[flat[:, None], order].T  # the longest side runs from a to b, and c lies on it
    across = _find_faces_across(F, flat * 3 + side)
    cap = np.full(len(F) + 1, -1)
    cap[flat] = np.arange(len(flat))
    up = cap[across]  # cap[-1] is -1: no cap lies across a boundary edge
    own = np.arange(len(flat))
    ends = (up < 0) | (up[up] == own)
    root = np.where(ends, own, up)
    for _ in range(len(flat).bit_length()):
        root = root[root]
    away = np.empty((len(flat), 3))
    away[ends] = _compute_arc_directions(
        V, F, flat[ends] * 3 + side[ends], across[ends], up[ends] > own[ends]
    )
    start, along = V[a[root]], V[b[root]] - V[a[root]]
    length = np.linalg.norm(along, axis=1)
    shortest = np.full(len(flat), np.inf)
    np.minimum.at(shortest, root, lengths.min(axis=1))
    height = np.minimum(ARC_HEIGHT * length, ARC_HEIGHT_OF_SHORTEST_SIDE * shortest[root])
    s = np.clip(((V[c] - start) * along).sum(axis=1) / length**2, 0, 1)
    moved, first = V.copy(), np.unique(c * len(flat) + root, return_index=True)[1]
    np.add.at(moved, c[first], (height * 4 * s * (1 - s))[first, None] * away[root[first]])
    return moved


def _find_faces_across(F: IntArray, side: IntArray) -> IntArray:
    """Return the face across each of the sides 3 t + k, or -1 at the boundary."""
    n = int(F.max()) + 1
    tail, head = F.ravel(), F[:, [1, 2, 0]].ravel()
    forth, back = tail * n + head, head[side] * n + tail[side]
    order = np.argsort(forth)
    place = np.minimum(np.searchsorted(forth, back, sorter=order), len(order) - 1)
    return np.where(forth[order[place]] == back, order[place] // 3, -1)


def _compute_arc_directions(
    V: FloatArray, F: IntArray, side: IntArray, across: IntArray, second: BoolArray
) -> FloatArray:
    """Return unit vectors orthogonal to the sides, in the plane of the faces across and away from them.

    Without a face across, or with a degenerate one, the vector is any vector orthogonal to the side. The
    second of two caps at a side gets the opposite vector.
    """
    t, k = side // 3, side % 3
    a, b = F[t, k], F[t, (k + 1) % 3]
    along = (V[b] - V[a]) / np.linalg.norm(V[b] - V[a], axis=1, keepdims=True)
    apex = F[across].sum(axis=1) - a - b
    inward = np.where((across >= 0)[:, None], V[np.where(across >= 0, apex, a)] - V[a], 0)
    inward -= (inward * along).sum(axis=1, keepdims=True) * along
    size = np.linalg.norm(inward, axis=1, keepdims=True)
    axis = np.eye(3)[np.abs(along).argmin(axis=1)]
    any_ = np.cross(along * np.where(a < b, 1, -1)[:, None], axis)
    any_ *= np.where(second, -1, 1)[:, None] / np.linalg.norm(any_, axis=1, keepdims=True)
    plane = size > COLLAPSED_LENGTH * np.linalg.norm(V[b] - V[a], axis=1, keepdims=True)
    return np.where(plane, -inward / np.where(plane, size, 1), any_)
