"""Check what would be published: `make release-check`.

Builds the source archive and the wheel in a temporary folder, checks both with twine, check-wheel-contents
and pyroma, and installs each into a fresh virtual environment. There the command answers on the plain
installation, and then those tests run that need no clone. They are the source archive's own. In the end
both files are in `dist`.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = "igl_linabf"
TOOLS = ("build>=1.2", "twine>=6.1", "check-wheel-contents>=0.6", "pyroma>=5")
FOR_TESTS = (
    "pytest>=8",
    "pytest-timeout>=2.3",
    "pytest-xdist>=3.5",
    "hypothesis>=6",
    "trimesh>=4",
    "pymeshfix",
)
LEFT_OUT = (  # they need a clone, or an extra that the fresh environments do not have
    "test_blender.py",
    "test_bootstrap.py",
    "test_demos.py",
    "test_docs.py",
    "test_docstrings.py",
    "test_fuzz.py",
    "test_names.py",
    "test_performance.py",
    "test_recipes.py",
    "test_release.py",
    "test_results.py",
    "test_rooms.py",
    "test_view.py",
)
IN_THE_ARCHIVE = ("README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "Makefile")
FOLDERS_IN_THE_ARCHIVE = ("docs", "demos", "recipes", "tests", "benchmarks", "scripts", "blender", "conda")


def say(text: str) -> None:
    print(f"release-check: {text}", flush=True)


def run(*command: object, cwd: Path | None = None) -> str:
    """Run a command; return and show what it printed, and end with it if it fails."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    process = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    print(process.stdout, end="", flush=True)
    if process.returncode:
        raise SystemExit(f"release-check: failed: {' '.join(map(str, command))}")
    return process.stdout


def environment(folder: Path, *packages: object) -> Path:
    """A new virtual environment with some packages; its Python."""
    run(sys.executable, "-m", "venv", folder)
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    install(python, *packages)
    return python


def install(python: Path, *packages: object) -> None:
    run(python, "-m", "pip", "install", "-qq", "--disable-pip-version-check", *packages)


def check_wheel(wheel: Path) -> None:
    """One top-level module, types, the command, and links that lead somewhere from the index's page."""
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (metadata,) = (name for name in names if name.endswith(".dist-info/METADATA"))
        page = archive.read(metadata).decode()
    tops = {name.partition("/")[0] for name in names if ".dist-info/" not in name}
    assert tops == {PACKAGE}, f"the wheel has {sorted(tops)} at its top level"
    assert f"{PACKAGE}/py.typed" in names, "the wheel has no py.typed"
    relative = [link for link in re.findall(r"\]\(([^)\s]+)", page) if not link.startswith("https://")]
    assert not relative, f"the page of the index has relative links: {relative}"


def check_archive(archive: Path, folder: Path) -> Path:
    """Unpack the source archive, and look whether all is in it."""
    with tarfile.open(archive) as packed:
        if hasattr(tarfile, "data_filter"):  # Python 3.10.12, 3.11.4 and later
            packed.extractall(folder, filter="data")
        else:
            packed.extractall(folder)
    (unpacked,) = folder.iterdir()
    for name in IN_THE_ARCHIVE:
        assert (unpacked / name).is_file(), f"the source archive has no {name}"
    for name in FOLDERS_IN_THE_ARCHIVE:
        mine = {path.name for path in (ROOT / name).iterdir() if path.is_file()}
        there = {path.name for path in (unpacked / name).iterdir() if path.is_file()}
        assert mine <= there, f"the source archive has no {sorted(mine - there)} in {name}"
    return unpacked


def check_installed(what: Path, unpacked: Path, folder: Path) -> None:
    """The plain installation answers; with pictures and pytest, the tests pass."""
    python = environment(folder / "env", what)
    version = run(python, "-m", PACKAGE, "--version", cwd=folder).split()[-1]
    assert version in what.name, f"{what.name} says that it is version {version}"
    run(python.with_name("igl-linabf"), "doctor", cwd=folder)
    run(python, "-m", "pip", "--disable-pip-version-check", "check")
    install(python, f"{what}[viz]", *FOR_TESTS)
    place = folder / "tests_only"  # without the package's sources: the installed one is tested
    for name in ("tests", "demos", "benchmarks"):
        shutil.copytree(unpacked / name, place / name)
    shutil.copy(unpacked / "pyproject.toml", place)
    ignored = [f"--ignore=tests/{name}" for name in LEFT_OUT]
    run(python, "-m", "pytest", "tests", "-n", "auto", "--dist", "loadfile", *ignored, cwd=place)


def main() -> None:
    with tempfile.TemporaryDirectory(prefix="release-check-") as name:
        folder = Path(name)
        say("building")
        tools = environment(folder / "tools", *TOOLS)
        run(tools, "-m", "build", "--outdir", folder / "dist", ROOT)
        (wheel,) = folder.glob("dist/*.whl")
        (archive,) = folder.glob("dist/*.tar.gz")
        say("twine, check-wheel-contents, pyroma")
        run(tools, "-m", "twine", "check", "--strict", wheel, archive)
        run(tools, "-m", "check_wheel_contents", wheel)
        rated = run(tools, "-m", "pyroma", "--min=10", archive)
        assert "Final rating: 10/10" in rated
        check_wheel(wheel)
        unpacked = check_archive(archive, folder / "unpacked")
        for what in (wheel, archive):
            say(f"a fresh environment with {what.name}")
            place = folder / f"from_{what.suffix[1:]}"
            place.mkdir()
            check_installed(what, unpacked, place)
        shutil.rmtree(ROOT / "dist", ignore_errors=True)
        shutil.copytree(folder / "dist", ROOT / "dist")
        say(f"dist/{wheel.name} and dist/{archive.name} can be published")


if __name__ == "__main__":
    main()
