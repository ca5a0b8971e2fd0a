"""Solves of systems of small meshes side by side: by their factors, and by conjugate gradients."""

import numpy as np

from .._types import BoolArray, FloatArray, IntArray
from .choice import compiled, inlined, run
from .cholesky import Factor, Index, Symbolic, _factored

Columns = tuple[Index, Index, Index, FloatArray, FloatArray]  # order, indptr, rows; entries of L, and 1 / D
Fans = tuple[Index, FloatArray, FloatArray]  # the row of each corner, `pair_weights`, cotangents; all (3, #F)
Slivers = tuple[IntArray, IntArray, Columns]  # triangles at rows of slivers, these, and the factor of S there


@inlined
def _substituted(factor: Columns, b: FloatArray, y: FloatArray, x: FloatArray) -> None:
    """Solve for two right sides, (n, 2), into `x`; `y` is work space, (2 n,)."""
    order, indptr, rows, below, inverse = factor
    for k in range(len(order)):
        y[2 * k], y[2 * k + 1] = b[order[k], 0], b[order[k], 1]
    for k in range(len(order)):
        u, v = y[2 * k], y[2 * k + 1]
        y[2 * k], y[2 * k + 1] = u * inverse[k], v * inverse[k]
        for p in range(indptr[k], indptr[k + 1]):
            r, entry = 2 * rows[p], below[p]
            y[r], y[r + 1] = y[r] - entry * u, y[r + 1] - entry * v
    for k in range(len(order) - 1, -1, -1):
        u, v, w, z, e = y[2 * k], y[2 * k + 1], 0.0, 0.0, np.int64(indptr[k])
        while e + 1 < indptr[k + 1]:  # two sums, which do not wait for each other
            r, s = rows[e], rows[e + 1]
            u -= below[e] * y[2 * r]
            v -= below[e] * y[2 * r + 1]
            w -= below[e + 1] * y[2 * s]
            z -= below[e + 1] * y[2 * s + 1]
            e += 2
        if e < indptr[k + 1]:
            u -= below[e] * y[2 * rows[e]]
            v -= below[e] * y[2 * rows[e] + 1]
        u += w
        v += z
        y[2 * k], y[2 * k + 1] = u, v
        x[order[k], 0], x[order[k], 1] = u, v


def _solved(factor: Columns, b: FloatArray) -> FloatArray:
    x = np.empty_like(b)
    _substituted(factor, b, np.empty(b.size), x)
    return x


def solved(factor: Factor, b: FloatArray) -> FloatArray:
    """Solve A x = b for two right sides, (n, 2)."""
    x: FloatArray = compiled(_solved)((*factor.symbolic[:3], factor.below, factor.inverse), b)
    return x


def _solved_inside(
    symbolic: tuple[Index, Index, Index, Index, Index, Index, Index, Index],
    indptr: IntArray,
    indices: IntArray,
    data: FloatArray,
    free: BoolArray,
    r: FloatArray,
) -> tuple[int, FloatArray]:
    n = len(indptr) - 1
    inside, diagonal, b = np.zeros(len(data)), np.ones(n), np.zeros((n, 2))
    for j in range(n):
        if free[j]:
            diagonal[j], b[j, 0] = data[indptr[j]], r[j]
            for p in range(indptr[j] + 1, indptr[j + 1]):
                if free[indices[p]]:
                    inside[p] = data[p]
    bad, below, inverse = _factored(inside, diagonal, *symbolic)
    x = np.empty((n, 2))
    if bad < 0:
        _substituted((*symbolic[:3], below, inverse), b, np.empty(2 * n), x)
    return bad, x[:, 0].copy()


def solved_inside(
    symbolic: Symbolic, indptr: IntArray, indices: IntArray, data: FloatArray, free: BoolArray, r: FloatArray
) -> tuple[int, FloatArray]:
    """Solve A x = r in the rows that are `free`, with x = 0 in the others; A is given by its lower triangle.

    The first row without a positive pivot, or -1; and x.
    """
    bad, x = run(_solved_inside, tuple(symbolic), indptr, indices, data, free, r)
    return (-1 if bad < 0 else int(symbolic.order[bad])), x


@inlined
def _fan_errors(
    t: int, row: Index, pair: FloatArray, cot: FloatArray, at: FloatArray, k: int
) -> tuple[float, float, float]:
    """P M^T x in triangle `t`; x is `at[:, k : k + 2]`, a row for each of the system and one of zeros."""
    a, b, c = row[0, t], row[1, t], row[2, t]
    u = at[a, k] + cot[0, t] * (at[c, k + 1] - at[b, k + 1])
    v = at[b, k] + cot[1, t] * (at[a, k + 1] - at[c, k + 1])
    w = at[c, k] + cot[2, t] * (at[b, k + 1] - at[a, k + 1])
    f, g, h = pair[2, t] * (u - v), pair[0, t] * (v - w), pair[1, t] * (w - u)
    return f - h, g - f, h - g


