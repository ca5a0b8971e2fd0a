"""Access the arrays and nodes of a glTF description that `validation` has checked."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..._types import FloatArray, IntArray
from ...errors import format_count
from ..parsing import Damaged
from ..references import Folder
from .extensions import INSTANCES


class Component(IntEnum):
    """glTF's codes for the component types of accessors."""

    BYTE = 5120
    UNSIGNED_BYTE = 5121
    SHORT = 5122
    UNSIGNED_SHORT = 5123
    UNSIGNED_INT = 5125
    FLOAT = 5126


class Mode(IntEnum):
    """glTF's codes for primitives that consist of triangles."""

    TRIANGLES = 4
    TRIANGLE_STRIP = 5
    TRIANGLE_FAN = 6


class Target(IntEnum):
    """glTF's codes for the use of a buffer view."""

    VERTEX_ATTRIBUTES = 34962
    INDICES = 34963


class Filter(IntEnum):
    """glTF's codes for texture filters."""

    NEAREST = 9728
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
INSTANCE_ATTRIBUTES = {"TRANSLATION": "VEC3", "ROTATION": "VEC4", "SCALE": "VEC3"}
UNSIGNED = (Component.UNSIGNED_BYTE, Component.UNSIGNED_SHORT, Component.UNSIGNED_INT)  # for indices
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


