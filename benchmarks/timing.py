"""Measure the time of linabf relative to igl.lscm: medians in one process after a warm-up, with input checks.

    python benchmarks/timing.py [--repeat 5] [--solver auto|cholmod|direct] [--large] [MESH ...]

Without MESH, the meshes are the cortex, lion, face and camelhead from IGL_LINABF_MESHES, and face subdivided
once (with --large also twice, 827 k triangles). Prints Markdown.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from meshes import Mesh, brain, load_shared_meshes, subdivide

from igl_linabf import LinABF, flatten, linabf
from igl_linabf.flattening import make_lscm_call, measure_median_times
from igl_linabf.io import read_mesh
from igl_linabf.linalg import find_cholmod_blas
from igl_linabf.surface import planar_mesh

STAGES = ("check", "estimate", "assembly", "analysis", "factor", "solve", "layout")


def choose_meshes(options: argparse.Namespace) -> Iterator[Mesh]:
    """Yield the meshes of the command line, or the default meshes."""
    if options.mesh:
        for path in options.mesh:
            yield path.stem, *read_mesh(path)
        return
    yield brain()
    for mesh in load_shared_meshes("disk"):
        if mesh[0] in ("igl_lion", "igl_camelhead", "igl_face"):
            yield mesh
        if mesh[0] == "igl_face":
            yield subdivide(mesh, 1)
            if options.large:
                yield subdivide(mesh, 2)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("mesh", nargs="*", type=Path)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--solver", default="auto")
    parser.add_argument("--large", action="store_true")
    options = parser.parse_args()
    by_cholmod = options.solver == "cholmod"
    print(
        f"CHOLMOD uses the BLAS library {find_cholmod_blas() or '(unknown)'}.\n"
        if by_cholmod
        else "The times of this section are measured without CHOLMOD.\n"
    )
    print("| mesh | triangles | linabf / igl.lscm | " + " | ".join(STAGES) + " | other |")
    print("|---|---|---|" + "---|" * (len(STAGES) + 1))
    for name, V, F in choose_meshes(options):
        bare = make_lscm_call(planar_mesh(V, F))
        calls = [partial(linabf, V, F, solver=options.solver), bare]
        measure_median_times(calls, 1)  # warm-up: not timed
        ours, theirs = measure_median_times(calls, options.repeat)
        results = [flatten(V, F, method=LinABF(solver=options.solver)).seconds for _ in range(3)]
        share = {s: statistics.median(r[s] / r["total"] for r in results) for s in STAGES}
        share["other"] = 1 - sum(share.values())
        cells = " | ".join(f"{value:.0%}" for value in share.values())
        print(f"| {name} | {len(F):,} | **{ours / theirs:.2f}** | {cells} |", flush=True)


if __name__ == "__main__":
    main()
