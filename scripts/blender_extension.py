"""Build the extension for Blender: `make blender`.

The archive holds the add-on, this package, and the wheels that it needs, for one platform and the Pythons of
several Blenders, each of which takes from it what fits. Blender has NumPy, and nothing is compiled or
downloaded when it is installed. This package's own wheels are built here, or found in a folder, as those for
another system have to be.

    python scripts/blender_extension.py [--python 3.11 --python 3.13]
    python scripts/blender_extension.py --platform macos-arm64|windows-x64 --wheels FOLDER
    python scripts/blender_extension.py --blender FOLDER    # a virtual environment with `bpy`, to try it in
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

from release_check import STABLE, fits, pythons

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "blender" / "igl_linabf"
PIP = {  # Blender's name of a platform, and pip's names of it
    "linux-x64": ("linux_x86_64", "manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux2014_x86_64"),
    "macos-arm64": ("macosx_12_0_arm64", "macosx_11_0_arm64"),
    "windows-x64": ("win_amd64",),
}
NUMPY = {
    "3.11": "numpy<2",
    "3.13": "numpy>=2,<2.4",
}  # of Blender 4.2 to 5.0, and from 5.1 on; its own is taken
BPY = "bpy>=4.2,<6"


def here() -> str:
    """Blender's name of this platform."""
    system = {"Linux": "linux", "Darwin": "macos", "Windows": "windows"}[platform.system()]
    return f"{system}-{'arm64' if platform.machine() in ('arm64', 'aarch64') else 'x64'}"


def own_wheels(folder: Path, versions: list[tuple[int, int]]) -> None:
    """Build this package's wheels for some Pythons, each by that one, or by one with the same stable ABI."""
    there = pythons()
    for asked in versions:
        for known, python in sorted(there.items(), key=lambda item: item[0] != asked):
            needed = not any(fits(wheel, asked) for wheel in folder.glob("*.whl"))
            if needed and (known == asked or min(known, asked) >= STABLE):
                pip = [python, "-m", "pip", "--disable-pip-version-check"]
                subprocess.run([*pip, "wheel", "-q", "--no-deps", "-w", folder, ROOT], check=True)


def wheels(folder: Path, target: str, asked: list[str] | None, ready: Path | None) -> list[Path]:
    """The wheels of this package and of all that it needs, without NumPy's."""
    versions = {text: tuple(int(part) for part in text.split(".")) for text in asked or NUMPY}
    with tempfile.TemporaryDirectory() as name:
        if ready is None and target == here():
            own_wheels(Path(name), list(versions.values()))
        own = [
            wheel for wheel in (ready or Path(name)).glob("igl_linabf-*.whl") if for_platform(wheel, target)
        ]
        for text, version in versions.items():
            mine = [wheel for wheel in own if fits(wheel, version)]
            if mine:
                download(folder, target, text, mine[0])
            elif asked:
                raise SystemExit(f"no wheel of igl_linabf for Python {text} on {target}: see --wheels")
            else:
                print(f"without Blenders of Python {text}, for which there is no wheel of igl_linabf")
    for wheel in folder.glob("numpy-*.whl"):
        wheel.unlink()
    return sorted(folder.glob("*.whl"))


def download(folder: Path, target: str, version: str, own: Path) -> None:
    """Add the wheels for a Python: one of this package, and those that it needs."""
    names = [word for name in PIP[target] for word in ("--platform", name)]
    command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "download", "-q", "-d", folder]
    command += ["--only-binary", ":all:", "--python-version", version, *names]
    subprocess.run([*command, own, NUMPY.get(version, "numpy>=2")], check=True)


def for_platform(wheel: Path, target: str) -> bool:
    system, _, machine = target.partition("-")
    tag = wheel.stem.split("-")[-1]
    return {"windows": "win", "macos": "macosx", "linux": "linux"}[system] in tag and tag.endswith(
        {"x64": ("x86_64", "amd64"), "arm64": ("arm64", "aarch64")}[machine]
    )


def build(target: str, versions: list[str] | None, into: Path, ready: Path | None) -> Path:
    """Write the archive for a platform; its path."""
    into.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "igl_linabf"
        shutil.copytree(SOURCE, folder, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "LICENSE", folder)
        (folder / "wheels").mkdir()
        held = wheels(folder / "wheels", target, versions, ready)
        manifest = folder / "blender_manifest.toml"
        listed = "".join(f'    "./wheels/{wheel.name}",\n' for wheel in held)
        said = manifest.read_text(encoding="utf-8").partition("\n# `make blender`")[0]
        said += f'platforms = ["{target}"]\nwheels = [\n{listed}]\n'
        manifest.write_text(said, encoding="utf-8")
        version = next(line.split('"')[1] for line in said.splitlines() if line.startswith("version = "))
        archive = into / f"igl_linabf-{version}-{target}.zip"
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
            for path in sorted(folder.rglob("*")):
                if path.is_file():
                    file.write(path, path.relative_to(folder))
    return archive


def with_blender(folder: Path) -> None:
    """Make a virtual environment with Blender as a module; what is there already stays."""
    python = folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    known = [python, "-c", "import importlib.util as u; raise SystemExit(u.find_spec('bpy') is None)"]
    if subprocess.run(known, check=False).returncode:
        subprocess.run([python, "-m", "pip", "install", "-q", BPY], check=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--platform", choices=sorted(PIP), default=here())
    parser.add_argument("--python", action="append", help=f"Blender's (default: {', '.join(NUMPY)})")
    parser.add_argument(
        "--wheels", type=Path, metavar="FOLDER", help="igl_linabf's wheels, instead of building"
    )
    parser.add_argument("--into", type=Path, default=ROOT / "dist")
    parser.add_argument("--blender", type=Path, metavar="FOLDER", help="make an environment with bpy instead")
    options = parser.parse_args()
    if options.blender:
        with_blender(options.blender)
        return 0
    archive = build(options.platform, options.python, options.into, options.wheels)
    print(f"wrote {archive}, {archive.stat().st_size / 1e6:.0f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
