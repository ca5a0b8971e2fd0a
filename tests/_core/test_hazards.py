"""The core reports arrays of wrong lengths, lack of memory, and sizes beyond the limits of its integers."""

from __future__ import annotations

import gc
import os
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from conftest import bumps
from scipy import sparse

from igl_linabf import _core

GRID = 150  # points along the side of a grid whose matrix is factored in parallel
FEATURES = "pni ssse3 fma cx16 sse4_1 sse4_2 movbe popcnt avx f16c bmi1 avx2 bmi2 lahf_lm abm"

WITHOUT_MEMORY = """
import resource, sys
import numpy as np
from scipy import sparse
from igl_linabf import _core
n = int(sys.argv[1])
path = sparse.diags([-np.ones(n - 1), 2 * np.ones(n)], [-1, 0])
A = sparse.tril(sparse.kron(path, sparse.eye(n)) + sparse.kron(sparse.eye(n), path)).tocsc()
A.sort_indices()
symbolic = _core.Symbolic(A.indptr, A.indices)
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
errors = 0
for more in np.linspace(0, 60e6, 41):
    resource.setrlimit(resource.RLIMIT_AS, (used + int(more), resource.RLIM_INFINITY))
    try:
        symbolic.factor(A.data).solve(np.ones((n * n, 8)))
    except MemoryError:
        errors += 1
print(errors)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are tested on Linux")
@pytest.mark.skipif(_core.CHECKED, reason="sanitizers reserve more memory than the limit")
def test_a_factorization_without_memory_raises_a_memory_error_and_never_aborts() -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_MEMORY, str(GRID)],
        capture_output=True,
        encoding="utf-8",
        env={**os.environ, "OMP_NUM_THREADS": "8"},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert 0 < int(done.stdout) < 41


def test_a_factor_outlives_its_analysis() -> None:
    symbolic = _core.Symbolic(np.array([0, 1, 2]), np.array([0, 1]))
    factor = symbolic.factor(np.array([4.0, 9.0]))
    del symbolic
    gc.collect()
    assert factor.solve(np.array([8.0, 9.0])).tolist() == [2.0, 1.0]


@pytest.mark.skipif(_core.CHECKED, reason="takes minutes with sanitizers")
@pytest.mark.slow
def test_a_front_with_more_than_two_to_the_32_entries_is_refused() -> None:
    n, degree, rng = 130_000, 8, np.random.default_rng(0)
    ends = rng.integers(n, size=(2, degree * n))
    A = sparse.coo_array((np.ones(degree * n), ends), shape=(n, n))
    L = sparse.csc_array(sparse.tril(A + A.T + sparse.eye_array(n)))
    L.sort_indices()
    with pytest.raises(ValueError, match="entries in a front"):
        _core.Symbolic(L.indptr, L.indices)


def test_more_nodes_than_a_packed_pair_can_store_are_refused() -> None:
    corner, none = np.array([[0], [1], [2]]), np.zeros(0, dtype=np.int64)
    n = 2**31 + 1
    for call in (
        lambda: _core.find_edges(corner, n),
        lambda: _core.group_sides(none, none, n),
        lambda: _core.symmetric_pattern(np.zeros((2, 0), dtype=np.int64), n),
        lambda: _core.shortest_edges(np.zeros((0, 2), dtype=np.int64), np.zeros(0), n),
    ):
        with pytest.raises(ValueError, match="nodes"):
            call()


@pytest.mark.skipif(not Path("/proc/cpuinfo").exists(), reason="features are listed on Linux")
def test_the_fast_build_is_chosen_only_if_the_processor_has_all_features_of_x86_64_v3() -> None:
    flags = re.search(r"^flags\s*:(.*)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    expected = flags is not None and set(FEATURES.split()) <= set(flags[1].split())
    assert _core._baseline.has_v3() == expected


def make_calls() -> dict[str, tuple[tuple[object, ...], list[int]]]:
    """Return valid arguments of core functions, and the indices of arguments whose lengths have to agree."""
    V, F = bumps(60)
    corner, n = np.ascontiguousarray(F.T), len(V)
    edges, sides, _ = _core.find_edges(corner, n)
    double_area, dot, _ = _core.side_products(V, corner)
    angle = np.arctan2(double_area, dot)
    indptr, indices, edge = _core.shortest_edges(edges, np.ones(len(edges)), n)
    length, mask, price = np.ones(len(edge)), np.ones(n, dtype=bool), np.ones(len(edges))
    x, y, plane, z = V[:, 0].copy(), V[:, 1].copy(), V[:, :2].copy(), V[:, 0] + 1j * V[:, 1]
    line = np.ones((1, 2))
    return {
        "side_products": ((V, corner), [1]),
        "count_fans": ((corner, sides, n), [0, 1]),
        "angle_sums": ((corner, angle, 1 / np.tan(angle), n), [0, 1, 2]),
        "errors": ((corner, angle, double_area, angle, x, y), [0, 1, 2, 3, 4, 5]),
        "edge_sums": ((angle, sides), [0]),
        "nearest_sources": ((indptr, indices, length, np.array([0]), mask, 9.0), [0, 1, 2, 4]),
        "minimum_cut_side": ((edges, price.astype(np.int64), n, 0, n - 1), [0, 1]),
        "block_dots": ((np.array([0, n]), x, y), [1, 2]),
        "isometric_energy": ((corner, angle + 0j, double_area, z, 1.0), [0, 1, 2]),
        "evaluate_cut_lines": (
            (plane, edges, price, mask, line, line[0, :1], np.ones((2, 4))),
            [0, 1, 2, 3, 4, 5, 6],
        ),
    }


@pytest.mark.parametrize("name", make_calls())
def test_arrays_that_do_not_fit_together_are_refused(name: str) -> None:
    function, (arguments, bound) = getattr(_core, name), make_calls()[name]
    function(*arguments)
    for i in bound:
        short = [value[:-1] if k == i else value for k, value in enumerate(arguments)]  # type: ignore[index]
        with pytest.raises(ValueError, match="of the core is"):
            function(*short)


def test_integers_out_of_range_are_refused() -> None:
    edges, capacity = np.array([[0, 1]]), np.ones(1, dtype=np.int64)
    for n, source, sink in ((2, 0, 2), (2, -1, 1), (-1, 0, 0)):
        with pytest.raises(ValueError, match="of the core is"):
            _core.minimum_cut_side(edges, capacity, n, source, sink)


@pytest.mark.skipif(not _core.CHECKED, reason="`make sanitize` runs this test")
@pytest.mark.parametrize("bad", [-1, 10**6])
def test_a_checked_build_rejects_indices_out_of_range(bad: int) -> None:
    V, index = np.ones((3, 3)), np.array([0, 1, bad])
    corner, z = index[:, None].copy(), np.ones(3, dtype=complex)
    for call in (
        lambda: _core.side_products(V, corner),
        lambda: _core.lengths(V, index[None, 1:].copy()),
        lambda: _core.find_edges(corner, 3),
        lambda: _core.signed_double_areas(z, corner),
        lambda: _core.shortest_edges(index[None, 1:].copy(), np.ones(1), 3),
        lambda: _core.min_rectangle_rotations(z, np.array([0, bad])),
    ):
        with pytest.raises(IndexError):
            call()


def test_a_list_of_pairs_beyond_the_limit_has_one_pair_more() -> None:
    n = 3_000
    z, F = np.tile([0, 1, 1j], n), np.arange(3 * n).reshape(n, 3)
    pairs = _core.find_overlaps(z, F, np.zeros(n, dtype=np.int64), 1_000)
    assert pairs.shape == (1_001, 2) and (pairs[:, 0] < pairs[:, 1]).all()
    assert all(a < b for a, b in pairwise(map(tuple, pairs.tolist())))
    assert len(_core.find_overlaps(z[:30], F[:10], np.zeros(10, dtype=np.int64), 45)) == 45
