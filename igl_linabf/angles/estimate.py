"""The angles of the surface, and the paper's initial estimate (section 4.2)."""

import numpy as np

from .. import _core
from .._types import BoolArray, FloatArray, IntArray
from ..surface import Mesh, Topology

CAP_ANGLE = 1e-7  # radians below pi above which a triangle's largest angle is too large


def corner_angles(mesh: Mesh) -> FloatArray:
    """Angles of the surface's triangles, (3, #F) radians."""
    return np.arctan2(mesh.double_area, mesh.dot)


def open_caps(alpha: FloatArray, least: float = CAP_ANGLE) -> tuple[FloatArray, IntArray]:
    """Angles (3, #F) with no angle within `least` of pi, and the faces that were changed for this.

    The two small angles of such a cap are scaled to sum to `least`. Closer to pi, its cotangents would
    exceed those of the faces around by more than double precision holds. Needles, with one small
    angle, need no change.
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
    """The paper's initial estimate (section 4.2), (3, #F) radians.

    If the angles around an interior vertex miss 2 pi by more than `threshold` radians, they are
    scaled to sum to 2 pi (the exponential map of the one-ring). All other angles stay. With
    `to_triangles`, each triangle's angles are then scaled to sum to pi, so that the constraints are
    linearised at angles of real triangles. `sums`, (#V,), has other sums, as `Constraints.sums`. At an
    ear, a vertex with one face, the sum is that triangle's angle.
    """
    estimate = alpha
    total = topology.sum_at_vertices(alpha)
    if sums is None:
        sums = np.where(topology.interior, 2 * np.pi, np.nan)
    far = np.abs(total - sums) > threshold  # not where there is none: NaN
    if far.any():
        estimate = alpha * np.where(far, sums / total, 1.0)[topology.corner]
        if to_triangles:
            estimate *= np.pi / estimate.sum(axis=0)
    asked_at = ~topology.interior & ~np.isnan(sums)
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


def rescaled(topology: Topology, length: FloatArray, log_scale: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Angles of triangles whose sides, (3, #F), are multiplied by exp((u_i + u_j) / 2) of their ends.

    Also returns which triangles cannot have such sides; their angles mean nothing.
    """
    # exp(-u / 2) of the vertex opposite to a side, times one factor for all three sides
    return _core.rescaled(topology.corner, length, np.exp(-log_scale / 2))
