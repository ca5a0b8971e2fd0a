"""Scroll segments are read as the specification says, and written whole or not at all."""

from __future__ import annotations

import json
import os
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from igl_linabf import MeshError, MeshWarning
from igl_linabf.io import Segment, read_tifxyz, write_tifxyz

tifffile = pytest.importorskip("tifffile")


def make_segment() -> Segment:
    rows, columns = np.mgrid[:6, :9]
    points = np.stack((20.0 * columns, 3.0 + rows, 1.0 + 10 * rows), axis=2)
    points[2, 3] = np.nan
    return Segment(
        points, (0.05, 0.1), {"type": "seg", "area_cm2": 1.5}, {"generations": rows.astype(np.uint16)}
    )


def make_link(path: Path, target: Path) -> None:
    """Create a symbolic link, or skip the test if this is not allowed."""
    try:
        path.symlink_to(target, target.is_dir())
    except OSError:  # Windows without developer mode
        pytest.skip("symbolic links cannot be created here")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_tifxyz(tmp_path / "segment", make_segment())
    return tmp_path / "segment"


def test_all_content_of_a_segment_survives_a_round_trip(folder: Path) -> None:
    read, given = read_tifxyz(folder), make_segment()
    np.testing.assert_array_equal(read.points, given.points)
    assert read.scale == given.scale
    assert read.meta["area_cm2"] == 1.5 and read.meta["type"] == "seg"
    assert read.meta["uuid"] == "segment"
    assert read.meta["bbox"] == [[0, 3, 1], [160, 8, 51]]
    np.testing.assert_array_equal(read.channels["generations"], given.channels["generations"])


def test_missing_points_are_written_as_the_specification_recommends(folder: Path) -> None:
    assert [tifffile.imread(folder / f"{name}.tif")[2, 3] for name in "xyz"] == [-1, -1, -1]
    assert tifffile.imread(folder / "x.tif").dtype == np.float32


@pytest.mark.parametrize("dtype", [np.float64, np.uint8, np.int16, np.uint32])
@pytest.mark.parametrize("options", [{}, {"tile": (16, 16)}, {"compression": "lzw", "predictor": True}])
def test_samples_of_any_type_and_layout_are_read(
    folder: Path, dtype: type, options: dict[str, object]
) -> None:
    if "compression" in options:
        pytest.importorskip("imagecodecs")
    x = read_tifxyz(folder).points[..., 0]
    tifffile.imwrite(folder / "x.tif", np.nan_to_num(x).astype(dtype), **options)
    np.testing.assert_array_equal(read_tifxyz(folder).points[..., 0], x)


def test_points_without_positive_z_are_missing(folder: Path) -> None:
    z = tifffile.imread(folder / "z.tif")
    z[0, :3] = [0, -5, np.nan]
    tifffile.imwrite(folder / "z.tif", z)
    assert np.argwhere(~read_tifxyz(folder).valid).tolist() == [[0, 0], [0, 1], [0, 2], [2, 3]]


@pytest.mark.parametrize("channels", [None, -1, 0])
def test_any_low_value_of_a_finer_mask_removes_its_point(folder: Path, channels: int | None) -> None:
    mask = np.full((12, 27), 255, dtype=np.uint8)
    mask[3, 5] = 254  # lies in the cell of point (1, 1)
    image = mask if channels is None else np.stack((mask, 0 * mask, mask), axis=channels)
    planar = (
        {}
        if channels is None
        else {"photometric": "rgb", "planarconfig": "separate" if channels == 0 else "contig"}
    )
    tifffile.imwrite(folder / "mask.tif", image, **planar)
    assert np.argwhere(~read_tifxyz(folder).valid).tolist() == [[1, 1], [2, 3]]
    assert np.argwhere(~read_tifxyz(folder, mask=False).valid).tolist() == [[2, 3]]


def test_a_mask_of_another_size_is_ignored_with_a_warning(folder: Path) -> None:
    tifffile.imwrite(folder / "mask.tif", np.zeros((7, 9), dtype=np.uint8))
    with pytest.warns(MeshWarning, match="not a multiple"):
        assert read_tifxyz(folder).valid.sum() == 53


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("{", "not JSON"),
        ("[]", "format is None"),
        ('{"format": "obj", "scale": [1, 1]}', "format is 'obj'"),
        ('{"format": "tifxyz"}', "scale is None"),
        ('{"format": "tifxyz", "scale": [0.05]}', "two positive"),
        ('{"format": "tifxyz", "scale": [0.05, -1]}', "two positive"),
    ],
)
def test_wrong_descriptions_are_refused(folder: Path, text: str, match: str) -> None:
    (folder / "meta.json").write_text(text, encoding="utf-8")
    with pytest.raises(MeshError, match=match):
        read_tifxyz(folder)


def test_damaged_images_are_named(folder: Path) -> None:
    whole = (folder / "y.tif").read_bytes()
    (folder / "y.tif").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(MeshError, match=r"y\.tif"):
        read_tifxyz(folder)
    tifffile.imwrite(folder / "y.tif", np.zeros((5, 9), dtype=np.float32))
    with pytest.raises(MeshError, match="differ in size"):
        read_tifxyz(folder)
    (folder / "y.tif").unlink()
    with pytest.raises(FileNotFoundError):
        read_tifxyz(folder)


def test_points_that_would_be_lost_are_refused(tmp_path: Path) -> None:
    segment = make_segment()
    segment.points[4, 4, 2] = 0
    with pytest.raises(MeshError, match=r"4, 4"):
        write_tifxyz(tmp_path / "segment", segment)
    assert not any(tmp_path.iterdir())


