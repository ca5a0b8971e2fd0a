"""Meshes for the tests (shared files by name, meshes of packages, generated surfaces) and common helpers."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import igl
import numpy as np
import pytest
from carried import MESHES
from PIL import Image
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import Delaunay

from igl_linabf import cut
from igl_linabf.io import read_mesh
from igl_linabf.surface import complex_positions, signed_double_areas

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / folder) for folder in ("demos", "benchmarks", "scripts")]
collect_ignore = ["blender_scenes"]  # project/test_blender.py runs this folder in the Python of Blender
OWN_BLENDER = ROOT / ".venv" / "blender" / ("Scripts/python.exe" if os.name == "nt" else "bin/python")

FOLDER = os.environ.get("IGL_LINABF_MESHES")
NO_FOLDER = "IGL_LINABF_MESHES is not set: no "  # a mesh name follows
DISKS = (
    "disk__bff_hemisphere.obj",
    "disk__flipfree_camelhead_small.obj",
    "disk__igl_camel_b.obj",
    "disk__igl_camelhead.off",
    "disk__igl_face.obj",
    "disk__igl_lilium.obj",
    "disk__igl_lion.off",
    "disk__igl_snail.obj",
    "disk__oded_cube_no_bottom.obj",
    "disk__optcuts_armadillo_i_f10000.obj",
    "disk__optcuts_camel_vova_f10000.obj",
    "disk__optcuts_david_o_f10000.obj",
    "disk__optcuts_foot_i_f10000.obj",
    "disk__optcuts_lion_o_f10000.obj",
)
STRESS = (
    "stress__flipfree_deer.obj",
    "stress__optcuts_cone2.0_f1500.obj",
    "stress__optcuts_dragon_i_f10000.obj",
    "stress__optcuts_duck1.obj",
    "stress__optcuts_golf.obj",
    "stress__optcuts_male_body_i_f10000.obj",
)
CLOSED = (
    "pial",
    "nut",
    "double_torus",
    "closed__igl_cow.off",
    "closed__igl_fandisk.off",
    "closed__igl_3holes.off",
    "closed__optcuts_horse_f10000.obj",
)
CARRIED_DISKS = ("cortex_right", "ball", "tube")
CARRIED_HOLES = ("crown", "pial_with_holes")
HOLES = ("holes__igl_beetle.off", "holes__igl_halftunnel.off")

Surface = tuple[np.ndarray, np.ndarray]


def bumps(n: int = 900, seed: int = 0, height: float = 0.35) -> Surface:
    """Return a disk of `n` random vertices, lifted by random waves."""
    rng = np.random.default_rng(seed)
    around = np.linspace(0, 2 * np.pi, int(4 * np.sqrt(n)), endpoint=False)
    rim = np.column_stack((np.cos(around), np.sin(around)))
    inside = rng.uniform(-1, 1, (2 * n, 2))
    inside = inside[np.linalg.norm(inside, axis=1) < 0.97][: n - len(rim)]
    xy = np.concatenate((rim, inside))
    F = Delaunay(xy).simplices.astype(np.int64)
    backwards = signed_double_areas(complex_positions(xy), F.T) < 0
    F[backwards] = F[backwards][:, [0, 2, 1]]
    waves = rng.normal(size=(5, 2)) * 4
    z = height * np.sin(xy @ waves.T + rng.uniform(0, 6, 5)).sum(axis=1) / 3
    return np.column_stack((xy, z)), F


def tree_cut(V: np.ndarray, F: np.ndarray, leaves: int, seed: int | None = None) -> Surface:
    """Cut a closed surface along a tree of shortest paths to distant points, or to random points."""
    edges = igl.edges(F)
    length = np.linalg.norm(V[edges[:, 0]] - V[edges[:, 1]], axis=1)
    graph = sparse.csr_array((length, edges.T), shape=(len(V), len(V)))
    options = {"directed": False, "min_only": True, "return_predecessors": True}
    first = int(np.argmax(csgraph.dijkstra(graph, indices=[0], **options)[0]))
    goals = [first] if seed is None else np.random.default_rng(seed).choice(len(V), leaves, False).tolist()
    tree, seam = [goals.pop(0)], []
    for _ in range(leaves - 1):
        distance, before, _ = csgraph.dijkstra(graph, indices=tree, **options)
        node = goals.pop(0) if goals else int(np.argmax(distance))
        while before[node] >= 0:
            seam.append((node, int(before[node])))
            tree.append(node)
            node = int(before[node])
    return cut(V, F, np.array(seam))[:2]


def load(name: str) -> Surface:
    """Return a mesh by name ("bumps", in `carried.MESHES`, or a shared file); skip the test if missing."""
    if name == "bumps":
        return bumps()
    if name in MESHES:
        try:
            return MESHES[name]()
        except ImportError as error:  # packages that contain these meshes may be missing
            pytest.skip(f"{error.name} is not installed: no {name}")
    if FOLDER is None:
        pytest.skip(f"{NO_FOLDER}{name}")
    return read_mesh(Path(FOLDER) / name)


def find_blender_python() -> Path:
    """Return the path of a Python with bpy, from IGL_LINABF_BPY or `make blender`, or skip the test."""
    named = os.environ.get("IGL_LINABF_BPY")
    if named:
        return Path(named)
    if find_spec("bpy") is not None:
        return Path(sys.executable)
    if not can_import_bpy(OWN_BLENDER):
        pytest.skip("no Python with bpy is there: `make blender` makes one")
    return OWN_BLENDER


@cache
def can_import_bpy(python: Path) -> bool:
    """Return True if a Python exists and can import bpy; the import fails in an incomplete environment."""
    if not python.exists():
        return False
    try:
        return subprocess.run([python, "-c", "import bpy"], capture_output=True, timeout=3600).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def build_wheel(folder: Path) -> Path:
    """Build the wheel for this Python, if possible with the core compiled by the editable install."""
    warm = find_spec("scikit_build_core") and find_spec("nanobind") and find_spec("hatch_fancy_pypi_readme")
    how = ("--no-build-isolation", "-C", "build-dir=build/{wheel_tag}") if warm else ()
    command = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", *how, "-w", str(folder), str(ROOT)]
    with lock_folder(ROOT / "build"):
        process = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=3600)
    if "No matching distribution found for" in process.stderr:
        pytest.skip("what builds the wheel cannot be fetched")
    assert process.returncode == 0, process.stderr
    (wheel,) = folder.glob("*.whl")
    return wheel


@contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Hold a lock, because two simultaneous builds would write the same files."""
    if os.name == "nt":  # Windows has no fcntl
        yield
        return
    import fcntl

    folder.mkdir(exist_ok=True)
    with (folder / "lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def summarize_skipped_tests(reasons: list[str]) -> list[str]:
    """Summarize why tests were skipped: missing shared meshes by kind, and all other reasons."""
    kinds: Counter[str] = Counter()
    others: Counter[str] = Counter()
    for reason in reasons:
        reason = reason.removeprefix("Skipped: ")
        if reason.startswith(NO_FOLDER):
            kinds[reason.removeprefix(NO_FOLDER).split("__")[0]] += 1
        else:
            others[reason] += 1
    lines = [f"{number:4} tests: {reason}" for reason, number in others.most_common()]
    if kinds:
        told = ", ".join(f"{kind} ({number})" for kind, number in kinds.most_common())
        what = "IGL_LINABF_MESHES is not set, so the shared meshes of these kinds were not tested"
        lines.append(f"{kinds.total():4} tests: {what}: {told}")
        if not any("is not installed: no " in reason for reason in others):
            lines.append(
                "      Of each kind, meshes that come with packages or are made by code were tested."
            )
    return lines


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print which tests were skipped, because a run without the shared meshes is incomplete."""
    skipped = terminalreporter.getreports("skipped")
    lines = summarize_skipped_tests(
        [str(report.longrepr[2]) for report in skipped if isinstance(report.longrepr, tuple)]
    )
    if lines:
        terminalreporter.section("not tested here", sep="=", yellow=True)
        for line in lines:
            terminalreporter.write_line(line)


@pytest.fixture
def few_sources(monkeypatch: pytest.MonkeyPatch) -> None:
    """Measure distances from only a few vertices, to save time; the result is less exact."""
    monkeypatch.setattr("igl_linabf.measures.distances.MAX_SOURCES", 100)


def read_pixels(path: Path) -> np.ndarray:
    """Return the image in a file as an array (height, width, channels)."""
    with Image.open(path) as image:
        return np.asarray(image)


def best_fit_distance(uv: np.ndarray, onto: np.ndarray) -> float:
    """Return the largest distance of two maps after the best similarity, relative to the size of `onto`."""
    z, w = uv @ [1, 1j], onto @ [1, 1j]
    z, w = z - z.mean(), w - w.mean()
    ratio = np.vdot(z, w) / np.vdot(z, z)
    return float(np.abs(ratio * z - w).max() / np.abs(w).max())
