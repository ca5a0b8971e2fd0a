"""Measure maps of meshes with holes, without cuts: F/3nt, flips, closure residual, relative time.

    python benchmarks/uncut.py [--repeat 5]

The meshes are the crown of the demo and the meshes of kind holes in IGL_LINABF_MESHES. Prints Markdown.
"""

from __future__ import annotations

import argparse
import warnings
from functools import partial

from meshes import crown, load_shared_meshes

from igl_linabf import LinABF, OutcomeWarning, abf, flatten, linabf, quality
from igl_linabf.flattening import make_lscm_call, measure_median_times
from igl_linabf.surface import planar_mesh


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    warnings.simplefilter("ignore", OutcomeWarning)
    print(
        "Each cell contains F/3nt and the number of flipped triangles; the number of iterations, the\n"
        "largest closure residual of a hole, and the **time relative to igl.lscm**.\n"
    )
    print("| mesh | triangles | holes | igl.lscm | one step | default | converged | ABF |")
    print("|---|---|---|---|---|---|---|---|")
    for name, V, F in [crown(), *load_shared_meshes("holes")]:
        runs = [
            partial(linabf, V, F, iterations=1),
            partial(linabf, V, F),
            partial(linabf, V, F, iterations=12),
            partial(abf, V, F),
        ]
        calls = [make_lscm_call(planar_mesh(V, F)), *runs]
        measure_median_times(calls, 1)  # warm-up: not timed
        lscm, *times = measure_median_times(calls, options.repeat)
        results = [flatten(V, F, method="lscm")]
        results += [flatten(V, F, method=LinABF(iterations=iterations)) for iterations in (1, "auto", 12)]
        results += [flatten(V, F, method="abf")]
        cells = []
        for result, seconds in zip(results, (lscm, *times), strict=True):
            q = quality(V, F, result.uv)
            cell = f"{q.angle_distortion:.3g}, {q.flips}"
            if result.report.steps:
                cell += f"; {result.report.iterations}, {result.after.closure:.0e}, **{seconds / lscm:.1f}**"
            cells.append(cell)
        print(f"| {name} | {len(F):,} | {len(results[0].holes)} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
