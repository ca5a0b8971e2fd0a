"""Build the extension for Blender: `make blender`.

The archive contains the add-on, this package, and the wheels of its dependencies, for one platform and the
Python versions of several Blender versions. Each Blender installs the wheels that match its Python. NumPy is
part of Blender. Installation compiles and downloads nothing. The wheels of this package are built by this
script, or, for another platform, taken from a folder.

    python scripts/blender_extension.py [--python 3.11 --python 3.13]
    python scripts/blender_extension.py --platform macos-arm64|windows-x64 --wheels FOLDER
    python scripts/blender_extension.py --blender FOLDER    # create a virtual environment with `bpy`
"""

from __future__ import annotations

import argparse
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from release_check import STABLE, find_pythons, is_compatible

ROOT = Path(__file__).resolve().parent.parent
ADD_ON = ROOT / "blender" / "igl_linabf"
PIP_PLATFORMS = {  # platform in Blender: names of the platform in pip
    "linux-x64": ("linux_x86_64", "manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux2014_x86_64"),
    "macos-arm64": ("macosx_12_0_arm64", "macosx_11_0_arm64"),
    "windows-x64": ("win_amd64",),
}
# NumPy versions of Blender 4.2 to 5.0, and of later versions; all other wheels must support them
NUMPY = {"3.11": "numpy<2", "3.13": "numpy>=2,<2.4"}
BPY = "bpy>=4.2,<6"


def current_platform() -> str:
    """Return the name of this platform in Blender."""
    system = {"Linux": "linux", "Darwin": "macos", "Windows": "windows"}[platform.system()]
    return f"{system}-{'arm64' if platform.machine() in ('arm64', 'aarch64') else 'x64'}"


def build_own_wheels(folder: Path, versions: list[tuple[int, int]]) -> None:
    """Build wheels of this package for some Python versions, with that Python or with its stable ABI."""
    available = find_pythons()
    for asked in versions:
        for known, python in sorted(available.items(), key=lambda item: item[0] != asked):
            needed = not any(is_compatible(wheel, asked) for wheel in folder.glob("*.whl"))
            if needed and (known == asked or min(known, asked) >= STABLE):
                pip = [python, "-m", "pip", "--disable-pip-version-check"]
                subprocess.run([*pip, "wheel", "-q", "--no-deps", "-w", folder, ROOT], check=True)


def collect_wheels(folder: Path, target: str, asked: list[str] | None, prebuilt: Path | None) -> list[Path]:
    """Return the wheels of this package and of its dependencies, without NumPy."""
    versions = {text: tuple(int(part) for part in text.split(".")) for text in asked or NUMPY}
    with tempfile.TemporaryDirectory() as name:
        if prebuilt is None and target == current_platform():
            build_own_wheels(Path(name), list(versions.values()))
        own = [
            wheel
            for wheel in (prebuilt or Path(name)).glob("igl_linabf-*.whl")
            if is_for_platform(wheel, target)
        ]
        for text, version in versions.items():
            matching = [wheel for wheel in own if is_compatible(wheel, version)]
            if matching:
                download(folder, target, text, matching[0])
            elif asked:
                raise SystemExit(f"no wheel of igl_linabf for Python {text} on {target}: see --wheels")
            else:
                print(f"no wheel of igl_linabf for Python {text}: the extension will not support its Blender")
    for wheel in folder.glob("numpy-*.whl"):
        wheel.unlink()
    return sorted(folder.glob("*.whl"))


def download(folder: Path, target: str, version: str, own: Path) -> None:
    """Download the wheels of this package and of its dependencies for a Python version."""
    names = [word for name in PIP_PLATFORMS[target] for word in ("--platform", name)]
    command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "download", "-q", "-d", folder]
    command += ["--only-binary", ":all:", "--python-version", version, *names]
    subprocess.run([*command, own, NUMPY.get(version, "numpy>=2")], check=True)


def is_for_platform(wheel: Path, target: str) -> bool:
    """Return True if a wheel is for a platform."""
    system, _, machine = target.partition("-")
    tag = wheel.stem.split("-")[-1]
    return {"windows": "win", "macos": "macosx", "linux": "linux"}[system] in tag and tag.endswith(
        {"x64": ("x86_64", "amd64"), "arm64": ("arm64", "aarch64")}[machine]
    )


def build(target: str, versions: list[str] | None, into: Path, prebuilt: Path | None) -> Path:
    """Write the archive for a platform, and return its path."""
    into.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "igl_linabf"
        shutil.copytree(ADD_ON, folder, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "LICENSE", folder)
        (folder / "wheels").mkdir()
        bundled = collect_wheels(folder / "wheels", target, versions, prebuilt)
        manifest = folder / "blender_manifest.toml"
        listed = "".join(f'    "./wheels/{wheel.name}",\n' for wheel in bundled)
        text = manifest.read_text(encoding="utf-8").partition("\n# `make blender`")[0]
        text += f'platforms = ["{target}"]\nwheels = [\n{listed}]\n'
        manifest.write_text(text, encoding="utf-8")
        version = next(line.split('"')[1] for line in text.splitlines() if line.startswith("version = "))
        archive = into / f"igl_linabf-{version}-{target}.zip"
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
            for path in sorted(folder.rglob("*")):
                if path.is_file():
                    file.write(path, path.relative_to(folder))
    return archive


def make_blender_environment(folder: Path) -> None:
    """Create a virtual environment with Blender as a module, unless it exists."""
    python = folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    known = [python, "-c", "import importlib.util as u; raise SystemExit(u.find_spec('bpy') is None)"]
    if subprocess.run(known, check=False).returncode:
        subprocess.run([python, "-m", "pip", "install", "-q", BPY], check=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--platform", choices=sorted(PIP_PLATFORMS), default=current_platform())
    parser.add_argument(
        "--python", action="append", help=f"Python versions of Blender (default: {', '.join(NUMPY)})"
    )
    parser.add_argument(
        "--wheels", type=Path, metavar="FOLDER", help="use the wheels of igl_linabf in FOLDER"
    )
    parser.add_argument("--into", type=Path, default=ROOT / "dist")
    parser.add_argument("--blender", type=Path, metavar="FOLDER", help="only create an environment with bpy")
    options = parser.parse_args()
    if options.blender:
        make_blender_environment(options.blender)
        return 0
    archive = build(options.platform, options.python, options.into, options.wheels)
    print(f"wrote {archive}, {archive.stat().st_size / 1e6:.0f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
