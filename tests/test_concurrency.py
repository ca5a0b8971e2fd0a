"""Results are identical to the bit in sequence, in threads, in processes, and for all hash seeds."""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import stat
import subprocess
import sys
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from functools import cache
from pathlib import Path
from threading import Barrier

import numpy as np
import pytest
from conftest import ROOT, bumps
from hostile_meshes import Disk, close_with_copy

from igl_linabf import LinABF, flatten, unwrap
from igl_linabf.io import write_obj
from igl_linabf.linalg import has_cholmod

# more tasks than threads, of different sizes, methods and solvers
WORK = [(kind, seed) for seed in range(6) for kind in ("linabf", "abf", "direct", "lscm", "unwrap")]


def fingerprint(kind: str, seed: int) -> str:
    V, F = bumps(300 + 150 * seed, seed)
    if kind == "unwrap":
        V, F = close_with_copy(*bumps(150 + 40 * seed, seed))
        atlas = unwrap(V, F)
        arrays = [atlas.TC, atlas.FTC, atlas.seams]
    else:
        V, F = Disk(n=len(V), holes=seed % 3, seed=seed).build() if seed % 2 else (V, F)
        result = flatten(V, F, method=LinABF(solver=kind) if kind == "direct" else kind)
        arrays = [result.uv, result.angles]
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


@cache
def run_in_turn() -> list[str]:
    return [fingerprint(*work) for work in WORK]


def run_at_once(pool: Executor) -> list[str]:
    with pool:
        return list(pool.map(fingerprint, *zip(*WORK, strict=True)))


def test_eight_threads_give_the_same_numbers() -> None:
    assert run_at_once(ThreadPoolExecutor(8)) == run_in_turn()
    assert run_at_once(ThreadPoolExecutor(8, initializer=Barrier(8).wait, initargs=(300,))) == run_in_turn()


# supernodal factorization by CHOLMOD may have started threads of OpenBLAS before the fork
@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
@pytest.mark.parametrize(
    "method",
    ["fork", pytest.param("spawn", marks=pytest.mark.slow)] if sys.platform == "linux" else ["spawn"],
)
def test_processes_give_the_same_numbers(method: str) -> None:
    expected = run_in_turn()
    context = multiprocessing.get_context(method)
    assert run_at_once(ProcessPoolExecutor(2, context)) == expected


def test_runs_give_the_same_numbers_for_any_hash_seed() -> None:
    code = "from test_concurrency import *; print(*run_in_turn())"
    path = os.pathsep.join((str(ROOT / "tests"), str(ROOT)))
    for seed in ("0", "1234"):
        process = subprocess.run(
            [sys.executable, "-W", "ignore", "-c", code],
            env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": path},
            capture_output=True,
            encoding="utf-8",
            timeout=500,
        )
        assert process.stdout.split() == run_in_turn(), process.stderr


@pytest.mark.skipif(not has_cholmod(), reason="CHOLMOD is not installed")
def test_supernodal_factors_are_the_same_in_threads() -> None:
    from igl_linabf.linalg import cholmod

    V, F = bumps(4000)
    before, method = cholmod.SIMPLICIAL_ROWS, LinABF(solver="cholmod")
    cholmod.SIMPLICIAL_ROWS = 100  # the default creates supernodes only for meshes of 40,000 vertices
    try:
        first = flatten(V, F, method=method).uv
        with ThreadPoolExecutor(8) as pool:
            for result in pool.map(lambda _: flatten(V, F, method=method), range(16)):
                assert (result.uv == first).all()
    finally:
        cholmod.SIMPLICIAL_ROWS = before


@pytest.mark.skipif(os.name != "posix", reason="file modes exist on POSIX only")
def test_files_written_in_threads_have_the_mode_of_the_umask(tmp_path: Path) -> None:
    V, F = bumps(60)
    mask = os.umask(0o027)
    try:
        with ThreadPoolExecutor(8) as pool:
            list(pool.map(lambda i: write_obj(tmp_path / f"{i}.obj", V, F, V[:, :2]), range(64)))
        assert os.umask(0o027) == 0o027
    finally:
        os.umask(mask)
    assert {stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()} == {0o640}
    assert len(list(tmp_path.iterdir())) == 64
