"""The Cholesky factor of the core agrees with CHOLMOD and NumPy for all patterns."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse import linalg

from igl_linabf.linalg import Cholesky, NotPositiveDefiniteError, Solvers, has_cholmod, solve_complex
from igl_linabf.linalg import cholmod as oracle

KINDS = [Cholesky, *[oracle.Cholmod] * has_cholmod()]
SIDES = [(), (0,), (1,), (2,), (3,), (7,), (20,)]


def get_lower_triangle(A: sparse.sparray) -> sparse.csc_array:
    lower = sparse.csc_array(sparse.tril(A))
    lower.sort_indices()
    return lower


def random(n: int, density: float, rng: np.random.Generator) -> sparse.csc_array:
    """Return a random diagonally dominant matrix."""
    A = sparse.random_array((n, n), density=min(density, 1.0), rng=rng)
    A = A + A.T
    return sparse.csc_array(A + sparse.diags_array(np.asarray(abs(A).sum(axis=0)).ravel() + 1))


def grid(side: int) -> sparse.csc_array:
    line = sparse.diags_array([2.1 * np.ones(side), -np.ones(side - 1)], offsets=[0, 1])
    line = line + sparse.triu(line, 1).T
    return sparse.csc_array(sparse.kronsum(line, line))


def grid_with_dense_row(side: int) -> sparse.csc_array:
    """Return the matrix of a grid with one dense row and column."""
    A = sparse.lil_array(grid(side))
    A[side, :] = A[:, side] = 0.01
    A[side, side] = 100.0
    return sparse.csc_array(A)


def analyse_pattern(kind, lower: sparse.csc_array, block: int = 1):
    return kind(lower.indptr, lower.indices, block)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("n", [0, 1, 2, 3, 40, 900])
def test_factors_of_any_pattern_are_right(kind, n: int) -> None:
    rng = np.random.default_rng(n)
    for density in (0.0, 1 / max(n, 1), 3 / max(n, 1), 0.2):  # the sparsest graphs are forests
        A = random(n, density, rng)
        lower = get_lower_triangle(A)
        factor = analyse_pattern(kind, lower).factor(lower.data)
        for sides in SIDES:
            b = rng.normal(size=(n, *sides))
            x = factor.solve(b)
            assert x.shape == b.shape
            assert np.allclose(x, np.linalg.solve(A.toarray(), b))


@pytest.mark.parametrize("A", [grid_with_dense_row(30), sparse.block_diag([grid(12)] * 30), grid(160)])
def test_large_factors_agree_with_cholmod(A) -> None:
    """The matrices have a dense row, many components, or a size that several threads share."""
    lower, rng = get_lower_triangle(A), np.random.default_rng(0)
    own, *other = (analyse_pattern(kind, lower).factor(lower.data) for kind in KINDS)
    for sides in SIDES:
        b = rng.normal(size=(A.shape[0], *sides))
        x = own.solve(b)
        assert np.abs(A @ x - b).max(initial=0.0) <= 1e-11
        for factor in other:
            assert np.allclose(factor.solve(b), x, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("A", [grid(30), grid_with_dense_row(30), sparse.block_diag([grid(12)] * 30)])
def test_sparse_right_hand_sides_give_columns_of_the_inverse(A) -> None:
    """The right-hand side is nonzero in a single entry, which can be in any column of a supernode."""
    n, lower, by_scipy = A.shape[0], get_lower_triangle(A), linalg.splu(sparse.csc_array(A))
    factor, rng = analyse_pattern(Cholesky, lower).factor(lower.data), np.random.default_rng(0)
    for width in (1, 2, 3, 7):
        for at in [rng.choice(n, width, replace=False) for _ in range(40)]:
            sides = np.zeros((n, width))
            sides[at, np.arange(width)] = 1.0
            assert np.allclose(factor.solve(sides), by_scipy.solve(sides), rtol=1e-9, atol=1e-13)
    single = np.arange(n) == n // 2  # a right-hand side with two entries, whose products cancel
    assert np.allclose(factor.solve(A @ single), single, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("n", [1, 2, 3, 40, 900])
def test_factors_of_blocks_are_right(kind, n: int) -> None:
    rng = np.random.default_rng(n)
    lower = get_lower_triangle(random(n, 3 / n, rng))
    block = 0.1 * rng.normal(size=(lower.nnz, 2, 2))
    own = lower.indptr[:-1]
    block[own] = [[2 * n, 0.1], [0.1, 3 * n]]
    upper = sparse.bsr_array((block, lower.indices, lower.indptr), shape=(2 * n, 2 * n)).tocsr()
    A = sparse.triu(upper) + sparse.triu(upper, 1).T
    b = rng.normal(size=(2 * n, 3))
    assert np.allclose(A @ analyse_pattern(kind, lower, 2).factor(block.reshape(-1, 4)).solve(b), b)
    block[own, 1, 0] = np.nan  # must not be read
    assert np.allclose(A @ analyse_pattern(kind, lower, 2).factor(block.reshape(-1, 4)).solve(b), b)


@pytest.mark.parametrize("name", ["auto", *["cholmod"] * has_cholmod()])
def test_complex_hermitian_systems_are_factored(name: str) -> None:
    rng = np.random.default_rng(0)
    A = rng.normal(size=(30, 30)) + 1j * rng.normal(size=(30, 30))
    A = A @ A.conj().T + np.eye(30)
    factor = Solvers(name).factor(get_lower_triangle(sparse.csc_array(A)))
    for sides in SIDES:
        b = rng.normal(size=(30, *sides)) + 1j * rng.normal(size=(30, *sides))
        assert np.allclose(A @ solve_complex(factor, b), b)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("supernodal", [False, True])
def test_indefinite_and_singular_matrices_are_rejected_with_their_row(
    kind, supernodal: bool, monkeypatch
) -> None:
    if supernodal:
        monkeypatch.setattr(oracle, "SIMPLICIAL_ROWS", 0)
    good = get_lower_triangle(sparse.diags_array([np.full(49, -1.0), np.full(50, 2.5)], offsets=[-1, 0]))
    row, column = good.indices, np.repeat(np.arange(50), np.diff(good.indptr))
    full, b = good + sparse.tril(good, -1).T, np.arange(100.0).reshape(50, 2)
    analysis = analyse_pattern(kind, good)
    for bad_value in (-3.0, 0.0, np.nan, *[np.inf] * (kind is Cholesky)):  # CHOLMOD accepts infinity
        bad = np.where((row == 20) | (column == 20), 0.0, good.data)
        bad[(row == 20) & (column == 20)] = bad_value
        with pytest.raises(NotPositiveDefiniteError) as caught:
            analysis.factor(bad)
        assert caught.value.row == 20
        factor = analysis.factor(good.data)
        assert np.allclose(full @ factor.solve(b), b)
        twice = analysis.factor(2 * good.data)
        assert np.allclose(2 * full @ twice.solve(b[:, 0]), b[:, 0])
        # the second factorization does not change the first factor
        assert np.allclose(full @ factor.solve(b), b)
        del twice
        # a factor that reuses the memory of a deleted factor
        assert np.allclose(full @ analysis.factor(good.data).solve(b), b)


def grids(sizes, rng):
    """Return a block-diagonal matrix of grid Laplacians with random weights and Dirichlet boundaries."""
    parts = []
    for k, m in sizes:
        row, column = sparse.eye_array(k, k=1), sparse.eye_array(m, k=1)
        links = sparse.kron(row, sparse.eye_array(m)) + sparse.kron(sparse.eye_array(k), column)
        links.data = rng.uniform(-1e-3, 1, links.nnz)
        links = links + links.T
        parts.append(sparse.diags_array(links.sum(axis=0) + 0.1) - links)
    return sparse.block_diag(parts, format="csc")


def test_the_blocks_of_a_block_diagonal_matrix_are_factored_independently() -> None:
    rng = np.random.default_rng(0)
    sizes = [(1, 1), (9, 14), (1, 70), (30, 30), (8, 8)]
    A = grids(sizes, rng)
    lower = sparse.tril(A).tocsc()
    lower.sort_indices()
    made = analyse_pattern(Cholesky, lower)
    for b in (
        rng.normal(size=A.shape[0]),
        rng.normal(size=(A.shape[0], 2)),
        rng.normal(size=(A.shape[0], 3)),
    ):
        x = made.factor(lower.data).solve(b)
        assert x.shape == b.shape
        np.testing.assert_allclose(A @ x, b, rtol=0, atol=1e-12)
    fill = made.memory_bytes / 8  # including the explicit zeros of relaxed supernodes
    assert fill < 1.5 * linalg.splu(A, permc_spec="MMD_AT_PLUS_A").L.nnz
    first, last = 1 + 126 + 70, 1 + 126 + 70 + 900
    lower.data[lower.indptr[first + 450]] *= -1
    with pytest.raises(NotPositiveDefiniteError) as error:
        made.factor(lower.data)
    assert first <= error.value.row < last  # the row is in the indefinite block


@pytest.mark.parametrize("threads", ["1", "2"])
def test_a_bad_pivot_in_any_subtree_is_found(threads: str, monkeypatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", threads)
    lower = get_lower_triangle(grid(150))
    analysis = analyse_pattern(Cholesky, lower)
    for row in range(0, 22_500, 1_125):
        values = lower.data.copy()
        values[lower.indptr[row]] = -1e3
        with pytest.raises(NotPositiveDefiniteError) as caught:
            analysis.factor(values)
        assert caught.value.row == row
    double, blocks = analyse_pattern(Cholesky, lower, 2), np.zeros((lower.nnz, 4))
    blocks[:, 0] = blocks[:, 3] = lower.data
    blocks[lower.indptr[11_111], 3] = -1e3
    with pytest.raises(NotPositiveDefiniteError) as caught:
        double.factor(blocks)
    assert caught.value.row == 2 * 11_111 + 1


@pytest.mark.parametrize("n", [1, 2, 3, 5, 9, 41])
def test_a_bad_pivot_is_named_by_its_row_wherever_it_is_in_a_supernode(n: int) -> None:
    rng = np.random.default_rng(n)
    for density in (2 / n, 1.0):
        lower = get_lower_triangle(random(n, density, rng))
        row, column, values = lower.indices, np.repeat(np.arange(n), np.diff(lower.indptr)), lower.data
        analysis = analyse_pattern(Cholesky, lower)
        for k in range(n):
            own = (row == k) | (column == k)
            for bad in (-1.0, 0.0, np.nan, np.inf):
                with pytest.raises(NotPositiveDefiniteError) as caught:
                    analysis.factor(np.where(own, np.where(row == column, bad, 0.0), values))
                assert caught.value.row == k


@pytest.mark.parametrize("threads", ["1", "2"])
@pytest.mark.parametrize("side", [4, 40, 150])
def test_a_matrix_with_one_eigenvalue_below_zero_is_refused_at_its_last_pivot(
    side: int, threads: str, monkeypatch
) -> None:
    """All earlier pivots are positive, and the bad pivot is in the root front, above all subtrees."""
    monkeypatch.setenv("OMP_NUM_THREADS", threads)
    least = 2 * (2.1 - 2 * np.cos(np.pi / (side + 1)))
    lower = get_lower_triangle(grid(side))
    own, analysis, b = lower.indptr[:-1], analyse_pattern(Cholesky, lower), np.ones(side * side)
    for share, good in ((0.999, True), (1.001, False)):
        values = lower.data.copy()
        values[own] -= share * least
        if good:
            A = grid(side) - share * least * sparse.eye_array(side * side)
            assert np.allclose(A @ analysis.factor(values).solve(b), b)
        else:
            with pytest.raises(NotPositiveDefiniteError):
                analysis.factor(values)


@pytest.mark.parametrize("shape", [(150, 150), (400, 400)])
def test_the_number_of_threads_does_not_change_a_bit(shape: tuple[int, int], monkeypatch) -> None:
    """The largest fronts of the second matrix are shared by several threads."""
    lower, made = get_lower_triangle(grid(shape[0])), []
    b = np.random.default_rng(0).normal(size=(lower.shape[0], 3))
    for threads in ("1", "2", "3"):
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        made.append(analyse_pattern(Cholesky, lower).factor(lower.data).solve(b))
    assert (made[1] == made[0]).all() and (made[2] == made[0]).all()


def test_invalid_patterns_are_rejected() -> None:
    for indptr, indices in (
        ([0, 1, 2], [0, 0]),  # the diagonal entry of the second column is missing
        ([0, 2, 3], [1, 0, 1]),  # the diagonal entry is not the first of its column
        ([0, 2, 3], [0, 2, 1]),  # a row index is out of range
        ([0, 3, 2], [0, 1, 1]),
        ([], []),
    ):
        with pytest.raises(ValueError, match="lower triangle"):
            Cholesky(np.array(indptr, dtype=np.int64), np.array(indices, dtype=np.int64))
    factor = Cholesky(np.array([0, 1]), np.array([0])).factor(np.ones(1))
    for shape in ((2,), (0,), (1, 1, 1), ()):
        with pytest.raises(ValueError, match="rows"):
            factor.solve(np.ones(shape))
    with pytest.raises(ValueError, match="values"):
        Cholesky(np.array([0, 1]), np.array([0])).factor(np.ones(2))
