"""Work in a process of its own, for code that may crash, hang, or not go together with other libraries."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
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
        process = None
        try:
            with _held_back():
                process = subprocess.Popen(
                    command,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.PIPE,
                    text=True,
                )
            _, stderr = process.communicate(timeout=timeout)
        except BaseException as error:
            if process is not None:
                process.kill()
                process.communicate()
            if isinstance(error, subprocess.TimeoutExpired):
                raise RuntimeError(f"{name} did not end within {timeout:g} seconds") from None
            raise
        if process.returncode != 0 or not made.exists():
            said = (stderr.strip() or f"exit code {process.returncode}").splitlines()[-1]
            raise RuntimeError(f"{name} failed: {said}")
        with np.load(made) as result:
            return dict(result)


@contextmanager
def _held_back() -> Iterator[None]:
    """Ctrl-C takes effect after the block: a process is not started and lost before it has a name."""
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield
        return
    came: list[tuple[int, FrameType | None]] = []
    signal.signal(signal.SIGINT, lambda number, frame: came.append((number, frame)))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if came:
        before(*came[0])


def serve(functions: dict[str, Callable[[Arrays], Arrays]]) -> None:
    """Do what the command line of `run_apart` asks for."""
    name, given, made = sys.argv[1:]
    with np.load(given) as arrays:
        result = functions[name](dict(arrays))
    np.savez(made, **result)
