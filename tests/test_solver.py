"""The solvers agree, analyse once, and say when something else ran."""

from __future__ import annotations

from contextlib import nullcontext

import numpy as np
import pytest
from conftest import best_fit_distance, load
from scipy import sparse
from scipy.sparse import csgraph

from igl_linabf import FallbackWarning, LinABF, MeshError, flatten, kernels, layout, linabf, quality
from igl_linabf.angles import iterations, reduced
from igl_linabf.flattening.ladder import ONE_SYSTEM_RTOL
from igl_linabf.kernels import dissection, is_fast, numpy_only
from igl_linabf.linalg import (
    NotPositiveDefiniteError,
    SmallBlocks,
    Solvers,
    SuperLU,
    Within,
    choice,
    conjugate_gradients,
)
from igl_linabf.linalg import compiled as loops
from igl_linabf.linalg import factors as solver
from igl_linabf.linalg.factors import IglCholesky
from igl_linabf.linalg.sparsity import Symmetric

DIRECT = [IglCholesky, *([solver.Cholmod] if solver.has_cholmod() else [])]
WITH_CHOLMOD = [solver.Cholmod, *([loops.Compiled] if is_fast() else [])] if solver.has_cholmod() else []
needs_cholmod = pytest.mark.skipif(not solver.has_cholmod(), reason="scikit-sparse is not installed")


@pytest.mark.parametrize("name", ["bumps", "cortex", "disk__igl_camelhead.off"])
def test_every_solver_gives_the_same_map(name: str) -> None:
    V, F = load(name)
    maps = {
        s: flatten(V, F, LinABF(iterations=1, rtol=1e-11, solver=s)) for s in ("auto", "multigrid", "direct")
    }
    first = maps["auto"].uv
    for result in maps.values():
        assert np.abs(result.uv - first).max() <= 1e-7 * np.ptp(first)
    assert "PyAMG" in maps["multigrid"].solver
    assert maps["direct"].solver.startswith("direct")
    assert maps["direct"].inner_steps == 0


@pytest.mark.parametrize("name", ["bumps", "cortex", "ball", "disk__igl_camel_b.obj"])
def test_solvers_agree_to_the_default_tolerance(name: str) -> None:
    V, F = load(name)
    for rtol, apart in (({}, 5e-3), ({"rtol": 1e-10}, 1e-8)):
        first, *others = (flatten(V, F, LinABF(solver=s, **rtol)).uv for s in ("auto", "multigrid", "direct"))
        for uv in others:
            assert best_fit_distance(uv, first) <= apart


def test_without_scikit_sparse_all_works_the_same(monkeypatch) -> None:
    V, F = load("cortex")
    expected = {layout: linabf(V, F, layout=layout, rtol=1e-11) for layout in ("auto", "least-squares")}
    monkeypatch.setattr(solver, "cholmod", None)
    for name, uv in expected.items():
        without = linabf(V, F, layout=name, rtol=1e-11)
        assert np.abs(without - uv).max() <= 1e-7 * np.ptp(uv)
    with numpy_only():
        assert flatten(V, F).solver == "conjugate gradients, igl's Cholesky"
    assert flatten(V, F, LinABF(iterations=1, solver="direct")).solver == "direct, igl's Cholesky"
    monkeypatch.setattr(choice, "MULTIGRID_FROM", 1000)
    with numpy_only():
        assert flatten(V, F).solver == "conjugate gradients, PyAMG"
    with pytest.raises(ImportError, match="libsuitesparse-dev"):
        linabf(V, F, solver="cholmod")


@needs_cholmod
def test_the_pattern_is_analysed_once_however_many_iterations(monkeypatch) -> None:
    V, F = load("cortex")
    analysed, factored = [], []

    def counted(kind, name, rows) -> None:
        made = getattr(kind, name)

        def run(self, lower, *more):
            rows.append(lower.shape[0])
            return made(self, lower, *more)

        monkeypatch.setattr(kind, name, run)

    monkeypatch.setattr(reduced, "SMALL", 0)  # from where slivers are corrected for
    for kind in WITH_CHOLMOD:
        counted(kind, "__init__", analysed)
        counted(kind, "_numeric" if hasattr(kind, "_numeric") else "_solve", factored)
    flatten(V, F)
    # the Laplacian, and the small system of the slivers; step and chord share one factor of each
    n, slivers = analysed
    assert n > 50 * slivers
    assert factored == [n, slivers, n]  # the last is the layout's
    analysed.clear()
    factored.clear()
    result = flatten(V, F, LinABF(iterations=12))
    assert analysed == [n, slivers]
    assert factored == [n, slivers] * result.iterations + [n]


