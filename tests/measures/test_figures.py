"""Quality figures agree with computations that are independent of the library."""

from __future__ import annotations

from dataclasses import astuple

import igl
import numpy as np
import pytest
from conftest import bumps, load
from own_measures import estimate_jacobians

from igl_linabf import MeshError, flatten, overlaps, quality
from igl_linabf.measures import format_table, measure_qualities
from igl_linabf.surface import Submesh


@pytest.mark.parametrize("name", ["bumps", "cortex", "disk__igl_snail.obj"])
def test_stretch_and_conformal_distortion_agree_with_finite_differences(name: str) -> None:
    V, F = load(name)
    rng = np.random.default_rng(0)
    # shear the map, so that no figure has its ideal value
    uv = flatten(V, F).uv @ rng.normal(size=(2, 2)) * 3
    if np.median(igl.doublearea(uv, F)) < 0:
        uv = uv[:, ::-1]
    sigma = np.linalg.svd(estimate_jacobians(V, F, uv), compute_uv=False)
    area, flat = igl.doublearea(V, F), np.abs(igl.doublearea(uv, F))
    normalised = np.sqrt(flat.sum() / area.sum())
    q = quality(V, F, uv)
    assert np.isclose(q.stretch_l2, normalised * np.sqrt(area @ (sigma**2).mean(axis=1) / area.sum()))
    assert np.isclose(q.stretch_linf, normalised * sigma.max())
    squares = (normalised * sigma) ** 2
    energy = (squares + 1 / squares).sum(axis=1) / 4
    assert np.isclose(q.symmetric_dirichlet, area @ energy / area.sum())
    assert np.isclose(q.conformal_distortion, area @ (sigma[:, 0] / sigma[:, 1]) / area.sum())
    assert np.isclose(q.report.conformal_distortion_max, (sigma[:, 0] / sigma[:, 1]).max())
    ratio = np.log(flat / area * area.sum() / flat.sum())
    assert np.isclose(q.area_distortion, area @ np.abs(ratio) / area.sum())


@pytest.mark.parametrize("name", ["bumps", "cortex", "disk__igl_snail.obj"])
def test_edge_change_and_texel_spread_agree_with_their_definitions(name: str) -> None:
    V, F = load(name)
    uv = flatten(V, F).uv * 3
    area, flat = igl.doublearea(V, F), igl.doublearea(uv, F)
    sides = [np.linalg.norm(P[F[:, k]] - P[F[:, k - 1]], axis=1) for P in (V, uv) for k in range(3)]
    ratio = np.concatenate(sides[3:]) / np.concatenate(sides[:3]) * np.sqrt(area.sum() / flat.sum())
    q = quality(V, F, uv)
    assert np.isclose(q.edge_change, np.abs(ratio - 1).mean())
    assert np.isclose(q.report.edge_change_99, np.percentile(np.abs(ratio - 1), 99))
    order = np.argsort(flat / area)
    below = np.cumsum(area[order]) / area.sum()
    first, last = ((flat / area)[order][np.searchsorted(below, share)] for share in (0.01, 0.99))
    assert np.isclose(q.texel_spread, last / first)


def test_figures_of_concatenated_maps_equal_those_of_each_map() -> None:
    meshes = [(V, F, flatten(V, F).uv) for V, F in (bumps(60, 1), bumps(200, 2), load("bumps"))]
    flipped = meshes[1][2]
    near = meshes[1][1][7]
    # move a vertex across the opposite side, which flips a face
    flipped[near[0]] = flipped[near[1:]].mean(axis=0) * 2 - flipped[near[0]]
    assert quality(*meshes[1][:2], flipped).flips
    surfaces = [(Submesh.from_input(V, F), uv, quality(V, F, uv).overlaps) for V, F, uv in meshes]
    for together, (V, F, uv) in zip(measure_qualities(surfaces), meshes, strict=True):
        *figures, report, distances = astuple(together)
        *alone, report_alone, none = astuple(quality(V, F, uv))
        assert figures == pytest.approx(alone, rel=1e-9)
        assert report == pytest.approx(report_alone, rel=1e-9)
        assert distances is none is None


