"""Calls of the command `igl-linabf`, in this process or in a new process."""

from __future__ import annotations

import io
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path


def run(*arguments: object) -> subprocess.CompletedProcess:
    """Run the command in this process, which saves the time of the imports."""
    from igl_linabf.cli import main

    words = [str(argument) for argument in arguments]
    streams = [io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True) for _ in range(2)]
    with redirect_stdout(streams[0]), redirect_stderr(streams[1]):
        try:
            code = main(words)
        except SystemExit as end:  # the parser exits on an invalid argument
            code = end.code
    printed, said = (stream.buffer.getvalue().decode("utf-8") for stream in streams)
    return subprocess.CompletedProcess(words, code, printed, remove_cholmod_warning(said))


def run_in_new_process(*arguments: object) -> subprocess.CompletedProcess:
    """Run the command in a new process, as a user does."""
    command = [sys.executable, "-m", "igl_linabf", *map(str, arguments)]
    process = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=500)
    process.stderr = remove_cholmod_warning(process.stderr)
    return process


def remove_cholmod_warning(said: str) -> str:
    """Remove the warning that scikit-sparse, and therefore CHOLMOD, is not installed."""
    lines = said.splitlines(keepends=True)
    return "".join(line for line in lines if "warning: scikit-sparse is not" not in line)


def list_session_processes(session: int) -> list[str]:
    """Return the command lines of the running processes of a session."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            state, _, _, its = (folder / "stat").read_text().rpartition(")")[2].split()[:4]
            command = (folder / "cmdline").read_text()
            # the kernel clears the command line of a process that ends
            if int(its) == session and state != "Z" and command:
                found.append(command)
        except (FileNotFoundError, ProcessLookupError):
            continue
    return found
