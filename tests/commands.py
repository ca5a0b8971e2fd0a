"""The command: in this process, or in processes of its own."""

from __future__ import annotations

import io
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path


def run(*arguments: object) -> subprocess.CompletedProcess:
    """Run the command in this process, which spares the imports."""
    from igl_linabf.cli import main

    words = [str(argument) for argument in arguments]
    streams = [io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True) for _ in range(2)]
    with redirect_stdout(streams[0]), redirect_stderr(streams[1]):
        try:
            code = main(words)
        except SystemExit as end:  # of the parser
            code = end.code
    printed, said = (stream.buffer.getvalue().decode("utf-8") for stream in streams)
    return subprocess.CompletedProcess(words, code, printed, without_cholmod_warning(said))


def run_apart(*arguments: object) -> subprocess.CompletedProcess:
    """Run the command as a user does, in a process of its own."""
    command = [sys.executable, "-m", "igl_linabf", *map(str, arguments)]
    process = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=500)
    process.stderr = without_cholmod_warning(process.stderr)
    return process


def without_cholmod_warning(said: str) -> str:
    """Drop the line that tells that the tests run without CHOLMOD."""
    lines = said.splitlines(keepends=True)
    return "".join(line for line in lines if "warning: scikit-sparse is not" not in line)


def of_session(session: int) -> list[str]:
    """Processes of a session that are still there."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            state, _, _, its = (folder / "stat").read_text().rpartition(")")[2].split()[:4]
            command = (folder / "cmdline").read_text()
            if int(its) == session and state != "Z" and command:  # the kernel clears it when one ends
                found.append(command)
        except (FileNotFoundError, ProcessLookupError):
            continue
    return found
