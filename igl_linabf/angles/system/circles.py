"""Polygons inscribed in circles: their angle sums, which depend on the lengths."""

from __future__ import annotations

import numpy as np
import scipy

from ..._types import FloatArray
from .constants import MOST_WAVES, SIDES_PER_WAVE


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
    root = scipy.optimize.brentq
    # the sides s see 2 arcsin(s / 2R); x = 1 / 2R, and the longest is 1
    if np.arcsin(others).sum() >= np.pi / 2:
        x = root(lambda x: np.arcsin(side * x).sum() - np.pi, 0.0, 1.0, xtol=1e-16, rtol=1e-15)
        angle = 2 * np.arcsin(side * x)
    else:  # the centre is beyond the longest side
        # divided by x, which is no root
        x = root(lambda x: (np.arcsin(others * x).sum() - np.arcsin(x)) / x, 1e-9, 1.0, rtol=1e-15)
        angle = 2 * np.arcsin(side * x)
        angle[longest] = 2 * np.pi - np.delete(angle, longest).sum()
    return np.asarray(angle * (2 * np.pi / angle.sum()))


def inscribed_sums(log_ratio: FloatArray, hole: bool) -> FloatArray:
    """Angle sums at the vertices of a loop that is inscribed in a circle, the mesh inside or around it."""
    centre = central_angles(log_ratio)
    turning = (centre + np.roll(centre, 1)) / 2
    return np.asarray(np.pi + turning if hole else np.pi - turning)


def predicted_change(log_ratio: FloatArray, turning: FloatArray, hole: bool) -> FloatArray:
    """How much more the sums of a circle change while a loop's angles change to them.

    With the angles change the lengths, and with these the sums of the circle. In a conformal map of the unit
    disk with the scale u, the sums change by -du/dn per length, which is -k u for the k-th wave along the
    loop, and those of the circle by -u. So what is missing now is 1 - 1 / k of the change, and 1 + 1 / k
    around a hole. The wave k = 1 is that of maps of the disk onto itself, and is not missing.

    Parameters
    ----------
    log_ratio, turning : (#P,) float64
        At each vertex, as in `central_angles`, and the exterior angle.
    hole : bool
        The mesh is around it.
    """
    centre = central_angles(log_ratio)
    share, at = (centre + np.roll(centre, 1)) / 2, np.concatenate(([0.0], np.cumsum(centre)[:-1]))
    missing = turning + share if hole else turning - share
    mean = (centre**2).sum() / (2 * np.pi)  # of the central angles, over the circle
    k = np.arange(1.0, 1 + min(MOST_WAVES, int(2 * np.pi / (SIDES_PER_WAVE * mean))))
    wave = np.cumprod(np.broadcast_to(np.exp(1j * at), (len(k), len(at))), axis=0)
    gain = -1 / (k + 1) if hole else np.where(k > 1, 1 / np.maximum(k - 1, 1), 0.0)
    more = share * ((gain * (wave.conj() @ missing)) @ wave).real / np.pi
    return np.asarray(more - share * (more.sum() / share.sum()))  # the sums keep their total
