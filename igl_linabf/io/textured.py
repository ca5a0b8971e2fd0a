"""Surfaces with texture coordinates at their corners, to OBJ, PLY and GLB and from OBJ."""

from __future__ import annotations

import json
import os
import struct
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import MeshError, some
from ..surface import FloatArray, IntArray, face_array, vertex_array
from .formats import parse_file
from .plain import replacing

SUFFIXES = (".obj", ".ply", ".glb")


def write_mesh(
    path: str | os.PathLike[str], V: ArrayLike, F: ArrayLike, TC: ArrayLike, FTC: ArrayLike | None = None
) -> None:
    """Write a surface with texture coordinates; the suffix says how.

    OBJ has the indices of both, so that the surface stays whole along seams, and every number to
    the last bit. PLY and GLB have texture coordinates at vertices only: there a vertex is written
    once for each of its texture coordinates. Texture coordinates in PLY (`s`, `t`) and everything
    in GLB are **32-bit floats**, seven digits; PLY's positions are doubles. GLB has v upside down,
    as glTF asks, and its readers turn it back.

    Parameters
    ----------
    path : path of an OBJ, PLY or GLB file
    V : (#V, 3) float
    F : (#F, 3) int
    TC : (#TC, 2) float
        Texture coordinates, v upwards. Rows that are not finite are left out: no corner may use one.
    FTC : (#F, 3) int, optional
        Their indices at the corners; `F` by default, for coordinates at vertices.

    Raises
    ------
    MeshError
        The suffix is none of the three, indices are out of range, coordinates that are used are not
        finite, or they are beyond what 32 bits hold.
    OSError
        The file cannot be written. It is whole or not there, whatever happens.

    Examples
    --------
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "two.obj")
    >>> V, F = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]
    >>> TC, FTC = [[0, 0], [1, 0], [1, 1], [2, 0], [3, 1], [2, 1]], [[0, 1, 2], [3, 4, 5]]
    >>> write_mesh(path, V, F, TC, FTC)
    >>> read_texture(path)[1].tolist()
    [[0, 1, 2], [3, 4, 5]]
    """
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise MeshError(f"{path} is no file that can be written: use {', '.join(SUFFIXES)}")
    positions, faces, map_ = vertex_array(V), face_array(F), vertex_array(TC, 2, "TC")
    corners = faces if FTC is None else face_array(FTC)
    if corners.shape != faces.shape:
        raise MeshError(f"FTC has {len(corners)} rows for {len(faces)} faces: pass one row a face")
    _check(positions, faces, "F", "V")
    _check(map_, corners, "F, taken for FTC," if FTC is None else "FTC", "TC")
    writer = {".obj": _obj, ".ply": _ply, ".glb": _glb}[suffix]
    with replacing(path) as temporary:
        writer(temporary, positions, faces, map_, corners)


def read_texture(path: str | os.PathLike[str]) -> tuple[FloatArray, IntArray]:
    """Read the texture coordinates of an OBJ file.

    Parameters
    ----------
    path : path of an OBJ file

    Returns
    -------
    TC : (#TC, 2) float64
    FTC : (#F, 3) int64
        Rows as in the faces of `read_mesh`, polygons being split.

    Raises
    ------
    MeshError
        It is no OBJ file, damaged, or some or all of its corners have no coordinates.
    OSError
        There is no such file, or it may not be read.

    Examples
    --------
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "one.obj")
    >>> with open(path, "w") as file:
    ...     _ = file.write("v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nvt 0 0\\nvt 1 0\\nvt 0 1\\nf 1/1 2/2 3/3\\n")
    >>> read_texture(path)[0].tolist()
    [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    """
    path = Path(path)
    if path.suffix.lower() != ".obj":
        raise MeshError(f"{path} is no OBJ file: texture coordinates are read from OBJ only")
    parsed = parse_file(path)
    if not len(parsed.F):
        raise MeshError(f"{path} has no faces: is it a mesh?")
    if not len(parsed.TC) or (parsed.FTC == -1).all():
        raise MeshError(f"{path} has no texture coordinates at its faces (vt, f v/vt): unwrap it first")
    bare = np.flatnonzero((parsed.FTC == -1).any(axis=1))
    if len(bare):
        raise MeshError(
            f"{path} has no texture coordinates at corners of the faces {some(bare)}: give them some"
        )
    _check(parsed.TC, parsed.FTC, f"the f lines of {path}", "vt")
    return parsed.TC, parsed.FTC


