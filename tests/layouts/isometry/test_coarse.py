"""Newton steps on a grid of displacements approach the isometric map without flips."""

import numpy as np
import pytest

from igl_linabf import flatten, linabf, quality
from igl_linabf.layouts.isometry import maps


def test_displacements_on_a_grid_reach_most_of_the_isometric_map(monkeypatch: pytest.MonkeyPatch) -> None:
    n = 120
    row, column = np.mgrid[:n, :n].astype(float)
    V = np.stack((column, row, 12 * np.sin(column / 20) * np.cos(row / 17)), axis=2).reshape(-1, 3)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    F = np.concatenate((np.column_stack((a, a + 1, a + n)), np.column_stack((a + 1, a + n + 1, a + n))))
    free = quality(V, F, flatten(V, F, method="isometric").uv)
    conformal = quality(V, F, linabf(V, F))
    monkeypatch.setattr(maps, "MOST_FREE_VERTICES", 1000)
    result = flatten(V, F, method="isometric")
    coarse = quality(V, F, result.uv)
    assert result.outcome.good and coarse.flips == 0
    gained = conformal.symmetric_dirichlet - coarse.symmetric_dirichlet
    assert gained > 0.9 * (conformal.symmetric_dirichlet - free.symmetric_dirichlet)
    assert coarse.area_distortion < 0.5 * conformal.area_distortion + 0.5 * free.area_distortion
