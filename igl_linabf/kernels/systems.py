"""The reduced system S and the Laplacian L_s: entries of edges and vertices."""

import numpy as np
from scipy import sparse

from .._runtime import unfilled
from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from .choice import filled_by, inlined, with_loops
from .triangles import NEXT, PREV, sum_by

Block = tuple[float, float, float, float]
Entries = tuple[IntArray, IntArray, IntArray]


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


def _conformal_weights(
    w: FloatArray, d: FloatArray, cot: FloatArray, first: int, last: int, made: FloatArray
) -> None:
    for t in range(first, last):
        scale = 2 * np.sqrt(w[0, t] * w[1, t] * w[2, t] / d[t])
        for k in range(3):
            made[k, t] = cot[k, t] * scale


@filled_by(_conformal_weights, lambda w, *_: unfilled(w.shape))
def conformal_weights(w: FloatArray, d: FloatArray, cot: FloatArray) -> FloatArray:
    """Twice what each half-edge gives to the Laplacian sum of s K, (3, #F); s = 2 sqrt(w0 w1 w2 / d)."""
    return np.asarray(cot * np.asarray(2 * np.sqrt(w.prod(axis=0) / d)))


def half_edge_blocks(cot: FloatArray, pair: FloatArray) -> FloatArray:
    """The blocks between tail and head of each half-edge, that opposite to corner k, (4, 3, #F)."""
    cn, cp, opposite = cot[NEXT], cot[PREV], pair
    to_a, to_b = pair[PREV] * (cot + cn), pair[NEXT] * (cot + cp)
    return np.stack(
        (-opposite, -opposite * cn - to_a, opposite * cp + to_b, opposite * cn * cp - cot * (to_a + to_b))
    )


def _at_edges(values: FloatArray, sides: IntArray, first: int, last: int, made: FloatArray) -> None:
    flat = values.ravel()
    for i in range(first, last):
        made[i] = flat[sides[0, i]]
        if sides[1, i] >= 0:
            made[i] += flat[sides[1, i]]


@filled_by(_at_edges, lambda values, sides: unfilled(sides.shape[1]))
def at_edges(values: FloatArray, sides: IntArray) -> FloatArray:
    """Sum values of half-edges, (3, #F), over the two sides of each edge, (2, #E), -1 for a missing one."""
    first, second = np.append(values, 0.0)[sides]  # a missing side reads the zero at the end
    return np.asarray(first + second)


def _laplacian_entries(
    indptr: IntArray, slot: IntArray, ends: IntArray, weight: FloatArray, made: FloatArray
) -> None:
    made[:] = 0.0
    for e in range(ends.shape[1]):
        i, j = ends[0, e], ends[1, e]
        if i == j:
            continue
        if i >= 0:
            made[indptr[i]] += weight[e]
        if j >= 0:
            made[indptr[j]] += weight[e]
        if slot[e] >= 0:
            made[slot[e]] -= weight[e]


@filled_by(_laplacian_entries, lambda indptr, *_: unfilled(int(indptr[-1])), in_pieces=False)
def laplacian_entries(indptr: IntArray, slot: IntArray, ends: IntArray, weight: FloatArray) -> FloatArray:
    """The entries of the Laplacian with `weight` at the edges between rows `ends`, (2, #E), -1 for none.

    `indptr` and `slot` are those of `entries`.
    """
    n, across = len(indptr) - 1, np.where(ends[0] == ends[1], 0.0, weight)
    made = -sum_by(slot + 1, weight, indptr[-1] + 1)[1:]
    made[indptr[:-1]] = sum(sum_by(rows + 1, across, n + 1)[1:] for rows in ends)
    return made


def _product_inside(
    indptr: IntArray, indices: IntArray, data: FloatArray, inside: BoolArray, x: FloatArray
) -> FloatArray:
    made = np.zeros(len(x))
    for j in range(len(x)):
        if not inside[j]:
            continue
        total = data[indptr[j]] * x[j]
        for at in range(indptr[j] + 1, indptr[j + 1]):
            i = indices[at]
            if inside[i]:
                made[i] += data[at] * x[j]
                total += data[at] * x[i]
        made[j] += total
    return made


