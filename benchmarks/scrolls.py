"""Time the flattening of OpenABF's test surfaces, with its published times and the SLIM of igl.

    python benchmarks/scrolls.py [--most 1000000] [--slim-most 100000] [--memory 1600 2500]

"wavy" is a grid of n x n points with unit steps and z = 0.3 sin(2 pi x / (n - 1)) cos(2 pi y / (n - 1));
"cap" is a hemisphere. SLIM starts from a harmonic map to a circle and takes 20 steps of the symmetric
Dirichlet energy, as flatboi does. Times are CPU seconds, with the L2 stretch and the flips of the
map. OpenABF's published times are for ABF++ and LSCM on an Apple M3 Max, for meshes of the same
numbers of triangles (github.com/educelab/volume-cartographer/pull/123). Prints Markdown.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable
from time import process_time

import igl
import numpy as np

from igl_linabf import Isometric, abf, flatten, linabf
from igl_linabf.measures import quality
from igl_linabf.scrolls import flatten_segment, synthetic_segment

SIZES = (50_000, 100_000, 200_000, 400_000, 600_000, 800_000, 1_000_000)
# published seconds of OpenABF: by a direct solver, and by conjugate gradients on 1 and 12 threads
PUBLISHED = {
    50_000: (1.30, 7.31, 4.33),
    100_000: (2.96, 28.34, 12.32),
    200_000: (7.38, 107.37, 47.58),
    400_000: (19.84, 433.05, 195.36),
    600_000: (35.69, 961.60, 486.76),
    800_000: (55.82, 1750.23, 842.42),
    1_000_000: (88.61, 3456.18, 1553.04),
}
SLIM_STEPS = 20
Mesh = tuple[np.ndarray, np.ndarray]


def triangulate(rows: int, columns: int) -> np.ndarray:
    """Return the faces of a grid of points, two triangles for each cell."""
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    return np.concatenate(
        (np.column_stack((a, a + 1, a + columns)), np.column_stack((a + 1, a + columns + 1, a + columns)))
    )


def wavy(triangles: int) -> Mesh:
    n = int(np.sqrt(triangles / 2)) + 1
    y, x = np.mgrid[:n, :n].astype(float)
    z = 0.3 * np.sin(2 * np.pi * x / (n - 1)) * np.cos(2 * np.pi * y / (n - 1))
    return np.stack((x, y, z), axis=2).reshape(-1, 3), triangulate(n, n)


def cap(triangles: int) -> Mesh:
    """Return a unit hemisphere of rings of triangles around a pole."""
    rings = round(np.sqrt(triangles / 8))
    around = 4 * rings
    polar, turn = np.meshgrid(
        np.linspace(0, np.pi / 2, rings + 1)[1:], 2 * np.pi * np.arange(around) / around, indexing="ij"
    )
    ring = np.stack((np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)), axis=2)
    first = np.arange(around)
    grid = triangulate(rings, around + 1)  # the last column of the grid is the first one
    row, column = np.divmod(grid, around + 1)
    fan = np.column_stack((0 * first, 1 + first, 1 + (first + 1) % around))
    F = np.concatenate((fan, (1 + row * around + column % around)[:, [0, 2, 1]]))
    return np.concatenate(([[0, 0, 1]], ring.reshape(-1, 3))), F


def slim(V: np.ndarray, F: np.ndarray) -> np.ndarray:
    """Return the map of SLIM after a harmonic start."""
    b = np.asarray(igl.boundary_loop(F))
    bc = igl.map_vertices_to_circle(V, b)
    start = igl.harmonic(V, F, b, bc, 1)
    data = igl.slim_precompute(V, F, start, igl.MappingEnergyType.SYMMETRIC_DIRICHLET, b[:0], bc[:0], 0.0)
    return np.asarray(igl.slim_solve(data, SLIM_STEPS))[:, :2]


def run(function: Callable[..., np.ndarray], V: np.ndarray, F: np.ndarray) -> str:
    """Compute a map; return its seconds, L2 stretch and flips as text."""
    start = process_time()
    uv = function(V, F)
    seconds = process_time() - start
    if not np.isfinite(uv).all():
        return f"{seconds:.1f}; not finite"
    q = quality(V, F, uv)
    return f"{seconds:.2f}; {q.stretch_l2:.4f}, {q.flips}"


def print_times(most: int, slim_most: int) -> None:
    """Print the table of times; SLIM only runs on meshes of at most `slim_most` triangles."""
    functions = {
        "linabf": linabf,
        "abf": abf,
        "isometric": lambda V, F: flatten(V, F, method=Isometric(), progress=False).uv,
    }
    heads = ["mesh", "triangles", *functions, "SLIM, 20 steps", "OpenABF: direct; CG on 1, 12 threads"]
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for name, make in (("wavy", wavy), ("cap", cap)):
        for triangles in (n for n in SIZES if n <= most):
            V, F = make(triangles)
            cells = [run(function, V, F) for function in functions.values()]
            cells.append(run(slim, V, F) if triangles <= slim_most else "")
            direct, *gradients = PUBLISHED[triangles]
            published = f"{direct:,}; {', '.join(f'{s:,}' for s in gradients)}"
            print(f"| {name} | {len(F):,} | {' | '.join(cells)} | {published} |", flush=True)


def print_memory(rows: int, columns: int) -> None:
    """Print the peak memory and the time of a synthetic segment; needs Linux or macOS."""
    import resource

    flat = flatten_segment(synthetic_segment(rows, columns), progress=False)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    report = flat.report
    print(f"{report.faces:,} triangles: {peak / 1e9:.2f} GB, {process_time():.0f} s of a core\n\n{report}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--most", type=int, default=SIZES[-1], help="largest number of triangles")
    parser.add_argument("--slim-most", type=int, default=100_000, help="largest number of triangles for SLIM")
    parser.add_argument("--memory", type=int, nargs=2, metavar=("ROWS", "COLUMNS"), help="only this segment")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    if options.memory:
        print_memory(*options.memory)
        sys.exit()
    linabf(*wavy(1000))
    print_times(options.most, options.slim_most)
