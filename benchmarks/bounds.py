"""Measure what bounds on the whole atlas cost: seams, charts and time of `max_dirichlet` and `max_charts`.

    python benchmarks/bounds.py

The models are those of trade.py. Prints Markdown.
"""

from __future__ import annotations

import warnings
from time import process_time

import numpy as np
from meshes import Mesh
from peers import relative_seams
from trade import models

from igl_linabf import Atlas, ChartOptions, OutcomeWarning, unwrap

BOUNDS = {
    "default": ChartOptions(),
    "max_dirichlet=4.1": ChartOptions(max_dirichlet=4.1),
    "max_dirichlet=4.03": ChartOptions(max_dirichlet=4.03),
    "max_charts=1": ChartOptions(max_charts=1),
}
HEADS = "model | method | bound | met | charts | seams / sqrt(area) | mean energy | trade | CPU time"


def unwrap_timed(V: np.ndarray, F: np.ndarray, charts: ChartOptions, method: str) -> tuple[Atlas, float]:
    """Return the atlas and its CPU time in seconds."""
    start = process_time()
    atlas = unwrap(V, F, charts=charts, method=method)
    return atlas, process_time() - start


def print_rows(mesh: Mesh, method: str) -> None:
    """Print one row for each bound; times are relative to the row without bounds."""
    name, V, F = mesh
    unit = 0.0
    for label, charts in BOUNDS.items():
        atlas, seconds = unwrap_timed(V, F, charts, method)
        unit = unit or seconds
        seams, energy = relative_seams(V, F, atlas.FTC), 4 * atlas.quality.symmetric_dirichlet
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
    for mesh in models():
        for method in ("isometric", "linabf"):
            print_rows(mesh, method)


if __name__ == "__main__":
    main()
