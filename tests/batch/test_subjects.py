"""A batch of FreeSurfer subjects writes a row for each hemisphere, and a folder for each subject."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from igl_linabf.batch import flatten_files

pytest.importorskip("distributed")
pytest.importorskip("nilearn")
from subjects import made_up_subject

from igl_linabf import MeshError


@pytest.mark.slow
def test_each_hemisphere_has_a_row_and_is_done_once(tmp_path: Path) -> None:
    first = made_up_subject(tmp_path / "a" / "sub-01", 3)
    shutil.copytree(first, tmp_path / "b" / "sub-01")  # two subjects with the same name
    broken = made_up_subject(tmp_path / "a" / "sub-02", 3, ("lh",))
    (broken / "surf" / "lh.pial").unlink()
    shutil.copy(first / "surf" / "lh.sphere.reg", broken / "surf" / "lh.white")
    out = tmp_path / "flat"
    done = flatten_files([tmp_path / "a", tmp_path / "b"], out, how="cortex", workers=1, progress=False)
    assert len(done.rows) == done.done == 5
    for row in done.rows:
        if "sub-02" not in row.input:
            assert row.good, row.message
            assert (out / row.output).is_file()
            assert row.output.endswith(("lh.cortex.flat.patch.3d", "rh.cortex.flat.patch.3d"))
            assert len(list((out / row.output).parent.iterdir())) == 10
    assert len({row.output for row in done.rows}) == 5
    again = flatten_files([tmp_path / "a", tmp_path / "b"], out, how="cortex", workers=1, progress=False)
    assert again.done == 0


def test_files_not_written_by_a_batch_are_kept(tmp_path: Path) -> None:
    subject = made_up_subject(tmp_path / "sub-01", 3, ("lh",))
    mine = tmp_path / "flat" / "sub-01" / "lh.cortex.patch.3d"
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    with pytest.raises(FileExistsError, match=r"sub-01/lh\.cortex\.patch\.3d are there already"):
        flatten_files(subject, tmp_path / "flat", how="cortex", workers=1, progress=False)
    assert mine.read_text() == "mine"


def test_missing_subjects_and_invalid_options_are_refused(tmp_path: Path) -> None:
    (tmp_path / "lh.sphere.reg").touch()  # a sphere outside of a folder `surf` is not a subject
    with pytest.raises(MeshError, match=r"holds no hemisphere \(surf/\?h\.sphere\.reg\)"):
        flatten_files(tmp_path, tmp_path / "flat", how="cortex", progress=False)
    with pytest.raises(ValueError, match="copy it here"):
        flatten_files("memory://subjects", tmp_path / "flat", how="cortex", progress=False)
    with pytest.raises(ValueError, match="are not options of cortex"):
        flatten_files(tmp_path, tmp_path / "flat", how="cortex", cones=4, progress=False)
