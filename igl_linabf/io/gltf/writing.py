"""Write glTF 2.0: GLB, its binary form, or .gltf, one text that holds the buffer, too."""

import base64
import json
import struct
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._types import IntArray
from ...errors import MeshError
from ..colours import given_colours
from ..materials import Material, as_gltf, linear
from ..mesh_file import MeshFile
from ..parsing import as_bytes
from ..vertex_splits import origin_of, single_precision, split_vertices
from .ngons import EXTENSION, fans
from .scene import DTYPES, Component, Target
from .textures import with_images

KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
METRES = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048}
KEPT = ("componentType", "normalized", "type", "name", "extensions", "extras")  # of an accessor


class Buffer:
    """The binary part of a file while it grows, and the description of what is in it."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.size = 0
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def put(self, data: bytes, **more: Any) -> int:
        """Bytes; returns the number of their view."""
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": len(data), **more})
        self.parts.append(data + b"\0" * (-len(data) % 4))
        self.size += len(self.parts[-1])
        return len(self.views) - 1

    def add(
        self,
        rows: NDArray[Any],
        use: Target = Target.VERTEX_ATTRIBUTES,
        like: Mapping[str, Any] | None = None,
    ) -> int:
        """An array of 32-bit numbers, or of those of another accessor; returns the number of its own."""
        if like is None:
            kind = Component.FLOAT if rows.dtype.kind == "f" else Component.UNSIGNED_INT
            like = {"componentType": kind, "type": KINDS[1 if rows.ndim == 1 else rows.shape[1]]}
        accessor = {**{key: like[key] for key in KEPT if key in like}, "count": len(rows)}
        data = np.ascontiguousarray(rows, DTYPES[accessor["componentType"]])
        said = {"target": use}
        width = data.itemsize * (data.shape[1] if data.ndim > 1 else 1)
        if use == Target.VERTEX_ATTRIBUTES and width % 4:  # rows begin at multiples of four bytes
            data = np.pad(data.view(np.uint8).reshape(len(data), -1), ((0, 0), (0, -width % 4)))
            said["byteStride"] = data.shape[1]
        accessor["bufferView"] = self.put(data.tobytes(), **said)
        if accessor["type"] == KINDS[3]:  # asked for of positions, as they are stored
            accessor |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self.accessors.append(accessor)
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
        origin = origin_of(mesh.V[mesh.polygons.corners[(part == i)[mesh.polygons.owner]]])
        near = replace(mesh, V=mesh.V - origin)
        primitives = [
            _primitive(
                near, np.flatnonzero((part == i) & (material == k)), k if k >= 0 else len(words), buffer
            )
            for k in np.unique(material[part == i]).tolist()
        ]
        named = {"name": names[i]} if i >= 0 else {}
        moved = {"translation": (metres * origin).tolist()} if origin.any() else {}
        nodes.append({"mesh": len(meshes), **named, **moved, **size})
        meshes.append({"primitives": primitives, **named})
    # readers (trimesh) drop texture coordinates that no material goes with
    looks = extras.looks or (Material(),) * len(words)
    materials = [as_gltf(look, name) for look, name in zip(looks, words, strict=True)]
    materials += [as_gltf(Material())] * bool((material < 0).any())
    polygons = any("extensions" in primitive for of in meshes for primitive in of["primitives"])
    description = {
        "asset": {"version": "2.0", "generator": "igl_linabf", **_comments(mesh)},
        **({"extensionsUsed": [EXTENSION]} if polygons else {}),
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
    }
    if mesh.images is not None:
        pages = {i: look.page for i, look in enumerate(looks)}
        with_images(description, buffer.put, mesh.images, pages, looks)
    write_gltf(temporary, description, buffer)


def _comments(mesh: MeshFile) -> dict[str, Any]:
    """What the file says to people, where glTF has room for it."""
    lines = [as_bytes(line).decode("utf-8", "backslashreplace") for line in mesh.extras.comments]
    return {"extras": {"comments": lines}} if lines else {}


def _primitive(mesh: MeshFile, faces: IntArray, material: int, buffer: Buffer) -> dict[str, Any]:
    """The faces of one part and one material, with vertices of their own."""
    corner = np.flatnonzero(np.isin(mesh.polygons.owner, faces))
    made = split_vertices(mesh, corner, normals=True, colours=given_colours(mesh))
    attributes = {
        "POSITION": buffer.add(single_precision(mesh.V[made.vertex], "V")),
        **{
            f"TEXCOORD_{i}": buffer.add(single_precision(TC * [1, -1] + [0, 1], "TC"))
            for i, TC in enumerate((made.TC,) if made.first is None else (made.first, made.TC))
        },
    }
    if made.normals is not None:
        attributes["NORMAL"] = buffer.add(single_precision(_unit(made.normals), "normals"))
    if made.colours is not None:
        given = made.colours
        colours = single_precision(np.column_stack((linear(given[:, :3]), given[:, 3:])), "colours")
        attributes["COLOR_0"] = buffer.add(colours)
    triangles, extensions = triangles_of(mesh, faces, corner, made.corners)
    indices = buffer.add(triangles.ravel(), Target.INDICES)
    return {"attributes": attributes, "indices": indices, "material": material, **extensions}


def triangles_of(
    mesh: MeshFile, faces: IntArray, corner: IntArray, vertex: IntArray, mirrored: bool = False
) -> tuple[IntArray, dict[str, Any]]:
    """Triangles of faces, with a vertex at each corner, in an order that keeps polygons; whether it does.

    With `mirrored` the other way round.
    """
    if (mesh.polygons.sizes[faces] == 3).all():
        return vertex.reshape(-1, 3)[:, [0, 2, 1] if mirrored else slice(None)], {}
    at = np.full(len(mesh.polygons.corners), -1)
    at[corner] = vertex
    own = mesh.split.rows(np.flatnonzero(np.isin(mesh.split.face, faces)))
    made = fans(own, at)
    if mirrored:  # a fan runs the other way round, too
        made = made[np.lexsort((-np.arange(len(made)), own.face))][:, [0, 2, 1]]
    return made, {"extensions": {EXTENSION: {}}}


def _unit(normals: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.where(length > 0, normals / np.where(length > 0, length, 1), [0, 0, 1]))


def write_gltf(path: str, description: dict[str, Any], buffer: Buffer) -> None:
    """The container: a text that describes, and the bytes that it describes."""
    description |= {"accessors": buffer.accessors, "bufferViews": buffer.views}
    description["buffers"] = [{"byteLength": buffer.size}]
    if path.lower().endswith(".gltf"):
        data = base64.b64encode(b"".join(buffer.parts)).decode()
        description["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{data}"
        with open(path, "w", encoding="utf-8") as file:
            json.dump(description, file, separators=(",", ":"))
        return
    text = json.dumps(description, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + buffer.size
    if size >= 2**32:
        raise MeshError(f"a GLB file has at most 4 GB, and this mesh needs {size} bytes: write OBJ or PLY")
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, size))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", buffer.size, b"BIN\0"))
        file.writelines(buffer.parts)
