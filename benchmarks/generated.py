"""Compare atlases of generated meshes by this package, xatlas, uvunwrap, Blender, PartUV and UVAtlas.

    python benchmarks/generated.py [--size 50k] [--seed 1] [--picture docs/images/generated.png]

The meshes resemble the output of generative models and scanners. Marching cubes extract them from distance
fields with noise: limbs or boxes, with bumps of two sizes, and a dozen floaters and cavities. `--size`
selects meshes of about 50,000, 150,000 or 320,000 triangles.

Each atlas is made in a separate process with one thread, and MB is the peak memory of that process. Blender,
PartUV and UVAtlas run as external programs: their memory is not measured, and the seconds of Blender are wall
time. Stretch and texels do not count flipped faces. Other programs are included if they are installed; PartUV
and UVAtlas are installed in the folder IGL_LINABF_PEERS as benchmarks/beside.py describes. Because of their
time, they get only the meshes of up to 100,000 triangles. PartUV's charts are measured before packing: they
have no fill, and only overlaps within charts count. Prints Markdown. With `--picture`, the script only draws
one mesh with the seams of `unwrap` and of uvunwrap.
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
from partuv_peer import unwrap_with_partuv
from peers import Maker, find_peers_folder, find_python, ours, peers, relative_seams, unmirror
from scipy.ndimage import zoom
from uvatlas_peer import unwrap_with_uvatlas

from igl_linabf import overlaps, quality

SIZES = {"50k": 96, "150k": 144, "320k": 200}  # grid points along an axis
EXTERNAL = ("Blender", "PartUV", "UVAtlas")  # programs that run in another process and report their seconds
MAX_TRIANGLES = {"PartUV": 100_000, "UVAtlas": 100_000}  # of the largest mesh that a program gets
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


def make_noise(n: int, rng: np.random.Generator, coarse: int) -> np.ndarray:
    """Return noise on a grid of n points per axis, interpolated from a `coarse` grid by cubic splines."""
    return zoom(rng.standard_normal((coarse,) * 3), n / coarse, order=3)[:n, :n, :n]


def random_distance(kind: str, at: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return the signed distances of points from a random limb or box."""
    if kind == "blob":
        (a, b), r = rng.uniform(-0.65, 0.65, (2, 3)), rng.uniform(0.08, 0.22)
        along = np.clip((at - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        return np.linalg.norm(at - a - along[..., None] * (b - a), axis=-1) - r
    centre, half = rng.uniform(-0.6, 0.6, 3), rng.uniform(0.03, 0.35, 3)
    beyond = np.abs(at - centre) - half
    return np.linalg.norm(np.maximum(beyond, 0), axis=-1) + np.minimum(beyond.max(-1), 0)


def generate_mesh(
    kind: str, n: int, noise: float, seed: int, bump_points: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return V and F of several closed components of any genus, from a grid of n points per axis.

    The bumps become finer with the grid, because a generator produces more detail on a finer grid. If given,
    `bump_points` is the number of points per axis that determines the size of the bumps.
    """
    import pyvista as pv  # here, to exclude it from the measured memory of an atlas

    rng, points = np.random.default_rng(seed), bump_points or n
    at = np.stack(np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij"), axis=-1)
    d = np.full((n, n, n), 10.0)
    for _ in range(9 if kind == "blob" else 10):
        d = np.minimum(d, random_distance(kind, at, rng))
    d += noise * make_noise(n, rng, points // 6) + noise / 2 * make_noise(n, rng, points // 3)
    for _ in range(12):  # add floaters and cut out cavities
        centre, r = rng.uniform(-0.9, 0.9, 3), rng.uniform(0.01, 0.04)
        ball = np.linalg.norm(at - centre, axis=-1) - r
        d = np.minimum(d, ball) if rng.random() < 0.5 else np.maximum(d, -ball)
    grid = pv.ImageData(dimensions=(n,) * 3, spacing=(2 / (n - 1),) * 3, origin=(-1, -1, -1))
    grid["d"] = d.ravel(order="F")
    surface = grid.contour([0.0], scalars="d", method="flying_edges").triangulate().clean()
    return np.asarray(surface.points, dtype=float), surface.faces.reshape(-1, 4)[:, 1:].astype(np.int64)


def list_makers() -> dict[str, Maker]:
    """Return the functions that make atlases: both methods of `unwrap`, and the installed programs."""
    folder = find_peers_folder()
    mine: dict[str, Maker] = {
        "linabf": partial(ours, method="linabf"),
        "isometric": partial(ours, method="isometric"),
    }
    found = mine | peers()
    for name, environment, make in (
        ("PartUV", "partuv", unwrap_with_partuv),
        ("UVAtlas", "open3d", unwrap_with_uvatlas),
    ):
        if folder and (python := find_python(folder, environment)):
            found[name] = partial(make, python)
    return found


def measure_peak_memory() -> float:
    """Return the peak memory of this process in MB; ru_maxrss would include the parent process."""
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    return int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1024


def measure_atlas(program: str, path: str) -> dict[str, float]:
    """Return the figures of one atlas, in the order of `HEADS`."""
    mesh = np.load(path)
    V, F, make = mesh["V"], mesh["F"], list_makers()[program]
    make(*igl.icosahedron())  # warm-up, which includes lazy imports
    start = process_time()
    atlas = make(V, F)
    seconds = process_time() - start
    peak = measure_peak_memory()
    if program in EXTERNAL:
        seconds, peak = atlas.seconds, np.nan
    TC, charts, flipped = unmirror(atlas)
    q = quality(V[atlas.origin], atlas.FTC[~flipped], TC)
    fill = igl.doublearea(TC, atlas.FTC).sum() / 2 / atlas.page
    seam, over = relative_seams(V, atlas.origin[atlas.FTC], atlas.FTC), len(overlaps(atlas.TC, atlas.FTC))
    if program == "PartUV":
        fill, over = np.nan, q.overlaps
    figures = charts, seam, q.stretch_l2, q.texel_spread, fill, np.count_nonzero(flipped), over, seconds, peak
    return dict(zip(HEADS, map(float, figures), strict=True))


def format_line(name: str, triangles: str, program: str, row: dict[str, float]) -> str:
    kinds = (",.0f", ".1f", ".3f", ".2f", ".2f", ",.0f", ",.0f", ".1f", ",.0f")
    cells = (format(row[head], kind) for head, kind in zip(HEADS, kinds, strict=True))
    figures = " | ".join("" if cell == "nan" else cell for cell in cells)
    return f"| {name} | {triangles} | {program} | {figures} |"


def print_table(sizes: list[str], seed: int) -> None:
    """Print a row for each mesh and program, the medians, and the ratios of the times."""
    print(f"| mesh | triangles | atlas | {' | '.join(HEADS)} |\n|{'---|' * (3 + len(HEADS))}")
    env = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    rows: dict[str, list[dict[str, float]]] = {program: [] for program in list_makers()}
    triangles = []
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "mesh.npz")
        for size, kind, noise in product(sizes, KINDS, NOISES):
            V, F = generate_mesh(kind, SIZES[size], noise, seed)
            np.savez(path, V=V, F=F)
            triangles.append(len(F))
            for program in rows:
                if len(F) > MAX_TRIANGLES.get(program, len(F)):
                    continue
                command = [sys.executable, __file__, "--one", program, path]
                done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True, env=env)
                rows[program].append(json.loads(done.stdout.splitlines()[-1]))
                print(
                    format_line(f"{kind}, {noise}, {size}", f"{len(F):,}", program, rows[program][-1]),
                    flush=True,
                )
    for program, measured in rows.items():
        if measured:
            medians = {head: median(row[head] for row in measured) for head in HEADS}
            print(format_line("median", f"{len(measured)} meshes", program, medians))
    for program in ("linabf", "uvunwrap"):
        if program in rows:
            pairs = zip(rows["isometric"], rows[program], strict=True)
            ratios = sorted(mine["CPU s"] / theirs["CPU s"] for mine, theirs in pairs)
            print(
                f"\nThe CPU time of isometric atlases is {ratios[0]:.1f} to {ratios[-1]:.1f} times that of "
                f"{program}, and {median(ratios):.1f} times in the median."
            )
    if len(sizes) > 1:
        times = [row["CPU s"] for row in rows["isometric"]]
        exponent = np.polyfit(np.log(triangles), np.log(times), 1)[0]
        print(
            f"\nThe time of isometric atlases grows like the number of triangles to the power {exponent:.2f}."
        )


def draw(path: str, seed: int) -> None:
    """Draw the first mesh with checkerboards and seams, for `unwrap` and uvunwrap."""
    from drawing import Row, draw_atlases  # here, for the same reason as pyvista in `generate_mesh`

    V, F = generate_mesh(KINDS[0], SIZES["50k"], NOISES[0], seed)
    shown = {name: make for name, make in list_makers().items() if name in ("isometric", "uvunwrap")}
    atlases = {name: make(V, F) for name, make in shown.items()}
    draw_atlases(path, [Row(V, atlases, (1, 1, 0.6), (0, 0, 1))])


def main() -> None:
    warnings.simplefilter("ignore")
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measure_atlas(*sys.argv[2:])))
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument(
        "--size", choices=SIZES, action="append", help="approximate number of triangles (default: all sizes)"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--picture", metavar="FILE", help="draw one of the meshes instead")
    options = parser.parse_args()
    if options.picture:
        draw(options.picture, options.seed)
    else:
        print_table(options.size or list(SIZES), options.seed)


if __name__ == "__main__":
    main()
