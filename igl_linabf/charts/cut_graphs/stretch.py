"""The stretch to expect of a map, from its seam alone.

A conformal map has the scale e^u, with L u = -K and u = 0 on the seam; L is the Laplacian, K the curvature.

An isometric map does not keep angles, and so has less to stretch. Its strain is small and obeys linear
elasticity: of all strains that take the curvature away, it is the one of the least integral of squares. By
Airy's stress function its trace w is the one of the least integral of w^2 with L w = -K off the seam,
whatever w is on it: u without its harmonic part. The L2 stretch is then 1 + 3/4 of the mean of w^2.
"""

import numpy as np
from scipy import sparse

from ..._types import FloatArray, IntArray
from ...flattening import Isometric, Method
from . import constants
from .closed_surface import ClosedSurface


def expected(closed: ClosedSurface, fixed: IntArray) -> tuple[float, FloatArray]:
    """L2 stretch of the map of a surface cut at the nodes `fixed`, and the log scale that makes it, (n,).

    It is u of a conformal map, and w of an isometric one, whose stretch beyond 1 is multiplied by
    `ISOMETRIC_STRETCH_WEIGHT`.
    """
    if not closed.isometric:
        u = log_scale(closed, fixed, closed.curvature)
        return expected_stretch(closed, u), u
    stretch, w = _isometric(closed, fixed)
    return 1 + constants.ISOMETRIC_STRETCH_WEIGHT * (stretch - 1), w


def isometric_stretch(closed: ClosedSurface, fixed: IntArray) -> float:
    """The L2 stretch of an isometric map of the surface cut at the nodes `fixed`: 1 for none."""
    return _isometric(closed, fixed)[0]


def _isometric(closed: ClosedSurface, fixed: IntArray) -> tuple[float, FloatArray]:
    """The L2 stretch of an isometric map, and the trace w of its strain."""
    weight = closed.area / closed.area.sum()
    w = _trace(closed, fixed, weight)
    return 1 + 0.75 * float(weight @ w**2), w


def expected_stretch(closed: ClosedSurface, u: FloatArray) -> float:
    """The L2 stretch of a conformal map with the log scale u."""
    weight = closed.area / closed.area.sum()
    return float(np.sqrt((weight @ np.exp(-2 * u)) * (weight @ np.exp(2 * u))))


def log_scale(closed: ClosedSurface, fixed: IntArray, curvature: FloatArray) -> FloatArray:
    """Logarithm of the conformal scale that removes `curvature`; zero at the nodes `fixed`."""
    u = closed.laplacian.dirichlet.solve(fixed, -curvature)
    return np.clip(u, -constants.MAX_LOG_SCALE, constants.MAX_LOG_SCALE)


def _trace(closed: ClosedSurface, fixed: IntArray, weight: FloatArray) -> FloatArray:
    """The w of the least mean square with L w = -K off the nodes `fixed`, by conjugate gradients.

    Unknown are its values at these nodes. A hole is one node, but w varies along it: so the nodes around it
    are among them.
    """
    lower = closed.laplacian.lower
    whole = lower + sparse.tril(lower, -1).T
    if closed.graph.n_holes:
        fixed = np.union1d(fixed, closed.graph.adjacency[0][: closed.graph.n_holes].indices)
    solve, values = closed.laplacian.dirichlet.solver(fixed), np.zeros(closed.graph.n)
    w, step, last = solve(-closed.curvature), np.zeros(len(fixed)), np.inf
    for _ in range(constants.MAX_TRACE_STEPS):
        left = weight * w
        slope = (left - whole @ solve(left))[fixed]
        scaled = slope / weight[fixed]
        down = float(slope @ scaled)
        if not down > 0:
            break
        step, last = down / last * step - scaled, down
        values[fixed] = step
        h = solve(-(whole @ values))
        h[fixed] = step
        w = w + down / float(h @ (weight * h)) * h
    return np.clip(w, -constants.MAX_LOG_SCALE, constants.MAX_LOG_SCALE)


def stretch_weight(method: Method) -> float:
    """Return the factor of the L2 stretch beyond 1 in the cost of a map by this method."""
    return constants.ISOMETRIC_STRETCH_WEIGHT if isinstance(method, Isometric) else 1.0
