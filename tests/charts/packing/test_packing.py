"""Packed charts keep their distance, have one scale, and are not mirrored."""

from __future__ import annotations

import re

import igl
import numpy as np
import pytest
import shapely
from conftest import bumps
from hard_surfaces import DEVELOPABLE, MACHINED, pipe
from scipy.spatial import cKDTree

from igl_linabf import ChartOptions, MeshError, Packing, find_seams, unwrap
from igl_linabf.charts import pack_charts
from igl_linabf.charts.atlas import find_seam_prices
from igl_linabf.charts.features import CreasedSurface
from igl_linabf.charts.packing.flat_charts import FlatChart
from igl_linabf.charts.packing.outlines import rasterize_outlines
from igl_linabf.charts.packing.packing import PackedChart, PackingRequest, _prepare_charts
from igl_linabf.surface import Submesh, complex_positions, signed_double_areas

Chart = tuple[np.ndarray, np.ndarray]
MARGIN = 0.005


def star(rng: np.random.Generator, size: float, thin: float = 1) -> Chart:
    """Return a star-shaped fan of triangles, rotated and moved at random."""
    around = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    radius = 1 + 0.5 * np.cos(rng.integers(2, 6) * around) + 0.2 * np.cos(7 * around + rng.uniform(0, 6))
    rim = radius * (thin * np.cos(around) + 1j / thin * np.sin(around))
    z = size * np.exp(1j * rng.uniform(0, 6)) * np.append(rim, 0) + complex(*rng.normal(size=2) * 5)
    c = np.arange(60)
    return np.column_stack((z.real, z.imag)), np.column_stack((np.full(60, 60), c, (c + 1) % 60))


def stars(sizes: np.ndarray | list[float], thin: float = 1) -> list[Chart]:
    rng = np.random.default_rng(0)
    return [star(rng, size, thin) for size in sizes]


RANDOM = np.random.default_rng(1)
SETS = {
    "one": stars([3]),
    "six": stars(RANDOM.uniform(0.5, 2, 6)),
    "lognormal": stars(RANDOM.lognormal(0, 1, 40)),
    "tiny": stars([1, 1, 1e-4, 0.5]),
    "thin": stars(np.ones(12), thin=5),
    "equal": stars(np.ones(16) * 1e-6),
}


