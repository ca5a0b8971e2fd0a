"""Reference for the angle computations of the core, by the formulas of the paper; corner arrays are (3, #F).

Zayer, Levy, Seidel, Linear Angle Based Parameterization, SGP 2007.
"""

import numpy as np
from scipy import sparse

# NEXT[k] and PREV[k] are corners k + 1 and k + 2, the left and right angle in the wheel of corner k
NEXT, PREV = [1, 2, 0], [2, 0, 1]


def sum_by_index(index, values, n):
    return np.bincount(index.ravel(), weights=values.ravel(), minlength=n)


# --- triangles in space


def side_products(V, corner):
    """Compute twice the areas, the scalar products of sides at corners, and the area rounding errors."""
    at = V[corner]
    side = at[PREV] - at[NEXT]
    dot = -(side[NEXT] * side[PREV]).sum(axis=2)
    double_area = np.linalg.norm(np.cross(side[0], side[1]), axis=1)
    longest = np.linalg.norm(side, axis=2).max(axis=0)
    extent = np.maximum(longest, np.abs(at).max(axis=(0, 2)))
    return double_area, dot, 4 * np.finfo(float).eps * extent * longest


def normals(V, corner):
    a, b, c = V[corner]
    normal = np.cross(b - a, c - a)
    return normal / np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]


def dihedrals(V, corner, sides, normal):
    """Compute the angles between the normals at edges; concave edges have negative angles."""
    m = corner.shape[1]
    turned = normal[sides[0] % m] - normal[sides[1] % m]
    angle = 2 * np.arcsin(np.minimum(np.linalg.norm(turned, axis=1) / 2, 1))
    apex = V[corner.ravel()[sides]]
    return np.where(((apex[1] - apex[0]) * turned).sum(axis=1) > 0, -angle, angle)


def lengths(V, edges):
    return np.linalg.norm(V[edges[:, 0]] - V[edges[:, 1]], axis=1)


# --- angles


def cotangents(alpha):
    with np.errstate(divide="ignore"):
        return 1 / np.tan(alpha)


def rescaled_angles(corner, length, factor):
    """Compute the angles of triangles after scaling their sides; mark triangles that cannot exist."""
    side = length * factor[corner]
    side /= side.max(axis=0)
    half = side.sum(axis=0) / 2
    left = half - side
    return 2 * np.arctan2(np.sqrt(np.maximum(left, 0).prod(axis=0) / half), np.maximum(left, 0)), ~(
        left > 0
    ).all(0)


def angle_sums(corner, alpha, cot, n):
    """Compute sum alpha (eq. 5) and sum log sin gamma - log sin beta (eq. 10) at vertices; |cot| <= 1e75."""
    log_sine = -0.5 * np.log1p(np.minimum(np.abs(cot), 1e75) ** 2)
    return sum_by_index(corner, alpha, n), sum_by_index(corner, log_sine[PREV] - log_sine[NEXT], n)


def limit_step(alpha, e, reach):
    """Limit steps to a share of the step that makes an angle zero; mark triangles that reach that step."""
    with np.errstate(divide="ignore"):
        times = np.where(e < 0, alpha / -e, np.inf).min(axis=0)
    return e * np.minimum(reach * times, 1), times <= 1


# --- the linear system of the angle changes e, without the rows of the triangles


def rows(corner, cot, n):
    """Return M, (n, 3 #F) sparse: vertex rows (eq. 5) and derivatives of the wheel rows (eq. 8 to 10)."""
    m = corner.shape[1]
    number = np.arange(3 * m).reshape(3, m)
    shape = (n, 3 * m)
    vertex = sparse.csr_array((np.ones(3 * m), (corner.ravel(), number.ravel())), shape=shape)
    wheel = sparse.csr_array((cot[NEXT].ravel(), (corner.ravel(), number[NEXT].ravel())), shape=shape)
    wheel -= sparse.csr_array((cot[PREV].ravel(), (corner.ravel(), number[PREV].ravel())), shape=shape)
    return vertex, wheel


def constraint_changes(corner, cot, e, n):
    """Return the products of the vertex rows and of the wheel rows of M with the angle changes e."""
    return tuple(part @ e.ravel() for part in rows(corner, cot, n))


def projection(w):
    """Return the matrix P = diag(w) - w w^T / sum w of each triangle, (#F, 3, 3)."""
    return np.eye(3) * w.T[:, None] - w.T[:, :, None] * (w / w.sum(axis=0)).T[:, None]


def conformal(cot):
    """Return the cotangent matrix K of each triangle, (#F, 3, 3)."""
    K = np.empty((cot.shape[1], 3, 3))
    for k in range(3):
        K[:, NEXT[k], PREV[k]] = K[:, PREV[k], NEXT[k]] = -cot[k] / 2
        K[:, k, k] = (cot[NEXT[k]] + cot[PREV[k]]) / 2
    return K


def times(matrices, y):
    return np.einsum("tij,jt->it", matrices, y)


def transposed(corner, cot, vertex, wheel):
    """Return the product M^T x with vertex and wheel multipliers x."""
    parts = rows(corner, cot, len(vertex))
    return (parts[0].T @ vertex + parts[1].T @ wheel).reshape(3, -1)


def project_errors(w, d, y):
    return times(projection(w), y)


def errors(corner, w, d, cot, vertex, wheel):
    """Return the angle changes P M^T x."""
    return times(projection(w), transposed(corner, cot, vertex, wheel))


def conformal_errors(corner, cot, vertex, wheel):
    """Return the angle changes K M^T x in the conformal metric."""
    return times(conformal(cot), transposed(corner, cot, vertex, wheel))


