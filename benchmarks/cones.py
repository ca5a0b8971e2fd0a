"""Cones: linear ABF and boundary first flattening (BFF) on the same ones, and a free boundary.

    python benchmarks/cones.py [--bff bff-command-line]
    python benchmarks/cones.py --speed
    python benchmarks/cones.py --period

`--bff` names the command of https://github.com/GeometryCollective/boundary-first-flattening, which chooses
the cones. Without it `find_cones` does, and the columns of BFF are missing. The meshes are the Stanford
bunny and those of kind `closed` in IGL_LINABF_MESHES. Prints Markdown. `--speed` prints the
time of maps with cones over that of `flatten` on the same surface cut, without and with finding the seam and
cutting along it, and that of all of `unwrap` over that of `unwrap` along the same seams. There the meshes are
subdivided to about 100,000 triangles. Set OMP_NUM_THREADS=1.
`--period` prints how the distortion of quarter cones grows with the period of a texture.
Where a surface has handles, BFF
leaves curvature along their whole loops, which is no map with the same cones: it is left out there.
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
from meshes import pial, shared, stanford, subdivided

from igl_linabf import Cones, MeshError, OutcomeWarning, cut, find_cones, flatten, quality, unwrap
from igl_linabf.io import read_mesh, read_texture

CONES = 16
TURNS = 3
PERIODS = 180, 90, 45


def cell(V: np.ndarray, F: np.ndarray, TC: np.ndarray, FTC: np.ndarray, seconds: float) -> str:
    """What is measured of a map: distortion, stretch, seam sides, flips, time."""
    origin = np.empty(len(TC), dtype=np.int64)
    origin[FTC] = F
    used = np.unique(FTC)
    packed = np.searchsorted(used, FTC)
    q = quality(V[origin[used]], packed, TC[used])
    mismatch = sides_apart(F, TC, FTC)
    return (
        f"{q.angle_distortion:.2e}, {q.stretch_l2:.3g}, {np.expm1(mismatch):.0e}, {q.flips} | {seconds:.2f}"
    )


def sides_apart(F: np.ndarray, TC: np.ndarray, FTC: np.ndarray) -> float:
    """The largest |log ratio| of the lengths of both sides of an edge."""
    length = np.linalg.norm(TC[np.roll(FTC, -1, axis=1)] - TC[FTC], axis=2).ravel()
    ends = np.sort(np.stack((F, np.roll(F, -1, axis=1)), axis=-1).reshape(-1, 2), axis=1)
    order = np.lexsort(ends.T)
    same = (ends[order][1:] == ends[order][:-1]).all(axis=1)
    return float(np.abs(np.log(length[order][1:] / length[order][:-1]))[same].max())


def by_bff(command: str, V: np.ndarray, F: np.ndarray) -> tuple[str, np.ndarray]:
    """The cell of BFF's map, and its cones: where the map's angles miss 2 pi most."""
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
    missing = np.abs(np.bincount(F.ravel(), np.abs(angle).ravel(), len(V)) - 2 * np.pi)
    return cell(V, F, TC, FTC, seconds), np.argsort(-missing)[:CONES]


def speed() -> None:
    """Print how many times the time of a free boundary cones take: medians of turns, of one thread."""
    print(
        "| mesh | triangles | cones | with the cutting | whole | quarter cones | with the cutting | whole |"
    )
    print("|---" * 8 + "|")
    closed = [(name, V, F, round(np.log(1e5 / len(F)) / np.log(4))) for name, V, F in shared("closed")]
    upsampled = [subdivided((name, V, F), times) if times else (name, V, F) for name, V, F, times in closed]
    for name, V, F in [stanford(), subdivided(pial(), 1), *upsampled]:
        cones, cells = find_cones(V, F, CONES), []
        for angles in (None, "quarter"):
            seconds = np.median(
                [turn(V, F, Cones(cones, angles=angles)) for _ in range(TURNS + 1)][1:], axis=0
            )
            coned, cutting, whole, free, seamed = seconds
            cells += [f"{coned / free:.2f}", f"{(coned + cutting) / free:.2f}", f"{whole / seamed:.2f}"]
        print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


def turn(V: np.ndarray, F: np.ndarray, cones: Cones) -> list[float]:
    """Seconds of the map with cones, of cutting for it, of all of `unwrap`; and with a free boundary."""
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


def periods() -> None:
    """Print the distortion of quarter cones whose seams shift by whole periods, and of those without one."""
    print("| mesh | cones | no period |" + "".join(f" 1/{n} |" for n in PERIODS))
    print("|---" * (3 + len(PERIODS)) + "|")
    for name, V, F in [stanford(), *shared("closed")]:
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
    parser.add_argument("--bff", help="the command of boundary first flattening")
    parser.add_argument("--speed", action="store_true", help="the time of cones over that of a free boundary")
    parser.add_argument("--period", action="store_true", help="distortion by the period of a texture")
    options = parser.parse_args()
    if options.speed:
        speed()
        return
    if options.period:
        periods()
        return
    if options.bff is None:
        print("BFF is left out: --bff names its command", file=sys.stderr)
    warnings.simplefilter("ignore", OutcomeWarning)
    print("Each cell: F/3nt, L2 stretch, largest difference of the lengths of a seam edge's sides, flips.")
    print("BFF's time includes reading and writing files.\n" if options.bff else "")
    names = ["cones", "quarter cones", "free boundary"]
    names = [*(["BFF"] if options.bff else []), *names]
    print(f"| mesh | triangles | {' | '.join(f'{name} | CPU s' for name in names)} |")
    print("|---" * (2 + 2 * len(names)) + "|")
    for name, V, F in [stanford(), *shared("closed")]:
        cells = []
        handles = igl.euler_characteristic(F) < 2
        if options.bff and not handles:
            made, cones = by_bff(options.bff, V, F)
            cells.append(made)
        else:
            cones = find_cones(V, F, CONES)
            cells += ["- | -"] if options.bff else []
        seams = unwrap(V, F, cones=cones).seams  # and a warm-up
        for settings in ({"cones": cones}, {"cones": Cones(cones, angles="quarter")}, {"seams": seams}):
            start = process_time()
            atlas = unwrap(V, F, **settings)
            cells.append(cell(V, F, atlas.TC, atlas.FTC, process_time() - start))
        print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
