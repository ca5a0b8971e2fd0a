"""Work in a process of its own, for code that may crash, hang, or not go together with other libraries."""

from __future__ import annotations

import io
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from subprocess import PIPE, Popen, TimeoutExpired
from types import FrameType
from typing import Any

import numpy as np

from .cleanup import undone_at_once

Arrays = dict[str, Any]  # of NumPy arrays


def run_in_child_process(module: str, name: str, arrays: Arrays, timeout: float | None = None) -> Arrays:
    """Run `python -m MODULE NAME`, arrays going in and out by pipes; there `run_as_child_process` answers.

    Raises
    ------
    RuntimeError
        It failed, with what it said last, or took longer than `timeout` seconds.
    """
    started: list[Popen[bytes]] = []
    with undone_at_once(partial(_kill, started)):
        try:
            with _interrupts_held_back():
                started.append(
                    Popen([sys.executable, "-m", module, name], stdin=PIPE, stdout=PIPE, stderr=PIPE)
                )
            (process,) = started
            made, said = process.communicate(_packed(arrays), timeout)
        except BaseException as error:
            for process in started:
                process.kill()
                process.communicate()
            if isinstance(error, TimeoutExpired):
                raise RuntimeError(f"{name} did not end within {timeout:g} seconds") from None
            raise
    if process.returncode != 0 or not made:
        last = (said.decode(errors="replace").strip() or f"exit code {process.returncode}").splitlines()[-1]
        raise RuntimeError(f"{name} failed: {last}")
    return _unpacked(made)


def run_as_child_process(functions: dict[str, Callable[[Arrays], Arrays]]) -> None:
    """Do what the command line of `run_in_child_process` asks for."""
    (name,) = sys.argv[1:]
    with os.fdopen(os.dup(1), "wb") as out:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what libraries print is no part of the result
        out.write(_packed(functions[name](_unpacked(sys.stdin.buffer.read()))))


def _packed(arrays: Arrays) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def _unpacked(data: bytes) -> Arrays:
    with np.load(io.BytesIO(data)) as arrays:
        return dict(arrays)


def _kill(started: list[Popen[bytes]]) -> None:
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
