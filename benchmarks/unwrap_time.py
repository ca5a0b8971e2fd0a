"""Measure the time of `unwrap`, compared with the flattening alone and with xatlas.

    python benchmarks/unwrap_time.py [FILE ...]

Without files, the meshes are the bunny, a torus, level sets with 5 and 10 handles, 500 mixed pieces, 2,000
cubes, a plate with 40 bores, and the meshes of kinds closed, handles, holes and multi in IGL_LINABF_MESHES,
some of them also subdivided with bumps. Each mesh runs in a separate process with one thread. xatlas is
included if it is installed. Prints Markdown.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import warnings
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from time import process_time

import igl
import numpy as np
import pyvista as pv
from meshes import load_shared_meshes, stanford
from peers import unwrap_with_xatlas

from igl_linabf import clean, flatten, flatten_many, unwrap
from igl_linabf.flattening import measure_median_times
from igl_linabf.io import read_mesh
from igl_linabf.surface import drop_unused_vertices

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from hard_surfaces import plate_with_holes

Surface = tuple[np.ndarray, np.ndarray]

REPEAT_BELOW = 30_000  # below this number of triangles, the time is the median of three runs
XATLAS_BELOW = 50_000  # above this number of triangles, xatlas takes minutes
LARGE = {"bunny": 1, "igl_cow": 2, "optcuts_horse_f10000": 3, "igl_3holes": 2, "bff_punctured-torus": 1}
KINDS = ("closed", "handles", "holes", "multi")


def add_bumps(V: np.ndarray, F: np.ndarray, times: int, seed: int = 0) -> Surface:
    """Return a Loop-subdivided surface with bumps of a thousandth of the diagonal."""
    V, F = igl.loop(V, F.astype(np.int64), times)
    size, rng = float(np.linalg.norm(np.ptp(V, axis=0))), np.random.default_rng(seed)
    height = sum(np.sin(V @ rng.normal(size=3) * 60 / size + rng.uniform(0, 6)) for _ in range(12))
    return V + igl.per_vertex_normals(V, F) * (height * size / 3000)[:, None], F


def torus(times: int) -> Surface:
    """Return a torus with bumps."""
    u, v = (a.ravel() for a in np.meshgrid(*2 * [2 * np.pi * np.arange(50) / 50], indexing="ij"))
    V = np.column_stack(
        ((1 + 0.5 * np.cos(v)) * np.cos(u), (1 + 0.5 * np.cos(v)) * np.sin(u), 0.5 * np.sin(v))
    )
    i, j = (a.ravel() for a in np.meshgrid(*2 * [np.arange(50)], indexing="ij"))
    a, b, c, d = (50 * ((i + k) % 50) + (j + m) % 50 for k, m in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return add_bumps(V, np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d)))), times)


def tangle(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return values that are negative inside a cube with a tunnel along each axis: 5 handles."""
    return sum(c**4 - 5 * c**2 for c in (x, y, z)) + 11.8


