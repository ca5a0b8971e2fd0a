"""Measure the first calls in new processes and a new environment, for docs/performance.md.

    python benchmarks/first_call.py [--environment FOLDER] [--repeat 5] [--print]

`pip install .` creates the environment in a temporary folder, or in FOLDER, where later runs reuse it. The
very first process has its own row; the other rows are medians. Processes alternate. The meshes are camelhead,
fandisk and cow of IGL_LINABF_MESHES.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
from pages import arguments, publish

ROOT = Path(__file__).resolve().parent.parent
# without PYTHONPATH, the processes import the installed package
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
DISK, CLOSED, PART = "disk__igl_camelhead.off", "closed__igl_cow.off", "closed__igl_fandisk.off"

READ = "import igl; V, F = igl.read_triangle_mesh({path!r}); "
LSCM = (
    "import numpy as np; loop = igl.boundary_loop(F); "
    "igl.lscm(V, F, np.array([loop[0], loop[len(loop) // 2]]), np.array([[0.0, 0.0], [1.0, 0.0]]))"
)
LINABF = "import igl_linabf; igl_linabf.linabf(V, F)"
TWO_ATLASES = """
import igl_linabf
from time import perf_counter
times = [perf_counter()]
for _ in range(2):
    igl_linabf.unwrap(V, F, method="isometric")
    times.append(perf_counter())
print(times[1] - times[0], times[2] - times[1])
"""


def make_environment(folder: Path) -> Path:
    """Create an environment with nothing but the package, if necessary; return its Python."""
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        subprocess.run([python, "-m", "pip", "install", "-q", ROOT], check=True)
    return python


def time_process(*command: object) -> float:
    """Return the wall time of a process that runs outside the clone."""
    with tempfile.TemporaryDirectory() as folder:
        start = perf_counter()
        words = [str(word) for word in command]
        subprocess.run(words, check=True, cwd=folder, env=ENVIRONMENT, stdout=subprocess.DEVNULL)
        return perf_counter() - start


def time_two_atlases(python: Path, path: str) -> list[float]:
    """Return the seconds of two successive isometric atlases in a new process."""
    code = READ.format(path=path) + TWO_ATLASES
    command = [python, "-c", code]
    process = subprocess.run(
        command, check=True, capture_output=True, encoding="utf-8", cwd=python.parent, env=ENVIRONMENT
    )
    return list(map(float, process.stdout.split()))


def make_table(python: Path, meshes: Path, repeat: int) -> str:
    """Return the table in Markdown."""
    disk, closed, part = (str(meshes / name) for name in (DISK, CLOSED, PART))
    both = {"linabf": LINABF, "igl.lscm": LSCM}
    commands = {name: (python, "-c", READ.format(path=disk) + code) for name, code in both.items()}
    very_first = {name: time_process(*command) for name, command in commands.items()}
    taken: dict[str, list[float]] = {name: [] for name in commands}
    for _ in range(repeat):
        for name, command in commands.items():
            taken[name].append(time_process(*command))
    usual = {name: float(np.median(values)) for name, values in taken.items()}
    command = python.with_name("igl-linabf")
    unwrapped = np.median([time_process(command, "unwrap", closed, "-o", "cow.obj") for _ in range(repeat)])
    rows = ["| what a process does | seconds | over `igl.lscm` |", "|---|---|---|"]
    for when, times in (("the very first", very_first), ("a later", usual)):
        for name in commands:
            over = f"{times[name] / times['igl.lscm']:.2f}"
            rows.append(f"| {when} one: import, read camelhead, `{name}` | {times[name]:.2f} | {over} |")
    rows.append(f"| `igl-linabf unwrap cow.off -o cow.obj` | {unwrapped:.2f} | |")
    for path in (closed, part):
        first, second = np.median([time_two_atlases(python, path) for _ in range(repeat)], axis=0)
        name = Path(path).stem.split("__igl_")[1]
        rows.append(f'| `unwrap(V, F, method="isometric")` of {name}: the first call | {first:.2f} | |')
        rows.append(f"| the second call | {second:.2f} | |")
    return "\n".join(rows)


def main() -> None:
    parser = arguments(__doc__, 5)
    parser.add_argument("--environment", type=Path)
    options = parser.parse_args()
    meshes = os.environ.get("IGL_LINABF_MESHES")
    if meshes is None:
        raise SystemExit("first_call: IGL_LINABF_MESHES is not set: name the folder of meshes")
    with tempfile.TemporaryDirectory() as folder:
        python = make_environment(options.environment or Path(folder) / "environment")
        table = make_table(python, Path(meshes).resolve(), options.repeat)
        page = f"`python benchmarks/first_call.py`\n\n{table}"
    publish("first call", page, options.printed)


if __name__ == "__main__":
    main()
