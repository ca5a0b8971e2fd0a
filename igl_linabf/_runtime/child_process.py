"""Run functions in a child process, because their code may crash, hang, or conflict with libraries."""

import io
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from subprocess import PIPE, Popen, TimeoutExpired
from types import FrameType
from typing import Any

import numpy as np

from .cleanup import undo_at_interrupt

Arrays = dict[str, Any]  # NumPy arrays by name


def run_in_child_process(module: str, name: str, arrays: Arrays, timeout: float | None = None) -> Arrays:
    """Run `python -m MODULE NAME` in a child process, and pass arrays in both directions through pipes.

    The module must call `run_as_child_process`.

    Raises
    ------
    RuntimeError
        The process failed (the message contains its last line of output), or took longer than `timeout`
        seconds.
    """
    started: list[Popen[bytes]] = []
    with undo_at_interrupt(partial(_kill_processes, started)):
        try:
            with _delay_interrupts():
                started.append(
                    Popen([sys.executable, "-m", module, name], stdin=PIPE, stdout=PIPE, stderr=PIPE)
                )
            (process,) = started
            made, said = process.communicate(_pack_arrays(arrays), timeout)
        except BaseException as error:
            for process in started:
                process.kill()
                process.communicate()
                assert process.stdin is not None
                with suppress(BrokenPipeError):
                    process.stdin.close()  # raises if the child has not read all of its input
            if isinstance(error, TimeoutExpired):
                raise RuntimeError(f"{name} did not end within {timeout:g} seconds") from None
            raise
    if process.returncode != 0 or not made:
        last = (said.decode(errors="replace").strip() or f"exit code {process.returncode}").splitlines()[-1]
        raise RuntimeError(f"{name} failed: {last}")
    return _unpack_arrays(made)


def run_as_child_process(functions: dict[str, Callable[[Arrays], Arrays]]) -> None:
    """Run the function that the command line names, in a process started by `run_in_child_process`."""
    (name,) = sys.argv[1:]
    with os.fdopen(os.dup(1), "wb") as out:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # libraries must not print into the result
        out.write(_pack_arrays(functions[name](_unpack_arrays(sys.stdin.buffer.read()))))


def _pack_arrays(arrays: Arrays) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def _unpack_arrays(data: bytes) -> Arrays:
    with np.load(io.BytesIO(data)) as arrays:
        return dict(arrays)


def _kill_processes(started: list[Popen[bytes]]) -> None:
    """Kill the processes without `Popen.wait`, because the interrupted thread may hold its lock."""
    for process in started:
        process.kill()
        if os.name == "posix":
            os.waitpid(process.pid, 0)


@contextmanager
def _delay_interrupts() -> Iterator[None]:
    """Delay Ctrl-C and SIGTERM until the end of the block, so that a started process is always recorded."""
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    before = {number: handler for number, handler in handlers.items() if callable(handler)}
    if threading.current_thread() is not threading.main_thread() or not before:
        yield
        return
    came: list[tuple[int, FrameType | None]] = []
    for number in before:
        signal.signal(number, lambda number, frame: came.append((number, frame)))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if came:
        before[signal.Signals(came[0][0])](*came[0])
