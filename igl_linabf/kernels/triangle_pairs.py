"""Pairs of triangles in the plane that lie over each other."""

import numpy as np
import shapely

from .._types import ComplexArray, FloatArray, IntArray
from .choice import inlined, with_loops
from .maps import signed_double_areas

LEAF = 8  # triangles at a leaf of the tree of boxes
MIN_DEPTH = 1e-6  # of a triangle's height: what lies deeper than that in another one is an overlap
ROUNDING = 16 * np.finfo(float).eps  # of a corner, as a share of how far it is from the origin
BLOCK_SIZE = 1 << 16  # triangles that are sought in the tree at a time, which bounds the memory


@inlined
def _boxes(triangle: ComplexArray, leaves: int) -> tuple[FloatArray, FloatArray]:
    """Around each triangle, and around each node of a binary tree: node k is above 2 k and 2 k + 1."""
    n = len(triangle)
    box, node = np.empty((n, 4)), np.full((2 * leaves, 4), np.inf)  # the lower left corner, the upper right
    node[:, 2:] = -np.inf
    for t in range(n):
        a, b, c = triangle[t]
        box[t, 0], box[t, 1] = min(a.real, b.real, c.real), min(a.imag, b.imag, c.imag)
        box[t, 2], box[t, 3] = max(a.real, b.real, c.real), max(a.imag, b.imag, c.imag)
        leaf = leaves + t // LEAF
        for k in range(2):
            node[leaf, k] = min(node[leaf, k], box[t, k])
            node[leaf, 2 + k] = max(node[leaf, 2 + k], box[t, 2 + k])
    for at in range(leaves - 1, 0, -1):
        for k in range(2):
            node[at, k] = min(node[2 * at, k], node[2 * at + 1, k])
            node[at, 2 + k] = max(node[2 * at, 2 + k], node[2 * at + 1, 2 + k])
    return box, node


@inlined
def _touch(box: FloatArray, i: int, j: int) -> bool:
    """Whether two boxes have a point in common; without branches, whose outcome no processor foresees."""
    touch: bool = (box[i, 0] <= box[j, 2]) & (box[j, 0] <= box[i, 2])
    touch &= (box[i, 1] <= box[j, 3]) & (box[j, 1] <= box[i, 3])
    return touch


@inlined
def _reaches(triangle: ComplexArray, inward: ComplexArray, i: int, j: int, least: float) -> bool:
    """Whether triangle j reaches across all sides of triangle i by more than `least`."""
    for k in range(3):
        start, by, reaches = triangle[i, k], inward[i, k], False
        for corner in range(3):
            step = triangle[j, corner] - start
            reaches |= by.real * step.imag + by.imag * step.real > least
        if not reaches:
            return False
    return True


def _overlapping(triangle: ComplexArray, end: IntArray, depth: FloatArray, rounding: FloatArray) -> IntArray:
    n, leaves = len(triangle), 1
    while leaves * LEAF < n:
        leaves *= 2
    box, node = _boxes(triangle, leaves)
    inward = np.empty_like(triangle)
    for t in range(n):
        for k in range(3):
            side = triangle[t, (k + 1) % 3] - triangle[t, k]
            inward[t, k] = np.conj(side) / np.sqrt(side.real**2 + side.imag**2)
    begin = np.empty(2 * leaves, dtype=np.int64)  # the first triangle below each node
    for at in range(2 * leaves - 1, 0, -1):
        begin[at] = (at - leaves) * LEAF if at >= leaves else begin[2 * at]
    found, size, stack = np.empty((64, 2), dtype=np.int64), 0, np.empty(128, dtype=np.int64)
    for first in range(0, n, LEAF):
        last = end[first : first + LEAF].max()
        if last <= first + 1:
            continue
        own = leaves + first // LEAF
        stack[0], top, up = own, 1, own
        while up > 1:  # what comes after the leaf is on the right of the way to the root
            if up & 1 == 0 and begin[up + 1] < last and _touch(node, own, up + 1):
                stack[top] = up + 1
                top += 1
            up >>= 1
        while top:
            top -= 1
            at = stack[top]
            if at < leaves:
                for below in range(2 * at, 2 * at + 2):
                    if begin[below] < last and _touch(node, own, below):
                        stack[top] = below
                        top += 1
                continue
            other = (at - leaves) * LEAF
            for i in range(first, min(first + LEAF, n)):
                for j in range(max(i + 1, other), min(other + LEAF, end[i])):
                    if not _touch(box, i, j):
                        continue
                    least = min(depth[i], depth[j]) + max(rounding[i], rounding[j])
                    if not _reaches(triangle, inward, i, j, least):
                        continue
                    if not _reaches(triangle, inward, j, i, least):
                        continue
                    if size == len(found):
                        found = np.concatenate((found, np.empty_like(found)))
                    found[size, 0], found[size, 1] = i, j
                    size += 1
    return found[:size].copy()


