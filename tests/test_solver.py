"""The solvers agree, analyse once, and say when something else ran."""

from __future__ import annotations

from contextlib import nullcontext

import numpy as np
import pytest
from conftest import best_fit_distance, load

from igl_linabf import FallbackWarning, LinABF, MeshError, flatten, linabf, quality
from igl_linabf.angles import iterations, reduced
from igl_linabf.flattening.ladder import ONE_SYSTEM_RTOL
<<<<<<< HEAD
from igl_linabf.kernels import numpy_only
from igl_linabf.linalg import Cholesky, NotPositiveDefiniteError, conjugate_gradients, has_cholmod, solvers
=======
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
>>>>>>> 66f681ac8f4e19cda558f9e15422993355573afa

NAMES = ["auto", "direct", *["cholmod"] * has_cholmod()]


@pytest.mark.parametrize("name", ["bumps", "cortex", "disk__igl_camelhead.off"])
def test_every_solver_gives_the_same_map(name: str) -> None:
    V, F = load(name)
    maps = {s: flatten(V, F, LinABF(iterations=1, rtol=1e-11, solver=s)) for s in NAMES}
    first = maps["auto"].uv
    for result in maps.values():
        assert np.abs(result.uv - first).max() <= 1e-7 * np.ptp(first)
    for made in maps.values():
        assert ("CHOLMOD" in made.solver) == ("CHOLMOD" in made.layout_solver) == (made is maps.get("cholmod"))
    assert maps["direct"].solver.startswith("direct")
    assert maps["direct"].inner_steps == 0


@pytest.mark.parametrize("name", ["bumps", "cortex", "ball", "disk__igl_camel_b.obj"])
def test_solvers_agree_to_the_default_tolerance(name: str) -> None:
    V, F = load(name)
    for rtol, apart in (({}, 5e-3), ({"rtol": 1e-10}, 1e-8)):
        first, *others = (flatten(V, F, LinABF(solver=s, **rtol)).uv for s in NAMES)
        for uv in others:
            assert best_fit_distance(uv, first) <= apart


def test_without_scikit_sparse_all_works_the_same(monkeypatch) -> None:
    V, F = load("cortex")
    expected = {layout: linabf(V, F, layout=layout, rtol=1e-11) for layout in ("auto", "least-squares")}
    monkeypatch.setattr(solvers, "has_cholmod", lambda: False)
    for name, uv in expected.items():
        without = linabf(V, F, layout=name, rtol=1e-11)
        assert np.abs(without - uv).max() <= 1e-7 * np.ptp(uv)
    assert flatten(V, F).solver == f"conjugate gradients, {Cholesky.name}"
    assert flatten(V, F, LinABF(iterations=1, solver="direct")).solver == f"direct, {Cholesky.name}"
    with pytest.raises(ImportError, match="libsuitesparse-dev"):
        linabf(V, F, solver="cholmod")


def test_the_pattern_is_analysed_once_however_many_iterations(monkeypatch) -> None:
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
    monkeypatch.setattr(reduced, "SMALL", 0)  # from where slivers are corrected for
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


<<<<<<< HEAD
@pytest.mark.parametrize("method", ["linabf", "abf"])
def test_the_number_of_threads_does_not_change_a_bit(method: str, monkeypatch) -> None:
    V, F = load("disk__igl_face.obj")
    maps = []
=======
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
>>>>>>> 66f681ac8f4e19cda558f9e15422993355573afa
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        maps.append(flatten(V, F, method))
    assert all((made.uv == maps[0].uv).all() for made in maps[1:])


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


def test_a_singular_layout_is_an_error_with_a_place(monkeypatch) -> None:
    V, F = load("bumps")

    def singular(self, values) -> None:
        raise NotPositiveDefiniteError(7)

    monkeypatch.setattr(Cholesky, "factor", singular)
    with pytest.raises(MeshError, match=r"singular in double precision.*faces \d+.*remove"):
        flatten(V * [1, 1, 0], F, LinABF(layout="least-squares"))
    with pytest.warns(FallbackWarning), pytest.raises(MeshError, match=r"singular.*faces \d+.*rad"):
        flatten(V, F)
