"""Templates separate the medial wall from the cuts among the missing faces of a flat map."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("nilearn")
import nibabel.freesurfer as freesurfer
from subjects import ball, fsaverage5

from igl_linabf import MeshError
from igl_linabf.cortex.templates import build_template, load_fsaverage_template, read_template
from igl_linabf.io import write_patch


def draw_template(cuts: list[tuple[float, float]], wall: float = 0.4, subdivisions: int = 5) -> tuple:
    """Return a ball, and a mask of a wall around its pole and of cuts, each given by longitude and end."""
    V, F = ball(subdivisions)
    down = np.arccos(np.clip(V[:, 2], -1, 1))
    out = down < wall
    for longitude, end in cuts:
        towards = np.array([np.cos(longitude), np.sin(longitude)])
        across = np.abs(V[:, :2] @ [-towards[1], towards[0]])
        out |= (V[:, :2] @ towards > 0) & (across < 0.03) & (down < end)
    return V, F, out


@pytest.mark.parametrize("hemisphere", ["lh", "rh"])
def test_fsaverage_has_a_wall_and_five_cuts_that_end_at_it(hemisphere: str) -> None:
    template = load_fsaverage_template(hemisphere)
    assert len(template.cuts) == 5
    inside = template.sphere[template.wall]
    for cut in template.cuts:
        length = np.linalg.norm(np.diff(cut, axis=0), axis=1).sum()
        assert 0.3 < length < 1.3  # 30 to 130 mm on FreeSurfer's sphere of radius 100 mm
        assert np.linalg.norm(inside - cut[-1], axis=1).min() < 0.08  # the cut ends at the rim of the wall
        assert np.linalg.norm(inside - cut[0], axis=1).min() > 0.2
    # the wall lies on the medial side, towards the other hemisphere
    (pial, _) = fsaverage5(hemisphere, "pial")
    towards = {"lh": 1, "rh": -1}[hemisphere]
    wall = pial[template.wall].mean(axis=0)
    assert towards * (wall - pial.mean(axis=0))[0] > 10


def test_a_drawn_wall_and_its_cuts_are_recovered(tmp_path: Path) -> None:
    asked = [(0.0, 1.5), (2.0, 1.0), (4.0, 2.0)]
    V, F, out = draw_template(asked)
    template = build_template(V, F, F[~out[F].any(axis=1)])
    assert len(template.cuts) == 3
    for longitude, end in asked:
        tip = np.array([np.cos(longitude) * np.sin(end), np.sin(longitude) * np.sin(end), np.cos(end)])
        cut = min(template.cuts, key=lambda cut, tip=tip: np.linalg.norm(cut[0] - tip))
        assert np.linalg.norm(cut[0] - tip) < 0.1
        off = np.abs(cut[:-5] @ [-np.sin(longitude), np.cos(longitude), 0])
        assert off.max() < 0.06
    assert 0.35 < np.arccos(V[template.wall, 2]).max() < 0.6
    # the template has the same cuts after writing and reading its files
    freesurfer.write_geometry(tmp_path / "lh.sphere.reg", 100 * V, F)
    kept = np.flatnonzero(~out)
    write_patch(str(tmp_path / "lh.mine.patch.3d"), kept, np.zeros(len(kept), dtype=bool), V[kept])
    read = read_template(tmp_path / "lh.mine.patch.3d", tmp_path / "lh.sphere.reg")
    assert (read.wall == template.wall).all()
    assert len(read.cuts) == 3


def test_a_template_without_a_wall_is_refused() -> None:
    V, F, out = draw_template([(0.0, 1.5)], wall=0.0)
    with pytest.raises(MeshError, match="only cuts, no medial wall"):
        build_template(V, F, F[~out[F].any(axis=1)])
    with pytest.raises(MeshError, match="leaves out nothing"):
        build_template(V, F, F)
