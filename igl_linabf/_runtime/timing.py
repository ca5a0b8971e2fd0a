"""Times of stages."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from time import perf_counter

_seconds: ContextVar[dict[str, float] | None] = ContextVar("seconds", default=None)


@contextmanager
def stopwatch(*stages: str) -> Iterator[dict[str, float]]:
    """Collect the seconds that `timed` measures in the block; 0 for `stages` that do not run."""
    seconds = dict.fromkeys(stages, 0.0)
    token = _seconds.set(seconds)
    try:
        yield seconds
    finally:
        _seconds.reset(token)


@contextmanager
def timed(stage: str) -> Iterator[None]:
    """Add the seconds that the block takes to those of `stage`."""
    start = perf_counter()
    yield
    seconds = _seconds.get()
    if seconds is not None:
        seconds[stage] = seconds.get(stage, 0.0) + perf_counter() - start
