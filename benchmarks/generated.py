"""Atlases of meshes like those of generative models and scanners, beside xatlas, uvunwrap and Blender.

    python benchmarks/generated.py [--size 50k] [--seed 1] [--picture docs/images/generated.png]

The meshes come by marching cubes from distance fields with noise: limbs or boxes, with bumps of two sizes,
and a dozen floaters and cavities. `--size` takes only those of about 50,000, 150,000 or 320,000 triangles.
Each atlas is made in a process of its own, with one thread; MB is the peak of that process. Blender is a
program beside: its seconds are those that it took by its clock, and its memory is not measured. Stretch and
texels are those of the faces that do not flip. Peers are added if they are installed. Prints Markdown; with
`--picture`, only draws one mesh with its seams, by `unwrap` and by uvunwrap.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import warnings
from functools import partial
from itertools import product
from pathlib import Path
from statistics import median
from time import process_time

import igl
import numpy as np
import pyvista as pv
from peers import Made, Maker, charts_of, ours, peers, relative_seams
from scipy.ndimage import zoom

from igl_linabf import overlaps, quality, texture_seams

SIZES = {"50k": 96, "150k": 144, "320k": 200}  # points of the grid along an axis
KINDS, NOISES = ("blob", "box"), (0.02, 0.03)
HEADS = (
    "charts",
    "seam / sqrt(area)",
    "L2 stretch",
    "texels 99 : 1 %",
    "fill",
    "flips",
    "overlaps",
    "CPU s",
    "MB",
)


def bumps(n: int, rng: np.random.Generator, coarse: int) -> np.ndarray:
    """Noise on a grid of n points an axis, by cubic splines from a grid of `coarse`."""
    return zoom(rng.standard_normal((coarse,) * 3), n / coarse, order=3)[:n, :n, :n]


def distance(kind: str, at: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Of points from a limb or a box at random."""
    if kind == "blob":
        (a, b), r = rng.uniform(-0.65, 0.65, (2, 3)), rng.uniform(0.08, 0.22)
        along = np.clip((at - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        return np.linalg.norm(at - a - along[..., None] * (b - a), axis=-1) - r
    centre, half = rng.uniform(-0.6, 0.6, 3), rng.uniform(0.03, 0.35, 3)
    beyond = np.abs(at - centre) - half
    return np.linalg.norm(np.maximum(beyond, 0), axis=-1) + np.minimum(beyond.max(-1), 0)


def generated(
    kind: str, n: int, noise: float, seed: int, shape: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """V and F of a surface, several closed components of any genus, from a grid of n points an axis.

    The bumps get finer with the grid, as a generator shows more detail on a finer one; with `shape`, they are
    those of a grid of so many points.
    """
    rng, bumpy = np.random.default_rng(seed), shape or n
    at = np.stack(np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij"), axis=-1)
    d = np.full((n, n, n), 10.0)
    for _ in range(9 if kind == "blob" else 10):
        d = np.minimum(d, distance(kind, at, rng))
    d += noise * bumps(n, rng, bumpy // 6) + noise / 2 * bumps(n, rng, bumpy // 3)
    for _ in range(12):  # floaters and cavities
        centre, r = rng.uniform(-0.9, 0.9, 3), rng.uniform(0.01, 0.04)
        ball = np.linalg.norm(at - centre, axis=-1) - r
        d = np.minimum(d, ball) if rng.random() < 0.5 else np.maximum(d, -ball)
    grid = pv.ImageData(dimensions=(n,) * 3, spacing=(2 / (n - 1),) * 3, origin=(-1, -1, -1))
    grid["d"] = d.ravel(order="F")
    surface = grid.contour([0.0], scalars="d", method="flying_edges").triangulate().clean()
    return np.asarray(surface.points, dtype=float), surface.faces.reshape(-1, 4)[:, 1:].astype(np.int64)


def makers() -> dict[str, Maker]:
    """`unwrap` by its two methods, as it is, and the installed peers."""
    mine: dict[str, Maker] = {"linabf": ours, "isometric": partial(ours, method="isometric")}
    return mine | peers()


def upright(made: Made) -> tuple[np.ndarray, int, np.ndarray]:
    """Texture coordinates with no chart mirrored, as xatlas has some; charts; which faces flip."""
    chart, areas = charts_of(made.FTC), igl.doublearea(made.TC, made.FTC)
    mirrored = np.bincount(chart, areas) < 0
    TC = made.TC.copy()
    TC[np.unique(made.FTC[mirrored[chart]]), 0] *= -1
    return TC, len(mirrored), (areas > 0) == mirrored[chart]


def measured(of: str, path: str) -> dict[str, float]:
    """The figures of one atlas, as `HEADS` has them."""
    mesh = np.load(path)
    V, F, make = mesh["V"], mesh["F"], makers()[of]
    make(*igl.icosahedron())  # imports
    start = process_time()
    made = make(V, F)
    seconds = process_time() - start
    # not ru_maxrss, which begins with the peak of the parent
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    most: float = int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1024
    if of == "Blender":
        seconds, most = made.seconds, np.nan
    TC, charts, flipped = upright(made)
    q = quality(V[made.origin], made.FTC[~flipped], TC)
    fill = igl.doublearea(TC, made.FTC).sum() / 2 / made.page
    seam, over = relative_seams(V, F, made.FTC), len(overlaps(made.TC, made.FTC))
    figures = charts, seam, q.stretch_l2, q.texel_spread, fill, np.count_nonzero(flipped), over, seconds, most
    return dict(zip(HEADS, map(float, figures), strict=True))


def line(name: str, triangles: str, of: str, row: dict[str, float]) -> str:
    kinds = (",.0f", ".1f", ".3f", ".2f", ".2f", ",.0f", ",.0f", ".1f", ",.0f")
    cells = (format(row[head], kind) for head, kind in zip(HEADS, kinds, strict=True))
    figures = " | ".join("" if cell == "nan" else cell for cell in cells)
    return f"| {name} | {triangles} | {of} | {figures} |"


def table(sizes: list[str], seed: int) -> None:
    """A line for each mesh and atlas, then the medians and the ratios of times."""
    print(f"| mesh | triangles | atlas | {' | '.join(HEADS)} |\n|{'---|' * (3 + len(HEADS))}")
    env = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    rows: dict[str, list[dict[str, float]]] = {of: [] for of in makers()}
    triangles = []
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "mesh.npz")
        for size, kind, noise in product(sizes, KINDS, NOISES):
            V, F = generated(kind, SIZES[size], noise, seed)
            np.savez(path, V=V, F=F)
            triangles.append(len(F))
            for of in rows:
                command = [sys.executable, __file__, "--one", of, path]
                done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True, env=env)
                rows[of].append(json.loads(done.stdout.splitlines()[-1]))
                print(line(f"{kind}, {noise}, {size}", f"{len(F):,}", of, rows[of][-1]), flush=True)
    for of, made in rows.items():
        print(line("median", "", of, {head: median(row[head] for row in made) for head in HEADS}))
    for of in ("linabf", "uvunwrap"):
        if of in rows:
            pairs = zip(rows["isometric"], rows[of], strict=True)
            ratios = sorted(mine["CPU s"] / theirs["CPU s"] for mine, theirs in pairs)
            print(
                f"\nCPU time of isometric over {of}: {median(ratios):.1f} in the median, "
                f"{ratios[0]:.1f} to {ratios[-1]:.1f}."
            )
    if len(sizes) > 1:
        times = [row["CPU s"] for row in rows["isometric"]]
        exponent = np.polyfit(np.log(triangles), np.log(times), 1)[0]
        print(f"\nExponent of isometric's time over the triangles: {exponent:.2f}.")


def draw(path: str, seed: int) -> None:
    """The first mesh with checkerboards and seams, by each that makes even texels."""
    from igl_linabf.plot import plot_checkerboard

    V, F = generated(KINDS[0], SIZES["50k"], NOISES[0], seed)
    shown = {name: make for name, make in makers().items() if name in ("isometric", "uvunwrap")}
    plotter = pv.Plotter(
        shape=(1, len(shown)), off_screen=True, window_size=[700 * len(shown), 700], border=False
    )
    for k, (name, make) in enumerate(shown.items()):
        made = make(V, F)
        uv, charts, _ = upright(made)
        plotter.subplot(0, k)
        side = np.sqrt(igl.doublearea(uv, made.FTC).sum() / 2) / 60  # a square is the same share of the area
        squares = float(np.ptp(uv, axis=0).max() / side)
        plot_checkerboard(V[made.origin], made.FTC, uv, frequency=squares, plotter=plotter)
        ends = texture_seams(F, made.FTC)
        lines = pv.PolyData(V, lines=np.insert(ends, 0, 2, axis=1).ravel())
        plotter.add_mesh(lines, color="crimson", line_width=3)
        plotter.view_vector((1, 1, 0.6), viewup=(0, 0, 1))
        plotter.camera.zoom(1.3)
        seam = relative_seams(V, F, made.FTC)
        plotter.add_text(f"{name}: {charts} charts, seams {seam:.1f} times the root of the area", font_size=9)
    plotter.show(screenshot=path)
    plotter.close()


def main() -> None:
    warnings.simplefilter("ignore")
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measured(*sys.argv[2:])))
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument(
        "--size", choices=SIZES, action="append", help="about so many triangles; all by default"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--picture", metavar="FILE", help="draw one of the meshes instead")
    options = parser.parse_args()
    if options.picture:
        draw(options.picture, options.seed)
    else:
        table(options.size or list(SIZES), options.seed)


if __name__ == "__main__":
    main()
