"""Write into docs/performance.md what a factor of the core costs beside CHOLMOD's: time, fill, memory.

    python benchmarks/factors.py [--largest 6] [--repeat 5] [--print]

The matrices are the cotangent Laplacians of disks, camel_b and face and finer ones, over the interior
vertices. Each is analysed, factored, and solved with for two right-hand sides, in a process of its own;
medians, of the largest ones one run. Fill is the factor's entries over those of the matrix's lower triangle,
memory what the process grows by at the peak (Linux). `--largest N` takes the first N sizes.
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
from meshes import divided, shared
from pages import arguments, publish
from performance import most_used
from scipy import sparse

from igl_linabf.angles import constraints_of, corner_angles
from igl_linabf.angles.steps.iterates import Iterate
from igl_linabf.linalg import Cholesky, Solvers, has_cholmod
from igl_linabf.surface import planar_mesh

NAMES = {"auto": "core", "cholmod": "CHOLMOD"}
SIZES = (("igl_camel_b", 1), ("igl_face", 1), ("igl_face", 2), ("igl_face", 4), ("igl_face", 8))
MUCH = 500_000  # triangles from which one run has to do


def laplacian(name: str, times: int) -> tuple[int, sparse.csc_array]:
    """Triangles, and the lower triangle of the Laplacian of a disk, each triangle of which is divided."""
    (mesh,) = (mesh for mesh in shared("disk") if mesh[0] == name)
    surface = planar_mesh(*divided(mesh, times)[1:])
    constraints = constraints_of(surface.topology)
    at = Iterate.of(constraints, corner_angles(surface))
    return len(surface.double_area), constraints.pattern.laplacian(surface.topology.sum_at_edges(at.cot) / 2)


def seconds(work: Callable[[], object]) -> tuple[float, object]:
    start = perf_counter()
    made = work()
    return perf_counter() - start, made


def measured(name: str, times: int, solver: str, repeat: int) -> None:
    """Print a row's numbers: triangles, milliseconds, fill, megabytes."""
    triangles, lower = laplacian(name, times)
    b, taken = np.random.default_rng(0).normal(size=(lower.shape[0], 2)), []
    Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")  # the peak so far is forgotten
    before = most_used()
    for _ in range(1 if triangles > MUCH else repeat):
        analysing, analysis = seconds(lambda: Solvers(solver).analyse(lower.indptr, lower.indices))
        factoring, factor = seconds(lambda: analysis.factor(lower.data))  # noqa: B023
        solving, _ = seconds(lambda: factor.solve(b))  # noqa: B023
        taken.append((analysing, factoring, solving))
    times_ms = [1000 * value for value in np.median(taken, axis=0)]
    grown = most_used() - before
    print(json.dumps([triangles, *times_ms, entries(lower, solver) / lower.nnz, grown / 1e6]))


def entries(lower: sparse.csc_array, solver: str) -> int:
    """Of the factor: with the zeros within supernodes, where it has such."""
    if solver == "auto":
        return Cholesky(lower.indptr, lower.indices).bytes // 8
    from sksparse import cholmod

    return cholmod.cholesky(sparse.csc_matrix(lower), mode="simplicial", ordering_method="amd").L().nnz


def row(name: str, times: int, solver: str, repeat: int) -> str:
    """The row of a matrix and a solver."""
    code = f"import factors; factors.measured({name!r}, {times}, {solver!r}, {repeat})"
    command, folder = [sys.executable, "-c", code], Path(__file__).parent
    done = subprocess.run(
        command, cwd=folder, capture_output=True, encoding="utf-8", check=True, env=os.environ
    )
    triangles, *figures = json.loads(done.stdout.splitlines()[-1])
    return f"| {triangles:,} | {NAMES[solver]} | {' | '.join(f'{value:.3g}' for value in figures)} |"


def main() -> None:
    parser = arguments(__doc__, 5)
    parser.add_argument("--largest", type=int, default=len(SIZES))
    options = parser.parse_args()
    heads = "| triangles | of | analyse, ms | factor, ms | solve for two, ms | fill | MB |"
    lines = [heads, "|---|---|---|---|---|---|---|"]
    for name, times in SIZES[: options.largest]:
        for solver in ("auto", "cholmod") if has_cholmod() else ("auto",):
            lines.append(row(name, times, solver, options.repeat))
    page = "`python benchmarks/factors.py`\n\n" + "\n".join(lines)
    publish("factors", page, options.printed)


if __name__ == "__main__":
    main()
