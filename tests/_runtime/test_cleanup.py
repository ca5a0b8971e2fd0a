"""Ctrl-C and SIGTERM end the command with one line, without leaving files or processes."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import igl
import numpy as np
import pytest
from commands import list_session_processes
from conftest import bumps
from hostile_meshes import close_with_copy

ENTRY = [sys.executable, "-m", "igl_linabf"]
ARGUMENTS = {
    "flatten": ["flatten", "{mesh}", "-o", "{out}", "--method", "abf", "--picture", "{picture}"],
    "unwrap": ["unwrap", "{closed}", "-o", "{out}", "--picture", "{picture}"],
    "compare": ["compare", "{mesh}", "--picture", "{picture}"],
    "repaired": ["unwrap", "{wound}", "-o", "{out}", "--repair-overlaps"],
    "cortex": ["cortex", "{subject}", "-o", "{folder}"],
    "batch": ["batch", "{closed}", "{wound}", "-o", "{folder}", "--workers", "2", "--repair-overlaps"],
    "cortices": ["batch", "{subject}", "-o", "{folder}", "--workers", "2", "--how", "cortex"],
}
# latest time of the interrupt, in seconds; 4 seconds for commands that are not listed
LONGEST_WAIT = {"batch": 15, "cortices": 15}


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("meshes")
    V, F = igl.upsample(*bumps(2000), 2)
    closed = igl.upsample(*close_with_copy(*bumps(900)), 1)
    t = np.repeat(np.linspace(0, 15, 2000), 2)  # a coiled strip whose map overlaps itself
    side = np.tile([0, 0.2], 2000)
    wound = np.column_stack(((1 - side) * np.cos(t), (1 - side) * np.sin(t), 1e-3 * t))
    strip = np.array([f for i in range(0, 3998, 2) for f in ([i, i + 1, i + 2], [i + 1, i + 3, i + 2])])
    paths = {}
    for name, surface in {"mesh": (V, F), "closed": closed, "wound": (wound, strip)}.items():
        paths[name] = folder / f"{name}.obj"
        igl.write_triangle_mesh(str(paths[name]), *surface)
    return {**paths, "subject": folder / "sub-01"}


def is_importing(pid: int) -> bool:
    """Return True if the process has started to import NumPy."""
    return "numpy" in Path(f"/proc/{pid}/maps").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/maps"), reason="needs /proc")
@pytest.mark.parametrize("name", ARGUMENTS)
@pytest.mark.parametrize(("number", "end"), [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated")])
def test_an_interrupt_at_any_moment_ends_in_one_line_and_leaves_nothing(
    number: signal.Signals, end: str, name: str, meshes: dict[str, Path], tmp_path: Path
) -> None:
    if "{subject}" in ARGUMENTS[name] and not meshes["subject"].exists():
        pytest.importorskip("nilearn")
        from subjects import made_up_subject

        made_up_subject(meshes["subject"])
    temporary, folder = tmp_path / "tmp", tmp_path / "out.d"
    temporary.mkdir()
    places = {**meshes, "out": tmp_path / "out.obj", "picture": tmp_path / "out.png", "folder": folder}
    arguments = [argument.format(**places) for argument in ARGUMENTS[name]]
    rng = np.random.default_rng(len(name))
    interrupted = 0
    for wait in (0.0, *rng.uniform(0, LONGEST_WAIT.get(name, 4), 2)):
        process = subprocess.Popen(
            [*ENTRY, *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            env={**os.environ, "TMPDIR": str(temporary)},
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        while not is_importing(process.pid):
            time.sleep(0.01)
        time.sleep(wait)
        process.send_signal(number)  # signal only the main process, which must end its child processes itself
        _, said = process.communicate(timeout=500)
        assert not list_session_processes(process.pid)
        assert not list(temporary.iterdir())
        assert not list(folder.rglob(".igl_linabf-*"))
        if process.returncode == 0:  # the command had already finished
            for path in tmp_path.glob("out.[!d]*"):
                path.unlink()
        else:
            interrupted += 1
            assert (process.returncode, said.splitlines()) == (128 + number, [f"igl-linabf: {end}"])
            # an interrupted batch keeps its finished maps
            assert name in LONGEST_WAIT or not list(folder.glob("*"))
        shutil.rmtree(folder, ignore_errors=True)
        assert [path.name for path in tmp_path.iterdir()] == ["tmp"]
    assert interrupted
