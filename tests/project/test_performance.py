"""docs/performance.md is complete, and its benchmark measures correctly."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from time import process_time

import numpy as np
import performance
import pytest
from conftest import ROOT, bumps
from pages import replace_between_marks


def test_a_new_run_replaces_only_its_figures(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- one -->\nold\n<!-- end of one -->\nb\n<!-- two -->\n<!-- end of two -->\n")
    replace_between_marks(page, "two", "second")
    replace_between_marks(page, "one", "first")
    replace_between_marks(page, "one", "first")
    assert page.read_text() == (
        "a\n<!-- one -->\nfirst\n\n<!-- end of one -->\nb\n<!-- two -->\nsecond\n\n<!-- end of two -->\n"
    )


def test_a_ratio_lies_within_its_interval_which_narrows() -> None:
    rng = np.random.default_rng(0)
    widths = []
    for n in (5, 50):
        ratio, _, rest = (
            performance.ratio(2 + rng.random(n), 1 + rng.random(n)).replace("*", "").partition(" (")
        )
        low, high = map(float, rest.rstrip(")").split(" to "))
        assert low <= float(ratio) <= high
        widths.append(high - low)
    assert widths[1] < widths[0]


def test_every_method_is_timed_the_requested_number_of_times() -> None:
    taken = performance.time_calls(performance.make_calls(*bumps(100)), 2, process_time)
    assert {"igl.lscm", "linabf", "abf", "the next of a Flattener"} <= set(taken)
    assert all(len(seconds) == 2 and (seconds >= 0).all() for seconds in taken.values())


@pytest.mark.slow
def test_the_peak_memory_includes_the_call() -> None:
    code = "import performance as p; import numpy as np; a = p.peak_memory(); np.ones(20_000_000); "
    code += "print(p.peak_memory() - a)"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", code]  # in a new process, whose peak memory is low
    output = subprocess.run(
        command, capture_output=True, encoding="utf-8", env=environment, check=True
    ).stdout
    assert 0.9 < int(output.split()[-1]) / 160e6 < 1.5


def test_the_page_has_every_table() -> None:
    page = (ROOT / "docs" / "performance.md").read_text()
    for title in (
        "Time over `igl.lscm`",
        "Where `linabf` spends its time",
        "Growth",
        "Memory at the peak",
        "Other programs",
    ):
        assert f"## {title}" in page
    assert page.count("| igl_face") > 4
    assert "`python benchmarks/performance.py" in page and "`python benchmarks/hierarchy.py" in page
