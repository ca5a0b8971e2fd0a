"""Surfaces whose maps overlap themselves."""

from __future__ import annotations

import numpy as np


def spiral() -> tuple[np.ndarray, np.ndarray]:
    """Return a flat helical band that winds by more than a full turn."""
    t = np.linspace(0, 9.0, 120)
    rings = [np.column_stack((r * np.cos(t), r * np.sin(t), 0.3 * t)) for r in (1.0, 1.25, 1.5, 1.75)]
    V, n = np.concatenate(rings), len(t)
    a = (np.arange(3)[:, None] * n + np.arange(n - 1)).ravel()
    return V, np.concatenate((np.column_stack((a, a + n, a + 1)), np.column_stack((a + 1, a + n, a + n + 1))))
