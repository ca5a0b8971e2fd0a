"""Read the container of glTF 2.0, text or binary: the JSON description and the arrays that it describes.

The description stays JSON, because libraries such as pygltflib discard unknown contents.
"""

import base64
import binascii
import json
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from ..._types import FloatArray
from ..parsing import Damaged
from .extensions import COMPRESSION_EXTENSIONS, INSTANCES, refuse_compressed, refuse_required


class Component(IntEnum):
    """glTF's codes for the component types of accessors."""

    BYTE = 5120
    UNSIGNED_BYTE = 5121
    SHORT = 5122
    UNSIGNED_SHORT = 5123
    UNSIGNED_INT = 5125
    FLOAT = 5126


class Mode(IntEnum):
    """glTF's codes for primitives of triangles."""

    TRIANGLES = 4
    TRIANGLE_STRIP = 5
    TRIANGLE_FAN = 6


class Target(IntEnum):
    """glTF's codes for the use of a buffer view."""

    VERTEX_ATTRIBUTES = 34962
    INDICES = 34963


class Filter(IntEnum):
    """glTF's codes for texture filters."""

    LINEAR = 9729
    LINEAR_MIPMAP_LINEAR = 9987


DTYPES = {
    Component.BYTE: "<i1",
    Component.UNSIGNED_BYTE: "<u1",
    Component.SHORT: "<i2",
    Component.UNSIGNED_SHORT: "<u2",
    Component.UNSIGNED_INT: "<u4",
    Component.FLOAT: "<f4",
}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


class Placement(NamedTuple):
    """The node that places a mesh in the scene.

    Attributes
    ----------
    name : str
        The name of the node.
    matrix : (4, 4) float64
    times : int
        The number of instances of the mesh.
    """

    name: str
    matrix: FloatArray
    times: int = 1


@dataclass(frozen=True, eq=False)
class Gltf:
    """A glTF file.

    Attributes
    ----------
    text : dict
        The JSON description.
    buffers : list of bytes
    folder : Path
        The folder for relative references.
    """

    text: dict[str, Any]
    buffers: list[bytes]
    folder: Path

    def entries(self, name: str) -> list[dict[str, Any]]:
        """Return all entries of a kind, such as "nodes"; an empty list if there are none."""
        return list(self.text.get(name, ()))

    def view(self, number: int) -> bytes:
        """Return the bytes of a buffer view."""
        view = self._entry("bufferViews", number)
        for name in COMPRESSION_EXTENSIONS & set(view.get("extensions", {})):
            extension = self._entry("buffers", view["buffer"]).get("extensions", {}).get(name, {})
            if extension.get("fallback"):  # the uncompressed buffer is empty
                refuse_compressed(f"its buffer view {number}", name)
        start, length = int(view.get("byteOffset", 0)), int(view["byteLength"])
        buffer = self.buffers[int(view["buffer"])]
        if start < 0 or length < 0 or start + length > len(buffer):
            raise Damaged(f"its buffer view {number} ends after the {len(buffer)} bytes of its buffer")
        return buffer[start : start + length]

    def array(self, number: int) -> NDArray[Any]:
        """Return the rows of an accessor, (n,) or (n, width), as stored."""
        accessor = self._entry("accessors", number)
        if accessor.get("componentType") not in DTYPES or accessor.get("type") not in WIDTHS:
            raise Damaged(f"its accessor {number} has an unknown type")
        kind, width = np.dtype(DTYPES[accessor["componentType"]]), WIDTHS[accessor["type"]]
        n = accessor["count"]
        if not 0 <= n < 2**32:
            raise Damaged(f"its accessor {number} has {n} rows")
        if "bufferView" in accessor:
            stride = self._entry("bufferViews", accessor["bufferView"]).get("byteStride")
            rows = self._rows(accessor, kind, width, n, stride)
        else:
            if n > 10**8:
                raise Damaged(f"its accessor {number} has {n} rows and no data")
            rows = np.zeros((n, width), kind)
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            m, indices = int(sparse["count"]), sparse["indices"]
            where = self._rows(indices, np.dtype(DTYPES[indices["componentType"]]), 1, m, None)
            if m and int(where.max()) >= n:
                raise Damaged(f"its accessor {number} changes rows that it does not have")
            rows = rows.copy()
            rows[where[:, 0]] = self._rows(sparse["values"], kind, width, m, None)
        return rows[:, 0] if width == 1 else rows

    def numbers(self, number: int) -> FloatArray:
        """Return the rows of an accessor as floating-point numbers; normalised integers become fractions."""
        rows = self.array(number)
        values = rows.astype(np.float64)
        if self._entry("accessors", number).get("normalized") and rows.dtype.kind != "f":
            values = np.maximum(values / np.iinfo(rows.dtype).max, -1.0)
        return np.asarray(values)

    def _rows(
        self, entry: dict[str, Any], kind: np.dtype[Any], width: int, n: int, stride: int | None
    ) -> NDArray[Any]:
        data, start = self.view(entry["bufferView"]), int(entry.get("byteOffset", 0))
        step = stride or kind.itemsize * width
        if n and (start < 0 or step < 1 or start + (n - 1) * step + kind.itemsize * width > len(data)):
            raise Damaged(f"its buffer view {entry['bufferView']} is too short for {n} rows")
        return np.ndarray((n, width), kind, data if n else b"", start if n else 0, (step, kind.itemsize))

    def _entry(self, name: str, number: int) -> dict[str, Any]:
        entries = self.text.get(name, ())
        if not 0 <= number < len(entries):
            raise Damaged(f"it has no entry {number} among its {len(entries)} {name}")
        return dict(entries[number])

    def primitives(self) -> Iterator[tuple[int, int, dict[str, Any]]]:
        """Yield the primitives of triangles: mesh, number within the mesh, and description."""
        for i, mesh in enumerate(self.entries("meshes")):
            for j, primitive in enumerate(mesh.get("primitives", ())):
                of_triangles = primitive.get("mode", Mode.TRIANGLES) in list(Mode)
                if of_triangles and "POSITION" in primitive.get("attributes", {}):
                    for name in COMPRESSION_EXTENSIONS & set(primitive.get("extensions", {})):
                        refuse_compressed(f"its mesh {i}", name)
                    yield i, j, primitive


