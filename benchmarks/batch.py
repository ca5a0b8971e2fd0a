"""Measure a batch: scaling to two workers, overhead per mesh, loss of a worker, cost of a million meshes.

    python benchmarks/batch.py [--meshes 1000] [--largest 50000] [--rounds 4] [--small 200] [--lossy 200]

The meshes are all meshes of IGL_LINABF_MESHES with at least 500 triangles, and random disks and spheres of
500 to 50,000 triangles. Each round unwraps a part of the meshes on one worker and on two workers. Some meshes
go to a cluster that loses a worker. A thousand meshes take about eight minutes on two cores. Prints Markdown.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter, process_time, sleep

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")  # one thread, as in the workers of a batch

import igl
import numpy as np
from distributed import Client
from meshes import load_shared_meshes
from scipy.spatial import ConvexHull, Delaunay

from igl_linabf import unwrap
from igl_linabf.batch import flatten_files
from igl_linabf.io import read_mesh, write_mesh

SMALLEST = 500  # triangles of the smallest mesh
KINDS = ("disk", "holes", "closed", "handles", "stress")
CLASSES = (1_000, 10_000, 50_000)  # triangles per mesh in the table of costs


def make_random_disk(triangles: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return a triangulation of random points of the unit disk, lifted by waves."""
    n = triangles // 2 + 1
    radius, angle = np.sqrt(rng.uniform(0, 1, n)), rng.uniform(0, 2 * np.pi, n)
    xy = np.column_stack((radius * np.cos(angle), radius * np.sin(angle)))
    rim = np.linspace(0, 2 * np.pi, int(4 * np.sqrt(n)), endpoint=False)
    xy = np.concatenate((0.98 * xy, np.column_stack((np.cos(rim), np.sin(rim)))))
    F = Delaunay(xy).simplices.astype(np.int64)
    (x0, y0), (x1, y1), (x2, y2) = (xy[F[:, k]].T for k in range(3))
    flipped = (x1 - x0) * (y2 - y0) < (x2 - x0) * (y1 - y0)
    F[flipped] = F[flipped][:, [0, 2, 1]]
    z = 0.1 * np.sin(xy @ rng.normal(size=(2, 5)) * 4 + rng.uniform(0, 6, 5)).sum(axis=1)
    return np.column_stack((xy, z)), F


