"""Any triangles as sheets, oriented manifolds: which sides are joined, and a vertex for each fan of faces.

Side 3 t + k of the faces runs from corner k of face t to its corner k + 1.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..._core import in_edges
from ..._types import BoolArray, FloatArray, IntArray
from ..ragged import index_and_rank
from ..topology import connected_labels, triangle_numbers
from .constants import COST_OF_ONE_SIDEDNESS, COST_OF_OTHER_PATCH, JOIN_COST_DECIMALS, MOST_FACES_PAIRED


@dataclass(frozen=True, eq=False)
class Sheets:
    """Triangles as an oriented manifold surface.

    Attributes
    ----------
    F : (#F, 3) int64
        The same faces in the same order, over new vertices.
    origin : (#V,) int64
        The vertex that each new one is a copy of.
    turned : (#F,) bool
        Faces that run the other way around: their last two corners have changed places.
    crowded, torn : (#, 2) int64
        Edges that had more than two faces; edges where a one-sided sheet was cut.
    twins : (#,) int64
        Faces of the same three vertices as one before them.
    """

    F: IntArray
    origin: IntArray
    turned: BoolArray
    crowded: IntArray
    torn: IntArray
    twins: IntArray


def separate_sheets(V: FloatArray, F: IntArray) -> Sheets:
    """Make triangles, none with a vertex twice, an oriented manifold surface.

    Of three and more faces at an edge those that continue each other best stay joined, pair by pair.
    Neighbours get the same orientation, that of most of a sheet's faces; where a sheet is
    one-sided, it is cut. Each fan of joined faces gets a vertex of its own.
    """
    if not len(F):
        no_edges = np.zeros((0, 2), dtype=np.int64)
        return Sheets(F, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=bool), no_edges, no_edges, F[:, 0])
    edges = _Edges.of(F, len(V))
    triangle, twin = _triangles(F, edges)
    links, crowded = _links(V, F, triangle, edges)
    turned, torn = _orientation(F, links)
    torn_edges = _edge_ends(F, links[torn])
    links = links[~torn]
    turn = turned[links // 3]
    links = np.where(turn, links // 3 * 3 + 2 - links % 3, links)
    F = np.where(turned[:, None], F[:, [0, 2, 1]], F)
    before = edges.of_sides().reshape(F.shape)
    number = np.where(turned[:, None], before[:, ::-1], before)
    F_new, origin = _with_fans(F, links, triangle, number.ravel())
    return Sheets(F_new, origin, turned, crowded, torn_edges, np.flatnonzero(twin))


def _tails_heads(F: IntArray) -> tuple[IntArray, IntArray]:
    return F.ravel(), F[:, [1, 2, 0]].ravel()


def _edge_ends(F: IntArray, links: IntArray) -> IntArray:
    tail, head = _tails_heads(F)
    return np.sort(np.column_stack((tail[links[:, 0]], head[links[:, 0]])), axis=1)


@dataclass(frozen=True, eq=False)
class _Edges:
    """Sides in the order of their edges; where each edge begins in it, and how many sides it has."""

    order: IntArray
    begin: IntArray
    count: IntArray

    @classmethod
    def of(cls, F: IntArray, n: int) -> "_Edges":
        return cls(*in_edges(*_tails_heads(F), n))

    def two(self) -> tuple[IntArray, IntArray]:
        """Both sides of each edge that has two."""
        begin = self.begin[self.count == 2]
        return self.order[begin], self.order[begin + 1]

    def of_sides(self) -> IntArray:
        """The number of sides at each side's edge."""
        number = np.empty_like(self.order)
        number[self.order] = np.repeat(self.count, self.count)
        return number


def _triangles(F: IntArray, edges: _Edges) -> tuple[IntArray, BoolArray]:
    """A number for each face's triangle, by its vertices; and which faces have that of one before them."""
    a, b = edges.two()
    twins = F.ravel()[_opposite(a)] == F.ravel()[_opposite(b)]
    crowd = edges.order[np.repeat(edges.count > 2, edges.count)]
    some = np.unique(np.concatenate((a[twins], b[twins], crowd)) // 3)  # no others can be equal
    triangle, twin = np.arange(len(F)), np.zeros(len(F), dtype=bool)
    if len(some):
        number, twin[some] = triangle_numbers(F[some])
        triangle[some] = some[np.unique(number, return_index=True)[1]][number]
    return triangle, twin


def _opposite(side: IntArray) -> IntArray:
    """The corner opposite to each side."""
    return np.asarray(side + np.array([2, -1, -1])[side % 3])


def _links(V: FloatArray, F: IntArray, triangle: IntArray, edges: _Edges) -> tuple[IntArray, IntArray]:
    """The pairs of sides that are joined, (#L, 2), and the edges of more than two faces."""
    order, begin, count = edges.order, edges.begin, edges.count
    plain = np.column_stack(edges.two())
    plain = plain[triangle[plain[:, 0] // 3] != triangle[plain[:, 1] // 3]]  # a leaf's two sides
    crowd = count > 2
    if not crowd.any():
        return plain, np.zeros((0, 2), dtype=np.int64)
    tail, head = _tails_heads(F)
    some = order[begin[crowd]]
    ends = np.sort(np.column_stack((tail[some], head[some])), axis=1)
    patch, turned, _ = _agreed(F, plain)
    a, b = _pairs_at(order, begin[crowd], count[crowd])
    a, b = (sides[triangle[a // 3] != triangle[b // 3]] for sides in (a, b))
    against = tail[a] == tail[b]
    same = patch[a // 3] == patch[b // 3]
    one_sided = same & (against ^ turned[a // 3] ^ turned[b // 3])
    with np.errstate(invalid="ignore"):
        cosine = (_inward(V, F, a) * _inward(V, F, b)).sum(axis=1)
    cosine[~np.isfinite(cosine)] = 1.0  # as if folded: a face without area has no direction
    cost = np.round(1 + cosine, JOIN_COST_DECIMALS)
    cost = cost + COST_OF_OTHER_PATCH * ~same + COST_OF_ONE_SIDEDNESS * one_sided
    ranked = np.lexsort((b, a, against, cost))
    chosen = _best_pairs(a[ranked], b[ranked], 3 * len(F))
    return np.concatenate((plain, chosen)), ends


def _pairs_at(order: IntArray, begin: IntArray, count: IntArray) -> tuple[IntArray, IntArray]:
    """All pairs of sides at the same edge; `begin` and `count` as of `_Edges`."""
    few = count <= MOST_FACES_PAIRED
    begin, count = begin[few], count[few]
    edge, at = index_and_rank(count)
    place, later = begin[edge] + at, count[edge] - at - 1
    row, ahead = index_and_rank(later)
    return order[place[row]], order[place[row] + 1 + ahead]


def _best_pairs(a: IntArray, b: IntArray, n: int) -> IntArray:
    """Of ranked pairs among n sides the first that use each side once, greedily."""
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


def _inward(V: FloatArray, F: IntArray, side: IntArray) -> FloatArray:
    """Unit vectors in the faces, at right angles to these sides; NaN in a face without area."""
    t, k = side // 3, side % 3
    a, b, c = (V[F[t, (k + i) % 3]] for i in range(3))
    # the end of the edge does not depend on the direction of the side: equal faces give equal bits
    swap = (F[t, k] > F[t, (k + 1) % 3])[:, None]
    a, b = np.where(swap, b, a), np.where(swap, a, b)
    along, across = b - a, c - a
    with np.errstate(invalid="ignore", divide="ignore"):
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        across = across - (across * along).sum(axis=1, keepdims=True) * along
        return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))


def _orientation(F: IntArray, links: IntArray) -> tuple[BoolArray, BoolArray]:
    """Which faces to turn, and across which links orientation cannot agree."""
    tail, _ = _tails_heads(F)
    if not (tail[links[:, 0]] == tail[links[:, 1]]).any():
        return np.zeros(len(F), dtype=bool), np.zeros(len(links), dtype=bool)
    label, turned, torn = _agreed(F, links)
    change = np.bincount(label, weights=turned) * 2 > np.bincount(label)
    return turned ^ change[label], torn


def _agreed(F: IntArray, links: IntArray) -> tuple[IntArray, BoolArray, BoolArray]:
    """The component of each face; which to turn to agree with its first one; links where that fails."""
    m, faces = len(F), links // 3
    tail, _ = _tails_heads(F)
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
    while (before != before[before]).any():  # of all faces on the way to the first, doubling the steps
        turned ^= turned[before]
        before = before[before]
    return label, turned, against ^ turned[faces[:, 0]] ^ turned[faces[:, 1]]


def _with_fans(
    F: IntArray, links: IntArray, triangle: IntArray, number: IntArray
) -> tuple[IntArray, IntArray]:
    """`F` over a vertex for each fan, and what each was; `links` join sides of opposite directions.

    `number` is that of the sides at each side's edge.
    """
    partner = np.full(F.size, -1)
    partner[links[:, 0]], partner[links[:, 1]] = links[:, 1], links[:, 0]
    fan = _fans_at_corners(F, partner, np.arange(F.size))
    while True:
        loose = np.flatnonzero((number > 2) | ((number == 2) & (partner < 0)))
        spoilt = _indistinct(fan.reshape(F.shape), partner, triangle, loose)
        if spoilt is None:
            break
        at = np.zeros(int(F.max()) + 1, dtype=bool)  # the vertices whose fans change
        for side in (spoilt, spoilt // 3 * 3 + (spoilt + 2) % 3):  # the two at the corner
            at[F.ravel()[side]] = at[F[side // 3, (side + 1) % 3]] = True
            other = partner[side]
            partner[other[other >= 0]] = -1
            partner[side] = -1
        corners = np.flatnonzero(at[F.ravel()])
        fan[corners] = int(fan.max()) + 1 + _fans_at_corners(F, partner, corners)
    used = np.zeros(int(fan.max()) + 1, dtype=bool)
    used[fan] = True
    fan = (np.cumsum(used) - 1)[fan]
    vertex = np.empty(int(fan.max()) + 1, dtype=np.int64)
    vertex[fan] = F.ravel()
    order = np.argsort(vertex, kind="stable")
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return place[fan].reshape(F.shape), vertex[order]


def _fans_at_corners(F: IntArray, partner: IntArray, corners: IntArray) -> IntArray:
    """The fan of each of some corners, all of their vertices, by what sides are joined."""
    place = np.empty(F.size, dtype=np.int64)
    place[corners] = np.arange(len(corners))
    side = corners[partner[corners] >= 0]
    across = partner[side]
    ahead = across + np.array([1, 1, -2])[across % 3]  # the corner where the other side ends
    return connected_labels(place[np.column_stack((side, ahead))], len(corners))


def _indistinct(F: IntArray, partner: IntArray, triangle: IntArray, loose: IntArray) -> IntArray | None:
    """Sides whose first corner needs a vertex of its own, as its edge is another's, too; None if none.

    That is where a surface touches itself along an edge, and is connected around both of its ends.
    Two free sides that come to lie together in opposite directions are joined instead. All of them are among
    the `loose` sides: others are one of two that are joined.
    """
    tail, head = _tails_heads(F)
    order, begin, count = in_edges(tail[loose], head[loose], int(F.max()) + 1)
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
