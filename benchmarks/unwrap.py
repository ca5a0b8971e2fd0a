"""Compare atlases with the atlases of other programs: distortion, seams, packing and time.

    python benchmarks/unwrap.py [--all]

The meshes are the bunny, a cortex, and the meshes of kinds closed, handles and multi in IGL_LINABF_MESHES;
with --all, the meshes of all valid kinds. xatlas and uvunwrap (extra `peers`) are included if they are
installed. Smart UV Project of Blender is included if bpy is installed, here or in the Python named by
BPY_PYTHON. igl.lscm flattens the charts of `unwrap`. Prints Markdown.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from time import perf_counter

import igl
import numpy as np
from meshes import load_shared_meshes, stanford
from peers import PADDING, RESOLUTION, TexelAtlas, make_charts, programs, relative_seams

from igl_linabf import OutcomeWarning, flatten, quality
from igl_linabf.surface import drop_unused_vertices
from igl_linabf.textures import find_covered_texels, find_texels_near_sides

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from carried import pial

KINDS = ("closed", "handles", "multi")
ALL_KINDS = (*KINDS, "holes", "disk", "stress", "flat2d")
HEADS = "charts | seams | F/3nt | L2 stretch | spread | flips | fill | touching | s"
FORMATS = (".0f", ".1f", ".3g", ".3f", ".1f", ".0f", ".2f", ".0f", ".2f")


def count_touching(TC: np.ndarray, FTC: np.ndarray, chart: np.ndarray) -> int:
    """Return the number of charts that share a texel of a bilinear lookup with another chart."""
    texels = TC[FTC] - 0.5
    size = (RESOLUTION, RESOLUTION)
    inner = find_covered_texels(texels, size)
    n = len(TC)
    tail, head = FTC, np.roll(FTC, -1, axis=1)
    face, k = np.nonzero(~np.isin(tail * n + head, head * n + tail, kind="sort"))
    near = find_texels_near_sides(texels[face, k], texels[face, (k + 1) % 3], size)
    index = np.concatenate((inner.index, near.index))
    of = np.concatenate((chart[inner.face], chart[face[near.side]]))
    pairs = np.unique(np.column_stack((index, of)), axis=0)
    several = np.isin(pairs[:, 0], pairs[1:, 0][np.diff(pairs[:, 0]) == 0])
    return len(np.unique(pairs[several, 1]))


def signed_double_areas(TC: np.ndarray, FTC: np.ndarray) -> np.ndarray:
    """Return twice the signed areas of the faces in the map."""
    a, b = TC[FTC[:, 1]] - TC[FTC[:, 0]], TC[FTC[:, 2]] - TC[FTC[:, 0]]
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def measure_atlas(V: np.ndarray, F: np.ndarray, atlas: TexelAtlas) -> list[float]:
    """Return the figures of one atlas, in the order of `HEADS`."""
    areas = signed_double_areas(atlas.TC, atlas.FTC)
    keep = np.abs(areas) > 0  # drop faces that a program omits, and faces without area
    chart = make_charts(atlas.FTC[keep])
    mirrored = np.bincount(chart, areas[keep]) < 0  # xatlas mirrors some charts
    flips = np.count_nonzero((areas[keep] > 0) == mirrored[chart])
    q = quality(V[atlas.origin], atlas.FTC[keep & (igl.doublearea(V, F) > 0)], atlas.TC)
    fill = np.abs(areas).sum() / 2 / atlas.page
    touch = count_touching(atlas.TC, atlas.FTC[keep], chart)
    seams = relative_seams(V, F, atlas.FTC)
    values = [len(mirrored), seams, q.angle_distortion, q.stretch_l2, q.texel_spread, flips]
    return [*values, fill, touch, atlas.seconds]


def flatten_charts_with_lscm(V: np.ndarray, F: np.ndarray, atlas: TexelAtlas) -> list[float]:
    """Return the figures of igl.lscm on the separate charts of an atlas, averaged over the triangles."""
    start = perf_counter()
    chart, of_charts = make_charts(atlas.FTC), []
    for i in range(chart.max() + 1):
        used, own = drop_unused_vertices(atlas.FTC[chart == i], len(atlas.TC))
        points = V[atlas.origin[used]]
        q = quality(points, own, flatten(points, own, method="lscm").uv)
        of_charts.append((len(own), q.angle_distortion, q.flips))
    triangles, distortion, flips = np.array(of_charts).T
    seams, unknown = relative_seams(V, F, atlas.FTC), float("nan")
    seconds = perf_counter() - start
    mean = triangles @ distortion / triangles.sum()
    return [len(of_charts), seams, mean, unknown, unknown, flips.sum(), unknown, unknown, seconds]


def format_row(name: str, program: str, values: list[float]) -> str:
    cells = [
        "" if np.isnan(value) else f"{value:{form}}" for value, form in zip(values, FORMATS, strict=True)
    ]
    return f"| {name} | {program} | {' | '.join(cells)} |"


def main() -> None:
    warnings.simplefilter("ignore", OutcomeWarning)
    print(
        f"The pages have {RESOLUTION} x {RESOLUTION} texels, with {PADDING} texels of padding. The column\n"
        "seams is the length of the seams divided by the square root of the area. Spread is the ratio of\n"
        "the 99th to the 1st percentile of the texel areas. Fill is the covered share of the page; pages\n"
        "of xatlas and uvunwrap need not be square. Touching is the number of charts that share a texel\n"
        "of a bilinear lookup with another chart, and s is the time in seconds. The rows of igl.lscm\n"
        "flatten each chart of unwrap without packing. In contrast, unwrap keeps the map of a chart that\n"
        "is cut only to fill the page better.\n"
    )
    print(f"| mesh | by | {HEADS} |\n|{'---|' * (HEADS.count('|') + 3)}")
    tables: dict[str, list[list[float]]] = {}
    for name, V, F in [
        stanford(),
        ("pial", *pial()),
        *load_shared_meshes(*(ALL_KINDS if "--all" in sys.argv else KINDS)),
    ]:
        for program, run in programs().items():
            try:
                atlas = run(V, F)
                found = {program: measure_atlas(V, F, atlas)}
                if program == "unwrap, linabf":
                    found["igl.lscm"] = flatten_charts_with_lscm(V, F, atlas)
            except Exception as error:  # an error of any program becomes a row of the table
                print(f"| {name} | {program} | {type(error).__name__} |{' |' * HEADS.count('|')}", flush=True)
                print(name, program, error, file=sys.stderr)
                continue
            for of, values in found.items():
                tables.setdefault(of, []).append(values)
                print(format_row(name, of, values), flush=True)
    for program, values in tables.items():
        print(format_row(f"median of {len(values)}", program, np.median(values, axis=0).tolist()))


if __name__ == "__main__":
    main()
