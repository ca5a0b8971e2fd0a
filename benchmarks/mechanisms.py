"""Compare atlases with and without each mechanism of the charts.

    python benchmarks/mechanisms.py [MECHANISM ...]

The models are the parts of parts.py, three generated surfaces, and the meshes of the kinds closed, handles,
holes, multi and stress in IGL_LINABF_MESHES. Each is unwrapped in three ways: by linear ABF, by isometric
maps, and by isometric maps for a page of 1024 texels. A mechanism is switched off by replacing a function or
a constant. The figures are measured on the arrays of the atlas, independently of the package. The output is
Markdown.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import igl
import numpy as np
from generated import generate_mesh
from meshes import Mesh, load_shared_meshes
from parts import parts
from peers import relative_seams

from igl_linabf import Packing, unwrap
from igl_linabf.charts import charting, unwrapping
from igl_linabf.charts.cut_graphs import clusters
from igl_linabf.charts.panels import Panels, RoundedPanels
from igl_linabf.charts.seams import search

PAGE = Packing(resolution=1024, padding=2)
WAYS = (("linabf", None), ("isometric", None), ("isometric", PAGE))
GENERATED = (("box", 64, 0.03, 1), ("blob", 64, 0.03, 2), ("blob", 48, 0.05, 3))
Replacement = tuple[Any, str, Any]  # (module or class, name, replacement)


def no_panels(panels: Panels) -> np.ndarray:
    return np.zeros(len(panels.creased.component_extent), dtype=bool)


MECHANISMS: dict[str, list[Replacement]] = {
    "nothing": [],
    "panels, also rounded ones": [
        (Panels, "mask_panel_components", no_panels),
        (RoundedPanels, "mask_panel_components", no_panels),
    ],
    "rounded panels": [(RoundedPanels, "mask_panel_components", no_panels)],
    "maps that compare panels with a tree": [(search.SeamSearch, "_measure_cost", lambda *_: -np.inf)],
    "a tree beside panels": [(search, "CHEAP_PANELS", 1e9)],
    "clusters": [(clusters, "MAX_CLUSTERS", 10**9)],
    "batches of small bodies": [(search, "MIN_SMALL_BODIES", 10**9), (search, "MIN_MEDIUM_BODIES", 10**9)],
    "pieces flattened together": [
        (charting, "MIN_PIECES_TOGETHER", 10**9),
        (charting, "MAX_FACES_TOGETHER", 0),
    ],
    "seams for even texels": [(charting, "MAX_EVEN_ROUNDS", 0)],
    "seams for measured stretch": [(charting, "MIN_SOUGHT_SEAM_LENGTH", 1e9)],
    "seams to tips": [(charting, "TIP_STRETCH", 1e9)],
    "uncut charts": [(charting, "_undo_costly_cuts", lambda done, *_: done)],
    "least seams between overlaps": [
        (charting, "split_overlaps", lambda piece, _: charting.bisect_piece(piece))
    ],
    "small charts": [(charting, "merge_small_charts", lambda done, *_: done)],
    "cuts for fuller pages": [(unwrapping, "cut_for_fill", lambda done, *_: (done, np.inf))],
}


class Figures(NamedTuple):
    """The figures of one atlas."""

    charts: int
    seams: float
    stretch: float
    spread: float
    fill: float
    cost: float
    seconds: float
    flips: int
    overlaps: int


def models() -> Iterator[Mesh]:
    yield from parts([])
    for kind, n, noise, seed in GENERATED:
        yield f"generated {kind} {seed}", *generate_mesh(kind, n, noise, seed)
    yield from load_shared_meshes("closed", "handles", "holes", "multi", "stress")


def figures(V: np.ndarray, F: np.ndarray, method: str, packing: Packing | None) -> Figures:
    start = time.process_time()
    atlas = unwrap(V, F, method=method, packing=packing, progress=False)
    seconds = time.process_time() - start
    TC, FTC = atlas.TC, atlas.FTC
    area, flat = igl.doublearea(V, F), igl.doublearea(TC, FTC)
    used = area > 1e-12 * area.max()
    weight = area[used] / area[used].sum()
    stretch = squared_stretch(V[F[used]], TC[FTC[used]])
    scale = flat[used] / area[used]
    order = np.argsort(scale)
    low, high = np.searchsorted(np.cumsum(weight[order]), (0.01, 0.99))
    ratio = scale[order[min(high, len(order) - 1)]] / scale[order[low]]
    return Figures(
        len(atlas.charts),
        relative_seams(V, F, FTC),
        float(np.sqrt(weight @ stretch * (weight @ scale))),
        float(ratio),
        atlas.fill,
        atlas.cost.total,
        seconds,
        int((flat[used] <= 0).sum()),
        sum(chart.overlapping for chart in atlas.charts),
    )


def squared_stretch(corners: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Return the squared L2 stretch of each triangle, from its corners on the surface and in the map."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    u, v = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    double_area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    # the two columns of the Jacobian of the inverse map, from the plane to the surface
    along_x = (a * v[:, 1:] - b * u[:, 1:]) / double_area[:, None]
    along_y = (b * u[:, :1] - a * v[:, :1]) / double_area[:, None]
    return ((along_x**2).sum(axis=1) + (along_y**2).sum(axis=1)) / 2


@contextmanager
def replace_temporarily(replacements: list[Replacement]) -> Iterator[None]:
    """Replace functions and constants temporarily."""
    kept = [(owner, name, getattr(owner, name)) for owner, name, _ in replacements]
    try:
        for owner, name, value in replacements:
            setattr(owner, name, value)
        yield
    finally:
        for owner, name, value in reversed(kept):
            setattr(owner, name, value)


def atlases(meshes: list[Mesh], name: str) -> list[list[Figures]]:
    """Return the figures of the atlases of all meshes without a mechanism, for each way of unwrapping."""
    with replace_temporarily(MECHANISMS[name]):
        return [[figures(V, F, method, packing) for _, V, F in meshes] for method, packing in WAYS]


def row(name: str, way: str, on: list[Figures], off: list[Figures]) -> str:
    """Return a table row: totals of charts and medians of other figures, with / without a mechanism."""
    with_it, without = (np.array(side, dtype=float) for side in (on, off))

    def ratio(k: int) -> float:
        return float(np.exp(np.median(np.log(without[:, k] / with_it[:, k]))))

    known = (with_it[:, 1] > 0) & (without[:, 1] > 0)
    longer = float(np.exp(np.median(np.log(without[known, 1] / with_it[known, 1]))))
    medians = [
        f"{a:.3f} / {b:.3f}" for a, b in zip(np.median(with_it, 0), np.median(without, 0), strict=True)
    ]
    cells = [
        name,
        way,
        f"{with_it[:, 0].sum():.0f} / {without[:, 0].sum():.0f}",
        f"x {longer:.3f}",
        medians[2],
    ]
    cells += [f"x {(without[:, 2] / with_it[:, 2]).max():.2f}", f"x {ratio(3):.2f}", medians[4], medians[5]]
    cells += [f"x {ratio(6):.2f}", f"{without[:, 7].sum():.0f}, {without[:, 8].sum():.0f}"]
    return f"| {' | '.join(cells)} |"


HEADS = (
    "switched off",
    "way",
    "charts",
    "seams",
    "median L2",
    "worst L2",
    "texel spread",
    "fill",
    "E",
    "time",
    "flips, overlaps",
)


def main() -> None:
    warnings.simplefilter("ignore")
    names = sys.argv[1:] or [name for name in MECHANISMS if name != "nothing"]
    meshes = list(models())
    on = atlases(meshes, "nothing")
    print(
        "Charts are totals over all models, and E, fill and L2 stretch are medians: with all mechanisms /\n"
        "without the mechanism of the row. Seams, texel spread and CPU time are medians of the ratios of\n"
        "the figure without the mechanism to the figure with it. The worst L2 is the largest such ratio\n"
        "of the L2 stretch. The ways are conformal maps, isometric maps, and isometric maps for a page of\n"
        "1024 texels.\n"
    )
    print(f"| {' | '.join(HEADS)} |\n|{'---|' * len(HEADS)}")
    for name in names:
        off = atlases(meshes, name)
        for way, a, b in zip(("conformal", "isometric", "page"), on, off, strict=True):
            print(row(name, way, a, b), flush=True)


if __name__ == "__main__":
    main()
