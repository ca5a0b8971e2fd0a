"""Independent implementations of quality measures: flips, Jacobians, and deviations from a circle."""

from __future__ import annotations

from fractions import Fraction

import numpy as np


def count_flipped_exactly(uv: np.ndarray, F: np.ndarray) -> int:
    """Return the number of triangles without positive area, in rational arithmetic."""
    count = 0
    for face in F.tolist():
        (ax, ay), (bx, by), (cx, cy) = ([Fraction(x) for x in uv[v].tolist()] for v in face)
        count += (bx - ax) * (cy - ay) <= (by - ay) * (cx - ax)
    return count


def estimate_jacobians(V: np.ndarray, F: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Return the derivative of the inverse map of each triangle, (#F, 3, 2), by finite differences."""
    h = 1e-3 * np.ptp(uv)

    def surface(p: np.ndarray) -> np.ndarray:
        """Evaluate the affine inverse map of each triangle at its point of `p`."""
        corners = np.concatenate((uv[F].transpose(0, 2, 1), np.ones((len(F), 1, 3))), axis=1)
        weights = np.linalg.solve(corners, np.insert(p, 2, 1, axis=1)[..., None])[..., 0]
        return np.einsum("tk,tkx->tx", weights, V[F])

    p = uv[F].mean(axis=1)
    return np.stack([(surface(p + h * e) - surface(p - h * e)) / (2 * h) for e in np.eye(2)], axis=2)


def measure_circle_error(z: np.ndarray) -> float:
    """Return the range of the radii around the centre of the best-fit circle, relative to their mean."""
    A = np.column_stack((z, np.ones(len(z))))
    centre = np.linalg.lstsq(A, (z**2).sum(axis=1), rcond=None)[0][:2] / 2
    radius = np.linalg.norm(z - centre, axis=1)
    return float(np.ptp(radius) / radius.mean())
