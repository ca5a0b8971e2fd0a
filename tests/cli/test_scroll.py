"""The command `scroll` flattens a segment, and refuses wrong use in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from igl_linabf.cli import main
from igl_linabf.io import read_mesh, read_texture, read_tifxyz, write_tifxyz
from igl_linabf.scrolls import synthetic_segment


@pytest.fixture
def segment(tmp_path: Path) -> Path:
    write_tifxyz(tmp_path / "segment", synthetic_segment(40, 90))
    return tmp_path / "segment"


def test_a_segment_is_written_flat_with_its_mesh(
    segment: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, obj = tmp_path / "flat", tmp_path / "flat.obj"
    command = ["scroll", str(segment), "-o", str(out), "--obj", str(obj)]
    assert main(command) == 0
    shown = capsys.readouterr()
    assert "L2 stretch, median" in shown.out and "of memory" in shown.err
    assert read_tifxyz(out).scale == read_tifxyz(segment).scale
    assert len(read_texture(obj)[1]) == len(read_mesh(obj)[1])
    before = sorted(tmp_path.iterdir())
    assert main(command) == 2
    assert "exists" in capsys.readouterr().err
    assert main([*command, "--force", "--json", "--pieces", "2", "--up", "rows", "--method", "linabf"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["report"]["flips"] == 0 and figures["good"]
    assert sorted(tmp_path.iterdir()) == before


def test_links_that_lead_out_of_a_segment_need_the_option_that_the_message_names(
    segment: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (segment / "x.tif").rename(tmp_path / "x.tif")
    try:
        (segment / "x.tif").symlink_to(tmp_path / "x.tif")
    except OSError:  # Windows without developer mode
        pytest.skip("symbolic links cannot be created here")
    command = ["scroll", str(segment), "-o", str(tmp_path / "flat")]
    assert main(command) == 2
    assert "--allow-outside" in capsys.readouterr().err
    assert main([*command, "--allow-outside"]) == 0


@pytest.mark.parametrize(
    ("options", "message"),
    [(["--obj", "flat.ply"], "does not end in .obj"), (["--pieces", "0"], "pieces is 0")],
)
def test_wrong_use_is_refused_in_one_line(
    segment: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    assert main(["scroll", str(segment), "-o", str(segment.with_name("flat")), *options]) == 2
    assert message in capsys.readouterr().err
    assert [path.name for path in segment.parent.iterdir()] == ["segment"]
