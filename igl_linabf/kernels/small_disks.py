"""Linear ABF of many small disks, each from its vertices to its map at once: loops only, for numba.

All arrays of a small disk stay in the processor's caches if it is done before the next one begins. Without
numba, `flattening.many` takes the same steps for all disks at a time, and so it does for those with too many
slivers.
"""

from typing import NamedTuple

import numpy as np

from .._types import ComplexArray, FloatArray, IntArray
from .choice import inlined, only_loops
from .cholesky import _analysed, _factored
from .connectivity import _boundary_loops, _in_one_piece, _undirected
from .maps import _centred, _signed_double_areas
from .small_slivers import _at_slivers
from .small_systems import _errors_by_gradients, _substituted
from .systems import _conformal_weights, _disparity, _pair_weights
from .triangles import _angle_sums, _arctangent, _cotangents, _cut_short, _products

ALONE, THIN, STILL, STEPPED = 0, 1, 2, 3  # what became of a disk
FIGURES = 13
MOST_SLIVERS = 600  # rows of slivers: the ordering of what is factored there takes the square of them


class Limits(NamedTuple):
    """What the loops ask of a disk.

    Attributes
    ----------
    smallest, largest : float
        Coordinate: the largest one of a disk is between these.
    cap : float
        Radians below pi above which an angle is too large.
    threshold : float
        Radians by which the angles around a vertex may miss 2 pi in the initial estimate.
    rtol, tol : float
        Relative residual of conjugate gradients; residual below which there is nothing to do.
    most_steps : int
        Of conjugate gradients.
    disparity : float
        Of the metrics in a triangle, above which it is a sliver.
    reach : float
        Share of the way to a vanishing angle that a step may go.
    gap : float
        Relative gap of the developed boundary.
    """

    smallest: float
    largest: float
    cap: float
    threshold: float
    rtol: float
    tol: float
    most_steps: int
    disparity: float
    reach: float
    gap: float


@inlined
def _is_sound(V: FloatArray, F: IntArray, corner: IntArray, limits: Limits) -> bool:
    """Fill `corner`; whether indices and coordinates are right, and every vertex has a face."""
    used, missing = np.zeros(len(V), dtype=np.bool_), 0
    x = y = z = 0.0
    for t in range(len(F)):
        i, j, k = F[t, 0], F[t, 1], F[t, 2]
        if min(i, j, k) < 0 or max(i, j, k) >= len(V) or i == j or j == k or k == i:
            return False
        used[i] = used[j] = used[k] = True
        corner[0, t], corner[1, t], corner[2, t] = i, j, k
    for v in range(len(V)):
        a, b, c = abs(V[v, 0]), abs(V[v, 1]), abs(V[v, 2])
        if not (a < limits.largest and b < limits.largest and c < limits.largest):
            return False
        x, y, z = max(a, x), max(b, y), max(c, z)
        missing += not used[v]
    return missing == 0 and max(x, y, z) > limits.smallest


@inlined
def _estimated(
    V: FloatArray,
    corner: IntArray,
    inside: IntArray,
    rows: int,
    limits: Limits,
    double: FloatArray,
    alpha: FloatArray,
) -> bool:
    """Fill `double`, twice the areas, and `alpha`, the initial estimate; whether no face is degenerate."""
    m = corner.shape[1]
    area, dot, least = np.empty(m), np.empty((3, m)), np.empty(m)
    _products(V, corner, 0, m, area, dot, least)
    for k in range(3):
        for t in range(m):
            alpha[k, t] = _arctangent(area[t], dot[k, t])
    total = np.zeros(len(V))
    for t in range(m):
        double[t] = area[t]
        if not area[t] > least[t]:
            return False
        for k in range(3):
            total[corner[k, t]] += alpha[k, t]
        a, b, c = alpha[0, t], alpha[1, t], alpha[2, t]
        if a + b + c - max(a, b, c) < limits.cap:
            return False
    far = False
    for v in range(len(V)):
        share = 1.0
        if inside[v] < rows and abs(total[v] - 2 * np.pi) > limits.threshold:
            share, far = 2 * np.pi / total[v], True
        total[v] = share
    for t in range(m if far else 0):
        for k in range(3):
            alpha[k, t] *= total[corner[k, t]]
        share = np.pi / (alpha[0, t] + alpha[1, t] + alpha[2, t])
        for k in range(3):
            alpha[k, t] *= share
    return True


