"""A map without flips that overlaps itself is reported by every entry, and injective maps are not."""

from __future__ import annotations

import warnings

import igl
import numpy as np
import pytest
from conftest import load
from holed_surfaces import surface
from overlapping_surfaces import spiral

from igl_linabf import (
    Flattener,
    OutcomeWarning,
    abf,
    compare,
    flatten,
    flatten_many,
    isometric,
    linabf,
    lscm,
    overlaps,
    unwrap,
)
from igl_linabf.cli import main
from igl_linabf.flattening import METHODS, Outcome
from igl_linabf.flattening import result as results
from igl_linabf.plot import plot_compare


def write(path, V: np.ndarray, F: np.ndarray) -> None:
    igl.write_triangle_mesh(str(path), V, F)


@pytest.mark.parametrize("method", [name for name in METHODS if name != "one-step-abf++"])
def test_the_outcome_is_overlapping_where_pairs_of_triangles_overlap(method: str) -> None:
    V, F = spiral()
    for result in (flatten(V, F, method=method), Flattener(F).flatten(V, method=method)):
        pairs = len(overlaps(result.uv, F))
        count = str(pairs) if pairs <= results.MAX_COUNTED else f"more than {results.MAX_COUNTED:,}"
        assert result.outcome is Outcome.OVERLAPPING and not result.outcome.good
        assert pairs > 0 == len(result.flipped)
        assert f"{count} pairs of triangles (faces " in result.message and "unwrap" in result.message


@pytest.mark.parametrize("call", [linabf, abf, isometric, lscm])
def test_functions_that_return_only_the_map_warn_once_and_the_map_is_unchanged(call) -> None:
    V, F = spiral()
    with pytest.warns(OutcomeWarning, match="the map overlaps itself") as told:
        uv = call(V, F)
    assert len(told) == 1
    assert (uv == flatten(V, F, method=call.__name__).uv).all()


@pytest.mark.parametrize("name", ["annulus", "plate", "wavy plate", "hemisphere", "comb", "slot"])
def test_the_outcome_of_maps_with_holes_agrees_with_the_pairs(name: str) -> None:
    V, F = surface(name)
    result = flatten(V, F)
    assert (result.outcome is Outcome.OVERLAPPING) == bool(
        len(overlaps(result.uv, F)) and not len(result.flipped)
    )


def test_sides_of_a_slit_that_touch_do_not_overlap() -> None:
    """The boundary of this injective map touches itself along the whole slit."""
    V, F = igl.triangulated_grid(21, 21)
    V = np.column_stack((V, np.zeros(len(V))))
    middle = np.flatnonzero((V[:, 0] == 0.5) & (V[:, 1] > 0.3) & (V[:, 1] < 1))
    end = np.flatnonzero((V[:, 0] == 0.5) & (V[:, 1] == 1))
    copied = np.concatenate((middle[1:], end))
    copy = np.arange(len(V))
    copy[copied] = len(V) + np.arange(len(copied))
    F = np.where(((V[F][..., 0].mean(axis=1) < 0.5)[:, None]), copy[F], F)
    V = np.concatenate((V, V[copied]))
    assert len(overlaps(V[:, :2], F)) == 0
    assert flatten(V, F).outcome is Outcome.CONVERGED


def test_many_meshes_get_the_outcomes_of_one(monkeypatch: pytest.MonkeyPatch) -> None:
    good = [load("bumps"), igl.triangulated_grid(5, 5)]
    meshes = [
        (np.pad(np.asarray(V), ((0, 0), (0, 3 - V.shape[1]))), F) for V, F in [spiral(), *good, spiral()]
    ]
    for method in ("linabf", "isometric", "lscm"):
        together = flatten_many(meshes, method=method)
        for (V, F), result in zip(meshes, together, strict=True):
            alone = flatten(V, F, method=method)
            assert result.outcome is alone.outcome
            assert (result.outcome is Outcome.OVERLAPPING) == (len(V) == len(spiral()[0]))
    monkeypatch.setattr(results, "MAX_COUNTED", 10)
    monkeypatch.setattr("igl_linabf.flattening.functions.MAX_COUNTED", 10)
    assert "more than 10 pairs" in flatten(*spiral()).message


def test_tables_commands_and_pictures_show_the_overlaps(tmp_path, capsys) -> None:
    V, F = spiral()
    table = compare(V, F, ["linabf"], repeat=1, others=False)
    pairs = table.entries["linABF"].quality.overlaps
    heading, row = str(table).splitlines()
    assert "overlaps" in heading and f" {pairs} " in row and row.endswith("overlapping")
    write(tmp_path / "in.obj", V, F)
    assert main(["flatten", str(tmp_path / "in.obj"), "-o", str(tmp_path / "out.obj")]) == 1
    told = capsys.readouterr()
    assert "the map overlaps itself" in told.err and "overlapping" in told.out
    assert main(["check", str(tmp_path / "out.obj"), "--quiet"]) == 1
    plotter = plot_compare(V, F, table.maps, off_screen=True, show=False)
    drawn = [actor for part in plotter.renderers for actor in part.actors.values()]
    captions = [actor.GetText(k) for actor in drawn if hasattr(actor, "GetText") for k in range(8)]
    plotter.close()
    assert any(f"{pairs:,} pairs overlap" in (caption or "") for caption in captions)


def test_a_chart_that_still_overlaps_has_the_outcome_in_the_table_of_the_atlas(monkeypatch) -> None:
    monkeypatch.setattr("igl_linabf.charts.charting._resolve_overlaps", lambda piece, made, *_: (made, []))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OutcomeWarning)
        atlas = unwrap(*spiral())
    (chart,) = atlas.charts
    assert chart.result.outcome is Outcome.OVERLAPPING
    assert "lies over itself" in atlas.troubles[0] and not atlas.good
    assert str(atlas).splitlines()[1].endswith("overlapping")
