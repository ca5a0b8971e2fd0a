"""Existing files: only the file that -o names is replaced, unless --force is given."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import igl
import numpy as np
import pytest
from gltf_files import write_scene

from igl_linabf import MeshError
from igl_linabf.batch import flatten_files
from igl_linabf.cli import main
from igl_linabf.io import read_file, write_file, write_textured

pytestmark = pytest.mark.filterwarnings("ignore::igl_linabf.MeshWarning")
OWN = b"made by hand"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Create a folder with one mesh as OBJ, OFF and GLB."""
    V, F = igl.icosahedron()
    for name in ("b.obj", "b.off", "disk.off"):
        igl.write_triangle_mesh(str(tmp_path / name), V, F[name == "disk.off" :])
    write_scene(tmp_path / "b.glb")
    monkeypatch.chdir(tmp_path)
    return tmp_path


UNWRAP = "unwrap b.off -o"
REFUSED = [
    ("unwrap b.obj -o b.obj --bake normals", "b.mtl"),
    ("unwrap b.obj -o b.obj --bake normals", "b.png"),
    ("unwrap b.glb -o new.obj", "new.mtl"),
    (f"{UNWRAP} new.glb --picture own.png", "own.png"),
    (f"{UNWRAP} maps", "maps/b.obj"),
    ("unwrap b.off disk.off -o maps", "maps/disk.obj"),
    (f"{UNWRAP} new.obj --picture maps", "maps/b.png"),
    ("flatten disk.off -o new.obj --picture own.png", "own.png"),
    ("flatten disk.off -o maps", "maps/disk.obj"),
    ("compare disk.off --picture own.png", "own.png"),
    ("pattern b.off -o maps", "maps/b.svg"),
    ("view b.off --screenshot own.png", "own.png"),
]


@pytest.mark.parametrize(("command", "own"), REFUSED)
def test_existing_files_that_are_not_named_are_refused_before_the_computation(
    command: str, own: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "maps").mkdir()
    (folder / own).write_bytes(OWN)
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}

    def at_work(*_: object, **__: object) -> None:
        raise AssertionError("the work has begun")

    for name in ("unwrapping.unwrap", "pattern_making.unwrap", "flattening.flatten", "flattening.compare"):
        monkeypatch.setattr(f"igl_linabf.cli.{name}", at_work)
    assert main([*command.split(), *["--quiet"] * ("view" not in command)]) == 2
    message = capsys.readouterr().err
    assert f"{own}: it is there already" in message
    assert "--force" in message
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_only_the_named_output_is_replaced_without_force(folder: Path) -> None:
    for name in ("b.mtl", "b.png", "own.png", "new.glb"):
        (folder / name).write_bytes(OWN)
    assert main(["unwrap", "b.off", "-o", "new.glb", "--quiet"]) == 0
    assert (folder / "new.glb").read_bytes() != OWN
    pictured = "unwrap b.obj -o b.obj --bake normals --resolution 64 --quiet --force --picture own.png"
    assert main(pictured.split()) == 0
    assert OWN not in [(folder / name).read_bytes() for name in ("b.mtl", "b.png", "own.png")]


