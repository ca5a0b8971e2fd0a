"""`--texcoord 1`: second texture coordinates beside the first ones, which stay, with their images."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from kept_of_gltf import P, array_of, at_corners, document, png, text_of, textured

from igl_linabf import MeshError, MeshWarning
from igl_linabf.cli import main
from igl_linabf.io import read_file, write_file
from igl_linabf.io.ply.reading import PlyTables

UV = np.array([[0.1, 0.2], [0.7, 0.2], [0.1, 0.9], [0.6, 0.8]], dtype="<f4")
TANGENT = np.array([[1, 0, 0, 1]] * 4, dtype="<f4")
OBJ = "\n".join(
    [
        *("v 0 0 0", "v 1 0 0", "v 0 1 0", "v 0 0 1", "vt 0 0", "vt 1 0", "vt 0 1", "usemtl skin"),
        *("f 1/1 3/3 2/2", "f 1/1 2/2 4/3", "f 2/2 3/3 4/1", "f 1/1 4/2 3/3", ""),
    ]
)


def tetrahedron(folder: Path, **shading: object) -> Path:
    path = folder / "in.gltf"
    info = {"baseColorTexture": {"index": 0}}
    looks = textured(pbrMetallicRoughness=info, normalTexture={"index": 0}, **shading)
    looks["images"] = [{"bufferView": 5, "mimeType": "image/png"}]
    given = {"TEXCOORD_0": UV, "NORMAL": P, "TANGENT": TANGENT}
    path.write_text(document(given, raw=(png(),), primitive={"material": 0}, **looks))
    return path


def test_a_glb_file_has_both_and_its_images_and_tangents(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, out = tetrahedron(tmp_path), tmp_path / "out.glb"
    assert main(["unwrap", str(source), "-o", str(out), "--texcoord", "1", "--quiet", "--trade", "30"]) == 0
    assert not capsys.readouterr().err
    before, after = read_file(source), read_file(out)
    for name in ("TEXCOORD_0", "TANGENT", "NORMAL"):
        assert (at_corners(before, name) == at_corners(after, name)).all()
    assert text_of(after)["materials"] == text_of(before)["materials"]
    second = at_corners(after, "TEXCOORD_1")
    assert np.ptp(second, axis=0).max() > 0.9
    primitive = text_of(after)["meshes"][0]["primitives"][0]
    triangles = second.reshape(-1, 3, 2)
    sides = triangles[:, 1:] - triangles[:, :1]
    assert (np.abs(np.linalg.det(sides)) > 0.01).all()
    assert len(array_of(after, primitive["attributes"]["POSITION"])) >= 4
    # and the other way round: new first ones leave the second ones
    assert main(["unwrap", str(out), "-o", str(tmp_path / "again.glb"), "--quiet"]) == 0
    again = read_file(tmp_path / "again.glb")
    assert (at_corners(again, "TEXCOORD_1") == second).all()


def test_images_on_old_second_coordinates_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tetrahedron(tmp_path, occlusionTexture={"index": 0, "texCoord": 1})
    text = json.loads(source.read_text())
    attributes = text["meshes"][0]["primitives"][0]["attributes"]
    attributes["TEXCOORD_1"] = attributes["TEXCOORD_0"]
    source.write_text(json.dumps(text))
    assert main(["unwrap", str(source), "-o", str(tmp_path / "o.glb"), "--texcoord", "1", "--quiet"]) == 0
    assert "1 images of its materials" in capsys.readouterr().err


@pytest.mark.parametrize("suffix", [".glb", ".ply"])
def test_other_formats_get_both(suffix: str, tmp_path: Path) -> None:
    (tmp_path / "in.obj").write_text(OBJ)
    mesh = read_file(tmp_path / "in.obj")
    TC = np.random.default_rng(0).random((12, 2))
    FTC = np.arange(12).reshape(-1, 3)
    with pytest.warns(match="does not keep"):  # what its materials are
        write_file(tmp_path / f"out{suffix}", mesh, TC, FTC, texcoord=1)
    after = read_file(tmp_path / f"out{suffix}")
    assert np.allclose(after.TC[after.FTC], mesh.TC[mesh.FTC], atol=1e-6)
    if suffix == ".glb":
        second = at_corners(after, "TEXCOORD_1") * [1, -1] + [0, 1]
    else:
        tables = after.extras.source
        assert isinstance(tables, PlyTables)
        second = tables.tables["face"]["texcoord1"].values.reshape(-1, 2)
        write_file(tmp_path / "again.ply", after, TC[::-1], FTC)  # which keeps what it does not know
        again = read_file(tmp_path / "again.ply").extras.source
        assert (again.tables["face"]["texcoord1"].values.reshape(-1, 2) == second).all()
    assert np.allclose(second, TC, atol=1e-6)


def test_polygons_of_a_ply_file_have_both_at_their_vertices(tmp_path: Path) -> None:
    lines = [
        "v 0 0 0",
        "v 1 0 0",
        "v 1 1 0",
        "v 0 1 0",
        "v 2 0 0",
        "v 2 1 0",
        "vt 0 0",
        "vt 1 0",
        "vt 1 1",
        "vt 0 1",
    ]
    (tmp_path / "in.obj").write_text("\n".join([*lines, "f 1/1 2/2 3/3 4/4", "f 2/1 5/2 6/3 3/4"]))
    mesh = read_file(tmp_path / "in.obj")
    TC = np.random.default_rng(0).random((6, 2))
    write_file(tmp_path / "out.ply", mesh, TC, texcoord=1)
    after = read_file(tmp_path / "out.ply")
    assert np.allclose(after.TC[after.FTC], mesh.TC[mesh.FTC], atol=1e-6)
    rows = after.extras.source.tables["vertex"]
    second = np.column_stack((rows["s1"].values, rows["t1"].values))[after.polygons.corners]
    assert np.allclose(second, TC[mesh.polygons.corners], atol=1e-6)


def test_an_obj_file_has_a_second_file_and_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "in.obj").write_text(OBJ)
    words = [
        "unwrap",
        str(tmp_path / "in.obj"),
        "-o",
        str(tmp_path / "out.obj"),
        "--texcoord",
        "1",
        "--quiet",
    ]
    assert main(words) == 0
    said = capsys.readouterr().err
    assert said.count("warning") == 1
    assert "out_texcoord1.obj" in said
    before, first, second = (read_file(tmp_path / f"{name}.obj") for name in ("in", "out", "out_texcoord1"))
    assert (first.TC[first.FTC] == before.TC[before.FTC]).all()
    assert (first.V == second.V).all()
    assert (first.F == second.F).all()
    assert not np.allclose(first.TC[first.FTC], second.TC[second.FTC])
    assert main(words) == 2  # the second file is there already
    assert main([*words, "--force"]) == 0


def test_what_polylines_lose_is_told_though_images_stay(tmp_path: Path) -> None:
    (tmp_path / "in.obj").write_text(OBJ + "l 1/1 2/2\n")
    mesh = read_file(tmp_path / "in.obj")
    with pytest.warns(MeshWarning) as told:
        write_file(tmp_path / "out.obj", mesh, mesh.TC, mesh.FTC, texcoord=1)
    assert any("the texture coordinates of polylines (l)" in str(of.message) for of in told)
    assert not any("images" in str(of.message) for of in told)


def test_what_has_no_place_for_two_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "in.obj").write_text(OBJ)
    words = ["unwrap", str(tmp_path / "in.obj"), "--texcoord", "1", "-o"]
    assert main([*words, str(tmp_path / "o.vtp")]) == 2
    assert "does not end in .glb or .gltf or .ply or .obj" in capsys.readouterr().err
    assert main([*words, str(tmp_path / "o.glb"), "--bake", "normals"]) == 2
    (tmp_path / "in.obj").write_text(OBJ.replace("f 1/1 3/3 2/2", "f 1 3 2"))
    assert main([*words, str(tmp_path / "o.glb")]) == 2
    assert "at all corners" in capsys.readouterr().err
    mesh = read_file(tmp_path / "in.obj")
    with pytest.raises(MeshError, match="first texture coordinates"):
        write_file(tmp_path / "o.glb", mesh, mesh.V[:, :2], texcoord=1)
    with pytest.raises(ValueError, match="texcoord is 2"):
        write_file(tmp_path / "o.glb", mesh, mesh.V[:, :2], texcoord=2)
