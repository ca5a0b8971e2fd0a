"""Bounds on the whole atlas are met by the shortest seams that the search over trade finds."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace

import igl
import numpy as np
import pytest
from conftest import load
from own_measures import estimate_jacobians

from igl_linabf import Atlas, ChartOptions, FallbackWarning, MeshWarning, OutcomeWarning, find_seams, unwrap
from igl_linabf.charts import AtlasBounds
from igl_linabf.charts.trade_search import MAX_TRADE, MAX_TRIALS, MIN_TRADE, SUFFICIENT_RATIO, search_trade

COW = "closed__igl_cow.off"
BALL = igl.icosahedron()


def measure_energy(V: np.ndarray, F: np.ndarray, atlas: Atlas) -> float:
    """Return the area-weighted mean of s1^2 + s2^2 + 1/s1^2 + 1/s2^2 of maps with the area of the surface."""
    area = igl.doublearea(V, F)
    uv = atlas.TC * np.sqrt(area.sum() / igl.doublearea(atlas.TC, atlas.FTC).sum())
    values = np.linalg.svd(estimate_jacobians(V[atlas.origin], atlas.FTC, uv), compute_uv=False)[:, :2]
    return float((values**2 + values**-2.0).sum(axis=1) @ area / area.sum())


def make_atlases(threshold: float, tried: list[float], **bounds: float) -> Callable[[float], Atlas]:
    """Return a function that makes atlases as a search expects: `threshold` separates energies and charts."""
    one = unwrap(*BALL)

    def make(trade: float) -> Atlas:
        tried.append(trade)
        energy, charts = (1.1, 1) if trade < threshold else (1.01, 2)
        report = replace(one.report, bounds=AtlasBounds(**bounds, trade=trade))
        quality = replace(one.quality, symmetric_dirichlet=energy)
        return replace(one, charts=one.charts * charts, seam_length=trade, quality=quality, report=report)

    return make


@pytest.mark.parametrize("threshold", [0.11, 0.4, 3.0, 5.9, 6.1, 100.0, 999.0])
def test_the_search_ends_near_the_threshold_within_few_trials(threshold: float) -> None:
    tried: list[float] = []

    def search(trade: float = 6, **bounds: float) -> Atlas:
        tried.clear()
        return search_trade(make_atlases(threshold, tried, **bounds), ChartOptions(trade=trade, **bounds))

    least = search(max_dirichlet=4.1).report.bounds.trade
    assert threshold <= least <= SUFFICIENT_RATIO * threshold
    assert len(tried) <= MAX_TRIALS
    assert min(tried) >= MIN_TRADE
    assert max(tried) <= MAX_TRADE
    most = search(max_charts=1).report.bounds.trade
    assert most == 6 if threshold > 6 else threshold / SUFFICIENT_RATIO <= most < threshold
    assert len(tried) <= MAX_TRIALS
    from_zero = search(0, max_dirichlet=4.1).report.bounds.trade
    assert threshold <= from_zero <= SUFFICIENT_RATIO * threshold
    for start in (0, 5e4):  # outside the range of the search
        assert search(start, max_charts=2).report.bounds.trade == start
    both = search(max_dirichlet=4.1, max_charts=1)  # the bounds conflict; the energy takes precedence
    assert both.quality.symmetric_dirichlet == 1.01
    assert not both.good


@pytest.mark.parametrize("method", ["linabf", "isometric"])
def test_the_energy_of_the_atlas_is_bounded(method: str) -> None:
    V, F = load(COW)
    loose, tight = (
        unwrap(V, F, charts=ChartOptions(max_dirichlet=most), method=method) for most in (4.3, 4.1)
    )
    for atlas, most in ((loose, 4.3), (tight, 4.1)):
        assert measure_energy(V, F, atlas) <= most + 1e-9
        assert 4 * atlas.quality.symmetric_dirichlet == pytest.approx(measure_energy(V, F, atlas), rel=1e-9)
        assert atlas.good
        assert atlas.report.bounds.max_dirichlet == most
        again = unwrap(V, F, charts=ChartOptions(trade=atlas.report.bounds.trade), method=method)
        assert (again.TC == atlas.TC).all()
    assert loose.seam_length < tight.seam_length


def test_the_number_of_charts_is_bounded() -> None:
    V, F = load(COW)
    few = unwrap(V, F, charts=ChartOptions(max_charts=2), method="isometric")
    assert len(few.charts) <= 2 < len(unwrap(V, F, method="isometric").charts)
    assert few.good
    enough, default = (unwrap(V, F, charts=charts) for charts in (ChartOptions(max_charts=50), None))
    assert (enough.TC == default.TC).all()


def test_an_unmet_bound_gives_one_warning_and_is_recorded() -> None:
    V, F = igl.upsample(*BALL, 2)
    V /= np.linalg.norm(V, axis=1)[:, None]
    two = np.concatenate((V, V + 3)), np.concatenate((F, F + len(V)))
    for bounds, trouble in (
        ({"max_charts": 1}, r"has 2 charts, more than max_charts = 1"),
        ({"max_dirichlet": 4.0001}, r"energy of 4\.\d+, beyond max_dirichlet"),
    ):
        with pytest.warns(OutcomeWarning, match=trouble) as caught:
            atlas = unwrap(*two, charts=ChartOptions(**bounds), method="isometric")
        assert len(caught) == 1
        assert not atlas.good
        assert [str(caught[0].message)] == atlas.troubles


def test_warnings_of_discarded_trials_are_not_issued() -> None:
    tried: list[float] = []
    make = make_atlases(20.0, tried)

    def make_and_warn(trade: float) -> Atlas:
        warnings.warn(f"fallback {trade}", FallbackWarning, stacklevel=2)
        if len(tried) == 1:
            warnings.warn("of the mesh", MeshWarning, stacklevel=2)
        return make(trade)

    with pytest.warns(UserWarning) as caught:
        best = search_trade(make_and_warn, ChartOptions(max_dirichlet=4.1))
    assert {str(warning.message) for warning in caught} == {
        f"fallback {best.report.bounds.trade}",
        "of the mesh",
    }


def test_bounds_out_of_range_or_without_a_choice_of_seams_are_errors() -> None:
    for wrong in (4, 3.9, float("nan")):
        with pytest.raises(ValueError, match=r"^max_dirichlet is .*: give a number above 4"):
            ChartOptions(max_dirichlet=wrong)
    for wrong in (0, 2.5, float("inf")):
        with pytest.raises(ValueError, match=r"^max_charts is .*: give a whole number"):
            ChartOptions(max_charts=wrong)
    seams = find_seams(*BALL)
    with pytest.raises(ValueError, match="give extend=True"):
        unwrap(*BALL, seams, charts=ChartOptions(max_charts=1))
    charts = ChartOptions(max_charts=1, extend=True)
    assert len(unwrap(*BALL, seams, charts=charts).charts) == 1