def test_only_segments_are_replaced_and_only_by_force(folder: Path) -> None:
    (folder / "mask.tif").write_bytes(b"of the old grid")
    with pytest.raises(FileExistsError):
        write_tifxyz(folder, make_segment())
    write_tifxyz(folder, replace(make_segment(), channels={}), force=True)
    assert sorted(path.name for path in folder.iterdir()) == ["meta.json", "x.tif", "y.tif", "z.tif"]
    with pytest.raises(FileExistsError, match="not a tifxyz segment"):
        write_tifxyz(folder.parent, make_segment(), force=True)


def test_a_failure_leaves_the_old_segment_and_nothing_else(folder: Path) -> None:
    before = json.loads((folder / "meta.json").read_text(encoding="utf-8"))
    broken = replace(make_segment(), channels={"no/folder": np.zeros((6, 9))})
    with pytest.raises(FileNotFoundError):
        write_tifxyz(folder, broken, force=True)
    assert [path.name for path in folder.parent.iterdir()] == ["segment"]
    assert json.loads((folder / "meta.json").read_text(encoding="utf-8")) == before


def test_an_image_that_announces_more_than_the_memory_is_refused(folder: Path) -> None:
    data = bytearray((folder / "x.tif").read_bytes())
    (start,) = struct.unpack_from("<I", data, 4)
    (number,) = struct.unpack_from("<H", data, start)
    for entry in range(start + 2, start + 2 + 12 * number, 12):
        if struct.unpack_from("<H", data, entry)[0] in (256, 257, 278):  # width, height, rows per strip
            struct.pack_into("<HII", data, entry + 2, 4, 1, 2_000_000)
    (folder / "x.tif").write_bytes(data)
    with pytest.raises(MeshError, match=r"x\.tif cannot be read as TIFF: its 4,000,000,000,000 samples"):
        read_tifxyz(folder)


@pytest.mark.parametrize("name", ["meta.json", "x.tif", "mask.tif", "generations.tif"])
def test_links_out_of_the_folder_are_followed_only_if_they_are_allowed(folder: Path, name: str) -> None:
    tifffile.imwrite(folder / "mask.tif", np.full((6, 9), 255, np.uint8))
    before = read_tifxyz(folder)
    (folder.parent / "outside").mkdir()
    target = folder.parent / "outside" / name
    (folder / name).rename(target)
    make_link(folder / name, target)
    with pytest.raises(MeshError, match=f"{name} leads out of the folder"):
        read_tifxyz(folder)
    followed = read_tifxyz(folder, allow_outside=True)
    np.testing.assert_array_equal(followed.points, before.points)
    assert followed.channels.keys() == before.channels.keys()


def test_links_inside_and_links_to_the_folder_are_followed(folder: Path) -> None:
    make_link(folder / "copy.tif", folder / "generations.tif")
    make_link(folder.parent / "link", folder)
    assert set(read_tifxyz(folder.parent / "link").channels) == {"copy", "generations"}


@pytest.mark.parametrize("name", ["meta.json", "x.tif", "mask.tif", "generations.tif"])
@pytest.mark.parametrize("kind", ["mkdir", "mkfifo"])
def test_folders_and_pipes_are_refused(folder: Path, name: str, kind: str) -> None:
    if not hasattr(os, kind):
        pytest.skip("this system has no named pipes")
    (folder / name).unlink(missing_ok=True)
    getattr(os, kind)(folder / name)
    with pytest.raises(MeshError, match=f"{name} is a folder, a pipe or a device"):
        read_tifxyz(folder)


@pytest.mark.parametrize(
    "text",
    [
        "[" * 10**5,
        json.dumps({"format": "x" * 10**4}),
        json.dumps({"format": "tifxyz", "scale": ["9" * 10**4, [[1] * 100] * 100]}),
    ],
)
def test_a_bad_description_is_refused_by_a_short_message(folder: Path, text: str) -> None:
    (folder / "meta.json").write_text(text, encoding="utf-8")
    with pytest.raises(MeshError, match=r"meta\.json") as caught:
        read_tifxyz(folder)
    assert len(str(caught.value)) < len(str(folder)) + 250


def test_a_description_that_is_nested_too_deeply_is_not_written(tmp_path: Path) -> None:
    deep: list[object] = []
    for _ in range(10**5):
        deep = [deep]
    with pytest.raises(MeshError, match="nested too deeply"):
        write_tifxyz(tmp_path / "segment", replace(make_segment(), meta={"deep": deep}))
    assert not any(tmp_path.iterdir())


def test_an_image_does_not_lead_to_another_file(folder: Path) -> None:
    x = read_tifxyz(folder).points[..., 0]
    rows, columns = x.shape
    tifffile.imwrite(folder.parent / "other.tif", np.full((rows, columns), 7.0, np.float32))
    text = (
        '<?xml version="1.0"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06"><Image ID="a">'
        f'<Pixels ID="b" DimensionOrder="XYZCT" Type="float" SizeX="{columns}" SizeY="{rows}" SizeZ="1" '
        'SizeC="1" SizeT="1"><Channel ID="c" SamplesPerPixel="1"/><TiffData IFD="0" PlaneCount="1">'
        '<UUID FileName="../other.tif">urn:uuid:1</UUID></TiffData></Pixels></Image></OME>'
    )
    stored = tifffile.imread(folder / "x.tif")
    tifffile.imwrite(folder / "x.tif", stored, description=text, metadata=None)
    assert np.array_equal(read_tifxyz(folder).points[..., 0], x, equal_nan=True)
