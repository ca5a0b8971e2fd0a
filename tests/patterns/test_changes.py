"""A pattern that changes lengths is reported in one warning, whose remedy makes the pieces fit."""

from __future__ import annotations

import warnings
from pathlib import Path

import igl
import numpy as np
import pytest

from igl_linabf import ChartOptions, OutcomeWarning, Packing, unwrap
from igl_linabf.cli import main
from igl_linabf.patterns import Pattern, write_pattern
from igl_linabf.patterns.pattern import MAX_CHANGE

pytest.importorskip("svgwrite")

Surface = tuple[np.ndarray, np.ndarray]
AROUND, ALONG = 32, 24  # edges around the pipe and along it


def grid(rows: int, columns: int, closed: bool) -> np.ndarray:
    """Return the quadrangles of a grid of vertices, row by row; the columns of a closed grid are cyclic."""
    n = columns + (not closed)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    right = (j + 1) % n
    return np.column_stack((i * n + j, i * n + right, (i + 1) * n + right, (i + 1) * n + j))


def bent_pipe() -> Surface:
    """Return a quarter of a torus with open ends."""
    along, around = np.meshgrid(
        np.linspace(0, np.pi / 2, ALONG + 1), 2 * np.pi * np.arange(AROUND) / AROUND, indexing="ij"
    )
    radius = 100 + 30 * np.cos(around)
    V = np.stack((radius * np.cos(along), radius * np.sin(along), 30 * np.sin(around)), axis=-1)
    return V.reshape(-1, 3), grid(ALONG, AROUND, closed=True)


def hill() -> Surface:
    x, y = np.meshgrid(*2 * [np.linspace(-100, 100, 41)])
    V = np.stack((x, y, 40 * np.exp(-(x**2 + y**2) / 3000)), axis=-1)
    return V.reshape(-1, 3), grid(40, 40, closed=False)


def sphere() -> Surface:
    V, F = igl.upsample(*igl.icosahedron(), 3)
    return 50 * V / np.linalg.norm(V, axis=1, keepdims=True), F


def write(path: Path, surface: Surface, seams: np.ndarray | None = None, **charts: float) -> Pattern:
    atlas = unwrap(*surface, seams, charts=ChartOptions(**charts), packing=Packing(cut_below=0))
    return write_pattern(path / "pattern.svg", *surface, atlas)


@pytest.mark.parametrize("surface", [bent_pipe(), hill(), sphere()], ids=["pipe", "hill", "sphere"])
def test_the_remedy_of_the_warning_makes_the_pieces_fit(surface: Surface, tmp_path: Path) -> None:
    with pytest.warns(OutcomeWarning, match=r"by more than 5%.*max_stretch=1\.0001") as caught:
        before = write(tmp_path, surface)
    assert len(caught) == 1
    assert f"at most by {before.error:.0%}" in str(caught[0].message) and before.error > MAX_CHANGE
    assert write(tmp_path, surface, max_stretch=1.0001).error <= MAX_CHANGE


def test_a_pipe_in_four_segments_fits(tmp_path: Path) -> None:
    V, F = bent_pipe()
    ring, row = np.arange(AROUND), AROUND * np.arange(ALONG + 1)
    rings = [np.column_stack((ring + start, np.roll(ring, -1) + start)) for start in row[6:-1:6]]
    seams = np.concatenate((*rings, np.column_stack((row[:-1], row[1:]))))
    pattern = write(tmp_path, (V, F), seams)
    assert pattern.pieces == 4 and pattern.error <= MAX_CHANGE


def test_the_command_warns_once_and_names_its_option(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    V, F = bent_pipe()
    igl.writeOBJ(str(tmp_path / "pipe.obj"), V, np.concatenate((F[:, :3], F[:, [0, 2, 3]])))
    words = ["pattern", str(tmp_path / "pipe.obj"), "-o", str(tmp_path / "pipe.svg"), "--units", "mm"]
    assert main(words) == 0
    said = capsys.readouterr().err
    assert said.count("warning:") == 1 and "Cut more with --max-stretch 1.0001" in said
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert main([*words, "--max-stretch", "1.0001"]) == 0
    assert "warning" not in capsys.readouterr().err
