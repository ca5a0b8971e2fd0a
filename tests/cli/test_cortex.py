"""The commands `cortex` for subjects and `flatten` for patches."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("nilearn")
import nibabel.freesurfer as freesurfer
from subjects import ball, made_up_subject

from igl_linabf.cli import main
from igl_linabf.io import read_file, write_patch

pytestmark = pytest.mark.usefixtures("few_sources")


def test_both_hemispheres_are_written_with_their_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    subject = made_up_subject(tmp_path / "sub-01", 4)
    assert main(["cortex", str(subject), "-o", str(tmp_path / "flat"), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["mesh"] == str(subject)
    for name in ("lh", "rh"):
        assert printed[name]["quality"]["distance_error"] < 0.2
        assert printed[name]["quality"]["flips"] == 0
        assert all(Path(file).is_file() for file in printed[name]["files"])
    assert len(list((tmp_path / "flat").iterdir())) == 10
    again = ["cortex", str(subject), "-o", str(tmp_path / "flat"), "--hemi", "rh", "--quiet"]
    assert main(again) == 2
    assert "rh.cortex.patch.3d: it is there already" in capsys.readouterr().err
    assert main([*again, "--force"]) == 0
    assert (
        main(["cortex", str(subject), "-o", str(tmp_path / "one"), "--hemi", "lh", "--method", "linabf"]) == 0
    )
    output = capsys.readouterr().out
    assert "lh: left out are" in output
    assert "distance error" in output
    assert all(path.name.startswith("lh.") for path in (tmp_path / "one").iterdir())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--template", "lh.mine.patch.3d"], "go together: give both"),
        (["--max-distance-error", "0.1"], "is for cuts that are found"),
        (["--hemi", "lh", "--medial-wall", "label"], "lh.cortex.label is missing"),
    ],
)
def test_errors_are_one_line_and_no_file_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture, options: list[str], message: str
) -> None:
    subject = made_up_subject(tmp_path / "sub-01", 2)
    assert main(["cortex", str(subject), "-o", str(tmp_path / "flat"), *options]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "flat").exists()


def test_a_patch_is_flattened_in_millimetres_beside_its_surface_or_on_a_given_one(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    V, F = ball(4)
    freesurfer.write_geometry(tmp_path / "lh.fiducial", 50 * V, F)
    vertex = np.flatnonzero(V[:, 2] < 0.3)
    patch, flat = tmp_path / "lh.full.patch.3d", tmp_path / "lh.full.flat.patch.3d"
    write_patch(str(patch), vertex, np.zeros(len(vertex), dtype=bool), V[vertex])
    asked = ["flatten", str(patch), "-o", str(flat), "--method", "isometric", "--fit", "lengths", "--json"]
    assert main(asked) == 0
    printed = capsys.readouterr()
    assert printed.err == ""  # no warning, because patches leave vertices out on purpose
    error = json.loads(printed.out)["quality"]["distance_error"]
    assert 0.05 < error < 0.3
    mesh = read_file(flat)
    assert mesh.TC is not None
    assert 100 < np.ptp(mesh.TC, axis=0).max() < 400  # the ball has a radius of 50
    (tmp_path / "lh.fiducial").rename(tmp_path / "ball")
    assert main(["flatten", str(patch), "-o", str(flat), "--surface", str(tmp_path / "ball"), "--quiet"]) == 0
    assert main(["flatten", str(patch), "-o", str(flat), "--quiet"]) == 2
    assert "--surface (lh.fiducial, lh.smoothwm" in capsys.readouterr().err
    obj = [
        "flatten",
        str(tmp_path / "ball"),
        "-o",
        str(tmp_path / "a.obj"),
        "--fit",
        "lengths",
        "--units",
        "square",
    ]
    assert main(obj) == 2
    assert "give --units mesh" in capsys.readouterr().err
