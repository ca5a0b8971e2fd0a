"""Write PLY in binary: a new file, or the one that was read with texture coordinates."""

from __future__ import annotations

from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from .._types import IntArray
from .mesh_file import MeshFile
from .one_index import one_index, single
from .parsing import Column, Property
from .ply import Element, PlyTables

NAMES = {"i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint"}
NAMES |= {"f4": "float", "f8": "double"}
TEXTURE = ("s", "t")  # MeshLab passes over them if they are doubles
OLD_TEXTURE = {"s", "t", "u", "v", "texture_u", "texture_v", "texcoord", "texnumber"}
Bytes = NDArray[np.uint8]
INDICES = ("vertex_indices", "vertex_index")


def save_ply(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write vertices, once for each of their texture coordinates, and polygons; all other elements stay."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    source = mesh.extras.source if isinstance(mesh.extras.source, PlyTables) else None
    extras = mesh.extras
    normals = extras.normals if source is None and extras.normal is not None else None
    indices = [mesh.polygons.corners, mesh.texture]
    if normals is not None and extras.normal is not None:
        indices.append(extras.normal)
    made = one_index(*indices)
    vertex: dict[str, Column] = {}
    types: dict[str, str] = {}
    rows = made.rows[0]
    if source is None:
        vertex = {axis: Column(mesh.V[rows, k]) for k, axis in enumerate("xyz")}
        types = dict.fromkeys("xyz", "f8")
        if normals is not None:
            for k, name in enumerate(("nx", "ny", "nz")):
                vertex[name], types[name] = Column(normals[made.rows[2], k]), "f4"
        if extras.colours is not None:
            for k, name in enumerate(("red", "green", "blue", "alpha")[: extras.colours.shape[1]]):
                values = np.round(np.clip(extras.colours[rows, k], 0, 1) * 255)
                vertex[name], types[name] = Column(values), "u1"
    else:
        for of in _element(source, "vertex").properties:
            if of.name not in OLD_TEXTURE and not of.length:  # no program has lists at vertices
                vertex[of.name], types[of.name] = (
                    Column(source.tables["vertex"][of.name].values[rows]),
                    of.type,
                )
    map_ = single(mesh.TC, "TC")[made.rows[1]]
    for k, name in enumerate(TEXTURE):
        vertex[name], types[name] = Column(map_[:, k]), "f4"
    faces: dict[str, tuple[Property, Column]] = {}
    for of in [] if source is None else _element(source, "face").properties:
        if of.name not in OLD_TEXTURE and of.name not in INDICES:
            faces[of.name] = of, source.tables["face"][of.name]  # type: ignore[union-attr]
    corner = Property("vertex_indices", "i4", "u1" if mesh.polygons.sizes.max() < 256 else "i4")
    faces[corner.name] = corner, Column(made.corners, mesh.polygons.sizes)
    others = [] if source is None else [of for of in source.elements if of.name not in ("vertex", "face")]
    comments = ["comment igl_linabf"] if source is None else source.comments
    with open(temporary, "wb") as file:
        head = ["ply", "format binary_little_endian 1.0", *comments]
        head.append(f"element vertex {len(rows)}")
        head += [f"property {NAMES[types[name]]} {name}" for name in vertex]
        head.append(f"element face {len(mesh.polygons)}")
        head += [_declared(of) for of, _ in faces.values()]
        for element in others:
            head += [f"element {element.name} {element.rows}", *map(_declared, element.properties)]
        file.write("\n".join([*head, "end_header\n"]).encode())
        table = np.empty(len(rows), dtype=[(name, "<" + types[name]) for name in vertex])
        for name, column in vertex.items():
            table[name] = column.values
        file.write(table.tobytes())
        _write_table(file, list(faces.values()), len(mesh.polygons))
        for element in others:
            assert source is not None
            columns = [(of, source.tables[element.name][of.name]) for of in element.properties]
            _write_table(file, columns, element.rows)


def _element(source: PlyTables, name: str) -> Element:
    return next(element for element in source.elements if element.name == name)


def _declared(of: Property) -> str:
    return f"property {f'list {NAMES[of.length]} ' if of.length else ''}{NAMES[of.type]} {of.name}"


def _write_table(file: BinaryIO, columns: list[tuple[Property, Column]], n: int) -> None:
    """Rows one after another, although their lists differ in size: each number's bytes at their place."""
    width = np.zeros(n, dtype=np.int64)
    for of, column in columns:
        width += _sizes(column, n) * np.dtype(of.type).itemsize
        width += np.dtype(of.length).itemsize if of.length else 0
    start = np.cumsum(width) - width
    data = np.empty(int(width.sum()), dtype=np.uint8)
    for of, column in columns:
        sizes = _sizes(column, n)
        if of.length:
            start = _put(data, start, sizes, of.length, np.ones(n, dtype=np.int64))
        start = _put(data, start, column.values, of.type, sizes)
    file.write(data.tobytes())


def _sizes(column: Column, n: int) -> IntArray:
    return np.ones(n, dtype=np.int64) if column.sizes is None else np.asarray(column.sizes, dtype=np.int64)


def _put(data: Bytes, start: IntArray, values: NDArray[Any], kind: str, sizes: IntArray) -> IntArray:
    """Write values, so many to each row, at the bytes where the rows begin; where these then go on."""
    bytes_ = np.ascontiguousarray(values, dtype="<" + kind).view(np.uint8).reshape(len(values), -1)
    width = bytes_.shape[1]
    before = np.repeat(np.cumsum(sizes) - sizes, sizes)
    at = np.repeat(start, sizes) + width * (np.arange(len(values)) - before)
    for k in range(width):
        data[at + k] = bytes_[:, k]
    return np.asarray(start + width * sizes)
