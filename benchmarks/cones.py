"""Compare linear ABF and boundary first flattening (BFF) with the same cones, and a free boundary.

    python benchmarks/cones.py [--bff bff-command-line]
    python benchmarks/cones.py --speed
    python benchmarks/cones.py --period

The meshes are the Stanford bunny and the meshes of kind closed in IGL_LINABF_MESHES. Prints Markdown.

--bff names the command of https://github.com/GeometryCollective/boundary-first-flattening. This command
chooses the cones. Without --bff, `find_cones` chooses the cones, and the table has no columns for BFF.
Surfaces with handles have no result of BFF, because it leaves curvature along whole loops around the handles,
not only at cones.

--speed prints two ratios of times, for meshes subdivided to about 100,000 triangles: the map with cones
relative to `flatten` on the cut surface (without and with the search for the seam and the cut), and `unwrap`
with cones relative to `unwrap` along the same seams. Set OMP_NUM_THREADS=1.

--period prints the growth of the distortion of quarter cones with the period of a texture.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path
from time import process_time

import igl
import numpy as np
from meshes import load_shared_meshes, pial, stanford, subdivide

from igl_linabf import Cones, MeshError, OutcomeWarning, cut, flatten, quality, unwrap
from igl_linabf.charts import find_cones
from igl_linabf.io import read_mesh, read_texture

CONES = 16
RUNS = 3
PERIODS = 180, 90, 45


def format_cell(V: np.ndarray, F: np.ndarray, TC: np.ndarray, FTC: np.ndarray, seconds: float) -> str:
    """Return the table cells of a map: distortion, stretch, mismatch of the seams, flips, and time."""
    origin = np.empty(len(TC), dtype=np.int64)
    origin[FTC] = F
    used = np.unique(FTC)
    packed = np.searchsorted(used, FTC)
    q = quality(V[origin[used]], packed, TC[used])
    mismatch = seam_mismatch(F, TC, FTC)
    return (
        f"{q.angle_distortion:.2e}, {q.stretch_l2:.3g}, {np.expm1(mismatch):.0e}, {q.flips} | {seconds:.2f}"
    )


def seam_mismatch(F: np.ndarray, TC: np.ndarray, FTC: np.ndarray) -> float:
    """Return the largest |log ratio| of the lengths of the two sides of an edge in the map."""
    length = np.linalg.norm(TC[np.roll(FTC, -1, axis=1)] - TC[FTC], axis=2).ravel()
    ends = np.sort(np.stack((F, np.roll(F, -1, axis=1)), axis=-1).reshape(-1, 2), axis=1)
    order = np.lexsort(ends.T)
    same = (ends[order][1:] == ends[order][:-1]).all(axis=1)
    return float(np.abs(np.log(length[order][1:] / length[order][:-1]))[same].max())


def run_bff(command: str, V: np.ndarray, F: np.ndarray) -> tuple[str, np.ndarray]:
    """Return the table cell of BFF's map, and its cones: vertices whose angle sums differ most from 2 pi."""
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder, "in.obj"), Path(folder, "out.obj")
        igl.writeOBJ(str(given), V, F)
        start = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([command, given, made, f"--nCones={CONES}"], check=True, capture_output=True)
        end = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds = end.ru_utime - start.ru_utime + end.ru_stime - start.ru_stime
        (_, F), (TC, FTC) = read_mesh(made), read_texture(made)
    side = np.roll(TC[FTC], -1, axis=1) - TC[FTC]
    z = side @ [1, 1j]
    angle = np.angle(-np.roll(z, 1, axis=1) / z)
    curvature = np.abs(np.bincount(F.ravel(), np.abs(angle).ravel(), len(V)) - 2 * np.pi)
    return format_cell(V, F, TC, FTC, seconds), np.argsort(-curvature)[:CONES]


