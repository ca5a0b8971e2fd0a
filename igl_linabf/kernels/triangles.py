"""What is computed in each triangle, and summed at the vertices; arrays over corners are (3, #F)."""

import numpy as np

from .._runtime import unfilled
from .._types import BoolArray, FloatArray, IntArray
from .choice import filled_by, inlined, with_loops

NEXT = [1, 2, 0]  # corner k + 1: where the left angle beta of corner k's fan is
PREV = [2, 0, 1]  # corner k + 2: where the right angle gamma is
LARGEST_COT = 1e75
EPS, TINY = float(np.finfo(np.float64).eps), float(np.finfo(np.float64).tiny)


def sum_by(index: IntArray, values: FloatArray, n: int) -> FloatArray:
    """Sum `values` over equal `index`, 0 .. n - 1."""
    return np.asarray(np.bincount(index.ravel(), weights=values.ravel(), minlength=n), dtype=np.float64)


def _products(
    V: FloatArray,
    corner: IntArray,
    first: int,
    last: int,
    double_area: FloatArray,
    dot: FloatArray,
    least: FloatArray,
) -> None:
    u = np.empty((3, 3))
    for t in range(first, last):
        extent = 0.0
        for k in range(3):
            a, b = corner[(k + 2) % 3, t], corner[(k + 1) % 3, t]
            for j in range(3):
                u[k, j] = V[a, j] - V[b, j]
                extent = max(extent, abs(V[a, j]))
        longest = 0.0
        for k in range(3):
            n, p = (k + 1) % 3, (k + 2) % 3
            dot[k, t] = -(u[n, 0] * u[p, 0] + u[n, 1] * u[p, 1] + u[n, 2] * u[p, 2])
            longest = max(longest, u[k, 0] * u[k, 0] + u[k, 1] * u[k, 1] + u[k, 2] * u[k, 2])
        x = u[0, 1] * u[1, 2] - u[1, 1] * u[0, 2]
        y = u[0, 2] * u[1, 0] - u[1, 2] * u[0, 0]
        z = u[0, 0] * u[1, 1] - u[1, 0] * u[0, 1]
        double_area[t] = np.sqrt(x * x + y * y + z * z)
        longest = np.sqrt(longest)
        least[t] = 4 * EPS * max(longest, extent) * longest


