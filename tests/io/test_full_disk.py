"""A full disk or an unwritable folder causes one error line and leaves no partial file."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import igl
import pytest
from commands import run
from conftest import bumps

resource = pytest.importorskip("resource", reason="limits of a process are POSIX's")

COMMANDS = {
    "obj": ["flatten", "{mesh}", "-o", "{folder}/x.obj"],
    "atlas": ["unwrap", "{mesh}", "-o", "{folder}/x.obj"],
    "ply": ["unwrap", "{mesh}", "-o", "{folder}/x.ply"],
    "glb": ["unwrap", "{mesh}", "-o", "{folder}/x.glb"],
    "png": [
        "compare",
        "{mesh}",
        "--methods",
        "lscm",
        "--repeat",
        "1",
        "--picture",
        "{folder}/x.png",
        "--force",
    ],
    "obj and png": ["flatten", "{mesh}", "-o", "{folder}/x.obj", "--picture", "{folder}/x.png", "--force"],
}


@pytest.fixture(scope="module")
def mesh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("mesh") / "mesh.obj"
    igl.write_triangle_mesh(str(path), *bumps(400))
    return path


def words(name: str, mesh: Path, folder: Path) -> list[str]:
    return [argument.format(mesh=mesh, folder=folder) for argument in COMMANDS[name]]


@contextmanager
def limit_file_size(size: int) -> Iterator[None]:
    """Limit the size of all files that this process writes, in bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_full_disk_is_one_sentence_and_leaves_the_old_file(name: str, mesh: Path, tmp_path: Path) -> None:
    old = [tmp_path / f"x.{suffix}" for suffix in ("obj", "ply", "glb", "png")]
    for path in old:
        path.write_text("old")
    # large enough for an OBJ file, too small for a picture
    with limit_file_size(60_000 if "and" in name else 4096):
        process = run(*words(name, mesh, tmp_path))
    assert process.returncode == 2
    assert process.stdout == ""
    assert len(process.stderr.splitlines()) == 1
    assert process.stderr.startswith(f"igl-linabf: {tmp_path}/x.")
    assert "File too large" in process.stderr
    assert sorted(tmp_path.iterdir()) == sorted(old)
    assert {path.read_text() for path in old} == {"old"}


@pytest.mark.skipif(
    sys.platform != "linux" or os.geteuid() != 0, reason="only Linux's root may mount a tmpfs"
)
def test_no_space_left_is_one_sentence(mesh: Path, tmp_path: Path) -> None:
    mount = ["mount", "-t", "tmpfs", "-o", "size=8k", "tmpfs", str(tmp_path)]
    if subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("mounting is forbidden")
    try:
        for name in COMMANDS:
            process = run(*words(name, mesh, tmp_path))
            assert process.returncode == 2
            assert process.stderr.startswith(f"igl-linabf: {tmp_path}/x.")
            assert process.stderr.endswith(": No space left on device\n")
            assert len(process.stderr.splitlines()) == 1
            assert not list(tmp_path.iterdir())
    finally:
        subprocess.run(["umount", str(tmp_path)], check=True)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no /dev/full")
def test_no_file_is_written_if_standard_output_is_full(mesh: Path, tmp_path: Path) -> None:
    with open("/dev/full", "w", encoding="utf-8") as full:
        command = [sys.executable, "-m", "igl_linabf", *words("obj", mesh, tmp_path)]
        process = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=500)
    assert (process.returncode, process.stderr) == (
        2,
        "igl-linabf: standard output: No space left on device\n",
    )
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", COMMANDS)
def test_a_missing_or_unwritable_folder_is_one_sentence(name: str, mesh: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    unwritable = [Path("/proc")] if sys.platform == "linux" else []
    for folder in (tmp_path / "nowhere", tmp_path / "file", *unwritable):
        process = run(*words(name, mesh, folder))
        assert process.returncode == 2
        assert len(process.stderr.splitlines()) == 1
        assert str(folder) in process.stderr
