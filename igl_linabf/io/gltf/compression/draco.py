"""Decode primitives that are compressed by Draco."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...parsing import Damaged, call_reader, import_optional

MAGIC, ENCODER, FLAGS, HEADER_SIZE = b"DRACO", 7, slice(9, 11), 11  # byte offsets in the header of Draco data
IS_MESH, EDGEBREAKER, HAS_METADATA = 1, 1, 0x8000  # values and flags in the header of Draco data


class DracoMesh(NamedTuple):
    """The decoded triangles (#T, 3), and the rows of each attribute, (#V, width), by attribute number."""

    F: NDArray[Any]
    attributes: dict[int, NDArray[Any]]


def decode_draco(data: bytes) -> DracoMesh:
    """Decode a mesh; raise `Damaged` if the data are damaged."""
    draco = import_optional("DracoPy")
    found = call_reader(draco.decode, data)
    if not isinstance(found, draco.DracoMesh):
        raise Damaged("its data compressed by Draco have no triangles")
    attributes = {int(entry["unique_id"]): np.asarray(entry["data"]) for entry in found.attributes}
    return DracoMesh(np.asarray(found.faces).reshape(-1, 3), attributes)


def read_counts(data: bytes) -> tuple[int, int]:
    """Return the numbers of vertices and triangles that data compressed by Draco declare.

    Return 0, 0 if metadata precede these numbers.
    """
    if data[:5] != MAGIC or len(data) < HEADER_SIZE or data[ENCODER] != IS_MESH:
        raise Damaged("its data compressed by Draco are not a mesh")
    if int.from_bytes(data[FLAGS], "little") & HAS_METADATA:
        return 0, 0
    is_edgebreaker = data[ENCODER + 1] == EDGEBREAKER
    first, rest = _read_varint(data, HEADER_SIZE + is_edgebreaker)
    second, _ = _read_varint(data, rest)
    return (first, second) if is_edgebreaker else (second, first)


def _read_varint(data: bytes, start: int) -> tuple[int, int]:
    """Return a number that is stored in groups of seven bits, and the place of the next byte."""
    value = 0
    for i, byte in enumerate(data[start : start + 5]):
        value |= (byte & 0x7F) << 7 * i
        if byte < 0x80:
            return value, start + i + 1
    raise Damaged("its data compressed by Draco are cut off")
