"""Unwrap the nasty meshes of tests/nasty_meshes.py with `unwrap` and with other programs.

    python benchmarks/nasty.py

The installed programs of `benchmarks/unwrap.py` are included. Each mesh runs in a child process of its own,
because a program may crash or hang. Prints Markdown.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from textwrap import shorten

import numpy as np
from peers import make_charts, peers

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from nasty_meshes import NASTY

from igl_linabf import MeshWarning, unwrap
from igl_linabf.measures.overlapping import find_overlapping_pairs

TIMEOUT = 60  # time limit per mesh in seconds, including the start of the program


def measure_atlas(m: int, charts: int, TC: np.ndarray, FTC: np.ndarray) -> str:
    """Return table cells: the number of charts, of faces without finite coordinates, and of overlaps."""
    corner = TC[FTC]
    a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    solid = FTC[np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) > 0]
    missing = m - int(np.isfinite(corner).all(axis=(1, 2)).sum())
    used, packed = np.unique(solid, return_inverse=True)
    over = len(find_overlapping_pairs(TC[used], packed.reshape(-1, 3), between=True)) if len(solid) else 0
    return f"{charts} | {missing} | {over}"


def our_cells(name: str) -> str:
    """Return the table cells of `unwrap`."""
    V, F = NASTY[name]()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        atlas = unwrap(V, F)
    repairs = ", ".join(f"{repair.kind} {repair.count:,}" for repair in atlas.report.repairs)
    flips = sum(chart.quality.flips for chart in atlas.charts)
    figures = measure_atlas(len(F), len(atlas.charts), atlas.TC, atlas.FTC)
    return f"{repairs} | {figures} | {flips} | {atlas.quality.stretch_l2:.3g}"


def peer_cells(program: str, name: str) -> str:
    """Return the table cells of another program; faces outside of its charts are at (0, 0)."""
    V, F = NASTY[name]()
    made = peers()[program](V, F)
    corner = made.TC[made.FTC]
    kept = made.FTC[np.isfinite(corner).all(axis=(1, 2)) & (corner != 0).any(axis=(1, 2))]
    charts = int(make_charts(kept).max()) + 1 if len(kept) else 0
    overlapping = measure_atlas(len(kept), charts, made.TC, kept).split(" | ")[2]
    return f"{charts} | {len(F) - len(kept)} | {overlapping}"


def run_in_child(*which: str) -> str:
    """Return the table cells that a child process prints, or how the process ended."""
    command = [sys.executable, "-W", "ignore", __file__, *which]
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, stdout=pipe, stderr=pipe, encoding="utf-8", start_new_session=True)
    try:
        printed, errors = process.communicate(timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        return f"more than {TIMEOUT} s | |"
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # also kills child processes, such as Blender
        process.communicate()
    if process.returncode:
        last = (errors.strip().splitlines() or [f"ended with {process.returncode}"])[-1]
        return f"{shorten(last, 60, placeholder=' ...')} | |"
    return printed.strip()


def main() -> None:
    print(
        "Lost faces have no finite texture coordinates or, for other programs, are outside of all charts\n"
        "at (0, 0). Lost faces include faces of zero area, which `unwrap` places on an edge of a\n"
        "neighbour. Overlaps are overlapping pairs of faces in the same chart or in two charts. `ended\n"
        "with -11` means a crash.\n"
    )
    heads = "mesh | triangles | repairs | charts | lost | overlaps | flips | L2 stretch"
    programs = list(peers())
    heads += "".join(f" | {program}: charts | lost | overlaps" for program in programs)
    print(f"| {heads} |\n|{'---|' * (heads.count('|') + 1)}")
    with ThreadPoolExecutor(2) as pool:
        made = {name: [pool.submit(run_in_child, program, name) for program in programs] for name in NASTY}
        for name, others in made.items():
            cells = [
                f"{name} | {len(NASTY[name]()[1]):,} | {our_cells(name)}",
                *(other.result() for other in others),
            ]
            print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(peer_cells(*sys.argv[1:]))
    else:
        main()
