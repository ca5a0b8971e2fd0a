"""Work in threads: in order, timed where it was called, and at an end with the first error."""

from __future__ import annotations

import threading
import time

import pytest

from igl_linabf._runtime import stopwatch, timed
from igl_linabf._runtime.threads import in_threads


@pytest.fixture(autouse=True)
def four(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "4")


def test_results_come_in_order_from_several_threads() -> None:
    def work(i: int) -> tuple[int, str]:
        time.sleep(0.02 * (4 - i % 4))
        return i, threading.current_thread().name

    found = list(in_threads(work, range(8)))
    assert [i for i, _ in found] == [*range(8)]
    assert 1 < len({name for _, name in found}) <= 4


def test_seconds_of_a_stage_add_up_over_threads() -> None:
    def work(_: int) -> None:
        with timed("work"):
            time.sleep(0.05)

    with stopwatch("work") as seconds:
        work(0)
        list(in_threads(work, range(4)))
    assert seconds["work"] > 4 * 0.05  # of five


def test_what_has_not_begun_is_left_after_an_error() -> None:
    begun = list[int]()

    def work(i: int) -> None:
        begun.append(i)
        time.sleep(0.05)
        if i == 0:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        list(in_threads(work, range(100)))
    time.sleep(0.3)
    assert len(begun) < 20
