"""Distortions of triangles agree with computations that are independent of the library."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import load
from own_measures import estimate_jacobians

from igl_linabf import MeshError, distortion, linabf, quality


@pytest.mark.parametrize("name", ["bumps", "cortex"])
def test_distortions_of_triangles_agree_with_finite_differences_and_igl(name: str) -> None:
    V, F = load(name)
    # shear the map, so that no measure has its ideal value
    uv = linabf(V, F) @ np.array([[3.0, 1.0], [0.5, 2.0]])
    sigma = np.linalg.svd(estimate_jacobians(V, F, uv), compute_uv=False)
    area, flat = igl.doublearea(V, F), igl.doublearea(uv, F)
    share = (flat / flat.sum()) / (area / area.sum())
    before, after = igl.internal_angles(V, F), igl.internal_angles(uv, F)
    assert np.allclose(distortion(V, F, uv), (((after - before) / before) ** 2).mean(axis=1))
    assert np.allclose(distortion(V, F, uv, "conformal"), sigma[:, 0] / sigma[:, 1])
    scaled = np.sqrt((sigma**2).mean(axis=1) * flat.sum() / area.sum())
    assert np.allclose(distortion(V, F, uv, "stretch"), scaled)
    assert np.allclose(distortion(V, F, uv, "area"), np.log(share))


def test_figures_of_the_whole_map_follow_from_its_triangles() -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    weight, q = igl.doublearea(V, F) / igl.doublearea(V, F).sum(), quality(V, F, uv)
    assert np.isclose(distortion(V, F, uv).mean(), q.angle_distortion)
    assert np.isclose(weight @ distortion(V, F, uv, "conformal"), q.conformal_distortion)
    assert np.isclose(np.sqrt(weight @ distortion(V, F, uv, "stretch") ** 2), q.stretch_l2)
    assert np.isclose(weight @ np.abs(distortion(V, F, uv, "area")), q.area_distortion)


def test_collapsed_triangles_are_infinite_and_flipped_triangles_equal_their_mirror_image() -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    for measure in ("angle", "conformal", "stretch", "area"):
        assert np.allclose(distortion(V, F, uv, measure), distortion(V, F, uv * [1, -1], measure))
    uv[F[0]] = uv[F[0, 0]]
    assert distortion(V, F, uv, "conformal")[0] == distortion(V, F, uv, "stretch")[0] == np.inf
    assert distortion(V, F, uv, "area")[0] == -np.inf
    assert np.isfinite(distortion(V, F, uv)).all()


def test_invalid_arguments_are_rejected() -> None:
    V, F = load("bumps")
    with pytest.raises(ValueError, match="'angle', 'conformal', 'stretch', 'area'"):
        distortion(V, F, V[:, :2], "sheer")
    with pytest.raises(MeshError, match="one row a vertex"):
        distortion(V, F, V[1:, :2])
