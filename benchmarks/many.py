"""Many small meshes at once: `flatten_many` beside a loop of `flatten`, and atlases of thousands of pieces.

    python benchmarks/many.py [--repeat 3]

The meshes are made here: disks of random triangulations, leaves of four triangles, cubes. Seconds are
those of the processor, medians. Prints Markdown.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Callable
from time import process_time

import numpy as np
from scipy.spatial import Delaunay

import igl_linabf as il
from igl_linabf.charts import pack

Surface = tuple[np.ndarray, np.ndarray]


def disk(triangles: int, seed: int) -> Surface:
    """A disk of about so many triangles between random points, lifted by waves."""
    rng = np.random.default_rng(seed)
    around = np.linspace(0, 2 * np.pi, int(2.2 * np.sqrt(triangles)), endpoint=False)
    inside = rng.uniform(-1, 1, (2 * triangles, 2))
    inside = inside[np.linalg.norm(inside, axis=1) < 0.95][: (triangles - len(around) + 2) // 2]
    xy = np.concatenate((np.column_stack((np.cos(around), np.sin(around))), inside))
    F = Delaunay(xy).simplices.astype(np.int64)
    a, b, c = xy[F.T]
    turned = np.linalg.det(np.stack((b - a, c - a), axis=-1)) < 0
    F[turned] = F[turned][:, ::-1]
    waves = rng.normal(size=(5, 2)) * 2
    return np.column_stack((xy, 0.3 * np.sin(xy @ waves.T + rng.uniform(0, 6, 5)).mean(axis=1))), F


def copies(V: np.ndarray, F: np.ndarray, n: int, noise: float) -> Surface:
    """Copies of a body, turned, scaled and moved at random, as one mesh."""
    rng = np.random.default_rng(0)
    turns = np.linalg.qr(rng.normal(size=(n, 3, 3)))[0]
    turns[np.linalg.det(turns) < 0] *= -1
    bodies = (V + noise * rng.normal(size=(n, *V.shape))) * rng.uniform(0.5, 1.5, (n, 1, 1))
    placed = bodies @ turns + 30 * rng.normal(size=(n, 1, 3))
    return placed.reshape(-1, 3), (F + len(V) * np.arange(n)[:, None, None]).reshape(-1, 3)


def tree(n: int = 5000) -> Surface:
    """Leaves of four triangles, each a component."""
    leaf = np.array([[0, 0, 0], [1, -0.35, 0.1], [2, 0, 0], [1, 0.35, 0.1], [1, 0, 0]])
    return copies(leaf, np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]), n, 0.03)


def cubes(n: int = 2000) -> Surface:
    """Closed cubes of twelve triangles."""
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return copies(cube, np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]), n, 0.0)


def seconds(work: Callable[[], object]) -> float:
    start = process_time()
    work()
    return process_time() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeat", type=int, default=3)
    repeat = range(parser.parse_args().repeat)
    warnings.simplefilter("ignore")
    print("| meshes | triangles each | a loop, ms a mesh | flatten_many | faster | largest difference |")
    print("|---|---|---|---|---|---|")
    for n, triangles in ((5000, 8), (2000, 50), (1000, 500), (200, 2000)):
        meshes = [disk(triangles, seed) for seed in range(n)]
        il.flatten_many(meshes[:50])
        loop, many = [il.flatten(V, F) for V, F in meshes], il.flatten_many(meshes)
        pairs = zip(loop, many, strict=True)
        worst = max(
            float(np.abs(a.uv - b.uv).max() / np.ptp(a.uv)) for a, b in pairs if isinstance(b, il.Flattening)
        )
        runs = [
            (
                seconds(lambda: [il.flatten(V, F) for V, F in meshes]),  # noqa: B023
                seconds(lambda: il.flatten_many(meshes)),  # noqa: B023
            )
            for _ in repeat
        ]
        one, all_ = np.median(runs, axis=0) * 1000 / n
        size = np.median([len(F) for _, F in meshes])
        print(f"| {n:,} | {size:.0f} | {one:.2f} | {all_:.3f} | {one / all_:.1f} | {worst:.0e} |", flush=True)
    print("\n| `unwrap` of | charts | seconds | packing alone | fill | L2 stretch | sound |")
    print("|---|---|---|---|---|---|---|")
    for name, (V, F) in {"5,000 leaves": tree(), "2,000 cubes": cubes()}.items():
        atlas = il.unwrap(V, F)
        taken = np.median([seconds(lambda: il.unwrap(V, F)) for _ in repeat])  # noqa: B023
        charts = [
            (chart.result.uv, np.unique(atlas.FTC[chart.faces], return_inverse=True)[1].reshape(-1, 3))
            for chart in atlas.charts
        ]
        packing = np.median([seconds(lambda: pack(charts)) for _ in repeat])  # noqa: B023
        figures = f"{atlas.fill:.2f} | {atlas.quality.stretch_l2:.4f} | {'yes' if atlas.good else 'no'}"
        print(f"| {name} | {len(charts):,} | {taken:.2f} | {packing:.2f} | {figures} |", flush=True)


if __name__ == "__main__":
    main()