@inlined
def _residual(
    alpha: FloatArray,
    total: FloatArray,
    log_ratio: FloatArray,
    inside: IntArray,
    b: FloatArray,
    missing: FloatArray,
    families: FloatArray,
) -> float:
    """Fill b and `missing` with the residuals of rows and triangles (eq. 5, 6, 10); the largest of all."""
    families[:] = 0.0
    around = within = wheel = 0.0
    for v in range(len(inside)):
        if inside[v] < len(b):
            b[inside[v], 0], b[inside[v], 1] = 2 * np.pi - total[v], log_ratio[v]
            around, wheel = max(around, abs(2 * np.pi - total[v])), max(wheel, abs(log_ratio[v]))
    for t in range(len(missing)):
        missing[t] = np.pi - (alpha[0, t] + alpha[1, t] + alpha[2, t])
        within = max(within, abs(missing[t]))
    families[0], families[1], families[2] = around, within, wheel
    return float(max(around, within, wheel))


@inlined
def _entered(
    ends: IntArray, sides: IntArray, half: FloatArray, weight: FloatArray, diagonal: FloatArray
) -> None:
    """Fill `weight`, less than 0, and `diagonal`: the Laplacian of twice what half-edges give."""
    flat = half.ravel()
    diagonal[:] = 0.0
    for e in range(len(weight)):
        other = sides[1, e]
        value = (flat[sides[0, e]] + (flat[other] if other >= 0 else 0.0)) / 2
        weight[e] = -value
        diagonal[ends[0, e]] += value
        diagonal[ends[1, e]] += value


@inlined
def _drawn(loop: IntArray, total: FloatArray, log_ratio: FloatArray, z: ComplexArray) -> float:
    """Develop the boundary into `z`, as `develop_boundary` does; the relative gap."""
    size, shift, mean = len(loop), 2 * np.pi, 0.0
    for v in loop:
        shift -= np.pi - total[v]
        mean += log_ratio[v] / size
    length, edge = np.empty(size), np.empty(size, dtype=np.complex128)
    at, longest, turned = 0.0, -np.inf, 0.0
    for i in range(size):
        at += log_ratio[loop[i]] - mean
        length[i], longest = at, max(longest, at)
        turned += np.pi - total[loop[i]] + shift / size
        edge[i] = complex(np.cos(turned), np.sin(turned))
    gap, around, xx, xy, yy = 0j, 0.0, 0.0, 0.0, 0.0
    for i in range(size):
        length[i] = np.exp(length[i] - longest)
        x, y = edge[i].real, edge[i].imag
        gap += length[i] * edge[i]
        around += length[i]
        xx, xy, yy = xx + length[i] * x * x, xy + length[i] * x * y, yy + length[i] * y * y
    det, place = xx * yy - xy * xy, 0j
    u, v = (xy * gap.imag - yy * gap.real) / det, (xy * gap.real - xx * gap.imag) / det
    for i in range(size):
        z[loop[i]] = place
        place += length[i] * (1 + u * edge[i].real + v * edge[i].imag) * edge[i]
    return abs(gap) / around


