"""Write a file repeatedly while faults occur: `python repeated_writing.py MODE FILE`.

The modes are "once", "kill" (a child process that writes is killed), "full" (no file may grow beyond a random
size, as on a full disk) and "two" (two processes write at once). After each fault, the file must contain one
of the two surfaces that are written alternately.
"""

from __future__ import annotations

import os
import signal
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from zipfile import ZipFile

import igl
import numpy as np

from igl_linabf.io import as_mesh_file, normalize_suffix, read_file, write_file

TRIALS = 20
SMALL = igl.icosahedron()
LARGE = igl.upsample(*SMALL, 3)


def write_one(path: Path, surface: tuple[np.ndarray, np.ndarray]) -> None:
    V, F = surface
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # formats that lose contents warn
        write_file(path, as_mesh_file(V, F), V[:, :2] - V[:, :2].min(axis=0))


def check_whole(path: Path) -> None:
    if path.suffix == ".3mf":  # after a fork, lib3mf generates the same UUIDs again and refuses them
        with ZipFile(path) as package:
            assert package.testzip() is None
            n = package.read("3D/3dmodel.model").count(b"<triangle ")
    else:
        n = len(read_file(path).polygons)
    assert n in (len(SMALL[1]), len(LARGE[1])), f"{path} has {n} faces"


def start(work: Callable[[], None]) -> int:
    """Run a function in a child process, and return the process id."""
    process = os.fork()
    if not process:
        try:
            work()
        finally:
            os._exit(0)
    return process


def write_forever(path: Path) -> None:
    while True:
        for surface in (SMALL, LARGE):
            write_one(path, surface)


def stop(process: int) -> None:
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)


def write_with_limit(path: Path, size: int) -> None:
    import resource

    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
    for surface in (SMALL, LARGE):
        try:
            write_one(path, surface)
        except (OSError, RuntimeError):  # packages raise RuntimeError
            continue


def main() -> None:
    mode, path, rng = sys.argv[1], Path(sys.argv[2]), np.random.default_rng(0)
    write_one(path.with_name(f"warm{normalize_suffix(path)}"), SMALL)  # imports the packages before the fork
    write_one(path, LARGE)
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    size = path.stat().st_size
    others = [start(lambda: write_forever(path)) for _ in range(2 * (mode == "two"))]
    try:
        for _ in range(TRIALS * (mode != "once")):
            if mode == "kill":
                process = start(lambda: write_forever(path))
                time.sleep(rng.uniform(0, 0.1))
                stop(process)
            elif mode == "full":
                limit = int(rng.integers(100, size))
                os.waitpid(start(lambda limit=limit: write_with_limit(path, limit)), 0)
            else:
                time.sleep(0.02)
            check_whole(path)
    finally:  # the child processes would never end
        for process in others:
            stop(process)
    check_whole(path)


if __name__ == "__main__":
    main()
