"""Work of many equal parts: a bar with how many are done, their rate, and how long it takes still."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .cleanup import undone_at_once
from .progress import Progress, on_terminal, wipe


@contextmanager
def counting(stage: str, total: int, progress: Progress) -> Iterator[Callable[[], None]]:
    """Yields what to call for each part that is done.

    A callable gets the name of the stage and the fraction done. None shows a bar where stderr is a terminal;
    False shows nothing.
    """
    done = 0
    if progress is not None or not on_terminal():

        def tell() -> None:
            nonlocal done
            done += 1
            if progress:
                progress(stage, done / total)

        yield tell
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
    with bar, undone_at_once(wipe):
        task = bar.add_task(stage, total=total)
        yield lambda: bar.advance(task)
