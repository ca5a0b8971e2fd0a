"""Work that is shared out to threads; NumPy and the core let several of them run at a time."""

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import copy_context
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")

# Threads at most. With fewer, cores idle; more wait for Python's lock. benchmarks/many.py has the times of
# many meshes, and OMP_NUM_THREADS limits them further.
MOST_THREADS = 8


def in_threads(work: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
    """Results of `work` in the order of `items`; every thread has a copy of the caller's context.

    There are as many threads as cores, or as OMP_NUM_THREADS says.
    """
    given = list(items)
    wanted = os.environ.get("OMP_NUM_THREADS", "")
    if wanted.isdecimal() and int(wanted):
        cores = int(wanted)
    else:  # those that the process may use, where the system says it
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    threads = min(cores, len(given), MOST_THREADS)
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
