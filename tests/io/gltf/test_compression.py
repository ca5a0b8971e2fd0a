"""Compressed glTF files hold the mesh that was compressed, and are written uncompressed."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from igl_linabf import MeshError, MeshWarning
from igl_linabf.cli import main
from igl_linabf.io import MeshFile, read_file, write_file

DracoPy = pytest.importorskip("DracoPy")
meshopt = pytest.importorskip("meshopt")

DRACO = "KHR_draco_mesh_compression"
CODES = {"float32": 5126, "uint32": 5125, "uint16": 5123, "int8": 5120}
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
SIDE = 8
U, V = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 1, SIDE), np.linspace(0, 1, SIDE)))
POINTS = np.column_stack((3 * U, 2 * V, np.sin(3 * U) * V)).astype("<f4")
UV = np.column_stack((U, V)).astype("<f4")
NORMALS = np.column_stack((U, V, 1 - 0.5 * U)).astype("<f4")
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)
START = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
F = np.concatenate([START[:, None] + [0, 1, SIDE + 1], START[:, None] + [0, SIDE + 1, SIDE]]).astype("<u4")


def write_gltf(path: Path, views: list[bytes], **text: Any) -> Path:
    """Write a glTF file with a mesh that has accessors for positions, uv, normals and triangles."""
    data, places = b"", []
    for view in views:
        places.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(view)})
        data += view + b"\0" * (-len(view) % 4)
    accessors = [
        {"componentType": CODES[rows.dtype.name], "count": len(rows), "type": KINDS[rows.shape[1]]}
        for rows in (POINTS, UV, NORMALS, F.reshape(-1, 1))
    ]
    attributes = {"POSITION": 0, "TEXCOORD_0": 1, "NORMAL": 2}
    made = {
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 3}]}],
        "accessors": accessors,
        "bufferViews": places,
        "buffers": [{"byteLength": len(data), "uri": f"data:;base64,{base64.b64encode(data).decode()}"}],
    }
    path.write_text(json.dumps({**made, **text}))
    return path


def write_draco(path: Path, data: bytes | None = None, **options: Any) -> Path:
    """Write a glTF file whose only primitive is compressed by Draco."""
    if data is None:
        options = {"quantization_bits": 16, "compression_level": 7, **options}
        given = {"tex_coord": UV.astype(float), "normals": NORMALS.astype(float)}
        data = DracoPy.encode(POINTS, F, **given, **options)
    mark = {"bufferView": 0, "attributes": {"TEXCOORD_0": 0, "NORMAL": 1, "POSITION": 2}}
    write_gltf(path, [data], extensionsUsed=[DRACO], extensionsRequired=[DRACO])
    text = json.loads(path.read_text())
    text["meshes"][0]["primitives"][0]["extensions"] = {DRACO: mark}
    path.write_text(json.dumps(text))
    return path


def write_meshopt(
    path: Path, name: str = "EXT_meshopt_compression", changes: dict[str, Any] | None = None
) -> Path:
    """Write a glTF file whose buffer views are compressed by meshopt; normals are filtered."""
    octahedral = meshopt.encode_filter_oct(np.column_stack((NORMALS, np.ones(len(NORMALS)))), 4, 8)
    blocks = [
        (meshopt.encode_vertex_buffer(POINTS), len(POINTS), 12, "ATTRIBUTES", "NONE"),
        (meshopt.encode_vertex_buffer(UV), len(UV), 8, "ATTRIBUTES", "NONE"),
        (meshopt.encode_vertex_buffer(octahedral), len(NORMALS), 4, "ATTRIBUTES", "OCTAHEDRAL"),
        (meshopt.encode_index_buffer(F.ravel()), F.size, 4, "TRIANGLES", "NONE"),
    ]
    write_gltf(path, [data for data, *_ in blocks], extensionsUsed=[name], extensionsRequired=[name])
    text = json.loads(path.read_text())
    fallback = {"byteLength": sum(count * stride for _, count, stride, *_ in blocks)}
    text["buffers"].append({**fallback, "extensions": {name: {"fallback": True}}})
    start = 0
    for i, (_, count, stride, mode, filter_) in enumerate(blocks):
        mark = {**text["bufferViews"][i], "count": count, "byteStride": stride, "mode": mode}
        mark |= {"filter": filter_} if filter_ != "NONE" else {}
        mark |= (changes or {}) if i == 0 else {}
        view = {"buffer": 1, "byteOffset": start, "byteLength": count * stride, "extensions": {name: mark}}
        text["bufferViews"][i] = view | ({"byteStride": stride} if mode == "ATTRIBUTES" else {})
        text["accessors"][i]["bufferView"] = i
        start += count * stride
    text["accessors"][2] |= {"componentType": CODES["int8"], "normalized": True}
    path.write_text(json.dumps(text))
    return path


def sort_corners(points: np.ndarray, uv: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return positions, uv and normals at the corners of triangles, (#T, 24), sorted by the middle in space.

    Each triangle begins with its smallest corner.
    """
    rows = np.concatenate((points, uv, normals), axis=2)
    first = np.argmin(np.round(points[..., 0] * 100 + points[..., 1], 2), axis=1)
    rows = rows[np.arange(len(rows))[:, None], (first[:, None] + np.arange(3)) % 3]
    middle = np.round(rows[:, :, :2].mean(axis=1), 2)
    return rows[np.lexsort(middle.T)].reshape(len(rows), -1)


