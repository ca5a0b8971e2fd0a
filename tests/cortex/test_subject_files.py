"""Files of a flat hemisphere can be read by other programs and keep the subject's vertex numbers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("nilearn")
pytest.importorskip("nibabel")
import nibabel
from PIL import Image
from subjects import made_up_subject

from igl_linabf import distortion
from igl_linabf.cortex import flatten_hemisphere, list_output_paths, write_hemisphere
from igl_linabf.cortex.pictures import compute_mean_curvatures
from igl_linabf.io import read_file


def find_rows(path: Path) -> np.ndarray:
    return np.frombuffer(path.read_bytes(), [("vertex", ">i4"), ("place", ">f4", 3)], offset=8)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple:
    folder = tmp_path_factory.mktemp("subjects")
    flat = flatten_hemisphere(made_up_subject(folder / "sub-01", 4, ("lh",)), "lh")
    write_hemisphere(folder / "flat", flat)
    return flat, folder


def test_every_file_keeps_the_vertex_numbers_of_the_subject(made: tuple) -> None:
    flat, folder = made
    solid, plane, surface, area, picture = list_output_paths(folder / "flat", "lh")
    assert sorted((folder / "flat").iterdir()) == sorted((solid, plane, surface, area, picture))
    laid = np.flatnonzero(np.isfinite(flat.uv[:, 0]))
    for path, places in ((solid, flat.hemisphere.V), (plane, np.insert(flat.uv, 2, 0.0, axis=1))):
        rows = find_rows(path)
        assert (np.abs(rows["vertex"]) - 1 == laid).all()
        assert ((rows["vertex"] < 0) == flat.border[laid]).all()
        np.testing.assert_allclose(rows["place"], places[laid], atol=1e-3)
        read = read_file(path, surface=folder / "sub-01" / "surf" / "lh.pial")
        assert {*map(tuple, read.F.tolist())} == {*map(tuple, flat.F.tolist())}
    points, triangles = nibabel.load(surface).agg_data()
    assert points.shape == (len(flat.uv), 3)
    assert (triangles == flat.F).all()
    np.testing.assert_allclose(points[laid, :2], flat.uv[laid], atol=1e-3)
    assert nibabel.load(surface).meta["AnatomicalStructurePrimary"] == "CortexLeft"
    change = nibabel.load(area).agg_data()
    assert change.shape == (len(flat.uv),)
    of_faces = distortion(flat.hemisphere.V, flat.F, flat.uv, "area")
    vertex = int(laid[100])
    assert change[vertex] == pytest.approx(of_faces[(vertex == flat.F).any(axis=1)].mean(), abs=1e-5)


def test_the_picture_shows_folds_on_the_left_and_areas_on_the_right(made: tuple) -> None:
    _, folder = made
    with Image.open(folder / "flat" / "lh.cortex.png") as image:
        pixels = np.asarray(image, dtype=float) / 255
    left, right = np.split(pixels[60:], 2, axis=1)
    drawn = (left < 0.95).all(axis=2)
    assert 0.2 < drawn.mean() < 0.6
    assert (np.ptp(left[drawn], axis=1) < 0.01).all()  # folds are drawn in grey
    assert np.ptp(left[drawn]) > 0.3
    assert (right[..., 2] - right[..., 0] > 0.2).any()  # some pixels are blue
    assert (right[..., 0] - right[..., 2] > 0.2).any()  # some pixels are red


def test_the_picture_is_upright(made: tuple) -> None:
    """The rows of the picture show the same shares of the area as the map, from top to bottom."""
    flat, folder = made
    with Image.open(folder / "flat" / "lh.cortex.png") as image:
        pixels = np.asarray(image, dtype=float)[60:, : image.width // 2] / 255
    rows = (pixels < 0.95).all(axis=2).sum(axis=1)
    inside = np.flatnonzero(rows)
    rows = rows[inside[0] : inside[-1] + 1]
    corners = flat.uv[flat.F]
    area = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    v = corners[..., 1]
    down = (v.max() - v.mean(axis=1)) / np.ptp(v)
    drawn, _ = np.histogram(np.arange(len(rows)) / len(rows), 30, (0, 1), weights=rows / rows.sum())
    wanted, _ = np.histogram(down, 30, (0, 1), weights=area / area.sum())
    off, upside_down = (np.abs(drawn - shares).sum() for shares in (wanted, wanted[::-1]))
    assert off < 0.05 < 0.1 < upside_down


def test_files_name_their_hemisphere(made: tuple, tmp_path: Path) -> None:
    flat, _ = made
    for name, structure in (("lh", "CortexLeft"), ("rh", "CortexRight")):
        write_hemisphere(tmp_path, replace(flat, hemisphere=replace(flat.hemisphere, name=name)))
        for path in (tmp_path / f"{name}.cortex.flat.surf.gii", tmp_path / f"{name}.cortex.area.shape.gii"):
            assert nibabel.load(path).meta["AnatomicalStructurePrimary"] == structure


def test_sulci_have_negative_curvature_and_gyri_positive() -> None:
    angle = np.linspace(0, 4 * np.pi, 81)
    x, y = np.meshgrid(angle, np.arange(30) * angle[1], indexing="ij")
    V = np.column_stack((x.ravel(), y.ravel(), np.cos(x).ravel()))
    i = np.arange(80 * 30).reshape(80, 30)[:, :-1].ravel()
    F = np.concatenate((np.column_stack((i, i + 30, i + 31)), np.column_stack((i, i + 31, i + 1))))
    curvature = compute_mean_curvatures(10 * V, F)
    middle = (np.abs(V[:, 1] - V[:, 1].mean()) < 1) & (x.ravel() > 1) & (x.ravel() < 11)
    assert (curvature[middle & (V[:, 2] > 0.7)] > 0.005).all()
    assert (curvature[middle & (V[:, 2] < -0.7)] < -0.005).all()


def test_a_failed_write_leaves_no_files(made: tuple, tmp_path: Path, monkeypatch) -> None:
    def broken(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("igl_linabf.cortex.writing.draw_flat_hemisphere", broken)
    with pytest.raises(OSError, match="No space"):
        write_hemisphere(tmp_path / "flat", made[0])
    assert list((tmp_path / "flat").iterdir()) == []
