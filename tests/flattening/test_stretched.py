"""A valid map that is too stretched to be useful stays valid; a warning states the stretch and a remedy."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import igl
import numpy as np
import pytest

from igl_linabf import OutcomeWarning, flatten, flatten_many, linabf, quality
from igl_linabf.cli import main


def tube(length: float, sides: int = 24, closed: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """Return a tube of radius 1, open at the top, and closed at the bottom by a disk if `closed`."""
    rows = int(4 * length) + 1
    a, z = 2 * np.pi * np.arange(sides) / sides, np.linspace(0, length, rows)
    ring = np.column_stack((np.cos(a), np.sin(a)))
    V = np.column_stack((np.tile(ring, (rows, 1)), np.repeat(z, sides)))
    i, j = (k.ravel() for k in np.meshgrid(np.arange(rows - 1), np.arange(sides), indexing="ij"))
    k = (j + 1) % sides
    F = np.concatenate(
        (
            np.column_stack((i * sides + j, i * sides + k, (i + 1) * sides + k)),
            np.column_stack((i * sides + j, (i + 1) * sides + k, (i + 1) * sides + j)),
        )
    )
    if closed:
        j = np.arange(sides)
        V = np.vstack((V, [0, 0, 0]))
        F = np.vstack((F, np.column_stack(((j + 1) % sides, j, np.full(sides, len(V) - 1)))))
    return V, F


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("length", [9, 14])
def test_the_warning_names_the_stretch_and_unwrap(length: float, closed: bool) -> None:
    V, F = tube(length, closed=closed)
    with pytest.warns(OutcomeWarning, match=r"an L2 stretch of [\d.,e+]+ .*igl_linabf\.unwrap") as said:
        result = flatten(V, F)
    assert result.outcome.good
    (message,) = (str(one.message) for one in said)
    named = float(re.search(r"stretch of ([\d.,e+]+)", message)[1].replace(",", ""))
    assert named == pytest.approx(quality(V, F, result.uv).stretch_l2, rel=1e-3)
    with pytest.warns(OutcomeWarning, match="L2 stretch"):
        linabf(V, F)


def test_useful_maps_cause_no_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert flatten(*tube(3)).outcome.good
        assert flatten(*tube(9), method="isometric").outcome.good


def test_stretched_maps_of_many_meshes_are_named() -> None:
    with pytest.warns(OutcomeWarning, match=r"meshes \[?1, 3\]? .*unwrap") as said:
        results = flatten_many([tube(2), tube(9), tube(3), tube(10)])
    assert len(said) == 1
    assert all(result.outcome.good for result in results)


def test_the_command_warns_and_its_exit_code_stays(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    igl.write_triangle_mesh(str(tmp_path / "tube.obj"), *tube(9))
    assert (
        main(["flatten", str(tmp_path / "tube.obj"), "-o", str(tmp_path / "map.obj"), "--units", "mesh"]) == 0
    )
    assert "warning: the map has an L2 stretch of" in capsys.readouterr().err
