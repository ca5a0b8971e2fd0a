"""Atlases for textures: stretch, texels and seams of the isometric method, beside uvunwrap and xatlas.

    python benchmarks/isometric.py

The meshes are the bunny, a cortex, nut and ant of pyvista's wheel, and those of the kinds closed, handles,
holes and multi in IGL_LINABF_MESHES. Peers are added if they are installed. The last table has the cortex by
both methods. Prints Markdown.
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
from meshes import shared, stanford
from peers import Maker, charts_of, ours, programs, relative_seams

from igl_linabf import MeshWarning, OutcomeWarning, Seams, flatten, overlaps, quality

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from carried import of_pyvista, pial

HEADS = ("charts", "seam / sqrt(area)", "L2 stretch", "texels 99 : 1 %", "overlaps, flips", "s")


def makers() -> Mapping[str, Maker]:
    """`unwrap` by its methods, no chart cut to fill a page; and the installed peers but Blender."""
    mine: dict[str, Maker] = {
        "linabf": partial(ours, resolution=None),
        "isometric": partial(ours, method="isometric", resolution=None),
        "isometric, trade 30": partial(ours, method="isometric", seams=Seams(trade=30.0), resolution=None),
    }
    return mine | {name: make for name, make in programs().items() if name in ("xatlas", "uvunwrap")}


def measured(V: np.ndarray, F: np.ndarray, make: Maker) -> list[float]:
    """The figures of one atlas, as `HEADS` has them; overlaps and flips added."""
    made = make(V, F)
    chart = charts_of(made.FTC)
    areas = igl.doublearea(made.TC, made.FTC)
    mirrored = np.bincount(chart, areas) < 0  # xatlas turns some charts over
    flips = np.count_nonzero((areas > 0) == mirrored[chart])
    q = quality(V[made.origin], made.FTC, made.TC)
    wrong = len(overlaps(made.TC, made.FTC)) + flips
    seam = relative_seams(V, F, made.FTC)
    return [len(mirrored), seam, q.stretch_l2, q.texel_spread, wrong, made.seconds]


def line(name: str, triangles: str, of: str, values: list[float]) -> str:
    charts, seam, stretch, texels, wrong, seconds = values
    figures = f"{charts:.0f} | {seam:.2f} | {stretch:.3f} | {texels:.2f} | {wrong:.0f} | {seconds:.1f}"
    return f"| {name} | {triangles} | {of} | {figures} |"


def cortex() -> None:
    """The cortex by both methods beside the flat map that ships with it."""
    from cortex import cortex

    V, F, shipped = cortex()
    print("\n| cortex | area distortion | change of edges, mean | 99 % | F/3nt | L2 stretch | flips | s |")
    print(f"|{'---|' * 8}")
    for name in ("shipped", "linabf", "isometric"):
        start = perf_counter()
        uv = shipped if name == "shipped" else flatten(V, F, name).uv
        seconds = "" if name == "shipped" else f"{perf_counter() - start:.1f}"
        q = quality(V, F, uv)
        print(
            f"| {name} | {q.area_distortion:.3f} | {q.edge_change:.1%} | {q.edge_change_99:.1%} | "
            f"{q.angle_distortion:.3g} | {q.stretch_l2:.3f} | {q.flips} | {seconds} |"
        )


def main() -> None:
    warnings.simplefilter("ignore", OutcomeWarning)
    warnings.simplefilter("ignore", MeshWarning)
    print(f"| mesh | triangles | atlas | {' | '.join(HEADS)} |\n|{'---|' * (3 + len(HEADS))}")
    rows: dict[str, list[list[float]]] = {}
    carried = [("pial", *pial()), *((name, *of_pyvista(name)) for name in ("nut", "ant"))]
    for name, V, F in [stanford(), *carried, *shared("closed", "handles", "holes", "multi")]:
        if len(F) < 100:
            continue
        for of, make in makers().items():
            values = measured(V, F, make)
            rows.setdefault(of, []).append(values)
            print(line(name, f"{len(F):,}", of, values), flush=True)
    for of, values in rows.items():
        print(line("median", "", of, [median(column) for column in zip(*values, strict=True)]))
    cortex()


if __name__ == "__main__":
    main()
