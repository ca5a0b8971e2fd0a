"""If one part of a scene has no texture coordinates, commands still process the other parts."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import igl
import numpy as np
import pytest
from PIL import Image

from igl_linabf import Packing, check_uv, unwrap
from igl_linabf.cli import main
from igl_linabf.io import MeshFile, image_maps, read_file, write_file
from igl_linabf.surface import Polygons

BALL, LAMP = igl.icosahedron(), igl.icosahedron()
ATLAS = unwrap(*BALL)
RED = (1.0, 0.0, 0.0)


def write_obj(path: Path) -> Path:
    """Write a ball with a red image, and a lamp with the same material and no texture coordinates."""
    V, F = BALL
    Image.new("RGB", (4, 4), (255, 0, 0)).save(path.with_name("red.png"))
    path.with_name("looks.mtl").write_text("newmtl red\nmap_Kd red.png\n")
    lines = ["mtllib looks.mtl"]
    lines += [f"v {x} {y} {z}" for x, y, z in np.concatenate((V, V + np.array([4, 0, 0])))]
    lines += [f"vt {u} {v}" for u, v in ATLAS.TC]
    lines += ["o ball", "usemtl red"]
    lines += [
        f"f {' '.join(f'{i + 1}/{t + 1}' for i, t in zip(*rows, strict=True))}"
        for rows in zip(F, ATLAS.FTC, strict=True)
    ]
    lines += ["o lamp", *(f"f {a} {b} {c}" for a, b, c in F + len(V) + 1)]
    path.write_text("\n".join([*lines, ""]))
    return path


@pytest.fixture(params=[".obj", ".glb"])
def scene(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    path = write_obj(tmp_path / "scene.obj")
    if request.param == ".obj":
        return path
    mesh = read_file(path, partial=True)
    maps = {"baseColorTexture": np.ones((4, 4, 3)) * RED}
    write_file(tmp_path / "scene.glb", mesh, mesh.TC, mesh.FTC, maps)
    return tmp_path / "scene.glb"


def run(capsys: pytest.CaptureFixture[str], *words: str, code: int = 0) -> dict[str, Any]:
    """Run a command, check that one warning names the lamp, and return the figures."""
    assert main([*words, "--json"]) == code
    printed = capsys.readouterr()
    warnings = [line for line in printed.err.splitlines() if "lamp" in line]
    assert len(warnings) == 1
    assert "20 faces without texture coordinates, in lamp" in warnings[0]
    found = json.loads(printed.out)
    assert found["unmapped_parts"] == ["lamp"]
    return found


def list_corners(mesh: MeshFile, part: str) -> Any:
    """Return the texture coordinates at the corners of a part; None if it has none."""
    rows = mesh.texture[np.isin(mesh.polygons.polygon_of_corner, find_faces(mesh, part))]
    assert (rows < 0).all() or (rows >= 0).all()
    return None if rows[0] < 0 else mesh.TC[rows]


def find_faces(mesh: MeshFile, part: str) -> np.ndarray:
    return np.flatnonzero(mesh.extras.parts[1] == mesh.parts.index(part))


def test_images_are_baked_for_the_other_parts(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = scene.with_name("baked.glb")
    run(capsys, "unwrap", str(scene), "-o", str(out), "--bake", "texture", "--resolution", "256")
    mesh = read_file(out)
    (picture,) = image_maps(mesh)["baseColorTexture"]
    for part, colour in (("ball", RED), ("lamp", (1.0, 1.0, 1.0))):
        centres = mesh.TC[mesh.FTC].mean(axis=1)[find_faces(mesh, part)]
        assert np.allclose(picture.interpolate(centres)[:, :3], colour, atol=0.01)


def test_second_coordinates_leave_the_first_ones_of_the_other_parts(
    scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = scene.with_name("lit.ply")
    before = read_file(scene, partial=True)
    assert main(["unwrap", str(scene), "-o", str(out), "--texcoord", "1", "--quiet"]) == 0
    assert "20 faces without texture coordinates, in lamp: both sets" in capsys.readouterr().err
    after = read_file(out)
    owner = np.isin(after.polygons.polygon_of_corner, np.arange(20))
    assert np.allclose(after.TC[after.texture[owner]], list_corners(before, "ball"), atol=1e-6)
    columns = after.extras.source.tables["face"]["texcoord1"].values.reshape(-1, 2)
    assert np.allclose(columns[~owner], after.TC[after.texture[~owner]])
    assert check_uv(after.V, after.F, columns, np.arange(120).reshape(-1, 3)).good


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_charts_of_the_other_parts_are_packed(
    scene: Path, suffix: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out = scene.with_name(f"packed{suffix}")
    found = run(capsys, "pack", str(scene), "-o", str(out), "--resolution", "512", "--padding", "9")
    assert found["packed"]["unmapped"] == 20
    mesh = read_file(out, partial=True)
    assert list_corners(mesh, "lamp") is None
    assert np.ptp(list_corners(mesh, "ball"), axis=0).max() > 0.9
    found = run(capsys, "check", str(out), code=1)
    assert found["check"]["unmapped"] == 20
    assert found["troubles"] == ["20 faces of 40 without texture coordinates: unwrap the mesh"]


def test_formats_with_coordinates_at_all_corners_say_so(
    scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = scene.with_name("packed.ply")
    assert main(["pack", str(scene), "-o", str(out), "--quiet"]) == 0
    assert "PLY has texture coordinates at all corners: lamp without" in capsys.readouterr().err
    mesh = read_file(out)
    assert (mesh.TC[mesh.texture[60:]] == [0, 1]).all()


def test_seams_are_found_on_parts_without_any(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = scene.with_name("cut.obj")
    found = run(capsys, "unwrap", str(scene), "-o", str(out), "--seams", "uv", "--force")
    assert found["good"]
    mesh = read_file(out)
    given = read_file(scene, partial=True)
    automatic = unwrap(given.V, given.F[find_faces(given, "lamp")], packing=Packing(cut_below=0))
    for part, charts in (("ball", len(ATLAS.charts)), ("lamp", len(automatic.charts))):
        faces = find_faces(mesh, part)
        F, FTC = mesh.F[faces], mesh.FTC[faces]
        assert check_uv(mesh.V, F, mesh.TC, FTC).charts == charts


def test_a_face_keeps_its_coordinates_if_another_has_none() -> None:
    polygons = Polygons.from_faces([[0, 1, 2], [0, 2, 3]])
    V, TC = np.eye(4, 3), np.eye(3, 2)
    mesh = MeshFile(V, polygons, TC, np.array([0, 1, 2, -1, -1, -1]))
    assert mesh.with_texture(TC * 2, [[0, 1, 2], [-1, -1, -1]]).texture.tolist() == [0, 1, 2, -1, -1, -1]
    with pytest.raises(ValueError, match="outside"):
        mesh.with_texture(TC, [[0, 1, -1], [-1, -1, -1]])
    with pytest.raises(ValueError, match="outside"):
        MeshFile(V, polygons).with_texture(TC, [[0, 1, 2], [-1, -1, -1]])
