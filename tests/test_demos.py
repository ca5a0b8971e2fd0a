"""The demos run as they are called in the README, and their numbers hold."""

from __future__ import annotations

import re
import subprocess
import sys

import igl
import numpy as np
from conftest import ROOT, load, pixels


def run(folder, *arguments: object) -> str:
    process = subprocess.run(
        [sys.executable, *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=300
    )
    assert process.returncode == 0, process.stderr
    return process.stdout


def row(text: str, label: str) -> list[float]:
    """The numbers of a table's row."""
    line = next(line for line in text.splitlines() if line.startswith(label))
    return [float(v.replace(",", "")) for v in re.split(r"\s{2,}", line)[1:]]


def test_cortex(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "cortex.py")
    assert row(text, "triangles") == [18654] * 4
    assert row(text, "flipped")[:3] == [0, 0, 0]
    lscm, ours, abf, shipped = row(text, "angle distortion")
    assert abf <= ours <= 2.54e-3 * 1.02
    assert ours < lscm < shipped
    V, coordinates, _, F, corners, _ = igl.readOBJ(str(tmp_path / "out" / "cortex.obj"))
    assert F.shape == corners.shape == (18654, 3)
    assert coordinates.min() == 0
    assert coordinates.max() == 1
    assert (igl.doublearea(np.ascontiguousarray(coordinates[:, :2]), corners) > 0).all()
    assert np.isclose(np.ptp(V, axis=0).max(), 170, atol=10)  # millimetres
    assert pixels(tmp_path / "out" / "cortex.png").shape[:2] == (2800, 1400)


def test_compare_lscm_on_any_mesh(tmp_path) -> None:
    igl.write_triangle_mesh(str(tmp_path / "bumps.ply"), *load("bumps"))
    text = run(tmp_path, ROOT / "demos" / "compare_lscm.py", "bumps.ply", "pictures")
    lscm, ours, abf = row(text, "angle distortion")
    assert abf <= ours <= lscm
    assert sorted(p.name for p in (tmp_path / "pictures").iterdir()) == ["bumps.obj", "bumps.png"]


def test_timing_prints_a_ratio_for_each_mesh(tmp_path) -> None:
    igl.write_triangle_mesh(str(tmp_path / "bumps.off"), *load("bumps"))
    text = run(tmp_path, ROOT / "benchmarks" / "timing.py", "--repeat", 1, "bumps.off")
    assert re.search(r"^\| bumps \| [\d,]+ \| \*\*[\d.]+\*\* \|", text, re.MULTILINE)
    assert "CHOLMOD" in text