@with_loops(_product_inside)
def product_inside(
    indptr: IntArray, indices: IntArray, data: FloatArray, inside: BoolArray, x: FloatArray
) -> FloatArray:
    """The rows and columns `inside` of a symmetric matrix times x; 0 in the other rows.

    The lower triangle is given as in CSC, each column with its diagonal first.
    """
    lower = sparse.csc_array((data, indices, indptr), shape=(len(x), len(x)))
    x = np.where(inside, x, 0.0)
    return np.where(inside, lower @ x + lower.T @ x - data[indptr[:-1]] * x, 0.0)


def _pulled(ends: IntArray, edges: IntArray, weight: FloatArray, z: ComplexArray, n: int) -> FloatArray:
    made = np.zeros((n, 2))
    for e in range(ends.shape[1]):
        for s in range(2):
            i, fixed = ends[s, e], z[edges[e, 1 - s]]
            if i >= 0:
                made[i, 0] += weight[e] * fixed.real
                made[i, 1] += weight[e] * fixed.imag
    return made


@with_loops(_pulled)
def pulled(ends: IntArray, edges: IntArray, weight: FloatArray, z: ComplexArray, n: int) -> FloatArray:
    """What fixed vertices add to L x: sum of weight z over the edges to them, (n, 2); z is zero at others."""
    at = z[edges]
    near = np.flatnonzero(at.any(axis=1))
    (a, b), weight, rows = at[near].T, weight[near], ends[:, near] + 1
    parts = ((weight * a.real, weight * b.real), (weight * a.imag, weight * b.imag))
    sums = [sum_by(rows[0], to, n + 1) + sum_by(rows[1], of, n + 1) for of, to in parts]
    return np.column_stack(sums)[1:]


def _disparity(
    w: FloatArray, d: FloatArray, cot: FloatArray, first: int, last: int, made: FloatArray
) -> None:
    for t in range(first, last):
        a, b, c = w[0, t], w[1, t], w[2, t]
        x, y, z = cot[0, t], cot[1, t], cot[2, t]
        pa, pb, pc = b * c / d[t], c * a / d[t], a * b / d[t]
        kp = 0.5 * ((y + z) * (pb + pc) + (z + x) * (pc + pa) + (x + y) * (pa + pb))
        kp += x * pa + y * pb + z * pc
        trace = ((x + y + z) * 2 * (pa + pb + pc) - kp) / 0.75
        made[t] = trace**2 * d[t] / (4 * a * b * c) - 2


@filled_by(_disparity, lambda w, d, cot: unfilled(len(d)))
def disparity(w: FloatArray, d: FloatArray, cot: FloatArray) -> FloatArray:
    """rho + 1 / rho of each triangle, rho the ratio of the eigenvalues of P and s K in it, (#F,)."""
    pair = pair_weights(w, d)
    # tr(K+ P) = (tr K tr P - tr K P) / (3/4), det = 4 w0 w1 w2 / d on the plane sum e = 0
    p = pair[NEXT] + pair[PREV]
    kp = 0.5 * ((cot[NEXT] + cot[PREV]) * p).sum(axis=0) + (cot * pair).sum(axis=0)
    trace = (cot.sum(axis=0) * p.sum(axis=0) - kp) / 0.75
    return np.asarray(trace**2 * d / (4 * w.prod(axis=0)) - 2)


@inlined
def _half_edge_block(w: FloatArray, d: FloatArray, cot: FloatArray, k: int, t: int) -> Block:
    """`half_edge_blocks` of one of them."""
    i, j = (k + 1) % 3, (k + 2) % 3
    a, b, c = w[k, t], w[i, t], w[j, t]
    x, y, z = cot[k, t], cot[i, t], cot[j, t]
    share = 1 / d[t]
    opposite, to_a, to_b = b * c * share, a * b * share * (x + y), a * c * share * (x + z)
    return -opposite, -opposite * y - to_a, opposite * z + to_b, opposite * y * z - x * (to_a + to_b)


def _system_blocks(
    at: tuple[IntArray, IntArray, IntArray],
    ends: IntArray,
    sides: IntArray,
    corner: IntArray,
    row: IntArray,
    wheels: int,
    w: FloatArray,
    d: FloatArray,
    cot: FloatArray,
    made: FloatArray,
) -> None:
    indptr, indices, slot = at
    n, m = len(indptr) - 1, corner.shape[1]
    made[:] = 0.0
    for e in range(len(slot)):
        i, j = ends[0, e], ends[1, e]
        if i < 0 or j < 0:
            continue
        vv = vw = wv = ww = 0.0
        for s in range(2):
            h = sides[s, e]
            if h < 0:
                continue
            k = int(h >= m) + int(h >= 2 * m)
            block = _half_edge_block(w, d, cot, k, h - k * m)
            vv += block[0]
            vw += block[1 + s]  # the second side runs the other way
            wv += block[2 - s]
            ww += block[3]
        p = slot[e]
        if i == j:
            p, vw = indptr[i], (vw + wv) / 2
            wv = vw
        elif i > j:
            vw, wv = wv, vw
        made[p, 0] += vv
        made[p, 1] += vw
        made[p, 2] += wv
        made[p, 3] += ww
    for t in range(m):
        share = 1 / d[t]
        for k in range(3):
            if row[corner[k, t]] < 0:
                continue
            i, j = (k + 1) % 3, (k + 2) % 3
            a, b, c, y, z = w[k, t] * share, w[i, t], w[j, t], cot[i, t], cot[j, t]
            opposite, beside_n, beside_p = b * c * share, a * b, a * c
            p = indptr[row[corner[k, t]]]
            mixed = (beside_p * z - beside_n * y) / 2
            made[p, 0] += (beside_n + beside_p) / 2
            made[p, 1] += mixed
            made[p, 2] += mixed
            made[p, 3] += (opposite * (y + z) ** 2 + beside_n * y**2 + beside_p * z**2) / 2
    if wheels < n:
        for i in range(n):
            for p in range(indptr[i], indptr[i + 1]):
                if i >= wheels:
                    made[p, 2] = 0.0
                if indices[p] >= wheels:
                    made[p, 1] = made[p, 3] = 0.0
            if i >= wheels:
                made[indptr[i], 3] = 0.5


@filled_by(_system_blocks, lambda at, *_: unfilled((len(at[1]), 4)), in_pieces=False)
def system_blocks(
    at: tuple[IntArray, IntArray, IntArray],
    ends: IntArray,
    sides: IntArray,
    corner: IntArray,
    row: IntArray,
    wheels: int,
    w: FloatArray,
    d: FloatArray,
    cot: FloatArray,
) -> FloatArray:
    """The blocks of S = sum_t M_t P_t M_t^T, (#blocks, 4), in the places `at` of `entries`.

    Those on the diagonal are halved. A block holds (vertex, vertex), (vertex, wheel), (wheel, vertex) and
    (wheel, wheel). From row `wheels` on, the wheel rows are those of the identity. `ends` has the rows of the
    edges, `sides` their half-edges, `row` that of each vertex.
    """
    indptr, indices, slot = at
    n, size, pair = len(indptr) - 1, len(indices), pair_weights(w, d)
    # a missing side reads the zero at the end; the second side runs the other way: its block is transposed
    vv, vw, wv, ww = (np.append(values, 0.0)[sides] for values in half_edge_blocks(cot, pair))
    block = np.stack((vv.sum(axis=0), vw[0] + wv[1], wv[0] + vw[1], ww.sum(axis=0)))
    down, same = ends[0] > ends[1], (ends[0] == ends[1]) & (ends[0] >= 0)
    block[1:3, down] = block[2:0:-1, down]
    block[1:3, same] = block[1:3, same].mean(axis=0)
    place = slot + 1
    place[same] = indptr[ends[0, same]] + 1
    made = np.stack([sum_by(place, values, size + 1)[1:] for values in block])
    cn, cp, beside_p, beside_n = cot[NEXT], cot[PREV], pair[NEXT], pair[PREV]
    mixed = beside_p * cp - beside_n * cn
    own = (beside_n + beside_p, mixed, mixed, pair * (cn + cp) ** 2 + beside_n * cn**2 + beside_p * cp**2)
    made[:, indptr[:-1]] += np.stack([sum_by(row[corner] + 1, values, n + 1)[1:] for values in own]) / 2
    if wheels < n:
        low, high = np.repeat(np.arange(n), np.diff(indptr)) >= wheels, indices >= wheels
        made[1, high] = made[2, low] = made[3, high] = 0.0
        made[3, indptr[wheels:-1]] = 0.5
    return np.ascontiguousarray(made.T)
