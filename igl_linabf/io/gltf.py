"""Write GLB, the binary form of glTF 2.0."""

from __future__ import annotations

import json
import struct

import numpy as np

from .._types import FloatArray, IntArray
from ..errors import MeshError
from .one_index import single, split_at_seams

FLOAT, UNSIGNED = 5126, 5125  # glTF's numbers for types of 32 bits
VERTEX_ATTRIBUTES, INDICES = 34962, 34963  # and for what a part is used as


def save_glb(path: str, V: FloatArray, F: IntArray, TC: FloatArray, FTC: IntArray) -> None:
    """Write triangles with texture coordinates at the vertices, v downwards."""
    points, map_, faces = split_at_seams(V, F, TC, FTC)
    positions = single(points, "V")
    downwards = single(map_ * [1, -1] + [0, 1], "TC")
    parts = (positions.tobytes(), downwards.tobytes(), faces.astype("<u4").tobytes())
    starts = np.cumsum([0, *map(len, parts)]).tolist()
    uses = (VERTEX_ATTRIBUTES, VERTEX_ATTRIBUTES, INDICES)
    attribute = {"componentType": FLOAT, "count": len(positions)}
    # glTF asks for the bounds, of positions as they are stored
    bounds = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
    description = {
        "asset": {"version": "2.0", "generator": "igl_linabf"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}
        ],
        # readers (trimesh) drop texture coordinates that no material goes with
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0}, "doubleSided": True}],
        "accessors": [
            {"bufferView": 0, "type": "VEC3", **attribute, **bounds},
            {"bufferView": 1, "type": "VEC2", **attribute},
            {"bufferView": 2, "type": "SCALAR", "componentType": UNSIGNED, "count": faces.size},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(part), "target": use}
            for start, part, use in zip(starts, parts, uses, strict=False)
        ],
        "buffers": [{"byteLength": starts[-1]}],
    }
    text = json.dumps(description, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + starts[-1]
    if size >= 2**32:
        raise MeshError(f"a GLB file has at most 4 GB, and this mesh needs {size} bytes: write OBJ or PLY")
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, size))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", starts[-1], b"BIN\0"))
        file.writelines(parts)
