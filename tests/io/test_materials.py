"""Materials and textures survive a round trip through MTL, glTF text and 3MF; flat surfaces of FreeSurfer."""

from __future__ import annotations

import json
import subprocess
from io import BytesIO
from pathlib import Path

import igl
import numpy as np
import pytest
from carried import quads
from conftest import find_blender_python, load
from gltf_files import OBJ, corners, unwrap_file, write_scene
from PIL import Image

from igl_linabf import MeshError, MeshWarning, flatten, unwrap
from igl_linabf.cli import main
from igl_linabf.io import READABLE, SUFFIXES, read_file, write_file, write_mesh, write_textured
from igl_linabf.textures import bake

MTL = """# colours
newmtl red
Kd 0.8 0.1 0.1
Ns 12
illum 2
newmtl blue
Kd 0.1 0.2 0.7
d 0.5
Pr 0.3
Ke 0 0 0.4
"""
pytestmark = pytest.mark.filterwarnings("ignore::igl_linabf.MeshWarning")


def read_looks(path: Path) -> dict[str, tuple[float, ...]]:
    mesh = read_file(path)
    return {
        name: (*look.colour, look.alpha, *look.emission)
        for name, look in zip(mesh.materials, mesh.extras.looks or (), strict=True)
    }


def write_painted_box(folder: Path) -> Path:
    """Write a box with two materials and its material library."""
    (folder / "box.mtl").write_text(MTL)
    (folder / "box.obj").write_text(OBJ)
    return folder / "box.obj"


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_materials_survive_obj_to_gltf_and_back(tmp_path: Path, suffix: str) -> None:
    source = write_painted_box(tmp_path)
    before, after = unwrap_file(source, tmp_path / f"out{suffix}")
    assert len(after.polygons) == len(before.polygons)
    given, there = read_looks(source), read_looks(tmp_path / f"out{suffix}")
    assert given["blue"] == (0.1, 0.2, 0.7, 0.5, 0, 0, 0.4)
    unwrap_file(tmp_path / f"out{suffix}", tmp_path / "back.obj")
    assert (tmp_path / "back.mtl").is_file()
    back = read_looks(tmp_path / "back.obj")
    for name, values in given.items():
        np.testing.assert_allclose(there[name], values, atol=1e-6)
        np.testing.assert_allclose(back[name], values, atol=1e-5)
    names, of = read_file(tmp_path / "back.obj").extras.materials
    known, wanted = before.extras.materials
    assert [names[k] for k in of] == [known[k] for k in wanted]


def test_opacity_comes_from_d_or_tr(tmp_path: Path) -> None:
    (tmp_path / "box.obj").write_text(OBJ)
    for line, alpha in (("d 0.25", 0.25), ("Tr 0.25", 0.75), ("Tr 0.25\nd 0.5", 0.5), ("Ns 1", 1)):
        (tmp_path / "box.mtl").write_text(f"newmtl red\n{line}\nnewmtl blue\n")
        assert {name: look[3] for name, look in read_looks(tmp_path / "box.obj").items()} == {
            "red": alpha,
            "blue": 1,
        }


