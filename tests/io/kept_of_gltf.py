"""What glTF and GLB files have, and what becomes of it."""

from __future__ import annotations

import base64
import json
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from kept import Cell, carried
from PIL import Image

from igl_linabf import Packing, bake_texture, unwrap
from igl_linabf.io import MeshFile, image_maps, read_file, write_file

P = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="<f4")
F = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], dtype="<u2")
SQUARE = P[:, :2].copy()
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
CODES = {"float32": 5126, "uint16": 5123, "uint32": 5125, "uint8": 5121, "int16": 5122, "int8": 5120}


def document(
    attributes: dict[str, np.ndarray] | None = None,
    *,
    more: tuple[np.ndarray, ...] = (),
    raw: tuple[bytes, ...] = (),
    primitive: dict[str, Any] | None = None,
    **text: Any,
) -> str:
    """A glTF of one tetrahedron; `more` arrays are accessors from 2 + #attributes on, `raw` views behind."""
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


def text_of(mesh: MeshFile) -> dict[str, Any]:
    return mesh.extras.source.gltf.text


def array_of(mesh: MeshFile, number: int) -> np.ndarray:
    return mesh.extras.source.gltf.array(number)


def at_corners(mesh: MeshFile, name: str) -> np.ndarray:
    """An attribute of the first primitive at its corners."""
    primitive = text_of(mesh)["meshes"][0]["primitives"][0]
    return array_of(mesh, primitive["attributes"][name])[array_of(mesh, primitive["indices"])]


def png() -> bytes:
    data = BytesIO()
    Image.new("RGB", (1, 1)).save(data, "PNG")
    return data.getvalue()


def textured(**of_materials: Any) -> dict[str, Any]:
    """The entries of a file whose material has textures, and one image in the view that follows."""
    return {
        "materials": [{"name": "skin", **of_materials}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 4, "mimeType": "image/png"}],
    }


def _attributes(folder: Path) -> None:
    given = {
        "NORMAL": P,
        "COLOR_0": np.arange(16, dtype="<u1").reshape(4, 4),
        "_LABEL": np.arange(4, dtype="<f4"),
        "TEXCOORD_1": SQUARE,
    }
    before, after = carried(folder, "a.gltf", document(given), "out.glb")
    for name in given:
        old, new = at_corners(before, name), at_corners(after, name)
        assert old.dtype == new.dtype
        assert (old == new).all()
    assert np.allclose(after.TC[after.texture], before.TC[before.texture], atol=1e-6)


