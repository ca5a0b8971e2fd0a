"""The Blender extension works without a display after installation from its archive.

The tests use the Python of `make blender`, or a Python with `bpy` that IGL_LINABF_BPY names.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from conftest import ROOT, build_wheel, find_blender_python

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def archive(tmp_path_factory) -> Path:
    """Build the Blender extension from these sources, and return the path of its archive."""
    into = tmp_path_factory.mktemp("extension")
    code = "import sys; print('%d.%d' % sys.version_info[:2])"
    asked = subprocess.run(
        [find_blender_python(), "-c", code], capture_output=True, encoding="utf-8", check=True
    )
    options = ["--python", asked.stdout.strip(), "--into", str(into)]
    if asked.stdout.strip() == "{}.{}".format(*sys.version_info):
        build_wheel(into)
        options += ["--wheels", str(into)]
    script = ROOT / "scripts" / "blender_extension.py"
    subprocess.run([sys.executable, str(script), *options], check=True, timeout=3600)
    (built,) = into.glob("*.zip")
    return built


def test_the_archive_contains_all_dependencies_except_numpy(archive: Path) -> None:
    with zipfile.ZipFile(archive) as file:
        manifest = tomllib.loads(file.read("blender_manifest.toml").decode())
        held = {name for name in file.namelist() if name.endswith(".whl")}
    assert {f"./{name}" for name in held} == set(manifest["wheels"])
    packages = {name.split("/")[-1].split("-")[0].lower() for name in held}
    assert {"igl_linabf", "libigl", "scipy", "shapely"} <= packages
    assert "numpy" not in packages
    package = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert manifest["version"] == package["version"]


def test_every_scene_in_blender(archive: Path) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    process = subprocess.run(
        [find_blender_python(), ROOT / "tests" / "blender_scenes", archive],
        capture_output=True,
        encoding="utf-8",
        env=environment,
        timeout=3600,
    )
    assert process.returncode == 0, (process.stdout + process.stderr)[-3000:]
    report = json.loads(process.stdout.splitlines()[-1])
    assert len(report["run"]) > 30
    assert not report["failed"], "\n".join(report["failed"].values())
