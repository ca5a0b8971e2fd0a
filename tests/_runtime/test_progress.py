"""Progress of long computations: fractions rise to one, a terminal shows a bar, and a log shows nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import igl
import pytest
from conftest import load

from igl_linabf import flatten, unwrap
from igl_linabf._runtime import progress_part, show_progress

SCRIPT = """
import sys, igl
from igl_linabf import unwrap
from igl_linabf._runtime import progress
progress.SECONDS_WITHOUT_BAR = float(sys.argv[1])
unwrap(*igl.upsample(*igl.icosahedron(), 3))
"""


class Record:
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
        (lambda record: flatten(V, F, progress=record), {"check", "step", "chord", "layout", "done"}),
        (lambda record: flatten(V, F, method="abf", progress=record), {"anchored", "layout", "done"}),
        (lambda record: flatten(V, F, method="lscm", progress=record), {"done"}),
        (lambda record: unwrap(*closed, progress=record), {"seams", "charts", "layout", "packing", "done"}),
    ):
        record = Record()
        call(record)
        assert stages <= set(record.stages)
        assert record.fractions == sorted(record.fractions)
        assert 0 <= record.fractions[0] <= record.fractions[-1] == 1


def test_a_nested_call_fills_its_part_of_the_progress() -> None:
    record = Record()
    with show_progress(record), progress_part("half", 0.5):
        flatten(*load("bumps"))
    assert {"half", "layout"} <= set(record.stages)
    assert record.fractions == sorted(record.fractions)
    inside = [f for stage, f in zip(record.stages, record.fractions, strict=True) if stage == "layout"]
    assert 0 < inside[0] <= inside[-1] <= 0.5
    assert record.fractions[-1] == 1


def test_an_exception_of_a_callback_ends_the_work() -> None:
    def stop(stage: str, fraction: float) -> None:
        if stage == "charts":
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        unwrap(*igl.icosahedron(), progress=stop)
    record = Record()  # the failed computation does not affect the progress of the next one
    flatten(*load("bumps"))
    assert record.stages == []


def run_on_terminal(script: str, *arguments: str) -> tuple[str, str]:
    """Run a script; return its stderr, which is a terminal, and its stdout, which is a pipe."""
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
    except OSError:  # Linux raises an error when a terminal is closed
        pass
    printed, _ = process.communicate(timeout=500)
    assert process.returncode == 0
    return text.decode(), printed.decode()


terminals = pytest.mark.skipif(not hasattr(os, "openpty"), reason="there are no pseudo-terminals")


@terminals
@pytest.mark.parametrize(("patience", "shown"), [(0, True), (1e9, False)])
def test_a_terminal_shows_a_bar_after_a_while(patience: float, shown: bool) -> None:
    text, _ = run_on_terminal(SCRIPT, str(patience))
    assert ("seams" in text and "%" in text) == shown


COMMAND = """
import sys
from igl_linabf._runtime import progress
from igl_linabf.cli import main
progress.SECONDS_WITHOUT_BAR = 0
shown = []
show = progress._Bar.__call__
def record(bar, stage, done):
    shown.append((bar, stage, done))
    show(bar, stage, done)
progress._Bar.__call__ = record
code = main(sys.argv[1:])
if shown:
    print("BARS", len({id(bar) for bar, _, _ in shown}))
for _, stage, done in shown:
    print("SHOWN", stage, done)
sys.exit(code)
"""


@pytest.mark.slow
@terminals
def test_one_bar_covers_a_command_from_reading_to_writing(tmp_path: Path) -> None:
    mesh, out = tmp_path / "disk.obj", tmp_path / "map.obj"
    igl.writeOBJ(str(mesh), *load("bumps"))
    stages = {
        "flatten": ["reading", "flattening", "layout", "writing"],
        "unwrap": ["reading", "seams", "packing", "writing"],
    }
    for command, expected in stages.items():
        text, printed = run_on_terminal(COMMAND, command, str(mesh), "-o", str(out))
        assert "reading" in text and "%" in text
        record = [line.split() for line in printed.splitlines() if line.startswith("SHOWN")]
        assert "BARS 1" in printed
        seen = list(dict.fromkeys(stage for _, stage, _ in record))
        assert [stage for stage in seen if stage in expected] == expected
        fractions = [float(done) for _, _, done in record]
        assert fractions == sorted(fractions)
        assert fractions[-1] == 1
        assert printed.index("F/3nt") < printed.index("SHOWN")  # stdout, which is a pipe, receives the table
        for silent in ("--quiet", "--json"):
            text, printed = run_on_terminal(COMMAND, command, str(mesh), "-o", str(out), silent)
            assert "%" not in text and "SHOWN" not in printed


def test_a_log_contains_no_progress_bar() -> None:
    process = subprocess.run(
        [sys.executable, "-c", SCRIPT, "0"], capture_output=True, encoding="utf-8", timeout=500
    )
    assert process.returncode == 0
    lines = process.stderr.splitlines()
    assert [line for line in lines if "scikit-sparse" not in line and "warn" not in line] == []
    assert process.stdout == ""
