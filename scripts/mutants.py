"""Whether the tests bite: each mutant of tests/mutants.diff is run on the tests of its room.

    python scripts/mutants.py [ROOM ...]

A mutant is a small fault in the code: a sign, a bound, a line left out. The line `# ROOM: fault | TESTS`
stands above its patch and names the tests that should fail. Prints each mutant with the test that found
it. Ends with 1 if one survives: no test asserts that property then, or the code does nothing. Some tests need
the meshes that `IGL_LINABF_MESHES` names; a mutant is not tried where all of its tests are skipped.

The patched module is loaded in place of the one on disk, which is left as it is; so it is in Python processes
that the tests start.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from types import CodeType

ROOT = Path(__file__).resolve().parent.parent
MUTANTS = ROOT / "tests" / "mutants.diff"
SKIPPED = "not tried, its tests are skipped here"
SECONDS = 400  # of one run of tests, after which a mutant counts as found: it hangs


@dataclass(frozen=True)
class Mutant:
    """A fault in one module.

    Attributes
    ----------
    room, property, tests : str
        The room, what the fault breaks, and the tests, as pytest takes them.
    path : Path
        The module's file.
    changes : list of (str, str)
        Lines as they are, which stand once in the file; and in the mutant.
    """

    room: str
    property: str
    tests: str
    path: Path
    changes: list[tuple[str, str]]

    @property
    def module(self) -> str:
        return ".".join(self.path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")

    def source(self) -> str:
        """The module's text with the fault in it."""
        text = self.path.read_text("utf-8")
        for old, new in self.changes:
            if text.count(old) != 1:
                raise ValueError(
                    f"{self.path.relative_to(ROOT)}: the lines of the mutant '{self.property}' stand there "
                    f"{text.count(old)} times, not once: bring tests/mutants.diff up to date\n{old}"
                )
            text = text.replace(old, new)
        return text


def mutants(text: str) -> list[Mutant]:
    """Those of a file of patches."""
    found = []
    for part in ("\n" + text).split("\n# ")[1:]:
        head, *lines = part.splitlines()
        room, rest = head.split(": ", 1)
        words, tests = rest.rsplit(" | ", 1)
        path = next(line for line in lines if line.startswith("--- a/")).removeprefix("--- a/")
        hunks = "\n".join(lines).split("\n@@")[1:]
        changes = []
        for hunk in hunks:
            body = hunk.splitlines()[1:]
            old = "".join(line[1:] + "\n" for line in body if line[:1] in (" ", "-"))
            new = "".join(line[1:] + "\n" for line in body if line[:1] in (" ", "+"))
            changes.append((old, new))
        found.append(Mutant(room, words, tests, ROOT / path, changes))
    return found


class Faulty(SourceFileLoader, MetaPathFinder):
    """Loads one module as the mutant has it."""

    def __init__(self, mutant: Mutant) -> None:
        super().__init__(mutant.module, str(mutant.path))
        self.text = mutant.source()

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        spec = PathFinder.find_spec(name, path) if name == self.name else None  # type: ignore[arg-type]
        if spec is not None:
            spec.loader = self
        return spec

    def get_code(self, fullname: str) -> CodeType:
        return compile(self.text, self.path, "exec")


def run(number: int, tests: str, start_up: str) -> tuple[str, float]:
    """What finds the mutant of that number in the file, "" if nothing does, or `SKIPPED`; and the seconds.

    `start_up` is a folder with a `sitecustomize.py`, which every Python process imports that is started.
    """
    environment = {**os.environ, "IGL_LINABF_MUTANT": str(number), "OMP_NUM_THREADS": "1"}
    environment["PYTHONPATH"] = os.pathsep.join(
        [start_up, str(ROOT), str(ROOT / "scripts"), *filter(None, [os.environ.get("PYTHONPATH")])]
    )
    start = perf_counter()
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    try:
        done = subprocess.run(
            [*command, *tests.split()],
            cwd=ROOT,
            env=environment,
            capture_output=True,
            encoding="utf-8",
            timeout=SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "hangs", perf_counter() - start
    seconds = perf_counter() - start
    if done.returncode == 0:
        return ("" if " passed" in done.stdout else SKIPPED), seconds
    failed = [
        line.split(" - ")[0] for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))
    ]
    if done.returncode > 1 and not failed:
        raise RuntimeError(f"pytest {tests} did not run:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return failed[0] if failed else "ends the run", seconds


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("rooms", nargs="*", metavar="ROOM")
    asked = parser.parse_args().rooms
    every = list(enumerate(mutants(MUTANTS.read_text("utf-8"))))
    chosen = [(number, mutant) for number, mutant in every if not asked or mutant.room in asked]
    for _, mutant in chosen:
        mutant.source()
    living, skipped = [], []
    with TemporaryDirectory() as start_up, ThreadPoolExecutor(os.cpu_count()) as pool:
        Path(start_up, "sitecustomize.py").write_text("import mutants\n", "utf-8")
        runs = pool.map(lambda pair: run(pair[0], pair[1].tests, start_up), chosen)
        for (_, mutant), (found, seconds) in zip(chosen, runs, strict=True):
            print(f"{mutant.room}: {mutant.property}: {found or 'SURVIVES'} ({seconds:.0f} s)", flush=True)
            if not found:
                living.append(mutant)
            if found == SKIPPED:
                skipped.append(mutant)
    tried = len(chosen) - len(skipped)
    print(f"{tried - len(living)} of {tried} mutants are found, {len(skipped)} not tried")
    return 1 if living else 0


if __name__ == "__main__":
    sys.exit(main())
if "IGL_LINABF_MUTANT" in os.environ:  # in a process of the tests
    sys.meta_path.insert(0, Faulty(mutants(MUTANTS.read_text("utf-8"))[int(os.environ["IGL_LINABF_MUTANT"])]))