@with_loops(_overlapping)
def overlapping(triangle: ComplexArray, end: IntArray, depth: FloatArray, rounding: FloatArray) -> IntArray:
    """The pairs i < j < end[i] of counter-clockwise triangles, (#T, 3), that no side separates; in any order.

    Each of the two has to reach across all sides of the other by the smaller of their depths, and by their
    rounding. Triangles that follow each other should be near each other: then this is fast.
    """
    x, y = triangle.real, triangle.imag
    boxes = shapely.box(x.min(axis=1), y.min(axis=1), x.max(axis=1), y.max(axis=1))
    tree = shapely.STRtree(boxes)
    side = np.roll(triangle, -1, axis=1) - triangle
    inward = (side / np.abs(side)).conj()
    found = [np.zeros((0, 2), dtype=np.int64)]
    for start in range(0, len(triangle), BLOCK_SIZE):
        i, j = tree.query(boxes[start : start + BLOCK_SIZE])
        i = i + start
        pairs = np.column_stack((i, j))[(i < j) & (j < end[i])]
        for order in ((0, 1), (1, 0)):
            for k in range(3):
                i, j = pairs[:, order].T
                reach = (inward[i, k] * (triangle[j, 0] - triangle[i, k])).imag
                for corner in (1, 2):
                    np.maximum(reach, (inward[i, k] * (triangle[j, corner] - triangle[i, k])).imag, out=reach)
                least = np.minimum(depth[i], depth[j]) + np.maximum(rounding[i], rounding[j])
                pairs = pairs[reach > least]
        found.append(pairs)
    return np.concatenate(found)


def solid_triangles(triangle: ComplexArray) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """Triangles, (#T, 3), all turned counter-clockwise; their heights, and the rounding of their corners."""
    area = signed_double_areas(triangle.T.ravel(), np.arange(triangle.size).reshape(3, -1))
    triangle[area < 0] = triangle[area < 0][:, [0, 2, 1]]
    longest = np.abs(triangle - np.roll(triangle, 1, axis=1)).max(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        height = np.where(longest > 0, np.abs(area) / longest, 0.0)
    return triangle, height, ROUNDING * np.abs(triangle).max(axis=1)


@inlined
def _solid(triangle: ComplexArray, inward: ComplexArray) -> tuple[float, float]:
    """The height of a triangle that is turned counter-clockwise, and its rounding; and its sides' normals."""
    one, other = triangle[1] - triangle[0], triangle[2] - triangle[0]
    area = one.real * other.imag - one.imag * other.real
    if area < 0:
        triangle[1], triangle[2] = triangle[2], triangle[1]
    longest, far = 0.0, 0.0
    for k in range(3):
        side, at = triangle[(k + 1) % 3] - triangle[k], triangle[k]
        length = np.sqrt(side.real**2 + side.imag**2)
        inward[k] = np.conj(side) / length if length > 0 else 0j
        longest, far = max(longest, length), max(far, np.sqrt(at.real**2 + at.imag**2))
    return (abs(area) / longest if longest > 0 else 0.0), ROUNDING * far


def _lie_over(some: ComplexArray, others: ComplexArray) -> bool:
    n = len(some)
    pair, inward = np.empty((n + 1, 3), dtype=np.complex128), np.empty((n + 1, 3), dtype=np.complex128)
    box, height, rounding = np.empty((n + 1, 4)), np.empty(n + 1), np.empty(n + 1)
    around = np.array([np.inf, np.inf, -np.inf, -np.inf])
    for j in range(n + len(others)):  # each of some comes to its row, and the others one by one to the last
        at = min(j, n)
        a, b, c = some[j] if j < n else others[j - n]
        box[at, 0], box[at, 1] = min(a.real, b.real, c.real), min(a.imag, b.imag, c.imag)
        box[at, 2], box[at, 3] = max(a.real, b.real, c.real), max(a.imag, b.imag, c.imag)
        if j < n:
            for k in range(2):
                around[k] = min(around[k], box[at, k])
                around[2 + k] = max(around[2 + k], box[at, 2 + k])
        elif box[n, 0] > around[2] or box[n, 2] < around[0] or box[n, 1] > around[3] or box[n, 3] < around[1]:
            continue
        pair[at, 0], pair[at, 1], pair[at, 2] = a, b, c
        height[at], rounding[at] = _solid(pair[at], inward[at])
        if height[at] <= rounding[at]:
            continue
        for i in range(at):
            if height[i] > rounding[i] and _touch(box, i, at):
                least = MIN_DEPTH * min(height[i], height[at]) + max(rounding[i], rounding[at])
                if _reaches(pair, inward, i, at, least) and _reaches(pair, inward, at, i, least):
                    return True
    return False


@with_loops(_lie_over)
def lie_over(some: ComplexArray, others: ComplexArray) -> bool:
    """Whether one of some triangles, (#S, 3), overlaps another one of them, or one of others, (#O, 3)."""
    x, y = others.real, others.imag
    near = (x.min(axis=1) <= some.real.max()) & (x.max(axis=1) >= some.real.min())
    near &= (y.min(axis=1) <= some.imag.max()) & (y.max(axis=1) >= some.imag.min())
    triangle, height, rounding = solid_triangles(np.concatenate((some, others[near])))
    solid = np.flatnonzero(height > rounding)
    end = np.where(solid < len(some), len(solid), 0)
    return len(overlapping(triangle[solid], end, MIN_DEPTH * height[solid], rounding[solid])) > 0
