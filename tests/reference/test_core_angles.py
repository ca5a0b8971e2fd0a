"""The angle computations of the core agree with their definitions."""

import itertools

import numpy as np
import pytest
from carried import MESHES
from reference import angles as reference
from scipy import sparse
from scipy.sparse.linalg import splu

from igl_linabf import _core as core
from igl_linabf.angles import build_constraints
from igl_linabf.linalg import conjugate_gradients
from igl_linabf.surface import planar_mesh


class Given:
    """A mesh with holes and sharp angles, with arrays that are derived from it."""

    def __init__(self):
        mesh = planar_mesh(*MESHES["crown"]())
        t, rng = mesh.topology, np.random.default_rng(1)
        self.V, self.corner, self.n, self.sides, self.edges = mesh.V, t.corner, t.n, t.sides, t.edges
        self.interior, self.mesh, self.rng = t.is_interior, mesh, rng
        alpha = np.arctan2(mesh.double_area, mesh.dot)
        alpha[:, ::7] *= rng.uniform(0.1, 1, (3, 1))
        self.alpha, self.w, self.cot = alpha, alpha**2, 1 / np.tan(alpha)
        self.d, self.e = self.w.sum(axis=0), rng.normal(size=alpha.shape)
        self.x, self.z = rng.normal(size=(2, t.n)), mesh.V[:, :2] @ [1, 1j]
        self.pattern, self.row = (constraints := build_constraints(t)).pattern, constraints.row
        # many vertices share the last row, as the vertices of a hole do
        self.merged = np.minimum(self.row, 20)


@pytest.fixture(scope="module")
def given():
    return Given()


def same(made, expected):
    made, expected = (x if isinstance(x, tuple) else (x,) for x in (made, expected))
    for a, b in zip(made, expected, strict=True):
        assert np.asarray(a).dtype == np.asarray(b).dtype and np.shape(a) == np.shape(b)
        largest = np.abs(b).max(initial=0, where=np.isfinite(b))
        np.testing.assert_allclose(a, b, rtol=1e-11, atol=1e-11 * largest)


def arguments(g):
    """Return arguments for each function, by name."""
    inside = np.ascontiguousarray(g.sides[:, g.sides[1] >= 0])
    beyond = np.concatenate((g.alpha, [[1e-12, 1.0, 3.0], [-1.0, 4.0, 6.0], [0.5, 2.0, 1.6]]), axis=1)
    huge = np.where(g.rng.random(g.cot.shape) < 0.1, 1e70, g.cot)
    factor = np.exp(g.rng.normal(size=g.n) / 4)
    length = np.sin(g.alpha)
    return {
        "sum_by_index": (g.corner.ravel(), g.e.ravel(), g.n),
        "side_products": (g.V, g.corner),
        "normals": (g.V, g.corner),
        "dihedrals": (g.V, g.corner, inside, core.normals(g.V, g.corner)),
        "lengths": (g.V, g.edges),
        "cotangents": (beyond,),
        "rescaled_angles": (g.corner, length, factor),
        "angle_sums": (g.corner, g.alpha, huge, g.n),
        "limit_step": (g.alpha, g.e, 0.7),
        "constraint_changes": (g.corner, g.cot, g.e, g.n),
        "project_errors": (g.w, g.d, g.e),
        "errors": (g.corner, g.w, g.d, g.cot, *g.x),
        "conformal_errors": (g.corner, g.cot, *g.x),
        "eigenvalue_disparity": (np.delete(g.w, 3, axis=1), np.delete(g.d, 3), np.delete(g.cot, 3, axis=1)),
        "signed_double_areas": (g.z, g.corner),
        "triangle_changes": (g.V, g.V[:, 1:] + g.x.T / 9, g.corner, g.mesh.double_area, g.mesh.dot),
    }


