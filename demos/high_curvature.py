"""Spikes
======

Figure 3 of the paper shows surfaces of high Gauss curvature. Here they are a spiky surface of revolution and
a crown. Both are height fields over a round plate.

At a tip, the angle sum deviates from 2 pi by far more than a radian. Therefore linear ABF uses the
exponential map of section 4.2 there. On the crown, LSCM flips triangles. Linear ABF flips none, and its map
is closer to the map of ABF.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import igl
import numpy as np
from compare_lscm import show


def rings(count: int, height: Callable[[np.ndarray], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return a round plate of `count` rings of triangles, lifted by the function `height`."""
    z, F, first = [np.zeros(1)], [], 0
    for k in range(1, count + 1):
        z.append(k / count * np.exp(2j * np.pi * np.arange(6 * k) / (6 * k)))
        last, first = first, first + max(1, 6 * (k - 1))
        for side in range(6):
            inner = last + (side * (k - 1) + np.arange(k)) % max(1, 6 * (k - 1))
            outer = first + (side * k + np.arange(k + 1)) % (6 * k)
            F.append(np.column_stack((inner, outer[:-1], outer[1:])))
            F.append(np.column_stack((inner[:-1], outer[1:-1], inner[1:])))
    plate = np.concatenate(z)
    return np.column_stack((plate.real, plate.imag, height(plate))), np.concatenate(F)


def spike(distance: np.ndarray, height: float, width: float) -> np.ndarray:
    """Return the height of a spike or ridge of half-width `width` at a distance from its top."""
    return height * np.maximum(0, 1 - distance / width)


def spiky(z: np.ndarray) -> np.ndarray:
    """Return the height of a spike on the axis and two sharp ridges around it."""
    r = np.abs(z)
    return spike(r, 1.5, 0.3) + spike(np.abs(r - 0.5), 0.35, 0.12) + spike(np.abs(r - 0.8), 0.25, 0.1)


def crown(z: np.ndarray) -> np.ndarray:
    """Return the height of a spike on the axis and six spikes around it."""
    centres = 0.55 * np.exp(2j * np.pi * np.arange(6) / 6)
    return spike(np.abs(z), 0.8, 0.2) + sum(spike(np.abs(z - at), 0.7, 0.18) for at in centres)


if __name__ == "__main__":
    for name, height, lscm_flips in (("spiky", spiky, False), ("crown", crown, True)):
        V, F = rings(40, height)
        deficit = 2 * np.pi - igl.internal_angles(V, F)[F == 0].sum()
        print(f"\n{name}: angle deficit at the middle {deficit:.2f} rad\n")
        measured = show(V, F, Path("out") / name)
        assert deficit > 4
        assert (measured["igl.lscm"].flips > 0) == lscm_flips
        assert measured["linABF"].flips == measured["ABF"].flips == 0
        assert measured["linABF"].report.angle_error < measured["igl.lscm"].report.angle_error
        assert measured["linABF"].angle_distortion < 1.06 * measured["ABF"].angle_distortion
