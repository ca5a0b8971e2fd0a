"""Run tests of the core with AddressSanitizer and UBSan, then with ThreadSanitizer: `make sanitize` on Linux.

The core is built twice, each time in a separate environment in `.venv` that shares the packages of `.venv`.
Both builds also check the indices of arrays. The tests end at the first finding.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import sysconfig
from dataclasses import dataclass, field, replace
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# libstdc++ must be loaded before the first exception, so that a sanitizer can intercept the exception
STANDARD_LIBRARY = "libstdc++.so.6"
# not a race: the C library frees the memory of threads that have ended
SUPPRESSIONS = "race:_dl_deallocate_tls\n"


@dataclass(frozen=True)
class Sanitizer:
    """A build of the core with a sanitizer, and the settings of its tests.

    Attributes
    ----------
    name : str
    flags : str
        The value of -fsanitize.
    runtimes : list of str
        Libraries of the compiler, which are loaded before Python.
    environment : dict
    tests : list of str
        Arguments of pytest.
    """

    name: str
    flags: str
    runtimes: list[str]
    environment: dict[str, str]
    tests: list[str] = field(default_factory=list)

    @property
    def python(self) -> Path:
        return ROOT / ".venv" / f"sanitize-{self.name}" / "bin" / "python"

    def build(self) -> None:
        """Create the environment, and build the core with the sanitizer."""
        folder = self.python.parent.parent
        if not self.python.exists():
            subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
        (packages,) = folder.glob("lib/python3*/site-packages")
        (packages / "packages_of_venv.pth").write_text(sysconfig.get_path("purelib") + "\n")
        (folder / "suppressions").write_text(SUPPRESSIONS)
        settings = {
            "build-dir": f"build/sanitize-{self.name}",
            "cmake.define.SANITIZE": self.flags,
            "cmake.define.CHECKED": "ON",
            "cmake.build-type": "Debug",
        }
        options = [part for name, value in settings.items() for part in ("-C", f"{name}={value}")]
        pip = [self.python, "-m", "pip", "install", "-q", "--disable-pip-version-check"]
        command = [*pip, "--no-build-isolation", "--no-deps", *options, "-e", ROOT]
        subprocess.run(command, check=True, cwd=ROOT)

    def run(self) -> int:
        """Run the tests; return the exit code of pytest."""
        runtimes = map(find_runtime, [*self.runtimes, STANDARD_LIBRARY])
        environment = {
            **os.environ,
            "LD_PRELOAD": " ".join(runtimes),
            "PYTHONMALLOC": "malloc",  # one block per allocation, so that overruns are detected
            **self.environment,
        }
        # run without address randomization, as ThreadSanitizer requires
        fixed = ["setarch", platform.machine(), "-R"] if self.name == "threads" else []
        # findings are printed at once, because pytest loses captured output if the process ends
        command = [*fixed, self.python, "-m", "pytest", "-s", "-p", "no:cacheprovider", *self.tests]
        return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode


SANITIZERS = (
    Sanitizer(
        "addresses",
        "address,undefined,float-cast-overflow",
        ["libasan.so", "libubsan.so"],
        {
            # Python does not free all memory at exit
            "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1",
            "UBSAN_OPTIONS": "print_stacktrace=1",
        },
    ),
    Sanitizer(
        "threads",
        "thread",
        ["libtsan.so"],
        {
            "TSAN_OPTIONS": "halt_on_error=1:exitcode=66:suppressions=.venv/sanitize-threads/suppressions",
            "OMP_NUM_THREADS": "4",
        },
        ["tests/_core/test_core_threads.py"],
    ),
)


def find_runtime(name: str) -> str:
    """Return the path of a library of the compiler."""
    found = subprocess.run(
        ["c++", f"-print-file-name={name}"], stdout=subprocess.PIPE, encoding="utf-8", check=True
    )
    return os.path.realpath(found.stdout.strip())


def main(tests: list[str]) -> int:
    if not sys.platform.startswith("linux"):
        raise SystemExit("sanitize: preloading the runtimes of the sanitizers of GCC works on Linux only")
    for sanitizer in SANITIZERS:
        print(f"sanitize: {sanitizer.flags}", flush=True)
        sanitizer.build()
        code = sanitizer.run() if sanitizer.tests else replace(sanitizer, tests=tests).run()
        if code:
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