def gyroid(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return values that are negative inside a sheet along the gyroid within a ball: 10 handles."""
    sheet = np.abs(np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)) - 0.35
    return np.maximum(sheet, x**2 + y**2 + z**2 - 4.5**2)


def level_set(f: Callable[..., np.ndarray], reach: float, points: int) -> Surface:
    """Return the zero set of a function, by marching cubes on a grid of `points` points per axis."""
    grid = pv.ImageData(
        dimensions=(points,) * 3, spacing=(2 * reach / (points - 1),) * 3, origin=(-reach,) * 3
    )
    body = (
        grid.contour([0.0], scalars=f(*grid.points.T), method="flying_edges").clean().connectivity("largest")
    )
    return np.asarray(body.points, dtype=float), body.faces.reshape(-1, 4)[:, 1:].astype(np.int64)


def make_pieces(count: int, boxes: float, seed: int = 0) -> Surface:
    """Return separate pieces: boxes (a share of `boxes`), and spheres of 20 to 1,280 triangles."""
    rng = np.random.default_rng(seed)
    corners = np.array([[x, y, z] for x in (0.0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    box = corners, np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])
    kinds = [box, *(igl.loop(*igl.icosahedron(), k) if k else igl.icosahedron() for k in range(4))]
    chosen = rng.choice(5, size=count, p=[boxes, *[(1 - boxes) / 4] * 4])
    V = [kinds[k][0] * rng.uniform(0.5, 1.5, size=3) + [4 * i, 0, 0] for i, k in enumerate(chosen)]
    base = np.cumsum([0, *map(len, V)])
    return np.concatenate(V), np.concatenate([kinds[k][1] + b for k, b in zip(chosen, base, strict=False)])


def read_clean_mesh(path: str) -> Surface:
    """Return the clean mesh of a file, with equal vertices welded."""
    V, F, *_ = clean(*read_mesh(path))
    return V, F


def models() -> dict[str, Callable[[], Surface]]:
    """Return the functions that make the meshes, by name."""
    given = {name: (V, F) for name, V, F in [stanford(), *load_shared_meshes(*KINDS)]}
    found: dict[str, Callable[[], Surface]] = {name: partial(tuple, mesh) for name, mesh in given.items()}
    for name, times in LARGE.items():
        for k in range(1, times + 1) if name in given else ():
            found[f"{name}, bumpy, {4**k} x"] = partial(add_bumps, *given[name], k)
    found |= {f"torus, bumpy, {4**k} x": partial(torus, k) for k in (1, 2)}
    found |= {f"5 handles, {n} points": partial(level_set, tangle, 3.0, n) for n in (80, 160)}
    found |= {"10 handles, 60 points": partial(level_set, gyroid, 5.0, 60)}
    found |= {"500 pieces": partial(make_pieces, 500, 0.5), "2,000 cubes": partial(make_pieces, 2000, 1.0)}
    return found | {"plate with 40 bores": partial(plate_with_holes, 40)}


def measure(name: str) -> dict[str, float]:
    """Return triangles, charts, times and memory for a file or one of `models`."""
    V, F = read_clean_mesh(name) if Path(name).is_file() else models()[name]()
    repeats = 3 if len(F) < REPEAT_BELOW else 1
    atlas = unwrap(V, F, progress=False)  # warm-up, which includes lazy imports
    (own,) = measure_median_times([partial(unwrap, V, F, progress=False)], repeats, process_time)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    charts = []
    for chart in atlas.charts:
        vertices, packed = drop_unused_vertices(atlas.FTC[chart.faces], len(atlas.TC))
        charts.append((V[atlas.origin[vertices]], packed))
    calls = [lambda: [flatten(*chart, progress=False) for chart in charts], partial(flatten_many, charts)]
    measure_median_times(calls, 1)  # warm-up: not timed
    one_by_one, together = measure_median_times(calls, repeats, process_time)
    row = {"triangles": len(F), "charts": len(charts), "s": own, "MB": memory / 1024}
    row |= {"flatten": one_by_one, "many": together}
    if find_spec("xatlas") and len(F) < XATLAS_BELOW:
        (row["xatlas"],) = measure_median_times([partial(unwrap_with_xatlas, V, F)], repeats, process_time)
    return row


def main() -> None:
    files = sys.argv[1:]
    if files[:1] == ["--one"]:
        warnings.simplefilter("ignore")
        print(json.dumps(measure(files[1])))
        return
    print(
        "The column s is the CPU time of unwrap in seconds, with one thread. The columns / flatten and\n"
        "/ flatten_many are the ratios of s to the time of only flattening the charts, one by one and\n"
        "together. MB is the peak memory of the process.\n"
    )
    heads = [
        "mesh",
        "triangles",
        "charts",
        "s",
        "/ flatten",
        "/ flatten_many",
        "/ xatlas",
        "MB",
        "KB a triangle",
    ]
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    env = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    for name in files or models():
        command = [sys.executable, __file__, "--one", name]
        done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True, env=env)
        row = json.loads(done.stdout.splitlines()[-1])
        cells = [
            Path(name).stem if files else name,
            f"{row['triangles']:,}",
            f"{row['charts']:,}",
            f"{row['s']:.2f}",
        ]
        cells += [f"{row['s'] / row[alone]:.1f}" for alone in ("flatten", "many")]
        cells += [f"{row['s'] / row['xatlas']:.2f}" if "xatlas" in row else ""]
        cells += [f"{row['MB']:,.0f}", f"{1024 * row['MB'] / row['triangles']:.1f}"]
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