def sphere(triangles: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return a triangulation of random points of the sphere, displaced by waves."""
    V = rng.normal(size=(triangles // 2 + 2, 3))
    V /= np.linalg.norm(V, axis=1)[:, None]
    F = ConvexHull(V).simplices.astype(np.int64)
    flipped = (
        np.einsum("ij,ij->i", np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]]), V[F[:, 0]]) < 0
    )
    F[flipped] = F[flipped][:, [0, 2, 1]]
    waves = np.sin(V @ rng.normal(size=(3, 5)) * 3 + rng.uniform(0, 6, 5)).sum(axis=1)
    return V * (1 + 0.05 * waves)[:, None], F


def write_meshes(folder: Path, count: int, largest: int) -> list[Path]:
    """Write the available real meshes and random meshes to files; return the paths in random order."""
    rng = np.random.default_rng(0)
    meshes = [(V, F) for _, V, F in load_shared_meshes(*KINDS) if SMALLEST <= len(F) <= largest][:count]
    real = len(meshes)
    sizes = np.exp(rng.uniform(np.log(SMALLEST), np.log(largest), count - real)).astype(int)
    meshes += [(make_random_disk if k % 2 else sphere)(int(size), rng) for k, size in enumerate(sizes)]
    paths = [folder / f"{k}.obj" for k in rng.permutation(len(meshes))]
    for path, (V, F) in zip(paths, meshes, strict=True):
        igl.write_triangle_mesh(str(path), V, F)
    total = sum(len(F) for _, F in meshes)
    print(f"{real} real meshes, {count - real} generated meshes; {total:,} triangles in all.\n", flush=True)
    return paths


def print_scaling(folder: Path, paths: list[Path], rounds: int) -> None:
    """Print the time on one worker, on two workers, and their ratio.

    Busy is the share of time during which the workers process a mesh. If other programs use the cores, this
    share is more meaningful than the ratio.
    """
    print(
        "| meshes | one worker, s | busy | two workers, s | busy | ratio |\n|---|---|---|---|---|---|",
        flush=True,
    )
    totals = np.zeros((2, 2))  # seconds and busy seconds, for one worker and for two
    for k in range(rounds):
        part, seconds = paths[k::rounds], np.zeros((2, 2))
        for workers in (1, 2):
            done = flatten_files(part, folder / f"{workers}", workers=workers, progress=False)
            seconds[workers - 1] = done.seconds, sum(row.seconds or 0 for row in done.rows) / workers
        totals += seconds
        _print_ratio(len(part), seconds)
    _print_ratio(len(paths), totals)
    print()


def _print_ratio(count: int, seconds: np.ndarray) -> None:
    (one, one_busy), (two, two_busy) = seconds
    cells = f"{one:.1f} | {one_busy / one:.0%} | {two:.1f} | {two_busy / two:.0%} | {one / two:.2f}"
    print(f"| {count} | {cells} |", flush=True)


def print_overhead(folder: Path, count: int) -> None:
    """Print the additional time per mesh on a worker, compared with a loop, for the smallest meshes."""
    rng = np.random.default_rng(1)
    (folder / "small").mkdir()
    paths = [folder / "small" / f"{k}.obj" for k in range(count)]
    for path in paths:
        igl.write_triangle_mesh(str(path), *make_random_disk(SMALLEST, rng))
    differences, loops = [], []
    for k in range(3):
        start = perf_counter()
        for path in paths:
            V, F = read_mesh(path)
            atlas = unwrap(V, F, progress=False)
            write_mesh(folder / "loop.obj", V, F, atlas.TC, atlas.FTC)
        loops.append((perf_counter() - start) / count)
        done = flatten_files(paths, folder / f"small {k}", workers=1, progress=False)
        differences.append(done.seconds / count - loops[-1])
    print(
        f"Overhead per mesh, compared with a plain loop: {1e3 * statistics.median(differences):.1f} ms "
        f"(the loop: {1e3 * statistics.median(loops):.1f} ms per mesh; {count} meshes, median of 3 runs).\n",
        flush=True,
    )


@contextmanager
def start_cluster(folder: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """Run a scheduler and two workers on the loopback interface; yield the address and the workers."""
    address, log = folder / "scheduler.json", open(folder / "dask.log", "wb")  # noqa: SIM115
    environment = {**os.environ, "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}

    def start(command: str) -> subprocess.Popen[bytes]:
        line = f"-m dask {command} --scheduler-file {address} --host 127.0.0.1".split()
        return subprocess.Popen(
            [sys.executable, *line], stdout=log, stderr=log, start_new_session=True, env=environment
        )

    started = [start("scheduler --port 0 --no-dashboard")]
    try:
        while not address.exists() or not address.read_text().strip().endswith("}"):
            sleep(0.1)
        started += [start(f"worker --nthreads 1 --local-directory {folder}") for _ in range(2)]
        scheduler_address = json.loads(address.read_text())["address"]
        with Client(scheduler_address, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=120)
        yield scheduler_address, started[1:]
    finally:
        for process in started[::-1]:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        log.close()


def print_loss(folder: Path, paths: list[Path]) -> None:
    """Kill one of two workers half-way through a batch, and print the outcomes of the meshes."""
    out, killed = folder / "cluster", []
    with start_cluster(folder) as (address, workers):

        def kill_worker(_: str, share: float) -> None:
            if share >= 0.5 and not killed:
                killed.append(share)
                os.killpg(workers[0].pid, signal.SIGKILL)  # kills the nanny process of the worker as well

        done = flatten_files(paths, out, scheduler=address, progress=kill_worker)
        assert workers[0].poll() is not None or workers[0].wait(10)
        assert workers[1].poll() is None
    with open(out / "results.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    inputs = [row["input"] for row in rows]
    maps = {path.name for path in out.glob("*.obj")}
    lost = len({str(path) for path in paths} - set(inputs)) + sum(row["outcome"] == "waiting" for row in rows)
    duplicates = len(inputs) - len(set(inputs))
    unmatched = {row["output"] for row in rows if row["charts"]} ^ maps
    for name in maps:
        read_mesh(out / name)  # raises an error if the file is incomplete
    outcome_counts = Counter(row.outcome for row in done.rows)
    outcomes = ", ".join(f"{n} {outcome}" for outcome, n in outcome_counts.items())
    print(
        f"Two workers of a scheduler, one of them killed after {killed[0]:.0%} of {len(paths)} meshes: "
        f"{len(rows)} rows ({outcomes}), {len(maps)} maps; {lost} lost, {duplicates} duplicates, "
        f"{len(unmatched)} maps without a row or rows without a map.\n",
        flush=True,
    )


def print_cost(folder: Path) -> None:
    """Print the cost of a million meshes, extrapolated from the CPU time of a few meshes."""
    rng = np.random.default_rng(2)
    print("| triangles per mesh | core seconds per mesh | core hours for a million meshes |\n|---|---|---|")
    for size in CLASSES:
        seconds = []
        for make in (make_random_disk, sphere) * 3:
            path = folder / "one.obj"
            igl.write_triangle_mesh(str(path), *make(size, rng))
            start = process_time()
            V, F = read_mesh(path)
            atlas = unwrap(V, F, progress=False)
            write_mesh(path, V, F, atlas.TC, atlas.FTC)
            seconds.append(process_time() - start)
        mean = statistics.fmean(seconds)
        print(f"| {size:,} | {mean:.3g} | {mean * 1e6 / 3600:,.0f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--meshes", type=int, default=1000)
    parser.add_argument("--largest", type=int, default=50_000)
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--small", type=int, default=200)
    parser.add_argument("--lossy", type=int, default=200)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "in").mkdir()
        paths = write_meshes(folder / "in", options.meshes, options.largest)
        print_overhead(folder, options.small)
        print_loss(folder, paths[: options.lossy])  # the paths are in random order
        print_scaling(folder, paths, options.rounds)
        print_cost(folder)


if __name__ == "__main__":
    main()