def print_speed() -> None:
    """Print the time of maps with cones relative to the time with a free boundary (medians, one thread)."""
    print(
        "| mesh | triangles | cones | with the cutting | whole | quarter cones | with the cutting | whole |"
    )
    print("|---" * 8 + "|")
    closed = [
        (name, V, F, round(np.log(1e5 / len(F)) / np.log(4))) for name, V, F in load_shared_meshes("closed")
    ]
    upsampled = [subdivide((name, V, F), times) if times else (name, V, F) for name, V, F, times in closed]
    for name, V, F in [stanford(), subdivide(pial(), 1), *upsampled]:
        cones, cells = find_cones(V, F, CONES), []
        for angles in (None, "quarter"):
            seconds = np.median(
                [time_once(V, F, Cones(cones, angles=angles)) for _ in range(RUNS + 1)][1:], axis=0
            )
            coned, cutting, whole, free, seamed = seconds
            cells += [f"{coned / free:.2f}", f"{(coned + cutting) / free:.2f}", f"{whole / seamed:.2f}"]
        print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


def time_once(V: np.ndarray, F: np.ndarray, cones: Cones) -> list[float]:
    """Return seconds: map with cones, its cut, `unwrap` with cones, free map, `unwrap` along the seams."""
    start = process_time()
    atlas = unwrap(V, F, cones=cones)
    whole = process_time() - start
    coned = atlas.charts[0].result.seconds
    start = process_time()
    unwrap(V, F, atlas.seams)
    seamed = process_time() - start
    V, F, _ = cut(V, F, atlas.seams)
    disks = [igl.remove_unreferenced(V, F[chart.faces])[:2] for chart in atlas.charts]
    free = sum(flatten(*disk).seconds["total"] for disk in disks)
    return [coned["total"] - coned["check"], coned["check"], whole, free, seamed]


def print_periods() -> None:
    """Print the distortion of quarter cones with and without periods of a texture."""
    print("| mesh | cones | no period |" + "".join(f" 1/{n} |" for n in PERIODS))
    print("|---" * (3 + len(PERIODS)) + "|")
    for name, V, F in [stanford(), *load_shared_meshes("closed")]:
        cones, cells = find_cones(V, F), []
        for period in (None, *(1 / n for n in PERIODS)):
            try:
                atlas = unwrap(V, F, cones=Cones(cones, angles="quarter", period=period))
                cells.append(f"{atlas.quality.angle_distortion:.2e}")
            except MeshError:
                cells.append("refused")
        print(f"| {name} | {len(cones)} | {' | '.join(cells)} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--bff", help="command of boundary first flattening")
    parser.add_argument(
        "--speed", action="store_true", help="print the time of cones over the time of a free boundary"
    )
    parser.add_argument(
        "--period", action="store_true", help="print the distortion for several periods of a texture"
    )
    options = parser.parse_args()
    if options.speed:
        print_speed()
        return
    if options.period:
        print_periods()
        return
    if options.bff is None:
        print("no columns of BFF: name its command with --bff", file=sys.stderr)
    warnings.simplefilter("ignore", OutcomeWarning)
    print("Each cell: F/3nt, L2 stretch, largest difference of the lengths of a seam edge's sides, flips.")
    print("BFF's time includes reading and writing files.\n" if options.bff else "")
    names = ["cones", "quarter cones", "free boundary"]
    names = [*(["BFF"] if options.bff else []), *names]
    print(f"| mesh | triangles | {' | '.join(f'{name} | CPU s' for name in names)} |")
    print("|---" * (2 + 2 * len(names)) + "|")
    for name, V, F in [stanford(), *load_shared_meshes("closed")]:
        cells = []
        handles = igl.euler_characteristic(F) < 2
        if options.bff and not handles:
            made, cones = run_bff(options.bff, V, F)
            cells.append(made)
        else:
            cones = find_cones(V, F, CONES)
            cells += ["- | -"] if options.bff else []
        seams = unwrap(V, F, cones=cones).seams  # also serves as a warm-up
        for settings in ({"cones": cones}, {"cones": Cones(cones, angles="quarter")}, {"seams": seams}):
            start = process_time()
            atlas = unwrap(V, F, **settings)
            cells.append(format_cell(V, F, atlas.TC, atlas.FTC, process_time() - start))
        print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
