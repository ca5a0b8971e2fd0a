"""Cones: linear ABF and boundary first flattening (BFF) on the same ones, and a free boundary.

    python benchmarks/cones.py [--bff bff-command-line]
    python benchmarks/cones.py --speed

`--bff` names the command of https://github.com/GeometryCollective/boundary-first-flattening, which chooses
the cones. Without it `find_cones` does, and the columns of BFF are missing. The meshes are the Stanford
bunny and those of kind `closed` in IGL_LINABF_MESHES. Prints Markdown. `--speed` prints the time of
a map of the bunny with cones over that of `flatten` on the same surface cut, without and with finding the
seam and cutting along it.
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
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median
from time import process_time

import igl
import numpy as np
from meshes import shared, stanford

from igl_linabf import LinABF, OutcomeWarning, find_cones, flatten, quality, unwrap
from igl_linabf.charts.cone_seams import seam_through
from igl_linabf.charts.coned import _flattened as unwrapped
from igl_linabf.charts.cones import CONE_TRADE, ConePiece, angles_of, found_on
from igl_linabf.charts.given_seams import textured_seams
from igl_linabf.flattening import flatten_with_cones
from igl_linabf.io import read_mesh, read_texture
from igl_linabf.surface import Submesh, planar_mesh

CONES = 16


def cell(V: np.ndarray, F: np.ndarray, TC: np.ndarray, FTC: np.ndarray, seconds: float) -> str:
    """What is measured of a map: distortion, stretch, seam sides, flips, time."""
    origin = np.empty(len(TC), dtype=np.int64)
    origin[FTC] = F
    used = np.unique(FTC)
    packed = np.searchsorted(used, FTC)
    q = quality(V[origin[used]], packed, TC[used])
    mismatch = textured_seams(Submesh.checked(V, F).topology, TC, FTC)[1]
    return (
        f"{q.angle_distortion:.2e}, {q.stretch_l2:.3g}, {np.expm1(mismatch):.0e}, {q.flips} | {seconds:.2f}"
    )


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
    """Print how many times the time of `flatten` cones take: medians of turns, CPU seconds of one thread."""
    print("| mesh | triangles | cones | with the cutting | quarter cones | with the cutting |")
    print("|---|---|---|---|---|---|")
    for name, V, F in (stanford(),):
        component = Submesh.checked_manifold(V, F).components()[0]
        place = ConePiece(component)
        cones = found_on(place, CONES, CONE_TRADE)
        node = place.piece.node[cones]
        (cut,) = component.cut_along(component.vertices[place.piece.edges[seam_through(place.piece, node)]])
        mesh = replace(planar_mesh(cut), vertices=np.arange(len(cut.V)), n_given=len(cut.V))
        cells = []
        for wanted in (None, "quarter"):
            sums = np.where(component.topology.interior, 2 * np.pi, np.nan)
            sums[cones] = angles_of(place, cones, wanted)
            calls = (
                partial(flatten, cut.V, cut.F),
                partial(flatten_with_cones, mesh, component.topology, sums, (), bool(wanted), LinABF()),
                partial(unwrapped, place, cones, sums[cones], bool(wanted), LinABF()),
            )
            free, coned, whole = cpu_medians(calls)
            cells += [f"{coned / free:.2f}", f"{whole / free:.2f}"]
        print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


def cpu_medians(calls: Sequence[Callable[[], object]], repeat: int = 5) -> list[float]:
    """Median CPU seconds of each call, after one that is not timed; they take turns."""
    seconds: list[list[float]] = [[] for _ in calls]
    for _ in range(repeat + 1):
        for call, taken in zip(calls, seconds, strict=True):
            start = process_time()
            call()
            taken.append(process_time() - start)
    return [median(taken[1:]) for taken in seconds]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--bff", help="the command of boundary first flattening")
    parser.add_argument("--speed", action="store_true", help="the time of cones over that of a free boundary")
    options = parser.parse_args()
    if options.speed:
        speed()
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
        for settings in ({"cones": cones}, {"cones": cones, "cone_angles": "quarter"}, {"seams": seams}):
            start = process_time()
            atlas = unwrap(V, F, **settings)
            cells.append(cell(V, F, atlas.TC, atlas.FTC, process_time() - start))
        print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
