"""Work in a process of its own, for code that may crash, hang, or not go together with other libraries."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

Arrays = dict[str, Any]  # of NumPy arrays


def run_apart(module: str, name: str, arrays: Arrays, timeout: float | None = None) -> Arrays:
    """Run `python -m MODULE NAME IN.npz OUT.npz`; `serve` is its other side.

    Raises
    ------
    RuntimeError
        It failed, with what it said last, or took longer than `timeout` seconds.
    """
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder) / "in.npz", Path(folder) / "out.npz"
        np.savez(given, **arrays)
        command = [sys.executable, "-m", module, name, str(given), str(made)]
        try:
            process = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
        except subprocess.TimeoutExpired:
            raise RuntimeError(f"{name} did not end within {timeout:g} seconds") from None
        if process.returncode != 0 or not made.exists():
            said = (process.stderr.strip() or f"exit code {process.returncode}").splitlines()[-1]
            raise RuntimeError(f"{name} failed: {said}")
        with np.load(made) as result:
            return dict(result)


def serve(functions: dict[str, Callable[[Arrays], Arrays]]) -> None:
    """Do what the command line of `run_apart` asks for."""
    name, given, made = sys.argv[1:]
    with np.load(given) as arrays:
        result = functions[name](dict(arrays))
    np.savez(made, **result)
