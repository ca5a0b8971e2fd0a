"""Measure what bounds on the whole atlas cost: seams, charts and time of `max_dirichlet` and `max_charts`.

    python benchmarks/bounds.py

Measure the models of trade.py, and print Markdown.
"""

from __future__ import annotations

import warnings
from time import process_time

import igl
from meshes import Mesh
from peers import relative_seams
from trade import models

from igl_linabf import ChartOptions, OutcomeWarning, unwrap
from igl_linabf.charts.atlas import mean_energy

BOUNDS = {
    "default": ChartOptions(),
    "max_dirichlet=4.1": ChartOptions(max_dirichlet=4.1),
    "max_dirichlet=4.03": ChartOptions(max_dirichlet=4.03),
    "max_charts=1": ChartOptions(max_charts=1),
}
HEADS = "model | method | bound | met | charts | seams / sqrt(area) | mean energy | trade | CPU time"


def print_rows(mesh: Mesh, method: str) -> None:
    """Print one row for each bound; times are relative to the row without bounds."""
    name, V, F = mesh
    unit = 0.0
    for label, charts in BOUNDS.items():
        start = process_time()
        atlas = unwrap(V, F, charts=charts, method=method)
        seconds = process_time() - start
        unit = unit or seconds
        seams, energy = relative_seams(V, F, atlas.FTC), mean_energy(atlas)
        cells = [name, method, label, "yes" if atlas.good else "no", str(len(atlas.charts)), f"{seams:.2f}"]
        cells += [f"{energy:.3f}", f"{atlas.report.bounds.trade:.3g}", f"{seconds / unit:.1f}"]
        print(f"| {' | '.join(cells)} |", flush=True)


def main() -> None:
    warnings.simplefilter("ignore", OutcomeWarning)
    print(
        "The mean energy is the symmetric Dirichlet energy of the atlas, 4 for an isometry. CPU times are\n"
        "relative to the atlas with default options. Trade is the value that the search found.\n"
    )
    print(f"| {HEADS} |\n|{'---|' * (HEADS.count('|') + 1)}")
    unwrap(*igl.icosahedron(), method="isometric")  # warm-up, which includes lazy imports
    for mesh in models():
        for method in ("isometric", "linabf"):
            print_rows(mesh, method)


if __name__ == "__main__":
    main()
