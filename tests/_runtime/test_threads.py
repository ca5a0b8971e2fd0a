"""Work in threads: results are in order, times are added up, and the first error ends the work."""

from __future__ import annotations

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from igl_linabf._runtime import stopwatch, time_stage
from igl_linabf._runtime.threads import map_in_threads


@pytest.fixture(autouse=True)
def four(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "4")


def test_results_of_several_threads_are_in_order() -> None:
    two = threading.Barrier(2)  # each item waits until a second item is in progress

    def work(i: int) -> tuple[int, str]:
        two.wait()
        time.sleep(0.02 * (4 - i % 4))
        return i, threading.current_thread().name

    found = list(map_in_threads(work, range(8)))
    assert [i for i, _ in found] == [*range(8)]
    assert 1 < len({name for _, name in found}) <= 4


def test_seconds_of_a_stage_add_up_over_threads() -> None:
    def work(_: int) -> None:
        with time_stage("work"):
            time.sleep(0.05)

    with stopwatch("work") as seconds:
        work(0)
        list(map_in_threads(work, range(4)))
    assert seconds["work"] > 4 * 0.05  # five calls take at least 0.05 seconds each


def test_items_that_have_not_started_are_cancelled_after_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    begun, cancelled = list[int](), threading.Event()
    shutdown = ThreadPoolExecutor.shutdown

    def record(pool: ThreadPoolExecutor, *arguments: bool, **options: bool) -> None:
        shutdown(pool, *arguments, **options)
        cancelled.set()

    def work(i: int) -> None:
        begun.append(i)
        if i == 0:
            raise RuntimeError("enough")
        cancelled.wait()

    monkeypatch.setattr(ThreadPoolExecutor, "shutdown", record)
    with pytest.raises(RuntimeError, match="enough"):
        list(map_in_threads(work, range(100)))
    assert len(begun) <= 5  # the item that fails, and an item in each thread
