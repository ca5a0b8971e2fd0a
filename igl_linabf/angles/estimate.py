"""Compute the angles of the surface, and the initial estimate of flat angles (section 4.2 of the paper)."""

import numpy as np

from .. import _core
from .._types import BoolArray, FloatArray, IntArray
from ..surface import Mesh, Topology

CAP_ANGLE = 1e-7  # radians; a triangle with an angle this close to pi is a cap


def corner_angles(mesh: Mesh) -> FloatArray:
    """Return the angles of the triangles of the surface, (3, #F) radians."""
    return np.arctan2(mesh.double_area, mesh.dot)


def limit_obtuse_angles(alpha: FloatArray, least: float = CAP_ANGLE) -> tuple[FloatArray, IntArray]:
    """Reduce angles close to pi; return the angles, (3, #F), and the faces that changed.

    A cap is a triangle with an angle within `least` of pi. Its two small angles are scaled to sum to `least`.
    Otherwise, the cotangents of a cap would exceed the cotangents of neighbouring faces by more than double
    precision can represent. Needles, which have a single small angle, need no change.
    """
    rest = alpha.sum(axis=0) - alpha.max(axis=0)
    caps = np.flatnonzero(rest < least)
    if not len(caps):
        return alpha, caps
    alpha = alpha.copy()
    small = alpha[:, caps] < np.pi / 2
    alpha[:, caps] = np.where(small, alpha[:, caps] * (least / rest[caps]), np.pi - least)
    return alpha, caps


def initial_estimate(
    topology: Topology,
    alpha: FloatArray,
    threshold: float = 1.0,
    to_triangles: bool = True,
    sums: FloatArray | None = None,
) -> FloatArray:
    """Compute the initial estimate of the angles (section 4.2 of the paper), (3, #F) radians.

    If the angles around an interior vertex differ from 2 pi by more than `threshold` radians, they are scaled
    to sum to 2 pi (the exponential map of the one-ring). All other angles stay unchanged. With
    `to_triangles`, the angles of each triangle are then scaled to sum to pi, so that the constraints are
    linearised at the angles of real triangles. `sums`, (#V,), replaces 2 pi by other angle sums, as in
    `Constraints.sums`. At an ear, a vertex with a single face, the angle of this face is set to the
    prescribed sum.
    """
    estimate = alpha
    total = topology.sum_at_vertices(alpha)
    if sums is None:
        sums = np.where(topology.is_interior, 2 * np.pi, np.nan)
    far = np.abs(total - sums) > threshold  # False where `sums` is NaN
    if far.any():
        estimate = alpha * np.where(far, sums / total, 1.0)[topology.corner]
        if to_triangles:
            estimate *= np.pi / estimate.sum(axis=0)
    asked_at = ~topology.is_interior & ~np.isnan(sums)
    if asked_at.any():
        ears = asked_at & (np.bincount(topology.corner.ravel(), minlength=topology.n) == 1)
        k, t = np.nonzero(ears[topology.corner])
        estimate = estimate.copy()
        estimate[k, t] = asked = sums[topology.corner[k, t]]
        others = (k + 1) % 3, (k + 2) % 3
        share = (np.pi - asked) / (estimate[others[0], t] + estimate[others[1], t])
        for other in others:
            estimate[other, t] *= share
    return estimate


def compute_rescaled_angles(
    topology: Topology, length: FloatArray, log_scale: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return the angles, (3, #F), of the triangles after side ij is scaled by exp((u_i + u_j) / 2).

    `length`, (3, #F), are the sides before scaling, and `log_scale`, (#V,), is u. Also return a mask of the
    triangles whose scaled sides violate the triangle inequality. Their angles are meaningless.
    """
    # scale each side by exp(-u / 2) at the opposite vertex: this differs by one factor per triangle
    return _core.rescaled_angles(topology.corner, length, np.exp(-log_scale / 2))