def _flat_disk(
    V: FloatArray, F: IntArray, limits: Limits, uv: FloatArray, angles: FloatArray, figures: FloatArray
) -> int:
    n, m = len(V), len(F)
    corner = np.empty((3, m), dtype=np.int64)
    if not _is_sound(V, F, corner, limits):
        return ALONE
    edges, sides, sound = _undirected(corner, n)
    size, rim = len(edges), np.flatnonzero(sides[1] < 0)
    loop, sizes, _ = _boundary_loops(edges[rim, 0], edges[rim, 1], n)
    if not sound or len(sizes) != 1 or n - size + m != 1 or not _in_one_piece(sides, m):
        return ALONE
    inside, rows = np.ones(n, dtype=np.int64), n - len(loop)  # the row of each vertex, #rows for none
    for v in loop:
        inside[v] = 0
    at = 0
    for v in range(n):
        own = inside[v]
        inside[v] = at if own else rows
        at += own
    double, alpha = np.empty(m), np.empty((3, m))
    if not _estimated(V, corner, inside, rows, limits, double, alpha):
        return ALONE
    families, cot = figures[:9].reshape(3, 3), np.empty((3, m))
    _cotangents(alpha, 0, m, cot)
    total, log_ratio = _angle_sums(corner, alpha, cot, n)
    b, missing = np.empty((rows, 2)), np.empty(m)
    stepped = _residual(alpha, total, log_ratio, inside, b, missing, families[0]) > limits.tol
    families[1:] = families[0]
    if stepped and not rows:
        return ALONE
    ends, weight, diagonal = np.empty((2, size), dtype=np.int64), np.empty(size), np.empty(rows + 1)
    for e in range(size):
        ends[0, e], ends[1, e] = inside[edges[e, 0]], inside[edges[e, 1]]
    symbolic = _analysed(np.array([0, rows]), ends, np.array([0, size]))
    order, begin, below = symbolic[:3]
    if stepped:
        row = np.empty((3, m), dtype=np.uint32)
        for k in range(3):
            for t in range(m):
                row[k, t] = inside[corner[k, t]]
        w, d = alpha * alpha, np.empty(m)
        for t in range(m):
            d[t] = w[0, t] + w[1, t] + w[2, t]
        disparity, conformal = np.empty(m), np.empty((3, m))
        _disparity(w, d, cot, 0, m, disparity)
        sliver = np.zeros(rows + 1, dtype=np.bool_)
        for t in range(m):
            if disparity[t] > limits.disparity:
                sliver[row[0, t]] = sliver[row[1, t]] = sliver[row[2, t]] = True
        sliver[rows] = False
        if np.count_nonzero(sliver) > MOST_SLIVERS:
            return THIN
        _conformal_weights(w, d, cot, 0, m, conformal)
        _entered(ends, sides, conformal, weight, diagonal)
        bad, entries, inverse = _factored(weight, diagonal, *symbolic)
        if bad >= 0:
            return ALONE
        fans, factor = (row, _pair_weights(w, d), cot), (order, begin, below, entries, inverse)
        slivers = (np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), factor)
        if sliver.any():
            positive, slivers = _at_slivers(fans, sliver)
            if not positive:
                return ALONE
        step, cut = np.empty((3, m)), np.empty(m, dtype=np.bool_)
        for k in range(2):  # one inner step of the first has to leave far less
            e0 = w * (missing / d)
            steps, converged = _errors_by_gradients(
                fans, factor, slivers, e0, b, limits.rtol, limits.rtol ** (2 - k), limits.most_steps
            )
            _cut_short(alpha, e0, limits.reach, 0, m, step, cut)
            if not converged or cut.any():
                return ALONE
            alpha, cot = alpha + step, np.empty((3, m))  # the chord has the cotangents before
            _cotangents(alpha, 0, m, cot)
            total, log_ratio = _angle_sums(corner, alpha, cot, n)
            _residual(alpha, total, log_ratio, inside, b, missing, families[k + 1])
            figures[9 + k] = steps
    z = np.zeros(n, dtype=np.complex128)
    figures[11] = _drawn(loop, total, log_ratio, z)
    if not figures[11] <= limits.gap:
        return ALONE
    if rows:
        _entered(ends, sides, cot, weight, diagonal)
        bad, entries, inverse = _factored(weight, diagonal, *symbolic)
        if bad >= 0:
            return ALONE
        right = np.zeros((rows + 1, 2))
        for e in range(size):
            for s in range(2):
                fixed = z[edges[e, 1 - s]]  # zero but on the boundary
                right[ends[s, e], 0] -= weight[e] * fixed.real
                right[ends[s, e], 1] -= weight[e] * fixed.imag
        x, work = np.empty_like(right), np.empty(2 * rows)
        _substituted((order, begin, below, entries, inverse), right, work, x)
        for v in range(n):
            if inside[v] < rows:
                z[v] = complex(x[inside[v], 0], x[inside[v], 1])
    flat, whole = np.empty(m), np.zeros(1)
    _signed_double_areas(z, corner, 0, m, flat)
    smallest, largest = np.inf, 0.0
    for t in range(m):
        if not flat[t] > 0:
            return ALONE
        smallest, largest = min(smallest, flat[t] / double[t]), max(largest, flat[t] / double[t])
        whole[0] += double[t] / 2
    figures[12] = largest / max(smallest, 1e-32 * largest)
    z = _centred(z, corner, flat, whole, np.array([0, n]), np.array([0, m]))
    for v in range(n):
        uv[v, 0], uv[v, 1] = z[v].real, z[v].imag
    for t in range(m):
        for k in range(3):
            angles[t, k] = alpha[k, t]
    return STEPPED if stepped else STILL


inlined(_flat_disk)


def _flat_disks(
    V: FloatArray, F: IntArray, vertex_start: IntArray, face_start: IntArray, limits: Limits
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    size = len(face_start) - 1
    state, figures = np.empty(size, dtype=np.int64), np.zeros((size, FIGURES))
    uv, angles = np.empty((len(V), 2)), np.empty((len(F), 3))
    for k in range(size):
        a, b, c, d = vertex_start[k], vertex_start[k + 1], face_start[k], face_start[k + 1]
        state[k] = _flat_disk(V[a:b], F[c:d], limits, uv[a:b], angles[c:d], figures[k])
    return state, uv, angles, figures


flat_disks = only_loops(_flat_disks)
flat_disks.__doc__ = """The states of disks; maps (#V, 2), angles (#F, 3) and figures of those that are flat.

A disk is ALONE if linear ABF's step and chord are not enough for it, or something is wrong with it; THIN if
it has many slivers; STILL if its angles were flat from the start; or STEPPED. Figures are the largest
residuals of vertices, triangles and wheels at the start, after the step and after the chord; the inner steps
of the two; the gap; the ratio of area scales.
"""