def boundary_samples(chart: Chart, step: float) -> np.ndarray:
    """Return points along the boundary, at most `step` apart."""
    uv, F = chart
    halves = np.sort(F[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, count = np.unique(halves, axis=0, return_counts=True)
    a, b = uv[edges[count == 1].T]
    pieces = np.ceil(np.linalg.norm(b - a, axis=1) / step).astype(int) + 1
    return np.concatenate(
        [p + np.linspace(0, 1, n)[:, None] * (q - p) for p, q, n in zip(a, b, pieces, strict=True)]
    )


def contains_point(chart: Chart, point: np.ndarray) -> bool:
    """Return True if a triangle of the chart contains the point."""
    a, b, c = (chart[0][chart[1][:, k]] @ [1, 1j] for k in range(3))
    p = complex(*point)
    turns = np.stack([((q - r).conj() * (p - r)).imag for q, r in ((b, a), (c, b), (a, c))])
    return bool(((turns > 0).all(axis=0) | (turns < 0).all(axis=0)).any())


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("margin", [0, MARGIN, 0.02])
def test_packed_charts_are_apart_at_one_scale_and_not_mirrored(name: str, margin: float) -> None:
    charts = SETS[name]
    placed = pack_charts(charts, Packing(margin=margin))
    scale = abs(placed[0].ratio)
    for (uv, F), new in zip(charts, placed, strict=True):
        assert abs(new.ratio) == pytest.approx(scale, rel=1e-13)
        z = new.ratio * complex_positions(uv) + new.shift
        rounding = 1e-15 * (1 + scale * np.abs(uv).max())
        assert np.abs(complex_positions(new.uv) - z).max() < 20 * rounding
        before, after = (signed_double_areas(complex_positions(w), F.T) for w in (uv, new.uv))
        assert np.allclose(after, before * scale**2, rtol=1e-9, atol=10 * rounding * scale * np.ptp(uv))
        assert new.area == pytest.approx(after.sum() / 2, rel=1e-6, abs=rounding)
    everything = np.concatenate([new.uv for new in placed])
    assert everything.min() == pytest.approx(margin, abs=1e-12)
    # the charts reach the far side of the unit square
    assert everything.max() == pytest.approx(1 - margin, abs=1e-5)

    step = 2e-3 if len(charts) > 30 else 5e-4
    new_charts = [(new.uv, F) for new, (_, F) in zip(placed, charts, strict=True)]
    samples = [boundary_samples(chart, step) for chart in new_charts]
    for i, mine in enumerate(samples[1:], 1):
        # each point of a boundary has a sample within half a step
        near, _ = cKDTree(mine).query(np.concatenate(samples[:i]), distance_upper_bound=max(margin - step, 0))
        assert np.isinf(near).all()
    for i, chart in enumerate(new_charts):
        assert not any(contains_point(chart, samples[j][0]) for j in range(len(samples)) if j != i)
    if margin == MARGIN:
        least = {"one": 0.39, "six": 0.5, "lognormal": 0.64, "tiny": 0.38, "thin": 0.15, "equal": 0.42}[name]
        assert sum(new.area for new in placed) > least


def test_no_point_belongs_to_two_charts() -> None:
    charts = SETS["lognormal"]
    placed = pack_charts(charts, Packing(margin=MARGIN))
    shapes = [
        shapely.union_all(shapely.polygons(new.uv[F])) for new, (_, F) in zip(placed, charts, strict=True)
    ]
    assert shapely.union_all(shapes).area == pytest.approx(sum(new.area for new in placed), rel=1e-9)
    near = min(a.distance(b) for i, a in enumerate(shapes) for b in shapes[:i])
    assert MARGIN * (1 - 1e-9) < near < 2 * MARGIN


def box(width: float, height: float, turn: float = 0.0) -> Chart:
    z = np.array([0, width, width + 1j * height, 1j * height]) * np.exp(1j * turn)
    return np.column_stack((z.real, z.imag)), np.array([[0, 1, 2], [0, 2, 3]])


def fill(charts: list[Chart]) -> float:
    return float(sum(new.area for new in pack_charts(charts, Packing(margin=0))))


def test_rectangles_are_rotated_by_90_degrees_where_they_fit_better() -> None:
    pinwheel = [box(2, 1), box(2, 1), box(2, 1), box(2, 1), box(1, 1)]
    assert fill(pinwheel) > 0.99  # 9/16 without rotation


def test_charts_are_turned_to_their_narrowest_rectangle() -> None:
    rng = np.random.default_rng(0)
    sizes, turns = rng.uniform(0.5, 2, (9, 2)), rng.uniform(0, 2 * np.pi, 9)
    upright = fill([box(*size) for size in sizes])
    tilted = fill([box(*size, turn) for size, turn in zip(sizes, turns, strict=True)])
    assert tilted > 0.95 * upright > 0.8


def test_the_scale_is_searched_finely() -> None:
    # sides of the squares in the smallest perfect squared square
    sides = (50, 35, 27, 8, 19, 15, 17, 11, 6, 24, 29, 25, 9, 2, 7, 18, 16, 42, 4, 37, 33)
    assert fill([box(side, side) for side in sides]) > 0.85


def count_charts_per_texel(placed: list[PackedChart], charts: list[Chart], resolution: int) -> np.ndarray:
    """Return, for each page and texel, the number of charts that meet the bilinear kernel of the texel."""
    count = np.zeros((max(new.page for new in placed) + 1, resolution, resolution), dtype=np.int64)
    for new, (_, F) in zip(placed, charts, strict=True):
        texels = (
            new.uv - [new.page % 10, new.page // 10]
        ) * resolution - 0.5  # texel (i, j) has its centre at (i, j)
        shape = shapely.union_all(shapely.polygons(texels[F]))
        shapely.prepare(shape)
        low = np.maximum(np.floor(texels.min(axis=0)), 0)
        high = np.minimum(np.ceil(texels.max(axis=0)), resolution - 1)
        columns, rows = (np.arange(a, b + 1, dtype=int) for a, b in zip(low, high, strict=True))
        x, y = (part.ravel() for part in np.meshgrid(columns, rows))
        reach = 1 - 1e-6  # leave out the border of the kernel, where the kernel vanishes
        met = shapely.intersects(shape, shapely.box(x - reach, y - reach, x + reach, y + reach))
        count[new.page, y[met], x[met]] += 1
    return count


@pytest.mark.parametrize("resolution", [128, 300])
def test_no_two_charts_share_a_texel_of_a_bilinear_lookup(resolution: int) -> None:
    charts = SETS["lognormal"]
    once = count_charts_per_texel(pack_charts(charts, Packing(resolution=resolution)), charts, resolution)
    assert once.max() == 1
    assert once.sum() > 0.6 * once.size
    assert (
        count_charts_per_texel(
            pack_charts(charts, Packing(resolution=resolution, padding=0)), charts, resolution
        ).max()
        > 1
    )
    # only the two stars are not placed on shelves
    many = [box(1 + 3 * (k % 3), 1, 0.1 * k) for k in range(120)] + stars([4, 3])
    assert (
        count_charts_per_texel(pack_charts(many, Packing(resolution=resolution)), many, resolution).max() == 1
    )


def test_a_texel_density_takes_as_many_pages_as_it_needs() -> None:
    charts = SETS["six"]
    placed = pack_charts(charts, Packing(resolution=256, texel_density=40))
    pages = max(new.page for new in placed) + 1
    assert {round(abs(new.ratio) * 256, 9) for new in placed} == {40}
    assert {new.page for new in placed} == set(range(pages))
    assert pages > 1
    assert count_charts_per_texel(placed, charts, 256).max() == 1
    with pytest.raises(MeshError, match=r"density of 40 do not fit on a page of 256 x 256"):
        pack_charts(charts, Packing(resolution=256, texel_density=40, pages=1))
    with pytest.raises(MeshError, match=r"chart \d takes \d+ x \d+\): use a smaller density or a larger"):
        pack_charts(charts, Packing(resolution=256, texel_density=600))
    with pytest.raises(ValueError, match="needs a resolution"):
        pack_charts(charts, Packing(texel_density=40))


def test_the_density_error_names_the_chart_that_does_not_fit_alone() -> None:
    # the second strip fits only obliquely
    strips = [rectangle(w, h) for w, h in ((1, 1), (4.4, 0.1), (2, 2), (8, 0.1))]
    with pytest.raises(MeshError, match=r"\(chart 3 takes 320 x 4\)|\(chart 3 takes 4 x 320\)"):
        pack_charts(strips, Packing(resolution=160, texel_density=40))
    assert len(pack_charts(strips[:3], Packing(resolution=160, texel_density=40))) == 3
    with pytest.raises(MeshError, match=r"charts 3, 4 are too large for any page; chart 3 takes"):
        pack_charts([*strips, rectangle(7, 1)], Packing(resolution=160, texel_density=40))
    with pytest.raises(MeshError, match=r"each one fits alone; together they cover 1.25 pages"):
        pack_charts([strips[0]] * 5, Packing(resolution=200, texel_density=100, pages=1))


def rectangle(width: float, height: float) -> tuple[np.ndarray, np.ndarray]:
    return np.array([[0, 0], [width, 0], [width, height], [0, height]]), np.array([[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize("number", [1, 6, 130])
def test_charts_are_not_turned_without_rotate(number: int) -> None:
    charts = (SETS["six"] * number)[:number]
    placed = pack_charts(charts, Packing(resolution=512), rotate=False)
    assert all(new.ratio.imag == 0 < new.ratio.real for new in placed)
    assert count_charts_per_texel(placed, charts, 512).max() == 1


def test_a_chart_larger_than_a_page_is_cut_until_its_parts_fit() -> None:
    V, F = bumps()
    size = np.sqrt(igl.doublearea(V, F).sum() / 2)
    density = 300 / size
    atlas = unwrap(V, F, packing=Packing(resolution=128, texel_density=density))
    assert atlas.good
    assert atlas.pages == len(np.unique(np.floor(atlas.TC[atlas.FTC].mean(axis=1)), axis=0)) > 4
    assert atlas.report.scale * 128 == pytest.approx(density)
    charts = [(atlas.TC, atlas.FTC[atlas.chart == k]) for k in range(len(atlas.charts))]
    parts = [igl.remove_unreferenced(np.insert(uv, 2, 0.0, axis=1), F)[:2] for uv, F in charts]
    placed = [PackedChart(1, 0, uv[:, :2], 0, page) for (uv, _), page in zip(parts, atlas.page, strict=True)]
    assert count_charts_per_texel(placed, parts, 128).max() == 1
    with pytest.raises(MeshError, match="fit on 2 pages"):
        unwrap(V, F, packing=Packing(resolution=128, texel_density=density, pages=2))


def test_more_pages_hold_larger_charts_in_tiles() -> None:
    charts = SETS["equal"]
    sizes = []
    for pages in (1, 12):
        placed = pack_charts(charts, Packing(resolution=256, pages=pages))
        sizes.append(abs(placed[0].ratio))
        tile = np.array([[new.page % 10, new.page // 10] for new in placed])
        for new, corner in zip(placed, tile, strict=True):
            inside = new.uv - corner
            assert inside.min() > 1 / 256 - 1e-9
            assert inside.max() < 1 - 1 / 256 + 1e-9
        assert count_charts_per_texel(placed, charts, 256).max() == 1
    assert sizes[1] > 2 * sizes[0]


def test_packing_is_deterministic() -> None:
    first, second = pack_charts(SETS["six"]), pack_charts(SETS["six"])
    assert all((a.uv == b.uv).all() for a, b in zip(first, second, strict=True))


def test_hundreds_of_charts_of_all_sizes_are_apart_at_one_scale() -> None:
    rng = np.random.default_rng(2)
    charts = [
        star(rng, size, thin)
        for size, thin in zip(rng.lognormal(0, 1, 400), rng.uniform(1, 3, 400), strict=True)
    ]
    margin = 0.001
    placed = pack_charts(charts, Packing(margin=margin))
    assert sum(new.area for new in placed) > 0.45
    assert np.ptp([abs(new.ratio) for new in placed]) < 1e-13 * abs(placed[0].ratio)
    everything = np.concatenate([new.uv for new in placed])
    assert everything.min() == pytest.approx(margin, abs=1e-12)
    assert everything.max() == pytest.approx(1 - margin, abs=1e-5)
    shapes = [shapely.polygons(new.uv[:-1]) for new in placed]  # boundaries of the stars
    tree = shapely.STRtree(shapes)
    near = tree.query(shapes, "dwithin", 0.999 * margin)
    assert (near[0] == near[1]).all()
    for (uv, _), new in zip(charts, placed, strict=True):
        z = new.ratio * complex_positions(uv) + new.shift
        np.testing.assert_allclose(complex_positions(new.uv), z, rtol=0, atol=1e-13)


def test_many_charts_are_packed_beside_a_chart_of_many_triangles() -> None:
    V, F = bumps(30_000)
    placed = pack_charts([(V[:, :2], F), *stars(RANDOM.uniform(0.02, 0.1, 60))])
    assert sum(new.area for new in placed) > 0.4
    assert pack_charts([]) == []


def test_vertices_without_faces_are_nan() -> None:
    uv, F = SETS["one"][0]
    (new,) = pack_charts([(np.vstack(([np.nan, np.nan], uv)), F + 1)])
    assert np.isnan(new.uv[0]).all()
    assert np.isfinite(new.uv[1:]).all()


def test_invalid_charts_are_refused() -> None:
    good = SETS["one"][0]
    triangle = np.array([[0, 1, 2]])
    with pytest.raises(MeshError, match="chart 1 has no area"):
        pack_charts([good, (np.array([[0, 0], [1, 1], [3, 3]]), triangle)])
    with pytest.raises(MeshError, match=r"chart 1: .* of vertices 1 are NaN"):
        pack_charts([good, (np.array([[0, 0], [np.nan, 1], [3, 0]]), triangle)])
    with pytest.raises(MeshError, match=r"chart 0: .* outside 0\.\.1"):
        pack_charts([(np.eye(2), triangle)])
    with pytest.raises(ValueError, match="margin"):
        pack_charts([good], Packing(margin=0.2))
    with pytest.raises(ValueError, match=r"resolution is \(512, 0\): .* square page"):
        pack_charts([good], Packing(resolution=(512, 0)))
    with pytest.raises(MeshError, match="100 charts do not fit"):
        pack_charts(stars(np.ones(100)), Packing(margin=0.1))


@pytest.mark.parametrize("others", [0, 45])
def test_limbs_are_cut_where_a_fuller_page_is_worth_the_seam(others: int) -> None:
    # a hub with four long limbs (bent, because planes are not cut), alone or beside small squares
    V, F = igl.triangulated_grid(41, 41)
    V = np.column_stack((V * 40 - 20, np.square(V * 40 - 20).sum(axis=1) / 200))
    inside = (np.abs(V[F].mean(axis=1)[:, :2]) < 2).any(axis=1)
    V, F = igl.remove_unreferenced(V, F[inside])[:2]
    square = np.array([[0, 0, 0], [0.7, 0, 0], [0.7, 0.7, 0], [0, 0.7, 0]])
    beside = len(V) + 4 * np.arange(others)[:, None, None] + [[0, 1, 2], [0, 2, 3]]
    V = np.concatenate([V, *(square + np.array([k, 30, 0]) for k in range(others))])
    F = np.concatenate((F, beside.reshape(-1, 3)))
    whole, cut = (
        unwrap(V, F, charts=ChartOptions(trade=trade), packing=Packing(resolution=256)) for trade in (0, 6)
    )
    assert len(whole.charts) == 1 + others
    assert len(cut.charts) > 1 + others
    assert cut.good
    gain = 1 / whole.fill - 1 / cut.fill
    size = np.sqrt(igl.doublearea(V, F).sum() / 2)
    assert 6 * gain > (cut.seam_length - whole.seam_length) / size > 0
    assert cut.fill > 1.5 * whole.fill


@pytest.mark.parametrize("name", ["bar", "low prism", "L", "table"])
def test_planes_are_not_cut_for_a_fuller_page(name: str) -> None:
    V, F = (DEVELOPABLE | MACHINED)[name]()
    whole = unwrap(V, F, find_seams(V, F))
    cut = unwrap(V, F, packing=Packing(resolution=1024, padding=4))
    assert cut.fill > whole.fill and len(cut.charts) > len(whole.charts)
    creased = CreasedSurface(Submesh.from_input(V, F))
    across = creased.is_coplanar[find_seam_prices(creased, cut.FTC)[0]]
    assert not across.any()


@pytest.mark.parametrize("packing", [None, Packing(resolution=512)])
def test_a_needle_of_any_length_takes_no_more_memory(packing: Packing | None) -> None:
    V = np.array(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [3, 0, 0], [1e8, 0, 0], [3, 1e-7, 0]], dtype=float
    )
    atlas = unwrap(V, np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6]]), packing=packing)
    assert atlas.good and len(atlas.charts) == 2


@pytest.mark.parametrize("name", ["bevelled disk", "disk with a rim", "robot", "bracket"])
def test_without_a_resolution_charts_are_cut_until_the_page_is_half_full(name: str) -> None:
    V, F = (DEVELOPABLE | MACHINED)[name]()
    whole, cut, fuller = (
        unwrap(V, F, find_seams(V, F)),
        unwrap(V, F),
        unwrap(V, F, packing=Packing(resolution=1024, padding=4)),
    )
    assert 1.25 * whole.fill <= cut.fill
    assert whole.fill < 0.5 < cut.fill
    assert len(whole.charts) < len(cut.charts) <= len(fuller.charts)


@pytest.mark.parametrize("name", ["plank", "plate", "L", "tall L"])
def test_nets_are_not_cut_for_a_page_that_gets_little_fuller(name: str) -> None:
    V, F = (DEVELOPABLE | MACHINED)[name]()
    atlas = unwrap(V, F)
    assert atlas.fill < 0.5
    assert len(atlas.charts) == 1


@pytest.mark.parametrize("packing", [None, Packing(resolution=1024)])
def test_no_part_is_a_single_triangle(packing: Packing | None) -> None:
    for surface in (igl.icosahedron(), igl.upsample(*igl.icosahedron(), 1), pipe([(0, 2, 0.5)], 32, 20)):
        for hide in (None, [1, 0, 0], [0, 1, 0], [-1, 0, 0]):
            atlas = unwrap(*surface, charts=ChartOptions(hide=hide), packing=packing)
            assert min(len(chart.faces) for chart in atlas.charts) > 1


def test_trial_parts_equal_packed_parts() -> None:
    V, F = igl.triangulated_grid(12, 9)
    hole = (np.abs(V[F].mean(axis=1) - [0.5, 0.4]) < 0.12).all(axis=1)
    V, F = igl.remove_unreferenced(V, F[~hole])[:2]
    place = np.random.default_rng(0).permutation(len(V))
    V, F = V[np.argsort(place)], place[F]
    bent = np.column_stack((V, np.sin(3 * V).sum(axis=1)))
    surface = Submesh.from_input(bent, F)
    chart = FlatChart(CreasedSurface(surface), surface, V * [2, 1], 0)
    lines = [([1, 0.3], 1.1), ([0.2, 1], 0.5), ([1, 1], 1.4)]
    for groups in (chart.make_groups_of_one(), chart.group_by_square(6)):
        sides = np.array([groups.centre @ normal > at for normal, at in lines])
        for side, outlines in zip(sides, groups.make_outlines_of_parts(sides), strict=True):
            parts = [(part.uv, part.piece.F) for part in chart.cut_into_parts(side[groups.label])]
            *_, packed = _prepare_charts(parts, PackingRequest.from_packing(Packing(margin=MARGIN)))
            assert len(parts) > 1
            for outline, other, size in zip(outlines, packed.outlines, packed.sizes, strict=True):
                assert outline.area == pytest.approx(other.area)
                assert len(outline.start) == len(other.start)
                extent = np.ptp([outline.start.real, outline.start.imag], axis=1)
                assert np.allclose(np.sort(extent), np.sort(size))  # the outline may lie along another side
    assert len(chart.group_by_square(6).centre) < len(F) / 2


@pytest.mark.parametrize("number", [80, 90, 100])
def test_charts_whose_gaps_leave_no_room_are_refused(number: int) -> None:
    square, F = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]), np.array([[0, 1, 2], [0, 2, 3]])
    sizes = np.random.default_rng(0).uniform(0.5, 1, number)
    with pytest.raises(
        MeshError, match=f"{number} charts do not fit with a margin of 0.1: use a smaller one"
    ):
        pack_charts([(square * size, F) for size in sizes], Packing(margin=0.1))


@pytest.mark.parametrize("gap", [0.0, 0.7, 3.3])
def test_masks_are_the_cells_that_a_widened_chart_touches(gap: float) -> None:
    cells = 9.0
    *_, charts = _prepare_charts(SETS["thin"][:4], PackingRequest.from_packing(Packing(margin=MARGIN)))
    turns = [np.exp(2j * np.pi * np.arange(n) / 16) for n in (16, 3, 1, 5)]
    # one mask serves two opposite directions
    turns[0] = np.column_stack((turns[0][:8], -turns[0][:8])).ravel()
    for outline, by, masks in zip(
        charts.outlines, turns, rasterize_outlines(charts.outlines, turns, cells, gap), strict=True
    ):
        lines = np.stack((outline.start, outline.end), axis=1)
        for k, shape in enumerate(masks.shapes):
            turned = (lines * by[k] - masks.origin[k]) * cells
            ends = np.stack((turned.real, turned.imag), axis=-1)
            polygon = shapely.get_parts(shapely.polygonize(shapely.linestrings(ends)))
            y, x = np.indices(shape)
            around = shapely.box(x - gap / 2, y - gap / 2, x + 1 + gap / 2, y + 1 + gap / 2)
            touched = shapely.intersects(shapely.union_all(polygon), around)
            drawn = np.zeros(shape, dtype=bool)
            for row, first, length, high in masks.blocks[masks.start[k] : masks.start[k + 1]]:
                assert not drawn[row : row + high, first : first + length].any()
                drawn[row : row + high, first : first + length] = True
            assert (drawn == touched).all()


@pytest.mark.filterwarnings("ignore:the mesh is repaired")
# the smallest and the largest surface are normalized first
@pytest.mark.parametrize("size", [1e-100, 1.0, 1e100])
def test_the_error_states_the_requested_density(size: float) -> None:
    V, F = igl.icosahedron()
    seams = find_seams(V, F)
    with pytest.raises(MeshError, match=re.escape(f"at a texel density of {64 / size:g} does not fit")):
        unwrap(V * size, F, seams, packing=Packing(resolution=64, texel_density=64 / size, pages=1))


def turn_chart(chart: Chart, angle: float) -> Chart:
    uv, F = chart
    c, s = np.cos(angle), np.sin(angle)
    return uv @ [[c, s], [-s, c]], F


@pytest.mark.parametrize("sizes", [[(1, 0.38)], [(3, 1), (2, 1.5), (1, 1), (2.5, 2)]])
def test_straight_charts_lie_along_the_sides_of_the_page(sizes: list[tuple[float, float]]) -> None:
    # the first chart would need 5 % less space along the diagonal
    rng = np.random.default_rng(0)
    charts = [turn_chart(rectangle(*size), rng.uniform(0, 6)) for size in sizes]
    for (_, F), new in zip(charts, pack_charts(charts), strict=True):
        side = new.uv[F[0, 1]] - new.uv[F[0, 0]]
        assert np.abs(side).min() < 1e-9 * np.abs(side).max()


def test_oblique_charts_that_save_a_tenth_of_the_page_stay_oblique() -> None:
    placed = pack_charts([turn_chart(rectangle(6, 0.3), 0.2)])[0]  # a bar along the diagonal
    assert placed.area > 1.4 * 0.3 / 6
