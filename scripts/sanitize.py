"""Run tests of the core with AddressSanitizer and UBSan: `make sanitize`, on Linux.

The core is built with both sanitizers in the separate environment `.venv/sanitize`, which shares the packages
of `.venv`. The tests end at the first finding.
"""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / ".venv" / "sanitize"
PYTHON = FOLDER / "bin" / "python"
BUILD = (
    *("--no-build-isolation", "--no-deps", "-C", "build-dir=build/sanitize"),
    *("-C", "cmake.define.SANITIZE=ON", "-C", "cmake.build-type=Debug"),
)
# libstdc++ must be loaded before the first exception, so that the sanitizer can intercept it
RUNTIMES = ("libasan.so", "libubsan.so", "libstdc++.so.6")


def build() -> None:
    """Create the environment, and build the core with the sanitizers."""
    if not PYTHON.exists():
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", FOLDER], check=True)
    (folder,) = FOLDER.glob("lib/python3*/site-packages")
    (folder / "packages_of_venv.pth").write_text(sysconfig.get_path("purelib") + "\n")
    pip = [PYTHON, "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    subprocess.run([*pip, *BUILD, "-e", ROOT], check=True, cwd=ROOT)


def find_runtime(name: str) -> str:
    """Return the path of a library of the compiler."""
    found = subprocess.run(
        ["c++", f"-print-file-name={name}"], stdout=subprocess.PIPE, encoding="utf-8", check=True
    )
    return os.path.realpath(found.stdout.strip())


def main() -> int:
    if not sys.platform.startswith("linux"):
        raise SystemExit("sanitize: preloading the runtimes of the sanitizers of GCC works on Linux only")
    build()
    environment = {
        **os.environ,
        "LD_PRELOAD": " ".join(map(find_runtime, RUNTIMES)),
        "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1",  # Python leaks at exit
        "UBSAN_OPTIONS": "print_stacktrace=1",
        "PYTHONMALLOC": "malloc",  # separate blocks, so that overruns are detected
    }
    command = [PYTHON, "-m", "pytest", "-p", "no:cacheprovider", *sys.argv[1:]]
    return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
