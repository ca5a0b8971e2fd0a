"""The solvers agree, analyse patterns once, and report fallbacks."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import best_fit_distance, load

from igl_linabf import FallbackWarning, LinABF, MeshError, flatten, linabf
from igl_linabf.angles.system import preconditioner
from igl_linabf.linalg import Cholesky, NotPositiveDefiniteError, conjugate_gradients, has_cholmod, solvers

NAMES = ["auto", "direct", *["cholmod"] * has_cholmod()]


@pytest.mark.parametrize("name", ["bumps", "cortex", "disk__igl_camelhead.off"])
def test_every_solver_gives_the_same_map(name: str) -> None:
    V, F = load(name)
    maps = {s: flatten(V, F, method=LinABF(iterations=1, rtol=1e-11, solver=s)) for s in NAMES}
    first = maps["auto"].uv
    for result in maps.values():
        assert np.abs(result.uv - first).max() <= 1e-7 * np.ptp(first)
    for made in maps.values():
        assert (
            ("CHOLMOD" in made.report.solver)
            == ("CHOLMOD" in made.report.layout_solver)
            == (made is maps.get("cholmod"))
        )
    assert maps["direct"].report.solver.startswith("direct")
    assert maps["direct"].report.inner_steps == 0


@pytest.mark.parametrize("name", ["bumps", "cortex", "ball", "disk__igl_camel_b.obj"])
def test_solvers_agree_to_the_default_tolerance(name: str) -> None:
    V, F = load(name)
    for rtol, apart in (({}, 5e-3), ({"rtol": 1e-10}, 1e-8)):
        first, *others = (flatten(V, F, method=LinABF(solver=s, **rtol)).uv for s in NAMES)
        for uv in others:
            assert best_fit_distance(uv, first) <= apart


def test_results_are_the_same_without_scikit_sparse(monkeypatch) -> None:
    V, F = load("cortex")
    expected = {layout: linabf(V, F, layout=layout, rtol=1e-11) for layout in ("auto", "least-squares")}
    monkeypatch.setattr(solvers, "has_cholmod", lambda: False)
    for name, uv in expected.items():
        without = linabf(V, F, layout=name, rtol=1e-11)
        assert np.abs(without - uv).max() <= 1e-7 * np.ptp(uv)
    assert flatten(V, F).report.solver == f"conjugate gradients, {Cholesky.name}"
    assert (
        flatten(V, F, method=LinABF(iterations=1, solver="direct")).report.solver
        == f"direct, {Cholesky.name}"
    )
    with pytest.raises(ImportError, match="libsuitesparse-dev"):
        linabf(V, F, solver="cholmod")


def test_the_pattern_is_analysed_once_for_any_number_of_iterations(monkeypatch) -> None:
    V, F = load("cortex")
    analysed, factored = [], []
    analyse, factor = Cholesky.__init__, Cholesky.factor

    def counted_analysis(self, indptr, indices, block=1) -> None:
        analysed.append(len(indptr) - 1)
        analyse(self, indptr, indices, block)
        self.rows = len(indptr) - 1

    def counted_factor(self, values):
        factored.append(self.rows)
        return factor(self, values)

    monkeypatch.setattr(Cholesky, "__init__", counted_analysis)
    monkeypatch.setattr(Cholesky, "factor", counted_factor)
    monkeypatch.setattr(preconditioner, "LARGE_SYSTEM", 0)  # correct for slivers in systems of any size
    flatten(V, F)
    # factors of the Laplacian and of the small system of slivers; a step and its chord step share both
    n, slivers = analysed
    assert n > 50 * slivers
    assert factored == [n, slivers, n]  # the last factor is that of the layout
    analysed.clear()
    factored.clear()
    result = flatten(V, F, method=LinABF(iterations=12))
    assert analysed == [n, slivers]
    assert factored == [n, slivers] * result.report.iterations + [n]


@pytest.mark.parametrize("method", ["linabf", "abf"])
def test_the_number_of_threads_does_not_change_a_bit(method: str, monkeypatch) -> None:
    V, F = load("disk__igl_face.obj")
    maps = []
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        maps.append(flatten(V, F, method=method))
    assert all((made.uv == maps[0].uv).all() for made in maps[1:])


def test_the_system_is_factored_where_conjugate_gradients_do_not_converge(monkeypatch) -> None:
    V, F = load("cortex")
    expected = flatten(V, F, method=LinABF(iterations=2, solver="direct"))
    monkeypatch.setattr(conjugate_gradients, "__defaults__", (2,))
    with pytest.warns(FallbackWarning, match="did not converge") as caught:
        result = flatten(V, F, method=LinABF(iterations=2, rtol=1e-10, layout="greedy"))
    assert len([w for w in caught if "did not converge" in str(w.message)]) == 1
    assert result.report.solver.startswith("direct")
    assert "after conjugate gradients" in result.report.solver
    assert np.abs(result.angles - expected.angles).max() <= 1e-10


def test_a_singular_layout_is_an_error_with_a_location(monkeypatch) -> None:
    V, F = load("bumps")

    def singular(self, values) -> None:
        raise NotPositiveDefiniteError(7)

    monkeypatch.setattr(Cholesky, "factor", singular)
    with pytest.raises(MeshError, match=r"singular in double precision.*faces \d+.*remove"):
        flatten(V * [1, 1, 0], F, method=LinABF(layout="least-squares"))
    with pytest.warns(FallbackWarning), pytest.raises(MeshError, match=r"singular.*faces \d+.*rad"):
        flatten(V, F)
