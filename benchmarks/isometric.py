"""Compare atlases of the isometric method, uvunwrap and xatlas: stretch, texels and seams.

    python benchmarks/isometric.py

The meshes are the bunny, a cortex, nut and ant of the pyvista package, and the meshes of kinds closed,
handles, holes and multi in IGL_LINABF_MESHES. The other programs are included if they are installed. The last
table compares two maps of the cortex with the map of FreeSurfer. Prints Markdown.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter

import igl
import numpy as np
from meshes import load_shared_meshes, stanford
from peers import Maker, make_charts, ours, programs, relative_seams

from igl_linabf import ChartOptions, MeshWarning, OutcomeWarning, flatten, overlaps, quality

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from carried import load_pyvista_mesh, pial

HEADS = ("charts", "seam / sqrt(area)", "L2 stretch", "texels 99 : 1 %", "overlaps, flips", "s")


def list_makers() -> Mapping[str, Maker]:
    """Return functions that make atlases: the methods of `unwrap`, and the installed programs."""
    mine: dict[str, Maker] = {
        "linabf": partial(ours, method="linabf", resolution=None),
        "isometric": partial(ours, method="isometric", resolution=None),
        "isometric, trade 30": partial(
            ours, method="isometric", charts=ChartOptions(trade=30.0), resolution=None
        ),
    }
    return mine | {name: make for name, make in programs().items() if name in ("xatlas", "uvunwrap")}


def measure_atlas(V: np.ndarray, F: np.ndarray, make: Maker) -> list[float]:
    """Return the figures of one atlas in the order of `HEADS`; flips are added to the overlaps."""
    atlas = make(V, F)
    chart = make_charts(atlas.FTC)
    areas = igl.doublearea(atlas.TC, atlas.FTC)
    mirrored = np.bincount(chart, areas) < 0  # xatlas mirrors some charts
    flips = np.count_nonzero((areas > 0) == mirrored[chart])
    q = quality(V[atlas.origin], atlas.FTC, atlas.TC)
    defects = len(overlaps(atlas.TC, atlas.FTC)) + flips
    seam = relative_seams(V, F, atlas.FTC)
    return [len(mirrored), seam, q.stretch_l2, q.texel_spread, defects, atlas.seconds]


def format_line(name: str, triangles: str, program: str, values: list[float]) -> str:
    charts, seam, stretch, texels, defects, seconds = values
    figures = f"{charts:.0f} | {seam:.2f} | {stretch:.3f} | {texels:.2f} | {defects:.0f} | {seconds:.1f}"
    return f"| {name} | {triangles} | {program} | {figures} |"


def print_cortex() -> None:
    """Print the table of the cortex: both methods, and the map that is distributed with the surface."""
    from cortex import cortex

    V, F, shipped = cortex()
    print("\n| cortex | area distortion | change of edges, mean | 99 % | F/3nt | L2 stretch | flips | s |")
    print(f"|{'---|' * 8}")
    for name in ("shipped", "linabf", "isometric"):
        start = perf_counter()
        uv = shipped if name == "shipped" else flatten(V, F, method=name).uv
        seconds = "" if name == "shipped" else f"{perf_counter() - start:.1f}"
        q = quality(V, F, uv)
        print(
            f"| {name} | {q.area_distortion:.3f} | {q.edge_change:.1%} | {q.report.edge_change_99:.1%} | "
            f"{q.angle_distortion:.3g} | {q.stretch_l2:.3f} | {q.flips} | {seconds} |"
        )


def main() -> None:
    warnings.simplefilter("ignore", OutcomeWarning)
    warnings.simplefilter("ignore", MeshWarning)
    print(f"| mesh | triangles | atlas | {' | '.join(HEADS)} |\n|{'---|' * (3 + len(HEADS))}")
    rows: dict[str, list[list[float]]] = {}
    carried = [("pial", *pial()), *((name, *load_pyvista_mesh(name)) for name in ("nut", "ant"))]
    for name, V, F in [stanford(), *carried, *load_shared_meshes("closed", "handles", "holes", "multi")]:
        if len(F) < 100:
            continue
        for program, make in list_makers().items():
            values = measure_atlas(V, F, make)
            rows.setdefault(program, []).append(values)
            print(format_line(name, f"{len(F):,}", program, values), flush=True)
    for program, values in rows.items():
        print(format_line("median", "", program, [median(column) for column in zip(*values, strict=True)]))
    print_cortex()


if __name__ == "__main__":
    main()
