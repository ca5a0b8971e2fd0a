"""Write PLY in binary: a new file, or the one that was read with texture coordinates."""

import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._types import FloatArray, IntArray
from ..materials import bytes_of_colours, warn_of_images
from ..mesh_file import MeshFile
from ..parsing import Column, Property, as_bytes
from ..references import renamed
from ..vertex_splits import SplitVertices, single_precision, split_behind, unique_tuples
from .reading import COLOUR_NAMES, CORNER_TEXTURE, IMAGE, INDICES, NAMES, NORMAL_NAMES, PlyTables, row_type

TEXTURE = ("s", "t")  # MeshLab passes over them if they are doubles
SECOND = "1"  # behind their names: PLY has no rule for second ones
OLD_TEXTURE = {"s", "t", "u", "v", "texture_u", "texture_v", CORNER_TEXTURE}
OLD_SECOND = {name + SECOND for name in (*TEXTURE, CORNER_TEXTURE)}
Fields = list[tuple[Property, Column]]


def save_ply(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write vertices, each under its number, and polygons; all other elements stay.

    Texture coordinates are at the vertices. Where there are seams, they are lists at the triangles; polygons
    have more vertices behind the others instead, as MeshLab opens no polygons with such lists.
    """
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    source = mesh.extras.source if isinstance(mesh.extras.source, PlyTables) else None
    polygons, split_at_normals = mesh.polygons, source is None
    made = split_behind(mesh)
    at_faces = len(made.vertex) > len(mesh.V) and bool((polygons.sizes == 3).all())
    if at_faces:
        one = np.zeros_like(mesh.texture)
        first = None if mesh.first is None else (mesh.first[0], one)
        made = split_behind(replace(mesh, texture=one, first=first), split_at_normals)
    elif split_at_normals:
        made = split_behind(mesh, split_at_normals)
    elements = _new_elements(mesh, made) if source is None else _kept(source, made, mesh.first is not None)
    corner = Property(INDICES[0], "i4", "u1" if polygons.sizes.max() < 256 else "i4")
    elements["face"].insert(0, (corner, Column(made.corners, polygons.sizes)))
    for mark, whole, at_vertices in _maps(mesh, made):
        if at_faces:
            lists = single_precision(whole[0], "TC")[whole[1]].ravel()
            corner = Property(CORNER_TEXTURE + mark, "f4", "u1")
            elements["face"].append((corner, Column(lists, 2 * polygons.sizes)))
        else:
            names = [name + mark for name in TEXTURE]
            elements["vertex"] += _numbers(names, "f4", single_precision(at_vertices, "TC"))
    comments = _new_comments(mesh) if source is None else _kept_comments(mesh, source, path)
    head = ["ply", "format binary_little_endian 1.0", *comments]
    for name, columns in elements.items():
        head += [f"element {name} {len(columns[0][1])}", *(_declared(of) for of, _ in columns)]
    with open(temporary, "wb") as file:
        file.write("\n".join([*head, "end_header\n"]).encode("latin-1"))
        for columns in elements.values():
            file.write(_binary_rows(columns))


def _maps(mesh: MeshFile, made: SplitVertices) -> list[tuple[str, tuple[FloatArray, IntArray], FloatArray]]:
    """What the names of texture coordinates end in, their rows at corners, and those of vertices."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    if mesh.first is None or made.first is None:
        return [("", (mesh.TC, mesh.texture), made.TC)]
    return [("", mesh.first, made.first), (SECOND, (mesh.TC, mesh.texture), made.TC)]


def _numbers(names: Iterable[str], kind: str, table: NDArray[Any]) -> Fields:
    return [(Property(name, kind), Column(table[:, k])) for k, name in enumerate(names)]


def _new_elements(mesh: MeshFile, made: SplitVertices) -> dict[str, Fields]:
    vertex, extras = _numbers("xyz", "f8", mesh.V[made.vertex]), mesh.extras
    if made.normals is not None:
        vertex += _numbers(NORMAL_NAMES, "f4", made.normals)
    if extras.colours is not None:
        vertex += _colour_fields(extras.colours[made.vertex])
    return {
        "vertex": vertex,
        "face": [] if extras.face_colours is None else _colour_fields(extras.face_colours),
    }


def _colour_fields(colours: FloatArray) -> Fields:
    return _numbers(COLOUR_NAMES[0][: colours.shape[1]], "u1", bytes_of_colours(colours))


def _kept(source: PlyTables, made: SplitVertices, second: bool) -> dict[str, Fields]:
    """The elements that were read, vertices and faces first, without what is written anew."""
    old = OLD_TEXTURE | OLD_SECOND if second else OLD_TEXTURE
    kept = {name: [(of, source.tables[name][of.name]) for of in its] for name, _, its in source.elements}
    vertex = [(of, column.take(made.vertex)) for of, column in kept.pop("vertex") if of.name not in old]
    face = [(of, column) for of, column in kept.pop("face") if of.name not in {*old, *INDICES}]
    return {"vertex": vertex, "face": face, **kept}


def _new_comments(mesh: MeshFile) -> list[str]:
    """A comment is one line of bytes, of which PLY says no encoding."""
    given = [as_bytes(line).decode("latin-1") for line in mesh.extras.comments]
    return ["comment igl_linabf", *(f"comment {line}" for line in given)]


def _kept_comments(mesh: MeshFile, source: PlyTables, path: Path) -> list[str]:
    """The comments that were read; images are named as seen from the new folder."""
    comments = []
    for line in source.comments:
        head, name, rest = line.partition(f"comment {IMAGE} ")
        if name and not head and mesh.path is not None:
            named = os.fsdecode(rest.encode("latin-1"))
            rest = os.fsencode(renamed(named.strip(), mesh.path.parent, path.parent)).decode("latin-1")
        comments.append(head + name + rest)
    if mesh.first is None:
        warn_of_images(sum(line.startswith(f"comment {IMAGE} ") for line in comments))
    return comments


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
