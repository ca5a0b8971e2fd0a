"""Read text OFF files with the normals, colours and texture coordinates of NOFF, COFF and STOFF."""

import re
from contextlib import suppress
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .._types import FloatArray
from ..errors import format_count
from .mesh_file import MeshFile
from .parsing import (
    SPACE,
    Damaged,
    Extras,
    Property,
    decode_utf8,
    make_polygons,
    parse_indices,
    parse_table,
    raise_damaged_line,
    split_rows,
)

FACE_PROPERTIES = (Property("corners", "i4", "i4"),)
MAX_CORNER_COUNT_DIGITS = 9  # digits of a face's corner count; Python refuses to convert thousands of digits
INVALID_FACE = "is not a face: it needs a number of corners, at least 3, and this number of vertex indices"
INVALID_VERTEX = "is not a vertex: it needs three numbers"
DEFAULT_FACE_COLOUR = 170 / 255  # Geomview's grey for faces without a colour


class VertexData(NamedTuple):
    """The values after the positions in the vertex lines of an OFF file."""

    normals: FloatArray | None
    colours: FloatArray | None
    TC: FloatArray | None
    unknown: bool


def parse_off(data: bytes) -> MeshFile:
    """Parse the mesh from the bytes of an OFF file."""
    rows, line_numbers = split_rows(data, b"#")
    rows[:1] = [re.sub(rb"OFF(?=\d)", b"OFF ", row, count=1) for row in rows[:1]]  # OFF without a space
    head = rows[0].split() if rows else [b""]
    if not re.fullmatch(rb"(ST|C|N)*OFF", head[0]):
        raise Damaged("it does not begin with OFF, COFF, NOFF or STOFF (text, in three dimensions)")
    if head[1:] == [b"BINARY"]:
        raise Damaged("it is a binary OFF: export it as text, or as PLY, from the program that wrote it")
    first = 1 if len(head) == 1 else 0  # counts may follow OFF on the first line
    words = rows[first].split()[1 - first :][:2] if first < len(rows) else []
    counts = parse_indices(words, 2)
    if not counts:
        raise Damaged(f"after {head[0].decode()} the numbers of vertices and faces are missing")
    n, m = counts
    rows, line_numbers = rows[first + 1 :], line_numbers[first + 1 :]
    if len(rows) != n + m and head[0] == b"OFF":
        rows, line_numbers = _group_words_by_row(rows, line_numbers, n, m)
    if len(rows) != n + m:
        raise Damaged(
            f"its header declares {format_count(n, 'vertex')} and {format_count(m, 'face')}, but "
            f"{len(rows)} lines follow: correct the "
            "header if no line is missing"
        )
    V, vertex_data = _parse_vertices(rows[:n], line_numbers[:n], head[0])
    rows, line_numbers = rows[n:], line_numbers[n:]
    polygons = parse_table(rows, line_numbers, FACE_PROPERTIES, INVALID_FACE)["corners"]
    for i in np.flatnonzero(np.asarray(polygons.sizes) < 3)[:1]:
        raise_damaged_line(line_numbers[i], rows[i], INVALID_FACE)
    faces = make_polygons(polygons)
    for i in faces.find_out_of_range(n)[:1]:
        raise_damaged_line(line_numbers[i], rows[i], f"refers to a vertex outside 0..{n - 1}")
    face_colours, other = _parse_face_colours(rows, faces.sizes.tolist())
    lost = {
        "numbers after the positions of its vertices": vertex_data.unknown,
        "numbers after the corners of its faces": other,
    }
    comments = map(bytes.strip, re.findall(rb"#([^\r\n]*)", data))
    extras = Extras(
        colours=vertex_data.colours,
        normals=vertex_data.normals,
        normal=None if vertex_data.normals is None else faces.corners,
        face_colours=face_colours,
        comments=tuple(decode_utf8(line) for line in comments if line),
        unshared=tuple(what for what, is_there in lost.items() if is_there),
    )
    return MeshFile(V, faces, vertex_data.TC, None if vertex_data.TC is None else faces.corners, extras)


