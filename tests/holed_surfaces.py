"""Generate surfaces with holes."""

from __future__ import annotations

import igl
import numpy as np
from conftest import load
from high_curvature import rings

Surface = tuple[np.ndarray, np.ndarray]


def remove_near(V: np.ndarray, F: np.ndarray, centres: np.ndarray, radius: float) -> Surface:
    """Remove the faces that have a vertex within `radius` of one of the centres."""
    near = (np.linalg.norm(V[:, None] - centres, axis=2) < radius).any(axis=1)
    V, F, *_ = igl.remove_unreferenced(V, F[~near[F].any(axis=1)])
    return V, F


def plate(holes: int, wave: float) -> Surface:
    """Return a round plate with holes along a spiral, lifted by a wave."""
    V, F = rings(40, lambda z: 0 * z.real)
    i = np.arange(holes) + 0.5
    z = 0.9 * np.sqrt(i / holes) * np.exp(2.399963j * i) if holes > 1 else np.zeros(1)
    V, F = remove_near(V, F, np.column_stack((z.real, z.imag, 0 * z.real)), 0.05 if holes > 1 else 0.4)
    V[:, 2] = wave * np.sin(4 * V[:, 0]) * np.cos(3 * V[:, 1])
    return V, F


def surface(name: str) -> Surface:
    if name == "annulus":
        return plate(1, 0.0)
    if name == "plate":
        return plate(30, 0.0)
    if name == "wavy plate":
        return plate(30, 0.15)
    if name == "hemisphere":
        V, F = rings(30, lambda z: np.sqrt(np.maximum(0, 1.01 - np.abs(z) ** 2)))
        return remove_near(V, F, np.array([[0.4, 0.0, np.sqrt(1.01 - 0.16)]]), 0.3)
    if name == "crown":
        from holes import crown_without_tips

        return crown_without_tips()
    return load(name)
