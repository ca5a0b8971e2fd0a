"""Overlapping charts are split or moved apart, and small charts are merged into a neighbour."""

from __future__ import annotations

import os
import sys
from subprocess import Popen

import igl
import numpy as np
import pytest
import shapely
from conftest import load
from overlapping_surfaces import spiral

from igl_linabf import ChartOptions, FallbackWarning, find_seams, flatten, overlaps, quality, unwrap
from igl_linabf.charts import constants as charts_constants
from igl_linabf.charts.splitting import merge_small_charts, scaf
from igl_linabf.surface import Submesh


def test_overlapping_charts_are_split_along_short_seams() -> None:
    V, F = spiral()
    assert quality(V, F, flatten(V, F).uv).overlaps > 0
    atlas = unwrap(V, F)
    assert atlas.report.n_splits == len(atlas.charts) - 1 >= 1
    assert atlas.good
    assert 0 < atlas.seam_length < 2  # the seams run across the strip, not along it
    shapes = [shapely.union_all(shapely.polygons(atlas.TC[atlas.FTC[c.faces]])) for c in atlas.charts]
    assert shapely.union_all(shapes).area == pytest.approx(sum(s.area for s in shapes), rel=1e-9)


def test_bijective_keeps_one_chart_and_reports_the_cost() -> None:
    V, F = spiral()
    atlas = unwrap(V, F, np.zeros((0, 2), dtype=int), charts=ChartOptions(repair_overlaps=True))
    (chart,) = atlas.charts
    assert chart.overlapping == 0
    assert chart.distortion_increase > 0
    assert "overlaps repaired" in chart.result.message
    assert len(overlaps(atlas.TC, atlas.FTC)) == 0


def test_bijective_is_deterministic_under_load() -> None:
    V, F = spiral()
    alone = unwrap(V, F, charts=ChartOptions(repair_overlaps=True))
    busy = [Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2 * (os.cpu_count() or 1))]
    try:
        beside = unwrap(V, F, charts=ChartOptions(repair_overlaps=True))
    finally:
        for process in busy:
            process.kill()
            process.wait()
    assert "overlaps repaired" in beside.charts[0].result.message
    assert alone.TC.tobytes() == beside.TC.tobytes()
    assert alone.FTC.tobytes() == beside.FTC.tobytes()


