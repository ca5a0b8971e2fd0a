"""The paper's Table 1: time and F/3nt of converged ABF and of one step of linear ABF.

    python benchmarks/table1.py [--repeat 5]

The meshes are the cortex and every disk in IGL_LINABF_MESHES. Times are medians, as ratios to igl.lscm in the
same process. Blender's ABF is added if `bpy` is installed. `PAPER` holds the paper's own values, which are
printed beside ours. Prints Markdown.
"""

from __future__ import annotations

import argparse
import warnings
from functools import partial

from meshes import brain, shared

from igl_linabf import OutcomeWarning, abf, linabf, quality
from igl_linabf.flattening import bare_lscm, medians
from igl_linabf.flattening import other_programs as peers
from igl_linabf.surface import planar_mesh

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
# The paper's values, by our mesh of the same model: (triangles there, seconds of its ABF, of linear ABF,
# F/3nt of its ABF, of linear ABF). Empty: the text of its table could not be had where this was written.
# Whoever has the paper (SGP 2007, pages 135-141) puts them here, and they are printed beside ours.
PAPER: dict[str, tuple[int, float, float, float, float]] = {}
NO_VALUES = """\
The columns are those of the paper's Table 1, time and F/3nt. The paper's own values are not beside them:
its text could not be had where this was written, so they could not be checked. `PAPER` in
`benchmarks/table1.py` is the place for them. What differs in any case: the paper's times are of its machine
and of its program for ABF, while these are ratios to `igl.lscm` within one process; and these meshes need
not be the paper's.
"""
VALUES = """\
The column "paper" holds the values of the paper's Table 1 for the same model, which may be another mesh or
another cut of it: triangles, seconds of its ABF and of linear ABF on its machine, F/3nt of both.
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    warnings.simplefilter("ignore", OutcomeWarning)
    others = [name for name in peers.installed() if name.endswith("ABF")]
    print("Times relative to igl.lscm. linABF: one iteration. ABF: to its default tolerance, and to 1e-7.\n")
    print(VALUES if PAPER else NO_VALUES)
    heads = [*COLUMNS, *(f"{name}: time, F/3nt" for name in others), *["paper"] * bool(PAPER)]
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for name, V, F in [brain(), *shared("disk")]:
        mesh = planar_mesh(V, F)
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
        if PAPER:
            cells.append(", ".join(f"{value:,g}" for value in PAPER.get(name, ())))
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