def test_a_picture_and_a_texture_with_the_same_name_are_refused(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (
        main(["unwrap", "b.off", "-o", "new.obj", "--bake", "normals", "--picture", "new.png", "--quiet"])
        == 2
    )
    assert "would both be written to new.png" in capsys.readouterr().err
    assert not (folder / "new.png").exists()


def test_functions_also_refuse_existing_companion_files(folder: Path) -> None:
    mesh, (V, F) = read_file("b.glb"), igl.icosahedron()
    (folder / "new.mtl").write_bytes(OWN)
    with pytest.raises(FileExistsError, match="force=True"):
        write_file("new.obj", mesh, mesh.V[:, :2])
    with pytest.raises(FileExistsError, match="force=True"):
        write_textured("new.obj", V, F, V[:, :2], F, np.ones((2, 2)))
    assert not (folder / "new.obj").exists()
    write_file("new.obj", mesh, mesh.V[:, :2], force=True)
    assert (folder / "new.mtl").read_bytes() != OWN


@pytest.mark.parametrize("own", ["b.obj", "b.mtl", "results.parquet"])
def test_a_batch_replaces_only_files_written_by_a_batch(own: str, folder: Path) -> None:
    pytest.importorskip("distributed")
    (folder / "maps").mkdir()
    (folder / "maps" / own).write_bytes(OWN)
    with pytest.raises(FileExistsError, match="no batch has written them"):
        flatten_files("b.off", "maps", workers=1, progress=False)
    assert sorted(path.name for path in (folder / "maps").iterdir() if path.name[0] != ".") == [own]
    assert (folder / "maps" / own).read_bytes() == OWN


@pytest.mark.slow
def test_a_batch_replaces_its_own_maps(folder: Path) -> None:
    pytest.importorskip("distributed")
    for method in ("linabf", "abf"):  # another method flattens all meshes again
        assert flatten_files("b.off", "maps", workers=1, progress=False, method=method).done == 1
    (folder / "maps" / "disk.obj").write_bytes(OWN)
    with pytest.raises(FileExistsError, match=r"disk\.obj are there already"):
        flatten_files("disk.off", "maps", workers=1, progress=False)
    assert flatten_files("disk.off", "maps", workers=1, progress=False, force=True).good
    assert (folder / "maps" / "disk.obj").read_bytes() != OWN


def test_names_on_standard_output_are_relative_to_the_current_folder(
    folder: Path, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    (folder / "in").mkdir()
    (folder / "in" / "b.mtl").write_text("newmtl a\n")
    text = (folder / "b.obj").read_text()
    (folder / "in" / "b.obj").write_text(f"mtllib b.mtl\nusemtl a\n{text}")
    assert main(["unwrap", "in/b.obj", "-o", "-", "--quiet"]) == 0
    assert b"\nmtllib in/b.mtl\n" in b"\n" + capfdbinary.readouterr().out


@pytest.mark.skipif(os.name == "nt", reason="names of files are Unicode there")
def test_files_beside_a_name_that_is_not_utf8_are_found(folder: Path) -> None:
    name = os.fsdecode(b"caf\xe9.obj")
    V, F = igl.icosahedron()
    try:
        write_textured(name, V, F, V[:, :2], F, np.ones((2, 2)))
    except OSError:
        pytest.skip("this file system has only names in UTF-8")
    assert b"mtllib caf\xe9.mtl\n" in (folder / name).read_bytes()
    assert b"map_Kd caf\xe9.png\n" in (folder / os.fsdecode(b"caf\xe9.mtl")).read_bytes()
    assert read_file(name).extras.looks[0].images


def test_a_foreign_table_is_not_replaced(folder: Path) -> None:
    pytest.importorskip("distributed")
    (folder / "maps").mkdir()
    (folder / "maps" / "results.csv").write_bytes(OWN)
    with pytest.raises((OSError, MeshError), match="not the table of a batch"):
        flatten_files("b.off", "maps", workers=1, progress=False)
    assert (folder / "maps" / "results.csv").read_bytes() == OWN


def test_keep_materials_separates_materials_by_chart(tmp_path: Path) -> None:
    lines = [f"v {x} {y} {z}" for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    lines += ["usemtl wood", "f 1 3 4 2", "f 5 6 8 7", "f 1 2 6 5"]
    lines += ["usemtl iron", "f 3 7 8 4", "f 1 5 7 3", "f 2 4 8 6"]
    (tmp_path / "in.obj").write_text("\n".join(lines) + "\n")
    out = tmp_path / "out.obj"
    words = ["unwrap", str(tmp_path / "in.obj"), "-o", str(out), "--quiet"]
    shared = []
    for more in ([], ["--keep-materials"]):
        assert main([*words, *more]) == 0
        mesh = read_file(out)
        shared.append(bool(set(mesh.FTC[:3].ravel()) & set(mesh.FTC[3:].ravel())))
    assert shared == [True, False]
    (tmp_path / "in.obj").write_text("\n".join(line for line in lines if "usemtl" not in line) + "\n")
    assert main([*words, "--keep-materials"]) == 2
