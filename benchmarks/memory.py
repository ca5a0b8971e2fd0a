"""Compare the peak memory per face with the estimate of `igl_linabf.linalg.memory`.

    python benchmarks/memory.py [TIMES]

The mesh is the cortex of the nilearn package, subdivided TIMES times (default: 2). The mesh is flattened with
each solver in a new process.
"""

from __future__ import annotations

import subprocess
import sys

import igl
from meshes import cortex

from igl_linabf import LinABF, flatten
from igl_linabf.linalg import memory

RUNS = {
    "auto": LinABF(),
    "auto, least squares": LinABF(layout="least-squares"),
    "CHOLMOD": LinABF(solver="cholmod"),
}


def run(name: str, times: int) -> None:
    """Flatten with one solver, and print a row of the table."""
    import resource

    V, F, _ = cortex()
    for _ in range(times):
        V, F = igl.upsample(V, F)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    flatten(V, F, method=RUNS[name])
    measured = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)  # Linux reports KiB
    blocks = [1, 2] if "least squares" in name else [1]
    estimated = memory.BYTES_PER_FACE * len(F) + sum(memory.factor_bytes(len(V), block) for block in blocks)
    print(f"| {name} | {len(F):,} | {measured / len(F):.0f} | {estimated / len(F):.0f} |")


if __name__ == "__main__":
    if len(sys.argv) == 3:
        run(sys.argv[1], int(sys.argv[2]))
    else:
        print("| solver | triangles | bytes per face, measured | estimated |\n|---|---|---|---|", flush=True)
        for name in RUNS:
            subprocess.run([sys.executable, __file__, name, *(sys.argv[1:] or ["2"])], check=True)
