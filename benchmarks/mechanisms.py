"""What each mechanism of charts is for: atlases with it, and with it turned off.

    python benchmarks/mechanisms.py [MECHANISM ...]

The models are the parts of parts.py, a limb, the bunny, a generated box of 60,000 triangles, and meshes in
IGL_LINABF_MESHES, one of them stretched 20 : 1 as well, each unwrapped with the methods "linabf" and
"isometric". A mechanism is turned off by another function in its place. Prints Markdown.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from generated import generated
from meshes import Mesh, shared, stanford
from parts import parts
from peers import relative_seams

from igl_linabf import unwrap
from igl_linabf.charts import charting
from igl_linabf.charts.seams import growth, search

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from carried import limb

METHODS = ("linabf", "isometric")
SHARED = (
    "igl_cow",
    "optcuts_horse_f10000",
    "optcuts_torus_with_hole",
    "igl_beetle",
    "bff_teapot",
    "flipfree_deer",
    "optcuts_dragon_i_f10000",
    "optcuts_male_body_i_f10000",
    "optcuts_duck1",
)
Patch = tuple[Any, str, Callable[..., Any]]  # a module or class, a name in it, and what stands there instead
_NONE = np.zeros(0, dtype=np.int64)
MECHANISMS: dict[str, Patch] = {
    "panels, rounded ones too": (search, "_of_panels", lambda creased, *_: ([], creased)),
    "rounded panels": (
        search.RoundedPanels,
        "made",
        lambda panels, trade: np.zeros(len(panels.creased.extent), dtype=bool),
    ),
    "nets": (
        search,
        "Nets",
        type("NoNets", (search.Nets,), {"settled": lambda *_: None, "cheaper": lambda *_: None}),
    ),
    "crease cuts of isometric maps": (charting, "split_at_creases", lambda *_: []),
    "small charts": (charting, "merge_small_charts", lambda made, *_: made),
    "tips of maps": (charting, "seams_to_tips", lambda *_: np.zeros((0, 2), dtype=np.int64)),
    "walks between overlaps": (charting, "split_overlaps", lambda *_: []),
    "predicted overlaps and tips": (search, "predicted_seams", lambda *_: (_NONE, _NONE)),
    "faces laid out narrower": (charting, "relayout_locally", lambda piece, made, pairs: (made, pairs)),
    "reused maps": (charting, "reuse_maps", lambda piece, made, parts, *_: [None] * len(parts)),
    "slides into valleys": (search, "slide_into_valleys", lambda closed, seam, *_: seam),
    "moved branch points": (growth, "move_branch_points", lambda graph, seam, cost: seam),
}


class Figures(NamedTuple):
    """The figures of one atlas."""

    charts: int
    seams: float
    stretch: float
    fill: float
    cost: float


def models() -> Iterator[Mesh]:
    yield from parts([])
    yield "limb", *limb()
    yield stanford()
    yield "generated box", *generated("box", 96, 0.03, 1)
    for name, V, F in shared("closed", "handles", "holes", "multi", "stress"):
        if name in SHARED:
            yield name, V, F
        if name == "optcuts_male_body_i_f10000":
            yield "male body, stretched", V * [1, 20, 1], F


def figures(V: np.ndarray, F: np.ndarray, method: str) -> Figures:
    atlas = unwrap(V, F, method=method, progress=False)
    seams, stretch = relative_seams(V, F, atlas.FTC), atlas.quality.stretch_l2
    return Figures(len(atlas.charts), seams, stretch, atlas.fill, atlas.cost.total)


def without(patch: Patch, meshes: list[Mesh]) -> list[Figures]:
    """The figures of all atlases with the mechanism turned off."""
    owner, name, instead = patch
    kept = getattr(owner, name)
    setattr(owner, name, instead)
    try:
        return [figures(V, F, method) for _, V, F in meshes for method in METHODS]
    finally:
        setattr(owner, name, kept)


def row(name: str, with_it: list[Figures], off: list[Figures]) -> str:
    """What changes: charts in all, and the means of the other figures."""
    pairs = [(a, b) for a, b in zip(with_it, off, strict=True) if not np.allclose(a, b, rtol=1e-3, atol=0)]
    cells = [name, f"{len(pairs)} of {len(off)}"]
    if not pairs:
        return f"| {' | '.join(cells + ['-'] * len(Figures._fields))} |"
    one, other = (np.array(side, dtype=float) for side in zip(*pairs, strict=True))
    cells.append(f"{one[:, 0].sum():.0f} / {other[:, 0].sum():.0f}")
    cells += [f"{a:.3f} / {b:.3f}" for a, b in zip(one.mean(0)[1:], other.mean(0)[1:], strict=True)]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    warnings.simplefilter("ignore")
    names = sys.argv[1:] or list(MECHANISMS)
    meshes = list(models())
    with_it = [figures(V, F, method) for _, V, F in meshes for method in METHODS]
    print(
        "Each row: the atlases that change by more than a thousandth if this mechanism is turned off;\n"
        "their charts in all, and the means of seams over the square root of the area, L2 stretch, fill\n"
        "and cost E, each with the mechanism / without it.\n"
    )
    heads = ["mechanism", "atlases that change", "charts", "seams", "L2 stretch", "fill", "E"]
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for name in names:
        print(row(name, with_it, without(MECHANISMS[name], meshes)), flush=True)


if __name__ == "__main__":
    main()
