"""The recipes run, and their output and pictures are right."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from conftest import ROOT
from pixels import measure_colour_share
from scripts_of_repo import run

SCRIPTS = sorted(path.stem for path in (ROOT / "recipes").glob("*.py"))


def test_each_recipe_has_a_title_a_test_and_a_place_in_the_gallery() -> None:
    order = (ROOT / "docs" / "gallery_pages.py").read_text()
    for name in SCRIPTS:
        text = (ROOT / "recipes" / f"{name}.py").read_text()
        assert re.match(r'"""\n(.+)\n=+\n', text), name
        assert f'"{name}"' in order
        assert name in WHAT


# name of the recipe: ((rows, columns) of panels in its picture, pattern of its output)
WHAT = {
    "blender_python": ((1, 2), r"all +576 .* 0 +0"),
    "colours_into_glb": ((1, 2), r"off by [0-2] of 255 in the median"),
    "deforming_mesh": ((2, 3), r"(F/3nt [\d.]+, 0 flipped triangles\s+){3}"),
    "differentiable_renderer": ((1, 2), r"step 20: root mean square error 0\.0[0-4]"),
    "flat_cortex": ((1, 2), r"flipped triangles +0\noverlapping pairs +0"),
    "folder_of_meshes": ((1, 3), r"(?s)airplane \| valid.*damaged \| refused.*cannot be read as PLY"),
    "quads_from_scan": ((1, 2), r"[\d,]+ of [\d,]+ cells are whole quadrangles"),
    "sheet_metal": ((1, 2), r"edges change by 0\.00% at most"),
    "xatlas_pipeline": ((1, 2), r"faces +99,785\nwithout coordinates +0\n(?s:.*)\nflipped faces +0\n"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SCRIPTS)
def test_each_recipe_runs_and_fills_its_picture(tmp_path: Path, name: str) -> None:
    (rows, columns), said = WHAT[name]
    assert re.search(said, run(tmp_path, ROOT / "recipes" / f"{name}.py"))
    assert min(measure_colour_share(tmp_path / "out" / f"{name}.png", rows, columns)) >= 1


@pytest.mark.slow
def test_tensors_hold_the_texture_coordinates_of_the_mesh(tmp_path: Path) -> None:
    pytest.importorskip("torch")
    text = run(tmp_path, ROOT / "recipes" / "differentiable_renderer.py")
    assert "tensors of torch.float32 and torch.int32 on cpu" in text
