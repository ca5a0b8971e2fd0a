"""Commands in processes of their own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def run(*arguments: object) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "igl_linabf", *map(str, arguments)]
    process = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=120)
    # where the tests run without CHOLMOD, that is said first
    lines = process.stderr.splitlines(keepends=True)
    process.stderr = "".join(line for line in lines if "warning: scikit-sparse is not" not in line)
    return process


def of_session(session: int) -> list[str]:
    """Processes of a session that are still there."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            state, _, _, its = (folder / "stat").read_text().rpartition(")")[2].split()[:4]
            if int(its) == session and state != "Z":
                found.append((folder / "cmdline").read_text())
        except (FileNotFoundError, ProcessLookupError):
            continue
    return found