def _parse_vertices(rows: list[bytes], line_numbers: list[int], head: bytes) -> tuple[FloatArray, VertexData]:
    """Return the positions, and the normals, colours and texture coordinates that the header declares."""
    width = len(rows[0].split()) if rows else 3
    has_normals, has_colours, has_texture = (key in head.replace(b"OFF", b"") for key in (b"N", b"C", b"ST"))
    colour_width = width - 3 * (1 + has_normals) - 2 * has_texture  # components per colour
    is_consistent = colour_width in (3, 4) if has_colours else colour_width == 0
    numbers = np.empty((0, 0))
    if is_consistent and width > 3:
        with suppress(Damaged):  # ignore extra values unless all vertices have them
            numbers = _parse_columns(rows, line_numbers, width)
    if not numbers.size:
        return _parse_columns(rows, line_numbers, 3), VertexData(None, None, None, unknown=width > 3)
    V, *parts = np.split(numbers, np.cumsum([3, 3 * has_normals, colour_width * has_colours]), axis=1)
    normals, colours, TC = parts
    return V, VertexData(
        normals if has_normals else None,
        _scale_to_unit(colours) if has_colours else None,
        TC if has_texture else None,
        unknown=False,
    )


def _parse_columns(rows: list[bytes], line_numbers: list[int], width: int) -> FloatArray:
    names = list(map(str, range(width)))
    table = parse_table(rows, line_numbers, [Property(name, "f8") for name in names], INVALID_VERTEX)
    return np.column_stack([table[name].values for name in names])


def _scale_to_unit(colours: FloatArray) -> FloatArray:
    """Convert colours to the range 0 to 1, from fractions or from integers up to 255."""
    return colours / 255 if colours.max(initial=0) > 1 else colours


def _parse_face_colours(rows: list[bytes], sizes: list[int]) -> tuple[FloatArray | None, bool]:
    """Return the colours at the ends of face lines, and whether any line ends with other values."""
    blank = np.frombuffer(b"\n".join([b"", *rows]), dtype=np.uint8) <= SPACE
    if np.count_nonzero(blank[:-1] & ~blank[1:]) == sum(sizes) + len(sizes):  # no words after the indices
        return None, False
    colours, other = np.full((len(rows), 4), np.nan), False
    for colour, row, k in zip(colours, rows, sizes, strict=True):
        words = row.split()[1 + k :]
        try:
            values = list(map(float, words))
        except ValueError:
            values = [0.0]
        if len(values) in (3, 4):
            colour[:] = values if len(values) == 4 else [*values, np.inf]
        else:
            other |= bool(values)  # values other than colours, such as an index into a colour map
    given = colours[~np.isnan(colours[:, 0])]
    if not len(given):
        return None, other
    opaque = np.isinf(given[:, 3])
    given[opaque, 3] = 255 if given[:, :3].max() > 1 else 1
    filled = np.full(colours.shape, DEFAULT_FACE_COLOUR)
    filled[:, 3] = 1
    filled[~np.isnan(colours[:, 0])] = _scale_to_unit(given)
    return filled if not opaque.all() else filled[:, :3], other


def _group_words_by_row(
    rows: list[bytes], line_numbers: list[int], n: int, m: int
) -> tuple[list[bytes], list[int]]:
    """Return one row per vertex and per face, even if a vertex or a face spans several lines of the file."""
    words = [(word, line) for row, line in zip(rows, line_numbers, strict=True) for word in row.split()]
    if len(words) < 3 * n + m:
        return rows, line_numbers
    starts = list(range(0, 3 * n + 1, 3))
    for _ in range(m):
        size = words[starts[-1]][0] if starts[-1] < len(words) else b""
        if not size.isdigit() or len(size) > MAX_CORNER_COUNT_DIGITS or int(size) > len(words):
            return rows, line_numbers
        starts.append(starts[-1] + 1 + int(size))
    if starts[-1] != len(words):
        return rows, line_numbers
    joined = [b" ".join(word for word, _ in words[i:j]) for i, j in pairwise(starts)]
    return joined, [words[i][1] for i in starts[:-1]]
