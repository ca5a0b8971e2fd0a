"""Write new glTF 2.0 files: binary GLB, or a .gltf text file with an embedded buffer."""

import base64
import json
import struct
import warnings
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._types import BoolArray, FloatArray, IntArray
from ...errors import MeshError, MeshWarning, stack_level
from ..colours import get_stored_colours
from ..materials import Material, decode_srgb, make_gltf_material
from ..mesh_file import MeshFile
from ..parsing import encode_utf8
from ..vertex_splits import choose_origin, round_to_single, split_vertices, to_single_precision, warn_of_error
from .ngons import EXTENSION, order_as_fans
from .scene import DTYPES, Component, Target
from .textures import add_images

ACCESSOR_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
MAX_PRIMITIVES = 256  # with more primitives, materials that look the same are merged
METRES_PER_UNIT = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048}
KEPT_ACCESSOR_KEYS = (
    "componentType",
    "normalized",
    "type",
    "name",
    "extensions",
    "extras",
)  # keys that a rewritten accessor copies from the original accessor


class Buffer:
    """A growing binary buffer with its buffer views and accessors."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.size = 0
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def append_bytes(self, data: bytes, **properties: Any) -> int:
        """Append bytes, and return the number of their buffer view."""
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": len(data), **properties})
        self.parts.append(data + b"\0" * (-len(data) % 4))
        self.size += len(self.parts[-1])
        return len(self.views) - 1

    def append_array(
        self,
        rows: NDArray[Any],
        use: Target = Target.VERTEX_ATTRIBUTES,
        like: Mapping[str, Any] | None = None,
    ) -> int:
        """Append an array, and return the number of its accessor.

        The component type and other properties are copied from the accessor `like`. Without `like`, the array
        is stored as 32-bit numbers.
        """
        if like is None:
            kind = Component.FLOAT if rows.dtype.kind == "f" else Component.UNSIGNED_INT
            like = {"componentType": kind, "type": ACCESSOR_TYPES[1 if rows.ndim == 1 else rows.shape[1]]}
        accessor = {**{key: like[key] for key in KEPT_ACCESSOR_KEYS if key in like}, "count": len(rows)}
        data = np.ascontiguousarray(rows, DTYPES[accessor["componentType"]])
        view_properties = {"target": use}
        width = data.itemsize * (data.shape[1] if data.ndim > 1 else 1)
        if use == Target.VERTEX_ATTRIBUTES and width % 4:  # glTF aligns rows to four bytes
            data = np.pad(data.view(np.uint8).reshape(len(data), -1), ((0, 0), (0, -width % 4)))
            view_properties["byteStride"] = data.shape[1]
        accessor["bufferView"] = self.append_bytes(data.tobytes(), **view_properties)
        if accessor["type"] == ACCESSOR_TYPES[3] and np.isfinite(rows).all():  # required for positions
            accessor |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def save_new_gltf(temporary: str, mesh: MeshFile) -> None:
    """Write polygons with a node for each part and texture coordinates at the vertices, v downwards.

    Faces without texture coordinates have primitives of their own.
    """
    extras, buffer = mesh.extras, Buffer()
    bare, mesh = mesh.lacks_texture, mesh.fill_missing_texture()
    names, part = extras.parts or ((), np.full(len(mesh.polygons), -1))
    material_names, material, looks = _collect_materials(mesh, part)
    meshes: list[dict[str, Any]] = []
    nodes: list[dict[str, Any]] = []
    metres = METRES_PER_UNIT.get(extras.units or "meter", 1.0)
    size = {} if metres == 1 else {"scale": [metres] * 3}
    colours, error = get_stored_colours(mesh), 0.0
    for i, by_material in _group_faces(part, material, bare):
        faces = np.concatenate(list(by_material.values()))
        positions = mesh.V[mesh.polygons.corners[mesh.polygons.select_corners(faces)]]
        origin, extent, primitives = choose_origin(positions), np.ptp(positions, axis=0).max(), []
        for (k, is_bare), chosen in by_material.items():
            primitive, rounding = _write_primitive(mesh, chosen, origin, colours, buffer, is_bare)
            primitives.append({**primitive, "material": k if k >= 0 else len(material_names)})
            error = max(error, rounding / extent if extent > 0 else 0.0)
        name_entry = {"name": names[i]} if i >= 0 else {}
        translation = {"translation": (metres * origin).tolist()} if origin.any() else {}
        nodes.append({"mesh": len(meshes), **name_entry, **translation, **size})
        meshes.append({"primitives": primitives, **name_entry})
    warn_of_error(error, "V")
    for map_ in (mesh.TC, None if mesh.first is None else mesh.first[0]):
        if map_ is not None:
            to_single_precision(map_, "TC")  # only to warn about rounding; the result is not used
    # give faces without a material a plain one: readers such as trimesh would discard texture coordinates
    materials = [make_gltf_material(look, name) for look, name in zip(looks, material_names, strict=True)]
    materials += [make_gltf_material(Material())] * bool((material < 0).any())
    polygons = any(
        "extensions" in primitive for mesh_entry in meshes for primitive in mesh_entry["primitives"]
    )
    description = {
        "asset": {"version": "2.0", "generator": "igl_linabf", **_make_asset_extras(mesh)},
        **({"extensionsUsed": [EXTENSION]} if polygons else {}),
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
    }
    if mesh.images is not None:
        pages = {i: look.page for i, look in enumerate(looks)}
        add_images(description, buffer.append_bytes, mesh.images, pages, looks)
    write_gltf(temporary, description, buffer)


def _collect_materials(mesh: MeshFile, part: IntArray) -> tuple[Sequence[str], IntArray, Sequence[Material]]:
    """Return the names of the materials to write, the material of each face, and the materials.

    Materials that look the same are merged if there are more than MAX_PRIMITIVES primitives.
    """
    names, material = mesh.extras.materials or ((), np.full(len(mesh.polygons), -1))
    looks = mesh.extras.looks or (Material(),) * len(names)
    count = len(np.unique(np.column_stack((part, material)), axis=0))
    if mesh.extras.looks is None or count <= MAX_PRIMITIVES:
        return names, material, looks
    first: dict[tuple[Any, ...], int] = {}
    shared = np.array([first.setdefault(_describe_look(look), i) for i, look in enumerate(looks)])
    kept = np.unique(shared)
    if len(kept) < len(names):
        warnings.warn(
            f"its {len(names)} materials have {len(kept)} different appearances: GLB and glTF take one "
            "primitive for each material of a part, so materials that look the same are written as one, with "
            "the name of the first",
            MeshWarning,
            stacklevel=stack_level(),
        )
    number = np.append(np.searchsorted(kept, shared), -1)
    return [names[i] for i in kept], number[material], [looks[i] for i in kept]


def _describe_look(look: Material) -> tuple[Any, ...]:
    """Return a key that is equal for materials with the same appearance."""
    images = tuple((map_.kind, map_.wrap, map_.matrix, map_.options, map_.nearest) for map_ in look.maps)
    scalars = look.colour, look.alpha, look.metallic, look.roughness, look.emission, look.factor, look.page
    return (*scalars, look.lines, images)


def _make_asset_extras(mesh: MeshFile) -> dict[str, Any]:
    """Return the comments of the mesh as the "extras" of the glTF asset."""
    lines = [encode_utf8(line).decode("utf-8", "backslashreplace") for line in mesh.extras.comments]
    return {"extras": {"comments": lines}} if lines else {}


def _group_faces(
    part: IntArray, material: IntArray, bare: BoolArray
) -> Iterator[tuple[int, dict[tuple[int, bool], IntArray]]]:
    """Yield each part, and a dict from (material, `bare`) to its faces in ascending order."""
    keys = np.column_stack((part, material, bare))
    order = np.lexsort((bare, material, part))
    start = np.flatnonzero((keys[order[1:]] != keys[order[:-1]]).any(axis=1)) + 1
    groups = np.split(order, start)
    for i, same_part in groupby(groups, key=lambda faces: int(part[faces[0]])):
        yield i, {(int(material[faces[0]]), bool(bare[faces[0]])): faces for faces in same_part}


def _write_primitive(
    mesh: MeshFile,
    faces: IntArray,
    origin: FloatArray,
    colours: FloatArray | None,
    buffer: Buffer,
    is_bare: bool,
) -> tuple[dict[str, Any], float]:
    """Append the faces of one part and one material; return the primitive and the largest rounding error.

    Positions are written relative to `origin`, and `colours` are the colours at all corners of the mesh. If
    `is_bare`, the texture coordinates are left out.
    """
    split = split_vertices(mesh, mesh.polygons.select_corners(faces), normals=True, colours=colours)
    V = mesh.V[split.vertex] - origin
    positions = round_to_single(V, "V")
    maps = [TC for TC in (split.first, None if is_bare else split.TC) if TC is not None]
    attributes = {
        "POSITION": buffer.append_array(positions),
        **{
            f"TEXCOORD_{i}": buffer.append_array(round_to_single(TC * [1, -1] + [0, 1], "TC"))
            for i, TC in enumerate(maps)
        },
    }
    if split.normals is not None:
        attributes["NORMAL"] = buffer.append_array(
            round_to_single(_normalise_vectors(split.normals), "normals")
        )
    if split.colours is not None:
        light = np.column_stack((decode_srgb(split.colours[:, :3]), split.colours[:, 3:]))
        attributes["COLOR_0"] = buffer.append_array(round_to_single(light, "colours"))
    triangles, extensions = order_triangles(mesh, faces, split.corners)
    indices = buffer.append_array(triangles.ravel(), Target.INDICES)
    return {"attributes": attributes, "indices": indices, **extensions}, float(np.abs(V - positions).max())


def order_triangles(
    mesh: MeshFile, faces: IntArray, vertex: IntArray, mirrored: bool = False
) -> tuple[IntArray, dict[str, Any]]:
    """Return the triangles of faces, ordered to encode polygons, and the extension that declares this.

    `faces` are ascending, and `vertex` has the vertex at each corner of these faces. With `mirrored`, the
    orientation is reversed.
    """
    if (mesh.polygons.sizes[faces] == 3).all():
        return vertex.reshape(-1, 3)[:, [0, 2, 1] if mirrored else slice(None)], {}
    triangles = mesh.triangulation.select_polygons(faces)
    ordered = order_as_fans(triangles, vertex)
    if mirrored:  # a mirrored fan also has its triangles in reverse order
        ordered = ordered[np.lexsort((-np.arange(len(ordered)), triangles.face))][:, [0, 2, 1]]
    return ordered, {"extensions": {EXTENSION: {}}}


def _normalise_vectors(normals: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.where(length > 0, normals / np.where(length > 0, length, 1), [0, 0, 1]))


def write_gltf(path: str, description: dict[str, Any], buffer: Buffer) -> None:
    """Write the JSON description and the buffer to a GLB or glTF file."""
    description |= {"accessors": buffer.accessors, "bufferViews": buffer.views}
    description["buffers"] = [{"byteLength": buffer.size}]
    if path.lower().endswith(".gltf"):
        data = base64.b64encode(b"".join(buffer.parts)).decode()
        description["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{data}"
        with open(path, "w", encoding="utf-8") as file:
            json.dump(description, file, separators=(",", ":"), allow_nan=False)
        return
    text = json.dumps(description, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + buffer.size
    if size >= 2**32:
        raise MeshError(f"a GLB file has at most 4 GB, and this mesh needs {size} bytes: write OBJ or PLY")
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, size))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", buffer.size, b"BIN\0"))
        file.writelines(buffer.parts)
