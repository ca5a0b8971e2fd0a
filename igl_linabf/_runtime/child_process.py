"""Work in a process of its own, for code that may crash, hang, or not go together with other libraries."""

from __future__ import annotations

import os
import secrets
import shutil
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from subprocess import DEVNULL, PIPE, Popen, TimeoutExpired
from types import FrameType
from typing import Any

import numpy as np

from .cleanup import undone_at_once

Arrays = dict[str, Any]  # of NumPy arrays


def run_in_child_process(module: str, name: str, arrays: Arrays, timeout: float | None = None) -> Arrays:
    """Run `python -m MODULE NAME IN.npz OUT.npz`; `run_as_child_process` is its other side.

    Raises
    ------
    RuntimeError
        It failed, with what it said last, or took longer than `timeout` seconds.
    """
    started: list[Popen[str]] = []
    with _temporary_folder() as folder, undone_at_once(partial(_kill, started)):
        given, made = folder / "in.npz", folder / "out.npz"
        np.savez(given, **arrays)
        command = [sys.executable, "-m", module, name, str(given), str(made)]
        try:
            with _interrupts_held_back():
                process = Popen(command, stdin=DEVNULL, stdout=DEVNULL, stderr=PIPE, text=True)
                started.append(process)
            _, stderr = process.communicate(timeout=timeout)
        except BaseException as error:
            for process in started:
                process.kill()
                process.communicate()
            if isinstance(error, TimeoutExpired):
                raise RuntimeError(f"{name} did not end within {timeout:g} seconds") from None
            raise
        if process.returncode != 0 or not made.exists():
            said = (stderr.strip() or f"exit code {process.returncode}").splitlines()[-1]
            raise RuntimeError(f"{name} failed: {said}")
        with np.load(made) as result:
            return dict(result)


@contextmanager
def _temporary_folder() -> Iterator[Path]:
    """As tempfile's, but with a name from the beginning on, by which it can be removed."""
    folder = Path(tempfile.gettempdir()) / f"igl_linabf-{secrets.token_hex(8)}"
    remove = partial(shutil.rmtree, folder, ignore_errors=True)
    with undone_at_once(remove):
        folder.mkdir(mode=0o700)
        try:
            yield folder
        finally:
            remove()


def _kill(started: list[Popen[str]]) -> None:
    """Not by `wait`, whose lock the interrupted thread may hold."""
    for process in started:
        process.kill()
        if os.name == "posix":
            os.waitpid(process.pid, 0)


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
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


def run_as_child_process(functions: dict[str, Callable[[Arrays], Arrays]]) -> None:
    """Do what the command line of `run_in_child_process` asks for."""
    name, given, made = sys.argv[1:]
    with np.load(given) as arrays:
        result = functions[name](dict(arrays))
    np.savez(made, **result)