@pytest.mark.parametrize("name", arguments(Given()))
def test_the_core_agrees_with_the_formulas_of_the_paper(name, given):
    args = arguments(given)[name]
    if (
        name == "eigenvalue_disparity"
    ):  # needs the angles of triangles, because K is singular for other values
        alpha = np.arctan2(given.mesh.double_area, given.mesh.dot)
        args = (alpha**2, (alpha**2).sum(axis=0), 1 / np.tan(alpha))
    same(getattr(core, name)(*args), getattr(reference, name)(*args))


def test_the_angle_at_a_side_without_length_is_zero(given):
    uv = given.V[:, :2].copy()
    uv[given.corner[1, 5]] = uv[given.corner[0, 5]]
    changed = core.triangle_changes(given.V, uv, given.corner, given.mesh.double_area, given.mesh.dot)
    np.testing.assert_allclose((changed[0] + changed[1])[:2, 5], 0, atol=1e-12)
    uv[given.corner[2, 5]] = uv[given.corner[0, 5]]
    changed = core.triangle_changes(given.V, uv, given.corner, given.mesh.double_area, given.mesh.dot)
    assert changed[2][5] == changed[3][5] == changed[4][5] == 0


def test_the_core_agrees_with_the_reference_for_collapsed_triangles(given):
    empty = np.zeros((3, 4))
    assert np.isinf(core.cotangents(empty)).all()
    total, log_ratio = core.angle_sums(given.corner, given.alpha, np.full_like(given.cot, np.inf), given.n)
    assert np.isfinite(total).all() and np.abs(log_ratio).max() < 1e-9
    corner = np.zeros((3, 2), dtype=np.int64)
    assert not core.normals(given.V, corner).any()
    alpha, bad = core.rescaled_angles(
        given.corner[:, :2], np.array([[1.0, 3], [1, 1], [1, 1]]), np.ones(given.n)
    )
    assert bad.tolist() == [False, True]
    np.testing.assert_allclose(alpha[:, 0], np.pi / 3)


@pytest.mark.parametrize("kind", [np.int32, np.int64])
@pytest.mark.parametrize("wheels", [21, 18])
def test_system_blocks_agree_with_the_reduced_system(kind, wheels, given):
    g, n = given, 21
    ends = g.merged[g.edges.T]
    indptr, indices, slot = core.symmetric_pattern(ends, n)
    block = core.system_blocks(
        indptr.astype(kind),
        indices.astype(kind),
        slot,
        ends,
        g.sides,
        g.corner,
        g.merged,
        wheels,
        g.w,
        g.d,
        g.cot,
    )
    S = reference.reduced(g.corner, g.merged, n, g.w, g.cot)
    S[1, :, wheels:] = S[:, 1, :, wheels:] = 0
    S[1, 1, range(wheels, n), range(wheels, n)] = 1
    number = np.repeat(np.arange(n), np.diff(indptr))
    half = np.zeros((2, 2, n, n))
    half[:, :, number, indices] = block.reshape(-1, 2, 2).transpose(1, 2, 0)
    same(half + half.transpose(1, 0, 3, 2), S)
    x = g.rng.normal(size=(n, 2))
    made = core.block_product(indptr.astype(kind), indices.astype(kind), block, x.ravel())
    same(made.reshape(n, 2), np.einsum("abij,jb->ia", S, x))


def test_edge_weights_agree_with_element_matrices(given):
    g = given
    pair, half = core.pair_weights(g.w, g.d), core.conformal_weights(g.w, g.d, g.cot)
    P, K = (
        reference.projection(g.w),
        reference.conformal_scale(g.w)[:, None, None] * reference.conformal(g.cot),
    )
    for k in range(3):
        i, j = reference.NEXT[k], reference.PREV[k]
        same(pair[k], -P[:, i, j])
        same(half[k], -K[:, i, j])
    joined = g.sides[1] >= 0
    flat = half.ravel()
    same(core.edge_sums(half, g.sides), flat[g.sides[0]] + np.where(joined, flat[g.sides[1]], 0))


