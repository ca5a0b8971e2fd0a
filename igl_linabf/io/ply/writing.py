"""Write PLY in binary: a new file, or the one that was read with texture coordinates."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mesh_file import MeshFile
from ..parsing import Column, Property
from ..vertex_splits import SplitVertices, single_precision, split_vertices, unique_tuples
from .reading import INDICES, NAMES, PlyTables, row_type

TEXTURE = ("s", "t")  # MeshLab passes over them if they are doubles
OLD_TEXTURE = {"s", "t", "u", "v", "texture_u", "texture_v", "texcoord", "texnumber"}
Fields = list[tuple[Property, Column]]


def save_ply(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write vertices, once for each of their texture coordinates, and polygons; all other elements stay."""
    source = mesh.extras.source if isinstance(mesh.extras.source, PlyTables) else None
    made = split_vertices(mesh, normals=source is None)
    elements = {"vertex": _new_vertices(mesh, made), "face": []} if source is None else _kept(source, made)
    elements["vertex"] += _numbers(TEXTURE, "f4", single_precision(made.TC, "TC"))
    corner = Property(INDICES[0], "i4", "u1" if mesh.polygons.sizes.max() < 256 else "i4")
    elements["face"].append((corner, Column(made.corners, mesh.polygons.sizes)))
    comments = ["comment igl_linabf"] if source is None else source.comments
    head = ["ply", "format binary_little_endian 1.0", *comments]
    for name, columns in elements.items():
        head += [f"element {name} {len(columns[0][1])}", *(_declared(of) for of, _ in columns)]
    with open(temporary, "wb") as file:
        file.write("\n".join([*head, "end_header\n"]).encode())
        for columns in elements.values():
            file.write(_binary_rows(columns))


def _numbers(names: Iterable[str], kind: str, table: NDArray[Any]) -> Fields:
    return [(Property(name, kind), Column(table[:, k])) for k, name in enumerate(names)]


def _new_vertices(mesh: MeshFile, made: SplitVertices) -> Fields:
    columns = _numbers("xyz", "f8", mesh.V[made.vertex])
    if made.normals is not None:
        columns += _numbers(("nx", "ny", "nz"), "f4", made.normals)
    if mesh.extras.colours is not None:
        colours = np.round(np.clip(mesh.extras.colours[made.vertex], 0, 1) * 255)
        columns += _numbers(("red", "green", "blue", "alpha")[: colours.shape[1]], "u1", colours)
    return columns


def _kept(source: PlyTables, made: SplitVertices) -> dict[str, Fields]:
    """The elements that were read, vertices and faces first, without what is written anew."""
    kept = {name: [(of, source.tables[name][of.name]) for of in its] for name, _, its in source.elements}
    vertex = [(of, column) for of, column in kept.pop("vertex") if of.name not in OLD_TEXTURE]
    face = [(of, column) for of, column in kept.pop("face") if of.name not in {*OLD_TEXTURE, *INDICES}]
    # no program has lists at vertices
    rows = [(of, Column(column.values[made.vertex])) for of, column in vertex if not of.length]
    return {"vertex": rows, "face": face, **kept}


def _declared(of: Property) -> str:
    return f"property {f'list {NAMES[of.length]} ' if of.length else ''}{NAMES[of.type]} {of.name}"


def _binary_rows(columns: Fields) -> bytes:
    """Rows one after another, which differ in length where their lists do: those of one form at a time."""
    every = np.ones(len(columns[0][1]), dtype=np.int64)
    sizes = [every if column.sizes is None else column.sizes for _, column in columns]
    (_, *forms), form = unique_tuples(every, *sizes)
    types = [row_type(tuple(of for of, _ in columns), own, "<") for own in zip(*forms, strict=True)]
    width = np.array([kind.itemsize for kind in types], dtype=np.int64)[form]
    start = np.cumsum(width) - width
    data = np.empty(int(width.sum()), dtype=np.uint8)
    for i, kind in enumerate(types):
        rows = np.flatnonzero(form == i)
        table = np.empty(len(rows), dtype=kind)
        for k, (of, column) in enumerate(columns):
            size = forms[k][i]
            if of.length:
                table[f"{k} size"] = size
                begin = np.cumsum(sizes[k]) - sizes[k]
                table[str(k)] = column.values[begin[rows, None] + np.arange(size)]
            else:
                table[str(k)] = column.values[rows, None]
        if len(types) == 1:
            return table.tobytes()
        for k, byte in enumerate(table.view(np.uint8).reshape(len(rows), -1).T):
            data[start[rows] + k] = byte
    return data.tobytes()
