"""Files that use many features of OBJ, PLY and glTF, and helpers to compare what is read from them."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import igl
import numpy as np

from igl_linabf import unwrap
from igl_linabf.io import MeshFile, read_file, write_file


def corners(mesh: MeshFile) -> np.ndarray:
    """Return position and texture coordinates at each corner."""
    assert mesh.TC is not None
    assert mesh.texture is not None
    return np.hstack((mesh.V[mesh.polygons.corners], mesh.TC[mesh.texture]))


def unwrap_file(source: Path, out: Path) -> tuple[MeshFile, MeshFile]:
    """Unwrap a file; return the mesh with its atlas, and the mesh that is read from the written file."""
    mesh = read_file(source)
    atlas = unwrap(mesh.V, mesh.F, progress=False)
    write_file(out, mesh, atlas.TC, atlas.FTC)
    return mesh.with_texture(atlas.TC, atlas.FTC), read_file(out)


OBJ = """# a box
mtllib box.mtl
o lid
v 0 0 1 1 0 0
v 1 0 1 0 1 0
v 1 1 1 0 0 1
v 0 1 1 1 1 0
vn 0 0 1
vt 9 9
usemtl red
s off
f 1/1/1 2/1/1 3/1/1 4/1/1
o body
v 0 0 0 1 0 0
v 1 0 0 0 1 0
v 1 1 0 0 0 1
v 0 1 0 1 1 0
vn 0 0 -1
usemtl blue
f -1//-1 -2//-1 -3//-1 -4//-1
g sides
f 1 5 6 2
f 2 6 7 3
f 3 7 8 4
f 4 8 5 1 # the last
l 1/1 5/1
"""


def write_glb(path: Path, text: dict, parts: list[bytes]) -> None:
    """Write a GLB file with one buffer view for each of `parts`."""
    views, start = [], 0
    for part in parts:
        views.append({"buffer": 0, "byteOffset": start, "byteLength": len(part)})
        start += len(part)
    data = json.dumps({**text, "bufferViews": views, "buffers": [{"byteLength": start}]}).encode()
    data += b" " * (-len(data) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(data) + start)
    path.write_bytes(
        head + struct.pack("<I4s", len(data), b"JSON") + data + struct.pack("<I4s", start, b"BIN\0")
    )
    with path.open("ab") as file:
        file.writelines(parts)


def write_scene(path: Path) -> None:
    """Write an animated scene of two meshes under rotated and scaled nodes."""
    V, F = igl.icosahedron()
    normals = V / np.linalg.norm(V, axis=1)[:, None]
    colours = (np.arange(48) * 5).astype("<u1").reshape(12, 4)
    three, nine = np.arange(3, dtype="<f4"), np.arange(9, dtype="<f4")
    floats, index = (V.astype("<f4"), normals.astype("<f4")), (F[:11].astype("<u2"), F[11:].astype("<u2"))
    arrays = (*floats, *index, colours, three, nine, (V * 0.1).astype("<f4"))
    parts = [array.tobytes() + b"\0" * (-array.nbytes % 4) for array in arrays]
    view = {"POSITION": 0, "NORMAL": 1, "COLOR_0": 4, "_LABEL": 4}
    first = {"attributes": view, "indices": 2, "material": 0, "targets": [{"POSITION": 7}]}
    second = {"attributes": {"POSITION": 0, "NORMAL": 1, "COLOR_0": 4}, "indices": 3, "material": 1,
              "targets": [{"POSITION": 7}]}  # fmt: skip
    text = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "root", "scale": [2] * 3, "rotation": [0, 0, 0.5**0.5, 0.5**0.5], "children": [1, 2, 3]},
            {"name": "here", "mesh": 0, "translation": [1, 2, 3], "extras": {"id": 7}},
            {"name": "there", "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 9, 9, 9, 1]},
            {"name": "ball", "mesh": 1},
        ],
        "meshes": [{"name": "gem", "primitives": [first, second], "weights": [0.5]},
                   {"name": "ball", "primitives": [{"attributes": {"POSITION": 0}, "indices": 3}]}],
        "materials": [{"name": "gold"}, {"name": "lead", "pbrMetallicRoughness": {"roughnessFactor": 0.3}}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
                        "samplers": [{"input": 5, "output": 6}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 12, "type": "VEC3", "min": V.min(0).tolist(),
             "max": V.max(0).tolist()},
            {"bufferView": 1, "componentType": 5126, "count": 12, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5123, "count": 33, "type": "SCALAR"},
            {"bufferView": 3, "componentType": 5123, "count": 27, "type": "SCALAR"},
            {"bufferView": 4, "componentType": 5121, "normalized": True, "count": 12, "type": "VEC4"},
            {"bufferView": 5, "componentType": 5126, "count": 3, "type": "SCALAR"},
            {"bufferView": 6, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 7, "componentType": 5126, "count": 12, "type": "VEC3"},
        ],
    }  # fmt: skip
    write_glb(path, text, parts)
