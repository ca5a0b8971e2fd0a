"""Polygons inscribed in circles, and their angle sums, which depend on the edge lengths."""

from __future__ import annotations

import numpy as np
import scipy

from ..._types import FloatArray

MOST_WAVES = 32  # maximum number of predicted Fourier modes along a loop
SIDES_PER_WAVE = 4  # minimum number of sides per wavelength of a predicted Fourier mode


def compute_central_angles(log_ratio: FloatArray) -> FloatArray:
    """Return the central angles of the sides of a polygon that is inscribed in a circle; they sum to 2 pi.

    Parameters
    ----------
    log_ratio : (#P,) float64
        At each vertex, the logarithm of the ratio of the length of the next side to the length of the
        previous side. Side i starts at vertex i.
    """
    log_length = np.cumsum(log_ratio - log_ratio.mean())
    side = np.exp(log_length - log_length.max())
    longest = int(np.argmax(side))
    others = np.delete(side, longest)
    if others.sum() <= 1.0:  # no closed polygon: use angles proportional to the sides
        return np.asarray(2 * np.pi * side / side.sum())
    root = scipy.optimize.brentq
    # a side s subtends the angle 2 arcsin(s x) at the centre, with x = 1 / 2R; the longest side is 1
    if np.arcsin(others).sum() >= np.pi / 2:
        x = root(lambda x: np.arcsin(side * x).sum() - np.pi, 0.0, 1.0, xtol=1e-16, rtol=1e-15)
        angle = 2 * np.arcsin(side * x)
    else:  # the centre of the circle lies beyond the longest side
        # divide by x to remove the root at x = 0
        x = root(lambda x: (np.arcsin(others * x).sum() - np.arcsin(x)) / x, 1e-9, 1.0, rtol=1e-15)
        angle = 2 * np.arcsin(side * x)
        angle[longest] = 2 * np.pi - np.delete(angle, longest).sum()
    return np.asarray(angle * (2 * np.pi / angle.sum()))


def compute_inscribed_sums(log_ratio: FloatArray, hole: bool) -> FloatArray:
    """Return the angle sums at the vertices of a loop inscribed in a circle.

    With `hole`, the mesh lies outside the loop; otherwise inside.
    """
    central = compute_central_angles(log_ratio)
    turning = (central + np.roll(central, 1)) / 2
    return np.asarray(np.pi + turning if hole else np.pi - turning)


def predict_sum_changes(log_ratio: FloatArray, turning: FloatArray, hole: bool) -> FloatArray:
    """Predict how the angle sums of a circle will change while the angles of its loop approach these sums.

    The edge lengths change with the angles, and the sums of the circle change with the lengths. In a
    conformal map of the unit disk with scale u, the angle sums of the loop change by -du/dn per length. This
    is -k u for the k-th Fourier mode along the loop, while the sums of the circle change by -u. Therefore,
    the current difference is the share 1 - 1 / k of the required change, or the share 1 + 1 / k around a
    hole. The mode k = 1 belongs to maps of the disk onto itself, and contributes nothing to the difference.

    Parameters
    ----------
    log_ratio, turning : (#P,) float64
        At each vertex, the logarithm as in `compute_central_angles`, and the exterior angle.
    hole : bool
        Whether the mesh lies outside the loop.
    """
    central = compute_central_angles(log_ratio)
    share, at = (central + np.roll(central, 1)) / 2, np.concatenate(([0.0], np.cumsum(central)[:-1]))
    missing = turning + share if hole else turning - share
    mean = (central**2).sum() / (2 * np.pi)  # mean central angle, weighted by arc length
    k = np.arange(1.0, 1 + min(MOST_WAVES, int(2 * np.pi / (SIDES_PER_WAVE * mean))))
    wave = np.cumprod(np.broadcast_to(np.exp(1j * at), (len(k), len(at))), axis=0)
    gain = -1 / (k + 1) if hole else np.where(k > 1, 1 / np.maximum(k - 1, 1), 0.0)
    more = share * ((gain * (wave.conj() @ missing)) @ wave).real / np.pi
    return np.asarray(more - share * (more.sum() / share.sum()))  # keeps the total of the angle sums