@pytest.mark.parametrize("kind", [np.int32, np.int64])
def test_entries_agree_with_the_laplacian(kind, given):
    g, n = given, 21
    ends, weight = g.merged[g.edges.T], g.rng.normal(size=len(g.edges))
    indptr, indices, slot = core.symmetric_pattern(ends, n)
    data = core.laplacian_entries(indptr.astype(kind), slot, ends, weight)
    upper = sparse.csr_array((data, indices, indptr), shape=(n, n)).toarray()
    L = reference.laplacian(ends, weight, n)
    same(upper, np.triu(L))
    x = g.rng.normal(size=(n, 2))
    same(core.symmetric_product(indptr.astype(kind), indices.astype(kind), data, x), L @ x)
    fixed = np.where(g.merged < 0, g.z, 0)
    expected = np.zeros(n + 1, dtype=complex)
    for (i, j), (a, b), w in zip(ends.T, g.edges, weight, strict=True):
        expected[i] += w * fixed[b]
        expected[j] += w * fixed[a]
    made = core.fixed_vertex_terms(ends, g.edges, weight, fixed, n)
    same(made, np.column_stack((expected.real, expected.imag))[:n])


def test_selected_rows_agree_with_the_matrix(given):
    g = given
    indptr, indices, _ = core.symmetric_pattern(g.pattern.edge_rows, g.pattern.n)
    n, rng = g.pattern.n, np.random.default_rng(2)
    block = rng.normal(size=(len(indices), 4))
    upper = sparse.bsr_array((block.reshape(-1, 2, 2), indices, indptr), shape=(2 * n, 2 * n)).tocsr()
    whole, some = upper + upper.T, np.flatnonzero(rng.random(n) < 0.2)
    number = np.full(n, -1)
    number[some] = np.arange(len(some))
    for kind in (np.int32, np.int64):
        start, column, place = core.block_rows(indptr.astype(kind), indices.astype(kind), number)
        assert all((np.diff(column[i:j]) > 0).all() for i, j in itertools.pairwise(start))
        of = np.repeat(some, np.diff(start))
        own = core.gather_row_blocks(block, column, place, of)
        rows = sparse.bsr_array(
            (own.reshape(-1, 2, 2), column, start), shape=(2 * len(some), 2 * n)
        ).toarray()
        both = (2 * some[:, None] + np.arange(2)).ravel()
        same(rows, whole[both].toarray())
    x, r, z = rng.normal(size=len(both)), rng.normal(size=2 * n + 3), rng.normal(size=2 * n)
    made = core.subtract_rows(start, column, own, x, r)
    same(made[: 2 * n], r[: 2 * n] - rows.T @ x)
    assert (made[2 * n :] == r[2 * n :]).all()
    same(core.row_residual(start, column, own, some, r, z), r[both] - rows @ z)


@pytest.mark.parametrize("turn", [0.3, 2.0, -1.4])
def test_maps_are_centred_by_their_moments(turn, given):
    g, m = given, given.corner.shape[1]
    lopsided = 1.5 * g.z.real + 1j * g.z.imag + 0.1 * g.z.real**2
    z = np.exp(1j * turn) * (lopsided + 3 - 2j)
    z = np.concatenate((z, 5 * np.conj(z)))  # two concatenated maps
    corner, double = np.hstack((g.corner, g.corner + g.n)), np.tile(g.mesh.double_area, 2)
    area, ends = np.array([1.0, 3.0]), (np.array([0, g.n, 2 * g.n]), np.array([0, m, 2 * m]))
    made = core.normalize_maps(z, corner, double, area, *ends)
    for k in range(2):
        own = slice(k * g.n, (k + 1) * g.n)
        same(made[own], reference.normalize_maps(z[own], g.corner, g.mesh.double_area, area[k]))


def test_the_rotation_of_a_symmetric_map_does_not_depend_on_rounding():
    square, corner = np.array([0, 1, 1 + 1j, 1j]), np.array([[0, 0], [1, 2], [2, 3]])
    ends = np.array([0, 4]), np.array([0, 2])
    made = [
        core.normalize_maps(
            (square - 0.5 - 0.5j) * (1 + 1e-14j * k), corner, np.ones(2), np.array([1.0]), *ends
        )
        for k in range(3)
    ]
    for other in made:
        np.testing.assert_allclose(other, made[0], atol=1e-12)
    np.testing.assert_allclose(np.sort(np.abs(made[0])), np.sqrt(0.5))


