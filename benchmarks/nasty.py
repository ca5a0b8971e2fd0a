"""Nasty meshes (tests/nasty_meshes.py): what `unwrap` makes of them, beside other programs.

    python benchmarks/nasty.py

The programs are those of `benchmarks/unwrap.py` that are installed. Each runs in a child process for each
mesh, as it may crash or hang. Prints Markdown.
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
from peers import charts_of, peers

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from nasty_meshes import NASTY

from igl_linabf import MeshWarning, unwrap
from igl_linabf.measures.overlapping import overlapping_pairs

LIMIT = 60  # seconds for a mesh, of which most pass until a program is loaded


def measured(m: int, charts: int, TC: np.ndarray, FTC: np.ndarray) -> str:
    """Charts; faces without finite coordinates; faces of an area; overlaps, of all faces with one."""
    corner = TC[FTC]
    a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    solid = FTC[np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) > 0]
    missing = m - int(np.isfinite(corner).all(axis=(1, 2)).sum())
    used, packed = np.unique(solid, return_inverse=True)
    over = len(overlapping_pairs(TC[used], packed.reshape(-1, 3), between=True)) if len(solid) else 0
    return f"{charts} | {missing} | {over}"


def ours(name: str) -> str:
    V, F = NASTY[name]()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        atlas = unwrap(V, F)
    repairs = ", ".join(f"{repair.kind} {repair.count:,}" for repair in atlas.repairs)
    flips = sum(chart.quality.flips for chart in atlas.charts)
    figures = measured(len(F), len(atlas.charts), atlas.TC, atlas.FTC)
    return f"{repairs} | {figures} | {flips} | {atlas.quality.stretch_l2:.3g}"


def by_peer(program: str, name: str) -> str:
    """What another program makes of it. It puts faces that it leaves out of its charts at (0, 0)."""
    V, F = NASTY[name]()
    made = peers()[program](V, F)
    corner = made.TC[made.FTC]
    kept = made.FTC[np.isfinite(corner).all(axis=(1, 2)) & (corner != 0).any(axis=(1, 2))]
    charts = int(charts_of(kept).max()) + 1 if len(kept) else 0
    overlapping = measured(len(kept), charts, made.TC, kept).split(" | ")[2]
    return f"{charts} | {len(F) - len(kept)} | {overlapping}"


def in_a_child(*which: str) -> str:
    command = [sys.executable, "-W", "ignore", __file__, *which]
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, stdout=pipe, stderr=pipe, encoding="utf-8", start_new_session=True)
    try:
        printed, said = process.communicate(timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return f"more than {LIMIT} s | |"
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # Blender runs in a process of its own
        process.communicate()
    if process.returncode:
        last = (said.strip().splitlines() or [f"ended with {process.returncode}"])[-1]
        return f"{shorten(last, 60, placeholder=' ...')} | |"
    return printed.strip()


def main() -> None:
    print(
        "Lost: faces without finite coordinates; of other programs, those in no chart, put at (0, 0).\n"
        "Faces without area, which `unwrap` puts on an edge of their neighbour, are among those. Overlaps:\n"
        "pairs of faces, of the same chart or of two. `ended with -11`: the process crashed.\n"
    )
    heads = "mesh | triangles | repairs | charts | lost | overlaps | flips | L2 stretch"
    programs = list(peers())
    heads += "".join(f" | {program}: charts | lost | overlaps" for program in programs)
    print(f"| {heads} |\n|{'---|' * (heads.count('|') + 1)}")
    with ThreadPoolExecutor(2) as pool:
        made = {name: [pool.submit(in_a_child, program, name) for program in programs] for name in NASTY}
        for name, others in made.items():
            cells = [
                f"{name} | {len(NASTY[name]()[1]):,} | {ours(name)}",
                *(other.result() for other in others),
            ]
            print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(by_peer(*sys.argv[1:]))
    else:
        main()
