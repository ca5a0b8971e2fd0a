"""Files in the formats that igl reads, and OBJ out, whole or not at all."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import load

from igl_linabf import MeshError, linabf
from igl_linabf.io import read_mesh, replacing, unit_square, write_obj


@pytest.mark.parametrize("suffix", ["obj", "off", "ply", "stl"])
def test_reads_what_igl_writes(tmp_path, suffix: str) -> None:
    V, F = load("bumps")
    path = tmp_path / f"mesh.{suffix}"
    igl.write_triangle_mesh(str(path), V, F)
    positions, faces = read_mesh(path)
    assert len(positions) == len(V)  # STL's corners are welded
    assert np.allclose(positions[faces], V[F], atol=1e-5)
    # linabf(V, F) in the same numbering, up to what the format keeps of the coordinates
    ours, theirs = linabf(V, F, rtol=1e-10), linabf(positions, faces, rtol=1e-10)
    assert np.allclose(theirs[faces], ours[F], atol=1e-3)


def test_obj_has_the_map_to_the_last_bit(tmp_path) -> None:
    V, F = load("bumps")
    V = np.vstack((V, [9, 9, 9]))  # an unreferenced vertex: no vt for it
    uv = np.vstack((linabf(V[:-1], F), [np.nan, np.nan]))
    path = tmp_path / "flat.obj"
    write_obj(path, V, F, uv)
    positions, coordinates, _, faces, corners, _ = igl.readOBJ(str(path))
    assert (positions == V).all()
    assert (faces == F).all()
    assert (coordinates[corners][..., :2] == uv[F]).all()
    assert "nan" not in path.read_text()
    assert [p.name for p in tmp_path.iterdir()] == ["flat.obj"]


def test_unit_square_keeps_the_shape() -> None:
    uv = np.array([[-3.0, 1], [1, 2], [np.nan, np.nan], [-1, 1.5]])
    fitted = unit_square(uv)
    assert np.nanmin(fitted) == 0
    assert np.nanmax(fitted) == 1
    assert np.allclose((fitted[1] - fitted[0]) * 4, uv[1] - uv[0])


def test_a_file_that_cannot_be_finished_leaves_the_old_one(tmp_path) -> None:
    path = tmp_path / "flat.obj"
    path.write_text("old")
    with pytest.raises(RuntimeError), replacing(path) as temporary:
        with open(temporary, "w", encoding="utf-8") as file:
            file.write("half")
        raise RuntimeError
    assert path.read_text() == "old"
    V, F = load("bumps")
    with pytest.raises(MeshError, match="face 0 has a vertex without coordinates"):
        write_obj(path, V, F, np.full((len(V), 2), np.nan))
    assert path.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(
    ("name", "text"),
    [("a.obj", "hello\n"), ("a.off", "OFF\n3 1"), ("a.ply", "ply"), ("a.txt", "x"), ("a.stl", "")],
)
def test_what_is_no_mesh_is_refused(tmp_path, name: str, text: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(MeshError, match=name):
        read_mesh(path)
    with pytest.raises(FileNotFoundError):
        read_mesh(tmp_path / "nothing.obj")