class Placement(NamedTuple):
    """A node that places a mesh in the scene.

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
    """The description and the buffers of a glTF file.

    Attributes
    ----------
    text : dict
        The JSON description.
    buffers : list of bytes
    folder : Folder
        The folder for relative references.
    description_size : int
        The number of bytes of the file itself.
    compression : tuple of str
        The extensions by which the data were compressed in the file.
    """

    text: dict[str, Any]
    buffers: list[bytes]
    folder: Folder
    description_size: int
    compression: tuple[str, ...] = ()
    _dense: dict[int, NDArray[Any]] = field(default_factory=dict)

    def get_entries(self, name: str) -> list[dict[str, Any]]:
        """Return all entries of a kind, such as "nodes"; an empty list if there are none."""
        return list(self.text.get(name, ()))

    @property
    def total_bytes(self) -> int:
        """The number of bytes of the file and its buffers; buffers that share a file count once."""
        return self.description_size + sum({id(buffer): len(buffer) for buffer in self.buffers}.values())

    def read_view(self, number: int) -> bytes:
        """Return the bytes of a buffer view."""
        return bytes(self._get_view_memory(number))

    def check_view(self, number: int) -> None:
        """Raise `Damaged` if a buffer view ends after its buffer."""
        self._get_view_memory(number)

    def check_rows(self, number: int) -> None:
        """Raise `Damaged` if the buffer view of an accessor is too short for its rows."""
        accessor = self.text["accessors"][number]
        if "bufferView" in accessor:
            self._read_stored_rows(accessor, accessor, accessor["count"])
        if "sparse" in accessor:
            self._read_sparse_rows(number)

    def row_bytes(self, number: int) -> int:
        """Return the number of bytes of a row of an accessor."""
        kind, width = self._get_row_type(self.text["accessors"][number])
        return kind.itemsize * width

    def read_array(self, number: int, rows: IntArray | slice = slice(None)) -> NDArray[Any]:
        """Return rows of an accessor, (n,) or (n, width), as stored; by default all rows."""
        accessor = self.text["accessors"][number]
        if "bufferView" in accessor:
            values = self._read_stored_rows(accessor, accessor, accessor["count"])
        else:
            kind, width = self._get_row_type(accessor)
            values = np.broadcast_to(np.zeros(1, kind), (accessor["count"], width))
        if "sparse" in accessor:
            if number not in self._dense:
                self._dense[number] = values.copy()
                where, new = self._read_sparse_rows(number)
                self._dense[number][where] = new
            values = self._dense[number]
        values = values[rows]
        return values[:, 0] if values.shape[1] == 1 else values

    def read_numbers(self, number: int, rows: IntArray | slice = slice(None)) -> FloatArray:
        """Return rows of an accessor as floating-point numbers; normalised integers become fractions."""
        stored = self.read_array(number, rows)
        values = stored.astype(np.float64)
        if self.text["accessors"][number].get("normalized") and stored.dtype.kind != "f":
            values = np.maximum(values / np.iinfo(stored.dtype).max, -1.0)
        return np.asarray(values)

    def count_rows(self, number: int) -> int:
        """Return the number of rows of an accessor."""
        return int(self.text["accessors"][number]["count"])

    def _get_view_memory(self, number: int) -> memoryview:
        view = self.text["bufferViews"][number]
        start, length = view.get("byteOffset", 0), view["byteLength"]
        buffer = memoryview(self.buffers[view["buffer"]])
        if start + length > len(buffer):
            raise Damaged(f"its buffer view {number} ends after the {len(buffer)} bytes of its buffer")
        return buffer[start : start + length]

    def _get_row_type(self, accessor: dict[str, Any]) -> tuple[np.dtype[Any], int]:
        return np.dtype(DTYPES[accessor["componentType"]]), WIDTHS[accessor["type"]]

    def _read_stored_rows(self, entry: dict[str, Any], accessor: dict[str, Any], n: int) -> NDArray[Any]:
        """Return `n` rows of the type of `accessor`, from the buffer view and byte offset of `entry`."""
        kind, width = self._get_row_type(accessor)
        number, start = entry["bufferView"], entry.get("byteOffset", 0)
        data, size = self._get_view_memory(number), kind.itemsize * width
        step = self.text["bufferViews"][number].get("byteStride", size) if entry is accessor else size
        if n and (step < size or start + (n - 1) * step + size > len(data)):
            raise Damaged(
                f"its buffer view {number} is too short for {format_count(n, 'row')} of {size} bytes"
            )
        return np.ndarray((n, width), kind, data if n else b"", start if n else 0, (step, kind.itemsize))

    def _read_sparse_rows(self, number: int) -> tuple[IntArray, NDArray[Any]]:
        """Return the row numbers that a sparse accessor replaces, and the new values."""
        accessor = self.text["accessors"][number]
        sparse = accessor["sparse"]
        index = {**sparse["indices"], "type": "SCALAR"}
        where = self._read_stored_rows(index, index, sparse["count"])[:, 0].astype(np.int64)
        if len(where) and int(where.max()) >= accessor["count"]:
            raise Damaged(f"its accessor {number} changes rows that it does not have")
        return where, self._read_stored_rows(sparse["values"], accessor, sparse["count"])

    def iterate_primitives(self) -> Iterator[tuple[int, int, dict[str, Any]]]:
        """Yield each primitive of triangles: number of the mesh, number in the mesh, description."""
        for i, mesh in enumerate(self.get_entries("meshes")):
            for j, primitive in enumerate(mesh.get("primitives", ())):
                of_triangles = primitive.get("mode", Mode.TRIANGLES) in list(Mode)
                if of_triangles and "POSITION" in primitive.get("attributes", {}):
                    yield i, j, primitive


def find_placements(gltf: Gltf) -> dict[int, Placement]:
    """Return the placement of each mesh's largest instance; of equal instances, the first one is used."""
    nodes, scenes = gltf.get_entries("nodes"), gltf.get_entries("scenes")
    largest, area_of_mesh = dict[int, Placement](), dict[int, float]()
    roots = scenes[gltf.text.get("scene", 0)].get("nodes", ()) if scenes else ()
    children = {child for node in nodes for child in node.get("children", ())}
    stack = [(i, np.eye(4)) for i in (*roots, *(i for i in range(len(nodes)) if i not in children))][::-1]
    seen, instances = set[int](), dict[tuple[int, ...], FloatArray]()
    while stack:
        i, parent = stack.pop()
        if i in seen:
            continue
        seen.add(i)
        with np.errstate(over="ignore", invalid="ignore"):
            matrix = parent @ _make_transform(nodes[i])
            placed = matrix @ _find_instance_transforms(gltf, nodes[i], instances)
        if not np.isfinite(placed).all():
            raise Damaged(f"its node {i} is placed beyond double precision")
        if "mesh" in nodes[i]:
            mesh, areas = nodes[i]["mesh"], _compute_area_scales(placed)
            k = int(np.argmax(areas))
            times = len(placed) + (largest[mesh].times if mesh in largest else 0)
            if mesh not in largest or areas[k] > area_of_mesh[mesh]:
                area_of_mesh[mesh] = float(areas[k])
                largest[mesh] = Placement(nodes[i].get("name", ""), placed[k])
            largest[mesh] = largest[mesh]._replace(times=times)
        stack += [(child, matrix) for child in nodes[i].get("children", ())][::-1]
    return {
        mesh: _drop_collapsing_matrix(placement, area_of_mesh[mesh]) for mesh, placement in largest.items()
    }


