"""Compare readers of mesh files in two Markdown tables (docs/readers.md): time, and damaged files.

    python benchmarks/readers.py [--files 300] [--times 7]

The readers of igl and of this package are always compared; plyfile, meshio, trimesh (with Pillow for
textures) and numpy-stl if they are installed. The times are for an icosahedron subdivided TIMES times.
`tests/hostile_files.py` makes the damaged files, and child processes read them.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import logging
import re
import resource
import statistics
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from functools import cache, partial
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter

import igl
import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

import fuzzing
from hostile_files import good_files, list_files, mutate

from igl_linabf.io import read_mesh

Surface = tuple[np.ndarray, np.ndarray]


def _plyfile(path: str) -> Surface:
    from plyfile import PlyData, PlyParseError

    try:  # the fast path, for files with triangles only
        data = PlyData.read(path, known_list_len={"face": {"vertex_indices": 3}})
    except PlyParseError:
        data = PlyData.read(path)
    vertex, faces = data["vertex"], data["face"]["vertex_indices"]
    points = np.column_stack([vertex[axis] for axis in "xyz"])
    return points, np.vstack(faces) if faces.dtype == object else np.array(faces)


def _meshio(path: str) -> Surface:
    import meshio

    mesh = meshio.read(path)
    return mesh.points, mesh.cells_dict["triangle"]


def _trimesh(path: str) -> Surface:
    import trimesh

    mesh = trimesh.load(path, process=False, force="mesh")
    return mesh.vertices, mesh.faces


def _numpy_stl(path: str) -> Surface:
    from stl.mesh import Mesh

    corners = Mesh.from_file(path).vectors
    return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)


SUFFIXES = ("obj", "off", "ply", "stl")
# name of the package: (reader, suffixes that the reader supports)
READERS: dict[str, tuple[Callable[[str], Surface], tuple[str, ...]]] = {
    "libigl": (igl.read_triangle_mesh, SUFFIXES),
    "igl_linabf": (read_mesh, SUFFIXES),
    "plyfile": (_plyfile, ("ply",)),
    "meshio": (_meshio, SUFFIXES),
    "trimesh": (_trimesh, SUFFIXES),
    "numpy-stl": (_numpy_stl, ("stl",)),
}
MODULES = {"libigl": "igl", "numpy-stl": "stl"}
FORMS = {
    "OBJ": ("obj", 0),
    "OBJ, uv and normals": ("obj", 1),
    "OFF": ("off", 0),
    "PLY, text": ("ply", 0),
    "PLY, binary": ("ply", 1),
    "STL, text": ("stl", 1),
    "STL, binary": ("stl", 0),
}
FOLDER = Path(tempfile.gettempdir())
# memory limit in bytes of a child process, because a damaged file may declare billions of rows
MEMORY = 4 << 30
RUNS = 5
PACKAGES = {MODULES.get(name, name) for name in READERS}
# errors by which a reader refuses a file, in addition to the error types that its package defines
REFUSALS = (ValueError, RuntimeError, OSError, NotImplementedError)
SEPARATOR = " reads "  # separates package and suffix in the name of a kind of case
PLACE = re.compile(r"\b(line|row|face|triangle|vert|element|byte)\w*\b.{0,30}?\d|\b(head|begin|end)", re.I)
OUTCOMES = {
    "same": "read as if undamaged",
    "place": "refused with the place",
    "no place": "refused without",
    "inner": "inner error",
    "other": "read as another mesh",
    "impossible": "read as no mesh",
    "crash": "crash, hang or exit",
}


@cache
def _damaged(suffix: str, seed: int) -> tuple[bytes, bytes]:
    """Return the bytes of an undamaged file, and of the same file with damage."""
    rng = np.random.default_rng(seed)
    forms = good_files(rng)[suffix]
    undamaged = forms[rng.integers(len(forms))]
    return undamaged, mutate(undamaged, rng)


def _corners(read: Callable[[str], Surface], data: bytes, suffix: str) -> np.ndarray | None:
    """Return the positions at the corners of the faces (#F, 3, 3), or None for invalid indices."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"mesh.{suffix}"
        path.write_bytes(data)
        V, F = (np.asarray(array) for array in read(str(path)))
    if F.ndim != 2 or V.shape[1:] != (3,) or F.min(initial=0) < 0 or F.max(initial=0) >= max(len(V), 1):
        return None
    return V[F.astype(np.int64)] if len(F) else np.empty((0, 3, 3))


def _outcome(name: str, suffix: str, seed: int) -> str:
    """Return the outcome of reading a damaged file, which is a key of `OUTCOMES`."""
    read, _ = READERS[name]
    undamaged, data = _damaged(suffix, seed)
    expected = _corners(read_mesh, undamaged, suffix)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    logging.disable()
    output = io.StringIO()
    try:
        with (
            contextlib.redirect_stdout(output),
            contextlib.redirect_stderr(output),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")
            found = _corners(read, data, suffix)
    except SystemExit:
        return "crash"
    except Exception as error:
        package = type(error).__module__.partition(".")[0]
        if package not in PACKAGES and type(error) not in REFUSALS:
            return "inner"
        return "place" if PLACE.search(str(error)) else "no place"
    if found is None or not np.isfinite(found).all():
        return "impossible"
    same = found.shape == expected.shape and np.allclose(found, expected, rtol=1e-6, atol=1e-7)
    return "same" if same else "other"


def print_seconds(installed: list[str], times: int) -> None:
    """Print the table of times, by format and reader."""
    files = list_files(*igl.upsample(*igl.icosahedron(), times))
    heads = " | ".join(f"{name} / libigl" for name in installed[1:])
    print(f"| {20 * 4**times:,} triangles | seconds, libigl | {heads} |")
    print("|---|" + "---|" * len(installed))
    for label, (suffix, form) in FORMS.items():
        seconds_of_runs: dict[str, list[float]] = {
            name: [] for name in installed if suffix in READERS[name][1]
        }
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"mesh.{suffix}"
            path.write_bytes(files[suffix][form])
            for _ in range(RUNS):
                for name in seconds_of_runs:
                    start = perf_counter()
                    READERS[name][0](str(path))
                    seconds_of_runs[name].append(perf_counter() - start)
        median = {name: statistics.median(runs) for name, runs in seconds_of_runs.items()}
        base = median["libigl"]
        cells = [f"{median[name] / base:.1f}" if name in median else "" for name in installed[1:]]
        print(f"| {label} | {base:.2f} | {' | '.join(cells)} |", flush=True)


def _count_forms_read(name: str, suffix: str, seed: int) -> str:
    """Return how many undamaged variants of a format a reader reads correctly."""
    forms = good_files(np.random.default_rng(seed))[suffix]
    read = 0
    for data in forms:
        with contextlib.suppress(Exception, SystemExit), contextlib.redirect_stdout(io.StringIO()):
            found = _corners(READERS[name][0], data, suffix)
            read += found is not None and np.allclose(found, _corners(read_mesh, data, suffix), rtol=1e-6)
    return f"{read} of {len(forms)}"


def print_damage(installed: list[str], files: int) -> None:
    """Print the table of outcomes for damaged files, by format and reader."""
    print(f"| {files:,} damaged files each | undamaged forms read | " + " | ".join(OUTCOMES.values()) + " |")
    print("|---|---|" + "---|" * len(OUTCOMES))
    for suffix in SUFFIXES:
        for name in installed:
            if suffix not in READERS[name][1]:
                continue
            kind = f"{name}{SEPARATOR}{suffix}"
            count, broken = fuzzing.run_all([(kind, seed) for seed in range(files)], __file__)[kind]
            count += Counter(crash=len(broken))
            cells = " | ".join(f"{count[outcome]:,}" for outcome in OUTCOMES)
            forms = _count_forms_read(name, suffix, files)
            print(f"| {suffix.upper()}, {name} | {forms} | {cells} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--files", type=int, default=300)
    parser.add_argument("--times", type=int, default=7)
    options = parser.parse_args()
    fuzzing.LIMIT = 10.0  # time limit per file in seconds
    installed = [name for name in READERS if find_spec(MODULES.get(name, name)) is not None]
    print(", ".join(f"{name} {metadata.version(name)}" for name in installed if name != "igl_linabf"))
    print()
    print_seconds(installed, options.times)
    print()
    print_damage(installed, options.files)


if __name__ == "__main__":
    if sys.argv[1:2] and sys.argv[1].endswith(".json"):
        kinds = {f"{name}{SEPARATOR}{suffix}": (name, suffix) for name in READERS for suffix in SUFFIXES}
        fuzzing.run_as_child({kind: partial(_outcome, *arguments) for kind, arguments in kinds.items()})
    else:
        main()
