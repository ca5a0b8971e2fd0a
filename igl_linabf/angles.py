"""Corner angles: the initial estimate and the constraints that a flat mesh's angles satisfy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .mesh import Mesh
from .topology import NEXT, PREV, FloatArray, Topology


def corner_angles(mesh: Mesh) -> FloatArray:
    """Angles of the surface's triangles, (3, #F) radians."""
    return np.arctan2(mesh.double_area, mesh.dot)


def initial_estimate(
    topology: Topology, alpha: FloatArray, threshold: float = 1.0, to_triangles: bool = True
) -> FloatArray:
    """The paper's initial estimate (section 4.2), (3, #F) radians.

    Around an interior vertex whose angles miss 2 pi by more than `threshold` radians they are
    scaled to sum to 2 pi (the exponential map of the one-ring); elsewhere, and on the boundary,
    they stay. With `to_triangles` each triangle's angles are then scaled to sum to pi, so that
    the estimate is one of real triangles and the linearisation is taken at a sound point.
    """
    estimate = alpha
    total = topology.sum_at_vertices(alpha)
    interior = topology.row >= 0
    for loop in topology.loops[1:]:
        interior[loop] = False
    far = interior & (np.abs(total - 2 * np.pi) > threshold)
    if far.any():
        estimate = alpha * np.where(far, 2 * np.pi / total, 1.0)[topology.corner]
        if to_triangles:
            estimate *= np.pi / estimate.sum(axis=0)
    return estimate


@dataclass(frozen=True, eq=False)
class Residual:
    """What is missing of the three constraint families (right-hand sides of eq. 5, 6 and 10).

    Attributes
    ----------
    vertex, wheel : (#rows,) float64
        target - sum alpha, and sum log sin(gamma) - log sin(beta).
    triangle : (#F,) float64
        pi - sum alpha.
    turning, log_ratio : (#V,) float64
        At a vertex of a boundary loop, the mesh on the left: the exterior angle, and the
        logarithm of the next edge's length over the last one's.
    """

    vertex: FloatArray
    wheel: FloatArray
    triangle: FloatArray
    turning: FloatArray
    log_ratio: FloatArray

    @property
    def largest(self) -> float:
        """Largest absolute value over the three families, in radians (wheel: a logarithm)."""
        return float(max(np.abs(r).max(initial=0.0) for r in (self.vertex, self.wheel, self.triangle)))


def residual(topology: Topology, alpha: FloatArray) -> Residual:
    """Residuals of the angle constraints at `alpha`, (3, #F) radians."""
    # an angle of 0 or pi, as in a collapsed triangle, counts as the smallest there is
    log_sin = np.log(np.maximum(np.abs(np.sin(alpha)), np.finfo(np.float64).tiny))
    total = topology.sum_at_vertices(alpha)
    log_ratio = topology.sum_at_vertices(log_sin[PREV] - log_sin[NEXT])
    return Residual(
        vertex=topology.target - topology.sum_at_rows(total),
        wheel=topology.sum_at_rows(log_ratio),
        triangle=np.pi - alpha.sum(axis=0),
        turning=np.pi - total,
        log_ratio=log_ratio,
    )
