"""Run tests of the core with AddressSanitizer and UBSan: `make sanitize`, on Linux.

The core is built with both into an environment of its own, `.venv/sanitize`, which has `.venv`'s packages.
The first thing that a sanitizer finds ends the tests.
"""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PLACE = ROOT / ".venv" / "sanitize"
PYTHON = PLACE / "bin" / "python"
BUILD = (
    *("--no-build-isolation", "--no-deps", "-C", "build-dir=build/sanitize"),
    *("-C", "cmake.define.SANITIZE=ON", "-C", "cmake.build-type=Debug"),
)
# libstdc++ before the first exception, or the sanitizer does not know how they are thrown
RUNTIMES = ("libasan.so", "libubsan.so", "libstdc++.so.6")


def build() -> None:
    if not PYTHON.exists():
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", PLACE], check=True)
    (folder,) = PLACE.glob("lib/python3*/site-packages")
    (folder / "packages_of_venv.pth").write_text(sysconfig.get_path("purelib") + "\n")
    pip = [PYTHON, "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    subprocess.run([*pip, *BUILD, "-e", ROOT], check=True, cwd=ROOT)


def runtime(name: str) -> str:
    found = subprocess.run(
        ["c++", f"-print-file-name={name}"], stdout=subprocess.PIPE, encoding="utf-8", check=True
    )
    return os.path.realpath(found.stdout.strip())


def main() -> int:
    if not sys.platform.startswith("linux"):
        raise SystemExit(
            "sanitize: the runtimes of GCC's sanitizers are loaded first here, which takes Linux"
        )
    build()
    environment = {
        **os.environ,
        "LD_PRELOAD": " ".join(map(runtime, RUNTIMES)),
        "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1",  # Python leaves what it holds
        "UBSAN_OPTIONS": "print_stacktrace=1",
        "PYTHONMALLOC": "malloc",  # each block by itself, so that what lies beside it is known
    }
    command = [PYTHON, "-m", "pytest", "-p", "no:cacheprovider", *sys.argv[1:]]
    return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
