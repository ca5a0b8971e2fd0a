"""`unwrap` and `pack` can shrink the charts that no ray from outside reaches."""

from __future__ import annotations

import igl
import numpy as np
import pytest

from igl_linabf import Cones, Packing, find_seams, unwrap
from igl_linabf.charts import pack_together
from igl_linabf.charts.features import find_unseen_charts
from igl_linabf.uv import pack


def sphere(radius: float, centre: float = 0.0, inward: bool = False) -> tuple[np.ndarray, np.ndarray]:
    V, F = igl.upsample(*igl.icosahedron(), 2)
    V = radius * V / np.linalg.norm(V, axis=1)[:, None] + [centre, 0, 0]
    return V, F[:, ::-1] if inward else F


def together(*surfaces: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    first = np.cumsum([0, *(len(V) for V, _ in surfaces)])
    return np.concatenate([V for V, _ in surfaces]), np.concatenate(
        [F + k for (_, F), k in zip(surfaces, first, strict=False)]
    )


def measure_chart_scales(V: np.ndarray, F: np.ndarray, **options) -> np.ndarray:
    """Return the scale of the charts of the first and the last face, after checking all texel densities."""
    atlas = unwrap(V, F, packing=Packing(unseen=0.25, **options))
    TC = atlas.flat
    texels = igl.doublearea(TC, atlas.FTC) / igl.doublearea(V, F)
    found = np.array([np.sqrt(np.mean(texels[atlas.chart == k])) for k in range(len(atlas.charts))])
    said = np.array([chart.scale for chart in atlas.charts])
    assert np.allclose(found / found.max(), said, rtol=0.05)
    assert np.isclose(atlas.report.scale, found.max(), rtol=0.05)
    assert ("no ray from outside" in str(atlas)) == bool((said < 1).any())
    return said[np.array([atlas.chart[np.flatnonzero(F[:, 0] == corner)[0]] for corner in F[[0, -1], 0]])]


@pytest.mark.parametrize("options", [{}, {"resolution": 512}, {"resolution": 256, "texel_density": 60}])
def test_cavities_share_less_of_the_page(options) -> None:
    body = together(sphere(1.0), sphere(0.4, inward=True))
    assert measure_chart_scales(*body, **options).tolist() == [1.0, 0.25]
    # the surface turned inside out
    assert measure_chart_scales(body[0], body[1][:, ::-1], **options).tolist() == [1.0, 0.25]


def test_visible_charts_keep_their_texels() -> None:
    assert measure_chart_scales(*together(sphere(1.0), sphere(0.4, 3.0))).tolist() == [1.0, 1.0]
    V, F = sphere(1.0)
    bowl = V, F[V[F].mean(axis=1)[:, 2] < 0.7]  # the inner ball is visible through the opening of the bowl
    assert measure_chart_scales(*together(bowl, sphere(0.2))).tolist() == [1.0, 1.0]


def test_a_chart_that_fits_at_its_share_is_not_cut() -> None:
    V, F = together(sphere(1.0), sphere(0.9, inward=True))
    page = {"resolution": 512, "texel_density": 512 / 3}

    def inside(**more: float) -> int:
        """Return the charts of the inner sphere."""
        atlas = unwrap(V, F, packing=Packing(**page, **more))
        return len(np.unique(atlas.chart[len(F) // 2 :]))

    assert inside(unseen=0.25) < inside()


def test_the_quality_ignores_scales_of_charts() -> None:
    V, F = together(sphere(1.0), sphere(0.6, inward=True))
    even, smaller = (unwrap(V, F, find_seams(V, F), packing=Packing(unseen=share)) for share in (1, 0.25))
    assert [chart.scale for chart in smaller.charts] == [1.0, 0.25]
    for figure in ("stretch_l2", "texel_spread", "angle_distortion"):
        assert np.isclose(getattr(smaller.quality, figure), getattr(even.quality, figure), rtol=1e-6), figure
    assert np.isclose(smaller.cost.stretch, even.cost.stretch, rtol=1e-6)


@pytest.mark.parametrize(("scale", "share"), [("even", 0.25), ("keep", 0.125)])
def test_maps_are_packed_with_less_for_cavities(scale: str, share: float) -> None:
    V, F = together(sphere(1.0), sphere(0.4, inward=True))
    seams = find_seams(V, F) + 1
    V, F = np.concatenate(([[np.nan] * 3], V)), F + 1  # unused vertices are ignored
    n = len(F) // 2
    atlas = unwrap(V, F, seams, packing=Packing(unseen=0.5))
    packed = pack(V, F, atlas.TC, atlas.FTC, Packing(resolution=256, unseen=0.25), scale=scale)
    assert packed.unseen.tolist() == [False, True]
    texels = igl.doublearea(packed.TC, packed.FTC) / igl.doublearea(V, F)
    outer, inner = (
        np.sqrt(np.average(texels[part], weights=igl.doublearea(V, F)[part]))
        for part in (slice(n), slice(n, None))
    )
    assert np.isclose(inner / outer, share)
    assert np.isclose(outer, packed.scale) if scale == "even" else outer > packed.scale
    assert "1 unseen" in str(packed)
    assert not pack(V, F, atlas.TC, atlas.FTC).unseen.any()


def test_a_stack_is_visible_if_one_of_its_charts_is() -> None:
    V, F = together(sphere(1.0), sphere(0.4, inward=True))
    one = unwrap(*sphere(1.0))
    shared = np.concatenate((one.FTC, one.FTC[:, ::-1]))  # ball and cavity share their texels
    assert not pack(V, F, one.TC, shared, Packing(unseen=0.25)).unseen.any()
    within = sphere(0.4, inward=True), sphere(0.3)
    V, F = together(sphere(1.0), *within)
    moved = one.TC + np.array([2, 0])
    apart = np.concatenate((one.TC, moved))
    shared = np.concatenate((one.FTC, shared[len(one.FTC) :] + len(one.TC), one.FTC + len(one.TC)))
    assert pack(V, F, apart, shared, Packing(unseen=0.25)).unseen.tolist() == [False, True, True]


def test_faces_without_a_map_hide_charts_inside() -> None:
    V, F = together(sphere(1.0), sphere(0.4))
    one = unwrap(*sphere(0.4))
    FTC = np.concatenate((np.full_like(one.FTC, -1), one.FTC))
    assert pack(V, F, one.TC, FTC, Packing(unseen=0.25)).unseen.tolist() == [True]


def test_deep_bowls_are_visible_unless_a_lid_hides_them() -> None:
    V, F = igl.upsample(*igl.icosahedron(), 4)
    V = V / np.linalg.norm(V, axis=1)[:, None]
    middle = V[F].mean(axis=1)
    opening = (np.linalg.norm(middle[:, :2], axis=1) < 0.2) & (middle[:, 2] > 0)
    vase = together((V, F[~opening]), (0.9 * V, F[~opening][:, ::-1]))
    closed = together((V, F), (0.9 * V, F[~opening][:, ::-1]))
    for (points, faces), inner in ((vase, False), (closed, True)):
        outside = np.arange(len(faces)) < len(faces) - np.count_nonzero(~opening)
        charts = [np.flatnonzero(outside), np.flatnonzero(~outside)]
        for moved in (0, 1e6):
            assert find_unseen_charts(points + moved, faces, charts).tolist() == [False, inner]


def test_scales_are_kept_when_atlases_are_packed_again() -> None:
    V, F = together(sphere(1.0), sphere(0.4, inward=True))
    assert {chart.scale for chart in unwrap(V, F).charts} == {1.0}
    atlas = unwrap(V, F, packing=Packing(unseen=0.5))
    again = pack_together([atlas], Packing(resolution=512))[0]
    for made in (atlas, again):
        area = igl.doublearea(made.flat, made.FTC)
        small = np.flatnonzero([chart.scale < 1 for chart in made.charts])
        inside = np.isin(made.chart, small)
        ratio = area[inside].sum() / area[~inside].sum()
        assert np.isclose(ratio / 0.4**2, 0.25, rtol=0.02)


def test_unseen_needs_a_surface_without_cones() -> None:
    V, F = sphere(1.0)
    for wrong in (0, -1, 1.5, np.nan, "half"):
        with pytest.raises(ValueError, match="unseen is"):
            Packing(unseen=wrong)
    with pytest.raises(ValueError, match="cones"):
        unwrap(V, F, cones=Cones("auto"), packing=Packing(unseen=0.5))
    atlas = unwrap(V, F)
    with pytest.raises(ValueError, match="unseen is for unwrap"):
        pack_together([atlas], Packing(unseen=0.5))
