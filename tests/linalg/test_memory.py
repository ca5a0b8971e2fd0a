"""Computations that exceed the free memory are rejected before they begin."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import igl
import numpy as np
import psutil
import pytest
from conftest import bumps, load

from igl_linabf import LinABF, MeshError, flatten
from igl_linabf.angles import Pattern
from igl_linabf.errors import MemoryLimitError
from igl_linabf.linalg import Cholesky, memory
from igl_linabf.surface import build_planar_topology

LIMITED = """
import resource, sys
import igl, numpy as np
from igl_linabf import MeshError, flatten
V, F = igl.icosahedron()
V, F = igl.upsample(V, F, 7)
F = F[1:]
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
limit = used + int(sys.argv[1])
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
try:
    result = flatten(V, F)
except MeshError as error:
    print("refused:", error)
else:
    print(len(F), result.outcome.value)
"""


@pytest.fixture
def bytes_free(monkeypatch):
    def limit(count: int) -> None:
        monkeypatch.setattr(memory, "available_memory", lambda: count)
        monkeypatch.setattr(memory, "MIN_QUERIED_BYTES", 0)

    return limit


def test_a_factor_that_does_not_fit_is_rejected_before_work_begins(bytes_free, monkeypatch) -> None:
    V, F = bumps(8000)
    monkeypatch.setattr(memory, "BYTES_PER_FACE", 1)
    bytes_free(memory.factor_bytes(len(V) // 2))
    with pytest.raises(
        MemoryLimitError, match=r"factor of a system of \d,\d{3} rows would take about .* GiB"
    ):
        flatten(V, F, method=LinABF(rtol=1e-10))


def test_a_mesh_that_does_not_fit_into_memory_is_rejected_with_an_estimate(bytes_free) -> None:
    V, F = load("bumps")
    bytes_free(memory.BYTES_PER_FACE * len(F) - 1)
    with pytest.raises(MeshError, match=r"1,\d{3} faces take about .* GiB.*are free: decimate the mesh"):
        flatten(V, F)
    # the least-squares layout needs a factor in any case, so that the mesh does not fit
    bytes_free(memory.BYTES_PER_FACE * len(F) + 1)
    with pytest.raises(MeshError, match="decimate the mesh"):
        flatten(V, F, method=LinABF(layout="least-squares"))


def test_the_estimate_includes_the_columns_of_many_holes(bytes_free) -> None:
    n, step = 41, 4
    V, F = igl.triangulated_grid(n, n)
    row, column = np.floor(V[F].mean(axis=1) * (n - 1)).astype(int).T % step
    V, F = igl.remove_unreferenced(V, F[(row != 1) | (column != 1)])[:2]
    V = np.column_stack((V, 0.1 * np.sin(9 * V[:, 0])))
    bytes_free(memory.BYTES_PER_FACE * len(F) + memory.factor_bytes(len(V), 2) + 50 * 100 * len(V))
    with pytest.raises(MemoryLimitError, match=r"3,000 faces with 100 holes take about .*: fill small holes"):
        flatten(V, F)


@pytest.mark.skipif(sys.platform != "linux", reason="limits of the address space are Linux's")
@pytest.mark.parametrize(
    ("limit", "says"),
    [(2**28, "refused: 327,679 faces"), pytest.param(2**32, "327679 converged", marks=pytest.mark.slow)],
)
def test_the_memory_limit_of_the_process_is_respected(limit: int, says: str) -> None:
    process = subprocess.run(
        [sys.executable, "-c", LIMITED, str(limit)], capture_output=True, encoding="utf-8", timeout=500
    )
    assert process.returncode == 0, process.stderr
    assert process.stdout.startswith(says)


def test_free_memory_does_not_exceed_total_memory() -> None:
    free = memory.available_memory()
    assert free is not None
    assert 2**26 < free < 2**46


@pytest.mark.parametrize("block", [1, 2])
@pytest.mark.parametrize("side", [30, 100])
def test_the_estimated_size_of_a_factor_is_a_tight_upper_bound(side: int, block: int) -> None:
    n = side * side
    pattern = Pattern(
        build_planar_topology(igl.triangulated_grid(side, side)[1], np.arange(n)), np.arange(n), n
    )
    taken = Cholesky(pattern.indptr, pattern.indices, block).memory_bytes
    assert taken <= memory.factor_bytes(n, block) <= 4 * taken


@pytest.mark.skipif(sys.platform == "win32", reason="there are no such limits")
@pytest.mark.parametrize("limit", ["system", "address space", "memory.max", "memory_memory.limit_in_bytes"])
def test_free_memory_is_limited_by_the_tightest_limit(
    limit: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    import resource

    free, taken = 123 * 2**20, 17 * 2**20
    own = psutil.Process().memory_info().vms
    infinite = resource.RLIM_INFINITY
    soft = own + free if limit == "address space" else infinite
    monkeypatch.setattr(resource, "getrlimit", lambda _: (soft, infinite))
    left = free if limit == "system" else 2 * free
    monkeypatch.setattr(psutil, "virtual_memory", lambda: SimpleNamespace(available=left))
    monkeypatch.setattr(
        memory, "Path", lambda name: tmp_path / name.removeprefix("/sys/fs/cgroup/").replace("/", "_")
    )
    for version, used in (
        ("memory.max", "memory.current"),
        ("memory_memory.limit_in_bytes", "memory_memory.usage_in_bytes"),
    ):
        (tmp_path / version).write_text(str(free + taken if limit == version else "max"))
        (tmp_path / used).write_text(str(taken))
    # the process may allocate or free memory in the meantime
    assert memory.available_memory() == pytest.approx(free, abs=2**24)