def reduced(corner, row, n, w, cot):
    """Return S = sum M_t P_t M_t^T, (2, 2, n, n); vertices may share a row, or have no row (-1)."""
    m = corner.shape[1]
    to_rows = sparse.csr_array((np.ones(len(row)), (np.where(row < 0, n, row), np.arange(len(row)))))
    M = [(to_rows @ part)[:n] for part in rows(corner, cot, len(row))]
    number = np.arange(3 * m).reshape(3, m)
    i, j = (np.broadcast_to(x, (3, 3, m)) for x in (number[:, None], number[None]))
    P = sparse.csr_array((projection(w).transpose(1, 2, 0).ravel(), (i.ravel(), j.ravel())))
    return np.array([[(a @ P @ b.T).toarray() for b in M] for a in M])


def conformal_scale(w):
    """Return s, the geometric mean of the eigenvalue ratios of P and K; s K is close to P."""
    return 2 * np.sqrt(w.prod(axis=0) / w.sum(axis=0))


def eigenvalue_disparity(w, d, cot):
    """Return rho + 1 / rho, where rho is the eigenvalue ratio of P and s K on the plane sum e = 0."""
    plane = np.linalg.svd(np.ones((1, 3)))[2][1:]
    P, K = plane @ projection(w) @ plane.T, plane @ conformal(cot) @ plane.T
    both = np.linalg.solve(K, P)
    return np.trace(both, axis1=1, axis2=2) ** 2 / np.linalg.det(both) - 2


def laplacian(ends, weight, n):
    """Return L with x^T L x = sum weight (x_i - x_j)^2 over edges between rows `ends`; x is 0 at row -1."""
    L = np.zeros((n + 1, n + 1))
    for (i, j), w in zip(ends.T, weight, strict=True):
        if i != j:
            L[i, i] += w
            L[j, j] += w
            L[i, j] -= w
            L[j, i] -= w
    return L[:n, :n]


# --- flat maps


def signed_double_areas(z, corner):
    a, b, c = z[corner]
    return ((b - a).conj() * (c - a)).imag


def triangle_changes(V, uv, corner, double_area, dot):
    """Compute angles, their changes, signed double areas, singular values, and length ratios of a map."""
    z, at = (uv @ [1, 1j])[corner], V[corner]
    right, left = z[NEXT] - z, z[PREV] - z
    cross = right.conj() * left
    angle = np.arctan2(double_area, dot)
    x = (at[1] - at[0]) / np.linalg.norm(at[1] - at[0], axis=1)[:, None]
    y = np.cross(normals(V, corner), x)
    frame = np.stack([np.einsum("ti,sti->st", axis, at[1:] - at[0]) for axis in (x, y)])  # (2, side, #F)
    flat = np.stack([np.stack((p.real, p.imag)) for p in (right[0], left[0])], axis=1)
    jacobian = np.einsum("ist,tsj->tij", flat, np.linalg.inv(frame.transpose(2, 0, 1)))
    major, minor = np.linalg.svd(jacobian, compute_uv=False).T
    ratio = np.abs(z[PREV] - z[NEXT]) / np.linalg.norm(at[PREV] - at[NEXT], axis=2)
    return angle, np.arctan2(np.abs(cross.imag), cross.real) - angle, cross[0].imag, major, minor, ratio


def normalize_maps(z, corner, double_area, area):
    """Scale a map to an area, centre it, and rotate it to its principal axes with a positive third moment."""
    at, share = z[corner], double_area / double_area.sum()
    z = z - share @ at.mean(axis=0)
    a, b, c = z[corner]
    second = share @ (a**2 + b**2 + c**2 + (a + b + c) ** 2)
    z = z * np.exp(-0.5j * np.angle(second))
    x = z[corner].mean(axis=0).real
    return z * np.sqrt(2 * area / double_area.sum()) * np.sign(share @ x**3)


# --- boundary loops


def developed_edges(turning, log_ratio):
    """Return the edges of a loop from its turning, divided by its total length; edge k starts at vertex k."""
    length = np.cumsum(log_ratio - log_ratio.mean())
    edge = np.exp(length - length.max() + 1j * np.cumsum(turning))
    return edge / np.abs(edge).sum()


def developed_loop(turning, log_ratio, movable):
    """Lay out the outer loop from exterior angles, closed by min sum delta^2 / l; also return the gap."""
    missing = (2 * np.pi - turning.sum()) / np.count_nonzero(movable)
    edge = developed_edges(turning + np.where(movable, missing, 0.0), log_ratio)
    length, u = np.abs(edge), np.stack((edge.real, edge.imag)) / np.abs(edge)
    gap = edge.sum()
    # length changes delta = l u . mu
    mu = np.linalg.solve((u * length) @ u.T, -np.array([gap.real, gap.imag]))
    return np.append(0, np.cumsum(edge * (1 + mu @ u))[:-1]), abs(gap)


def loop_gaps(loops, turning, log_ratio):
    """Return the gap of each loop of vertices, and the derivatives of the gaps, one loop after another."""
    gaps, q = [], [np.empty(0, np.complex128)]
    for loop in loops:
        angle, ratio = turning[loop], log_ratio[loop]
        # clockwise, because the mesh is to the left of the loop
        angle = angle - (angle.sum() + 2 * np.pi) / len(angle)
        edge = developed_edges(angle, ratio)
        to_end = np.cumsum(edge[::-1])[::-1]
        gaps.append(to_end[0])
        to_end = to_end + to_end[0] * np.arange(len(angle)) / len(angle)  # average over all starting vertices
        q.append(to_end - to_end.mean())
    return np.array(gaps), np.concatenate(q)
