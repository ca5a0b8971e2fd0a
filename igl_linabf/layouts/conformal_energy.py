"""The least-squares layout: the conformal energy of triangles with the target angles (section 5)."""

import numpy as np

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..linalg import NotPositiveDefiniteError, Pattern, Solvers
from ..surface import Topology

DENSE = 64  # vertices, up to which the system is a dense matrix


def least_squares(
    topology: Topology,
    cot: FloatArray,
    pinned: IntArray,
    position: ComplexArray,
    solvers: Solvers,
    width: float = 1.0,
) -> tuple[ComplexArray, str]:
    """Minimise the conformal energy from triangles with the target angles (the paper's section 5).

    E(z) = 1/4 sum cot(alpha) |z_i - z_j|^2 - area(z) = 1/2 z^H (L + i Q) z, L the cotangent
    Laplacian of the target angles and Q skew, on the boundary edges only; the pins, at least two,
    are eliminated and one complex Hermitian system is factored. With `width` times the area in E, a strip
    beside a line of pins gets this share of its width. Returns the map and the solver's name.
    """
    row = np.zeros(topology.n, dtype=np.int64)
    row[pinned] = -1
    free = row == 0
    a, b = topology.edges.T
    weight = topology.sum_at_edges(cot) / 2
    entry = -weight + 0.5j * width * (topology.sides[1] < 0)  # from a to b, the mesh on the left
    z = np.zeros(topology.n, dtype=np.complex128)
    z[pinned] = position
    if not free.any():
        return z, "none"
    if topology.n <= DENSE:
        z[free] = _dense(topology.edges, weight, entry, z, free)
        return z, "dense Cholesky"
    row[free] = np.arange(np.count_nonzero(free))
    pattern = Pattern(topology, row, len(row) - len(pinned))
    i, j = pattern.ends
    rhs = [
        pattern.row_sums(i, part(entry * z[b])) + pattern.row_sums(j, part(entry.conj() * z[a]))
        for part in (np.real, np.imag)
    ]
    lower = pattern.hermitian(entry, pattern.row_sums(i, weight) + pattern.row_sums(j, weight))
    factored = solvers.whole(lower).factor(lower)
    z[free] = factored.solve(-rhs[0] - 1j * rhs[1])
    return z, factored.name


def _dense(
    edges: IntArray, weight: FloatArray, entry: ComplexArray, z: ComplexArray, free: BoolArray
) -> ComplexArray:
    """The free coordinates beside those that are pinned, where a sparse matrix would cost more."""
    (a, b), n = edges.T, len(z)
    whole = np.diag(np.bincount(edges.ravel(), np.repeat(weight, 2), n).astype(np.complex128))
    whole[a, b], whole[b, a] = entry, entry.conj()
    own = whole[free][:, free]
    try:
        lower = np.linalg.cholesky(own)
    except np.linalg.LinAlgError:
        raise NotPositiveDefiniteError(0) from None
    half = np.linalg.solve(lower, -whole[free][:, ~free] @ z[~free])
    return np.asarray(np.linalg.solve(lower.conj().T, half))


def far_apart(points: FloatArray) -> IntArray:
    """Two points of a closed polygon (#P, dim) half its length apart; of such pairs the most distant."""
    arc = np.concatenate(([0], np.cumsum(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1))))
    opposite = np.searchsorted(arc, (arc[:-1] + arc[-1] / 2) % arc[-1]) % len(points)
    i = int(np.argmax(np.linalg.norm(points - points[opposite], axis=1)))
    return np.array([i, opposite[i]])
