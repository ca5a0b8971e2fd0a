"""Formats that igl writes are read, and OBJ files are written completely or not at all."""

from __future__ import annotations

from dataclasses import replace

import igl
import numpy as np
import pytest
from conftest import load

from igl_linabf import MeshError, MeshWarning, linabf
from igl_linabf.io import (
    Extras,
    as_mesh_file,
    read_file,
    read_mesh,
    read_texture,
    replacing,
    unit_square,
    write_file,
    write_mesh,
    write_obj,
)
from igl_linabf.io.materials import Colour, Material


@pytest.mark.parametrize("suffix", ["obj", "off", "ply", "stl"])
def test_files_written_by_igl_are_read(tmp_path, suffix: str) -> None:
    V, F = load("bumps")
    path = tmp_path / f"mesh.{suffix}"
    igl.write_triangle_mesh(str(path), V, F)
    positions, faces = read_mesh(path)
    assert len(positions) == len(V)  # the three corners of each STL triangle are welded
    assert np.allclose(positions[faces], V[F], atol=1e-5)
    # both meshes have the same numbering, and positions in the precision of the format
    ours, theirs = linabf(V, F, rtol=1e-10), linabf(positions, faces, rtol=1e-10)
    assert np.allclose(theirs[faces], ours[F], atol=1e-3)


def test_obj_stores_the_map_exactly(tmp_path) -> None:
    V, F = load("bumps")
    V = np.vstack((V, [9, 9, 9]))  # the unreferenced vertex gets no line vt
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
    ("name", "text"), [("a.obj", "hello\n"), ("a.off", "OFF\n3 1"), ("a.ply", "ply"), ("a.stl", "")]
)
def test_files_that_are_not_meshes_are_refused(tmp_path, name: str, text: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(MeshError, match=name):
        read_mesh(path)
    (tmp_path / "a.txt").write_text(text)
    with pytest.raises(ValueError, match="is not a mesh file: use one that ends in"):
        read_mesh(tmp_path / "a.txt")
    with pytest.raises(FileNotFoundError):
        read_mesh(tmp_path / "nothing.obj")


def test_names_that_obj_cannot_store_remain_distinct(tmp_path) -> None:
    """Two materials share a name, one has no name, and one has the name of the default material."""
    V, F = igl.icosahedron()
    names = ("red", "red", "", "two\nlines", "end\\", "igl_linabf", "a # b", "a")
    of = np.array([*range(len(names)), *[-1] * (len(F) - len(names))])
    looks = tuple(Material(colour=Colour(i / 10, 0, 0)) for i in range(len(names)))
    mesh = replace(
        as_mesh_file(V, F),
        extras=Extras(materials=(names, of), parts=(("none", "x", "x"), of % 4 - 1), looks=looks),
    )
    with pytest.warns(MeshWarning, match="the exact names"):
        write_file(tmp_path / "out.obj", mesh, V[:, :2])
    after = read_file(tmp_path / "out.obj")
    assert after.materials == (
        "red",
        "red.2",
        "unnamed",
        "two lines",
        "end_",
        "igl_linabf",
        "a # b",
        "a",
        "igl_linabf_",
    )
    assert after.extras.materials[1].tolist() == np.where(of < 0, len(names), of).tolist()
    reds = [look.colour.red for look in after.extras.looks]
    assert reds == pytest.approx([*(i / 10 for i in range(len(names))), 1])
    parts, part = after.extras.parts
    assert set(parts) == {"none", "x", "x.2", "none_"}
    assert [parts[i] for i in part] == ["none_" if i < 0 else ("none", "x", "x.2")[i] for i in of % 4 - 1]


@pytest.mark.parametrize("suffix", [".vtp", ".3mf"])
def test_a_warning_reports_lost_comments(tmp_path, suffix: str) -> None:
    pytest.importorskip({".vtp": "pyvista", ".3mf": "lib3mf"}[suffix])
    V, F = igl.icosahedron()
    mesh = replace(as_mesh_file(V, F), extras=Extras(comments=("made by hand",)))
    with pytest.warns(MeshWarning, match="does not keep its comments"):
        write_file(tmp_path / f"out{suffix}", mesh, V[:, :2])


@pytest.mark.parametrize("suffix", ["ply", "obj"])
def test_texture_coordinates_at_seams_are_preserved(tmp_path, suffix: str) -> None:
    V, F = igl.icosahedron()
    TC = np.random.default_rng(0).random((60, 2)).astype(np.float32)
    path = tmp_path / f"atlas.{suffix}"
    write_mesh(path, V, F, TC, np.arange(60).reshape(20, 3))
    positions, faces = read_mesh(path)
    assert (positions == V).all()  # no vertex is duplicated
    assert (faces == F).all()
    map_, corners = read_texture(path)
    assert (map_[corners].reshape(-1, 2) == TC).all()
