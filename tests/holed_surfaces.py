"""Surfaces with holes."""

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


def slotted_plate(turns: int) -> Surface:
    """Return a square plate with a spiral slot; the boundary of the slot is longer than the rim."""
    n, cell, step = 8 * turns + 8, (4 * turns + 4) * (1 + 1j), 1 + 0j
    cut = np.zeros((n, n), dtype=bool)
    for side in range(1, 4 * turns):
        for _ in range(2 * side):
            cut[int(cell.imag), int(cell.real)] = True
            cell += step
        step *= 1j
    return plate_without_cells(cut)


def plate_with_comb(teeth: int) -> Surface:
    """Return a square plate with a comb-shaped window, whose boundary is longer than the rim of the plate."""
    n = 4 * teeth + 4
    cut = np.zeros((n, n), dtype=bool)
    cut[2:-2, 2:-2] = (np.arange(n - 4) % 4 < 2) | (np.arange(n - 4) < 2)[:, None]
    return plate_without_cells(cut)


def plate_without_cells(cut: np.ndarray) -> Surface:
    """Return a square plate of side 10 without the cells that are marked in a mask (n, n)."""
    n = len(cut)
    y, x = np.divmod(np.arange((n + 1) ** 2), n + 1)
    V = np.column_stack((x, y, 0 * x)) * (10 / n)
    row, column = np.nonzero(~cut)
    corner = row * (n + 1) + column
    F = np.concatenate([corner[:, None] + [0, *ends] for ends in ((1, n + 2), (n + 2, n + 1))])
    V, F, *_ = igl.remove_unreferenced(V, F)
    return V, F


def surface(name: str) -> Surface:
    if name == "comb":
        return plate_with_comb(5)
    if name == "slot":
        return slotted_plate(3)
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
