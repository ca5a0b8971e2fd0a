"""The reduced system S and the Laplacian L_s: entries of edges and vertices, products with a vector."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from .._types import FloatArray, IntArray
from .choice import with_loops
from .triangles import NEXT, PREV, sum_by


def _pair_weights(w: FloatArray, d: FloatArray) -> FloatArray:
    made = np.empty_like(w)
    for t in range(w.shape[1]):
        for k in range(3):
            made[k, t] = w[(k + 1) % 3, t] * w[(k + 2) % 3, t] / d[t]
    return made


@with_loops(_pair_weights)
def pair_weights(w: FloatArray, d: FloatArray) -> FloatArray:
    """w_i w_j / d, (3, #F), k opposite to i and j: y^T P y sums this times (y_i - y_j)^2 over pairs."""
    return np.asarray(w[NEXT] * w[PREV] / d)


def _conformal_weights(w: FloatArray, d: FloatArray, cot: FloatArray) -> FloatArray:
    made = np.empty_like(w)
    for t in range(w.shape[1]):
        scale = 2 * np.sqrt(w[0, t] * w[1, t] * w[2, t] / d[t])
        for k in range(3):
            made[k, t] = cot[k, t] * scale
    return made


@with_loops(_conformal_weights)
def conformal_weights(w: FloatArray, d: FloatArray, cot: FloatArray) -> FloatArray:
    """Twice what each half-edge gives to the Laplacian sum of s K, (3, #F); s = 2 sqrt(w0 w1 w2 / d)."""
    return np.asarray(cot * np.asarray(2 * np.sqrt(w.prod(axis=0) / d)))


def _own_blocks(corner: IntArray, cot: FloatArray, pair: FloatArray, n: int) -> FloatArray:
    made = np.zeros((3, n))
    for t in range(corner.shape[1]):
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            v, cn, cp = corner[k, t], cot[i, t], cot[j, t]
            opposite, beside_p, beside_n = pair[k, t], pair[i, t], pair[j, t]
            made[0, v] += beside_n + beside_p
            made[1, v] += beside_p * cp - beside_n * cn
            made[2, v] += opposite * (cn + cp) ** 2 + beside_n * cn**2 + beside_p * cp**2
    return made


@with_loops(_own_blocks)
def own_blocks(corner: IntArray, cot: FloatArray, pair: FloatArray, n: int) -> FloatArray:
    """What the corners of each vertex give to its own block of S, (3, n).

    The rows are (vertex, vertex), (vertex, wheel), (wheel, wheel).
    """
    cn, cp, opposite = cot[NEXT], cot[PREV], pair
    beside_p, beside_n = pair[NEXT], pair[PREV]  # of corners k and k - 1, of k and k + 1
    own = (
        beside_n + beside_p,
        beside_p * cp - beside_n * cn,
        opposite * (cn + cp) ** 2 + beside_n * cn**2 + beside_p * cp**2,
    )
    return np.stack([sum_by(corner, values, n) for values in own])


def _edge_blocks(cot: FloatArray, pair: FloatArray, upward: IntArray) -> FloatArray:
    m, size = cot.shape[1], upward.shape[1]
    made = np.empty((4, size))
    for p in range(size):
        vv = vw = wv = ww = 0.0
        for s in range(2):
            h = upward[s, p]
            if h < 0:
                continue
            k = h // m
            t = h - k * m
            i, j = (k + 1) % 3, (k + 2) % 3
            c, cn, cp, opposite = cot[k, t], cot[i, t], cot[j, t], pair[k, t]
            to_a, to_b = pair[j, t] * (c + cn), pair[i, t] * (c + cp)
            first, last = -opposite * cn - to_a, opposite * cp + to_b
            vv += -opposite
            if s == 0:
                vw += first
                wv += last
            else:
                vw += last
                wv += first
            ww += opposite * cn * cp - c * (to_a + to_b)
        made[0, p], made[1, p], made[2, p], made[3, p] = vv, vw, wv, ww
    return made


@with_loops(_edge_blocks)
def edge_blocks(cot: FloatArray, pair: FloatArray, upward: IntArray) -> FloatArray:
    """Blocks of S between the ends of edges, by their half-edges `upward`, (2, #P), -1 for a missing one.

    Returns (4, #P): (vertex, vertex), (vertex, wheel), (wheel, vertex), (wheel, wheel), the first at the
    tail of the first half-edge.
    """
    across = half_edge_blocks(cot, pair).reshape(4, -1)
    if upward.min(initial=0) < 0:  # edges of the boundary between two rows
        across = np.column_stack((across, np.zeros(4)))
    (vv, vw, wv, ww), (h, r) = across, upward  # r runs the other way, where the block is transposed
    return np.stack((vv[h] + vv[r], vw[h] + wv[r], wv[h] + vw[r], ww[h] + ww[r]))


def half_edge_blocks(cot: FloatArray, pair: FloatArray) -> FloatArray:
    """The blocks between tail and head of each half-edge, that opposite to corner k, (4, 3, #F)."""
    cn, cp, opposite = cot[NEXT], cot[PREV], pair
    to_a, to_b = pair[PREV] * (cot + cn), pair[NEXT] * (cot + cp)
    return np.stack(
        (
            -opposite,
            -opposite * cn - to_a,
            opposite * cp + to_b,
            opposite * cn * cp - cot * (to_a + to_b),
        )
    )


def _at_edges(values: FloatArray, sides: IntArray) -> FloatArray:
    flat, size = values.ravel(), sides.shape[1]
    made = np.empty(size)
    for i in range(size):
        made[i] = flat[sides[0, i]]
        if sides[1, i] >= 0:
            made[i] += flat[sides[1, i]]
    return made


@with_loops(_at_edges)
def at_edges(values: FloatArray, sides: IntArray) -> FloatArray:
    """Sum values of half-edges, (3, #F), over the two sides of each edge, (2, #E), -1 for a missing one."""
    first, second = np.append(values, 0.0)[sides]  # a missing side reads the zero at the end
    return np.asarray(first + second)


def _degrees(ends: IntArray, weight: FloatArray, n: int) -> FloatArray:
    made = np.zeros(n)
    for e in range(ends.shape[1]):
        i, j = ends[0, e], ends[1, e]
        if i != j:
            if i >= 0:
                made[i] += weight[e]
            if j >= 0:
                made[j] += weight[e]
    return made


@with_loops(_degrees)
def degrees(ends: IntArray, weight: FloatArray, n: int) -> FloatArray:
    """The diagonal of the Laplacian with `weight` at the edges between rows `ends`, (2, #E), -1 for none."""
    i, j = ends
    across = np.where(i == j, 0.0, weight)
    return sum_by(i + 1, across, n + 1)[1:] + sum_by(j + 1, across, n + 1)[1:]


def _disparity(w: FloatArray, d: FloatArray, cot: FloatArray) -> FloatArray:
    m = w.shape[1]
    made = np.empty(m)
    for t in range(m):
        a, b, c = w[0, t], w[1, t], w[2, t]
        x, y, z = cot[0, t], cot[1, t], cot[2, t]
        pa, pb, pc = b * c / d[t], c * a / d[t], a * b / d[t]
        kp = 0.5 * ((y + z) * (pb + pc) + (z + x) * (pc + pa) + (x + y) * (pa + pb))
        kp += x * pa + y * pb + z * pc
        trace = ((x + y + z) * 2 * (pa + pb + pc) - kp) / 0.75
        made[t] = trace**2 * d[t] / (4 * a * b * c) - 2
    return made


@with_loops(_disparity)
def disparity(w: FloatArray, d: FloatArray, cot: FloatArray) -> FloatArray:
    """rho + 1 / rho of each triangle, rho the ratio of the eigenvalues of P and s K in it, (#F,)."""
    pair = pair_weights(w, d)
    # tr(K+ P) = (tr K tr P - tr K P) / (3/4), det = 4 w0 w1 w2 / d on the plane sum e = 0
    p = pair[NEXT] + pair[PREV]
    kp = 0.5 * ((cot[NEXT] + cot[PREV]) * p).sum(axis=0) + (cot * pair).sum(axis=0)
    trace = (cot.sum(axis=0) * p.sum(axis=0) - kp) / 0.75
    return np.asarray(trace**2 * d / (4 * w.prod(axis=0)) - 2)


def _filled_blocks(
    size: int, slot: IntArray, block: FloatArray, own: IntArray, diagonal: FloatArray
) -> FloatArray:
    made = np.zeros((size, 4))
    for p in range(len(slot)):
        for k in range(4):
            made[slot[p], k] += block[k, p]
    for i in range(len(own)):
        for k in range(4):
            made[own[i], k] += diagonal[k, i] / 2
    return made


@with_loops(_filled_blocks)
def filled_blocks(
    size: int, slot: IntArray, block: FloatArray, own: IntArray, diagonal: FloatArray
) -> FloatArray:
    """Blocks, (size, 4): `block`, (4, #slots), summed at `slot`, and half of `diagonal`, (4, n), at `own`."""
    made = np.zeros((size, 4))
    np.add.at(made, slot, block.T)
    made[own] += diagonal.T / 2
    return made


def _block_product(indptr: IntArray, indices: IntArray, block: FloatArray, x: FloatArray) -> FloatArray:
    y = np.zeros_like(x)
    for i in range(len(indptr) - 1):
        u, v = x[2 * i], x[2 * i + 1]
        s = t = 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            a, b, c, d = block[k, 0], block[k, 1], block[k, 2], block[k, 3]
            p, q = x[2 * j], x[2 * j + 1]
            s += a * p + b * q
            t += c * p + d * q
            y[2 * j] += a * u + c * v
            y[2 * j + 1] += b * u + d * v
        y[2 * i] += s
        y[2 * i + 1] += t
    return y


@with_loops(_block_product)
def block_product(indptr: IntArray, indices: IntArray, block: FloatArray, x: FloatArray) -> FloatArray:
    """(U + U^T) x, U of 2 by 2 blocks: `block`, (#blocks, 4), at rows and columns as in CSR."""
    upper = sparse.bsr_array((block.reshape(-1, 2, 2), indices, indptr), shape=(len(x), len(x)))
    return np.asarray(upper @ x + upper.T @ x)