@pytest.mark.parametrize("size", [40, 300_000])
def test_conjugate_gradient_steps_are_taken_block_by_block(size):
    rng, start = np.random.default_rng(0), np.array([0, 3, 3, size, size])
    p, q, x, r = rng.normal(size=(4, size))
    share = np.array([0.7, 1, rng.normal(), 0])
    each = np.repeat([0.7, 0.5, 0, 0], np.diff(start))

    def dots(a, b):
        return np.array([a[i:j] @ b[i:j] for i, j in itertools.pairwise(start)])

    np.testing.assert_allclose(core.block_dots(start, p, q), dots(p, q), atol=1e-11 * size)
    gone, left, turned = x.copy(), r.copy(), p.copy()
    along = np.repeat(np.divide(share, dots(p, q), out=np.zeros(4), where=dots(p, q) != 0), np.diff(start))
    square = core.cg_step(start, share, p, q, gone, left)
    same(gone, x + along * p)
    same(left, r - along * q)
    same(square, dots(left, left))
    core.update_cg_direction(start, share, np.array([1, 2, 0, 0.0]), q, turned)
    same(turned, q + each * p)
    with pytest.raises(TypeError):  # an array of another type would be copied, and the result lost
        core.update_cg_direction(start, share, share, q, turned.astype(np.float32))


def test_the_number_of_threads_does_not_change_a_bit(monkeypatch):
    rng, start = np.random.default_rng(0), np.array([0, 600_000])
    a, b = rng.normal(size=(2, 600_000))
    found = set()
    for threads in ("1", "2", "5", "0", "all"):  # invalid values ("0", "all") mean the number of cores
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        found.add((*core.block_dots(start, a, b), *core.cg_step(start, np.ones(1), b, a, b.copy(), a.copy())))
    assert len(found) == 1


@pytest.mark.parametrize("kind", [np.int32, np.int64])
def test_products_with_many_rows_agree_with_the_matrix_for_any_number_of_threads(kind, monkeypatch):
    """From 250,000 rows on, threads share the rows, and each thread adds to both halves of the result."""
    rng, n = np.random.default_rng(0), 250_001
    ends = np.stack((rng.integers(n, size=n), rng.integers(n, size=n)))
    indptr, indices, _ = core.symmetric_pattern(ends, n)
    pattern = indptr.astype(kind), indices.astype(kind)
    block, data = rng.normal(size=(len(indices), 4)), rng.normal(size=len(indices))
    x = rng.normal(size=2 * n)
    upper = sparse.bsr_array((block.reshape(-1, 2, 2), indices, indptr), shape=(2 * n, 2 * n)).tocsr()
    one = sparse.csr_array((data, indices, indptr), shape=(n, n))
    pairs, made = x.reshape(n, 2), []
    for threads in ("1", "2"):
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        made.append((core.block_product(*pattern, block, x), core.symmetric_product(*pattern, data, pairs)))
    same(made[0], (upper @ x + upper.T @ x, one @ pairs + sparse.triu(one, 1).T @ pairs))
    for a, b in zip(*made, strict=True):
        np.testing.assert_array_equal(a, b)


def test_sums_reject_invalid_indices():
    with pytest.raises(ValueError, match="not below n"):
        core.sum_by_index(np.array([0, 3]), np.ones(2), 3)
    with pytest.raises(ValueError, match="not below n"):
        core.sum_by_index(np.array([0, -1]), np.ones(2), 3)
    with pytest.raises(ValueError, match="argument 2"):
        core.sum_by_index(np.array([0, 1]), np.ones(3), 3)
    assert core.sum_by_index(np.empty(0, dtype=np.int64), np.empty(0), 2).tolist() == [0, 0]


