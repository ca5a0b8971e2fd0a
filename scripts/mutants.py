"""Run tests on each mutant of tests/mutants.diff, and report the survivors.

    python scripts/mutants.py [ROOM ...]

A mutant is a small fault in the code: a wrong sign, a wrong bound, a missing line. The line above its patch,
`# ROOM: fault | TESTS`, names the tests that should fail. The script prints each mutant with the test that
finds it. The exit code is 1 if a mutant survives: either no test asserts that property, or the code has no
effect. Some tests need the meshes in `IGL_LINABF_MESHES`; a mutant is not tried if all of its tests are
skipped.

The patched module replaces the module on disk at import, also in Python processes that the tests start. The
file on disk is not changed.
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
TIMEOUT = 400  # seconds per run of tests; a mutant that hangs counts as found


@dataclass(frozen=True)
class Mutant:
    """A fault in one module.

    Attributes
    ----------
    room, property, tests : str
        The subpackage, the property that the fault breaks, and the tests as arguments of pytest.
    path : Path
        The file of the module.
    changes : list of (str, str)
        Original lines, which must occur exactly once in the file, and the lines of the mutant.
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
        """Return the source of the module with the fault."""
        text = self.path.read_text("utf-8")
        for old, new in self.changes:
            if text.count(old) != 1:
                raise ValueError(
                    f"{self.path.relative_to(ROOT)}: the lines of the mutant '{self.property}' stand there "
                    f"{text.count(old)} times, not once: bring tests/mutants.diff up to date\n{old}"
                )
            text = text.replace(old, new)
        return text


def parse_mutants(text: str) -> list[Mutant]:
    """Return the mutants in the text of a file of patches."""
    found = []
    for part in ("\n" + text).split("\n# ")[1:]:
        head, *lines = part.splitlines()
        room, rest = head.split(": ", 1)
        property_, tests = rest.rsplit(" | ", 1)
        path = next(line for line in lines if line.startswith("--- a/")).removeprefix("--- a/")
        hunks = "\n".join(lines).split("\n@@")[1:]
        changes = []
        for hunk in hunks:
            body = hunk.splitlines()[1:]
            old = "".join(line[1:] + "\n" for line in body if line[:1] in (" ", "-"))
            new = "".join(line[1:] + "\n" for line in body if line[:1] in (" ", "+"))
            changes.append((old, new))
        found.append(Mutant(room, property_, tests, ROOT / path, changes))
    return found


class MutantLoader(SourceFileLoader, MetaPathFinder):
    """A loader that replaces one module by its mutant."""

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
    """Return the test that finds a mutant ("" if it survives, `SKIPPED` if not tried), and the seconds.

    Every Python process imports the `sitecustomize.py` of the folder `start_up` when it starts.
    """
    environment = {**os.environ, "IGL_LINABF_MUTANT": str(number), "OMP_NUM_THREADS": "1"}
    environment["PYTHONPATH"] = os.pathsep.join(
        [start_up, str(ROOT), str(ROOT / "scripts"), *filter(None, [os.environ.get("PYTHONPATH")])]
    )
    start = perf_counter()
    command = [sys.executable, "-m", "pytest", "-x", "-p", "no:cacheprovider"]
    try:
        done = subprocess.run(
            [*command, *tests.split()],
            cwd=ROOT,
            env=environment,
            capture_output=True,
            encoding="utf-8",
            timeout=TIMEOUT,
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
    rooms = parser.parse_args().rooms
    numbered = list(enumerate(parse_mutants(MUTANTS.read_text("utf-8"))))
    chosen = [(number, mutant) for number, mutant in numbered if not rooms or mutant.room in rooms]
    for _, mutant in chosen:
        mutant.source()
    survivors, skipped = [], []
    with TemporaryDirectory() as start_up, ThreadPoolExecutor(os.cpu_count()) as pool:
        Path(start_up, "sitecustomize.py").write_text("import mutants\n", "utf-8")
        runs = pool.map(lambda pair: run(pair[0], pair[1].tests, start_up), chosen)
        for (_, mutant), (found, seconds) in zip(chosen, runs, strict=True):
            print(f"{mutant.room}: {mutant.property}: {found or 'SURVIVES'} ({seconds:.0f} s)", flush=True)
            if not found:
                survivors.append(mutant)
            if found == SKIPPED:
                skipped.append(mutant)
    tried = len(chosen) - len(skipped)
    print(f"{tried - len(survivors)} of {tried} mutants are found, {len(skipped)} not tried")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
if "IGL_LINABF_MUTANT" in os.environ:  # this process runs tests of a mutant
    sys.meta_path.insert(
        0, MutantLoader(parse_mutants(MUTANTS.read_text("utf-8"))[int(os.environ["IGL_LINABF_MUTANT"])])
    )
