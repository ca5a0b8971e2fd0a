"""Charts that nobody sees from outside get the share of the texels that is asked for."""

from __future__ import annotations

import igl
import numpy as np
import pytest

from igl_linabf import Cones, Packing, Seams, check_uv, pack, pack_together, unwrap

HOLLOW_FACES = 80


@pytest.fixture(scope="module")
def hollow() -> tuple[np.ndarray, np.ndarray]:
    """A ball with a cavity, whose faces are the last ones."""
    V, F = igl.loop(*igl.icosahedron())
    return np.concatenate((V, V / 2)), np.concatenate((F, F[:, ::-1] + len(V)))


def densities(V: np.ndarray, TC: np.ndarray, F: np.ndarray, FTC: np.ndarray) -> np.ndarray:
    """Page widths per unit of length, of the ball and of the cavity."""
    a, b, c = V[F.T]
    p, q, r = TC[FTC.T]
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    flat = np.abs(np.linalg.det(np.stack((q - p, r - p), axis=1)))
    outer, inner = slice(HOLLOW_FACES), slice(HOLLOW_FACES, None)
    return np.sqrt([flat[part].sum() / area[part].sum() for part in (outer, inner)])


@pytest.mark.parametrize(
    "wish",
    [
        {},
        {"resolution": 256},
        {"resolution": 256, "texel_density": 30},
        {"resolution": 128, "texel_density": 60},  # charts are cut, and take several pages
        {"resolution": 128, "pages": 2},
    ],
)
@pytest.mark.parametrize("share", [0.5, 0.1])
def test_a_cavity_gets_its_share_of_the_texel_density(
    hollow: tuple[np.ndarray, np.ndarray], wish: dict[str, int], share: float
) -> None:
    V, F = hollow
    atlas = unwrap(V, F, packing=Packing(unseen=share, **wish))
    outer, inner = densities(V, atlas.TC, F, atlas.FTC)
    assert inner / outer == pytest.approx(share)
    assert atlas.scale == pytest.approx(outer)
    if "texel_density" in wish:
        assert outer * wish["resolution"] == pytest.approx(wish["texel_density"])
    inside = [bool((chart.faces >= HOLLOW_FACES).all()) for chart in atlas.charts]
    assert [chart.unseen for chart in atlas.charts] == inside
    assert atlas.good
    size = wish.get("resolution", 256)
    assert check_uv(V, F, atlas.TC, atlas.FTC, resolution=size).overlaps == 0


def test_a_smaller_cavity_leaves_the_others_more_texels_and_their_stretch_as_it_is(
    hollow: tuple[np.ndarray, np.ndarray],
) -> None:
    V, F = hollow
    even, smaller = (unwrap(V, F, packing=Packing(unseen=share)) for share in (1, 0.1))
    assert smaller.scale > 1.02 * even.scale
    assert smaller.quality.stretch_l2 == pytest.approx(even.quality.stretch_l2)
    assert "1 chart unseen from outside" in str(smaller)
    assert "unseen" not in str(even)
    assert not any(chart.unseen for chart in even.charts)


def test_a_chart_that_fits_only_at_its_share_is_not_cut(hollow: tuple[np.ndarray, np.ndarray]) -> None:
    V, F = hollow
    V = V * np.where(np.arange(len(V)) < len(V) // 2, 1, 1.9)[:, None]  # nearly as large as the ball
    atlas = unwrap(V, F, packing=Packing(resolution=128, texel_density=60, unseen=0.1))
    assert [chart.unseen for chart in atlas.charts].count(True) == 1
    assert [chart.unseen for chart in atlas.charts].count(False) > 1


def test_polygons_and_unused_vertices_make_no_difference() -> None:
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float) - 0.5
    cube = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    V = np.concatenate(([[np.nan] * 3], corners, corners / 2))
    F = np.concatenate((cube + 1, cube[:, ::-1] + 9))
    atlas = unwrap(V, F, Seams(), packing=Packing(unseen=0.5))
    assert [chart.unseen for chart in atlas.charts] == [bool((c.faces >= 6).all()) for c in atlas.charts]
    packed = pack(V, F, atlas.TC, atlas.FTC, Packing(unseen=0.5))
    assert packed.unseen.tolist() == [bool((packed.chart[6:] == i).any()) for i in range(len(packed.page))]


def test_pack_gives_it_beside_either_scale(hollow: tuple[np.ndarray, np.ndarray]) -> None:
    V, F = hollow
    atlas = unwrap(V, F, packing=Packing(unseen=0.5))
    for scale, share in (("even", 0.5), ("keep", 0.25)):
        packed = pack(V, F, atlas.TC, atlas.FTC, Packing(unseen=0.5), scale=scale)
        outer, inner = densities(V, packed.TC, F, packed.FTC)
        assert inner / outer == pytest.approx(share)
        assert packed.unseen.tolist() == [False, True]


def test_a_stack_is_seen_if_one_of_it_is(hollow: tuple[np.ndarray, np.ndarray]) -> None:
    V, F = hollow
    one = unwrap(V[: len(V) // 2], F[:HOLLOW_FACES])
    FTC = np.concatenate((one.FTC, one.FTC[:, ::-1]))  # ball and cavity share their texels
    packed = pack(V, F, one.TC, FTC, Packing(unseen=0.5))
    assert not packed.unseen.any()


def test_packing_together_keeps_the_share(hollow: tuple[np.ndarray, np.ndarray]) -> None:
    V, F = hollow
    atlas = unwrap(V, F, packing=Packing(unseen=0.5))
    for again in pack_together([atlas, atlas], Packing(resolution=256)):
        outer, inner = densities(V, again.TC, F, again.FTC)
        assert inner / outer == pytest.approx(0.5)
        assert again.scale == pytest.approx(outer)
    with pytest.raises(ValueError, match="give it to unwrap"):
        pack_together([atlas], Packing(unseen=0.5))


def test_cones_and_shares_that_are_none_are_refused(hollow: tuple[np.ndarray, np.ndarray]) -> None:
    with pytest.raises(ValueError, match="cones"):
        unwrap(*hollow, cones=Cones(8), packing=Packing(unseen=0.5))
    for share in (0, -1, 1.5, np.nan, "half"):
        with pytest.raises(ValueError, match="unseen is"):
            Packing(unseen=share)
