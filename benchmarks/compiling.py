"""Compile programs of other authors from their sources with CMake."""

from __future__ import annotations

import subprocess
from pathlib import Path


def compile_program(folder: Path, cmake: str, sources: Path, target: str, main: str = "") -> Path:
    """Compile a target in a folder, and return the program.

    `cmake` is the text of CMakeLists.txt; "{sources}" stands for the folder of the sources. `main` is the
    text of main.cpp. A second call in the same folder compiles only changed files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    texts = {"CMakeLists.txt": cmake.format(sources=sources.resolve()), "main.cpp": main}
    for name, text in texts.items():
        path = folder / name
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
    build = folder / "build"
    for command in (
        ["cmake", "-S", folder, "-B", build, "-DCMAKE_BUILD_TYPE=Release"],
        ["cmake", "--build", build, "--target", target],
    ):
        subprocess.run(command, check=True, capture_output=True)
    return next(path for path in build.rglob(target) if path.is_file())
