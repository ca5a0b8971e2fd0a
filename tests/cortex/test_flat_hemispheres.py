"""Flat maps of synthetic subjects, from their files."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("nilearn")
import nibabel.freesurfer as freesurfer
from subjects import fsaverage5, made_up_subject

from igl_linabf import MeshError, MeshWarning
from igl_linabf.cortex import flatten_hemisphere, flatten_hemispheres
from igl_linabf.io import write_patch
from igl_linabf.measures import distance_error

pytestmark = pytest.mark.usefixtures("few_sources")


@pytest.fixture(scope="module")
def subject(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made_up_subject(tmp_path_factory.mktemp("subjects") / "sub-01", 4)


def copy_subject(subject: Path, folder: Path) -> Path:
    return Path(shutil.copytree(subject, folder / subject.name))


def test_both_hemispheres_are_flat_upright_and_at_the_scale_of_lengths(subject: Path) -> None:
    left, right = flatten_hemispheres(subject)
    for flat, name in ((left, "lh"), (right, "rh")):
        V, F, uv = flat.hemisphere.V, flat.F, flat.uv
        white, pial, _ = (
            freesurfer.read_geometry(subject / "surf" / f"{name}.{k}")[0] for k in ("white", "pial", "pial")
        )
        np.testing.assert_allclose(V, (white + pial) / 2, atol=1e-4)
        assert flat.good
        assert flat.quality.flips == flat.quality.overlaps == 0
        laid = np.isfinite(uv[:, 0])
        assert (np.unique(F) == np.flatnonzero(laid)).all()
        assert not (laid & ~flat.cuts.is_kept).any()
        least = distance_error(V, F, uv)
        assert least == pytest.approx(flat.quality.distance_error, abs=0.01)
        assert all(distance_error(V, F, s * uv) > least for s in (0.95, 1.05))
        assert np.corrcoef(uv[laid, 1], V[laid, 2])[0, 1] > 0.3  # superior (z) points up
        assert (
            abs((uv[laid, 0] - uv[laid, 0].mean()) @ (V[laid, 2] - V[laid, 2].mean())) < 1e-6 * len(V) * 1e4
        )
        assert flat.border[F].any()
        assert not flat.border[~laid].any()
    again = flatten_hemisphere(subject, "rh")
    np.testing.assert_array_equal(again.uv, right.uv)  # the same map as for both hemispheres in threads


def test_the_subjects_own_label_is_its_medial_wall(subject: Path, tmp_path: Path) -> None:
    mine = copy_subject(subject, tmp_path)
    with pytest.raises(MeshError, match=r"lh\.cortex\.label is missing, .* medial_wall='template'"):
        flatten_hemisphere(mine, "lh", medial_wall="label")
    wall = flatten_hemisphere(mine, "lh").cuts.wall
    cortex = np.flatnonzero(~wall)
    lines = "".join(f"{v} 0 0 0 0\n" for v in cortex[:-5])  # the label lacks five vertices of the cortex
    (mine / "label").mkdir()
    (mine / "label" / "lh.cortex.label").write_text(f"#!ascii label\n{len(cortex) - 5}\n{lines}")
    flat = flatten_hemisphere(mine, "lh", medial_wall="label")
    assert set(np.flatnonzero(flat.cuts.wall)) == {*np.flatnonzero(wall), *cortex[-5:]}
    assert len(flat.cuts.paths) == 5
    for text, message in (
        ("no label", r"lh\.cortex\.label has no vertices"),
        (f"#!ascii label\n1\n{len(flat.uv)} 0 0 0 0\n", "it is another subject's"),
        ("#!ascii label\n1\n-1 0 0 0 0\n", "it is another subject's"),
    ):
        (mine / "label" / "lh.cortex.label").write_text(text)
        with pytest.raises(MeshError, match=message):
            flatten_hemisphere(mine, "lh", medial_wall="label")


def test_foreign_and_missing_spheres_are_refused_by_name(subject: Path, tmp_path: Path) -> None:
    mine = copy_subject(subject, tmp_path)
    sphere = mine / "surf" / "lh.sphere.reg"
    sphere.unlink()
    with pytest.raises(MeshError, match=r"lh\.sphere\.reg is missing, .* cuts='found'"):
        flatten_hemisphere(mine, "lh")
    points, _, F = fsaverage5("lh", "sphere", "sphere")
    freesurfer.write_geometry(sphere, points, F)
    with pytest.raises(MeshError, match=r"lh\.sphere\.reg has 10242 vertices, .* have 2562: it is another"):
        flatten_hemisphere(mine, "lh")
    shutil.copy(mine / "surf" / "lh.pial", sphere)
    with pytest.raises(MeshError, match=r"lh\.sphere\.reg is not a sphere"):
        flatten_hemisphere(mine, "lh")
    freesurfer.write_geometry(mine / "surf" / "lh.pial", points, F)
    with pytest.raises(MeshError, match=r"lh\.smoothwm has 2,562 vertices and .*lh\.pial 10,242"):
        flatten_hemisphere(mine, "lh")
    with pytest.raises(MeshError, match=r"has no surf/lh\.fiducial, .* a FreeSurfer subject"):
        flatten_hemisphere(tmp_path, "lh")
    with pytest.raises(ValueError, match="the hemisphere is 'left'"):
        flatten_hemisphere(subject, "left")


def test_a_piece_that_a_cut_and_the_wall_enclose_is_left_out_with_a_warning(
    subject: Path, tmp_path: Path
) -> None:
    flat = flatten_hemisphere(subject, "lh")
    sphere = freesurfer.read_geometry(subject / "surf" / "lh.sphere.reg")[0] / 100
    cut = max(flat.cuts.paths, key=len)
    stays = flat.cuts.is_kept.copy()
    # extend the wall by an arm that touches the middle of the longest cut
    start, end = sphere[cut[len(cut) // 3]], sphere[cut[-1]]
    bow = (start + end) / 2 + 0.6 * np.cross(start, end) / np.linalg.norm(np.cross(start, end))
    line = np.concatenate([np.linspace(a, b, 200) for a, b in ((start, bow), (bow, end))])
    for at in line / np.linalg.norm(line, axis=1)[:, None]:
        stays[np.linalg.norm(sphere - at, axis=1) < 0.05] = False
    mine = copy_subject(subject, tmp_path)
    (mine / "label").mkdir()
    lines = "".join(f"{v} 0 0 0 0\n" for v in np.flatnonzero(stays))
    (mine / "label" / "lh.cortex.label").write_text(f"#!ascii label\n{stays.sum()}\n{lines}")
    with pytest.warns(MeshWarning, match="cuts and medial wall enclose pieces of"):
        made = flatten_hemisphere(mine, "lh", medial_wall="label")
    assert made.quality.flips == made.quality.overlaps == 0
    (piece, *_) = made.patch.pieces
    assert len(piece) > 13
    assert np.isnan(made.uv[piece]).all()


def test_a_template_can_be_a_patch_and_its_sphere(subject: Path, tmp_path: Path) -> None:
    flat = flatten_hemisphere(subject, "rh")
    patch, sphere = tmp_path / "rh.mine.patch.3d", subject / "surf" / "rh.sphere.reg"
    kept = np.flatnonzero(flat.cuts.is_kept)
    write_patch(str(patch), kept, flat.border[kept], flat.hemisphere.V[kept])
    same = flatten_hemisphere(subject, "rh", template=(patch, sphere))
    missing, more = ~flat.cuts.is_kept & same.cuts.is_kept, flat.cuts.is_kept & ~same.cuts.is_kept
    # the subject serves as its own template
    assert missing.sum() + more.sum() < 0.2 * (~flat.cuts.is_kept).sum()
    with pytest.raises(MeshError, match=r"rh\.mine\.patch\.3d is of the other hemisphere"):
        flatten_hemisphere(subject, "lh", template=(patch, sphere))


def test_the_template_of_the_other_hemisphere_is_found_by_name(subject: Path, tmp_path: Path) -> None:
    for name in ("lh", "rh"):
        shutil.copy(subject / "surf" / f"{name}.sphere.reg", tmp_path / f"{name}.sphere.reg")
    template = tmp_path / "lh.mine.patch.3d", tmp_path / "lh.sphere.reg"  # rh.mine.patch.3d does not exist
    with pytest.raises(FileNotFoundError, match=r"rh\.mine\.patch\.3d"):
        flatten_hemispheres(subject, ("rh",), template=template)


def test_invalid_options_are_refused(subject: Path) -> None:
    for options, message in (
        ({"cuts": "none"}, "cuts is 'none'"),
        ({"medial_wall": "aparc"}, "medial_wall is 'aparc'"),
        ({"max_distance_error": 0.1}, "is for cuts that are found"),
        ({"cuts": "found", "max_distance_error": 15}, "from 0 to 1, such as 0.15"),
        ({"cuts": "found", "medial_wall": "label", "template": ("a", "b")}, "leave out the template"),
    ):
        with pytest.raises(ValueError, match=message):
            flatten_hemisphere(subject, "lh", **options)