@needs_cholmod
def test_supernodal_and_simplicial_factors_agree(monkeypatch) -> None:
    V, F = load("cortex")
    compiled = flatten(V, F, LinABF(rtol=1e-11)).uv
    with numpy_only():
        uv = flatten(V, F, LinABF(rtol=1e-11)).uv
        monkeypatch.setattr(solver, "SIMPLICIAL_UP_TO", 0)
        supernodal = flatten(V, F, LinABF(rtol=1e-11)).uv
    for other in (compiled, supernodal):
        assert np.abs(other - uv).max() <= 1e-9 * np.ptp(uv)


@pytest.mark.skipif(not is_fast(), reason="numba is not installed")
@pytest.mark.parametrize("divided", [False, True])
@pytest.mark.parametrize("n", [1, 2, 40, 900])
def test_compiled_factors_of_any_pattern_are_right(n: int, divided: bool, monkeypatch) -> None:
    """Also of forests, dense rows, and patterns that were not analysed; by separators, in threads, too."""
    for least in ("DIVIDED_FROM", "DISSECTED_FROM"):
        monkeypatch.setattr(loops, least, 0 if divided else np.inf)
    monkeypatch.setattr(dissection, "PART", 20)
    rng = np.random.default_rng(n)
    for density in (0.0, 1 / n, 3 / n, 0.2):
        A = sparse.random_array((n, n), density=min(density, 1.0), rng=rng)
        A = A + A.T
        A.setdiag(np.asarray(abs(A).sum(axis=0)).ravel() + 1)
        lower = sparse.tril(A).tocsc()
        lower.sort_indices()
        analysis = loops.Compiled(lower)
        for b in (rng.normal(size=n), rng.normal(size=(n, 3)), rng.normal(size=(n, 20))):
            assert np.allclose(A @ analysis.factor(lower).solve(b), b)
        assert np.allclose(
            A.diagonal()[:, None] * analysis.factor(sparse.diags_array(A.diagonal()).tocsc()).solve(b), b
        )
        block = 0.1 * rng.normal(size=(len(lower.data), 4))
        block[lower.indptr[:-1]] = [2 * n, 0.1, 0.1, 3 * n]
        system, x = Symmetric((lower.indptr, lower.indices, block)), rng.normal(size=2 * n)
        for kind in (analysis, *(kind(lower) for kind in DIRECT)):
            inverse = kind.of_blocks(system)
            assert np.allclose(inverse.solve(system.whole() @ x), x)


@pytest.mark.skipif(not is_fast(), reason="numba is not installed")
@pytest.mark.parametrize("shape", [(150, 150), (1000, 20)])
def test_separators_part_a_graph_and_save_fill(shape: tuple[int, int], monkeypatch) -> None:
    monkeypatch.setattr(dissection, "PART", 400)
    paths = [sparse.diags_array([np.ones(k - 1)], offsets=[-1], shape=(k, k)) for k in shape]
    n = int(np.prod(shape))
    grid = sparse.kronsum(*paths) + sparse.kron(*paths[::-1]) + sparse.eye_array(n)  # in triangles
    shuffled = np.random.default_rng(0).permutation(n)
    whole = (grid + grid.T).tocsr()[shuffled][:, shuffled]
    lower = sparse.tril(whole).tocsc()
    lower.sort_indices()
    pattern = lower.indptr, lower.indices
    graph, turns = kernels.neighbours(*pattern), []
    for threads in ("1", "2", "3"):
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        turns.append(kernels.separators(*graph))
    turn = turns[0]
    assert (turns[1] == turn).all() and (turns[2] == turn).all()
    assert turn.max() == round(np.log2(n / 400))
    for least in range(turn.max(), 0, -1):
        left = np.flatnonzero(turn < least)
        count, label = csgraph.connected_components(whole[left][:, left])
        halvings = turn.max() - least + 1
        assert count >= 2**halvings and np.bincount(label).max() < 0.6**halvings * n
    assert np.count_nonzero(turn == turn.max()) <= 1.2 * min(shape)
    fill = []
    for ordered in (kernels.minimum_degree, kernels.dissected):
        order = ordered(*pattern)
        assert (np.sort(order) == np.arange(n)).all()
        fill.append(kernels.supernodes(*pattern, order).value_start[-1])
    assert fill[1] < fill[0] or shape[1] < 50  # a strip has little fill anyway


