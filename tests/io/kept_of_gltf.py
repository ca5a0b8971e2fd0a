"""Checks of what remains of the contents of glTF and GLB files in each format that is written."""

from __future__ import annotations

import base64
import json
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kept import Cell, round_trip
from PIL import Image

from igl_linabf import Packing, unwrap
from igl_linabf.io import MeshFile, image_maps, read_file, write_file
from igl_linabf.textures import bake_texture

P = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="<f4")
F = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], dtype="<u2")
SQUARE = P[:, :2].copy()
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
CODES = {"float32": 5126, "uint16": 5123, "uint32": 5125, "uint8": 5121, "int16": 5122, "int8": 5120}


def make_document(
    attributes: dict[str, np.ndarray] | None = None,
    *,
    more: tuple[np.ndarray, ...] = (),
    raw: tuple[bytes, ...] = (),
    primitive: dict[str, Any] | None = None,
    **text: Any,
) -> str:
    """Return a glTF tetrahedron with additional accessors (`more`) and buffer views (`raw`).

    The numbers of the additional accessors start at 2 + #attributes.
    """
    given = {"POSITION": P, **(attributes or {})}
    arrays = [*given.values(), F.ravel(), *more]
    blocks = [np.ascontiguousarray(array).tobytes() for array in arrays] + list(raw)
    views, data = [], b""
    for block in blocks:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(block)})
        data += block + b"\0" * (-len(block) % 4)
    accessors = [
        {
            "bufferView": i,
            "componentType": CODES[array.dtype.name],
            "count": len(array),
            "type": KINDS[1 if array.ndim == 1 else array.shape[1]],
            **({"normalized": True} if array.ndim > 1 and array.dtype.kind in "ui" else {}),
        }
        for i, array in enumerate(arrays)
    ]
    first = {
        "attributes": {name: i for i, name in enumerate(given)},
        "indices": len(given),
        **(primitive or {}),
    }
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    made = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "tetra"}],
        "meshes": [{"primitives": [first]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data), "uri": uri}],
    }
    return json.dumps(made | text)


def get_description(mesh: MeshFile) -> dict[str, Any]:
    return mesh.extras.source.gltf.text


def get_array(mesh: MeshFile, number: int) -> np.ndarray:
    return mesh.extras.source.gltf.read_array(number)


def get_corner_values(mesh: MeshFile, name: str) -> np.ndarray:
    """Return an attribute of the first primitive at the corners of its triangles."""
    primitive = get_description(mesh)["meshes"][0]["primitives"][0]
    return get_array(mesh, primitive["attributes"][name])[get_array(mesh, primitive["indices"])]


def make_png() -> bytes:
    data = BytesIO()
    Image.new("RGB", (1, 1)).save(data, "PNG")
    return data.getvalue()


def make_material_entries(**of_materials: Any) -> dict[str, Any]:
    """Return the glTF entries of a material with textures and one image in an additional buffer view."""
    return {
        "materials": [{"name": "skin", **of_materials}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 4, "mimeType": "image/png"}],
    }


def check_attributes(folder: Path) -> None:
    given = {
        "NORMAL": P,
        "COLOR_0": np.arange(16, dtype="<u1").reshape(4, 4),
        "_LABEL": np.arange(4, dtype="<f4"),
        "TEXCOORD_1": SQUARE,
    }
    before, after = round_trip(folder, "a.gltf", make_document(given), "out.glb")
    for name in given:
        old, new = get_corner_values(before, name), get_corner_values(after, name)
        assert old.dtype == new.dtype
        assert (old == new).all()
    assert np.allclose(after.TC[after.texture], before.TC[before.texture], atol=1e-6)


