"""Separate arbitrary triangles into sheets, which are oriented manifolds.

Sides of faces are paired, and each fan of faces that the pairs connect gets its own copy of the vertex.
A side is a half-edge of a face: side 3 t + k runs from corner k of face t to its corner k + 1.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..._core import group_sides
from ..._types import BoolArray, FloatArray, IntArray
from ..ragged import index_and_rank
from ..topology import connected_labels, number_triangles

MOST_FACES_PAIRED = 500  # with more faces at an edge, the faces are not joined in pairs

# Joining two faces costs 1 + cos of their angle (0 flat, 1 at a right angle, 2 folded) plus penalties.
JOIN_COST_DECIMALS = 6  # decimals of the rounded cost, so that rounding errors do not break ties
COST_OF_OTHER_PATCH = 1.05  # penalty for joining faces of patches that are not connected otherwise
COST_OF_ONE_SIDEDNESS = 3.0  # penalty for joining faces if the patch would become one-sided


@dataclass(frozen=True, eq=False)
class Sheets:
    """Triangles that have been separated into oriented manifold sheets.

    Attributes
    ----------
    F : (#F, 3) int64
        The same faces in the same order, with new vertices.
    origin : (#V,) int64
        The old vertex that each new vertex is a copy of.
    turned : (#F,) bool
        Mask of reoriented faces, whose last two corners are swapped.
    crowded : (#, 2) int64
        Edges that had more than two faces.
    torn : (#, 2) int64
        Edges where a one-sided sheet was cut.
    twins : (#,) int64
        Faces that have the same three vertices as an earlier face.
    """

    F: IntArray
    origin: IntArray
    turned: BoolArray
    crowded: IntArray
    torn: IntArray
    twins: IntArray


def separate_sheets(V: FloatArray, F: IntArray) -> Sheets:
    """Separate triangles with three distinct vertices each into oriented manifold sheets.

    Where three or more faces share an edge, the pairs of faces that continue each other best are joined.
    All faces of a sheet get the orientation of the majority; a one-sided sheet is cut. Each fan of joined
    faces gets its own copy of the vertex.
    """
    if not len(F):
        no_edges = np.zeros((0, 2), dtype=np.int64)
        return Sheets(F, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=bool), no_edges, no_edges, F[:, 0])
    edges = _EdgeGroups.from_faces(F, len(V))
    triangle, twin = _number_triangles(F, edges)
    links, crowded = _link_sides(V, F, triangle, edges)
    turned, torn = orient_faces(F, links)
    torn_edges = _get_vertices_of_edges(F, links[torn])
    links = links[~torn]
    turn = turned[links // 3]
    links = np.where(turn, links // 3 * 3 + 2 - links % 3, links)
    F = np.where(turned[:, None], F[:, [0, 2, 1]], F)
    before = edges.count_faces_at_sides().reshape(F.shape)
    number = np.where(turned[:, None], before[:, ::-1], before)
    F_new, origin = _split_vertices(F, links, triangle, number.ravel())
    return Sheets(F_new, origin, turned, crowded, torn_edges, np.flatnonzero(twin))


def get_vertices_of_sides(F: IntArray) -> tuple[IntArray, IntArray]:
    """Return the first and the last vertex of each side, (3 #F,)."""
    return F.ravel(), F[:, [1, 2, 0]].ravel()


def _get_vertices_of_edges(F: IntArray, links: IntArray) -> IntArray:
    tail, head = get_vertices_of_sides(F)
    return np.sort(np.column_stack((tail[links[:, 0]], head[links[:, 0]])), axis=1)


@dataclass(frozen=True, eq=False)
class _EdgeGroups:
    """The sides sorted by edge; for each edge, the position of its first side and the number of its sides."""

    order: IntArray
    begin: IntArray
    count: IntArray

    @classmethod
    def from_faces(cls, F: IntArray, n: int) -> "_EdgeGroups":
        return cls(*group_sides(*get_vertices_of_sides(F), n))

    def get_paired_sides(self) -> tuple[IntArray, IntArray]:
        """Return both sides of each edge that has exactly two sides."""
        begin = self.begin[self.count == 2]
        return self.order[begin], self.order[begin + 1]

    def count_faces_at_sides(self) -> IntArray:
        """Return, for each side, the number of sides that share its edge."""
        number = np.empty_like(self.order)
        number[self.order] = np.repeat(self.count, self.count)
        return number


def _number_triangles(F: IntArray, edges: _EdgeGroups) -> tuple[IntArray, BoolArray]:
    """Number the distinct vertex triples of faces; also return a mask of the faces that repeat one."""
    a, b = edges.get_paired_sides()
    twins = F.ravel()[_get_opposite_corner(a)] == F.ravel()[_get_opposite_corner(b)]
    crowd = edges.order[np.repeat(edges.count > 2, edges.count)]
    some = np.unique(np.concatenate((a[twins], b[twins], crowd)) // 3)  # faces that may equal another face
    triangle, twin = np.arange(len(F)), np.zeros(len(F), dtype=bool)
    if len(some):
        number, twin[some] = number_triangles(F[some])
        triangle[some] = some[np.unique(number, return_index=True)[1]][number]
    return triangle, twin


def _get_opposite_corner(side: IntArray) -> IntArray:
    """Return the corner opposite to each side."""
    return np.asarray(side + np.array([2, -1, -1])[side % 3])


def _link_sides(
    V: FloatArray, F: IntArray, triangle: IntArray, edges: _EdgeGroups
) -> tuple[IntArray, IntArray]:
    """Return the pairs of joined sides, (#L, 2), and the edges with more than two faces."""
    order, begin, count = edges.order, edges.begin, edges.count
    plain = np.column_stack(edges.get_paired_sides())
    plain = plain[triangle[plain[:, 0] // 3] != triangle[plain[:, 1] // 3]]  # never join equal faces
    crowd = count > 2
    if not crowd.any():
        return plain, np.zeros((0, 2), dtype=np.int64)
    tail, head = get_vertices_of_sides(F)
    some = order[begin[crowd]]
    ends = np.sort(np.column_stack((tail[some], head[some])), axis=1)
    patch, turned, _ = _propagate_orientation(F, plain)
    a, b = _pair_sides(order, begin[crowd], count[crowd])
    a, b = (sides[triangle[a // 3] != triangle[b // 3]] for sides in (a, b))
    against = tail[a] == tail[b]
    same = patch[a // 3] == patch[b // 3]
    one_sided = same & (against ^ turned[a // 3] ^ turned[b // 3])
    with np.errstate(invalid="ignore"):
        cosine = (_compute_inward_vectors(V, F, a) * _compute_inward_vectors(V, F, b)).sum(axis=1)
    cosine[~np.isfinite(cosine)] = 1.0  # treat faces without area as folded
    cost = np.round(1 + cosine, JOIN_COST_DECIMALS)
    cost = cost + COST_OF_OTHER_PATCH * ~same + COST_OF_ONE_SIDEDNESS * one_sided
    ranked = np.lexsort((b, a, against, cost))
    chosen = _choose_pairs(a[ranked], b[ranked], 3 * len(F))
    return np.concatenate((plain, chosen)), ends


def _pair_sides(order: IntArray, begin: IntArray, count: IntArray) -> tuple[IntArray, IntArray]:
    """Return all pairs of sides at the same edge; the parameters are the fields of `_EdgeGroups`."""
    few = count <= MOST_FACES_PAIRED
    begin, count = begin[few], count[few]
    edge, at = index_and_rank(count)
    place, later = begin[edge] + at, count[edge] - at - 1
    row, ahead = index_and_rank(later)
    return order[place[row]], order[place[row] + 1 + ahead]


def _choose_pairs(a: IntArray, b: IntArray, n: int) -> IntArray:
    """Choose pairs greedily from a ranked list, such that each of the n sides is used at most once."""
    chosen = [np.zeros((0, 2), dtype=np.int64)]
    while len(a):
        rank = np.arange(len(a))
        best = np.full(n, len(a))
        np.minimum.at(best, a, rank)
        np.minimum.at(best, b, rank)
        mine = (best[a] == rank) & (best[b] == rank)
        chosen.append(np.column_stack((a[mine], b[mine])))
        taken = np.zeros(n, dtype=bool)
        taken[chosen[-1]] = True
        free = ~(taken[a] | taken[b])
        a, b = a[free], b[free]
    return np.concatenate(chosen)


def _compute_inward_vectors(V: FloatArray, F: IntArray, side: IntArray) -> FloatArray:
    """Return unit vectors in the faces, orthogonal to the given sides; NaN for faces without area."""
    t, k = side // 3, side % 3
    a, b, c = (V[F[t, (k + i) % 3]] for i in range(3))
    # start from the same end of the edge for both directions: equal faces then give bitwise equal vectors
    swap = (F[t, k] > F[t, (k + 1) % 3])[:, None]
    a, b = np.where(swap, b, a), np.where(swap, a, b)
    along, across = b - a, c - a
    with np.errstate(invalid="ignore", divide="ignore"):
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        across = across - (across * along).sum(axis=1, keepdims=True) * along
        return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))


def orient_faces(F: IntArray, links: IntArray) -> tuple[BoolArray, BoolArray]:
    """Return masks of the faces to reorient, and of the links where orientations cannot agree.

    `links` are pairs of sides, (#L, 2), of faces that share an edge; side 3 f + k begins at corner k of
    face f. All connected faces get the orientation of their majority.
    """
    tail, _ = get_vertices_of_sides(F)
    if not (tail[links[:, 0]] == tail[links[:, 1]]).any():
        return np.zeros(len(F), dtype=bool), np.zeros(len(links), dtype=bool)
    label, turned, torn = _propagate_orientation(F, links)
    change = np.bincount(label, weights=turned) * 2 > np.bincount(label)
    return turned ^ change[label], torn


def _propagate_orientation(F: IntArray, links: IntArray) -> tuple[IntArray, BoolArray, BoolArray]:
    """Propagate the orientation of the first face of each component over a spanning tree.

    Returns the component of each face, a mask of the faces to reorient, and a mask of the links between faces
    whose orientations still disagree.
    """
    m, faces = len(F), links // 3
    tail, _ = get_vertices_of_sides(F)
    against = tail[links[:, 0]] == tail[links[:, 1]]
    label = connected_labels(faces, m)
    turned = np.zeros(m, dtype=bool)
    if not against.any():
        return label, turned, against
    roots = np.unique(label, return_index=True)[1]
    tree = np.concatenate((faces, np.column_stack((np.full(len(roots), m), roots))))
    graph = sparse.csr_array((np.ones(len(tree), dtype=np.int8), tree.T), shape=(m + 1, m + 1))
    before = sparse.csgraph.breadth_first_order(graph, m, directed=False)[1].astype(np.int64)
    before[roots], before[m] = roots, m
    before = before[:m]
    keys, link = np.unique(faces.min(axis=1) * m + faces.max(axis=1), return_index=True)
    child = np.flatnonzero(before != np.arange(m))
    up = before[child]
    key = np.minimum(child, up) * m + np.maximum(child, up)
    turned[child] = against[link[np.searchsorted(keys, key)]]
    while (before != before[before]).any():  # pointer doubling: accumulate turns along the path to the root
        turned ^= turned[before]
        before = before[before]
    return label, turned, against ^ turned[faces[:, 0]] ^ turned[faces[:, 1]]


def _split_vertices(
    F: IntArray, links: IntArray, triangle: IntArray, number: IntArray
) -> tuple[IntArray, IntArray]:
    """Give each fan its own vertex; return the new faces and the origin of each vertex.

    `links` are pairs of sides of opposite directions. `number` has, for each side, the number of sides that
    share its edge.
    """
    partner = np.full(F.size, -1)
    partner[links[:, 0]], partner[links[:, 1]] = links[:, 1], links[:, 0]
    fan = _label_fans(F, partner, np.arange(F.size))
    while True:
        loose = np.flatnonzero((number > 2) | ((number == 2) & (partner < 0)))
        spoilt = _find_coincident_sides(fan.reshape(F.shape), partner, triangle, loose)
        if spoilt is None:
            break
        at = np.zeros(int(F.max()) + 1, dtype=bool)  # vertices whose fans change
        for side in (spoilt, spoilt // 3 * 3 + (spoilt + 2) % 3):  # the two sides of a face at its corner
            at[F.ravel()[side]] = at[F[side // 3, (side + 1) % 3]] = True
            other = partner[side]
            partner[other[other >= 0]] = -1
            partner[side] = -1
        corners = np.flatnonzero(at[F.ravel()])
        fan[corners] = int(fan.max()) + 1 + _label_fans(F, partner, corners)
    used = np.zeros(int(fan.max()) + 1, dtype=bool)
    used[fan] = True
    fan = (np.cumsum(used) - 1)[fan]
    vertex = np.empty(int(fan.max()) + 1, dtype=np.int64)
    vertex[fan] = F.ravel()
    order = np.argsort(vertex, kind="stable")
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return place[fan].reshape(F.shape), vertex[order]


def _label_fans(F: IntArray, partner: IntArray, corners: IntArray) -> IntArray:
    """Label the fans of the given corners, which must be all corners of some vertices."""
    place = np.empty(F.size, dtype=np.int64)
    place[corners] = np.arange(len(corners))
    side = corners[partner[corners] >= 0]
    across = partner[side]
    ahead = across + np.array([1, 1, -2])[across % 3]  # end corner of the partner side
    return connected_labels(place[np.column_stack((side, ahead))], len(corners))


def _find_coincident_sides(
    F: IntArray, partner: IntArray, triangle: IntArray, loose: IntArray
) -> IntArray | None:
    """Return the sides whose start vertex must be duplicated so that no two edges have equal ends.

    Edges coincide where a surface touches itself along an edge and is connected around both of its ends. Two
    free sides of opposite directions at such an edge are joined instead, which updates `partner`. `loose` are
    the sides to examine. All other sides are joined in pairs, each at an edge with exactly two sides.
    """
    tail, head = get_vertices_of_sides(F)
    order, begin, count = group_sides(tail[loose], head[loose], int(F.max()) + 1)
    order = loose[order]
    two = begin[count == 2]
    a, b = order[two], order[two + 1]
    apart = partner[a] != b
    a, b = a[apart], b[apart]
    closing = (tail[a] != tail[b]) & (triangle[a // 3] != triangle[b // 3])
    partner[a[closing]], partner[b[closing]] = b[closing], a[closing]
    spoilt = [b[~closing]]
    for start, number in zip(begin[count > 2].tolist(), count[count > 2].tolist(), strict=True):
        sides = order[start : start + number]
        keep = next((s for s in sides.tolist() if partner[s] >= 0), int(sides[0]))
        spoilt.append(sides[(sides != keep) & (sides != partner[keep])])
    found = np.concatenate(spoilt)
    return found if len(found) else None