@pytest.mark.skipif(not is_fast(), reason="numba is not installed")
def test_the_memory_of_a_factor_serves_the_next_one_as_soon_as_it_is_gone() -> None:
    rng, n = np.random.default_rng(0), 300
    A = sparse.random_array((n, n), density=0.02, rng=rng)
    A = A + A.T
    A.setdiag(np.asarray(abs(A).sum(axis=0)).ravel() + 1)
    first, b = sparse.tril(A).tocsc(), rng.normal(size=(n, 2))
    second = first * 2.0
    analysis, made = loops.Compiled(first), []
    take = kernels.fresh

    def counted(size: int) -> np.ndarray:
        made.append(size)
        return take(size)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(kernels, "fresh", counted)
        solve = analysis.factor(first).solve
        x, new = solve(b), len(made)
        other = analysis.factor(second).solve  # while the first one is still there
        assert (solve(b) == x).all()
        assert np.allclose(2 * other(b), x)
        del solve
        both = len(made)
        assert new < both < 2 * new
        again = analysis.factor(first).solve
        assert len(made) == both
        assert (again(b) == x).all()
        assert np.allclose(2 * other(b), x)
        indefinite = first.copy()
        indefinite.setdiag(-1.0)
        del again
        with pytest.raises(NotPositiveDefiniteError):
            analysis.factor(indefinite)
        assert (analysis.factor(first).solve(b) == x).all()
        assert len(made) == both


@needs_cholmod
@pytest.mark.skipif(not is_fast(), reason="numba is not installed")
def test_the_number_of_threads_does_not_change_a_bit(monkeypatch) -> None:
    V, F = load("disk__igl_camelhead.off")
    monkeypatch.setattr(loops, "DIVIDED_FROM", 0)
    monkeypatch.setattr("igl_linabf.kernels.choice.DIVIDED_FROM", 0)
    maps = [flatten(V, F)]
    monkeypatch.setattr(loops, "SHARED_FROM", 0)  # threads share each supernode above the subtrees
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        maps.append(flatten(V, F))
    assert all((made.uv == maps[1].uv).all() for made in maps[1:])
    assert np.abs(maps[0].uv - maps[1].uv).max() <= 1e-12 * np.ptp(maps[0].uv)
    assert maps[0].solver == "conjugate gradients, compiled Cholesky"


@pytest.mark.skipif(not is_fast(), reason="numba is not installed")
def test_a_factor_in_single_precision_gives_the_same_map(monkeypatch) -> None:
    V, F = load("disk__igl_camelhead.off")
    expected = flatten(V, F, LinABF(iterations=1, rtol=1e-10))
    monkeypatch.setattr(loops, "SINGLE_FROM", 0)
    monkeypatch.setattr(loops, "REFINED_FROM", 0)
    made = flatten(V, F, LinABF(iterations=1, rtol=1e-10))
    assert made.solver == "conjugate gradients, compiled Cholesky in single precision"
    assert made.inner_steps <= 1.1 * expected.inner_steps
    assert np.abs(made.uv - expected.uv).max() <= 1e-8 * np.ptp(expected.uv)
    assert made.layout_solver == "compiled Cholesky in single precision"
    with monkeypatch.context() as context:  # too few steps: it is taken in double precision instead
        solve = loops.Compiled._solve
        context.setattr(loops.Compiled, "_solve", lambda *args: (lambda b: b) if args[2:] else solve(*args))
        again = flatten(V, F, LinABF(iterations=1, rtol=1e-10))
    assert again.solver == "conjugate gradients, compiled Cholesky"
    assert again.layout_solver == "compiled Cholesky"
    assert np.abs(again.uv - expected.uv).max() <= 1e-8 * np.ptp(expected.uv)


