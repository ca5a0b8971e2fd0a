"""Build the extension for Blender: `make blender`.

The archive holds the add-on, this package, and the wheels that it needs, for one platform: Blender has
NumPy, and nothing is compiled or downloaded when it is installed.

    python scripts/blender_extension.py [--platform linux-x64|macos-arm64|windows-x64] [--python 3.11]
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

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "blender" / "igl_linabf"
PIP = {  # Blender's name of a platform, and pip's names of it
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux2014_x86_64"),
    "macos-arm64": ("macosx_12_0_arm64", "macosx_11_0_arm64"),
    "windows-x64": ("win_amd64",),
}
IN_BLENDER = {"numpy"}  # of its own version
BPY = "bpy>=4.2,<6"
SOURCE_ONLY = ("rectpack>=0.2.2",)  # pure Python, and published without a wheel
ONLY_NUMPY = "numpy<2"  # which Blender 4.2 to 5.0 have


def here() -> str:
    """Blender's name of this platform."""
    system = {"Linux": "linux", "Darwin": "macos", "Windows": "windows"}[platform.system()]
    return f"{system}-{'arm64' if platform.machine() in ('arm64', 'aarch64') else 'x64'}"


def wheels(folder: Path, target: str, python: str) -> list[Path]:
    """The wheels of this package and of all that it needs, without NumPy's."""
    pip = [sys.executable, "-m", "pip"]
    subprocess.run([*pip, "wheel", "-q", "--no-deps", "-w", folder, ROOT, *SOURCE_ONLY], check=True)
    names = [word for name in PIP[target] for word in ("--platform", name)]
    command = [*pip, "download", "-q", "--only-binary", ":all:", "--python-version", python, *names]
    subprocess.run([*command, "-d", folder, *folder.glob("*.whl"), ONLY_NUMPY], check=True)
    for wheel in folder.glob("*.whl"):
        if wheel.name.split("-")[0].lower() in IN_BLENDER:
            wheel.unlink()
    return sorted(folder.glob("*.whl"))


def build(target: str, python: str, into: Path) -> Path:
    """Write the archive for a platform; its path."""
    into.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "igl_linabf"
        shutil.copytree(SOURCE, folder, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "LICENSE", folder)
        (folder / "wheels").mkdir()
        held = wheels(folder / "wheels", target, python)
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
    parser.add_argument("--python", default="3.11", help="Blender's (default: %(default)s)")
    parser.add_argument("--into", type=Path, default=ROOT / "dist")
    parser.add_argument("--blender", type=Path, metavar="FOLDER", help="make an environment with bpy instead")
    options = parser.parse_args()
    if options.blender:
        with_blender(options.blender)
        return 0
    archive = build(options.platform, options.python, options.into)
    print(f"wrote {archive}, {archive.stat().st_size / 1e6:.0f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