def check_mesh(mesh: MeshFile) -> None:
    extras = mesh.extras
    normals = extras.normals[extras.normal].reshape(-1, 3, 3)
    found = sort_corners(mesh.V[mesh.F], (mesh.TC * [1, -1] + [0, 1])[mesh.FTC], normals)
    given = sort_corners(POINTS[F], UV[F], NORMALS[F])
    assert found.shape == given.shape
    assert np.allclose(found[:, :], given, atol=0.02)
    assert np.allclose(found.reshape(-1, 8)[:, :5], given.reshape(-1, 8)[:, :5], atol=1e-4)


WRITERS = {
    "Draco, edgebreaker": write_draco,
    "Draco, sequential": lambda path: write_draco(path, preserve_order=True),
    "meshopt": write_meshopt,
    "meshopt, KHR": lambda path: write_meshopt(path, "KHR_meshopt_compression"),
}


@pytest.mark.parametrize("kind", WRITERS)
def test_compressed_files_hold_the_mesh_and_are_written_uncompressed(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = WRITERS[kind](tmp_path / "in.gltf")
    check_mesh(read_file(source))
    assert main(["pack", str(source), "-o", str(tmp_path / "out.glb"), "--quiet"]) == 0
    printed = capsys.readouterr().err
    assert printed.count("warning") == 1
    assert "compression, and is written uncompressed" in printed
    after = read_file(tmp_path / "out.glb")
    assert not {"extensionsUsed", "extensionsRequired"} & set(after.extras.source.gltf.text)
    assert len(after.F) == len(F)
    assert main(["unwrap", str(source), "-o", str(tmp_path / "out.obj"), "--quiet"]) == 0
    assert not capsys.readouterr().err  # OBJ loses nothing, so no warning


def test_uncompressed_data_are_used_if_the_file_has_both(tmp_path: Path) -> None:
    source = write_draco(tmp_path / "in.gltf", b"not Draco")
    text = json.loads(source.read_text())
    blocks = [POINTS, UV, NORMALS, F]
    data = b"".join(block.tobytes() for block in blocks)
    starts = np.cumsum([0, *(block.nbytes for block in blocks)]).tolist()
    text["buffers"].append(
        {"byteLength": len(data), "uri": f"data:;base64,{base64.b64encode(data).decode()}"}
    )
    for i, block in enumerate(blocks):
        text["bufferViews"].append({"buffer": 1, "byteOffset": starts[i], "byteLength": block.nbytes})
        text["accessors"][i]["bufferView"] = i + 1
    source.write_text(json.dumps(text))
    check_mesh(read_file(source))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"count": 2**32}, "out of proportion"),
        ({"byteLength": 10**6}, "ends after"),
        ({"byteStride": 10}, "rows of 10 bytes, which ATTRIBUTES"),
        ({"filter": "QUATERNION"}, "filter QUATERNION does not allow"),
        ({"mode": "TRIANGLES"}, "which TRIANGLES"),
        ({"count": 63}, "has 756 bytes, not 768"),
        ({"mode": "SPARSE"}, "glTF 2.0 requires"),
        ({"byteLength": 20}, "cannot be read"),
    ],
)
def test_wrong_layouts_of_meshopt_are_refused(changes: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=message):
        read_file(write_meshopt(tmp_path / "in.gltf", changes=changes))


def test_damaged_data_are_refused_or_give_a_mesh(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    whole = DracoPy.encode(POINTS, F, tex_coord=UV.astype(float), normals=NORMALS.astype(float))
    refused = 0
    for _ in range(300):
        data = bytearray(whole)
        for place in rng.integers(0, len(data), rng.integers(1, 4)):
            data[place] = rng.integers(256)
        data = data[: rng.integers(len(data))] if rng.random() < 0.2 else data
        source = write_draco(tmp_path / "in.gltf", bytes(data))
        try:
            mesh = read_file(source)
            write_file(tmp_path / "out.obj", mesh, np.zeros((len(mesh.V), 2)))
        except MeshError:
            refused += 1
    assert 50 < refused < 300


def test_a_number_of_triangles_out_of_proportion_is_refused_before_decoding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = DracoPy.encode(POINTS, F, tex_coord=UV.astype(float), normals=NORMALS.astype(float))
    assert whole[12:14] == bytes([len(POINTS), len(F)])  # the numbers of vertices and triangles
    monkeypatch.setattr(DracoPy, "decode", None)
    data = whole[:13] + b"\xff\xff\xff\xff\x0f" + whole[14:]
    with pytest.raises(MeshError, match="out of proportion"):
        read_file(write_draco(tmp_path / "in.gltf", data))


def test_a_missing_decoder_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for package, write in (("DracoPy", write_draco), ("meshopt", write_meshopt)):
        source = write(tmp_path / "in.gltf")
        monkeypatch.setitem(__import__("sys").modules, package, None)
        with pytest.raises(ImportError, match=r"igl-linabf\[formats\]"):
            read_file(source)


def test_primitives_may_share_compressed_data(tmp_path: Path) -> None:
    source = write_draco(tmp_path / "in.gltf")
    text = json.loads(source.read_text())
    text["meshes"][0]["primitives"] *= 2
    source.write_text(json.dumps(text))
    mesh = read_file(source)
    assert len(mesh.F) == 2 * len(F)
    with pytest.warns(MeshWarning, match="written uncompressed"):
        write_file(tmp_path / "out.glb", mesh, mesh.TC, mesh.FTC)
    assert len(read_file(tmp_path / "out.glb").F) == 2 * len(F)