@pytest.mark.skipif(not is_fast(), reason="numba is not installed")
@pytest.mark.parametrize("divided_from", [0, 10_000])
def test_halfway_solves_of_few_entries_multiply_to_those_of_all_rows(monkeypatch, divided_from: int) -> None:
    monkeypatch.setattr(loops, "SPARSE_FROM", 0)
    monkeypatch.setattr(loops, "DIVIDED_FROM", divided_from)
    rng = np.random.default_rng(0)
    line = sparse.diags_array([2.1 * np.ones(50), -np.ones(49)], offsets=[0, 1])
    A = sparse.kronsum(line + line.T, line + line.T) + sparse.diags_array(rng.random(2500))
    lower = sparse.tril(A).tocsc()
    lower.sort_indices()
    factored = loops.Compiled(lower).factor(lower)
    row, value = rng.integers(0, 2500, (6, 5)), rng.normal(size=(6, 5))
    B = np.zeros((2500, 5))
    np.add.at(B, (row, np.arange(5)), value)
    half = factored.halfway(row, value)
    assert np.allclose(half.T @ half, B.T @ factored.solve(B), rtol=1e-10)
    assert len(half) < 2500


@pytest.mark.skipif(not is_fast(), reason="numba is not installed")
def test_where_the_scale_varies_a_lot_single_precision_flips_nothing(monkeypatch) -> None:
    V, F = load("disk__optcuts_lion_o_f10000.obj")
    expected = flatten(V, F)
    monkeypatch.setattr(loops, "SINGLE_FROM", 0)
    monkeypatch.setattr(loops, "REFINED_FROM", 0)
    made = flatten(V, F)
    assert expected.outcome == made.outcome
    assert not len(made.flipped)


@pytest.mark.skipif(not is_fast(), reason="numba is not installed")
def test_where_single_precision_loses_a_pivot_the_factor_is_in_double_precision(monkeypatch) -> None:
    monkeypatch.setattr(loops, "SINGLE_FROM", 0)
    n, floor = 300, 1e-9
    path = sparse.diags_array([np.full(n - 1, -1.0), np.full(n, 2.0)], offsets=[-1, 0]).tocsc()
    for ends, single in ((1.0 + 1e-2, True), (1.0 + floor, False)):
        path[0, 0] = path[n - 1, n - 1] = ends
        made = loops.Compiled(path).preconditioner(path, rough=True)
        b = np.random.default_rng(0).normal(size=(n, 2))
        left = np.abs((path + sparse.tril(path, -1).T) @ made.solve(b) - b).max()
        assert made.single == single
        assert left <= (1e-3 if single else 1e-5)


def test_where_conjugate_gradients_reach_their_cap_the_system_is_factored(monkeypatch) -> None:
    V, F = load("cortex")
    expected = flatten(V, F, LinABF(iterations=2, solver="direct"))
    monkeypatch.setattr(conjugate_gradients, "__defaults__", (2,))
    with pytest.warns(FallbackWarning, match="did not converge") as caught:
        result = flatten(V, F, LinABF(iterations=2, rtol=1e-10, layout="greedy"))
    assert len([w for w in caught if "did not converge" in str(w.message)]) == 1
    assert result.solver.startswith("direct")
    assert "after conjugate gradients" in result.solver
    assert np.abs(result.angles - expected.angles).max() <= 1e-10