def _per_triangle(V: FloatArray, corner: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    m = corner.shape[1]
    return unfilled(m), unfilled((3, m)), unfilled(m)


@filled_by(_products, _per_triangle)
def products(V: FloatArray, corner: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Twice the areas, the scalar products, and the least double area that rounding does not make."""
    x, y, z = (axis[corner] for axis in np.ascontiguousarray(V.T))
    # side k is opposite to corner k
    ux, uy, uz = (c[PREV] - c[NEXT] for c in (x, y, z))
    dot = -(ux[NEXT] * ux[PREV] + uy[NEXT] * uy[PREV] + uz[NEXT] * uz[PREV])
    double_area = np.sqrt(
        (uy[0] * uz[1] - uz[0] * uy[1]) ** 2
        + (uz[0] * ux[1] - ux[0] * uz[1]) ** 2
        + (ux[0] * uy[1] - uy[0] * ux[1]) ** 2
    )
    longest = np.sqrt((ux**2 + uy**2 + uz**2).max(axis=0))
    extent = np.maximum(longest, np.maximum(np.abs(x), np.maximum(np.abs(y), np.abs(z))).max(axis=0))
    # a coordinate x is known to eps |x|; that times the longest side is an area out of nothing
    return double_area, dot, 4 * EPS * extent * longest


def _normals(V: FloatArray, corner: IntArray) -> FloatArray:
    normal, tiny = np.empty((corner.shape[1], 3)), np.finfo(np.float64).tiny
    u, v = np.empty(3), np.empty(3)
    for t in range(corner.shape[1]):
        for j in range(3):
            u[j] = V[corner[1, t], j] - V[corner[0, t], j]
            v[j] = V[corner[2, t], j] - V[corner[0, t], j]
        x, y, z = u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
        length = max(np.sqrt(x * x + y * y + z * z), tiny)
        normal[t, 0], normal[t, 1], normal[t, 2] = x / length, y / length, z / length
    return normal


@with_loops(_normals)
def normals(V: FloatArray, corner: IntArray) -> FloatArray:
    """Unit normals of triangles, (#F, 3); zero, or what rounding makes of it, where there is no area."""
    a, b, c = V[corner]
    normal = np.cross(b - a, c - a)
    length = np.sqrt(np.einsum("ij,ij->i", normal, normal))
    return np.asarray(normal / np.maximum(length, np.finfo(np.float64).tiny)[:, None])


def _bends(V: FloatArray, corner: IntArray, sides: IntArray, normal: FloatArray) -> FloatArray:
    bend, m = np.empty(sides.shape[1]), corner.shape[1]
    for e in range(sides.shape[1]):
        s, t = sides[0, e], sides[1, e]
        i, j = np.int64(s >= m) + np.int64(s >= 2 * m), np.int64(t >= m) + np.int64(t >= 2 * m)
        s, t = s - i * m, t - j * m  # no division, which takes as long as the rest
        v, w = corner[i, s], corner[j, t]
        squared, rise = 0.0, 0.0
        for k in range(3):
            turned = normal[s, k] - normal[t, k]
            squared += turned * turned
            rise += (V[w, k] - V[v, k]) * turned
        angle = 2 * np.arcsin(min(np.sqrt(squared) / 2, 1.0))
        bend[e] = -angle if rise > 0 else angle
    return bend


@with_loops(_bends)
def bends(V: FloatArray, corner: IntArray, sides: IntArray, normal: FloatArray) -> FloatArray:
    """Angle between the normals at edges, of sides (2, #E); negative where the surface is concave."""
    m = corner.shape[1]
    turned = normal[sides[0] % m] - normal[sides[1] % m]
    angle = 2 * np.arcsin(np.minimum(np.sqrt(np.einsum("ij,ij->i", turned, turned)) / 2, 1))
    apex = corner.ravel()[sides]  # opposite to the edge, on its two sides
    rise = np.einsum("ij,ij->i", V[apex[1]] - V[apex[0]], turned)
    return np.asarray(np.where(rise > 0, -angle, angle))


def _lengths(V: FloatArray, edges: IntArray) -> FloatArray:
    length = np.empty(len(edges))
    for e in range(len(edges)):
        squared = 0.0
        for j in range(V.shape[1]):
            squared += (V[edges[e, 0], j] - V[edges[e, 1], j]) ** 2
        length[e] = np.sqrt(squared)
    return length


@with_loops(_lengths)
def lengths(V: FloatArray, edges: IntArray) -> FloatArray:
    """Of edges, (#E, 2)."""
    along = V[edges[:, 0]] - V[edges[:, 1]]
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", along, along)))


@inlined
def _cotangent(x: float) -> float:
    """Of an angle, by the rational function of Cephes (Moshier 1989): a loop of these runs in SIMD."""
    quarter = np.floor(x * (2 / np.pi) + 0.5)
    y = x - quarter * (np.pi / 2)
    z = y * y
    p = (-1.30936939181383734205e4 * z + 1.15351664838587416140e6) * z - 1.79565251976484877988e7
    q = ((z + 1.36812963470692954678e4) * z - 1.32089234440210967447e6) * z + 2.50083801823357915839e7
    tangent = y + y * (z * p / (q * z - 5.38695755929454629881e7))
    return float(1 / tangent if quarter == 2 * np.floor(quarter / 2) else -tangent)


@inlined
def _arctangent(y: float, x: float) -> float:
    """The angle of x + i y in [0, pi], y being at least 0, in the same way; 0 where both are 0."""
    low, high = min(y, abs(x)), max(y, abs(x))
    steep = low > 0.66 * high
    u = (low - high) / (low + high) if steep else low / max(high, TINY)
    z = u * u
    p = (-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z - 7.500855792314704667340e1
    q = (z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2
    p = (p * z - 1.228866684490136173410e2) * z - 6.485021904942025371773e1
    q = ((q * z + 4.328810604912902668951e2) * z + 4.853903996359136964868e2) * z + 1.945506571482613964425e2
    angle = u + u * (z * p / q) + (np.pi / 4 if steep else 0.0)
    angle = np.pi / 2 - angle if y > abs(x) else angle
    return np.pi - angle if x < 0 else angle


def _cotangents(alpha: FloatArray, first: int, last: int, cot: FloatArray) -> None:
    for k in range(3):
        angle, made = alpha[k, first:last], cot[k, first:last]
        for t in range(len(angle)):  # from 0 on, for SIMD
            made[t] = _cotangent(angle[t])


@filled_by(_cotangents, lambda alpha: unfilled(alpha.shape))
def cotangents(alpha: FloatArray) -> FloatArray:
    """cot alpha, (3, #F); infinite at an angle of 0, as in a collapsed triangle."""
    made = np.tan(alpha)  # NumPy's tangent takes a fifth of the time of its sine
    with np.errstate(divide="ignore"):
        np.divide(1, made, out=made)
    return made


def _rescaled(
    corner: IntArray,
    length: FloatArray,
    factor: FloatArray,
    first: int,
    last: int,
    made: FloatArray,
    bad: BoolArray,
) -> None:
    for t in range(first, last):
        a = length[0, t] * factor[corner[0, t]]
        b = length[1, t] * factor[corner[1, t]]
        c = length[2, t] * factor[corner[2, t]]
        size = max(a, b, c)
        a, b, c = a / size, b / size, c / size
        x, y, z, half = (b + c - a) / 2, (c + a - b) / 2, (a + b - c) / 2, (a + b + c) / 2
        bad[t] = not min(x, y, z) > 0
        x, y, z = max(x, 0.0), max(y, 0.0), max(z, 0.0)
        radius = np.sqrt(x * y * z / half)
        made[0, t] = 2 * _arctangent(radius, x)
        made[1, t] = 2 * _arctangent(radius, y)
        made[2, t] = 2 * _arctangent(radius, z)


@filled_by(_rescaled, lambda corner, *_: (unfilled(corner.shape), np.empty(corner.shape[1], dtype=bool)))
def rescaled(corner: IntArray, length: FloatArray, factor: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Angles (3, #F) of triangles whose sides, (3, #F), are multiplied by the factor of the vertex opposite.

    Also tells which triangles cannot have such sides; their angles mean nothing.
    """
    side = length * factor[corner]
    side /= side.max(axis=0)
    half = side.sum(axis=0) / 2
    left = half - side
    bad = ~(left > 0).all(axis=0)
    left = np.maximum(left, 0.0)
    return 2 * np.arctan2(np.sqrt(left.prod(axis=0) / half), left), bad


def squared_cosecants(cot: FloatArray) -> FloatArray:
    """1 / sin^2 of the angles; an angle of 0 or pi, as in a collapsed triangle, counts as one of 1e-75."""
    square = np.minimum(np.abs(cot), LARGEST_COT)
    np.square(square, out=square)
    square += 1
    return square


def log_sines(cot: FloatArray) -> FloatArray:
    """log |sin alpha|, from cot alpha."""
    logs = squared_cosecants(cot)
    np.log(logs, out=logs)
    logs *= -0.5
    return logs


def _angle_sums(
    corner: IntArray, alpha: FloatArray, cot: FloatArray, n: int
) -> tuple[FloatArray, FloatArray]:
    total, log_ratio, ratio = np.zeros(n), np.zeros(n), np.ones(n)
    square = np.empty(3)
    for t in range(corner.shape[1]):
        for k in range(3):
            total[corner[k, t]] += alpha[k, t]
            c = min(abs(cot[k, t]), LARGEST_COT)
            square[k] = 1 + c * c
        for k in range(3):
            v = corner[k, t]
            ratio[v] *= square[(k + 1) % 3] / square[(k + 2) % 3]
            if not 1e-150 < ratio[v] < 1e150:  # the next factor could overflow
                log_ratio[v] += np.log(ratio[v])
                ratio[v] = 1.0
    for v in range(n):
        log_ratio[v] = 0.5 * (log_ratio[v] + np.log(ratio[v]))
    return total, log_ratio


@with_loops(_angle_sums)
def angle_sums(corner: IntArray, alpha: FloatArray, cot: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """At each vertex the sum of its angles, and of log sin(gamma) - log sin(beta) (eq. 5 and 10)."""
    log_sin = log_sines(cot)
    return sum_by(corner, alpha, n), sum_by(corner, log_sin[PREV] - log_sin[NEXT], n)


def _row_sums(corner: IntArray, cot: FloatArray, e: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    vertex, wheel = np.zeros(n), np.zeros(n)
    for t in range(corner.shape[1]):
        a, b, c = corner[0, t], corner[1, t], corner[2, t]
        p, q, r = cot[0, t] * e[0, t], cot[1, t] * e[1, t], cot[2, t] * e[2, t]
        vertex[a] += e[0, t]
        vertex[b] += e[1, t]
        vertex[c] += e[2, t]
        wheel[a] += q - r
        wheel[b] += r - p
        wheel[c] += p - q
    return vertex, wheel


@with_loops(_row_sums)
def row_sums(corner: IntArray, cot: FloatArray, e: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """M e: what errors (3, #F) change the vertex and the wheel constraint of each vertex by, (n,) each."""
    q = cot * e
    return sum_by(corner, e, n), sum_by(corner, q[NEXT] - q[PREV], n)


def _errors(
    corner: IntArray,
    w: FloatArray,
    d: FloatArray,
    cot: FloatArray,
    vertex: FloatArray,
    wheel: FloatArray,
    first: int,
    last: int,
    e: FloatArray,
) -> None:
    for t in range(first, last):
        a, b, c = corner[0, t], corner[1, t], corner[2, t]
        x, y, z = wheel[a], wheel[b], wheel[c]
        y0 = vertex[a] + cot[0, t] * (z - y)
        y1 = vertex[b] + cot[1, t] * (x - z)
        y2 = vertex[c] + cot[2, t] * (y - x)
        w0, w1, w2 = w[0, t], w[1, t], w[2, t]
        e[0, t] = w0 * ((w1 * (y0 - y1) + w2 * (y0 - y2)) / d[t])
        e[1, t] = w1 * ((w2 * (y1 - y2) + w0 * (y1 - y0)) / d[t])
        e[2, t] = w2 * ((w0 * (y2 - y0) + w1 * (y2 - y1)) / d[t])


@filled_by(_errors, lambda corner, *_: unfilled(corner.shape))
def errors(
    corner: IntArray, w: FloatArray, d: FloatArray, cot: FloatArray, vertex: FloatArray, wheel: FloatArray
) -> FloatArray:
    """P M^T x of multipliers (n,) of single vertices: angles (3, #F) that sum to zero in each triangle."""
    x, y = vertex.take(corner), wheel.take(corner)  # far faster than by an index
    return projected(w, d, x + cot * (y[PREV] - y[NEXT]))


def _projected(w: FloatArray, d: FloatArray, y: FloatArray, first: int, last: int, made: FloatArray) -> None:
    for t in range(first, last):
        y0, y1, y2 = y[0, t], y[1, t], y[2, t]
        w0, w1, w2 = w[0, t], w[1, t], w[2, t]
        made[0, t] = w0 * ((w1 * (y0 - y1) + w2 * (y0 - y2)) / d[t])
        made[1, t] = w1 * ((w2 * (y1 - y2) + w0 * (y1 - y0)) / d[t])
        made[2, t] = w2 * ((w0 * (y2 - y0) + w1 * (y2 - y1)) / d[t])


@filled_by(_projected, lambda w, *_: unfilled(w.shape))
def projected(w: FloatArray, d: FloatArray, y: FloatArray) -> FloatArray:
    """P y: (3, #F) angles that sum to zero in each triangle."""
    after, before = y[NEXT], y[PREV]
    return np.asarray(w * ((w[NEXT] * (y - after) + w[PREV] * (y - before)) / d))


def _conformal_errors(corner: IntArray, cot: FloatArray, vertex: FloatArray, wheel: FloatArray) -> FloatArray:
    m = corner.shape[1]
    e = np.empty((3, m))
    for t in range(m):
        a, b, c = corner[0, t], corner[1, t], corner[2, t]
        x, y, z = wheel[a], wheel[b], wheel[c]
        p, q, r = cot[0, t], cot[1, t], cot[2, t]
        y0, y1, y2 = vertex[a] + p * (z - y), vertex[b] + q * (x - z), vertex[c] + r * (y - x)
        u, v, w = p * (y1 - y2) / 2, q * (y2 - y0) / 2, r * (y0 - y1) / 2
        e[0, t], e[1, t], e[2, t] = w - v, u - w, v - u
    return e


@with_loops(_conformal_errors)
def conformal_errors(corner: IntArray, cot: FloatArray, vertex: FloatArray, wheel: FloatArray) -> FloatArray:
    """K M^T x of multipliers (n,) of single vertices, K the cotangent matrices: `errors` in that metric."""
    x, y = vertex.take(corner), wheel.take(corner)
    return conformally(cot, x + cot * (y[PREV] - y[NEXT]))


def conformally(cot: FloatArray, y: FloatArray) -> FloatArray:
    """K y: (3, #F) angles that sum to zero in each triangle."""
    across = cot * (y[NEXT] - y[PREV]) / 2
    return np.asarray(across[PREV] - across[NEXT])


def _cut_short(
    alpha: FloatArray, e: FloatArray, reach: float, first: int, last: int, made: FloatArray, cut: BoolArray
) -> None:
    for t in range(first, last):
        x, y, z = e[0, t], e[1, t], e[2, t]
        a, b, c = alpha[0, t], alpha[1, t], alpha[2, t]
        made[0, t], made[1, t], made[2, t] = x, y, z
        cut[t] = False
        if reach * a < -x or reach * b < -y or reach * c < -z:  # few: most do without a division
            times = np.inf
            for k in range(3):
                if e[k, t] < 0:
                    times = min(times, alpha[k, t] / -e[k, t])
            cut[t] = times <= 1
            share = min(reach * times, 1.0)
            for k in range(3):
                made[k, t] = e[k, t] * share


@filled_by(_cut_short, lambda alpha, *_: (unfilled(alpha.shape), np.empty(alpha.shape[1], dtype=bool)))
def cut_short(alpha: FloatArray, e: FloatArray, reach: float) -> tuple[FloatArray, BoolArray]:
    """The errors, up to a share `reach` of the way to a vanishing angle; where they are not shorter."""
    with np.errstate(divide="ignore"):  # how many times each triangle could take its errors
        times = np.where(e < 0, alpha / -e, np.inf).min(axis=0)
    return e * np.minimum(reach * times, 1.0), times <= 1
