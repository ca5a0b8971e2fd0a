"""`Flattener`: repeated flattening of the same triangles."""

from __future__ import annotations

import re

import igl
import numpy as np
import pytest
from conftest import load

import igl_linabf as il


def move_vertices(V: np.ndarray, k: int) -> np.ndarray:
    """Return the vertices after a motion and a stretch, which may make another loop the longest."""
    return V * [1, 1 + 0.5 * k, 1] + 1e-3 * k * np.ptp(V) * np.sin(7 * V / np.ptp(V))


def assert_same(made: il.flattening.Flattening, expected: il.flattening.Flattening) -> None:
    for part in ("uv", "angles", "flipped"):
        np.testing.assert_array_equal(getattr(made, part), getattr(expected, part))
    assert (made.outcome, made.message) == (expected.outcome, expected.message)
    for part in ("attempts", "steps", "solver", "layout_solver", "gap"):
        assert getattr(made.report, part) == getattr(expected.report, part)


@pytest.mark.parametrize("name", ["bumps", "cortex", "crown", "pial_with_holes", "disk__igl_camelhead.off"])
@pytest.mark.parametrize("method", ["linabf", "abf", il.LinABF(solver="direct"), "lscm"], ids=str)
def test_each_call_returns_the_result_of_flatten_to_the_bit(name: str, method: object) -> None:
    V, F = load(name)
    flattener = il.Flattener(F)
    for k in (0, 1, 2):
        assert_same(
            flattener.flatten(move_vertices(V, k), method=method),
            il.flatten(move_vertices(V, k), F, method=method),
        )


def test_each_call_has_its_own_method_pins_and_outer_loop() -> None:
    V, F = load("crown")
    loop = igl.boundary_loop_all(F)[-1]
    flattener = il.Flattener(F)
    calls = [
        ((), {}),
        (([0, 9], [[0, 0], [2, 1]]), {"method": "abf"}),
        ((), {"method": il.LinABF(layout="least-squares"), "outer": loop[0]}),
        ((), {"method": il.LinABF(solver="direct")}),
        ((), {}),
    ]
    for args, options in calls:
        assert_same(flattener.flatten(V, *args, **options), il.flatten(V, F, *args, **options))


def test_edges_and_analysis_are_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    V, F = load("bumps")
    flattener = il.Flattener(F)
    first = flattener.flatten(V)
    for module, name in ((il.surface.mesh, "build_planar_topology"), (il.linalg.Solvers, "analyse")):
        monkeypatch.delattr(module, name)
    assert_same(flattener.flatten(V), first)


def test_unused_vertices_are_nan_and_named() -> None:
    V, F = load("bumps")
    flattener = il.Flattener(F + 1)
    with pytest.warns(il.MeshWarning, match="vertices 0, 901, 902 belong to no face"):
        made = flattener.flatten(np.vstack((V[:1], V, V[:2])))
    assert np.isnan(made.uv[[0, -1, -2]]).all()
    np.testing.assert_array_equal(made.uv[1:-2], il.flatten(V, F).uv)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda V: V[:-1], "refer to vertices outside"),
        (lambda V: V * np.nan, "NaN or infinite"),
        (lambda V: V * 0 + 1, "zero area"),
        (lambda V: V[:, :2], "shape"),
    ],
)
def test_bad_positions_are_refused_as_by_flatten(change: object, said: str) -> None:
    V, F = load("bumps")
    with pytest.raises(il.MeshError, match=said) as expected:
        il.flatten(change(V), F)
    with pytest.raises(il.MeshError, match=re.escape(str(expected.value))):
        il.Flattener(F).flatten(change(V))


@pytest.mark.parametrize("far", [2**31, 2**53, 2**63 - 1])
def test_faces_with_huge_vertex_numbers_are_named(far: int) -> None:
    F = load("bumps")[1].copy()
    F[3, 1] = far
    with pytest.raises(il.MeshError, match=r"faces 3 refer to vertices beyond .*: correct F"):
        il.Flattener(F)
    with pytest.raises(il.MeshError, match=r"faces 3 refer to vertices beyond .*: correct F"):
        il.layouts.layout(F, np.full(F.shape, np.pi / 3))


def test_surfaces_that_are_not_disks_are_refused_at_once() -> None:
    V, F = igl.icosahedron()
    for bad in (F, F[:0], F * 0, -F):
        with pytest.raises(il.MeshError) as made:
            il.Flattener(bad)
        with pytest.raises(il.MeshError) as expected:
            il.flatten(V, bad)
        if bad.min(initial=0) >= 0:
            assert str(made.value) == str(expected.value)