def load_gltf(path: Path) -> Gltf:
    """Read the container, and the buffers stored in other files."""
    data = path.read_bytes()
    blob = b""
    if data[:4] == b"glTF":
        data, blob = _split_chunks(data)
    try:
        text = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise Damaged(f"its description is not valid JSON ({error})") from None
    version = str(text.get("asset", {}).get("version", "")) if isinstance(text, dict) else ""
    if version.split(".")[0] != "2":
        named = f"of version {version}" if version else "without a version"
        raise Damaged(f"it is a glTF {named}: write it as glTF 2.0, for example from Blender")
    refuse_required(text)
    buffers = []
    for i, buffer in enumerate(text.get("buffers", ())):
        uri = buffer.get("uri")
        inside = blob if i == 0 else b""  # only the first buffer is in the container
        buffers.append(inside if uri is None else _read_resource(uri, path, i))
    return Gltf(text, buffers, path.parent)


def _split_chunks(data: bytes) -> tuple[bytes, bytes]:
    """Return the JSON chunk and the binary chunk of a GLB file."""
    start, declared, chunks = 12, int.from_bytes(data[8:12], "little"), dict[bytes, bytes]()
    if declared > len(data):
        raise Damaged(f"its header declares {declared} bytes, but it has {len(data)}")
    while start + 8 <= len(data):
        length, kind = int.from_bytes(data[start : start + 4], "little"), data[start + 4 : start + 8]
        if start + 8 + length > len(data):
            raise Damaged(f"its chunk at byte {start} is cut off")
        chunks.setdefault(kind, data[start + 8 : start + 8 + length])
        start += 8 + length
    if b"JSON" not in chunks:
        raise Damaged("it has no chunk of JSON at byte 12")
    return chunks[b"JSON"], chunks.get(b"BIN\0", b"")


def _read_resource(uri: str, path: Path, number: int) -> bytes:
    if uri.startswith("data:"):
        try:
            return base64.b64decode(uri.partition(",")[2], validate=True)
        except binascii.Error:
            raise Damaged(f"its buffer {number} is not valid base64") from None
    file = path.parent / unquote(uri)
    if not file.is_file():
        raise Damaged(f"its buffer {number} is in a file that is missing, {uri}")
    return file.read_bytes()


def find_placements(gltf: Gltf) -> dict[int, Placement]:
    """Return the placement of each mesh by its largest instance, or by the first one of equal size."""
    nodes, placements_of_mesh = gltf.entries("nodes"), dict[int, list[Placement]]()
    scenes = gltf.entries("scenes")
    scene = gltf.text.get("scene", 0)
    roots = scenes[scene].get("nodes", ()) if 0 <= scene < len(scenes) else ()
    children = {child for node in nodes for child in node.get("children", ())}
    stack = [(i, np.eye(4)) for i in (*roots, *(i for i in range(len(nodes)) if i not in children))][::-1]
    seen = set[int]()
    while stack:
        i, parent = stack.pop()
        if i in seen or not 0 <= i < len(nodes):
            continue
        seen.add(i)
        matrix = parent @ _make_transform(nodes[i])
        if "mesh" in nodes[i]:
            mesh_placements, name = (
                placements_of_mesh.setdefault(int(nodes[i]["mesh"]), []),
                str(nodes[i].get("name", "")),
            )
            mesh_placements += [
                Placement(name, matrix @ each) for each in _find_instance_transforms(gltf, nodes[i])
            ]
        stack += [(child, matrix) for child in nodes[i].get("children", ())][::-1]
    return {mesh: _largest_placement(mesh_placements) for mesh, mesh_placements in placements_of_mesh.items()}


def _largest_placement(candidates: list[Placement]) -> Placement:
    """Return the largest of a mesh's placements; if all have size zero, use the mesh's own size."""
    areas = [_area_scale(placement.matrix) for placement in candidates]
    largest = candidates[int(np.argmax(areas))]._replace(times=len(candidates))
    if max(areas) > 0:
        return largest
    matrix = np.eye(4)
    matrix[:3, 3] = largest.matrix[:3, 3]
    return largest._replace(matrix=matrix)


def _area_scale(matrix: FloatArray) -> float:
    """Return the factor by which a transform (4, 4) scales areas, a norm of its factors for three planes."""
    a, b, c = matrix[:3, :3].T
    with np.errstate(all="ignore"):
        return float(np.nan_to_num(np.linalg.norm([np.cross(a, b), np.cross(b, c), np.cross(c, a)])))


def _find_instance_transforms(gltf: Gltf, node: dict[str, Any]) -> list[FloatArray]:
    """Return the transforms of a node's instances, or the identity."""
    attributes = node.get("extensions", {}).get(INSTANCES, {}).get("attributes", {})
    keys = {"TRANSLATION": "translation", "ROTATION": "rotation", "SCALE": "scale"}
    rows = {key: gltf.numbers(attributes[name]) for name, key in keys.items() if name in attributes}
    count = min(map(len, rows.values()), default=0)
    return [_make_transform({key: rows[key][i] for key in rows}) for i in range(count)] or [np.eye(4)]


def _make_transform(node: dict[str, Any]) -> FloatArray:
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, :3] *= np.array(node.get("scale", (1.0, 1.0, 1.0)), dtype=float)
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix
