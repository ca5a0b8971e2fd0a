"""Isometric atlases and maps of up to a million triangles: time over size, memory, and what floaters cost.

    python benchmarks/large.py

First one generated shape, sampled ever finer, and a million triangles whose bumps get finer with the grid:
each in a process of its own, with all cores. Then bumpy disks, by `isometric` and by `linabf` in turn, in one
process. Last, the texels that floaters take from the other charts. Prints Markdown.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path
from statistics import median
from time import perf_counter

import igl
import numpy as np
from generated import NOISES, SIZES, generated
from scipy.ndimage import zoom

from igl_linabf import flatten, pack, quality, unwrap

SHAPE = SIZES["50k"]  # points of the grid whose bumps the sampled shape has
SAMPLED, FINEST = (96, 144, 200, 282, 396), 312  # points of the grid along an axis
DISKS, REPEAT = (20_000, 100_000, 500_000), 3
FLOATER = 1e-3  # of the whole area: smaller components are floaters


def measured(path: str) -> dict[str, float]:
    """An isometric atlas of the mesh in a file: charts, stretch, texels, seconds, MB."""
    mesh = np.load(path)
    unwrap(*igl.icosahedron(), method="isometric")  # imports
    start = perf_counter()
    atlas = unwrap(mesh["V"], mesh["F"], method="isometric", progress=False)
    seconds = perf_counter() - start
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    most = int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1024
    q = atlas.quality
    return {
        "charts": len(atlas.charts),
        "stretch": q.stretch_l2,
        "texels": q.texel_spread,
        "s": seconds,
        "MB": most,
    }


def sampled() -> None:
    """The table of one shape, sampled ever finer, and of the finest bumps."""
    heads = ("mesh", "triangles", "charts", "L2 stretch", "texels 99 : 1 %", "s", "MB")
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    triangles, seconds = [], []
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "mesh.npz")
        for n, shape in [*((n, SHAPE) for n in SAMPLED), (FINEST, None)]:
            V, F = generated("blob", n, NOISES[0], 1, shape)
            np.savez(path, V=V, F=F)
            command = [sys.executable, __file__, "--one", path]
            done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True)
            row = json.loads(done.stdout.splitlines()[-1])
            name = "finer bumps" if shape is None else "one shape"
            figures = f"{row['stretch']:.3f} | {row['texels']:.2f} | {row['s']:.1f} | {row['MB']:,.0f}"
            print(f"| {name} | {len(F):,} | {row['charts']} | {figures} |", flush=True)
            if shape is not None:
                triangles.append(len(F))
                seconds.append(row["s"])
    exponent = np.polyfit(np.log(triangles), np.log(seconds), 1)[0]
    print(f"\nExponent of the time over the triangles of the one shape: {exponent:.2f}.")


def bumpy_disk(triangles: int) -> tuple[np.ndarray, np.ndarray]:
    """V and F of a square with hills, the same ones at any number of triangles."""
    n = round(np.sqrt(triangles / 2)) + 1
    hills = np.random.default_rng(1).standard_normal((12, 12))
    x, y = (axis.ravel() for axis in np.meshgrid(*[np.linspace(0, 1, n)] * 2, indexing="ij"))
    height = 0.06 * zoom(hills, n / len(hills), order=3)[:n, :n].ravel()
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    F = np.concatenate((np.column_stack((a, a + n, a + n + 1)), np.column_stack((a, a + n + 1, a + 1))))
    return np.column_stack((x, y, height)), F


def disks() -> None:
    """The table of disks: seconds of the isometric map over those of `linabf`."""
    print("\n| disk of triangles | isometric / linabf | L2 stretch, isometric | linabf |\n|---|---|---|---|")
    for number in DISKS:
        V, F = bumpy_disk(number)
        ratios = []
        for _ in range(REPEAT):
            start = perf_counter()
            conformal = flatten(V, F)
            between = perf_counter()
            isometric = flatten(V, F, method="isometric")
            ratios.append((perf_counter() - between) / (between - start))
        stretch = [quality(V, F, result.uv).stretch_l2 for result in (isometric, conformal)]
        print(f"| {len(F):,} | {median(ratios):.1f} | {stretch[0]:.3f} | {stretch[1]:.3f} |", flush=True)


def floaters() -> None:
    """The table of pages: texels per unit of length with the floaters' charts over those without."""
    print("\n| mesh | charts | of floaters | texels per length, with / without them |\n|---|---|---|---|")
    for kind, noise in (("blob", NOISES[1]), ("box", NOISES[1])):
        V, F = generated(kind, SIZES["150k"], noise, 1)
        atlas = unwrap(V, F, method="isometric", progress=False)
        label = igl.vertex_components(F)[F[:, 0]]
        area = igl.doublearea(V, F)
        large = (np.bincount(label, area) > FLOATER * area.sum())[label]
        few = pack(V, F[large], atlas.TC, atlas.FTC[large])
        every = pack(V, F, atlas.TC, atlas.FTC)
        number = len(every.page) - len(few.page)
        figures = f"{len(every.page)} | {number} | {every.scale / few.scale:.3f}"
        print(f"| {kind}, {noise} | {figures} |", flush=True)


def main() -> None:
    warnings.simplefilter("ignore")
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measured(sys.argv[2])))
        return
    sampled()
    disks()
    floaters()


if __name__ == "__main__":
    main()