def _drop_collapsing_matrix(placement: Placement, area: float) -> Placement:
    """Return the placement, without its linear map if this map would shrink the mesh to zero area."""
    if area > 0:
        return placement
    matrix = np.eye(4)
    matrix[:3, 3] = placement.matrix[:3, 3]
    return placement._replace(matrix=matrix)


def _compute_area_scales(matrices: FloatArray) -> FloatArray:
    """Return the area scale of each transform (k, 4, 4): the norm of its scales in the three axis planes."""
    a, b, c = np.moveaxis(matrices[:, :3, :3], 2, 0)
    with np.errstate(all="ignore"):
        planes = np.hstack([np.cross(a, b), np.cross(b, c), np.cross(c, a)])
        return np.asarray(np.nan_to_num(np.linalg.norm(planes, axis=1)))


def _find_instance_transforms(
    gltf: Gltf, node: dict[str, Any], known: dict[tuple[int, ...], FloatArray]
) -> FloatArray:
    """Return the transforms of a node's instances, (k, 4, 4), or the identity.

    `known` caches the transforms by accessor numbers, because several nodes may share accessors.
    """
    attributes = node.get("extensions", {}).get(INSTANCES, {}).get("attributes", {})
    names = [name for name in INSTANCE_ATTRIBUTES if name in attributes]
    count = min((gltf.count_rows(attributes[name]) for name in names), default=0)
    if not count:
        return np.eye(4)[None]
    key = tuple(attributes.get(name, -1) for name in INSTANCE_ATTRIBUTES)
    if key in known:
        return known[key]
    rows = {name: gltf.read_numbers(attributes[name], slice(count)) for name in names}
    matrices = np.tile(np.eye(4), (count, 1, 1))
    if "ROTATION" in rows:
        matrices[:, :3, :3] = np.moveaxis(_compute_rotations(*rows["ROTATION"].T), 2, 0)
    if "SCALE" in rows:
        matrices[:, :3, :3] *= rows["SCALE"][:, None, :]
    if "TRANSLATION" in rows:
        matrices[:, :3, 3] = rows["TRANSLATION"]
    known[key] = matrices
    return matrices


def _compute_rotations(x: Any, y: Any, z: Any, w: Any) -> FloatArray:
    """Return the rotation matrix of a unit quaternion, (3, 3), or of k quaternions, (3, 3, k)."""
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _make_transform(node: dict[str, Any]) -> FloatArray:
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    matrix = np.eye(4)
    matrix[:3, :3] = _compute_rotations(*np.array(node.get("rotation", (0.0, 0.0, 0.0, 1.0)), dtype=float))
    matrix[:3, :3] *= np.array(node.get("scale", (1.0, 1.0, 1.0)), dtype=float)
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix
