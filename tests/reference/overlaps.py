"""Reference for overlaps, their sheets, and the merging of regions, by comparing all pairs of triangles."""

import numpy as np
import shapely
from scipy import sparse
from scipy.sparse import csgraph

MIN_DEPTH = 1e-6
ROUNDING = 16 * np.finfo(float).eps
ROOM = 0.8
LONG, DIRECTIONS = 15.0, 24


def upright(triangle):
    """Orient triangles, (#T, 3), counter-clockwise; also return their heights and rounding errors."""
    a, b, c = triangle.T
    area = ((b - a).conj() * (c - a)).imag
    longest = np.abs(triangle - np.roll(triangle, 1, axis=1)).max(axis=1)
    height = np.divide(np.abs(area), longest, out=np.zeros(len(area)), where=longest > 0)
    turned = np.where((area < 0)[:, None], triangle[:, [0, 2, 1]], triangle)
    return turned, height, ROUNDING * np.abs(triangle).max(axis=1)


def overlap_of(one, other, least):
    """Return True if two counter-clockwise triangles overlap more deeply than `least` (separating axes)."""

    def separates(a, b):
        side = np.roll(a, -1) - a
        with np.errstate(invalid="ignore"):
            reach = ((side / np.abs(side)).conj()[:, None] * (b[None] - a[:, None])).imag
        return not (reach.max(axis=1) > least).all()

    return not separates(one, other) and not separates(other, one)


def find_overlaps(z, F, chart):
    """Return the pairs of faces i < j of one chart that overlap by more than a millionth of a height."""
    triangle, height, rounding = upright(z[F])
    solid = np.flatnonzero(height > rounding)
    pairs = [(i, j) for i in solid for j in solid if i < j and chart[i] == chart[j]]
    least = [MIN_DEPTH * min(height[i], height[j]) + max(rounding[i], rounding[j]) for i, j in pairs]
    found = [pair for pair, deep in zip(pairs, least, strict=True) if overlap_of(*triangle[list(pair)], deep)]
    return np.array(found, dtype=np.int64).reshape(-1, 2)


def common_areas(z, F, pairs):
    """Return the area of the intersection of each pair of triangles."""
    one, other = (
        shapely.make_valid(shapely.polygons(np.stack((z[F[side]].real, z[F[side]].imag), axis=2)))
        for side in pairs.T
    )
    return shapely.area(shapely.intersection(one, other))


def overlap_sheets(pairs, beside, m, most):
    """Return the two sheets of the `most` largest overlaps of m faces; `beside` lists adjacent faces."""
    pairs = np.unique(np.concatenate((pairs, pairs[:, ::-1])), axis=0)
    number = {pair: k for k, pair in enumerate(map(tuple, pairs.tolist()))}
    near = [set() for _ in range(m)]
    for i, j in beside:
        near[i].add(j)
        near[j].add(i)
    ways = [
        (k, number[other])
        for (i, j), k in number.items()
        for other in [*((there, j) for there in near[i]), *((i, there) for there in near[j])]
        if other in number
    ]
    i, j = np.array(ways, dtype=np.int64).reshape(-1, 2).T
    graph = sparse.csr_array((np.ones(len(i)), (i, j)), shape=(len(pairs),) * 2)
    _, label = csgraph.connected_components(graph)
    mirror = np.array([number[j, i] for i, j in number])
    label = np.minimum(label, label[mirror])
    overlaps = sorted(set(label.tolist()), key=lambda own: (-np.sum(label == own), np.argmax(label == own)))
    sheets = []
    for own in overlaps[:most]:
        seed = int(np.argmax(label == own))
        reached = csgraph.breadth_first_order(graph, seed, return_predecessors=False)
        when = np.full((2, m), len(reached))
        for side in range(2):
            np.minimum.at(when[side], pairs[reached, side], np.arange(len(reached)))
        met = when.max(axis=0).min()
        grown = when < (met if met == len(reached) else ROOM * met)
        sheet = np.where(grown[0], 1, 2 * grown[1])
        sheet[pairs[seed]] = 1, 2
        for face in pairs[seed]:
            inside = sheet == sheet[face]
            same = [(i, j) for i, j in beside if inside[i] and inside[j]]
            a, b = np.array(same, dtype=np.int64).reshape(-1, 2).T
            joined = sparse.coo_array((np.ones(len(a)), (a, b)), shape=(m, m))
            _, piece = csgraph.connected_components(joined, directed=False)
            sheets.append(np.flatnonzero(piece == piece[face]).tolist())
    return sheets


def taken(points, page):
    """Return the smallest area of a bounding rectangle in a few directions; long rectangles are penalized."""
    along = np.exp(-2j * np.pi * np.arange(DIRECTIONS) / DIRECTIONS)
    far = (points[:, None] * along).real.max(axis=0).reshape(4, -1)
    sides = np.array([far[0] + far[2], far[1] + far[3]])
    return np.maximum(sides.prod(axis=0), LONG * (sides.max(axis=0) ** 2 / 2 - page)).min()


def merge_regions(regions, depths, pairs, turns, shifts, worths, pages):
    """Merge regions along hinges in the given order; return the chart and the motion of each region."""
    n = len(regions)
    chart, turn, shift = np.arange(n), np.ones(n, dtype=complex), np.zeros(n, dtype=complex)
    corner = [
        np.array([complex(x, y) for x in (r.real.min(), r.real.max()) for y in (r.imag.min(), r.imag.max())])
        for r in regions
    ]
    for (a, b), own_turn, own_shift, worth, page in zip(pairs, turns, shifts, worths, pages, strict=True):
        here, there = chart[a], chart[b]
        if here == there:
            continue
        by = turn[a] * own_turn / turn[b]
        to = turn[a] * own_shift + shift[a] - by * shift[b]
        fixed, moving = np.flatnonzero(chart == here), np.flatnonzero(chart == there)
        if len(fixed) < len(moving):
            here, fixed, moving, by, to = there, moving, fixed, 1 / by, -to / by
        moved = {r: (by * turn[r], by * shift[r] + to) for r in moving}
        one = np.concatenate([turn[r] * corner[r] + shift[r] for r in fixed])
        other = np.concatenate([turn[r] * corner[r] + shift[r] for r in moving])
        both = np.append(one, by * other + to)
        if taken(both, page) - taken(one, page) - taken(other, page) > worth:
            continue
        if any(
            overlap_of(turn[r] * t + shift[r], moved[s][0] * u + moved[s][1], min(d, e))
            for r in fixed
            for s in moving
            for t, d in zip(regions[r], depths[r], strict=True)
            for u, e in zip(regions[s], depths[s], strict=True)
            if d >= 0 and e >= 0
        ):
            continue
        for s in moving:
            (turn[s], shift[s]), chart[s] = moved[s], here
    return chart, turn, shift