@pytest.mark.parametrize("sizes", [[30], [5, 80, 1, 40]])
def test_blocks_are_solved_independently(sizes):
    rng, start = np.random.default_rng(0), np.concatenate(([0], np.cumsum(sizes)))
    parts = [B @ B.T + np.diag(rng.uniform(1, 99, n)) for n in sizes for B in (rng.normal(size=(n, n)),)]
    A = sparse.block_diag([sparse.csr_array(part) for part in parts], format="csr")
    b = rng.normal(size=start[-1])
    diagonal = A.diagonal()
    x, steps, converged = conjugate_gradients(
        A.dot, b, lambda r: r / diagonal, 1e-10, start=None if len(sizes) == 1 else start
    )
    assert converged.all() and steps.dtype == np.int64 and converged.dtype == bool
    for k, part in enumerate(parts):
        own = slice(start[k], start[k + 1])
        alone, taken, _ = conjugate_gradients(part.dot, b[own], lambda r, s=own: r / diagonal[s], 1e-10)
        assert taken[0] == steps[k]
        np.testing.assert_allclose(x[own], alone, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(x, splu(A.tocsc()).solve(b), atol=1e-8)


def test_a_block_that_fails_does_not_affect_other_blocks():
    A = sparse.diags_array([1.0, 2, 3, np.nan, 0, 5]).tocsr()
    b, start = np.array([1.0, 1, 0, 1, 1, 1]), np.array([0, 2, 3, 4, 5, 6])
    x, steps, converged = conjugate_gradients(A.dot, b, lambda r: r, 1e-12, 9, start=start)
    assert converged.tolist() == [True, True, False, False, True]
    assert steps.tolist()[:2] == [2, 0] and steps[4] == 1
    np.testing.assert_allclose(x[[0, 1, 2, 5]], [1, 0.5, 0, 0.2])


def test_a_single_step_can_suffice():
    A, b = sparse.diags_array([1.0, 1.1]), np.array([1.0, 1.0])
    steps = [
        conjugate_gradients(A.dot, b, lambda r: r, 1e-9, first_rtol=first)[1][0] for first in (None, 0.1)
    ]
    assert steps == [2, 1]


def test_loops_follow_their_turning_and_scale():
    rng, n = np.random.default_rng(1), 40
    loops = [rng.permutation(n)[:size] for size in (3, 8, 19, 1)]
    turning, log_ratio = rng.normal(size=(2, n)) / 3
    log_ratio[5] = 800.0  # exp of this value overflows
    made = core.loop_gaps(np.concatenate(loops), np.cumsum([0, *map(len, loops)]), turning, log_ratio)
    for a, b in zip(made, reference.loop_gaps(loops, turning, log_ratio), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("prescribed", [0, 3, 30])
def test_outer_loops_are_closed_by_the_smallest_change_of_lengths(prescribed):
    rng, sizes = np.random.default_rng(prescribed), [3, 8, 30]
    start = np.cumsum([0, *sizes])
    turning, log_ratio = rng.normal(size=(2, start[-1])) / 3
    movable = np.arange(start[-1]) % 30 >= prescribed
    movable |= not movable.any()
    z, gaps = core.develop_loops(start, turning, log_ratio, movable)
    for i, gap in enumerate(gaps):
        own = slice(start[i], start[i + 1])
        if movable[own].any():
            there, relative = reference.developed_loop(turning[own], log_ratio[own], movable[own])
            np.testing.assert_allclose(z[own], there, rtol=0, atol=1e-11)
            assert gap == pytest.approx(relative, abs=1e-11)


@pytest.mark.parametrize("ratio", [800.0, 2000.0])  # exp overflows, and some edges have zero length
def test_an_outer_loop_with_vanishing_edges_is_laid_out(ratio):
    log_ratio = np.array([0.0, ratio, 0.0, 0.1, 0.0])
    z, gaps = core.develop_loops(np.array([0, 5]), np.full(5, 1.0), log_ratio, np.ones(5, dtype=bool))
    assert np.isfinite(z).all() and 0 < gaps[0] <= 1
