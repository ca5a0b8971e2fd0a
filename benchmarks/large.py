"""Measure isometric atlases and maps of up to a million triangles: time, memory, cost of floaters.

    python benchmarks/large.py

The first table has one generated shape at increasing resolutions, and a million triangles with finer bumps.
Each mesh runs in a separate process on all cores. The second table compares `isometric` and `linabf` on bumpy
disks, with alternating runs in one process. The last table shows how many texels floaters take from the other
charts. Prints Markdown.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import warnings
from statistics import median
from time import perf_counter

import igl
import numpy as np
from generated import NOISES, SIZES, generate_mesh, measure_peak_memory
from scipy.ndimage import zoom

from igl_linabf import flatten, quality, unwrap
from igl_linabf.uv import pack

BUMP_POINTS = SIZES["50k"]  # grid points along an axis of the shape with bumps, before it is resampled
SAMPLED, FINEST = (96, 144, 200, 282, 396), 312  # grid points along an axis
DISKS, REPEAT = (20_000, 100_000, 500_000), 3
FLOATER = 1e-3  # components with a smaller share of the area are floaters


def measure_atlas(path: str) -> dict[str, float]:
    """Return charts, stretch, texels, seconds and MB of an isometric atlas of the mesh in a file."""
    mesh = np.load(path)
    unwrap(*igl.icosahedron(), method="isometric")  # warm-up, which includes lazy imports
    start = perf_counter()
    atlas = unwrap(mesh["V"], mesh["F"], method="isometric", progress=False)
    seconds = perf_counter() - start
    peak = measure_peak_memory()
    q = atlas.quality
    return {
        "charts": len(atlas.charts),
        "stretch": q.stretch_l2,
        "texels": q.texel_spread,
        "s": seconds,
        "MB": peak,
    }


def print_sampled() -> None:
    """Print the table of one shape at increasing resolutions, and of the finest bumps."""
    heads = ("mesh", "triangles", "charts", "L2 stretch", "texels 99 : 1 %", "s", "MB")
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    triangles, seconds = [], []
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "mesh.npz")
        for n, bump_points in [*((n, BUMP_POINTS) for n in SAMPLED), (FINEST, None)]:
            V, F = generate_mesh("blob", n, NOISES[0], 1, bump_points)
            np.savez(path, V=V, F=F)
            command = [sys.executable, __file__, "--one", path]
            done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True)
            row = json.loads(done.stdout.splitlines()[-1])
            name = "finer bumps" if bump_points is None else "one shape"
            figures = f"{row['stretch']:.3f} | {row['texels']:.2f} | {row['s']:.1f} | {row['MB']:,.0f}"
            print(f"| {name} | {len(F):,} | {row['charts']} | {figures} |", flush=True)
            if bump_points is not None:
                triangles.append(len(F))
                seconds.append(row["s"])
    exponent = np.polyfit(np.log(triangles), np.log(seconds), 1)[0]
    print(
        f"\nFor the shape at several resolutions, the time grows like the number of triangles to the power "
        f"{exponent:.2f}."
    )


def bumpy_disk(triangles: int) -> tuple[np.ndarray, np.ndarray]:
    """Return V and F of a square with hills that do not depend on the number of triangles."""
    n = round(np.sqrt(triangles / 2)) + 1
    hills = np.random.default_rng(1).standard_normal((12, 12))
    x, y = (axis.ravel() for axis in np.meshgrid(*[np.linspace(0, 1, n)] * 2, indexing="ij"))
    height = 0.06 * zoom(hills, n / len(hills), order=3)[:n, :n].ravel()
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    F = np.concatenate((np.column_stack((a, a + n, a + n + 1)), np.column_stack((a, a + n + 1, a + 1))))
    return np.column_stack((x, y, height)), F


def print_disks() -> None:
    """Print the table of disks: time of the isometric map relative to the time of `linabf`."""
    print("\n| disk of triangles | isometric / linabf | L2 stretch, isometric | linabf |\n|---|---|---|---|")
    for triangles in DISKS:
        V, F = bumpy_disk(triangles)
        ratios = []
        for _ in range(REPEAT):
            start = perf_counter()
            conformal = flatten(V, F)
            middle = perf_counter()
            isometric = flatten(V, F, method="isometric")
            ratios.append((perf_counter() - middle) / (middle - start))
        stretch = [quality(V, F, result.uv).stretch_l2 for result in (isometric, conformal)]
        print(f"| {len(F):,} | {median(ratios):.1f} | {stretch[0]:.3f} | {stretch[1]:.3f} |", flush=True)


def print_floaters() -> None:
    """Print the table of pages: ratio of the texel densities with and without floaters."""
    print("\n| mesh | charts | of floaters | texels per length, with / without them |\n|---|---|---|---|")
    for kind, noise in (("blob", NOISES[1]), ("box", NOISES[1])):
        V, F = generate_mesh(kind, SIZES["150k"], noise, 1)
        atlas = unwrap(V, F, method="isometric", progress=False)
        label = igl.vertex_components(F)[F[:, 0]]
        area = igl.doublearea(V, F)
        large = (np.bincount(label, area) > FLOATER * area.sum())[label]
        without_floaters = pack(V, F[large], atlas.TC, atlas.FTC[large])
        with_floaters = pack(V, F, atlas.TC, atlas.FTC)
        floater_charts = len(with_floaters.page) - len(without_floaters.page)
        ratio = with_floaters.scale / without_floaters.scale
        figures = f"{len(with_floaters.page)} | {floater_charts} | {ratio:.3f}"
        print(f"| {kind}, {noise} | {figures} |", flush=True)


def main() -> None:
    warnings.simplefilter("ignore")
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measure_atlas(sys.argv[2])))
        return
    print_sampled()
    print_disks()
    print_floaters()


if __name__ == "__main__":
    main()