def _check(rows: FloatArray, index: IntArray, index_name: str, name: str) -> None:
    outside = np.flatnonzero(((index < 0) | (index >= len(rows))).any(axis=1))
    if len(outside):
        raise MeshError(
            f"faces {some(outside)} refer in {index_name} to rows outside 0..{len(rows) - 1} of {name} "
            f"(face {outside[0]} is {index[outside[0]].tolist()}): correct the indices or complete {name}"
        )
    finite = np.asarray(np.isfinite(rows).all(axis=1))
    missing = np.flatnonzero(~finite[index].all(axis=1))
    if len(missing):
        raise MeshError(
            f"faces {some(missing)} have corners whose coordinates in {name} are NaN or infinite: "
            "give them coordinates, or leave the faces out"
        )


def _obj(path: str, V: FloatArray, F: IntArray, TC: FloatArray, FTC: IntArray) -> None:
    mapped = np.asarray(np.isfinite(TC).all(axis=1))
    corners = np.stack((F + 1, np.cumsum(mapped)[FTC]), axis=-1).reshape(-1, 6)
    with open(path, "w", encoding="ascii") as file:  # igl.writeOBJ says nothing of a full disk
        file.write("# igl_linabf\n")
        for keyword, rows in (("v", V), ("vt", TC[mapped])):
            file.writelines(f"{keyword} {' '.join(map(repr, row))}\n" for row in rows.tolist())
        file.writelines("f {}/{} {}/{} {}/{}\n".format(*row) for row in corners.tolist())


def _ply(path: str, V: FloatArray, F: IntArray, TC: FloatArray, FTC: IntArray) -> None:
    vertex, coordinate, faces = _split(F, FTC, len(TC))
    # MeshLab passes over s and t that are doubles
    points = np.empty(len(vertex), dtype=[("xyz", "<f8", 3), ("st", "<f4", 2)])
    points["xyz"], points["st"] = V[vertex], _single(TC[coordinate], "TC")
    rows = np.empty(len(faces), dtype=[("count", "u1"), ("corner", "<i4", 3)])
    rows["count"], rows["corner"] = 3, faces
    header = [
        "ply",
        "format binary_little_endian 1.0",
        "comment igl_linabf",
        f"element vertex {len(points)}",
        *(f"property double {name}" for name in "xyz"),
        *(f"property float {name}" for name in "st"),
        f"element face {len(rows)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    with open(path, "wb") as file:
        file.write("\n".join(header).encode())
        file.write(points.tobytes())
        file.write(rows.tobytes())


def _glb(path: str, V: FloatArray, F: IntArray, TC: FloatArray, FTC: IntArray) -> None:
    vertex, coordinate, faces = _split(F, FTC, len(TC))
    positions = _single(V[vertex], "V")
    map_ = _single(TC[coordinate] * [1, -1] + [0, 1], "TC")
    parts = (positions.tobytes(), map_.tobytes(), faces.astype("<u4").tobytes())
    starts = np.cumsum([0, *map(len, parts)]).tolist()
    targets = (34962, 34962, 34963)  # vertex attributes, vertex attributes, indices
    numbers = {"componentType": 5126, "count": len(positions)}  # 32-bit floats
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
            # glTF asks for the bounds, of positions as they are stored
            {"bufferView": 0, "type": "VEC3", **numbers, **_bounds(positions)},
            {"bufferView": 1, "type": "VEC2", **numbers},
            {"bufferView": 2, "type": "SCALAR", "componentType": 5125, "count": faces.size},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(part), "target": target}
            for start, part, target in zip(starts, parts, targets, strict=False)
        ],
        "buffers": [{"byteLength": starts[-1]}],
    }
    text = json.dumps(description, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + starts[-1]
    if size >= 2**32:
        raise MeshError(f"GLB holds 4 GB at most, and this takes {size} bytes: write OBJ or PLY")
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, size))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", starts[-1], b"BIN\0"))
        file.writelines(parts)


def _bounds(rows: NDArray[np.float32]) -> dict[str, list[float]]:
    return {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}


def _single(rows: FloatArray, name: str) -> NDArray[np.float32]:
    """The rows in single precision."""
    if np.abs(rows).max() > np.finfo(np.float32).max:
        raise MeshError(f"{name} has numbers beyond 3.4e38, the largest of 32 bits: scale it, or write OBJ")
    return rows.astype("<f4")


def _split(F: IntArray, FTC: IntArray, n: int) -> tuple[IntArray, IntArray, IntArray]:
    """Vertex and coordinate of each distinct pair of them at a corner, and the faces of pairs."""
    pairs, index = np.unique(F.ravel() * n + FTC.ravel(), return_inverse=True)
    return pairs // n, pairs % n, index.reshape(F.shape).astype(np.int64)
