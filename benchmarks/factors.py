"""Compare the factors of the core and of CHOLMOD (time, fill, memory), for docs/performance.md.

    python benchmarks/factors.py [--largest 6] [--repeat 5] [--print]

The matrices are the cotangent Laplacians of the interior vertices of two disks, camel_b and face, with
subdivided triangles. Each matrix is analysed, factored and solved for two right-hand sides in a separate
process. Times are medians; the largest matrices run once. Fill is the number of entries of the factor divided
by the number of entries in the lower triangle of the matrix. Memory is the growth of the process at its peak
(Linux). `--largest N` takes the first N sizes.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np
from meshes import load_shared_meshes, split_triangles
from pages import arguments, publish
from performance import peak_memory
from scipy import sparse

from igl_linabf.angles import build_constraints, corner_angles
from igl_linabf.angles.steps.iterates import Iterate
from igl_linabf.linalg import Cholesky, Solvers, has_cholmod
from igl_linabf.surface import planar_mesh

NAMES = {"auto": "core", "cholmod": "CHOLMOD"}
SIZES = (("igl_camel_b", 1), ("igl_face", 1), ("igl_face", 2), ("igl_face", 4), ("igl_face", 8))
SINGLE_RUN = 500_000  # matrices of at least as many triangles run only once


def laplacian(name: str, times: int) -> tuple[int, sparse.csc_array]:
    """Return the number of triangles and the lower triangle of the Laplacian of a subdivided disk."""
    (mesh,) = (mesh for mesh in load_shared_meshes("disk") if mesh[0] == name)
    surface = planar_mesh(*split_triangles(mesh, times)[1:])
    constraints = build_constraints(surface.topology)
    iterate = Iterate.from_angles(constraints, corner_angles(surface))
    return len(surface.double_area), constraints.pattern.build_laplacian(
        surface.topology.sum_at_edges(iterate.cot) / 2
    )


def time_call(work: Callable[[], object]) -> tuple[float, object]:
    """Return the seconds that `work` takes, and its result."""
    start = perf_counter()
    result = work()
    return perf_counter() - start, result


def print_measurement(name: str, times: int, solver: str, repeat: int) -> None:
    """Print the numbers of a table row: triangles, milliseconds, fill, and megabytes."""
    triangles, lower = laplacian(name, times)
    b, times_of_runs = np.random.default_rng(0).normal(size=(lower.shape[0], 2)), []
    Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")  # reset the peak memory of the process
    before = peak_memory()
    for _ in range(1 if triangles > SINGLE_RUN else repeat):
        analysing, analysis = time_call(lambda: Solvers(solver).analyse(lower.indptr, lower.indices))
        factoring, factor = time_call(lambda: analysis.factor(lower.data))  # noqa: B023
        solving, _ = time_call(lambda: factor.solve(b))  # noqa: B023
        times_of_runs.append((analysing, factoring, solving))
    times_ms = [1000 * value for value in np.median(times_of_runs, axis=0)]
    growth = peak_memory() - before
    print(json.dumps([triangles, *times_ms, count_entries(lower, solver) / lower.nnz, growth / 1e6]))


def count_entries(lower: sparse.csc_array, solver: str) -> int:
    """Return the number of entries of the factor, including zeros within supernodes."""
    if solver == "auto":
        return Cholesky(lower.indptr, lower.indices).memory_bytes // 8
    from sksparse import cholmod

    return cholmod.cholesky(sparse.csc_matrix(lower), mode="simplicial", ordering_method="amd").L().nnz


def make_row(name: str, times: int, solver: str, repeat: int) -> str:
    """Return the table row of a matrix and a solver, measured in a separate process."""
    code = f"import factors; factors.print_measurement({name!r}, {times}, {solver!r}, {repeat})"
    command, folder = [sys.executable, "-c", code], Path(__file__).parent
    process = subprocess.run(
        command, cwd=folder, capture_output=True, encoding="utf-8", check=True, env=os.environ
    )
    triangles, *figures = json.loads(process.stdout.splitlines()[-1])
    return f"| {triangles:,} | {NAMES[solver]} | {' | '.join(f'{value:.3g}' for value in figures)} |"


def main() -> None:
    parser = arguments(__doc__, 5)
    parser.add_argument("--largest", type=int, default=len(SIZES))
    options = parser.parse_args()
    heads = "| triangles | of | analyse, ms | factor, ms | solve for two, ms | fill | MB |"
    lines = [heads, "|---|---|---|---|---|---|---|"]
    for name, times in SIZES[: options.largest]:
        for solver in ("auto", "cholmod") if has_cholmod() else ("auto",):
            lines.append(make_row(name, times, solver, options.repeat))
    page = "`python benchmarks/factors.py`\n\n" + "\n".join(lines)
    publish("factors", page, options.printed)


if __name__ == "__main__":
    main()