def test_other_libraries_open_text_gltf(tmp_path: Path) -> None:
    pygltflib, trimesh = pytest.importorskip("pygltflib"), pytest.importorskip("trimesh")
    write_scene(tmp_path / "in.glb")
    before, after = unwrap_file(tmp_path / "in.glb", tmp_path / "out.gltf")
    np.testing.assert_allclose(corners(after), corners(before), atol=1e-6)
    assert after.parts == before.parts
    text = json.loads((tmp_path / "out.gltf").read_text())
    assert text["buffers"][0]["uri"].startswith("data:")
    assert len(pygltflib.GLTF2().load(str(tmp_path / "out.gltf")).meshes) == len(text["meshes"])
    opened = trimesh.load_scene(tmp_path / "out.gltf", process=False)
    assert all(len(mesh.visual.uv) == len(mesh.vertices) for mesh in opened.geometry.values())


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".obj", ".3mf"])
def test_a_baked_texture_is_embedded_or_beside_the_file(tmp_path: Path, suffix: str) -> None:
    V, F = load("bumps")
    colours = (V - V.min(axis=0)) / np.ptp(V, axis=0)
    lines = [f"v {' '.join(map(str, row))}" for row in np.hstack((V, colours)).tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (F + 1).tolist()]
    (tmp_path / "in.obj").write_text("\n".join(lines))
    out = tmp_path / f"out{suffix}"
    if suffix == ".3mf":
        pytest.importorskip("lib3mf")
    bakes = ["--bake", "colors", "--resolution", "256", "--quiet"]
    assert main(["unwrap", str(tmp_path / "in.obj"), "-o", str(out), *bakes]) == 0
    beside = sorted(path.name for path in tmp_path.iterdir() if path.stem == "out")
    assert beside == (["out.mtl", "out.obj", "out.png"] if suffix == ".obj" else [out.name])
    if suffix == ".3mf":
        lib3mf = pytest.importorskip("lib3mf")
        model = lib3mf.get_wrapper().CreateModel()
        model.QueryReader("3mf").ReadFromFile(str(out))
        textures = model.GetTexture2Ds()
        assert textures.MoveNext()
        data = textures.GetCurrentTexture2D().GetAttachment().WriteToBuffer()
        image = np.asarray(Image.open(BytesIO(bytes(data))))
    else:
        trimesh = pytest.importorskip("trimesh")
        opened = trimesh.load(out, process=False, force="mesh")
        material = opened.visual.material
        image = np.asarray(getattr(material, "baseColorTexture", None) or material.image)
    assert image.shape[:2] == (256, 256)
    mesh = read_file(out)  # the image contains the colour of each corner
    x, y = np.clip((mesh.TC[mesh.texture] * [1, -1] + [0, 1]) * 256 - 0.5, 0, 255).round().astype(int).T
    at = mesh.V[mesh.polygons.corners]
    wanted = (at - V.min(axis=0)) / np.ptp(V, axis=0)
    assert np.median(np.abs(image[y, x, :3] / 255 - wanted)) < 0.01


def test_a_baked_obj_keeps_its_other_lines_and_materials(tmp_path: Path) -> None:
    source = write_painted_box(tmp_path)
    mesh = read_file(source)
    atlas = unwrap(mesh.V, mesh.F, progress=False)
    write_file(tmp_path / "new.obj", mesh, atlas.TC, atlas.FTC, np.full((8, 8, 3), 0.5))
    text = (tmp_path / "new.obj").read_text()
    assert text.count("mtllib") == 1
    assert "mtllib new.mtl" in text
    assert "# the last" in OBJ and "o lid" in text and "s off" in text
    library = (tmp_path / "new.mtl").read_text()
    assert library.count("map_Kd new.png") == 2
    assert "Ns 12" in library
    assert (tmp_path / "box.mtl").read_text() == MTL
    assert read_file(tmp_path / "new.obj").extras.looks[0].images


def test_a_failure_leaves_no_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    V, F = load("bumps")
    atlas = unwrap(V, F, progress=False)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("igl_linabf.io.formats.WRITERS", {".obj": full})
    with pytest.raises(OSError, match="No space"):
        write_textured(tmp_path / "out.obj", V, F, atlas.TC, atlas.FTC, np.ones((4, 4)))
    assert list(tmp_path.iterdir()) == []


def test_a_warning_reports_images_for_old_texture_coordinates(tmp_path: Path) -> None:
    source = write_painted_box(tmp_path)
    (tmp_path / "box.mtl").write_text(MTL.replace("illum 2", "map_Kd old.png"))
    mesh = read_file(source)
    atlas = unwrap(mesh.V, mesh.F, progress=False)
    with pytest.warns(MeshWarning, match="GLB does not keep the images of its materials"):
        write_file(tmp_path / "out.glb", mesh, atlas.TC, atlas.FTC)
    with pytest.warns(MeshWarning, match="old texture coordinates"):
        write_file(tmp_path / "out.obj", mesh, atlas.TC, atlas.FTC)