@pytest.mark.parametrize("name", ["bumps", "cortex", "disk__igl_camel_b.obj"])
def test_angles_and_flips_agree_with_igl(name: str) -> None:
    V, F = load(name)
    uv = flatten(V, F, method="lscm").uv
    uv[F[7, 0]] = uv[F[7, 1:]].mean(axis=0) + 0.2 * (uv[F[7, 1:]].mean(axis=0) - uv[F[7, 0]])  # flips a face
    before, after = igl.internal_angles(V, F), igl.internal_angles(uv, F)
    q = quality(V, F, uv)
    assert np.isclose(q.angle_distortion, (((after - before) / before) ** 2).mean())
    assert np.isclose(q.report.angle_error, ((after - before) ** 2).mean())
    assert q.flips == len(igl.flipped_triangles(uv, F)) >= 1
    assert q.report.faces == len(F)


def test_a_similarity_is_perfect_and_a_mirror_flips_all() -> None:
    V, F = load("bumps")
    V = V * [1, 1, 0]
    turn = np.array([[0.6, 0.8], [-0.8, 0.6]])
    q = quality(V, F, 7 * V[:, :2] @ turn + [3, 4])
    perfect = (q.conformal_distortion, q.report.conformal_distortion_max, q.stretch_l2, q.stretch_linf)
    assert np.allclose(perfect, 1)
    assert max(q.angle_distortion, q.report.angle_error, q.area_distortion) < 1e-12
    assert q.flips == 0
    assert quality(V, F, V[:, :2] * [1, -1]).flips == len(F)


def test_overlaps_are_counted_within_charts_and_not_between_them() -> None:
    V, F = load("bumps")
    twice, both = np.vstack((V, V + np.array([5, 0, 0]))), np.vstack((F, F + len(V)))
    onto_each_other = np.vstack((V[:, :2], V[:, :2] + 0.1))
    assert quality(twice, both, onto_each_other).overlaps == 0
    assert len(overlaps(onto_each_other, both, between=True)) > len(F)
    # fold the right half onto the left half
    folded = V[:, :2] * [1, 1] - 2 * np.maximum(V[:, :1], 0) * [1, 0]
    assert quality(V, F, folded).overlaps == len(overlaps(folded, F)) > len(F) / 2


def test_collapsed_triangles_count_as_flips_and_infinite_stretch() -> None:
    V, F = load("bumps")
    uv = V[:, :2].copy()
    uv[F[0]] = uv[F[0, 0]]
    q = quality(V, F, uv)
    assert q.flips >= 1
    assert q.stretch_l2 == q.stretch_linf == q.report.conformal_distortion_max == q.area_distortion == np.inf
    assert np.isfinite(q.angle_distortion)


@pytest.mark.parametrize("spoil", [lambda uv: uv[:-1], lambda uv: uv * np.nan, lambda uv: uv[:, :1]])
def test_maps_of_the_wrong_shape_are_rejected(spoil) -> None:
    V, F = load("bumps")
    with pytest.raises(MeshError, match="uv"):
        quality(V, F, spoil(V[:, :2]))


def test_quality_prints_as_a_table() -> None:
    V, F = load("bumps")
    q = quality(V, F, V[:, :2])
    assert f"{q.angle_distortion:.4g}" in str(q)
    text = format_table({"one": q, "two": q}, {"seconds": {"one": "1.5"}})
    lines = text.splitlines()
    assert lines[0].split() == ["one", "two"]
    assert lines[1].split() == ["triangles", f"{len(F):,}", f"{len(F):,}"]
    assert lines[-1].split() == ["seconds", "1.5"]


def test_a_collapsed_triangle_counts_as_a_flip() -> None:
    V, F = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1.0, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
    # the last vertex lies on the diagonal, which collapses a triangle
    flat = np.array([[0, 0], [1, 0], [1, 1], [0.5, 0.5]])
    assert quality(V, F, flat).flips == 1
