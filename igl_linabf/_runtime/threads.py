"""Run functions in threads, if they spend their time in NumPy and the core without the GIL."""

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import copy_context
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")

MAX_THREADS = 8  # additional threads only wait for the GIL, see benchmarks/many.py


def map_in_threads(work: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
    """Yield `work(item)` for all items in order, computed in threads with copies of the caller's context.

    The number of threads is OMP_NUM_THREADS or the number of cores, at most `MAX_THREADS`.
    """
    given = list(items)
    wanted = os.environ.get("OMP_NUM_THREADS", "")
    if wanted.isdecimal() and int(wanted):
        cores = int(wanted)
    else:  # the cores available to this process, if the system reports them
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    threads = min(cores, len(given), MAX_THREADS)
    if threads < 2:
        yield from map(work, given)
        return
    with ThreadPoolExecutor(threads) as pool:
        futures: list[Future[R]] = [pool.submit(copy_context().run, work, item) for item in given]
        try:
            for future in futures:
                yield future.result()
        finally:  # after an error, cancel the items that have not started
            pool.shutdown(wait=False, cancel_futures=True)
