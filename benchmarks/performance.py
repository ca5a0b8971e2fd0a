"""Write the figures of docs/performance.md: relative times, stages, memory, growth, other programs.

    python benchmarks/performance.py [--repeat 7] [--cpu] [--largest 2] [--build-peers FOLDER] [--print]
    python benchmarks/performance.py --huge [--cpu] [--print]

All methods alternate in one process, after a warm-up. Each ratio is a ratio of medians, with the 95 %
interval of 2,000 bootstrap samples. Time is wall time including the checks of the input.

--cpu uses CPU time, for a busy machine. --largest N subdivides face N times (4^N x 52 k triangles). --huge
instead measures linabf up to 5.8 million triangles, each mesh in a separate process (small meshes in five),
and fits the exponent of the time for each surface; this takes 6 GB and about three minutes. --build-peers
compiles BFF from its sources in FOLDER with cmake. --print prints the tables instead of writing the page.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from functools import partial
from importlib import metadata
from importlib.util import find_spec
from io import StringIO
from math import isqrt
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from bff_peer import Bff
from many import disk
from meshes import Mesh, brain, load_shared_meshes, split_triangles, subdivide
from pages import arguments, publish
from scipy.stats import bootstrap

import igl_linabf as il
from igl_linabf._core import BUILD
from igl_linabf.flattening import make_lscm_call, other_programs
from igl_linabf.linalg import has_cholmod
from igl_linabf.surface import planar_mesh

STAGES = ("check", "estimate", "assembly", "analysis", "factor", "solve", "layout")
NATURAL = (
    "igl_camel_b",
    "optcuts_foot_i_f10000",
    "optcuts_lion_o_f10000",
    "igl_lion",
    "igl_camelhead",
    "igl_face",
)
GROWN = "igl_face"
# number of pieces into which each triangle is split
HUGE = {GROWN: (1, 4, 16, 64, 100), "igl_camelhead": (4, 16, 64, 256)}
TURNS, FEW = 5, 10  # surfaces with fewer than FEW pieces per triangle are timed in TURNS processes
LARGE = 400_000  # above this number of triangles, only three runs, and no other programs
Call = Callable[[], object]


def choose_meshes(largest: int) -> Iterator[Mesh]:
    """Yield meshes of 500 triangles and more."""
    yield "random disk", *disk(500, 0)
    meshes = {mesh[0]: mesh for mesh in load_shared_meshes("disk") if mesh[0] in NATURAL}
    meshes["cortex"] = brain()
    yield from sorted(meshes.values(), key=lambda mesh: len(mesh[2]))
    if "igl_camelhead" in meshes:
        yield subdivide(meshes["igl_camelhead"], 1)
    for times in range(1, largest + 1):
        if GROWN in meshes:
            yield subdivide(meshes[GROWN], times)


def make_calls(V: np.ndarray, F: np.ndarray) -> dict[str, Call]:
    """Return the calls to be timed, by the name of the method."""
    flattener = il.Flattener(F)
    methods: dict[str, Call] = {
        "igl.lscm": make_lscm_call(planar_mesh(V, F)),
        "linabf": partial(il.flatten, V, F),
        "abf": partial(il.flatten, V, F, method="abf"),
        "the next of a Flattener": partial(flattener.flatten, V),
    }
    if has_cholmod():
        methods["linabf by CHOLMOD"] = partial(il.flatten, V, F, method=il.LinABF(solver="cholmod"))
    return methods


def time_calls(methods: dict[str, Call], repeat: int, clock: Callable[[], float]) -> dict[str, np.ndarray]:
    """Return the seconds of each call; the calls alternate."""
    seconds: dict[str, list[float]] = {name: [] for name in methods}
    for k in range(repeat + 1):
        for name, call in methods.items():
            start = clock()
            call()
            if k:  # the first run is a warm-up
                seconds[name].append(clock() - start)
    return {name: np.array(taken) for name, taken in seconds.items()}


def ratio(ours: np.ndarray, theirs: np.ndarray) -> str:
    """Return the ratio of the medians with its 95 % interval, as text."""

    def ratio_of_medians(a: np.ndarray, b: np.ndarray, axis: int) -> np.ndarray:
        return np.median(a, axis=axis) / np.median(b, axis=axis)

    found = bootstrap(
        (ours, theirs), ratio_of_medians, n_resamples=2000, method="percentile", vectorized=True, rng=0
    )
    low, high = found.confidence_interval
    return f"**{np.median(ours) / np.median(theirs):.2f}** ({low:.2f} to {high:.2f})"


def measure_peak(name: str, what: str) -> tuple[int, float, float, int]:
    """Return triangles, CPU seconds, wall seconds and growth in bytes, measured in a separate process."""
    code = f"import performance; performance.print_growth({name!r}, {what!r})"
    folder = Path(__file__).parent
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        capture_output=True,
        encoding="utf-8",
        check=True,
        env=os.environ,
    )
    triangles, cpu, wall, growth = done.stdout.split()[-4:]
    return int(triangles), float(cpu), float(wall), int(growth)


def print_growth(name: str, what: str) -> None:
    """Print the numbers that `measure_peak` returns, for this process."""
    warnings.simplefilter("ignore")
    pieces = int(name.partition(", ")[2].removesuffix(" x") or 1)
    with redirect_stdout(StringIO()):
        (mesh,) = (mesh for mesh in load_shared_meshes("disk") if mesh[0] == name.partition(",")[0])
        _, V, F = split_triangles(mesh, isqrt(pieces))
        small = disk(4_000, 0)
        call = {"igl.lscm": make_lscm_call(planar_mesh(V, F))}.get(what) or partial(
            il.flatten, V, F, method=what
        )
        for method in ("lscm", "linabf", "abf"):
            il.flatten(*small, method=method)  # warm-up, which includes lazy imports
    Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")  # reset the peak memory of the process
    before, cpu, wall = peak_memory(), process_time(), perf_counter()
    call()
    print(len(F), process_time() - cpu, perf_counter() - wall, peak_memory() - before)


def peak_memory() -> int:
    """Return the peak memory of this process in bytes."""
    status = dict(
        line.split(":") for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    )
    return 1024 * int(status["VmHWM"].split()[0])


def describe_machine() -> str:
    """Return processor, system and versions as text."""
    model, cpuinfo = platform.processor(), Path("/proc/cpuinfo")
    if cpuinfo.exists():
        lines = [
            line for line in cpuinfo.read_text(encoding="utf-8").splitlines() if line.startswith("model name")
        ]
        model = lines[0].partition(":")[2].strip() if lines else model
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in ("libigl", "numpy", "scipy"))
    return (
        f"{model}, {os.cpu_count()} cores, {platform.system()}; Python {platform.python_version()}, "
        f"{versions}; core: {BUILD}"
    )


def time_peers(V: np.ndarray, F: np.ndarray, bff: Bff | None, cpu: bool) -> dict[str, float]:
    """Return the seconds of other programs in separate processes; NaN after a failure or a timeout.

    CPU times are available for BFF only.
    """
    times: dict[str, float] = {}
    programs: dict[tuple[str, ...], Callable[[], tuple[float, ...]]] = {
        (name,): partial(time_program, name, V, F)
        for name in ([] if cpu else other_programs.list_installed_programs())
    }
    if find_spec("mouette") and not cpu:
        programs["mouette BFF",] = lambda: (time_mouette(V, F),)
    if bff is not None:
        programs["BFF, core", "BFF, with its mesh"] = lambda: bff.measure_seconds(V, F, cpu)
    for names, seconds in programs.items():
        try:
            taken = seconds()
        except (RuntimeError, subprocess.SubprocessError) as error:
            taken = (np.nan,) * len(names)
            print(f"{names[0]}: {error}", file=sys.stderr)
        times |= dict(zip(names, taken, strict=True))
    return times


def time_program(name: str, V: np.ndarray, F: np.ndarray) -> tuple[float]:
    return (other_programs.run_program(name, V, F)[1],)


def time_mouette(V: np.ndarray, F: np.ndarray) -> float:
    import mouette

    raw = mouette.mesh.RawMeshData()
    raw.vertices += V.tolist()
    raw.faces += F.tolist()
    mesh = mouette.mesh.SurfaceMesh(raw)
    start = perf_counter()
    mouette.parametrization.BoundaryFirstFlattening(mesh, verbose=False).run()
    return perf_counter() - start


def main() -> None:
    parser = arguments(__doc__, 7)
    parser.add_argument("--cpu", action="store_true")
    parser.add_argument("--largest", type=int, default=2)
    parser.add_argument("--huge", action="store_true")
    parser.add_argument("--build-peers", type=Path, metavar="FOLDER")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    command = " ".join(["python benchmarks/performance.py", *sys.argv[1:]])
    summary = (
        f"`{command}`\n\nTime {'of the processor' if options.cpu else 'on the wall'}. {describe_machine()}."
    )
    mark, text = (
        ("millions", measure_millions(options.cpu)) if options.huge else ("figures", measure_ratios(options))
    )
    page = f"{summary}\n\n{text}"
    publish(mark, page, options.printed)


def measure_ratios(options: argparse.Namespace) -> str:
    """Return the tables of times relative to `igl.lscm`, stages, growth, memory and other programs."""
    bff = None if options.build_peers is None else Bff.build(options.build_peers)
    clock = process_time if options.cpu else perf_counter
    figures = Figures()
    for mesh in choose_meshes(options.largest):
        figures.measure(mesh, options.repeat, clock, bff)
    return figures.text(GROWN if not options.largest else f"{GROWN}, {4**options.largest} x")


@dataclass
class Figures:
    """Rows of the tables of measurements, one per mesh."""

    columns: list[str] = field(default_factory=list)
    times: list[str] = field(default_factory=list)
    shares: list[str] = field(default_factory=list)
    peers: list[tuple[str, dict[str, float]]] = field(default_factory=list)
    growth: dict[int, dict[str, float]] = field(default_factory=dict)

    def measure(self, mesh: Mesh, repeat: int, clock: Callable[[], float], bff: Bff | None) -> None:
        name, V, F = mesh
        print(f"{name}, {len(F):,} triangles", file=sys.stderr, flush=True)
        taken = time_calls(make_calls(V, F), 3 if len(F) > LARGE else repeat, clock)
        base = taken.pop("igl.lscm")
        self.columns = list(taken)
        cells = " | ".join(ratio(values, base) for values in taken.values())
        self.times.append(f"| {name} | {len(F):,} | {1000 * np.median(base):.3g} | {cells} |")
        if name.startswith(GROWN):
            self.growth[len(F)] = {what: float(np.median(values)) for what, values in taken.items()}
        results = [il.flatten(V, F).seconds for _ in range(3)]
        share = [float(np.median([r[s] / r["total"] for r in results])) for s in STAGES]
        cells = " | ".join(f"{value:.0%}" for value in [*share, 1 - sum(share)])
        self.shares.append(f"| {name} | {cells} |")
        if len(F) <= LARGE:
            theirs = time_peers(V, F, bff, clock is process_time)
            self.peers.append((name, {peer: seconds / np.median(base) for peer, seconds in theirs.items()}))

    def text(self, largest: str) -> str:
        parts = [
            make_table(
                "Time over `igl.lscm`", ["mesh", "triangles", "igl.lscm, ms", *self.columns], self.times
            )
        ]
        parts.append(make_table("Where `linabf` spends its time", ["mesh", *STAGES, "other"], self.shares))
        if len(self.growth) > 1:
            lines = [
                "## Growth\n",
                "The time grows like the number of triangles to the following power, measured on "
                f"{GROWN} and its subdivisions:\n",
            ]
            for what in self.columns:
                x, y = np.log([[size, row[what]] for size, row in self.growth.items()]).T
                lines.append(f"- {what}: {np.polyfit(x, y, 1)[0]:.2f}")
            parts.append("\n".join(lines))
            if platform.system() == "Linux":
                methods = ("igl.lscm", "linabf", "abf")
                cells = " | ".join(f"{measure_peak(largest, method)[-1] / 1e9:.2f} GB" for method in methods)
                parts.append(
                    make_table("Memory at the peak", ["mesh", *methods], [f"| {largest} | {cells} |"])
                )
        names = sorted({peer for _, row in self.peers for peer in row})
        if names:
            rows = [
                f"| {name} | {' | '.join(f'{row.get(peer, np.nan):.3g}' for peer in names)} |"
                for name, row in self.peers
            ]
            parts.append(
                make_table("Other programs, over `igl.lscm`", ["mesh", *names], rows).replace("nan", "-")
            )
        return "\n\n".join(parts)


def measure_millions(cpu: bool) -> str:
    """Return time, memory and exponents of `linabf` for up to 5.8 million triangles."""
    rows, lines = [], []
    for surface, pieces in HUGE.items():
        times = []
        for count in pieces:
            name = f"{surface}, {count} x" if count > 1 else surface
            print(name, file=sys.stderr, flush=True)
            turns = [measure_peak(name, "linabf") for _ in range(TURNS if count < FEW else 1)]
            triangles, cpu_seconds, wall, growth = np.median(turns, axis=0)
            seconds = cpu_seconds if cpu else wall
            times.append((int(triangles), seconds))
            rows.append(f"| {name} | {times[-1][0]:,} | {seconds:.3g} s | {growth / 1e9:.2f} GB |")
        exponent = np.polyfit(*np.log(times).T, 1)[0]
        lines.append(f"- {surface}: {exponent:.2f}, from {times[0][0]:,} to {times[-1][0]:,}")
    rows_table = make_table(
        "Millions of triangles", ["mesh", "triangles", "linabf", "memory at the peak"], rows
    )
    summary = "The time grows like the number of triangles to the following power:"
    return "\n\n".join([rows_table, summary, "\n".join(lines)])


def make_table(title: str, columns: Sequence[str], rows: list[str]) -> str:
    head = f"## {title}\n\n| {' | '.join(columns)} |\n{'|---' * len(columns)}|"
    return "\n".join([head, *rows])


if __name__ == "__main__":
    main()
