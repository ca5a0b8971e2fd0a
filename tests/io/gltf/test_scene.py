"""Normals, colours, materials, parts, transforms, units and arrays of a file survive a round trip."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import warnings
from pathlib import Path

import igl
import numpy as np
import pytest
from carried import dual, hemisphere, quads
from conftest import find_blender_python, load
from gltf_files import OBJ, corners, unwrap_file, write_glb, write_scene

from igl_linabf import MeshError, MeshWarning, flatten, linabf, unwrap
from igl_linabf.cli import main
from igl_linabf.io import read_file, read_mesh, read_texture, write_file, write_mesh
from igl_linabf.io.gltf.images import find_sampler


def test_an_obj_keeps_its_lines(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "box.mtl").write_text("newmtl red\nnewmtl blue\n")
    (tmp_path / "in" / "box.obj").write_text(OBJ)
    with pytest.warns(MeshWarning, match=r"texture coordinates of polylines \(l\)"):
        before, after = unwrap_file(tmp_path / "in" / "box.obj", tmp_path / "out.obj")
    text = (tmp_path / "out.obj").read_text().splitlines()
    kept = [line for line in OBJ.splitlines() if line.split()[0] not in ("vt", "f", "l", "mtllib")]
    assert [line for line in text if line.split()[0] not in ("vt", "f", "l", "mtllib")] == kept
    assert "mtllib in/box.mtl" in text  # the path is relative to the new file
    assert "l 1 5" in text
    assert [line.count("/") for line in text if line[0] == "f"] == [
        8,
        8,
        4,
        4,
        4,
        4,
    ]  # the same corners have normals
    assert np.allclose(corners(after), corners(before))
    assert after.parts == ("lid", "body")
    assert after.materials == ("red", "blue")
    assert np.allclose(after.colours, before.colours)


def test_a_ply_keeps_its_properties_and_elements(tmp_path: Path) -> None:
    V, F = dual()
    rng = np.random.default_rng(0)
    lines = ["ply", "format ascii 1.0", "comment of a scanner", f"element vertex {len(V)}"]
    lines += [f"property float {name}" for name in ("x", "y", "z", "confidence")]
    lines += [f"property uchar {name}" for name in ("red", "green", "blue")]
    lines += [f"element face {len(F)}", "property list uchar int vertex_indices", "property int label"]
    lines += ["element camera 1", "property float focus", "end_header"]
    colours = rng.integers(256, size=(len(V), 3))
    lines += [
        f"{x} {y} {z} {i} {r} {g} {b}"
        for i, ((x, y, z), (r, g, b)) in enumerate(zip(V, colours, strict=True))
    ]
    lines += [f"{len(row)} {' '.join(map(str, row))} {i}" for i, row in enumerate(F)]
    (tmp_path / "in.ply").write_text("\n".join([*lines, "0.5", ""]))
    before, after = unwrap_file(tmp_path / "in.ply", tmp_path / "out.ply")
    tables = after.extras.source.tables
    assert after.extras.source.comments == ["comment of a scanner"]
    assert (tables["face"]["label"].values == np.arange(len(F))).all()
    assert tables["camera"]["focus"].values.tolist() == [0.5]
    vertex = np.round(tables["vertex"]["confidence"].values).astype(int)
    assert (vertex[after.polygons.corners] == before.polygons.corners).all()
    assert np.allclose(after.colours, before.colours[vertex])
    with pytest.warns(MeshWarning, match="the elements camera of in.ply: write PLY"):
        write_file(tmp_path / "out.obj", before, before.TC, before.FTC)


def test_unusable_gltf_files_are_refused_with_a_reason(tmp_path: Path) -> None:
    path, V = tmp_path / "in.glb", np.array([[0, 0, 0], [1, 0, 0], [0, np.inf, 0]], dtype="<f4")
    text = {"asset": {"version": "2.0"}, "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "nodes": [{"mesh": 0, "scale": [2] * 3}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}]}  # fmt: skip
    write_glb(path, text, [V.tobytes()])
    with pytest.raises(MeshError, match="in V of vertices 2 are NaN or infinite"):
        unwrap(*read_mesh(path))
    write_glb(path, text | {"asset": {"version": "1.0"}}, [V.tobytes()])
    with pytest.raises(MeshError, match=r"a glTF of version 1\.0: write it as glTF 2\.0"):
        read_mesh(path)


def test_a_gltf_scene_survives_a_round_trip(tmp_path: Path) -> None:
    write_scene(tmp_path / "in.glb")
    before, after = unwrap_file(tmp_path / "in.glb", tmp_path / "out.glb")
    V, F = igl.icosahedron()
    assert len(before.polygons) == 20 + 9
    turned = V[F] + [1, 2, 3]
    assert np.allclose(before.V[before.triangles[:20]], 2 * turned[..., [1, 0, 2]] * [-1, 1, 1], atol=1e-6)
    assert len(np.unique(before.triangles[:20])) == 12  # the two primitives form one surface
    assert np.allclose(corners(after), corners(before), atol=1e-6)
    assert before.parts == after.parts == ("here", "ball")
    assert before.materials == ("gold", "lead")
    old, new = before.extras.source.gltf, after.extras.source.gltf
    assert new.text["nodes"] == old.text["nodes"]
    assert new.text["materials"][:2] == old.text["materials"]
    assert new.text["meshes"][0]["weights"] == [0.5]
    sampler = new.text["animations"][0]["samplers"][0]
    assert (new.read_array(sampler["output"]) == np.arange(9).reshape(3, 3)).all()
    for j in range(2):
        was, now = (of.text["meshes"][0]["primitives"][j] for of in (old, new))
        index = new.read_array(now["indices"]), old.read_array(was["indices"])
        for name in ("POSITION", "NORMAL", "COLOR_0"):
            rows = new.read_array(now["attributes"][name]), old.read_array(was["attributes"][name])
            assert rows[0].dtype == rows[1].dtype
            assert (rows[0][index[0]] == rows[1][index[1]]).all()
        rows = new.read_array(now["targets"][0]["POSITION"]), old.read_array(was["targets"][0]["POSITION"])
        assert (rows[0][index[0]] == rows[1][index[1]]).all()
    assert len(new.text["accessors"]) == len({json.dumps(a) for a in new.text["accessors"]})


def test_pygltflib_and_trimesh_open_the_scene(tmp_path: Path) -> None:
    pygltflib, trimesh = pytest.importorskip("pygltflib"), pytest.importorskip("trimesh")
    write_scene(tmp_path / "in.glb")
    unwrap_file(tmp_path / "in.glb", tmp_path / "out.glb")
    assert [node.name for node in pygltflib.GLTF2().load(str(tmp_path / "out.glb")).nodes][1:] == [
        "here",
        "there",
        "ball",
    ]
    opened = trimesh.load_scene(tmp_path / "out.glb", process=False)
    assert len(opened.graph.nodes_geometry) == 5  # two primitives in each of two nodes, and a ball
    assert opened.to_geometry().area == pytest.approx(4 * (2 * 9.574541 + 9 / 20 * 9.574541), rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".glb", ".obj", ".ply"])
def test_blender_opens_written_files(tmp_path: Path, suffix: str) -> None:
    blender = find_blender_python()
    V, F = quads()
    atlas = unwrap(V, F, progress=False)
    write_mesh(tmp_path / f"mesh{suffix}", V, F, atlas.TC, atlas.FTC)
    load = {".glb": "import_scene.gltf", ".obj": "wm.obj_import", ".ply": "wm.ply_import"}[suffix]
    script = (
        "import bpy; bpy.ops.wm.read_factory_settings(use_empty=True)\n"
        f"bpy.ops.{load}(filepath=r'{tmp_path / 'mesh'}{suffix}')\n"
        "m = next(o for o in bpy.data.objects if o.type == 'MESH').data\n"
        "uv = m.uv_layers.active.data\n"
        "print('read', len(m.polygons), len(m.uv_layers), sum(d.uv.x + d.uv.y for d in uv) / len(uv))"
    )
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    process = subprocess.run(
        [blender, "-c", script], capture_output=True, encoding="utf-8", timeout=500, env=environment
    )
    line = next(line for line in process.stdout.splitlines() if line.startswith("read"))
    _, faces, layers, mean = line.split()
    flat = (
        np.concatenate([np.ravel(row) for row in atlas.FTC]) if suffix != ".glb" else atlas.triangles.ravel()
    )
    assert int(faces) == (len(F) if suffix != ".glb" else 2 * len(F))  # Blender ignores FB_ngon_encoding
    assert layers == "1"
    assert float(mean) == pytest.approx(atlas.TC[flat].sum(axis=1).mean(), abs=1e-4)


def test_a_gifti_cortex_is_flattened_to_gifti(tmp_path: Path) -> None:
    pytest.importorskip("nilearn")
    nibabel = pytest.importorskip("nibabel")
    V, F = hemisphere("flat_left")
    meta = nibabel.gifti.GiftiMetaData({"AnatomicalStructurePrimary": "CortexLeft"})
    arrays = [
        nibabel.gifti.GiftiDataArray(V.astype("f4"), intent="NIFTI_INTENT_POINTSET", meta=meta),
        nibabel.gifti.GiftiDataArray(F.astype("i4"), intent="NIFTI_INTENT_TRIANGLE"),
    ]
    nibabel.save(nibabel.gifti.GiftiImage(darrays=arrays), tmp_path / "lh.surf.gii")
    out = tmp_path / "lh.flat.surf.gii"
    assert main(["flatten", str(tmp_path / "lh.surf.gii"), "-o", str(out), "--units", "mesh", "--quiet"]) == 0
    points, triangles = nibabel.load(out).darrays
    assert points.meta["GeometricType"] == "Flat"
    assert points.meta["AnatomicalStructurePrimary"] == "CortexLeft"
    assert (triangles.data == F).all()  # vertex numbers do not change, so that data at vertices remain valid
    assert np.allclose(
        points.data[:, :2], flatten(V.astype("f4"), F, progress=False).uv, rtol=1e-3, atol=1e-2
    )
    assert not points.data[:, 2].any()


def test_freesurfer_3mf_and_vtp_are_read(tmp_path: Path) -> None:
    freesurfer = pytest.importorskip("nibabel.freesurfer")
    V, F = igl.icosahedron()
    freesurfer.write_geometry(tmp_path / "lh.white", V, F)
    # a file without a suffix is detected by its first bytes
    freesurfer.write_geometry(tmp_path / "surface", V, F)
    for name in ("lh.white", "surface"):
        positions, faces = read_mesh(tmp_path / name)
        assert np.allclose(positions, V, atol=1e-6)
        assert (faces == F).all()
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("lxml")
    pytest.importorskip("networkx")
    both = trimesh.Scene()
    for k, name in enumerate(("left", "right")):
        both.add_geometry(
            trimesh.Trimesh(V, F, process=False),
            name,
            transform=trimesh.transformations.translation_matrix([9 * k, 0, 0]),
        )
    both.export(tmp_path / "two.3mf")
    mesh = read_file(tmp_path / "two.3mf")
    assert len(mesh.parts) == 2
    assert np.ptp(mesh.V, axis=0)[0] == pytest.approx(9 + np.ptp(V[:, 0]))
    assert mesh.extras.units
    pyvista = pytest.importorskip("pyvista")
    V, F = dual()
    poly = pyvista.PolyData(V, np.concatenate([[len(row), *row] for row in F]))
    poly.point_data["height"] = V[:, 2]
    poly.cell_data["label"] = np.arange(len(F))
    poly.save(tmp_path / "in.vtp")
    before, after = unwrap_file(tmp_path / "in.vtp", tmp_path / "out.vtp")
    assert np.allclose(corners(after), corners(before), atol=1e-6)
    again = pyvista.read(tmp_path / "out.vtp")
    assert np.allclose(again.point_data["height"], again.points[:, 2], atol=1e-6)
    assert (again.cell_data["label"] == np.arange(len(F))).all()


def test_vtp_colours_and_normals_are_read_and_warnings_point_at_the_caller(tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    ball = pyvista.Icosphere(nsub=1).compute_normals(cell_normals=False, split_vertices=False)
    ball.point_data["shade"] = (np.arange(ball.n_points * 3) % 256).reshape(-1, 3).astype(np.uint8)
    ball.save(tmp_path / "ball.vtp")
    before, after = unwrap_file(tmp_path / "ball.vtp", tmp_path / "ball.glb")
    for mesh in (before, after):
        assert mesh.colours is not None
        corners = mesh.V[mesh.polygons.corners]
        at = pyvista.PolyData(np.asarray(ball.points)).find_closest_point
        nearest = [at(point) for point in corners]
        shade = ball.point_data["shade"][nearest] / 255
        assert np.abs(mesh.colours[mesh.polygons.corners][:, :3] - shade).max() < 1e-3
        normals = mesh.extras.normals[mesh.extras.normal]
        assert (np.einsum("ij,ij->i", normals, ball.point_normals[nearest]) > 1 - 1e-6).all()
    with pytest.warns(MeshWarning, match="VTP does not keep the names of its parts of ball.glb") as caught:
        write_file(tmp_path / "again.vtp", after, after.TC, after.FTC)
    assert {warning.filename for warning in caught} == {__file__}
    again = read_file(tmp_path / "again.vtp")
    np.testing.assert_allclose(
        again.extras.normals[again.extras.normal], after.extras.normals[after.extras.normal], atol=1e-6
    )


def test_3mf_skips_faces_with_repeated_vertices(tmp_path: Path) -> None:
    pytest.importorskip("lib3mf")
    V, F = np.eye(3), np.array([[0, 1, 1], [0, 1, 2], [2, 2, 2]])
    with pytest.warns(MeshWarning, match="faces 0, 2 have a vertex twice, which 3MF does not allow"):
        write_mesh(tmp_path / "one.3mf", V, F, V[:, :2])
    mesh = read_file(tmp_path / "one.3mf")
    assert np.allclose(mesh.V[mesh.triangles], V[F[1:2]])
    with pytest.raises(MeshError, match="no face has three distinct vertices"):
        write_mesh(tmp_path / "none.3mf", V, F[[0, 2]], V[:, :2])
    assert not (tmp_path / "none.3mf").exists()


@pytest.mark.parametrize("name", ["scene.glb", "box.vtp", "two.3mf", "lh.surf.gii", "lh.white"])
def test_damaged_files_are_refused_in_one_sentence(tmp_path: Path, name: str) -> None:
    V, F = igl.icosahedron()
    path = tmp_path / name
    if name == "scene.glb":
        write_scene(path)
    elif name == "box.vtp":
        pytest.importorskip("pyvista").Box().save(path)
    elif name == "two.3mf":
        pytest.importorskip("lxml")
        pytest.importorskip("networkx")
        pytest.importorskip("trimesh").Trimesh(V, F).export(path)
    elif name == "lh.white":
        pytest.importorskip("nibabel.freesurfer").write_geometry(path, V, F)
    else:
        write_mesh(path, V, F[:5], V[:, :2]) if pytest.importorskip("nibabel") else None
    whole, rng, refused = path.read_bytes(), np.random.default_rng(0), 0
    for _ in range(60):
        data = bytearray(whole)
        for i in rng.integers(len(data), size=int(rng.integers(1, 9))):
            data[i] = int(rng.integers(256))
        path.write_bytes(bytes(data[: int(rng.integers(len(data)))]) if rng.random() < 0.3 else bytes(data))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                read_file(path)
            except MeshError as error:
                assert name in str(error)
                refused += 1
    assert refused > 5


def test_a_missing_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "nibabel", None)
    (tmp_path / "lh.surf.gii").write_text("")
    with pytest.raises(ImportError, match=r"pip install 'igl-linabf\[formats\]'"):
        read_file(tmp_path / "lh.surf.gii")


@pytest.mark.parametrize("scale", [[-1, 1, 1], [1, -2, 1], [-1, -1, -3], [-1, -1, 1]], ids=str)
def test_a_mirrored_mesh_keeps_its_orientation(scale: list[float], tmp_path: Path) -> None:
    V, F = igl.icosahedron()
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 12, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5125, "count": 60, "type": "SCALAR"},
    ]
    text = {
        "asset": {"version": "2.0"},
        "nodes": [{"children": [1], "scale": scale}, {"mesh": 0, "translation": [3, 0, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": accessors,
    }
    write_glb(tmp_path / "in.glb", text, [V.astype("<f4").tobytes(), F.astype("<u4").tobytes()])
    before, after = unwrap_file(tmp_path / "in.glb", tmp_path / "out.glb")
    for mesh in (before, after):
        np.testing.assert_allclose(mesh.V.mean(axis=0), np.array([3, 0, 0]) * scale, atol=1e-6)
        a, b, c = (mesh.V[mesh.triangles] - mesh.V.mean(axis=0)).transpose(1, 0, 2)
        assert (np.einsum("ij,ij->i", a, np.cross(b, c)) > 0).all()


def test_an_unknown_key_of_a_texture_reference_is_not_its_sampler() -> None:
    text = {"textures": [{"sampler": 0}], "samplers": [{"wrapS": 33071}]}
    assert find_sampler(text, {"index": 0, "sampler": 7}) == {"wrapS": 33071}


def test_units_scale_the_node_of_a_glb(tmp_path: Path) -> None:
    pytest.importorskip("lxml")
    pytest.importorskip("networkx")
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.box(extents=[200, 100, 50]).export(tmp_path / "box.3mf")
    before, after = unwrap_file(tmp_path / "box.3mf", tmp_path / "box.glb")
    assert before.extras.units == "millimeter"
    assert np.allclose(np.ptp(after.V, axis=0), [0.2, 0.1, 0.05])


@pytest.mark.parametrize("names", ["s t", "u v", "texture_u texture_v"])
def test_ply_texture_coordinates_are_read(names: str, tmp_path) -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    path = tmp_path / "bumps.ply"
    write_mesh(path, V, F, uv)
    head, _, body = path.read_bytes().partition(b"end_header")
    for old, new in zip((b" s\n", b" t\n"), names.encode().split(), strict=True):
        head = head.replace(old, b" " + new + b"\n")
    path.write_bytes(head + b"end_header" + body)
    TC, FTC = read_texture(path)
    assert np.allclose(TC[FTC], uv[F], atol=1e-6 * np.ptp(uv))
