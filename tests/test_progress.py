"""What is told of a long computation: fractions that rise to one, a bar on a terminal, nothing in a log."""

from __future__ import annotations

import os
import subprocess
import sys

import igl
import pytest
from conftest import load

from igl_linabf import flatten, unwrap

SCRIPT = """
import sys, igl
from igl_linabf import unwrap
from igl_linabf._runtime import progress
progress.PATIENCE = float(sys.argv[1])
unwrap(*igl.upsample(*igl.icosahedron(), 3))
"""


class Told:
    def __init__(self) -> None:
        self.stages: list[str] = []
        self.fractions: list[float] = []

    def __call__(self, stage: str, fraction: float) -> None:
        self.stages.append(stage)
        self.fractions.append(fraction)


def test_fractions_rise_to_one() -> None:
    V, F = load("bumps")
    closed = igl.upsample(*igl.icosahedron(), 2)
    for call, stages in (
        (lambda told: flatten(V, F, progress=told), {"check", "step", "chord", "layout", "done"}),
        (lambda told: flatten(V, F, "abf", progress=told), {"anchored", "layout", "done"}),
        (lambda told: flatten(V, F, "lscm", progress=told), {"done"}),
        (lambda told: unwrap(*closed, progress=told), {"seams", "charts", "layout", "packing", "done"}),
    ):
        told = Told()
        call(told)
        assert stages <= set(told.stages)
        assert told.fractions == sorted(told.fractions)
        assert 0 <= told.fractions[0] <= told.fractions[-1] == 1


def test_what_a_callback_raises_ends_the_work() -> None:
    def stop(stage: str, fraction: float) -> None:
        if stage == "charts":
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        unwrap(*igl.icosahedron(), progress=stop)
    told = Told()  # nothing of it is left behind
    flatten(*load("bumps"))
    assert told.stages == []


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="there are no pseudo-terminals")
@pytest.mark.parametrize(("patience", "shown"), [(0, True), (1e9, False)])
def test_a_bar_on_a_terminal_after_a_while(patience: float, shown: bool) -> None:
    ours, theirs = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT, str(patience)], stderr=theirs, env={**os.environ, "TERM": "xterm"}
    )
    os.close(theirs)
    text = b""
    try:
        while chunk := os.read(ours, 4096):
            text += chunk
    except OSError:  # so Linux says that the other end was closed
        pass
    assert process.wait(timeout=60) == 0
    assert (b"seams" in text and b"%" in text) == shown


def test_nothing_in_a_log() -> None:
    process = subprocess.run([sys.executable, "-c", SCRIPT, "0"], capture_output=True, text=True, timeout=60)
    assert process.returncode == 0
    lines = process.stderr.splitlines()
    assert [line for line in lines if "scikit-sparse" not in line and "warn" not in line] == []
    assert process.stdout == ""