def check_tree(folder: Path) -> None:
    nodes = [
        {"name": "all", "children": [1], "scale": [2, 2, 2], "extras": {"id": 3}},
        {"mesh": 0, "translation": [1, 2, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]
    lights = {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}
    used = {"extensionsUsed": ["KHR_lights_punctual"], "extensions": lights, "cameras": [{"name": "eye"}]}
    before, after = round_trip(folder, "a.gltf", make_document(nodes=nodes, **used), "out.glb")
    for key in ("nodes", "scenes", "extensions", "extensionsUsed", "cameras"):
        assert get_description(after)[key] == get_description(before)[key]


def check_shape_keys(folder: Path) -> None:
    primitive = {"targets": [{"POSITION": 2}]}
    before, after = round_trip(folder, "a.gltf", make_document(more=(P * 2,), primitive=primitive), "out.glb")
    corners = [
        get_array(mesh, its["targets"][0]["POSITION"])[get_array(mesh, its["indices"])]
        for mesh in (before, after)
        for its in get_description(mesh)["meshes"][0]["primitives"]
    ]
    assert (corners[0] == corners[1]).all()


def check_points(folder: Path) -> None:
    text = json.loads(make_document())
    text["meshes"][0]["primitives"].append({"mode": 0, "attributes": {"POSITION": 0}})
    _, after = round_trip(folder, "a.gltf", json.dumps(text), "out.glb")
    points = get_description(after)["meshes"][0]["primitives"][1]
    assert (get_array(after, points["attributes"]["POSITION"]) == P).all()


def check_metadata(folder: Path, extension: str = "EXT_structural_metadata") -> None:
    """Check that buffer views keep their bytes; only known extensions get new view numbers."""
    values, offsets = np.array([7, 8, 9, 10], "<f4"), np.array([0, 2, 4], "<u4")
    held = {"values": 3, "arrayOffsets": 4}
    tables = [{"class": "c", "count": 2, "properties": {"indices": held}}]
    text = make_document(
        {"NORMAL": P},
        raw=(values.tobytes(), offsets.tobytes()),
        extensions={extension: {"propertyTables": tables}},
        extensionsUsed=[extension],
    )
    _, after = round_trip(folder, "a.gltf", text, "out.glb")
    (table,) = get_description(after)["extensions"][extension]["propertyTables"]
    now = table["properties"]["indices"]
    assert after.extras.source.gltf.read_view(now["values"]) == values.tobytes()
    assert after.extras.source.gltf.read_view(now["arrayOffsets"]) == offsets.tobytes()


def check_features(folder: Path) -> None:
    """Check that features given by vertex numbers become an attribute."""
    ids = {"EXT_mesh_features": {"featureIds": [{"featureCount": 4}]}}
    text = make_document(primitive={"extensions": ids}, extensionsUsed=["EXT_mesh_features"])
    before, after = round_trip(folder, "a.gltf", text, "out.glb")
    primitive = get_description(after)["meshes"][0]["primitives"][0]
    (feature,) = primitive["extensions"]["EXT_mesh_features"]["featureIds"]
    numbers = get_corner_values(after, f"_FEATURE_ID_{feature['attribute']}")
    assert (P[numbers.astype(int)] == after.V[after.polygons.corners]).all()
    assert len(after.TC) > len(before.V)


def check_instancing(folder: Path) -> None:
    moved = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2, "SCALE": 3}}}
    at, scale = np.array([[0, 0, 0], [5, 0, 0]], "<f4"), np.array([[1, 1, 1], [3, 3, 3]], "<f4")
    text = make_document(
        more=(at, scale),
        nodes=[{"mesh": 0, "extensions": moved}],
        extensionsUsed=["EXT_mesh_gpu_instancing"],
        extensionsRequired=["EXT_mesh_gpu_instancing"],
    )
    before, after = round_trip(folder, "a.gltf", text, "out.glb")
    assert np.allclose(before.V.max(axis=0), [8, 3, 3])  # the mesh has the size of its largest instance
    numbers = get_description(after)["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
    assert (get_array(after, numbers["TRANSLATION"]) == at).all()
    assert (get_array(after, numbers["SCALE"]) == scale).all()


def check_outline(folder: Path) -> None:
    edges = np.array([0, 1, 1, 2], "<u2")
    outline = {"extensions": {"CESIUM_primitive_outline": {"indices": 2}}}
    used = ["CESIUM_primitive_outline"]
    _, after = round_trip(
        folder, "a.gltf", make_document(more=(edges,), primitive=outline, extensionsUsed=used), "out.glb"
    )
    assert "extensions" not in get_description(after)["meshes"][0]["primitives"][0]
    assert "extensionsUsed" not in get_description(after)


def check_tangents(folder: Path) -> None:
    given = {"NORMAL": P, "TANGENT": np.ones((4, 4), "<f4")}
    _, after = round_trip(folder, "a.gltf", make_document(given), "out.glb")
    assert set(get_description(after)["meshes"][0]["primitives"][0]["attributes"]) == {
        "POSITION",
        "NORMAL",
        "TEXCOORD_0",
    }


def check_second_coordinates(folder: Path) -> None:
    """Check that images and tangents of TEXCOORD_1 are kept without a warning."""
    given = {"TEXCOORD_1": SQUARE, "TANGENT": np.ones((4, 4), "<f4")}
    text = make_document(
        given,
        raw=(make_png(),),
        primitive={"material": 0},
        **make_material_entries(normalTexture={"index": 0, "texCoord": 1}),
    )
    before, after = round_trip(folder, "a.gltf", text, "out.glb")
    assert get_description(after)["materials"] == get_description(before)["materials"]
    image = get_description(after)["images"][0]
    assert after.extras.source.gltf.read_view(image["bufferView"]) == make_png()
    for name in given:
        assert (get_corner_values(before, name) == get_corner_values(after, name)).all()


def check_old_images(folder: Path) -> None:
    text = make_document(
        {"TEXCOORD_0": SQUARE, "TEXCOORD_1": SQUARE},
        raw=(make_png(),),
        primitive={"material": 0},
        **make_material_entries(
            pbrMetallicRoughness={"baseColorTexture": {"index": 0}},
            occlusionTexture={"index": 0, "texCoord": 1},
        ),
    )
    round_trip(folder, "a.gltf", text, "out.glb")


def check_external_image(folder: Path) -> None:
    (folder / "in").mkdir()
    (folder / "in" / "a b.webp").write_bytes(b"an image")
    (folder / "in" / "schema.json").write_text("{}")
    extensions = {"EXT_structural_metadata": {"schemaUri": "schema.json"}}
    text = make_document(images=[{"uri": "a%20b.webp"}], extensions=extensions)
    _, after = round_trip(folder, "a.gltf", text, "out.glb")
    image = get_description(after)["images"][0]
    assert after.extras.source.gltf.read_view(image["bufferView"]) == b"an image"
    assert get_description(after)["extensions"]["EXT_structural_metadata"]["schemaUri"] == "../in/schema.json"


def check_quantized(folder: Path) -> None:
    short = {"POSITION": (P * 32767).astype("<i2"), "NORMAL": (P * 127).astype("<i1")}
    short = {
        name: np.pad(rows, ((0, 0), (0, 1))) for name, rows in short.items()
    }  # align each row to four bytes
    text = json.loads(make_document(short, extensionsRequired=["KHR_mesh_quantization"]))
    for accessor, view in zip(text["accessors"][:2], text["bufferViews"][:2], strict=True):
        accessor["type"], view["byteStride"] = "VEC3", view["byteLength"] // 4
    before, after = round_trip(folder, "a.gltf", json.dumps(text), "out.glb")
    assert np.allclose(before.V[before.polygons.corners], P[F].reshape(-1, 3), atol=1e-4)
    for name in short:
        assert (get_corner_values(before, name) == get_corner_values(after, name)).all()


def check_mirrored(folder: Path) -> None:
    """Check that faces are oriented outwards in the scene, and that the mesh itself does not change."""
    nodes = [{"mesh": 0, "scale": [-1, 1, 1]}]
    before, after = round_trip(folder, "a.gltf", make_document(nodes=nodes), "out.glb")
    for mesh in (before, after):
        a, b, c = mesh.V[mesh.triangles].transpose(1, 0, 2)
        assert np.einsum("ij,ij->", np.cross(a, b), c) > 0
    corners = get_corner_values(after, "POSITION").reshape(-1, 3, 3)
    assert {tuple(sorted(map(tuple, face.tolist()))) for face in corners} == {
        tuple(sorted(map(tuple, face.tolist()))) for face in P[F]
    }
    assert np.einsum("ij,ij->", np.cross(corners[:, 0], corners[:, 1]), corners[:, 2]) > 0


def check_refused(text: str, folder: Path) -> None:
    round_trip(folder, "a.gltf", text, "out.glb")


def check_meshopt(folder: Path) -> None:
    meshopt = pytest.importorskip("meshopt")
    text, name = json.loads(make_document()), "EXT_meshopt_compression"
    data = meshopt.encode_vertex_buffer(P)
    uri = f"data:;base64,{base64.b64encode(data).decode()}"
    text["buffers"].append({"byteLength": len(data), "uri": uri})
    mark = {"buffer": 1, "byteLength": len(data), "byteStride": 12, "count": 4, "mode": "ATTRIBUTES"}
    text["bufferViews"][0] |= {"byteStride": 12, "extensions": {name: mark}}
    text |= {"extensionsUsed": [name], "extensionsRequired": [name]}
    check_decompressed(folder, text)


def check_draco(folder: Path) -> None:
    DracoPy = pytest.importorskip("DracoPy")
    name, data = "KHR_draco_mesh_compression", DracoPy.encode(P, F.astype(np.uint32), preserve_order=True)
    mark = {"bufferView": 2, "attributes": {"POSITION": 0}}
    text = json.loads(make_document(raw=(data,), primitive={"extensions": {name: mark}}))
    for accessor in text["accessors"]:
        del accessor["bufferView"]
    text |= {"extensionsUsed": [name], "extensionsRequired": [name]}
    check_decompressed(folder, text)


def check_decompressed(folder: Path, text: dict[str, Any]) -> None:
    before, after = round_trip(folder, "a.gltf", json.dumps(text), "out.glb")
    for mesh in (before, after):
        corners = mesh.V[mesh.F].reshape(-1, 9).tolist()
        assert sorted(corners) == sorted(P[F].reshape(-1, 9).tolist())
    assert "extensionsUsed" not in get_description(after)


def check_obj_output(folder: Path, **more: Any) -> None:
    round_trip(folder, "a.gltf", make_document(**more))


def check_instances(folder: Path) -> None:
    """Check that the largest instance is written, not the first one or one of size 0."""
    nodes = [{"mesh": 0, "scale": [s] * 3, "translation": [t, 0, 0]} for s, t in ((0, 0), (0.1, 1), (4, 2))]
    _, after = round_trip(folder, "a.gltf", make_document(nodes=nodes, scenes=[{"nodes": [0, 1, 2]}]))
    assert np.allclose(after.V.max(axis=0), [6, 4, 4])


def check_partial_colours(folder: Path) -> None:
    text = json.loads(make_document({"COLOR_0": np.zeros((4, 3), "<f4")}))
    text["meshes"][0]["primitives"].append({"attributes": {"POSITION": 0}, "indices": 2})
    before, _ = round_trip(folder, "a.gltf", json.dumps(text))
    # the primitive with colours is black; the primitive without colours is white, even at shared vertices
    assert (before.extras.corner_colours == np.repeat([0, 1], 12)[:, None]).all()


def check_unnamed_materials(folder: Path) -> None:
    text = json.loads(make_document())
    text["meshes"][0]["primitives"].append({"attributes": {"POSITION": 0}, "indices": 1, "material": 0})
    text["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}]
    _, after = round_trip(folder, "a.gltf", json.dumps(text))
    of = np.repeat([0, 1], 12)
    names, material = after.extras.materials
    assert after.extras.looks[names.index("material 0")].colour == (1, 0, 0)
    assert (np.array(names)[material][of[::3] == 1] == "material 0").all()


def check_moved_images(
    folder: Path, to: str = "out.glb", kinds: tuple[str, ...] = ("baseColorTexture",)
) -> None:
    """Check that images on new texture coordinates equal the results of `bake_texture` for the old images."""
    shading = {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 1, 1, 1]}
    more = {"normalTexture": {"index": 0, "scale": 2}} if "normalTexture" in kinds else {}
    if "occlusionTexture" in kinds:
        more["occlusionTexture"] = {"index": 0}
    text = make_material_entries(pbrMetallicRoughness=shading, **more)
    source = make_document({"TEXCOORD_0": SQUARE}, raw=(make_png(),), primitive={"material": 0}, **text)
    for name in ("in", "out"):
        (folder / name).mkdir()
    (folder / "in" / "a.gltf").write_text(source.replace('"bufferView": 4', '"bufferView": 3'))
    mesh = read_file(folder / "in" / "a.gltf")
    atlas = unwrap(mesh.V, mesh.F, packing=Packing(resolution=32))
    labels = mesh.extras.materials[1]
    images = {
        kind: bake_texture(mesh.V, mesh.F, atlas, mesh.TC, mesh.FTC, own, 32, labels=labels)
        for kind, own in image_maps(mesh).items()
    }
    assert set(images) == set(kinds)
    write_file(folder / "out" / to, mesh, atlas.TC, atlas.FTC, images)
    after = read_file(folder / "out" / to)
    assert {of.kind for look in after.extras.looks for of in look.maps} == set(kinds) - {"occlusionTexture"}
    if to.endswith(".glb"):
        (material,) = get_description(after)["materials"]
        assert material["pbrMetallicRoughness"]["baseColorFactor"] == [0.5, 1, 1, 1]
        assert material.get("normalTexture", {"scale": 2})["scale"] == 2
    for kind, own in image_maps(after).items():
        assert np.abs(own[0].pixels - images[kind]).max() < 0.003


def check_second_set(folder: Path) -> None:
    """Check that the first texture coordinates, tangents and images are kept."""
    text = make_material_entries(normalTexture={"index": 0})
    text["images"][0]["bufferView"] = 4
    (folder / "a.gltf").write_text(
        make_document(
            {"TEXCOORD_0": SQUARE, "TANGENT": np.ones((4, 4), "<f4")},
            raw=(make_png(),),
            primitive={"material": 0},
            **text,
        )
    )
    before = read_file(folder / "a.gltf")
    write_file(
        folder / "out.glb",
        before,
        np.arange(24).reshape(12, 2),
        before.polygons.reshape_like_faces(np.arange(12)),
        texcoord=1,
    )
    after = read_file(folder / "out.glb")
    for name in ("TEXCOORD_0", "TANGENT"):
        assert (get_corner_values(before, name) == get_corner_values(after, name)).all()
    assert get_description(after)["materials"] == get_description(before)["materials"]
    assert (get_corner_values(after, "TEXCOORD_1")[:, 0] == np.arange(0, 24, 2)).all()


GLB = partial(Cell, "glTF", "GLB")
OBJ = partial(Cell, "glTF", "OBJ")
CELLS = [
    GLB("normals, colours, further texture coordinates, custom attributes", "kept", check_attributes),
    GLB("nodes, lights, cameras, extras", "kept", check_tree),
    GLB("shape keys", "kept", check_shape_keys),
    GLB("primitives that are points or lines", "kept", check_points),
    GLB("`EXT_structural_metadata` (buffer views are renumbered)", "kept", check_metadata),
    GLB(
        "unknown extensions that refer to buffer views or accessors (their numbers do not change)",
        "kept",
        partial(check_metadata, extension="ACME_tables"),
    ),
    GLB("`EXT_mesh_features`, including feature IDs given by vertex numbers", "kept", check_features),
    GLB("`EXT_mesh_gpu_instancing`", "kept", check_instancing),
    GLB("quantized positions and normals", "kept", check_quantized),
    GLB("meshes mirrored by a node", "kept", check_mirrored),
    GLB("images and tangents of `TEXCOORD_1`", "kept", check_second_coordinates),
    GLB("external files (images are embedded, other references are updated)", "kept", check_external_image),
    GLB(
        "images of the old texture coordinates",
        "warning",
        check_old_images,
        "its materials have 1 image for the old texture coordinates: unwrap --bake texture",
    ),
    GLB("images of the old texture coordinates, with `--bake texture`", "kept", check_moved_images),
    GLB(
        "normal maps and their scale, with `--bake texture`",
        "kept",
        partial(check_moved_images, kinds=("baseColorTexture", "normalTexture")),
    ),
    GLB(
        "the old (first) texture coordinates with their images and tangents, with `--texcoord 1`",
        "kept",
        check_second_set,
    ),
    GLB(
        "tangents of the old texture coordinates",
        "warning",
        check_tangents,
        "the tangents (TANGENT) of 1 of its primitives were made for the old texture coordinates",
    ),
    GLB(
        "unknown extensions of meshes and primitives",
        "warning",
        check_outline,
        "the extensions CESIUM_primitive_outline of meshes may refer to vertex numbers",
    ),
    GLB(
        "unknown extensions that are required",
        "error",
        partial(check_refused, make_document(extensionsRequired=["ACME_cut"])),
        "it requires the extension ACME_cut",
    ),
    GLB(
        "meshopt compression",
        "warning",
        check_meshopt,
        "compressed by EXT_meshopt_compression, and is written uncompressed",
    ),
    GLB(
        "Draco compression",
        "warning",
        check_draco,
        "compressed by KHR_draco_mesh_compression, and is written uncompressed",
    ),
    OBJ("materials without names", "kept", check_unnamed_materials),
    OBJ("images of materials, with `--bake texture`", "kept", partial(check_moved_images, to="out.obj")),
    OBJ(
        "texture maps that MTL does not have, with `--bake texture`",
        "warning",
        partial(check_moved_images, to="out.obj", kinds=("baseColorTexture", "occlusionTexture")),
        "OBJ cannot store the maps occlusionTexture",
    ),
    OBJ("colours that differ across an edge", "warning", check_partial_colours, "the colours of its corners"),
    OBJ(
        "further instances of a mesh (the largest instance is written)",
        "warning",
        check_instances,
        "2 further instances of its meshes",
    ),
    OBJ(
        "animations",
        "warning",
        partial(check_obj_output, animations=[{"channels": [], "samplers": []}]),
        "OBJ does not keep its animations of a.gltf: write GLB to keep all of it",
    ),
    OBJ(
        "shape keys",
        "warning",
        partial(check_obj_output, more=(P,), primitive={"targets": [{"POSITION": 2}]}),
        "OBJ does not keep its shape keys",
    ),
    OBJ(
        "further vertex attributes",
        "warning",
        partial(check_obj_output, attributes={"TEXCOORD_1": SQUARE}),
        "the attributes TEXCOORD_1",
    ),
    OBJ(
        "extensions",
        "warning",
        partial(check_obj_output, extensions={"KHR_lights_punctual": {"lights": []}}),
        "the extensions KHR_lights_punctual",
    ),
    OBJ("extras", "warning", partial(check_obj_output, primitive={"extras": {"id": 3}}), "its extras"),
    OBJ(
        "several scenes",
        "warning",
        partial(check_obj_output, scenes=[{"nodes": [0]}, {"name": "B"}]),
        "its 2 scenes",
    ),
    OBJ(
        "node hierarchies with more than one parent node",
        "warning",
        partial(
            check_obj_output,
            scenes=[{"nodes": [2]}],
            nodes=[{"mesh": 0}, {"name": "arm", "children": [0]}, {"name": "body", "children": [1]}],
        ),
        "its node hierarchy",
    ),
]
