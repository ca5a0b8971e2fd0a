"""The paper's Table 1: time and F/3nt of converged ABF and of one step of linear ABF.

    python benchmarks/table1.py [--repeat 5]

The meshes are the cortex and every disk in IGL_LINABF_MESHES. Times are medians, as ratios to igl.lscm in the
same process. Blender's ABF is added if `bpy` is installed. Prints Markdown.
"""

from __future__ import annotations

import argparse
import warnings
from functools import partial

from meshes import brain, shared

from igl_linabf import OutcomeWarning, abf, linabf, quality
from igl_linabf.flattening import bare_lscm, medians
from igl_linabf.flattening import other_programs as peers
from igl_linabf.surface import planar

COLUMNS = (
    "mesh",
    "triangles",
    "time ABF",
    "to 1e-7",
    "time linABF",
    "F/3nt ABF",
    "F/3nt linABF",
    "differs by",
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    warnings.simplefilter("ignore", OutcomeWarning)
    others = [name for name in peers.installed() if name.endswith("ABF")]
    print("Times relative to igl.lscm. linABF: one iteration. ABF: to its default tolerance, and to 1e-7.\n")
    heads = [*COLUMNS, *(f"{name}: time, F/3nt" for name in others)]
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for name, V, F in [brain(), *shared("disk")]:
        mesh = planar(V, F)
        calls = [
            bare_lscm(mesh),
            partial(abf, V, F),
            partial(abf, V, F, tol=1e-7),
            partial(linabf, V, F, iterations=1),
        ]
        medians(calls, 1)  # a warm-up
        lscm, *times = medians(calls, options.repeat)
        converged, fine, linear = (f"{seconds / lscm:.2f}" for seconds in times)
        exact, one = (quality(V, F, uv).angle_distortion for uv in (abf(V, F), linabf(V, F, iterations=1)))
        cells = [name, f"{len(F):,}", converged, fine, linear]
        cells += [f"{exact:.4g}", f"{one:.4g}", f"{100 * (one / exact - 1):+.2f} %"]
        for other in others:
            uv, seconds = peers.run(other, mesh.V, mesh.faces)
            cells.append(f"{seconds / lscm:.1f}, {quality(V, F, uv).angle_distortion:.4g}")
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
