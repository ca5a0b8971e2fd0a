"""Read text and binary PLY files with all their elements and properties."""

import itertools
import re
import warnings
from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..._types import FloatArray
from ...errors import MeshWarning, first_few, format_count, stack_level
from ...surface import Polygons, has_distinct_corners
from ..mesh_file import MeshFile
from ..parsing import (
    Column,
    Damaged,
    Extras,
    Property,
    Table,
    decode_utf8,
    make_polygons,
    parse_table,
    raise_damaged_line,
    split_rows,
    triangulate_strips,
)

TYPE_NAMES = {"i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint"}
TYPE_NAMES |= {"f4": "float", "f8": "double"}
TYPE_CODES = {
    name: kind for kind in TYPE_NAMES for name in (TYPE_NAMES[kind], np.dtype(kind).name)
}  # PLY allows two names of each type, such as char and int8
BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
INTEGER_TYPES = [name for name, kind in TYPE_CODES.items() if kind[0] != "f"]
TEXTURE_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))  # names that programs give to (u, v)
COLOUR_NAMES: tuple[tuple[str, ...], ...] = (
    ("red", "green", "blue", "alpha"),
    ("red", "green", "blue"),
    ("r", "g", "b"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
)
NORMAL_NAMES = ("nx", "ny", "nz")
CORNER_TEXTURE = "texcoord"  # face property: list of u and v of each corner
SECOND_MAP_SUFFIX = "1"  # appended to names of second texture coordinates; not in the PLY standard
INDEX_NAMES = ("vertex_indices", "vertex_index")
IMAGE_COMMENT = "TextureFile"  # first word of a comment that names an image
MAX_PROPERTIES_WITH_LISTS = 64  # each combination of list sizes takes about 700 bytes per property
MAX_ROW_COUNT_DIGITS = 12  # digits of an element's row count, so that headers cannot cause overflow


class Element(NamedTuple):
    """The declaration of a table in a PLY header: its name, number of rows and columns."""

    name: str
    rows: int
    properties: list[Property]


class PlyTables(NamedTuple):
    """The elements, tables and comments of a PLY file."""

    elements: list[Element]
    tables: dict[str, Table]
    comments: list[str]


def parse_ply(data: bytes) -> MeshFile:
    """Parse the mesh from the bytes of a PLY file.

    Raises
    ------
    Damaged
        The file is damaged. The message names the line of a text file or the element of a binary file.
    """
    order, elements, comments, start, line = _parse_header(data)
    tables = (
        _read_binary_elements(data, start, elements, order)
        if order
        else _read_text_elements(data[start:], elements, line)
    )
    if "vertex" not in tables:
        raise Damaged("its header has no element vertex")
    if "range_grid" in tables and "face" not in tables:
        raise Damaged(
            "it contains a range scan without faces: mesh it first, for example by opening it in MeshLab"
        )
    of_strips = [name for name in tables.get("tristrips", ()) if name not in INDEX_NAMES]
    if "tristrips" in tables:
        elements = _append_strips(elements, tables)
    vertex = tables["vertex"]
    V = _stack_columns(vertex, *"xyz")
    if V is None:
        raise Damaged("its element vertex lacks the properties x, y and z")
    if "face" not in tables:  # a point cloud
        return MeshFile(V, Polygons.from_triangles(np.empty((0, 3), dtype=np.int64)))
    _, polygons = _find_index_list(tables, "face")
    small = np.flatnonzero(np.asarray(polygons.sizes) < 3)
    if len(small):
        raise Damaged(f"faces {first_few(small)} have fewer than three vertices")
    faces = make_polygons(polygons)
    outside = faces.find_out_of_range(len(V))
    if len(outside):
        raise Damaged(f"faces {first_few(outside)} refer to vertices outside 0..{len(V) - 1}")
    if of_strips:
        warnings.warn(
            f"triangle strips become faces, without their properties {', '.join(of_strips)}",
            MeshWarning,
            stacklevel=stack_level(),
        )
    extras = _make_extras(faces, PlyTables(elements, tables, comments))
    return _select_coordinates(MeshFile(V, faces, extras=extras), tables, CORNER_TEXTURE, TEXTURE_NAMES)


def select_second_uv_set(mesh: MeshFile, source: PlyTables) -> MeshFile:
    """Return a mesh with its second texture coordinates."""
    names = [tuple(name + SECOND_MAP_SUFFIX for name in pair) for pair in TEXTURE_NAMES]
    bare = replace(mesh, TC=None, texture=None)
    return _select_coordinates(bare, source.tables, CORNER_TEXTURE + SECOND_MAP_SUFFIX, names)


def _select_coordinates(
    mesh: MeshFile, tables: dict[str, Table], of_corners: str, of_vertices: Iterable[tuple[str, ...]]
) -> MeshFile:
    """Return the mesh with texture coordinates from a corner property, or otherwise vertex properties."""
    at_corners = tables["face"].get(of_corners)
    if at_corners is not None and (np.asarray(at_corners.sizes) == 2 * mesh.polygons.sizes).all():
        pairs = np.ascontiguousarray(at_corners.values, dtype=np.float64).view(np.complex128)
        pairs, texture = np.unique(pairs, return_inverse=True)  # complex pairs sort faster than rows
        TC = pairs.view(np.float64).reshape(-1, 2)
        return replace(mesh, TC=TC, texture=texture.ravel().astype(np.int64))
    for names in of_vertices:
        at_vertices = _stack_columns(tables["vertex"], *names)
        if at_vertices is not None:
            return replace(mesh, TC=at_vertices, texture=mesh.polygons.corners)
    return mesh


def _find_index_list(tables: dict[str, Table], element: str) -> tuple[str, Column]:
    """Return the name and the values of the property of an element that lists vertices."""
    for name in INDEX_NAMES:
        column = tables[element].get(name)
        if column is not None and column.sizes is not None and column.values.dtype.kind != "f":
            return name, column
    raise Damaged(f"its element {element} has no list of integers {INDEX_NAMES[0]}")


def _append_strips(elements: list[Element], tables: dict[str, Table]) -> list[Element]:
    """Append the triangles of the strips to the faces, with 0 or empty lists for all other properties."""
    _, rows = _find_index_list(tables, "tristrips")
    del tables["tristrips"]
    assert rows.sizes is not None
    row = np.repeat(np.arange(len(rows)), rows.sizes)
    ends = rows.values == -1  # -1 separates two strips in a list
    strip = row + np.cumsum(ends)
    F, _ = triangulate_strips(rows.values[~ends].astype(np.int64), strip[~ends])
    F = F[has_distinct_corners(F)]
    face_element = next((element for element in elements if element.name == "face"), None)
    if face_element is None:
        face_element = Element("face", 0, [Property(INDEX_NAMES[0], "i4", "u1")])
        tables["face"] = {INDEX_NAMES[0]: Column(np.empty(0, dtype="i4"), np.empty(0, dtype=np.int64))}
    index, _ = _find_index_list(tables, "face")
    for name, column in tables["face"].items():
        new = F.ravel() if name == index else np.zeros(0 if column.sizes is not None else len(F))
        sizes = np.full(len(F), 3 if name == index else 0)
        tables["face"][name] = Column(
            np.append(column.values, new.astype(np.int64 if name == index else column.values.dtype)),
            None if column.sizes is None else np.append(column.sizes, sizes),
        )
    face = Element("face", face_element.rows + len(F), face_element.properties)
    return [*(element for element in elements if element.name not in ("face", "tristrips")), face]


def _make_extras(faces: Polygons, source: PlyTables) -> Extras:
    """Return the colours, normals and comments of a PLY file, and descriptions of all other contents."""
    properties = {element.name: element.properties for element in source.elements}
    normals = _stack_columns(source.tables["vertex"], *NORMAL_NAMES)
    colours, colour_names = _find_colours(source.tables["vertex"], properties["vertex"])
    face_colours, face_colour_names = _find_colours(source.tables["face"], properties["face"])
    known = {
        "vertex": {
            *"xyz",
            *colour_names,
            *(NORMAL_NAMES if normals is not None else ()),
            *sum(TEXTURE_NAMES, ()),
        },
        "face": {*INDEX_NAMES, CORNER_TEXTURE, *face_colour_names},
    }
    unshared = []
    for element, known_names in known.items():
        others = [prop.name for prop in properties[element] if prop.name not in known_names]
        unshared += [f"the properties {', '.join(others)} of its {element} element"] * bool(others)
    elements = [name for name in properties if name not in known]
    unshared += [f"the elements {', '.join(elements)}"] * bool(elements)
    comments = [decode_utf8(line.partition(" ")[2].encode("latin-1")) for line in source.comments]
    unshared += ["its images"] * any(line.startswith(IMAGE_COMMENT) for line in comments)
    return Extras(
        colours=colours,
        normals=normals,
        normal=None if normals is None else faces.corners,
        face_colours=face_colours,
        comments=tuple(line for line in comments if not line.startswith(IMAGE_COMMENT)),
        unshared=tuple(unshared),
        source=source,
    )


def _find_colours(table: Table, properties: list[Property]) -> tuple[FloatArray | None, tuple[str, ...]]:
    """Return the colours of an element, from 0 to 1, and the names of their properties."""
    for names in COLOUR_NAMES:
        colours = _stack_columns(table, *names)
        if colours is not None:
            kind = next(prop.type for prop in properties if prop.name == names[0])
            return colours / (1 if kind[0] == "f" else np.iinfo(kind).max), names
    return None, ()


def _stack_columns(table: Table, *names: str) -> FloatArray | None:
    """Return the values of the named properties as columns; None unless the element has all of them."""
    columns = [table[name].values for name in names if name in table and table[name].sizes is None]
    return np.column_stack(columns).astype(np.float64) if len(columns) == len(names) else None


def _parse_header(data: bytes) -> tuple[str, list[Element], list[str], int, int]:
    """Return the byte order ("" for text), elements, comments, and the end of the header as byte and line."""
    order, elements, comments, start = None, list[Element](), list[str](), 0
    newline = b"\r" if re.match(rb"ply\s*\r(?!\n)", data) else b"\n"
    for line in itertools.count(1):
        end = data.find(newline, start)
        text = data[start : end if end >= 0 else start + 200]
        words = text.decode("latin-1").split()
        start = end + 1
        if line == 1 and words != ["ply"]:
            raise Damaged("it does not begin with the line ply")
        if end < 0:
            raise Damaged("its header has no end_header")
        match words:
            case ["format", encoding, _] if encoding in BYTE_ORDERS:
                order = BYTE_ORDERS[encoding]
            case ["element", name, rows] if rows.isdecimal() and len(rows) <= MAX_ROW_COUNT_DIGITS:
                elements.append(Element(name, int(rows), []))
            case ["property", kind, name] if elements and kind in TYPE_CODES:
                elements[-1].properties.append(Property(name, TYPE_CODES[kind]))
            case ["property", "list", length, kind, name] if (
                elements and length in INTEGER_TYPES and kind in TYPE_CODES
            ):
                elements[-1].properties.append(Property(name, TYPE_CODES[kind], TYPE_CODES[length]))
            case ["end_header"]:
                break
            case ["comment" | "obj_info", *_]:
                comments.append(text.decode("latin-1").strip())
            case []:
                pass
            case _ if line > 1:
                raise_damaged_line(line, text, "is not understood")
    if order is None:
        raise Damaged("its header has no line format")
    for element in elements:
        names = [prop.name for prop in element.properties]
        if not names or len(set(names)) < len(names):
            raise Damaged(f"its element {element.name} has no properties, or two with the same name")
        if len(names) > MAX_PROPERTIES_WITH_LISTS and any(prop.length for prop in element.properties):
            raise Damaged(
                f"its element {element.name} has lists and {len(names):,} properties: "
                f"at most {MAX_PROPERTIES_WITH_LISTS} are read"
            )
    if len({element.name for element in elements}) < len(elements):
        raise Damaged("it has two elements with the same name")
    return order, elements, comments, start, line


def _read_text_elements(data: bytes, elements: list[Element], before: int) -> dict[str, Table]:
    """Read all elements of a text file, with one row per line."""
    rows, line_numbers = split_rows(data)
    declared = sum(element.rows for element in elements)
    if len(rows) != declared:
        raise Damaged(
            f"its header declares {format_count(declared, 'row')} in total, but {len(rows)} lines "
            "follow: correct the header "
            "if no line is missing"
        )
    tables, start = {}, 0
    for element in elements:
        end = start + element.rows
        lines = [before + i for i in line_numbers[start:end]]
        problem = f"is not a row of the element {element.name}"
        tables[element.name] = parse_table(rows[start:end], lines, element.properties, problem)
        start = end
    return tables


def _read_binary_elements(data: bytes, start: int, elements: list[Element], order: str) -> dict[str, Table]:
    tables = {}
    for element in elements:
        tables[element.name], start = _read_element(data, start, element, order)
    if start != len(data):
        raise Damaged(f"{len(data) - start} bytes follow after the rows that its header declares")
    return tables


def _read_element(data: bytes, start: int, element: Element, order: str) -> tuple[Table, int]:
    """Read the columns of an element, by runs of rows with equal list sizes; also return its end in bytes."""
    runs: list[NDArray[Any]] = []
    sizes: list[tuple[int, ...]] = []
    done, ahead = 0, element.rows  # `ahead`: number of rows to test at once for equal list sizes
    while done < element.rows:
        sizes.append(_read_list_sizes(data, start, element, order, done))
        dtype = make_row_dtype(tuple(element.properties), sizes[-1], order)
        n = min(ahead, element.rows - done, (len(data) - start) // dtype.itemsize)
        run = np.frombuffer(data, dtype, n, start)
        same = np.ones(n, dtype=bool)
        for k, prop in enumerate(element.properties):
            if prop.length:
                same &= run[f"{k} size"] == sizes[-1][k]
        length = n if same.all() else int(np.argmin(same))
        runs.append(run[:length])
        ahead = 4 * length
        done += length
        start += length * dtype.itemsize
    lengths = list(map(len, runs))
    return {
        prop.name: Column(
            np.concatenate([np.empty(0, prop.type), *(run[str(k)].ravel() for run in runs)]),
            np.repeat([row[k] for row in sizes], lengths).astype(np.int64) if prop.length else None,
        )
        for k, prop in enumerate(element.properties)
    }, start


@lru_cache(1024)
def make_row_dtype(properties: tuple[Property, ...], sizes: tuple[int, ...], order: str) -> np.dtype[Any]:
    fields: list[Any] = []
    for k, (prop, size) in enumerate(zip(properties, sizes, strict=True)):
        fields += [(f"{k} size", order + (prop.length or "V0")), (str(k), order + prop.type, (size,))]
    return np.dtype(fields)


def _read_list_sizes(data: bytes, start: int, element: Element, order: str, i: int) -> tuple[int, ...]:
    """Return the number of values of each property in row `i`, which starts at byte `start`."""
    sizes = []
    for prop in element.properties:
        n = 1
        if prop.length:
            count = np.dtype(order + prop.length)
            n = int(np.frombuffer(data[start : start + count.itemsize].ljust(count.itemsize), count)[0])
            start += count.itemsize
            if start <= len(data) and not 0 <= n <= len(data) - start:
                raise Damaged(f"row {i} of the element {element.name} has a list of {n} values")
        start += abs(n) * np.dtype(prop.type).itemsize
        sizes.append(n)
    if start > len(data):
        raise Damaged(f"it ends in row {i} of the {element.rows} of the element {element.name}")
    return tuple(sizes)
