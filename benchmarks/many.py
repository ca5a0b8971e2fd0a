"""Compare `flatten_many` with a loop of `flatten` on small meshes, and time atlases of thousands of pieces.

    python benchmarks/many.py [--repeat 3]

The meshes are generated: disks of random triangulations, leaves of four triangles, and cubes. Times are
medians of CPU times, or of wall times where the column says so, because only these show the gain of threads.
igl.lscm is called in a loop, too. Prints Markdown.
"""

from __future__ import annotations

import argparse
import os
import warnings
from collections.abc import Callable
from time import perf_counter, process_time

import igl
import numpy as np
from scipy.spatial import Delaunay

import igl_linabf as il
from igl_linabf.charts import pack_charts

Surface = tuple[np.ndarray, np.ndarray]


def disk(triangles: int, seed: int) -> Surface:
    """Return a disk of about `triangles` triangles between random points, lifted by waves."""
    rng = np.random.default_rng(seed)
    around = np.linspace(0, 2 * np.pi, int(2.2 * np.sqrt(triangles)), endpoint=False)
    inside = rng.uniform(-1, 1, (2 * triangles, 2))
    inside = inside[np.linalg.norm(inside, axis=1) < 0.95][: (triangles - len(around) + 2) // 2]
    xy = np.concatenate((np.column_stack((np.cos(around), np.sin(around))), inside))
    F = Delaunay(xy).simplices.astype(np.int64)
    a, b, c = xy[F.T]
    flipped = np.linalg.det(np.stack((b - a, c - a), axis=-1)) < 0
    F[flipped] = F[flipped][:, ::-1]
    waves = rng.normal(size=(5, 2)) * 2
    return np.column_stack((xy, 0.3 * np.sin(xy @ waves.T + rng.uniform(0, 6, 5)).mean(axis=1))), F


def copies(V: np.ndarray, F: np.ndarray, n: int, noise: float) -> Surface:
    """Return copies of a body, with random rotations, scales and positions, as one mesh."""
    rng = np.random.default_rng(0)
    rotations = np.linalg.qr(rng.normal(size=(n, 3, 3)))[0]
    rotations[np.linalg.det(rotations) < 0] *= -1
    bodies = (V + noise * rng.normal(size=(n, *V.shape))) * rng.uniform(0.5, 1.5, (n, 1, 1))
    placed = bodies @ rotations + 30 * rng.normal(size=(n, 1, 3))
    return placed.reshape(-1, 3), (F + len(V) * np.arange(n)[:, None, None]).reshape(-1, 3)


def tree(n: int = 5000) -> Surface:
    """Return a mesh of n leaves of a tree; each leaf is a component of four triangles."""
    leaf = np.array([[0, 0, 0], [1, -0.35, 0.1], [2, 0, 0], [1, 0.35, 0.1], [1, 0, 0]])
    return copies(leaf, np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]), n, 0.03)


def cubes(n: int = 2000) -> Surface:
    """Return a mesh of closed cubes of twelve triangles."""
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return copies(cube, np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]), n, 0.0)


def cpu_seconds(work: Callable[[], object]) -> float:
    """Return the CPU seconds of a call of `work`."""
    return time_clocks(work)[0]


def time_clocks(work: Callable[[], object]) -> tuple[float, float]:
    """Return the CPU seconds and the wall seconds of a call of `work`."""
    start = process_time(), perf_counter()
    work()
    return process_time() - start[0], perf_counter() - start[1]


def find_pins(F: np.ndarray) -> np.ndarray:
    """Return two boundary vertices far from each other, for the pins of libigl."""
    rim = igl.boundary_loop(F)
    return rim[[0, len(rim) // 2]]


def compare(meshes: list[Surface], repeat: range) -> str:
    """Return the cells of a table row: a loop of `flatten`, `flatten_many`, and a loop of igl.lscm."""
    n, pins, at = len(meshes), [find_pins(F) for _, F in meshes], np.array([[0.0, 0.0], [1.0, 0.0]])
    il.flatten_many(meshes[:50])
    loop, many = [il.flatten(V, F) for V, F in meshes[:200]], il.flatten_many(meshes)
    pairs = zip(loop, many, strict=False)
    worst = max(
        float(np.abs(a.uv - b.uv).max() / np.ptp(a.uv))
        for a, b in pairs
        if isinstance(b, il.flattening.Flattening)
    )
    runs = [
        (
            time_clocks(lambda: [il.flatten(V, F) for V, F in meshes]),
            time_clocks(lambda: il.flatten_many(meshes)),
            time_clocks(lambda: [igl.lscm(V, F, b, at) for (V, F), b in zip(meshes, pins, strict=True)]),
        )
        for _ in repeat
    ]
    one, all_, libigl = np.median(runs, axis=0) * 1000 / n
    cells = [*one / all_, libigl[0] / all_[0]]
    return f"{one[0]:.2f} | {all_[0]:.3f} | {' | '.join(f'{ratio:.1f}' for ratio in cells)} | {worst:.0e}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeat", type=int, default=3)
    repeat = range(parser.parse_args().repeat)
    warnings.simplefilter("ignore")
    print(f"Number of cores that the process may use: {len(os.sched_getaffinity(0))}.\n")
    print(
        "| meshes | triangles each | a loop, ms a mesh | flatten_many | faster | by the clock "
        "| than a loop of igl.lscm | largest difference |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for n, triangles in ((2000, 8), (1000, 50), (1000, 500), (100, 2000)):
        meshes = [disk(triangles, seed) for seed in range(n)]
        size = np.median([len(F) for _, F in meshes])
        print(f"| {n:,} | {size:.0f} | {compare(meshes, repeat)} |", flush=True)
    print("\n| `unwrap` of | charts | seconds | packing alone | fill | L2 stretch | sound |")
    print("|---|---|---|---|---|---|---|")
    for name, (V, F) in {"5,000 leaves": tree(), "2,000 cubes": cubes()}.items():
        atlas = il.unwrap(V, F)
        taken = np.median([cpu_seconds(lambda: il.unwrap(V, F)) for _ in repeat])  # noqa: B023
        charts = [
            (chart.result.uv, np.unique(atlas.FTC[chart.faces], return_inverse=True)[1].reshape(-1, 3))
            for chart in atlas.charts
        ]
        packing = np.median([cpu_seconds(lambda: pack_charts(charts)) for _ in repeat])  # noqa: B023
        figures = f"{atlas.fill:.2f} | {atlas.quality.stretch_l2:.4f} | {'yes' if atlas.good else 'no'}"
        print(f"| {name} | {len(charts):,} | {taken:.2f} | {packing:.2f} | {figures} |", flush=True)


if __name__ == "__main__":
    main()
