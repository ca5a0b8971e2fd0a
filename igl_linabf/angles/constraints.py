"""Corner angles: the initial estimate and the constraints that a flat mesh's angles satisfy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..surface import NEXT, PREV, ComplexArray, FloatArray, IntArray, Mesh, Topology

CAP_ANGLE = 1e-7  # radians below pi above which a triangle's largest angle is too large


def corner_angles(mesh: Mesh) -> FloatArray:
    """Angles of the surface's triangles, (3, #F) radians."""
    return np.arctan2(mesh.double_area, mesh.dot)


def opened(alpha: FloatArray, least: float = CAP_ANGLE) -> tuple[FloatArray, IntArray]:
    """Angles (3, #F) with no angle within `least` of pi, and the faces where that took a repair.

    The two small angles of such a cap are scaled to sum to `least`. Beyond that, double precision
    does not hold its cotangents beside those of the faces around; needles, with one small angle,
    are no trouble.
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
class Closure:
    """The loops of the holes, as the angles draw them (design, section 3).

    What is missing of the turning and of the logarithms of the lengths is spread evenly over a
    loop first, and the gap over the derivative, so that nothing depends on the vertex where the
    drawing begins.

    Attributes
    ----------
    gap : (#holes,) complex128
        tau, by which each loop fails to close, in units of its length.
    vertex, hole : (#L,) int64
        The vertices of all these loops, and which hole each belongs to.
    q : (#L,) complex128
        From each of them to its loop's end, less the mean of that over the loop: the gap's
        derivative by log_ratio + i turning there.
    """

    gap: ComplexArray
    vertex: IntArray
    hole: IntArray
    q: ComplexArray


def closure_of(topology: Topology, turning: FloatArray, log_ratio: FloatArray) -> Closure:
    """Draw each hole's loop; `turning` and `log_ratio` as in `Residual`."""
    holes = topology.loops[1:]
    gap, q = np.zeros(len(holes), dtype=np.complex128), []
    for i, loop in enumerate(holes):
        angle, ratio = turning[loop], log_ratio[loop]
        angle = angle - (angle.sum() + 2 * np.pi) / len(loop)  # the mesh on the left: clockwise
        length = np.cumsum(ratio - ratio.mean())
        edge = np.exp(length - length.max() + 1j * np.cumsum(angle))  # it leaves the loop vertex
        edge /= np.abs(edge).sum()
        to_end = np.cumsum(edge[::-1])[::-1]
        gap[i] = to_end[0]
        to_end += gap[i] * np.arange(len(loop)) / len(loop)  # the mean over all beginnings
        q.append(to_end - to_end.mean())
    if not holes:
        return Closure(gap, np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), gap)
    hole = np.repeat(np.arange(len(holes)), [len(loop) for loop in holes])
    return Closure(gap, np.concatenate(holes), hole, np.concatenate(q))


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
    closure : Closure
        The holes' loops, drawn by them.
    """

    vertex: FloatArray
    wheel: FloatArray
    triangle: FloatArray
    turning: FloatArray
    log_ratio: FloatArray
    closure: Closure

    @property
    def largest(self) -> float:
        """Largest absolute value over the families: radians, logarithms, holes' relative gaps."""
        families = (self.vertex, self.wheel, self.triangle, self.closure.gap)
        return float(max(np.abs(r).max(initial=0.0) for r in families))


def residual(topology: Topology, alpha: FloatArray) -> Residual:
    """Residuals of the angle constraints at `alpha`, (3, #F) radians."""
    # an angle of 0 or pi, as in a collapsed triangle, counts as the smallest there is
    log_sin = np.sin(alpha)
    np.abs(log_sin, out=log_sin)
    np.maximum(log_sin, np.finfo(np.float64).tiny, out=log_sin)
    np.log(log_sin, out=log_sin)
    total = topology.sum_at_vertices(alpha)
    log_ratio = topology.sum_at_vertices(log_sin[PREV] - log_sin[NEXT])
    turning = np.pi - total
    return Residual(
        vertex=topology.target - topology.sum_at_rows(total),
        wheel=topology.sum_at_rows(log_ratio),
        triangle=np.pi - alpha.sum(axis=0),
        turning=turning,
        log_ratio=log_ratio,
        closure=closure_of(topology, turning, log_ratio),
    )
