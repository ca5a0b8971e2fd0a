"""Find the outer loop of a surface with holes: the boundary loop that encloses all holes in a flat map."""

import numpy as np

from .._core import laplacian_entries, sum_by_index, symmetric_pattern
from .._types import FloatArray, IntArray
from ..linalg import Solvers
from .topology import Topology

ROUNDING = 1e-9  # relative tolerance when lengths of loops are compared with extents
MIN_LEAD = np.pi  # loops whose total turnings differ by less than this, radians, are compared by length
MIN_WEIGHT, MAX_WEIGHT = 1e-6, 1e6  # edge weights are clipped to this range to keep the matrix definite


def find_outer_loop(V: FloatArray, topology: Topology, double_area: FloatArray, dot: FloatArray) -> int:
    """Return the index of the outer loop of a planar surface, with areas and products as in `Mesh`.

    The loop that encloses all other loops is more than twice as long as the extent of any of them. If several
    loops are long enough, the outer loop is the loop with the largest total turning. On a flat surface, the
    turning of the outer loop is 2 pi, and the turning of a hole is -2 pi.
    """
    if len(topology.loops) == 1:
        return 0
    length, extent = np.empty((2, len(topology.loops)))
    for i, loop in enumerate(topology.loops):
        length[i] = np.linalg.norm(V[np.roll(loop, -1)] - V[loop], axis=1).sum()
        extent[i] = np.ptp(V[loop], axis=0).max()
    able = np.flatnonzero(length > (2 - ROUNDING) * extent.max())
    if len(able) == 1:
        return int(able[0])
    turning = _compute_loop_turnings(topology, np.arctan2(double_area, dot))
    return int(able[_choose_by_turning(turning[able], length[able])])


def find_outer_loop_of_angles(topology: Topology, alpha: FloatArray) -> int:
    """Return the index of the outer loop of a planar surface, given its angles, (3, #F), only."""
    if len(topology.loops) == 1:
        return 0
    edges = np.array([len(loop) for loop in topology.loops])
    return _choose_by_turning(_compute_loop_turnings(topology, alpha), edges)


def _choose_by_turning(turning: FloatArray, length: FloatArray | IntArray) -> int:
    """Return the index of the longest loop among those whose turning is within `MIN_LEAD` of the largest."""
    return int(np.argmax(np.where(turning > turning.max() - MIN_LEAD, length, -1)))


def _compute_loop_turnings(topology: Topology, alpha: FloatArray) -> FloatArray:
    """Return the total turning of each boundary loop, in radians, in a flat map of the surface.

    The map is the conformal map whose scale is 1 along the boundary. On the surface itself, the turning of a
    loop would depend on every bump next to the loop.
    """
    bend = np.where(topology.is_interior, 2 * np.pi, np.pi) - topology.sum_at_vertices(alpha)
    weight = np.clip(topology.sum_at_edges(1 / np.tan(alpha)) / 2, MIN_WEIGHT, MAX_WEIGHT)
    log_scale = _solve_dirichlet(topology, weight, bend)
    a, b = topology.edges.T
    flux = weight * (log_scale[b] - log_scale[a])
    bend += sum_by_index(a, flux, topology.n) - sum_by_index(b, flux, topology.n)
    return np.array([bend[loop].sum() for loop in topology.loops])


def _solve_dirichlet(topology: Topology, weight: FloatArray, r: FloatArray) -> FloatArray:
    """Return x with L x = r at interior vertices and x = 0 on the boundary, for weights of the edges."""
    inside = topology.is_interior
    n = int(np.count_nonzero(inside))
    x = np.zeros(topology.n)
    if n:
        ends = np.where(inside, np.cumsum(inside) - 1, -1)[np.ascontiguousarray(topology.edges.T)]
        indptr, indices, slot = symmetric_pattern(ends, n)
        factor = Solvers().analyse(indptr, indices).factor(laplacian_entries(indptr, slot, ends, weight))
        x[inside] = factor.solve(r[inside])
    return x
