"""Report the progress of long computations, and measure the times of their stages."""

import multiprocessing
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from dataclasses import dataclass
from time import perf_counter
from typing import Any, Literal

from .cleanup import undo_at_interrupt

_seconds: ContextVar[dict[str, float] | None] = ContextVar("seconds", default=None)


@contextmanager
def stopwatch(*stages: str) -> Iterator[dict[str, float]]:
    """Collect the seconds that `time_stage` measures during the `with` block, with 0 for unused `stages`."""
    seconds = dict.fromkeys(stages, 0.0)
    token = _seconds.set(seconds)
    try:
        yield seconds
    finally:
        _seconds.reset(token)


@contextmanager
def time_stage(stage: str) -> Iterator[None]:
    """Add the duration of the `with` block to the seconds of `stage` in the current `stopwatch`."""
    start = perf_counter()
    yield
    seconds = _seconds.get()
    if seconds is not None:
        seconds[stage] = seconds.get(stage, 0.0) + perf_counter() - start


Progress = Callable[[str, float], None] | Literal[False] | None

SECONDS_WITHOUT_BAR = 2.0  # delay before a progress bar appears, so that short computations show none


@dataclass
class _Report:
    """The state of a progress report: callback (or None), fraction done, and end of the current part."""

    show: Callable[[str, float], None] | None
    done: float = 0.0
    end: float = 1.0


class _Bar:
    """A progress bar of the package `rich` on stderr, which appears after `SECONDS_WITHOUT_BAR`."""

    def __init__(self) -> None:
        self._start = perf_counter()
        self._bar: Any = None  # `rich` is imported when the bar appears
        self._ended = False

    def __call__(self, stage: str, done: float) -> None:
        if done >= 1:  # close the bar at once, because the caller may print next
            self.close()
        if self._ended:
            return
        if self._bar is None:
            if perf_counter() - self._start < SECONDS_WITHOUT_BAR:
                return
            from rich.console import Console
            from rich.progress import Progress as Bar

            self._bar = Bar(console=Console(stderr=True), transient=True)
            self._task = self._bar.add_task(stage, total=1.0)
            self._bar.start()
        self._bar.update(self._task, description=stage, completed=done)

    def close(self) -> None:
        if self._bar is not None and not self._ended:
            self._bar.stop()
        self._ended = True

    def erase(self) -> None:
        if self._bar is not None and not self._ended:
            erase_progress_bar()


def erase_progress_bar() -> None:
    """Clear the line of the progress bar and show the cursor, without taking a lock of `rich`."""
    os.write(sys.stderr.fileno(), b"\r\x1b[2K\x1b[?25h")


_current: ContextVar[_Report | None] = ContextVar("progress", default=None)


@contextmanager
def show_progress(progress: Progress) -> Iterator[None]:
    """Show the progress that `advance` and `progress_part` report during the `with` block.

    If `progress` is callable, it is called with the name of the stage and the fraction done. None shows a bar
    if stderr is a terminal and this is the main thread of the main process; False shows nothing. Inside
    another `show_progress` block, even a silent one, None continues the outer report.
    """
    if progress is None and _current.get() is not None:
        yield
        return
    if progress is not None and progress is not False and not callable(progress):
        raise ValueError(
            f"progress is {progress!r}: give a function of the stage and the fraction done, None or False"
        )
    bar = _Bar() if progress is None and has_terminal() else None
    token = _current.set(_Report(bar or progress or None))
    try:
        with nullcontext() if bar is None else undo_at_interrupt(bar.erase):
            yield
            advance("done", 1.0)
    finally:
        _current.reset(token)
        if bar is not None:
            bar.close()


def advance(stage: str, share: float) -> None:
    """Report that `stage` has done `share` of the remaining current part; 1 completes the part."""
    report = _current.get()
    if report is not None:
        report.done = report.end if share == 1 else report.done + share * (report.end - report.done)
        if report.show is not None:
            report.show(stage, report.done)


@contextmanager
def progress_part(stage: str, end: float) -> Iterator[None]:
    """Declare that the `with` block ends at the fraction `end` of the whole computation."""
    report = _current.get()
    if report is None:
        yield
        return
    whole, report.end = report.end, min(max(end, report.done), report.end)
    advance(stage, 0.0)
    try:
        yield
        advance(stage, 1.0)
    finally:
        report.end = whole


def has_terminal() -> bool:
    """Return True if a progress bar may be shown: stderr is a terminal, in the main thread and process."""
    return (
        sys.stderr is not None
        and sys.stderr.isatty()
        and threading.current_thread() is threading.main_thread()
        and multiprocessing.parent_process() is None
    )


@contextmanager
def count_steps(stage: str, total: int, progress: Progress) -> Iterator[Callable[[], None]]:
    """Yield a function to call after each of `total` items, and show how many items are complete.

    If `progress` is callable, it is called with the name of the stage and the fraction done. None shows a bar
    if stderr is a terminal; False shows nothing.
    """
    done = 0
    if progress is not None or not has_terminal():

        def count_one() -> None:
            nonlocal done
            done += 1
            if progress:
                progress(stage, done / total)

        yield count_one
        return

    from rich import progress as rich
    from rich.console import Console

    class Rate(rich.ProgressColumn):
        def render(self, task: rich.Task) -> str:
            return "" if task.speed is None else f"{task.speed:.3g} a second"

    columns = (
        rich.TextColumn("{task.description}"),
        rich.BarColumn(),
        rich.MofNCompleteColumn(),
        Rate(),
        rich.TimeRemainingColumn(),
    )
    bar = rich.Progress(*columns, console=Console(stderr=True), transient=True, speed_estimate_period=60)
    with bar, undo_at_interrupt(erase_progress_bar):
        task = bar.add_task(stage, total=total)
        yield lambda: bar.advance(task)
