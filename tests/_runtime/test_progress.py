"""What is told of a long computation: fractions that rise to one, a bar on a terminal, nothing in a log."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import igl
import pytest
from conftest import load

from igl_linabf import flatten, unwrap
from igl_linabf._runtime import progress_part, reporting

SCRIPT = """
import sys, igl
from igl_linabf import unwrap
from igl_linabf._runtime import progress
progress.SECONDS_WITHOUT_BAR = float(sys.argv[1])
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


def test_a_call_within_another_one_fills_its_part() -> None:
    told = Told()
    with reporting(told), progress_part("half", 0.5):
        flatten(*load("bumps"))
    assert {"half", "layout"} <= set(told.stages)
    assert told.fractions == sorted(told.fractions)
    inside = [f for stage, f in zip(told.stages, told.fractions, strict=True) if stage == "layout"]
    assert 0 < inside[0] <= inside[-1] <= 0.5
    assert told.fractions[-1] == 1


def test_what_a_callback_raises_ends_the_work() -> None:
    def stop(stage: str, fraction: float) -> None:
        if stage == "charts":
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        unwrap(*igl.icosahedron(), progress=stop)
    told = Told()  # nothing of it is left behind
    flatten(*load("bumps"))
    assert told.stages == []


def on_a_terminal(script: str, *arguments: str) -> tuple[str, str]:
    """What a script shows on its terminal, and what it prints into a pipe."""
    ours, theirs = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", script, *arguments],
        stdout=subprocess.PIPE,
        stderr=theirs,
        env={**os.environ, "TERM": "xterm"},
    )
    os.close(theirs)
    text = b""
    try:
        while chunk := os.read(ours, 4096):
            text += chunk
    except OSError:  # so Linux says that the other end was closed
        pass
    printed, _ = process.communicate(timeout=500)
    assert process.returncode == 0
    return text.decode(), printed.decode()


terminals = pytest.mark.skipif(not hasattr(os, "openpty"), reason="there are no pseudo-terminals")


@terminals
@pytest.mark.parametrize(("patience", "shown"), [(0, True), (1e9, False)])
def test_a_bar_on_a_terminal_after_a_while(patience: float, shown: bool) -> None:
    text, _ = on_a_terminal(SCRIPT, str(patience))
    assert ("seams" in text and "%" in text) == shown


COMMAND = """
import sys
from igl_linabf._runtime import progress
from igl_linabf.cli import main
progress.SECONDS_WITHOUT_BAR = 0
shown = []
show = progress._Bar.__call__
def told(bar, stage, done):
    shown.append((bar, stage, done))
    show(bar, stage, done)
progress._Bar.__call__ = told
code = main(sys.argv[1:])
if shown:
    print("BARS", len({id(bar) for bar, _, _ in shown}))
for _, stage, done in shown:
    print("SHOWN", stage, done)
sys.exit(code)
"""


@pytest.mark.slow
@terminals
def test_one_bar_from_reading_to_writing(tmp_path: Path) -> None:
    mesh, out = tmp_path / "disk.obj", tmp_path / "map.obj"
    igl.writeOBJ(str(mesh), *load("bumps"))
    stages = {
        "flatten": ["reading", "flattening", "layout", "writing"],
        "unwrap": ["reading", "seams", "packing", "writing"],
    }
    for command, expected in stages.items():
        text, printed = on_a_terminal(COMMAND, command, str(mesh), "-o", str(out))
        assert "reading" in text and "%" in text
        told = [line.split() for line in printed.splitlines() if line.startswith("SHOWN")]
        assert "BARS 1" in printed
        seen = list(dict.fromkeys(stage for _, stage, _ in told))
        assert [stage for stage in seen if stage in expected] == expected
        fractions = [float(done) for _, _, done in told]
        assert fractions == sorted(fractions)
        assert fractions[-1] == 1
        assert printed.index("F/3nt") < printed.index("SHOWN")  # the table is in the pipe, not on the bar
        for silent in ("--quiet", "--json"):
            text, printed = on_a_terminal(COMMAND, command, str(mesh), "-o", str(out), silent)
            assert "%" not in text and "SHOWN" not in printed


def test_nothing_in_a_log() -> None:
    process = subprocess.run(
        [sys.executable, "-c", SCRIPT, "0"], capture_output=True, encoding="utf-8", timeout=500
    )
    assert process.returncode == 0
    lines = process.stderr.splitlines()
    assert [line for line in lines if "scikit-sparse" not in line and "warn" not in line] == []
    assert process.stdout == ""