def _tree(folder: Path) -> None:
    nodes = [
        {"name": "all", "children": [1], "scale": [2, 2, 2], "extras": {"id": 3}},
        {"mesh": 0, "translation": [1, 2, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]
    lights = {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}
    used = {"extensionsUsed": ["KHR_lights_punctual"], "extensions": lights, "cameras": [{"name": "eye"}]}
    before, after = carried(folder, "a.gltf", document(nodes=nodes, **used), "out.glb")
    for key in ("nodes", "scenes", "extensions", "extensionsUsed", "cameras"):
        assert text_of(after)[key] == text_of(before)[key]


def _shape_keys(folder: Path) -> None:
    primitive = {"targets": [{"POSITION": 2}]}
    before, after = carried(folder, "a.gltf", document(more=(P * 2,), primitive=primitive), "out.glb")
    corners = [
        array_of(mesh, its["targets"][0]["POSITION"])[array_of(mesh, its["indices"])]
        for mesh in (before, after)
        for its in text_of(mesh)["meshes"][0]["primitives"]
    ]
    assert (corners[0] == corners[1]).all()


def _points(folder: Path) -> None:
    text = json.loads(document())
    text["meshes"][0]["primitives"].append({"mode": 0, "attributes": {"POSITION": 0}})
    _, after = carried(folder, "a.gltf", json.dumps(text), "out.glb")
    points = text_of(after)["meshes"][0]["primitives"][1]
    assert (array_of(after, points["attributes"]["POSITION"]) == P).all()


def _metadata(folder: Path, extension: str = "EXT_structural_metadata") -> None:
    """Views that an extension names hold the same bytes under their new numbers; unknown ones keep theirs."""
    values, offsets = np.array([7, 8, 9, 10], "<f4"), np.array([0, 2, 4], "<u4")
    held = {"values": 3, "arrayOffsets": 4}
    tables = [{"class": "c", "count": 2, "properties": {"indices": held}}]
    text = document(
        {"NORMAL": P},
        raw=(values.tobytes(), offsets.tobytes()),
        extensions={extension: {"propertyTables": tables}},
        extensionsUsed=[extension],
    )
    _, after = carried(folder, "a.gltf", text, "out.glb")
    (table,) = text_of(after)["extensions"][extension]["propertyTables"]
    now = table["properties"]["indices"]
    assert after.extras.source.gltf.view(now["values"]) == values.tobytes()
    assert after.extras.source.gltf.view(now["arrayOffsets"]) == offsets.tobytes()


def _features(folder: Path) -> None:
    """Features that the vertices' numbers gave are an attribute then."""
    ids = {"EXT_mesh_features": {"featureIds": [{"featureCount": 4}]}}
    text = document(primitive={"extensions": ids}, extensionsUsed=["EXT_mesh_features"])
    before, after = carried(folder, "a.gltf", text, "out.glb")
    primitive = text_of(after)["meshes"][0]["primitives"][0]
    (feature,) = primitive["extensions"]["EXT_mesh_features"]["featureIds"]
    numbers = at_corners(after, f"_FEATURE_ID_{feature['attribute']}")
    assert (P[numbers.astype(int)] == after.V[after.polygons.corners]).all()
    assert len(after.TC) > len(before.V)


def _instancing(folder: Path) -> None:
    moved = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2, "SCALE": 3}}}
    at, scale = np.array([[0, 0, 0], [5, 0, 0]], "<f4"), np.array([[1, 1, 1], [3, 3, 3]], "<f4")
    text = document(
        more=(at, scale),
        nodes=[{"mesh": 0, "extensions": moved}],
        extensionsUsed=["EXT_mesh_gpu_instancing"],
        extensionsRequired=["EXT_mesh_gpu_instancing"],
    )
    before, after = carried(folder, "a.gltf", text, "out.glb")
    assert np.allclose(before.V.max(axis=0), [8, 3, 3])  # the largest instance
    numbers = text_of(after)["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
    assert (array_of(after, numbers["TRANSLATION"]) == at).all()
    assert (array_of(after, numbers["SCALE"]) == scale).all()


def _outline(folder: Path) -> None:
    edges = np.array([0, 1, 1, 2], "<u2")
    outline = {"extensions": {"CESIUM_primitive_outline": {"indices": 2}}}
    used = ["CESIUM_primitive_outline"]
    _, after = carried(
        folder, "a.gltf", document(more=(edges,), primitive=outline, extensionsUsed=used), "out.glb"
    )
    assert "extensions" not in text_of(after)["meshes"][0]["primitives"][0]
    assert "extensionsUsed" not in text_of(after)


def _tangents(folder: Path) -> None:
    given = {"NORMAL": P, "TANGENT": np.ones((4, 4), "<f4")}
    _, after = carried(folder, "a.gltf", document(given), "out.glb")
    assert set(text_of(after)["meshes"][0]["primitives"][0]["attributes"]) == {
        "POSITION",
        "NORMAL",
        "TEXCOORD_0",
    }


def _second_coordinates(folder: Path) -> None:
    """An image and tangents of TEXCOORD_1 stay, and nothing is said of them."""
    given = {"TEXCOORD_1": SQUARE, "TANGENT": np.ones((4, 4), "<f4")}
    text = document(
        given, raw=(png(),), primitive={"material": 0}, **textured(normalTexture={"index": 0, "texCoord": 1})
    )
    before, after = carried(folder, "a.gltf", text, "out.glb")
    assert text_of(after)["materials"] == text_of(before)["materials"]
    image = text_of(after)["images"][0]
    assert after.extras.source.gltf.view(image["bufferView"]) == png()
    for name in given:
        assert (at_corners(before, name) == at_corners(after, name)).all()


def _old_images(folder: Path) -> None:
    text = document(
        {"TEXCOORD_0": SQUARE, "TEXCOORD_1": SQUARE},
        raw=(png(),),
        primitive={"material": 0},
        **textured(
            pbrMetallicRoughness={"baseColorTexture": {"index": 0}},
            occlusionTexture={"index": 0, "texCoord": 1},
        ),
    )
    carried(folder, "a.gltf", text, "out.glb")


def _image_beside(folder: Path) -> None:
    (folder / "in").mkdir()
    (folder / "in" / "a b.webp").write_bytes(b"an image")
    (folder / "in" / "schema.json").write_text("{}")
    extensions = {"EXT_structural_metadata": {"schemaUri": "schema.json"}}
    text = document(images=[{"uri": "a%20b.webp"}], extensions=extensions)
    _, after = carried(folder, "a.gltf", text, "out.glb")
    image = text_of(after)["images"][0]
    assert after.extras.source.gltf.view(image["bufferView"]) == b"an image"
    assert text_of(after)["extensions"]["EXT_structural_metadata"]["schemaUri"] == "../in/schema.json"


def _quantized(folder: Path) -> None:
    short = {"POSITION": (P * 32767).astype("<i2"), "NORMAL": (P * 127).astype("<i1")}
    short = {name: np.pad(rows, ((0, 0), (0, 1))) for name, rows in short.items()}  # rows of whole words
    text = json.loads(document(short, extensionsRequired=["KHR_mesh_quantization"]))
    for accessor, view in zip(text["accessors"][:2], text["bufferViews"][:2], strict=True):
        accessor["type"], view["byteStride"] = "VEC3", view["byteLength"] // 4
    before, after = carried(folder, "a.gltf", json.dumps(text), "out.glb")
    assert np.allclose(before.V[before.polygons.corners], P[F].reshape(-1, 3), atol=1e-4)
    for name in short:
        assert (at_corners(before, name) == at_corners(after, name)).all()


def _mirrored(folder: Path) -> None:
    """Faces look outwards in the scene, and the mesh itself stays as it was."""
    nodes = [{"mesh": 0, "scale": [-1, 1, 1]}]
    before, after = carried(folder, "a.gltf", document(nodes=nodes), "out.glb")
    for mesh in (before, after):
        a, b, c = mesh.V[mesh.triangles].transpose(1, 0, 2)
        assert np.einsum("ij,ij->", np.cross(a, b), c) > 0
    corners = at_corners(after, "POSITION").reshape(-1, 3, 3)
    assert {tuple(sorted(map(tuple, face.tolist()))) for face in corners} == {
        tuple(sorted(map(tuple, face.tolist()))) for face in P[F]
    }
    assert np.einsum("ij,ij->", np.cross(corners[:, 0], corners[:, 1]), corners[:, 2]) > 0


def _refused(text: str, folder: Path) -> None:
    carried(folder, "a.gltf", text, "out.glb")


def _compressed_views(folder: Path) -> None:
    text = json.loads(document())
    name = "EXT_meshopt_compression"
    text["buffers"].append({"byteLength": 48, "extensions": {name: {"fallback": True}}})
    mark = {"buffer": 0, "byteLength": 9, "byteStride": 12, "count": 4, "mode": "ATTRIBUTES"}
    text["bufferViews"][0] |= {"buffer": 1, "extensions": {name: mark}}
    carried(folder, "a.gltf", json.dumps(text), "out.glb")


def _to_obj(folder: Path, **more: Any) -> None:
    carried(folder, "a.gltf", document(**more))


def _instances_to_obj(folder: Path) -> None:
    """The largest instance counts, not the first one nor one of size 0."""
    nodes = [{"mesh": 0, "scale": [s] * 3, "translation": [t, 0, 0]} for s, t in ((0, 0), (0.1, 1), (4, 2))]
    _, after = carried(folder, "a.gltf", document(nodes=nodes, scenes=[{"nodes": [0, 1, 2]}]))
    assert np.allclose(after.V.max(axis=0), [6, 4, 4])


def _colours_of_some(folder: Path) -> None:
    text = json.loads(document({"COLOR_0": np.zeros((4, 3), "<f4")}))
    text["meshes"][0]["primitives"].append({"attributes": {"POSITION": 0}, "indices": 2})
    before, _ = carried(folder, "a.gltf", json.dumps(text))
    # black where they are, white elsewhere, also at vertices that both share
    assert (before.extras.corner_colours == np.repeat([0, 1], 12)[:, None]).all()


def _nameless(folder: Path) -> None:
    text = json.loads(document())
    text["meshes"][0]["primitives"].append({"attributes": {"POSITION": 0}, "indices": 1, "material": 0})
    text["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}]
    _, after = carried(folder, "a.gltf", json.dumps(text))
    of = np.repeat([0, 1], 12)
    names, material = after.extras.materials
    assert after.extras.looks[names.index("material 0")].colour == (1, 0, 0)
    assert (np.array(names)[material][of[::3] == 1] == "material 0").all()


def _moved(folder: Path, to: str = "out.glb", kinds: tuple[str, ...] = ("baseColorTexture",)) -> None:
    """Each image on its new coordinates is what `bake_texture` makes of the old one."""
    shading = {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 1, 1, 1]}
    more = {"normalTexture": {"index": 0, "scale": 2}} if "normalTexture" in kinds else {}
    if "occlusionTexture" in kinds:
        more["occlusionTexture"] = {"index": 0}
    text = textured(pbrMetallicRoughness=shading, **more)
    source = document({"TEXCOORD_0": SQUARE}, raw=(png(),), primitive={"material": 0}, **text)
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
        (material,) = text_of(after)["materials"]
        assert material["pbrMetallicRoughness"]["baseColorFactor"] == [0.5, 1, 1, 1]
        assert material.get("normalTexture", {"scale": 2})["scale"] == 2
    for kind, own in image_maps(after).items():
        assert np.abs(own[0].pixels - images[kind]).max() < 0.003


def _second_set(folder: Path) -> None:
    """The first texture coordinates, tangents and images stay."""
    text = textured(normalTexture={"index": 0})
    text["images"][0]["bufferView"] = 4
    (folder / "a.gltf").write_text(
        document(
            {"TEXCOORD_0": SQUARE, "TANGENT": np.ones((4, 4), "<f4")},
            raw=(png(),),
            primitive={"material": 0},
            **text,
        )
    )
    before = read_file(folder / "a.gltf")
    write_file(
        folder / "out.glb",
        before,
        np.arange(24).reshape(12, 2),
        before.polygons.shape(np.arange(12)),
        texcoord=1,
    )
    after = read_file(folder / "out.glb")
    for name in ("TEXCOORD_0", "TANGENT"):
        assert (at_corners(before, name) == at_corners(after, name)).all()
    assert text_of(after)["materials"] == text_of(before)["materials"]
    assert (at_corners(after, "TEXCOORD_1")[:, 0] == np.arange(0, 24, 2)).all()


GLB = partial(Cell, "glTF", "GLB")
OBJ = partial(Cell, "glTF", "OBJ")
CELLS = [
    GLB("normals, colours, further texture coordinates, custom attributes", "kept", _attributes),
    GLB("nodes, lights, cameras, extras", "kept", _tree),
    GLB("shape keys", "kept", _shape_keys),
    GLB("points and lines", "kept", _points),
    GLB("`EXT_structural_metadata` (buffer views are renumbered)", "kept", _metadata),
    GLB(
        "unknown extensions that refer to buffer views or accessors (their numbers do not change)",
        "kept",
        partial(_metadata, extension="ACME_tables"),
    ),
    GLB("`EXT_mesh_features`, including feature IDs given by vertex numbers", "kept", _features),
    GLB("`EXT_mesh_gpu_instancing`", "kept", _instancing),
    GLB("quantized positions and normals", "kept", _quantized),
    GLB("meshes mirrored by a node", "kept", _mirrored),
    GLB("images and tangents of `TEXCOORD_1`", "kept", _second_coordinates),
    GLB("external files: images are embedded, other references are updated", "kept", _image_beside),
    GLB(
        "images of the old texture coordinates",
        "warning",
        _old_images,
        "1 images of its materials were made for the old texture coordinates: --bake texture",
    ),
    GLB("images of the old texture coordinates, with `--bake texture`", "kept", _moved),
    GLB(
        "normal maps and their scale, with `--bake texture`",
        "kept",
        partial(_moved, kinds=("baseColorTexture", "normalTexture")),
    ),
    GLB("first texture coordinates, their images and tangents, with `--texcoord 1`", "kept", _second_set),
    GLB(
        "tangents of the old texture coordinates",
        "warning",
        _tangents,
        "the tangents (TANGENT) of 1 of its primitives were made for the old texture coordinates",
    ),
    GLB(
        "unknown extensions of meshes and primitives",
        "warning",
        _outline,
        "the extensions CESIUM_primitive_outline of meshes may refer to vertex numbers",
    ),
    GLB(
        "unknown extensions that are required",
        "error",
        partial(_refused, document(extensionsRequired=["ACME_cut"])),
        "it requires the extension ACME_cut",
    ),
    GLB(
        "meshopt compression, required",
        "error",
        partial(_refused, document(extensionsRequired=["EXT_meshopt_compression"])),
        "it is compressed by EXT_meshopt_compression: write it without",
    ),
    GLB(
        "meshopt compression of buffer views",
        "error",
        _compressed_views,
        "its buffer view 0 is compressed by",
    ),
    GLB(
        "Draco compression",
        "error",
        partial(_refused, document(primitive={"extensions": {"KHR_draco_mesh_compression": {}}})),
        "its mesh 0 is compressed by KHR_draco_mesh_compression",
    ),
    OBJ("materials without names", "kept", _nameless),
    OBJ("images, with `--bake texture`", "kept", partial(_moved, to="out.obj")),
    OBJ(
        "maps that MTL does not have, with `--bake texture`",
        "warning",
        partial(_moved, to="out.obj", kinds=("baseColorTexture", "occlusionTexture")),
        "OBJ cannot store the maps occlusionTexture",
    ),
    OBJ("colours that differ across an edge", "warning", _colours_of_some, "the colours of its corners"),
    OBJ(
        "further instances of a mesh (the largest one is written)",
        "warning",
        _instances_to_obj,
        "2 further instances of its meshes",
    ),
    OBJ(
        "animations",
        "warning",
        partial(_to_obj, animations=[{"channels": [], "samplers": []}]),
        "OBJ does not keep its animations of a.gltf: write GLB to keep all of it",
    ),
    OBJ(
        "shape keys",
        "warning",
        partial(_to_obj, more=(P,), primitive={"targets": [{"POSITION": 2}]}),
        "OBJ does not keep its shape keys",
    ),
    OBJ(
        "further attributes",
        "warning",
        partial(_to_obj, attributes={"TEXCOORD_1": SQUARE}),
        "the attributes TEXCOORD_1",
    ),
    OBJ(
        "extensions",
        "warning",
        partial(_to_obj, extensions={"KHR_lights_punctual": {"lights": []}}),
        "the extensions KHR_lights_punctual",
    ),
    OBJ("extras", "warning", partial(_to_obj, primitive={"extras": {"id": 3}}), "its extras"),
    OBJ(
        "several scenes", "warning", partial(_to_obj, scenes=[{"nodes": [0]}, {"name": "B"}]), "its 2 scenes"
    ),
    OBJ(
        "node hierarchies with more than one parent node",
        "warning",
        partial(
            _to_obj,
            scenes=[{"nodes": [2]}],
            nodes=[{"mesh": 0}, {"name": "arm", "children": [0]}, {"name": "body", "children": [1]}],
        ),
        "its node hierarchy",
    ),
]
