"""Work that is shared out to threads; NumPy and the compiled loops let several of them run at a time."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import copy_context
from functools import cache
from threading import Thread
from typing import Any, Generic, TypeVar

T = TypeVar("T")
R = TypeVar("R")

MOST_THREADS = 8  # threads; more would wait for Python's lock


def in_threads(work: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
    """Results of `work` in the order of `items`; every thread has a copy of the caller's context."""
    given = list(items)
    threads = min(_cores(), len(given), MOST_THREADS)
    if threads < 2:
        yield from map(work, given)
        return
    with ThreadPoolExecutor(threads) as pool:
        futures: list[Future[R]] = [pool.submit(copy_context().run, work, item) for item in given]
        try:
            for future in futures:
                yield future.result()
        finally:  # what has not begun is not needed after an error
            pool.shutdown(wait=False, cancel_futures=True)


class Begun(Generic[R]):
    """Work in a thread of its own, with a copy of the caller's context; `result` waits for it."""

    def __init__(self, work: Callable[[], R]) -> None:
        self._made: list[R] = []
        self._errors: list[BaseException] = []
        _working.add(self)
        self._thread = Thread(target=copy_context().run, args=(self._run, work))
        self._thread.start()

    def _run(self, work: Callable[[], R]) -> None:
        try:
            self._made.append(work())
        except BaseException as error:
            self._errors.append(error)
        finally:
            _working.discard(self)

    def result(self) -> R:
        self._thread.join()
        if self._errors:
            raise self._errors[0]
        return self._made[0]


_working: set[Begun[Any]] = set()


@cache
def _helpers() -> ThreadPoolExecutor:
    """Threads that wait for work: to wake one takes less time than to start one."""
    return ThreadPoolExecutor(MOST_THREADS - 1, thread_name_prefix="igl_linabf")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helpers.cache_clear)  # only the thread that forks goes on there


def at_once(work: Callable[[T], R], items: Sequence[T]) -> list[R]:
    """As `in_threads`, for short work: the caller's thread takes part, and all of it is done at the end.

    Work that was `begun` keeps its core: others wait for it.
    """
    threads = min(_cores() - len(_working), len(items), MOST_THREADS) if len(items) > 1 else 1
    if threads < 2:
        return list(map(work, items))
    made: dict[int, R] = {}
    todo = iter(range(len(items)))

    def some() -> None:
        for k in todo:
            made[k] = work(items[k])

    asked = [_helpers().submit(copy_context().run, some) for _ in range(threads - 1)]
    try:
        some()
    finally:
        errors = [future.exception() for future in asked if not future.cancel()]  # for those nothing is left
    for error in filter(None, errors):
        raise error
    return [made[k] for k in range(len(items))]


def begun(work: Callable[[], R]) -> Begun[R] | None:
    """Begin `work` if there is a core for it."""
    return Begun(work) if _cores() > 1 else None


def _cores() -> int:
    """How many cores this process is to use: as many as it may, or as OMP_NUM_THREADS says."""
    wanted = os.environ.get("OMP_NUM_THREADS", "")
    if wanted.isdecimal() and int(wanted):
        return int(wanted)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
