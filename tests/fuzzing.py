"""Run hostile cases in a child process, so that a crash or a hang is attributed to its case.

`python tests/fuzzing.py CASES.json ENDS.txt SECONDS` is the child process. It writes the outcome of each
case. A script with other cases can act as a child process, too: see `run_as_child`.
"""

from __future__ import annotations

import ctypes
import faulthandler
import json
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import hostile_files as files
import hostile_formats as formats
import hostile_meshes as meshes
import numpy as np

LIMIT = 240.0  # seconds, also on a busy machine, after which a case counts as a hang
ROOT = Path(__file__).parent.parent


def _disk(seed: int, most: int = 250) -> meshes.Disk:
    return meshes.Disk.random(np.random.default_rng(seed), most)


# kind of case: (function that checks the case of a seed, number of such cases among ten thousand)
KINDS: dict[str, tuple[Callable[[int], str], int]] = {
    "`flatten`, random disks": (lambda seed: meshes.check_disk(_disk(seed)), 2500),
    '`flatten`, `method="abf"`': (lambda seed: meshes.check_disk(_disk(seed), "abf"), 700),
    '`flatten`, `guarantee="injective"`': (meshes.check_guarantee, 500),
    "`flatten`, the other methods": (meshes.check_method, 600),
    "`flatten`, random options and pins": (meshes.check_options, 700),
    "`flatten`, dtypes, orders, strides": (meshes.check_dtypes, 400),
    "`flatten` and `unwrap`, corrupted meshes": (meshes.check_corrupted, 1400),
    "`unwrap`, disks, holes, spheres": (lambda seed: meshes.check_unwrap(_disk(seed, 60)), 400),
    "`unwrap`, any triangles": (meshes.check_any, 1000),
    "`unwrap`, mixtures of nasty and real meshes": (meshes.check_nasty, 1000),
    "`quality`, `overlaps`, `layout`, `cut`": (meshes.check_map, 500),
    "damaged files, `igl-linabf flatten`": (lambda seed: files.check_file(seed, "flatten"), 1200),
    "damaged files, `igl-linabf compare`": (lambda seed: files.check_file(seed, "compare"), 500),
    "damaged files, `igl-linabf unwrap`": (lambda seed: files.check_file(seed, "unwrap"), 600),
    "hostile descriptions of glTF, read and written": (formats.check_description, 1500),
    "damaged GLB, 3MF, VTP, GIFTI and FreeSurfer, read and written": (formats.check_format, 700),
}


def _break_promise(seed: int) -> str:
    raise meshes.BrokenError(str(seed))


# cases that the test harness must detect
BROKEN: dict[str, Callable[[int], str]] = {
    "to crash": lambda seed: ctypes.string_at(0).decode(),
    "to hang": lambda seed: str(time.sleep(1000)),
    "to break a promise": _break_promise,
}


def run(kind: str, seeds: range) -> tuple[Counter[str], list[str]]:
    """Run cases of one kind; return the counts of the outcomes, and each case that breaks a promise."""
    return run_all([(kind, seed) for seed in seeds])[kind]


def run_all(
    cases: list[tuple[str, int]], script: str = __file__, limit: float | None = None
) -> dict[str, tuple[Counter[str], list[str]]]:
    """Run cases of several kinds like `run`; a new child process continues after each crash."""
    ends: dict[str, tuple[Counter[str], list[str]]] = {kind: (Counter(), []) for kind, _ in cases}
    while cases:
        with tempfile.TemporaryDirectory() as folder:
            todo, done = Path(folder) / "cases.json", Path(folder) / "ends.txt"
            todo.write_text(json.dumps(cases))
            child = subprocess.run(
                [sys.executable, script, str(todo), str(done), str(limit or LIMIT)],
                cwd=ROOT,
                capture_output=True,
                encoding="utf-8",
                errors="replace",
            )
            ends_of_cases = (
                [json.loads(line) for line in done.read_text().splitlines()] if done.exists() else []
            )
        for (kind, seed), (good, end) in zip(cases, ends_of_cases, strict=False):
            count, broken = ends[kind]
            if good:
                count[end] += 1
            else:
                broken.append(f"{kind}, seed {seed}: {end}")
        remaining = cases[len(ends_of_cases) :]
        if remaining:
            kind, seed = remaining[0]
            what = f"the process ended with {child.returncode}: {child.stderr[:1000]}"
            ends[kind][1].append(f"{kind}, seed {seed}: {what}")
        cases = remaining[1:]
    return ends


def run_as_child(checks: dict[str, Callable[[int], str]]) -> None:
    """Run the cases that the command line names, and write the outcome of each."""
    todo, done, limit = sys.argv[1:]
    faulthandler.enable()
    with open(done, "w", encoding="utf-8") as file:
        for kind, seed in json.loads(Path(todo).read_text(encoding="utf-8")):
            faulthandler.dump_traceback_later(float(limit), exit=True)
            try:
                end = (True, checks[kind](seed))
            except Exception as error:  # every error is an outcome of the case
                trace = error.__traceback__
                while trace is not None and trace.tb_next is not None:
                    trace = trace.tb_next
                place = f"{Path(trace.tb_frame.f_code.co_filename).name}:{trace.tb_lineno}" if trace else ""
                end = (False, f"{type(error).__name__}: {error} ({place})")
            file.write(json.dumps(end) + "\n")
            file.flush()


if __name__ == "__main__":
    run_as_child({**BROKEN, **{kind: check for kind, (check, _) in KINDS.items()}})