@pytest.mark.parametrize(
    ("limits", "why"),
    [
        ({"SCAF_SECONDS": 0.0, "SCAF_SECONDS_PER_FACE": 1e-9}, "did not end within"),
        ({"MAX_SCAF_STRETCH_FACTOR": 0.99}, "would stretch the chart by .* by"),
    ],
    ids=["time", "stretch"],
)
def test_charts_are_cut_if_moving_their_parts_is_slow_or_stretches_them(
    limits: dict[str, float], why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    V, F = spiral()
    for name, value in limits.items():
        monkeypatch.setattr(scaf, name, value)
    with pytest.warns(FallbackWarning, match=f"cut apart, not moved.*{why}"):
        atlas = unwrap(V, F, charts=ChartOptions(repair_overlaps=True))
    assert atlas.report.n_splits
    assert len(overlaps(atlas.TC, atlas.FTC)) == 0


def test_charts_that_still_overlap_after_all_rounds_are_halved(monkeypatch) -> None:
    monkeypatch.setattr(charts_constants, "MAX_OVERLAP_ROUNDS", 0)
    V, F = spiral()
    with pytest.warns(FallbackWarning, match="because of overlaps"):
        atlas = unwrap(V, F, np.zeros((0, 2), dtype=int))
    assert atlas.good and len(atlas.charts) > 1
    assert len(overlaps(atlas.TC, atlas.FTC)) == 0


@pytest.mark.parametrize(
    ("name", "method"),
    [("limb", "isometric"), ("closed__igl_cow.off", "isometric"), ("holes__igl_beetle.off", "linabf")],
)
def test_small_charts_are_merged_where_the_union_is_flat(
    name: str, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    V, F = load(name)
    joined = unwrap(V, F, method=method, weld=False)
    monkeypatch.setattr("igl_linabf.charts.charting.merge_small_charts", lambda made, *_: made)
    apart = unwrap(V, F, method=method, weld=False)
    assert min(len(chart.faces) for chart in apart.charts) < 10
    assert len(joined.charts) < len(apart.charts)
    assert joined.good
    assert joined.quality.flips == joined.quality.overlaps == 0
    assert joined.quality.stretch_l2 < 1.01 * apart.quality.stretch_l2
    assert joined.seam_length < apart.seam_length
    for chart in joined.charts:  # the map of each chart has the area of its faces
        of_faces = V[joined.origin[joined.FTC[chart.faces]]]
        assert (of_faces == V[F[chart.faces]]).all()
        assert igl.doublearea(chart.result.uv, chart.result.F).sum() == pytest.approx(
            igl.doublearea(V, F[chart.faces]).sum()
        )


# the map of the mesh deer exceeds the range of double precision
@pytest.mark.filterwarnings("ignore:.* edges are cut in addition to the given seams")
@pytest.mark.filterwarnings("ignore::igl_linabf.OutcomeWarning")
def test_small_charts_are_merged_except_across_given_seams() -> None:
    V, F = load("stress__flipfree_deer.obj")
    options = {"method": "linabf", "charts": ChartOptions(extend=True)}
    mine = find_seams(V, F, method="linabf")
    begun, apart = unwrap(V, F, mine, **options), unwrap(V, F, mine, method="linabf").seams
    for kept, atlas in ((mine, begun), (apart, unwrap(V, F, apart, **options))):
        cut = {tuple(edge) for edge in np.sort(atlas.seams, axis=1).tolist()}
        assert cut >= {tuple(edge) for edge in np.sort(kept, axis=1).tolist()}


@pytest.mark.parametrize("kept", ["nothing", "one order", "other order"])
def test_a_small_chart_stays_apart_along_kept_seams_in_either_order_of_their_vertices(kept: str) -> None:
    V, F = igl.triangulated_grid(20, 20)
    V = np.column_stack((V, np.zeros(len(V))))
    corner = (V[F].mean(axis=1)[:, :2] < [0.1, 0.05]).all(axis=1)
    surface = Submesh.from_input(V, F)
    rims = [np.sort(igl.boundary_facets(part)[0], axis=1) for part in (F[~corner], F[corner])]
    one, other = ({tuple(edge) for edge in rim.tolist()} for rim in rims)
    seam = np.array(sorted(one & other))
    charts = unwrap(V, F, seam).charts
    pieces = sorted(surface.cut_along(seam), key=lambda piece: int(piece.faces[0]))
    made = [((0, k), chart, piece) for k, (chart, piece) in enumerate(zip(charts, pieces, strict=True))]
    edges = {"nothing": seam[:0], "one order": seam, "other order": seam[:, ::-1]}[kept]
    assert len(merge_small_charts(made, 10.0, edges)) == (1 if kept == "nothing" else 2)


def test_a_small_chart_is_not_squeezed_into_a_gap_of_its_neighbour() -> None:
    # a seam through the concave foot of a hill: the map overlaps itself, and a narrow strip is cut off
    x, y = np.meshgrid(*2 * [np.linspace(-100, 100, 41)])
    V = np.column_stack((x.ravel(), y.ravel(), 40 * np.exp(-(x**2 + y**2) / 3000).ravel()))
    k = np.arange(41 * 41).reshape(41, 41)
    F = np.column_stack([k[i : i + 40, j : j + 40].ravel() for i, j in ((0, 0), (0, 1), (1, 1), (1, 0))])
    atlas = unwrap(V, F, charts=ChartOptions(trade=3000))
    assert len(atlas.charts) > 1
    assert atlas.quality.stretch_linf < 1.1
