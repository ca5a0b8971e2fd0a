"""Polygons inscribed in a circle, from the ratios of their sides."""

import numpy as np
from scipy.optimize import brentq

from .._types import FloatArray


def central_angles(log_ratio: FloatArray) -> FloatArray:
    """The angles at which the circle's centre sees the sides of an inscribed polygon; they sum to 2 pi.

    Parameters
    ----------
    log_ratio : (#P,) float64
        The logarithm of the next side's length over the last one's, at each vertex. Side i leaves
        vertex i.
    """
    log_length = np.cumsum(log_ratio - log_ratio.mean())
    side = np.exp(log_length - log_length.max())
    longest = int(np.argmax(side))
    others = np.delete(side, longest)
    if others.sum() <= 1.0:  # no closed polygon has such sides: by their share of the length
        return np.asarray(2 * np.pi * side / side.sum())
    # the sides s see 2 arcsin(s / 2R); x = 1 / 2R, and the longest is 1
    if np.arcsin(others).sum() >= np.pi / 2:
        x = brentq(lambda x: np.arcsin(side * x).sum() - np.pi, 0.0, 1.0, xtol=1e-16, rtol=1e-15)
        angle = 2 * np.arcsin(side * x)
    else:  # the centre is beyond the longest side
        # divided by x, which is no root
        x = brentq(lambda x: (np.arcsin(others * x).sum() - np.arcsin(x)) / x, 1e-9, 1.0, rtol=1e-15)
        angle = 2 * np.arcsin(side * x)
        angle[longest] = 2 * np.pi - np.delete(angle, longest).sum()
    return np.asarray(angle * (2 * np.pi / angle.sum()))


def inscribed_sums(log_ratio: FloatArray, hole: bool) -> FloatArray:
    """Angle sums at the vertices of a loop that is inscribed in a circle, the mesh inside or around it."""
    centre = central_angles(log_ratio)
    turning = (centre + np.roll(centre, 1)) / 2
    return np.asarray(np.pi + turning if hole else np.pi - turning)
