"""A file has its old or its new contents, whatever happens to the process or the disk while writing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from igl_linabf.io import normalize_suffix

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform == "win32", reason="needs fork")]
SCRIPT = Path(__file__).with_name("repeated_writing.py")
PACKAGES = {"obj": "igl", "ply": "igl", "glb": "igl", "gltf": "igl", "3mf": "lib3mf", "vtp": "pyvista"}
PACKAGES |= {"surf.gii": "nibabel", "surf.gii.gz": "nibabel", "surf": "nibabel"}


def run(mode: str, path: Path) -> list[str]:
    """Run `repeated_writing.py`, and return the names of the files that it leaves."""
    process = subprocess.run([sys.executable, SCRIPT, mode, path], capture_output=True, text=True)
    assert process.returncode == 0, process.stderr
    return sorted(other.name for other in path.parent.iterdir())


@pytest.mark.parametrize("suffix", PACKAGES)
@pytest.mark.parametrize("mode", ["kill", "full", "two"])
def test_a_fault_leaves_the_old_file_or_the_new_one_and_no_litter(
    mode: str, suffix: str, tmp_path: Path
) -> None:
    pytest.importorskip(PACKAGES[suffix])
    path = tmp_path / f"a.{suffix}"
    names = run(mode, path)
    # the next process that writes to the folder removes temporary files of killed processes
    if mode != "full":
        names = run("once", path)
    assert names == [path.name, f"warm{normalize_suffix(path)}"]
