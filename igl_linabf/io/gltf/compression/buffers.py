"""Replace compressed primitives and buffer views of a glTF description by uncompressed ones."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....errors import format_count
from ...limits import check_expansion
from ...parsing import Damaged, call_reader, import_optional
from ..extensions import DRACO, MESHOPT
from ..scene import DTYPES, WIDTHS, Component, Gltf, Mode
from .draco import DracoMesh, decode_draco, read_counts

INDEX_BYTES = 4  # bytes of a decoded index
INDEX_SIZES = (2, 4)  # bytes of an index that meshopt encodes
# Row sizes in bytes that each meshopt filter allows. All other filters allow multiples of 4.
FILTER_STRIDES = {"OCTAHEDRAL": (4, 8), "QUATERNION": (8,), "COLOR": (4, 8)}


def decompress_gltf(gltf: Gltf) -> Gltf:
    """Return a file without compression; its description is changed in place.

    Raises
    ------
    Damaged
        Compressed data are damaged, or need memory out of proportion to the file.
    ImportError
        The package that decodes the data is missing.
    """
    decoder = _Decoder(gltf)
    for number, view in enumerate(gltf.get_entries("bufferViews")):
        for name in MESHOPT:
            if name in view.get("extensions", {}):
                decoder.decode_view(number, view, name)
    gltf = decoder.make_decompressed_file()
    decoder = _Decoder(gltf)
    for i, mesh in enumerate(gltf.get_entries("meshes")):
        for j, primitive in enumerate(mesh["primitives"]):
            if DRACO in primitive.get("extensions", {}):
                decoder.decode_primitive(primitive, f"meshes[{i}].primitives[{j}]")
    return decoder.make_decompressed_file()


class _Decoder:
    """Decoded data of a file, which become one additional buffer."""

    def __init__(self, gltf: Gltf) -> None:
        self.gltf = gltf
        self.given = gltf.total_bytes
        self.buffer = len(gltf.buffers)
        self.parts: list[bytes] = []
        self.size = 0
        self.wanted = 0
        self.names = set[str]()
        self.decoded = set[int]()  # accessors with decoded data
        self.meshes = dict[int, DracoMesh]()  # decoded data by buffer view

    def make_decompressed_file(self) -> Gltf:
        """Return the file with the decoded data as a new buffer, and without its compression extensions."""
        text = self.gltf.text
        if not self.names:
            return self.gltf
        for key in ("extensionsUsed", "extensionsRequired"):
            if key in text:
                text[key] = [name for name in text[key] if name not in self.names]
                if not text[key]:
                    del text[key]
        # remove the marks of meshopt extensions on buffers that have no data
        for buffer in text["buffers"]:
            extensions = {k: v for k, v in buffer.pop("extensions", {}).items() if k not in self.names}
            buffer |= {"extensions": extensions} if extensions else {}
        text["buffers"].append({"byteLength": self.size})
        names = (*self.gltf.compression, *sorted(self.names))
        return replace(self.gltf, buffers=[*self.gltf.buffers, b"".join(self.parts)], compression=names)

    def decode_view(self, number: int, view: dict[str, Any], name: str) -> None:
        """Replace a buffer view that is compressed by meshopt."""
        place = f"bufferViews[{number}].extensions.{name}"
        mark = view["extensions"].pop(name)
        if not view["extensions"]:
            del view["extensions"]
        start, length = mark.get("byteOffset", 0), mark["byteLength"]
        buffer = self.gltf.buffers[mark["buffer"]]
        if start + length > len(buffer):
            raise Damaged(f"its {place} ends after the {len(buffer)} bytes of its buffer")
        count, stride, mode = mark["count"], mark["byteStride"], mark["mode"]
        filter_ = mark.get("filter", "NONE")
        _check_layout(place, count, stride, mode, filter_)
        self._check_decoded_size(count * stride, place)
        decode = import_optional("meshopt").decode_gltf_buffer
        rows = call_reader(
            lambda data: decode(data, count, stride, mode, None if filter_ == "NONE" else filter_),
            buffer[start : start + length],
        )
        data = np.ascontiguousarray(rows).tobytes()
        if len(data) != count * stride or len(data) != view["byteLength"]:
            raise Damaged(f"its {place} has {len(data)} bytes, not {view['byteLength']}")
        view |= self._append_view(data)
        self.names.add(name)

    def decode_primitive(self, primitive: dict[str, Any], place: str) -> None:
        """Replace a primitive's data compressed by Draco, unless it also has uncompressed data."""
        text = self.gltf.text
        mark = primitive["extensions"].pop(DRACO)
        if not primitive["extensions"]:
            del primitive["extensions"]
        self.names.add(DRACO)
        compressed = [primitive["attributes"].get(name) for name in mark["attributes"]]
        if None in compressed or "indices" not in primitive:
            raise Damaged(f"its {place} lacks accessors for its data compressed by Draco")
        if all("bufferView" in text["accessors"][i] for i in (*compressed, primitive["indices"])):
            return
        number = mark["bufferView"]
        if number not in self.meshes:
            self.meshes[number] = self._decode_draco(number, len(mark["attributes"]), place)
        mesh = self.meshes[number]
        for name, unique_id in mark["attributes"].items():
            if unique_id not in mesh.attributes:
                raise Damaged(f"its {place}.attributes.{name} is missing in its data compressed by Draco")
            rows = mesh.attributes[unique_id]
            primitive["attributes"][name] = self._store_rows(
                primitive["attributes"][name], rows, f"{place}.{name}"
            )
        accessor = text["accessors"][primitive["indices"]]
        accessor["componentType"] = int(Component.UNSIGNED_INT)
        primitive["indices"] = self._store_rows(
            primitive["indices"], mesh.F.reshape(-1, 1), f"{place}.indices"
        )
        primitive["mode"] = int(Mode.TRIANGLES)

    def _decode_draco(self, number: int, n_attributes: int, place: str) -> DracoMesh:
        data = self.gltf.read_view(number)
        vertices, triangles = read_counts(data)
        row = n_attributes * WIDTHS["VEC4"] * INDEX_BYTES  # upper bound on the bytes per vertex
        self._check_decoded_size(3 * INDEX_BYTES * triangles + row * vertices, place)
        return decode_draco(data)

    def _check_decoded_size(self, size: int, place: str) -> None:
        """Raise `Damaged` if decoded data are out of proportion to the file."""
        self.wanted += size
        check_expansion(self.wanted, self.given, f"its compressed data, up to {place},")

    def _store_rows(self, number: int, rows: NDArray[Any], place: str) -> int:
        """Store rows as the data of an accessor, and return its number; a shared accessor is copied."""
        accessors = self.gltf.text["accessors"]
        accessor, rows = accessors[number], rows.reshape(len(rows), -1)
        stored = rows.astype(DTYPES[accessor["componentType"]])
        if rows.shape[1] != WIDTHS[accessor["type"]] or not np.array_equal(stored, rows, equal_nan=True):
            raise Damaged(f"its {place} differs in type from its data compressed by Draco")
        if number in self.decoded:
            accessor, number = dict(accessor), len(accessors)
            accessors.append(accessor)
        self.decoded.add(number)
        for key in ("byteOffset", "sparse"):
            accessor.pop(key, None)
        views = self.gltf.text.setdefault("bufferViews", [])
        accessor |= {"bufferView": len(views), "count": len(rows)}
        views.append(self._append_view(stored.tobytes()))
        return number

    def _append_view(self, data: bytes) -> dict[str, Any]:
        """Append data, and return the buffer view that contains them."""
        place = {"buffer": self.buffer, "byteOffset": self.size, "byteLength": len(data)}
        self.parts.append(data + b"\0" * (-len(data) % 4))
        self.size += len(self.parts[-1])
        return place


def _check_layout(place: str, count: int, stride: int, mode: str, filter_: str) -> None:
    """Raise `Damaged` if the specification of meshopt does not allow rows of this kind."""
    if mode == "ATTRIBUTES":
        is_allowed = stride % 4 == 0
        is_allowed &= stride in FILTER_STRIDES.get(filter_, (stride,))
    else:
        is_allowed = stride in INDEX_SIZES and filter_ == "NONE" and (mode == "INDICES" or count % 3 == 0)
    if not is_allowed:
        kind = f"{mode}, filter {filter_}"
        raise Damaged(
            f"its {place} has {format_count(count, 'row')} of {stride} bytes, which {kind} does not allow"
        )
