"""Solves of systems of small meshes side by side: by their factors, and by conjugate gradients."""

from __future__ import annotations

import numpy as np

from .._types import BoolArray, FloatArray, IntArray
from .choice import compiled, inlined, with_loops
from .cholesky import Factor, Index
from .triangles import NEXT, PREV, row_sums


@inlined
def _substituted(
    first: int,
    last: int,
    order: Index,
    indptr: Index,
    rows: Index,
    below: FloatArray,
    diagonal: FloatArray,
    b: FloatArray,
    y: FloatArray,
    x: FloatArray,
) -> None:
    """Solve the blocks of the rows `first` to `last` for two right sides, into `x`; `y` is work space."""
    for k in range(first, last):
        y[k, 0], y[k, 1] = b[order[k], 0], b[order[k], 1]
    for k in range(first, last):
        u, v = y[k, 0], y[k, 1]
        for p in range(indptr[k], indptr[k + 1]):
            y[rows[p], 0] -= below[p] * u
            y[rows[p], 1] -= below[p] * v
    for i in range(last - first):
        k = last - 1 - i
        u, v = y[k, 0] / diagonal[k], y[k, 1] / diagonal[k]
        for p in range(indptr[k], indptr[k + 1]):
            u -= below[p] * y[rows[p], 0]
            v -= below[p] * y[rows[p], 1]
        y[k, 0], y[k, 1] = u, v
        x[order[k], 0], x[order[k], 1] = u, v


def _solved(
    order: Index, indptr: Index, rows: Index, below: FloatArray, diagonal: FloatArray, b: FloatArray
) -> FloatArray:
    x = np.empty_like(b)
    _substituted(0, len(order), order, indptr, rows, below, diagonal, b, np.empty_like(b), x)
    return x


def solved(factor: Factor, b: FloatArray) -> FloatArray:
    """Solve A x = b for two right sides, (n, 2)."""
    s = factor.symbolic
    x: FloatArray = compiled(_solved)(s.order, s.indptr, s.rows, factor.below, factor.diagonal, b)
    return x


@inlined
def _fan_sums(
    first: int, last: int, row: IntArray, pair: FloatArray, cot: FloatArray, x: FloatArray, y: FloatArray
) -> None:
    """Add M P M^T x of the triangles `first` to `last` to `y`, both (#rows + 1, 2)."""
    for t in range(first, last):
        a, b, c = row[0, t], row[1, t], row[2, t]
        p, q, r = cot[0, t], cot[1, t], cot[2, t]
        u = x[a, 0] + p * (x[c, 1] - x[b, 1])
        v = x[b, 0] + q * (x[a, 1] - x[c, 1])
        w = x[c, 0] + r * (x[b, 1] - x[a, 1])
        f, g, h = pair[2, t] * (u - v), pair[0, t] * (v - w), pair[1, t] * (w - u)
        u, v, w = f - h, g - f, h - g  # the errors
        p, q, r = p * u, q * v, r * w
        y[a, 0] += u
        y[b, 0] += v
        y[c, 0] += w
        y[a, 1] += q - r
        y[b, 1] += r - p
        y[c, 1] += p - q


def _fan_product(row: IntArray, pair: FloatArray, cot: FloatArray, x: FloatArray) -> FloatArray:
    n, m = len(x) // 2, row.shape[1]
    padded, y = np.zeros((n + 1, 2)), np.zeros((n + 1, 2))
    padded[:n] = x.reshape(n, 2)
    _fan_sums(0, m, row, pair, cot, padded, y)
    return y[:n].copy().ravel()


@with_loops(_fan_product)
def fan_product(row: IntArray, pair: FloatArray, cot: FloatArray, x: FloatArray) -> FloatArray:
    """S x = M P M^T x without S; `row` is that of each corner, (3, #F), #rows for none; x is (2 #rows,).

    `pair` are P's `pair_weights`.
    """
    vertex, wheel = (np.append(x[k::2], 0.0).take(row) for k in (0, 1))
    y = vertex + cot * (wheel[PREV] - wheel[NEXT])
    along = pair * (y[NEXT] - y[PREV])
    sums = row_sums(row, cot, along[PREV] - along[NEXT], len(x) // 2 + 1)
    return np.column_stack([values[:-1] for values in sums]).ravel()


def _gradients(
    row_start: IntArray,
    face_start: IntArray,
    row: IntArray,
    pair: FloatArray,
    cot: FloatArray,
    b: FloatArray,
    rtol: float,
    most: int,
    order: Index,
    indptr: Index,
    rows: Index,
    below: FloatArray,
    diagonal: FloatArray,
) -> tuple[FloatArray, IntArray, BoolArray]:
    n, size = len(b), len(row_start) - 1
    x, r, p, q = np.zeros((n, 2)), b.copy(), np.zeros((n + 1, 2)), np.empty((n + 1, 2))
    z, work = np.empty((n, 2)), np.empty((n, 2))
    steps, converged = np.zeros(size, dtype=np.int64), np.zeros(size, dtype=np.bool_)
    for k in range(size):
        first, last = row_start[k], row_start[k + 1]
        norm = 0.0
        for i in range(first, last):
            norm += b[i, 0] * b[i, 0] + b[i, 1] * b[i, 1]
        goal, rho_before = rtol * np.sqrt(norm), 1.0
        converged[k] = goal == 0
        while steps[k] < most and not converged[k]:
            if np.sqrt(norm) < goal:
                converged[k] = True
            if converged[k] or not np.isfinite(norm):
                break
            _substituted(first, last, order, indptr, rows, below, diagonal, r, work, z)
            rho = 0.0
            for i in range(first, last):
                rho += r[i, 0] * z[i, 0] + r[i, 1] * z[i, 1]
            share = rho / rho_before
            for i in range(first, last):
                for j in range(2):
                    p[i, j] = z[i, j] + share * p[i, j]
                    q[i, j] = 0.0
            _fan_sums(face_start[k], face_start[k + 1], row, pair, cot, p, q)
            curvature = 0.0
            for i in range(first, last):
                curvature += p[i, 0] * q[i, 0] + p[i, 1] * q[i, 1]
            length, norm = rho / curvature, 0.0
            for i in range(first, last):
                for j in range(2):
                    x[i, j] += length * p[i, j]
                    r[i, j] -= length * q[i, j]
                    norm += r[i, j] * r[i, j]
            rho_before = rho
            steps[k] += 1
        for i in range(first, last):
            converged[k] &= np.isfinite(x[i, 0]) and np.isfinite(x[i, 1])
    return x, steps, converged


def fan_gradients(
    row_start: IntArray,
    face_start: IntArray,
    row: IntArray,
    pair: FloatArray,
    cot: FloatArray,
    b: FloatArray,
    factor: Factor,
    rtol: float,
    most: int,
) -> tuple[FloatArray, IntArray, BoolArray]:
    """Conjugate gradients of each mesh for itself, S by `fan_product`, and `factor` the preconditioner's.

    Mesh k has the rows `row_start[k]` to `row_start[k + 1]`, and such triangles. Returns x, as b,
    the steps of each mesh, and whether it converged.
    """
    s, pairs = factor.symbolic, b.reshape(-1, 2)
    system = (row_start, face_start, row, pair, cot, pairs, rtol, most)
    x, steps, converged = compiled(_gradients)(
        *system, s.order, s.indptr, s.rows, factor.below, factor.diagonal
    )
    return x.ravel(), steps, converged