@inlined
def _fan_add(
    t: int, row: Index, cot: FloatArray, u: float, v: float, w: float, at: FloatArray, k: int
) -> None:
    """Add M times the errors of triangle `t` to `at[:, k : k + 2]`."""
    a, b, c = row[0, t], row[1, t], row[2, t]
    p, q, r = cot[0, t] * u, cot[1, t] * v, cot[2, t] * w
    at[a, k] += u
    at[b, k] += v
    at[c, k] += w
    at[a, k + 1] += q - r
    at[b, k + 1] += r - p
    at[c, k + 1] += p - q


@inlined
def _fans_product(fans: Fans, near: IntArray, at: FloatArray) -> None:
    """Fill `at[:, 2 : 4]` with S times `at[:, : 2]`, as far as these triangles give it."""
    row, pair, cot = fans
    at[:, 2:] = 0.0
    for t in near:
        u, v, w = _fan_errors(t, row, pair, cot, at, 0)
        _fan_add(t, row, cot, u, v, w, at, 2)


@inlined
def _corrected(
    fans: Fans, factor: Columns, slivers: Slivers, r: FloatArray, z: FloatArray, work: FloatArray
) -> None:
    """Fill z, (#rows, 2), with what the factor gives of r, with S^-1 at slivers before and after it."""
    near, own, local = slivers
    n, at = len(r), np.zeros((len(r) + 1, 4))
    right, first, last = np.zeros((2 * len(own), 2)), np.empty((2 * len(own), 2)), np.empty((2 * len(own), 2))
    for i in range(len(own)):
        right[2 * i, 0], right[2 * i + 1, 0] = r[own[i], 0], r[own[i], 1]
    space = np.empty(right.size)
    _substituted(local, right, space, first)
    for i in range(len(own)):
        at[own[i], 0], at[own[i], 1] = first[2 * i, 0], first[2 * i + 1, 0]
    _fans_product(fans, near, at)
    left = r - at[:n, 2:]
    _substituted(factor, left, work, z)
    for i in range(len(own)):
        z[own[i], 0] += first[2 * i, 0]
        z[own[i], 1] += first[2 * i + 1, 0]
    at[:n, :2] = z
    _fans_product(fans, near, at)
    for i in range(len(own)):
        for j in range(2):
            right[2 * i + j, 0] = r[own[i], j] - at[own[i], 2 + j]
    _substituted(local, right, space, last)
    for i in range(len(own)):
        z[own[i], 0] += last[2 * i, 0]
        z[own[i], 1] += last[2 * i + 1, 0]


X, P, Q = 0, 2, 4  # columns of what conjugate gradients keep: of a row, all is in one cache line


@inlined
def _errors_by_gradients(
    fans: Fans,
    factor: Columns,
    slivers: Slivers,
    e: FloatArray,
    b: FloatArray,
    rtol: float,
    first_rtol: float,
    most: int,
) -> tuple[int, bool]:
    """Add P M^T x to e, S x = b - M e by conjugate gradients; the steps, and whether they converged.

    That is to a relative residual of `rtol`, or of `first_rtol` by a single step.

    S = M P M^T, and the factor is that of the preconditioner, which is corrected at `slivers`, if there are
    any. The row of a corner without one is #rows; b is (#rows, 2).
    """
    row, pair, cot = fans
    n, m = len(b), len(row[0])
    at, rest, z, work = np.zeros((n + 1, 6)), np.empty((n, 2)), np.empty((n, 2)), np.empty(2 * n)
    for t in range(m):
        _fan_add(t, row, cot, e[0, t], e[1, t], e[2, t], at, Q)
    norm, steps = 0.0, 0
    for i in range(n):
        for j in range(2):
            rest[i, j] = b[i, j] - at[i, Q + j]
            norm += rest[i, j] * rest[i, j]
    whole, rho_before = np.sqrt(norm), 1.0
    converged = whole == 0
    while steps < most and not converged:
        if np.sqrt(norm) < (first_rtol if steps == 1 else rtol) * whole:
            converged = True
        if converged or not np.isfinite(norm):
            break
        if len(slivers[0]):
            _corrected(fans, factor, slivers, rest, z, work)
        else:
            _substituted(factor, rest, work, z)
        rho = 0.0
        for i in range(n):
            rho += rest[i, 0] * z[i, 0] + rest[i, 1] * z[i, 1]
        share = rho / rho_before
        for i in range(n):
            for j in range(2):
                at[i, P + j] = z[i, j] + share * at[i, P + j]
                at[i, Q + j] = 0.0
        for t in range(m):
            u, v, w = _fan_errors(t, row, pair, cot, at, P)
            _fan_add(t, row, cot, u, v, w, at, Q)
        curvature = 0.0
        for i in range(n):
            curvature += at[i, P] * at[i, Q] + at[i, P + 1] * at[i, Q + 1]
        length, norm = rho / curvature, 0.0
        for i in range(n):
            for j in range(2):
                at[i, X + j] += length * at[i, P + j]
                rest[i, j] -= length * at[i, Q + j]
                norm += rest[i, j] * rest[i, j]
        rho_before = rho
        steps += 1
    for i in range(n):
        converged &= np.isfinite(at[i, X]) and np.isfinite(at[i, X + 1])
    for t in range(m):
        u, v, w = _fan_errors(t, row, pair, cot, at, X)
        e[0, t] += u
        e[1, t] += v
        e[2, t] += w
    return steps, converged