@pytest.mark.parametrize("fast", [False, True])
def test_the_chord_of_a_fine_mesh_ends_early_unless_rtol_is_given(fast: bool, monkeypatch) -> None:
    V, F = load("disk__igl_camelhead.off")
    monkeypatch.setattr(iterations, "FINE", len(V) // 2)
    monkeypatch.setattr(iterations, "MOST_OF_FINE", 2)
    with nullcontext() if fast else numpy_only():
        early, asked = flatten(V, F), flatten(V, F, LinABF(rtol=ONE_SYSTEM_RTOL))
    assert [step.kind for step in early.steps] == [step.kind for step in asked.steps] == ["step", "chord"]
    assert early.steps[0] == asked.steps[0]
    assert early.steps[1].inner_steps == 2 < asked.steps[1].inner_steps
    first, second = (quality(V, F, made.uv).angle_distortion for made in (early, asked))
    assert early.outcome.good
    assert first < 1.01 * second


@pytest.mark.parametrize("kind", [SuperLU, IglCholesky, *WITH_CHOLMOD])
@pytest.mark.parametrize("supernodal", [False, True])
def test_indefinite_and_singular_matrices_are_named_by_row(kind, supernodal: bool, monkeypatch) -> None:
    if supernodal:
        monkeypatch.setattr(solver, "SIMPLICIAL_UP_TO", 0)
        monkeypatch.setattr(loops, "DIVIDED_FROM", 0)
    good = sparse.diags_array([np.full(49, -1.0), np.full(50, 2.5)], offsets=[-1, 0]).tocsc()
    for bad_value in (-3.0, 0.0):
        bad = good.copy()
        bad[20, 20] = bad_value
        bad[20, 19] = bad[21, 20] = 0.0
        analysis = kind(good)
        with pytest.raises(NotPositiveDefiniteError) as caught:
            analysis.factor(bad)
        assert caught.value.row == 20 or (bad_value == 0 and kind not in WITH_CHOLMOD)
        factored, precondition = analysis.factor(good), analysis.preconditioner(good)
        b = np.arange(100.0).reshape(50, 2)
        full = good + sparse.tril(good, -1).T
        assert np.allclose(full @ factored.solve(b), b)
        assert np.allclose(full @ precondition.solve(b), b)
        twice = analysis.factor(2 * good)
        assert np.allclose(2 * full @ twice.solve(b[:, 0]), b[:, 0])
        assert np.allclose(full @ factored.solve(b), b)  # not changed under another's hands


@pytest.mark.parametrize("kind", [*WITH_CHOLMOD, IglCholesky, SuperLU])
def test_the_analysis_of_a_larger_matrix_serves_for_some_of_its_rows(kind) -> None:
    rng = np.random.default_rng(0)
    graph = sparse.random_array((60, 60), density=0.1, rng=rng)
    whole = (graph @ graph.T + sparse.eye_array(60)).tocsc()
    inside, b = rng.random(60) < 0.8, rng.random((60, 2))
    own = whole[inside][:, inside]
    analysis = Within(kind(sparse.tril(whole).tocsc()), sparse.tril(whole).tocsc(), inside)
    for make in (analysis.factor, analysis.preconditioner, analysis.for_one_solve):
        x = make(sparse.tril(own).tocsc()).solve(b[inside])
        assert np.abs(own @ x - b[inside]).max() <= 1e-12


@pytest.mark.parametrize("kind", [SuperLU, IglCholesky, *([solver.Cholmod] if solver.has_cholmod() else [])])
def test_a_system_of_no_rows_has_a_solution_of_none(kind) -> None:
    none = sparse.csc_array((0, 0))
    assert kind(none).factor(none).solve(np.empty((0, 2))).shape == (0, 2)


@pytest.mark.parametrize("name", ["multigrid", "auto"])
def test_complex_hermitian_systems_are_factored(name: str) -> None:
    rng = np.random.default_rng(0)
    A = rng.normal(size=(30, 30)) + 1j * rng.normal(size=(30, 30))
    A = A @ A.conj().T + np.eye(30)
    A[np.diag_indices(30)] = A.diagonal().real  # CHOLMOD wants it exactly real
    lower = sparse.tril(sparse.csc_array(A)).tocsc()
    factor = Solvers(name).whole(lower).factor(lower)
    b = rng.normal(size=30) + 1j * rng.normal(size=30)
    assert np.allclose(A @ factor.solve(b), b)


def test_where_multigrid_does_not_reach_the_layout_it_is_factored(monkeypatch) -> None:
    V, F = load("cortex")
    angles = flatten(V, F, LinABF(iterations=12)).angles
    expected = layout(F, angles)
    monkeypatch.setattr(conjugate_gradients, "__defaults__", (3,))
    with pytest.warns(FallbackWarning, match="PyAMG did not solve the layout"):
        uv = layout(F, angles, solver="multigrid")
    assert np.abs(uv - expected).max() <= 1e-9 * np.ptp(expected)


@pytest.mark.filterwarnings("ignore:PyAMG did not solve the layout")
def test_maps_that_need_all_digits_get_them_without_cholmod() -> None:
    V, F = load("disk__optcuts_lion_o_f10000.obj")
    result = flatten(V, F, LinABF(solver="multigrid"))
    assert len(result.flipped) == 0
    assert result.layout_solver == "igl's Cholesky"


def test_a_singular_layout_is_an_error_with_a_place(monkeypatch) -> None:
    V, F = load("bumps")

    def singular(self, lower, **_) -> None:
        raise NotPositiveDefiniteError(7)

    for kind in (SuperLU, IglCholesky, SmallBlocks, solver.Cholmod):
        monkeypatch.setattr(kind, "factor", singular)
        monkeypatch.setattr(kind, "preconditioner", singular)
    with pytest.raises(MeshError, match=r"singular in double precision.*faces \d+.*remove"):
        flatten(V * [1, 1, 0], F, LinABF(layout="least-squares"))
    with pytest.warns(FallbackWarning), pytest.raises(MeshError, match=r"singular.*faces \d+.*rad"):
        flatten(V, F)
