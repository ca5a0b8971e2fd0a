"""Loops of the core that run in several threads; `make sanitize` runs these tests with ThreadSanitizer."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scipy import sparse

from igl_linabf import _core

SHARED = 300_000  # length of an array above PARALLEL_SIZE, so that threads share its loops


@pytest.fixture(autouse=True)
def _many_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "4")


def grid_laplacian(n: int) -> sparse.csc_array:
    """Return the lower triangle of a positive definite matrix over a grid of n x n points."""
    path = sparse.diags_array([-np.ones(n - 1), 2 * np.ones(n)], offsets=[-1, 0])
    lower = sparse.kron(path, sparse.eye_array(n)) + sparse.kron(sparse.eye_array(n), path)
    made = sparse.csc_array(sparse.tril(lower))
    made.sort_indices()
    return made


def test_several_threads_may_factor_and_solve_with_one_analysis() -> None:
    A = grid_laplacian(150)  # large enough to be factored in parallel
    symbolic = _core.Symbolic(A.indptr, A.indices)
    B = np.random.default_rng(0).normal(size=(A.shape[0], 3))
    full = A + sparse.triu(A.T, 1)

    def solve(scale: float) -> float:
        X = symbolic.factor(A.data * scale).solve(B)
        return float(np.abs(scale * (full @ X) - B).max())

    with ThreadPoolExecutor(4) as pool:
        assert max(pool.map(solve, np.arange(1.0, 9.0))) < 1e-9


def test_sums_and_tables_of_long_arrays_are_correct() -> None:
    rng = np.random.default_rng(1)
    x, y = rng.normal(size=(2, SHARED))
    start = np.array([0, SHARED])
    np.testing.assert_allclose(_core.block_dots(start, x, y), [x @ y])
    p = y.copy()
    _core.update_cg_direction(start, np.ones(1), np.full(1, 2.0), x, p)
    np.testing.assert_allclose(p, x + y / 2)
    alpha = rng.uniform(0.1, 3, (3, SHARED))
    np.testing.assert_allclose(_core.cotangents(alpha), 1 / np.tan(alpha), rtol=1e-9, atol=1e-9)


def test_edges_and_products_of_large_grids_are_correct() -> None:
    n = 520  # n^2 points are more than PARALLEL_SIZE
    i = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    corner = np.concatenate([np.array([i, i + n, i + n + 1]), np.array([i, i + n + 1, i + 1])], axis=1)
    ends, sides, sound = _core.find_edges(corner, n * n)
    assert sound and len(ends) == 3 * (n - 1) ** 2 + 2 * (n - 1)
    assert (np.sort(corner.ravel()[sides[0]]) >= 0).all()
    A = grid_laplacian(n)
    x = np.random.default_rng(2).normal(size=(n * n, 2))
    made = _core.symmetric_product(A.indptr, A.indices, A.data, x)
    np.testing.assert_allclose(made, A @ x + sparse.triu(A.T, 1) @ x, atol=1e-12)
