"""Compare prescribed boundaries with a free boundary: F/3nt, L2 stretch, flips, solves and relative time.

    python benchmarks/boundaries.py [--repeat 3]
    python benchmarks/boundaries.py --bff bff-command-line

There are three tables, printed as Markdown:

- the cortex and the meshes of kinds disk, flat2d and stress in IGL_LINABF_MESHES;
- with circles for the holes, too: the crown, and the meshes of kind holes with up to 40,000 triangles;
- on a circle only: the bunny and the meshes of kind closed without handles, cut open along the seams of
  `unwrap` and subdivided to at least 25,000 triangles.

In the first two tables, chords are split, because a triangle with two boundary edges cannot lie along a
straight side. Times are CPU times of one thread: set OMP_NUM_THREADS=1. With `--bff`, the command of
https://github.com/GeometryCollective/boundary-first-flattening maps the disks to a circle as well.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import tempfile
import warnings
from functools import partial
from pathlib import Path
from time import process_time

import igl
import numpy as np
from meshes import Mesh, brain, crown, load_shared_meshes, stanford, subdivide

from igl_linabf import FallbackWarning, OutcomeWarning, cut, flatten, quality, unwrap
from igl_linabf.flattening import Flattening, measure_median_times
from igl_linabf.io import read_mesh, read_texture, write_obj
from igl_linabf.surface import planar_mesh, split_chords

FREE = "free"
MAX_TRIANGLES = 40_000  # triangles of the largest mesh with holes
MIN_TRIANGLES = 25_000  # opened surfaces are subdivided until they have at least as many triangles


def cut_open(mesh: Mesh) -> Mesh:
    """Return the largest chart of `unwrap`, subdivided to at least `MIN_TRIANGLES` triangles."""
    name, V, F = mesh
    atlas = unwrap(V, F, method="linabf")
    V, F, _ = cut(V, F, atlas.seams)
    chart = max(atlas.charts, key=lambda chart: len(chart.faces))
    V, F = igl.remove_unreferenced(V, F[chart.faces])[:2]
    times = max(0, int(np.ceil(np.log(MIN_TRIANGLES / len(F)) / np.log(4))))
    return subdivide((name, V, F), times) if times else (name, V, F)


def shape_error(result: Flattening, loop: np.ndarray) -> float:
    """Return how far a loop is from its circle or upright rectangle, relative to the size of the shape."""
    z = result.uv[loop]
    if len(result.report.corners):
        low, high = (end(result.uv[result.report.corners], axis=0) for end in (np.min, np.max))
        distance = np.minimum(np.abs(z - low), np.abs(z - high)).min(axis=1)
        return float(distance.max() / np.linalg.norm(high - low))
    return circle_error(z)


def circle_error(z: np.ndarray) -> float:
    """Return the range of the distances from the centre of the best-fit circle, relative to their mean."""
    centre = np.linalg.lstsq(np.column_stack((z, np.ones(len(z)))), (z**2).sum(axis=1), rcond=None)[0][:2] / 2
    radius = np.linalg.norm(z - centre, axis=1)
    return float(np.ptp(radius) / radius.mean())


def compare_with_bff(command: str) -> None:
    """Print a table of our map and the map of BFF on a circle."""
    print("Each cell: F/3nt, L2 stretch, flips, distance of the boundary from a circle; CPU seconds, with")
    print("reading and writing files.\n")
    print('| mesh | triangles | BFF | igl_linabf, `boundary="circle"` |')
    print("|---|---|---|---|")
    for name, V, F in [brain(), *load_shared_meshes("disk")]:
        V, F = split_chords(V, F)
        loop, cells = igl.boundary_loop(F), []
        with tempfile.TemporaryDirectory() as folder:
            given, output = Path(folder, "in.obj"), Path(folder, "out.obj")
            igl.writeOBJ(str(given), V, F)
            start = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([command, given, output, "--flattenToDisk"], check=True, capture_output=True)
            end = resource.getrusage(resource.RUSAGE_CHILDREN)
            TC, FTC = read_texture(output)
            bff_uv = np.empty((len(V), 2))
            bff_uv[read_mesh(output)[1]] = TC[FTC]
            our_uv = flatten(V, F, boundary="circle").uv  # also serves as a warm-up
            begin = process_time()
            write_obj(output, *read_mesh(given), flatten(V, F, boundary="circle").uv)
            seconds = end.ru_utime - start.ru_utime + end.ru_stime - start.ru_stime, process_time() - begin
        for uv, time in zip((bff_uv, our_uv), seconds, strict=True):
            q = quality(V, F, uv)
            cell = f"{q.angle_distortion:.3g}, {q.stretch_l2:.3g}, {q.flips}, {circle_error(uv[loop]):.0e}"
            cells.append(f"{cell}; {time:.2f}")
        print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--bff")
    options = parser.parse_args()
    warnings.simplefilter("ignore", OutcomeWarning)
    warnings.simplefilter("ignore", FallbackWarning)
    if options.bff:
        compare_with_bff(options.bff)
        return
    print(
        "Each cell contains F/3nt, the L2 stretch and the number of flipped triangles; the number of\n"
        "solves (and of conjugate gradient steps), the distance of the boundary from the requested shape,\n"
        "relative to the size of the shape, and the **CPU time relative to the free map**.\n"
    )
    print("| mesh | triangles | free | circle | rectangle |")
    print("|---|---|---|---|---|")
    for name, V, F in [brain(), *load_shared_meshes("disk", "flat2d", "stress")]:
        print_row(name, *split_chords(V, F), (FREE, "circle", "rectangle"), options.repeat)
    print("\n| with holes | triangles | free | circle | circles |")
    print("|---|---|---|---|---|")
    for name, V, F in [
        crown(),
        *(mesh for mesh in load_shared_meshes("holes") if len(mesh[2]) <= MAX_TRIANGLES),
    ]:
        print_row(name, *split_chords(V, F), (FREE, "circle", "circles"), options.repeat)
    print("\n| cut open | triangles | free | circle |")
    print("|---|---|---|---|")
    without_handles = [
        mesh for mesh in load_shared_meshes("closed") if igl.euler_characteristic(mesh[2]) == 2
    ]
    for mesh in [stanford(), *without_handles]:
        print_row(*cut_open(mesh), (FREE, "circle"), options.repeat)


def print_row(name: str, V: np.ndarray, F: np.ndarray, shapes: tuple[str, ...], repeat: int) -> None:
    mesh, cells = planar_mesh(V, F), []
    calls = [partial(flatten, V, F, boundary=shape, progress=False) for shape in shapes]
    results = {shape: call() for shape, call in zip(shapes, calls, strict=True)}
    times = dict(zip(shapes, measure_median_times(calls, repeat, process_time), strict=True))
    for shape, result in results.items():
        q = quality(V, F, result.uv)
        cell = f"{q.angle_distortion:.3g}, {q.stretch_l2:.3g}, {q.flips}; "
        cell += f"{result.report.iterations} ({result.report.inner_steps})"
        if shape != FREE:
            loops = mesh.topology.loops[: None if shape == "circles" else 1]
            worst = max(shape_error(result, mesh.vertices[loop]) for loop in loops)
            cell += f", {worst:.0e}, **{times[shape] / times[FREE]:.1f}**"
        cells.append(cell)
    print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
