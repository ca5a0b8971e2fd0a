"""Write glTF 2.0: GLB, its binary form, or .gltf, one text that holds the buffer, too."""

from __future__ import annotations

import base64
import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._types import IntArray
from ..errors import MeshError
from ..surface import Triangles
from .materials import Material, as_gltf, linear, without_images
from .mesh_file import MeshFile
from .ngons import EXTENSION, fans
from .one_index import one_index, single

FLOAT, UNSIGNED = 5126, 5125  # glTF's numbers for types of 32 bits
VERTEX_ATTRIBUTES, INDICES = 34962, 34963  # and for what a part is used as
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
METRES = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048}
LINEAR_MIPMAPS, LINEAR = 9987, 9729  # and for filters


class Buffer:
    """The binary part of a GLB file while it grows, and the description of what is in it."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.size = 0
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, rows: NDArray[Any], use: int, bounds: bool = False) -> int:
        """An array of 32-bit numbers; returns the number of its accessor."""
        data = rows.tobytes()
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": len(data), "target": use})
        accessor = {
            "bufferView": len(self.views) - 1,
            "type": KINDS[1 if rows.ndim == 1 else rows.shape[1]],
            "componentType": FLOAT if rows.dtype.kind == "f" else UNSIGNED,
            "count": len(rows),
        }
        if bounds:  # glTF asks for them, of positions as they are stored
            accessor |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self.accessors.append(accessor)
        self.parts.append(data)
        self.size += len(data)
        return len(self.accessors) - 1


def save_new_gltf(temporary: str, mesh: MeshFile) -> None:
    """Write polygons with texture coordinates at the vertices, v downwards: a node for each part."""
    extras, buffer = mesh.extras, Buffer()
    names, part = extras.parts or ((), np.full(len(mesh.polygons), -1))
    words, material = extras.materials or ((), np.full(len(mesh.polygons), -1))
    meshes: list[dict[str, Any]] = []
    nodes: list[dict[str, Any]] = []
    metres = METRES.get(extras.units or "meter", 1.0)
    size = {} if metres == 1 else {"scale": [metres] * 3}
    for i in np.unique(part).tolist():
        primitives = [
            _primitive(
                mesh, np.flatnonzero((part == i) & (material == k)), k if k >= 0 else len(words), buffer
            )
            for k in np.unique(material[part == i]).tolist()
        ]
        named = {"name": names[i]} if i >= 0 else {}
        nodes.append({"mesh": len(meshes), **named, **size})
        meshes.append({"primitives": primitives, **named})
    # readers (trimesh) drop texture coordinates that no material goes with
    looks = extras.looks or (Material(),) * len(words)
    materials = [as_gltf(look, name) for look, name in zip(looks, words, strict=True)]
    materials += [as_gltf(Material())] * bool((material < 0).any())
    polygons = any("extensions" in primitive for of in meshes for primitive in of["primitives"])
    description = {
        "asset": {"version": "2.0", "generator": "igl_linabf"},
        **({"extensionsUsed": [EXTENSION]} if polygons else {}),
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": buffer.size}],
    }
    write_gltf(temporary, description, buffer.parts, mesh.image)


def _primitive(mesh: MeshFile, faces: IntArray, material: int, buffer: Buffer) -> dict[str, Any]:
    """The faces of one part and one material, with vertices of their own."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    extras, split = mesh.extras, mesh.split
    mine = np.zeros(len(mesh.polygons), dtype=bool)
    mine[faces] = True
    corner = np.flatnonzero(mine[mesh.polygons.owner])
    with_normals = extras.normals is not None and extras.normal is not None
    indices = [mesh.polygons.corners[corner], mesh.texture[corner]]
    if with_normals and extras.normal is not None:
        indices.append(extras.normal[corner])
    made = one_index(*indices)
    attributes = {
        "POSITION": buffer.add(single(mesh.V[made.rows[0]], "V"), VERTEX_ATTRIBUTES, bounds=True),
        "TEXCOORD_0": buffer.add(single(mesh.TC[made.rows[1]] * [1, -1] + [0, 1], "TC"), VERTEX_ATTRIBUTES),
    }
    if with_normals and extras.normals is not None:
        normals = single(_unit(extras.normals[made.rows[2]]), "normals")
        attributes["NORMAL"] = buffer.add(normals, VERTEX_ATTRIBUTES)
    if extras.colours is not None:
        given = extras.colours[made.rows[0]]
        colours = single(np.column_stack((linear(given[:, :3]), given[:, 3:])), "colours")
        attributes["COLOR_0"] = buffer.add(colours, VERTEX_ATTRIBUTES)
    vertex = np.full(len(mesh.polygons.corners), -1)
    vertex[corner] = made.corners
    whole = bool(mine.all())
    own = split if whole else split.rows(np.flatnonzero(mine[split.face]))
    triangles, extension = triangles_of(own, vertex)
    made_of = buffer.add(triangles.astype("<u4").ravel(), INDICES)
    return {"attributes": attributes, "indices": made_of, "material": material, **extension}


def triangles_of(split: Triangles, vertex: IntArray) -> tuple[IntArray, dict[str, Any]]:
    """Triangles in an order that keeps polygons, and the mark that it does, if there are any."""
    if (split.polygons.sizes[split.face] == 3).all():
        return vertex[split.place], {}
    return fans(split, vertex), {"extensions": {EXTENSION: {}}}


def _unit(normals: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.where(length > 0, normals / np.where(length > 0, length, 1), [0, 0, 1]))


def with_texture(description: dict[str, Any], parts: list[bytes], image: bytes) -> None:
    """Add a PNG that becomes the colour of all materials; colours at vertices are left out."""
    size = description["buffers"][0]["byteLength"]
    description["bufferViews"].append({"buffer": 0, "byteOffset": size, "byteLength": len(image)})
    parts.append(image + b"\0" * (-len(image) % 4))
    description["buffers"][0]["byteLength"] = size + len(parts[-1])
    description["images"] = [{"bufferView": len(description["bufferViews"]) - 1, "mimeType": "image/png"}]
    description["samplers"] = [{"magFilter": LINEAR, "minFilter": LINEAR_MIPMAPS}]
    description["textures"] = [{"source": 0, "sampler": 0}]
    for material in description["materials"]:
        without_images(material)
        shading = material.get("pbrMetallicRoughness", {})
        shading.pop("baseColorFactor", None)  # the image would be multiplied by it
        material["pbrMetallicRoughness"] = {**shading, "metallicFactor": 0, "baseColorTexture": {"index": 0}}
    for mesh in description["meshes"]:
        for primitive in mesh["primitives"]:
            primitive["attributes"].pop("COLOR_0", None)  # viewers would multiply by it


def write_gltf(path: str, description: dict[str, Any], parts: list[bytes], image: bytes | None) -> None:
    """The container: a text that describes, and the bytes that it describes."""
    if image is not None:
        with_texture(description, parts, image)
    if path.lower().endswith(".gltf"):
        data = base64.b64encode(b"".join(parts)).decode()
        description["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{data}"
        with open(path, "w", encoding="utf-8") as file:
            json.dump(description, file, separators=(",", ":"))
        return
    text = json.dumps(description, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    length = sum(map(len, parts))
    padding = b"\0" * (-length % 4)
    size = 12 + 8 + len(text) + 8 + length + len(padding)
    if size >= 2**32:
        raise MeshError(f"a GLB file has at most 4 GB, and this mesh needs {size} bytes: write OBJ or PLY")
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, size))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", length + len(padding), b"BIN\0"))
        file.writelines([*parts, padding])
