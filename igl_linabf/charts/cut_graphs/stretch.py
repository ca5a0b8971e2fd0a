"""Predict the stretch of a map from its seam.

A conformal map has the scale e^u, where L u = -K and u = 0 on the seam; L is the Laplacian, K the curvature.

An isometric map stretches a surface less than a conformal map, because it need not preserve angles. Its
strain is small and obeys linear elasticity: among all strains that remove the curvature, it minimises the
integral of the squared strain. In terms of Airy's stress function, the trace w of the strain minimises the
integral of w^2 subject to L w = -K off the seam, with arbitrary values on the seam. Thus w is u minus its
orthogonal projection onto the functions that are harmonic off the seam. The L2 stretch is then 1 + 3/4 of the
mean of w^2.
"""

import numpy as np

from ..._types import FloatArray, IntArray
from ...flattening import Isometric, Method
from .closed_surface import ClosedSurface

MAX_LOG_SCALE = 100.0  # log scales are clipped to this value; scales beyond exp(350) overflow when squared
ISOMETRIC_STRETCH_WEIGHT = 6.0  # weight in the cost of an atlas of (L2 stretch - 1) of an isometric map
MAX_TRACE_STEPS = 6  # number of conjugate gradient steps that compute the trace of the strain


def predict_stretch(closed: ClosedSurface, fixed: IntArray) -> tuple[float, FloatArray]:
    """Return the expected L2 stretch of the map of a surface cut at the nodes `fixed`, and the log scale.

    The log scale, (n,), is u for a conformal map and w for an isometric map. For an isometric map, the
    stretch minus 1 is multiplied by `ISOMETRIC_STRETCH_WEIGHT`.
    """
    if not closed.isometric:
        u = solve_log_scale(closed, fixed, closed.curvature)
        return predict_conformal_stretch(closed, u), u
    stretch, w = _solve_isometric(closed, fixed)
    return 1 + ISOMETRIC_STRETCH_WEIGHT * (stretch - 1), w


def predict_isometric_stretch(closed: ClosedSurface, fixed: IntArray) -> float:
    """Return the expected L2 stretch of an isometric map of the surface cut at the nodes `fixed`."""
    return _solve_isometric(closed, fixed)[0]


def _solve_isometric(closed: ClosedSurface, fixed: IntArray) -> tuple[float, FloatArray]:
    """Return the L2 stretch of an isometric map, and the trace w of its strain."""
    weight = closed.area / closed.area.sum()
    w = _solve_trace(closed, fixed, weight)
    return 1 + 0.75 * float(weight @ w**2), w


def predict_conformal_stretch(closed: ClosedSurface, u: FloatArray) -> float:
    """Return the L2 stretch of a conformal map with the log scale u."""
    weight = closed.area / closed.area.sum()
    return float(np.sqrt((weight @ np.exp(-2 * u)) * (weight @ np.exp(2 * u))))


def solve_log_scale(closed: ClosedSurface, fixed: IntArray, curvature: FloatArray) -> FloatArray:
    """Return the logarithm of the conformal scale that removes `curvature` and is 1 at the nodes `fixed`."""
    u = closed.laplacian.dirichlet_solver.solve(fixed, -curvature)
    return np.clip(u, -MAX_LOG_SCALE, MAX_LOG_SCALE)


def _solve_trace(closed: ClosedSurface, fixed: IntArray, weight: FloatArray) -> FloatArray:
    """Compute the strain trace w of least mean square by conjugate gradients.

    L w = -K holds outside the nodes `fixed`; the unknowns are the values of w at `fixed`. A hole is one node,
    but w varies along its boundary; therefore the nodes adjacent to holes are unknowns, too.
    """
    fixed, whole = np.union1d(fixed, closed.graph.nodes_near_holes), closed.laplacian.full_matrix
    solve, values = closed.laplacian.dirichlet_solver.make_solver(fixed), np.zeros(closed.graph.n)
    w, step, last = solve(-closed.curvature), np.zeros(len(fixed)), np.inf
    for _ in range(MAX_TRACE_STEPS):
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
    return np.clip(w, -MAX_LOG_SCALE, MAX_LOG_SCALE)


def get_stretch_weight(method: Method) -> float:
    """Return the weight of (L2 stretch - 1) in the cost of a map computed by `method`."""
    return ISOMETRIC_STRETCH_WEIGHT if isinstance(method, Isometric) else 1.0