def test_3mf_has_texture_coordinates_parts_and_unit(tmp_path: Path) -> None:
    pytest.importorskip("lib3mf")
    source = write_painted_box(tmp_path)
    before, after = unwrap_file(source, tmp_path / "out.3mf")
    assert after.parts == before.parts
    assert after.extras.units == "millimeter"
    split = before.triangulation
    given = np.hstack(
        (before.V[split.F].reshape(-1, 3), before.TC[before.texture[split.place]].reshape(-1, 2))
    )
    _, part = before.extras.parts
    order = np.argsort(part[split.face], kind="stable")
    np.testing.assert_allclose(corners(after), given.reshape(-1, 3, 5)[order].reshape(-1, 5), atol=1e-6)
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("lxml")
    pytest.importorskip("networkx")
    opened = trimesh.load_scene(tmp_path / "out.3mf", process=False)
    assert sum(len(mesh.faces) for mesh in opened.geometry.values()) == len(split.F)
    write_scene(tmp_path / "in.glb")  # lengths in glTF are in metres
    before, after = unwrap_file(tmp_path / "in.glb", tmp_path / "scene.3mf")
    assert after.extras.units == "meter"
    assert np.ptp(after.V) == pytest.approx(np.ptp(before.V), rel=1e-6)


def test_meshlab_opens_3mf(tmp_path: Path) -> None:
    pymeshlab = pytest.importorskip("pymeshlab")
    pytest.importorskip("lib3mf")
    V, F = load("bumps")
    atlas = unwrap(V, F, progress=False)
    write_mesh(tmp_path / "m.3mf", V, F, atlas.TC, atlas.FTC)
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(tmp_path / "m.3mf"))
    assert meshes.current_mesh().face_number() == len(F)


def test_flat_cortices_are_written_for_freesurfer(tmp_path: Path) -> None:
    freesurfer = pytest.importorskip("nibabel.freesurfer")
    V, F = load("bumps")
    freesurfer.write_geometry(tmp_path / "lh.pial", V, F)
    mesh = read_file(tmp_path / "lh.pial")
    uv = flatten(mesh.V, mesh.F).uv
    with pytest.warns(MeshWarning, match="positions in space"):
        write_file(tmp_path / "lh.flat.surf", mesh, uv)
    points, faces = freesurfer.read_geometry(tmp_path / "lh.flat.surf")
    assert (faces == F).all()
    np.testing.assert_allclose(points[:, :2], uv, atol=1e-5 * np.ptp(uv))
    assert not points[:, 2].any()
    # the layout that FreeSurfer's read_patch expects: one row per vertex
    write_file(tmp_path / "lh.patch.flat", mesh, uv)
    data = (tmp_path / "lh.patch.flat").read_bytes()
    version, n = np.frombuffer(data, ">i4", 2)
    rows = np.frombuffer(data, [("vertex", ">i4"), ("place", ">f4", 3)], n, 8)
    assert (version, len(data)) == (-1, 8 + 16 * n)
    assert sorted(np.abs(rows["vertex"]) - 1) == list(range(len(V)))
    np.testing.assert_allclose(rows["place"][:, :2], uv[np.abs(rows["vertex"]) - 1], atol=1e-5 * np.ptp(uv))
    rim = np.abs(rows["vertex"][rows["vertex"] < 0]) - 1
    assert set(rim.tolist()) == set(igl.boundary_loop(F).tolist())
    atlas = unwrap(*igl.icosahedron(), progress=False)
    with pytest.raises(MeshError, match=r"on seams, .* write \.surf or \.gii"):
        write_mesh(tmp_path / "ball.flat", *igl.icosahedron(), atlas.TC, atlas.FTC)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".obj", ".gltf"])
def test_blender_shows_the_texture(tmp_path: Path, suffix: str) -> None:
    blender = find_blender_python()
    V, F = quads()
    atlas = unwrap(V, F, progress=False)
    image = bake(V, F, atlas, np.abs(V) / np.abs(V).max(), 64)
    write_textured(tmp_path / f"mesh{suffix}", V, F, atlas.TC, atlas.FTC, image)
    operator = {".gltf": "import_scene.gltf", ".obj": "wm.obj_import"}[suffix]
    script = (
        "import bpy; bpy.ops.wm.read_factory_settings(use_empty=True)\n"
        f"bpy.ops.{operator}(filepath=r'{tmp_path / 'mesh'}{suffix}')\n"
        "m = next(o for o in bpy.data.objects if o.type == 'MESH').data\n"
        "nodes = [n.image.size[:] for n in m.materials[0].node_tree.nodes if n.type == 'TEX_IMAGE']\n"
        "print('read', len(m.uv_layers), *nodes)"
    )
    process = subprocess.run([blender, "-c", script], capture_output=True, encoding="utf-8", timeout=500)
    assert "read 1 (64, 64)" in process.stdout, process.stderr


def test_every_written_format_is_readable() -> None:
    assert set(SUFFIXES) <= set(READABLE)
