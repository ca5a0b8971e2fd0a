"""`--texcoord 1` adds second texture coordinates, and keeps the first ones with their images."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from kept_of_gltf import (
    P,
    get_array,
    get_corner_values,
    get_description,
    make_document,
    make_material_entries,
    make_png,
)

from igl_linabf import MeshWarning
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


def write_tetrahedron(folder: Path, **shading: object) -> Path:
    path = folder / "in.gltf"
    info = {"baseColorTexture": {"index": 0}}
    looks = make_material_entries(pbrMetallicRoughness=info, normalTexture={"index": 0}, **shading)
    looks["images"] = [{"bufferView": 5, "mimeType": "image/png"}]
    given = {"TEXCOORD_0": UV, "NORMAL": P, "TANGENT": TANGENT}
    path.write_text(make_document(given, raw=(make_png(),), primitive={"material": 0}, **looks))
    return path


def test_glb_keeps_both_sets_with_images_and_tangents(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, out = write_tetrahedron(tmp_path), tmp_path / "out.glb"
    assert main(["unwrap", str(source), "-o", str(out), "--texcoord", "1", "--quiet", "--trade", "30"]) == 0
    assert not capsys.readouterr().err
    before, after = read_file(source), read_file(out)
    for name in ("TEXCOORD_0", "TANGENT", "NORMAL"):
        assert (get_corner_values(before, name) == get_corner_values(after, name)).all()
    assert get_description(after)["materials"] == get_description(before)["materials"]
    second = get_corner_values(after, "TEXCOORD_1")
    assert np.ptp(second, axis=0).max() > 0.9
    primitive = get_description(after)["meshes"][0]["primitives"][0]
    triangles = second.reshape(-1, 3, 2)
    sides = triangles[:, 1:] - triangles[:, :1]
    assert (np.abs(np.linalg.det(sides)) > 0.01).all()
    assert len(get_array(after, primitive["attributes"]["POSITION"])) >= 4
    # writing new first texture coordinates preserves the second coordinates
    assert main(["unwrap", str(out), "-o", str(tmp_path / "again.glb"), "--quiet"]) == 0
    again = read_file(tmp_path / "again.glb")
    assert (get_corner_values(again, "TEXCOORD_1") == second).all()


def test_a_warning_reports_images_on_old_second_coordinates(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = write_tetrahedron(tmp_path, occlusionTexture={"index": 0, "texCoord": 1})
    text = json.loads(source.read_text())
    attributes = text["meshes"][0]["primitives"][0]["attributes"]
    attributes["TEXCOORD_1"] = attributes["TEXCOORD_0"]
    source.write_text(json.dumps(text))
    assert main(["unwrap", str(source), "-o", str(tmp_path / "o.glb"), "--texcoord", "1", "--quiet"]) == 0
    assert "1 image for the old texture coordinates" in capsys.readouterr().err


@pytest.mark.parametrize("suffix", [".glb", ".ply"])
def test_both_sets_are_written_to_other_formats(suffix: str, tmp_path: Path) -> None:
    (tmp_path / "in.obj").write_text(OBJ)
    mesh = read_file(tmp_path / "in.obj")
    TC = np.random.default_rng(0).random((12, 2))
    FTC = np.arange(12).reshape(-1, 3)
    with pytest.warns(match="does not keep"):  # the format loses materials
        write_file(tmp_path / f"out{suffix}", mesh, TC, FTC, texcoord=1)
    after = read_file(tmp_path / f"out{suffix}")
    assert np.allclose(after.TC[after.FTC], mesh.TC[mesh.FTC], atol=1e-6)
    if suffix == ".glb":
        second = get_corner_values(after, "TEXCOORD_1") * [1, -1] + [0, 1]
    else:
        tables = after.extras.source
        assert isinstance(tables, PlyTables)
        second = tables.tables["face"]["texcoord1"].values.reshape(-1, 2)
        # second texture coordinates are unknown properties, which are kept
        write_file(tmp_path / "again.ply", after, TC[::-1], FTC)
        again = read_file(tmp_path / "again.ply").extras.source
        assert (again.tables["face"]["texcoord1"].values.reshape(-1, 2) == second).all()
    assert np.allclose(second, TC, atol=1e-6)


def test_ply_polygons_have_both_sets_at_their_vertices(tmp_path: Path) -> None:
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


def test_obj_gets_a_second_file_with_a_warning(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
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
    printed = capsys.readouterr().err
    assert printed.count("warning") == 1
    assert "out_texcoord1.obj" in printed
    before, first, second = (read_file(tmp_path / f"{name}.obj") for name in ("in", "out", "out_texcoord1"))
    assert (first.TC[first.FTC] == before.TC[before.FTC]).all()
    assert (first.V == second.V).all()
    assert (first.F == second.F).all()
    assert not np.allclose(first.TC[first.FTC], second.TC[second.FTC])
    assert main(words) == 2  # the second output file already exists
    assert main([*words, "--force"]) == 0


def test_a_warning_reports_texture_coordinates_of_polylines_but_no_images(tmp_path: Path) -> None:
    (tmp_path / "in.obj").write_text(OBJ + "l 1/1 2/2\n")
    mesh = read_file(tmp_path / "in.obj")
    with pytest.warns(MeshWarning) as caught:
        write_file(tmp_path / "out.obj", mesh, mesh.TC, mesh.FTC, texcoord=1)
    assert any("the texture coordinates of polylines (l)" in str(warning.message) for warning in caught)
    assert not any("images" in str(warning.message) for warning in caught)


def test_formats_and_meshes_without_two_sets_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "in.obj").write_text(OBJ)
    words = ["unwrap", str(tmp_path / "in.obj"), "--texcoord", "1", "-o"]
    assert main([*words, str(tmp_path / "o.vtp")]) == 2
    assert "does not end in .glb or .gltf or .ply or .obj" in capsys.readouterr().err
    assert main([*words, str(tmp_path / "o.glb"), "--bake", "normals"]) == 2
    (tmp_path / "in.obj").write_text("\n".join(line for line in OBJ.replace("/", "//").splitlines()))
    assert main([*words, str(tmp_path / "o.glb")]) == 2
    assert "no texture coordinates: leave out --texcoord" in capsys.readouterr().err
    mesh = read_file(tmp_path / "in.obj")
    with pytest.raises(ValueError, match="first texture coordinates"):
        write_file(tmp_path / "o.glb", mesh, mesh.V[:, :2], texcoord=1)
    with pytest.raises(ValueError, match="texcoord is 2"):
        write_file(tmp_path / "o.glb", mesh, mesh.V[:, :2], texcoord=2)


@pytest.mark.parametrize("suffix", [".glb", ".ply"])
def test_second_coordinates_are_checked_and_packed_and_the_first_ones_are_kept(
    suffix: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "in.obj").write_text(OBJ)
    source, out = tmp_path / f"in{suffix}", tmp_path / f"out{suffix}"
    mesh = read_file(tmp_path / "in.obj")
    corners = np.array([[0.1, 0.1], [0.3, 0.1], [0.1, 0.3]])
    shifts = np.array([[0, 0], [0.3, 0], [0.02, 0], [0, 0.3]])  # the first and the third triangle overlap
    with pytest.warns(match="does not keep"):
        write_file(
            source, mesh, (corners + shifts[:, None]).reshape(-1, 2), np.arange(12).reshape(-1, 3), texcoord=1
        )
    assert main(["check", str(source), "--texcoord", "1", "--json"]) == 1
    assert "overlap by accident" in json.loads(capsys.readouterr().out)["troubles"][0]
    words = ["--texcoord", "1", "--resolution", "64"]
    assert main(["pack", str(source), "-o", str(out), *words, "--padding", "3", "--quiet"]) == 0
    assert main(["check", str(out), *words, "--min-margin", "3", "--quiet"]) == 0
    before, after = read_file(source), read_file(out)
    assert (after.TC[after.FTC] == before.TC[before.FTC]).all()
    both = read_file(out, texcoord=1)
    assert (both.first[0][both.first[1]] == after.TC[after.texture]).all()
    for triangle in both.TC[both.FTC]:  # right-angled and isosceles, as before
        legs = triangle[1:] - triangle[0]
        assert np.allclose(legs @ legs.T, np.eye(2) * (legs[0] @ legs[0]), atol=1e-6)


def test_only_images_on_second_coordinates_separate_their_charts(tmp_path: Path) -> None:
    source = write_tetrahedron(tmp_path, occlusionTexture={"index": 0, "texCoord": 1})
    text = json.loads(source.read_text())
    attributes = text["meshes"][0]["primitives"][0]["attributes"]
    attributes["TEXCOORD_1"] = attributes["TEXCOORD_0"]
    source.write_text(json.dumps(text))
    (look,) = read_file(source, texcoord=1).extras.looks
    assert [image_map.kind for image_map in look.maps] == ["occlusionTexture"]


def test_files_without_second_coordinates_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "in.obj").write_text(OBJ)
    mesh = read_file(tmp_path / "in.obj")
    with pytest.warns(match="does not keep"):
        write_file(tmp_path / "in.ply", mesh, mesh.TC, mesh.FTC)
    cases = {
        "in.obj": "one set of texture coordinates: use GLB, glTF or PLY; for OBJ, read in_texcoord1.obj",
        "in.ply": "in.ply has no second texture coordinates: unwrap it with --texcoord 1",
    }
    for name, message in cases.items():
        assert main(["check", str(tmp_path / name), "--texcoord", "1"]) == 2
        assert message in capsys.readouterr().err
    words = ["pack", str(tmp_path / "in.ply"), "--texcoord", "1", "-o", str(tmp_path / "o.vtp")]
    assert main(words) == 2
    assert "does not end in .glb or .gltf or .ply or .obj" in capsys.readouterr().err
