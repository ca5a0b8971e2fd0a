"""Write binary PLY: a new file, or the file that was read with new texture coordinates."""

import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._types import FloatArray, IntArray
from ..materials import quantise_colours, warn_of_stale_images
from ..mesh_file import MeshFile
from ..parsing import Column, Property, encode_utf8
from ..vertex_splits import SplitVertices, find_unique_tuples, split_with_stable_indices, to_single_precision
from .reading import (
    COLOUR_NAMES,
    CORNER_TEXTURE,
    IMAGE_COMMENT,
    INDEX_NAMES,
    NORMAL_NAMES,
    SECOND_MAP_SUFFIX,
    TYPE_NAMES,
    PlyTables,
    make_row_dtype,
)

TEXTURE_PROPERTIES = ("s", "t")  # written as 32-bit floats, because MeshLab ignores doubles
TEXTURE_NAMES_TO_REPLACE = {"s", "t", "u", "v", "texture_u", "texture_v", CORNER_TEXTURE}
SECOND_NAMES_TO_REPLACE = {name + SECOND_MAP_SUFFIX for name in (*TEXTURE_PROPERTIES, CORNER_TEXTURE)}
Fields = list[tuple[Property, Column]]


def save_ply(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write vertices with unchanged indices, polygons, and all other elements of a PLY file that was read.

    Texture coordinates are vertex properties if there are no seams. With seams, triangle meshes store texture
    coordinates as lists at the faces. Meshes with larger polygons get additional vertices instead, because
    MeshLab does not open polygons with lists of texture coordinates.
    """
    assert mesh.TC is not None and mesh.texture is not None
    source = mesh.extras.source if isinstance(mesh.extras.source, PlyTables) else None
    polygons, split_at_normals = mesh.polygons, source is None
    split = split_with_stable_indices(mesh)
    at_faces = len(split.vertex) > len(mesh.V) and bool((polygons.sizes == 3).all())
    if at_faces:
        one = np.zeros_like(mesh.texture)
        first = None if mesh.first is None else (mesh.first[0], one)
        split = split_with_stable_indices(replace(mesh, texture=one, first=first), split_at_normals)
    elif split_at_normals:
        split = split_with_stable_indices(mesh, split_at_normals)
    elements = (
        _make_elements(mesh, split)
        if source is None
        else _keep_elements(source, split, mesh.first is not None)
    )
    corner = Property(INDEX_NAMES[0], "i4", "u1" if polygons.sizes.max() < 256 else "i4")
    elements["face"].insert(0, (corner, Column(split.corners, polygons.sizes)))
    for suffix, whole, at_vertices in _list_maps(mesh, split):
        if at_faces:
            lists = to_single_precision(whole[0], "TC")[whole[1]].ravel()
            corner = Property(CORNER_TEXTURE + suffix, "f4", "u1")
            elements["face"].append((corner, Column(lists, 2 * polygons.sizes)))
        else:
            names = [name + suffix for name in TEXTURE_PROPERTIES]
            elements["vertex"] += _make_fields(names, "f4", to_single_precision(at_vertices, "TC"))
    comments = _make_comments(mesh) if source is None else _keep_comments(mesh, source, path)
    head = ["ply", "format binary_little_endian 1.0", *comments]
    for name, columns in elements.items():
        head += [f"element {name} {len(columns[0][1])}", *(_declare_property(prop) for prop, _ in columns)]
    with open(temporary, "wb") as file:
        file.write("\n".join([*head, "end_header\n"]).encode("latin-1"))
        for columns in elements.values():
            file.write(_encode_rows(columns))


def _list_maps(
    mesh: MeshFile, split: SplitVertices
) -> list[tuple[str, tuple[FloatArray, IntArray], FloatArray]]:
    """Return, for each texture map, its suffix of property names, (TC, texture), and values at vertices."""
    assert mesh.TC is not None and mesh.texture is not None
    if mesh.first is None or split.first is None:
        return [("", (mesh.TC, mesh.texture), split.TC)]
    return [("", mesh.first, split.first), (SECOND_MAP_SUFFIX, (mesh.TC, mesh.texture), split.TC)]


def _make_fields(names: Iterable[str], kind: str, table: NDArray[Any]) -> Fields:
    return [(Property(name, kind), Column(table[:, k])) for k, name in enumerate(names)]


def _make_elements(mesh: MeshFile, split: SplitVertices) -> dict[str, Fields]:
    vertex, extras = _make_fields("xyz", "f8", mesh.V[split.vertex]), mesh.extras
    if split.normals is not None:
        vertex += _make_fields(NORMAL_NAMES, "f4", split.normals)
    if extras.colours is not None:
        vertex += _make_colour_fields(extras.colours[split.vertex])
    return {
        "vertex": vertex,
        "face": [] if extras.face_colours is None else _make_colour_fields(extras.face_colours),
    }


def _make_colour_fields(colours: FloatArray) -> Fields:
    return _make_fields(COLOUR_NAMES[0][: colours.shape[1]], "u1", quantise_colours(colours))


def _keep_elements(source: PlyTables, split: SplitVertices, has_second: bool) -> dict[str, Fields]:
    """Return the elements of the original file, vertices and faces first, without replaced properties."""
    replaced = TEXTURE_NAMES_TO_REPLACE | SECOND_NAMES_TO_REPLACE if has_second else TEXTURE_NAMES_TO_REPLACE
    kept = {
        name: [(prop, source.tables[name][prop.name]) for prop in props] for name, _, props in source.elements
    }
    vertex = [
        (prop, column.select_rows(split.vertex))
        for prop, column in kept.pop("vertex")
        if prop.name not in replaced
    ]
    face = [(prop, column) for prop, column in kept.pop("face") if prop.name not in {*replaced, *INDEX_NAMES}]
    return {"vertex": vertex, "face": face, **kept}


def _make_comments(mesh: MeshFile) -> list[str]:
    """Return the comment lines of a new PLY header; PLY does not specify an encoding for comments."""
    lines = [encode_utf8(line).decode("latin-1") for line in mesh.extras.comments]
    return ["comment igl_linabf", *(f"comment {line}" for line in lines)]


def _keep_comments(mesh: MeshFile, source: PlyTables, path: Path) -> list[str]:
    """Return the comments of the original file, with image names relative to the new file's folder."""
    comments = []
    for line in source.comments:
        head, name, rest = line.partition(f"comment {IMAGE_COMMENT} ")
        if name and not head and mesh.folder is not None:
            image_name = os.fsdecode(rest.encode("latin-1"))
            rest = os.fsencode(mesh.folder.relocate_reference(image_name.strip(), path.parent)).decode(
                "latin-1"
            )
        comments.append(head + name + rest)
    if mesh.first is None:
        warn_of_stale_images(sum(line.startswith(f"comment {IMAGE_COMMENT} ") for line in comments))
    return comments


def _declare_property(prop: Property) -> str:
    list_type = f"list {TYPE_NAMES[prop.length]} " if prop.length else ""
    return f"property {list_type}{TYPE_NAMES[prop.type]} {prop.name}"


def _encode_rows(columns: Fields) -> bytes:
    """Return the rows of a table as bytes; rows with equal list sizes are encoded together."""
    ones = np.ones(len(columns[0][1]), dtype=np.int64)
    sizes = [ones if column.sizes is None else column.sizes for _, column in columns]
    (_, *forms), form = find_unique_tuples(ones, *sizes)
    types = [
        make_row_dtype(tuple(prop for prop, _ in columns), list_sizes, "<")
        for list_sizes in zip(*forms, strict=True)
    ]
    width = np.array([kind.itemsize for kind in types], dtype=np.int64)[form]
    start = np.cumsum(width) - width
    data = np.empty(int(width.sum()), dtype=np.uint8)
    for i, kind in enumerate(types):
        rows = np.flatnonzero(form == i)
        table = np.empty(len(rows), dtype=kind)
        for k, (prop, column) in enumerate(columns):
            size = forms[k][i]
            if prop.length:
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
