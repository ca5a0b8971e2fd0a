"""Read text and binary STL files."""

import warnings
from dataclasses import replace

import igl
import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray
from ..errors import MeshWarning, first_few, format_count, stack_level
from ..surface import Polygons
from .mesh_file import MeshFile
from .parsing import (
    Damaged,
    Extras,
    FaceLabels,
    convert_to_utf8,
    decode_utf8,
    parse_name,
    parse_numbers,
    raise_damaged_line,
)

COLOUR_TAG = b"COLOR="  # precedes the body colour that Magics writes into the title: 4 bytes RGBA
MATERIAL_TAG = b"MATERIAL="  # precedes the material that Magics writes into the title
COLOUR_FLAG = 0x8000  # attribute bit that indicates whether a triangle has its own colour
MAX_LEVEL = 31  # largest value of a colour component, which has five attribute bits
TRIANGLE_DTYPE = np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("more", "<u2")])
HEADER_DTYPE = np.dtype([("title", "S80"), ("triangles", "<u4")])


def parse_stl(data: bytes) -> MeshFile:
    """Parse the mesh from the bytes of an STL file; corners at equal positions become one vertex."""
    header_size, extras = HEADER_DTYPE.itemsize, Extras()
    declared = int(np.frombuffer(data[:header_size].ljust(header_size, b"\0"), HEADER_DTYPE)["triangles"][0])
    count, remainder = divmod(len(data) - header_size, TRIANGLE_DTYPE.itemsize)
    if count == declared and (declared or not remainder):
        if remainder:
            warnings.warn(
                f"{remainder} bytes follow face {declared - 1}, the last face of the STL file: they are "
                "skipped",
                MeshWarning,
                stacklevel=stack_level(),
            )
        table = np.frombuffer(data, TRIANGLE_DTYPE, declared, header_size)
        with np.errstate(invalid="ignore"):  # converting a signalling NaN would warn
            V = table["corner"].astype(np.float64).reshape(-1, 3)
        extras = _parse_binary_extras(data[: header_size - 4], table["more"])
    elif (text := convert_to_utf8(data)).lstrip()[:5].lower() == b"solid":
        V, parts = _parse_text(text)
        extras = Extras(parts=parts)
    elif len(data) >= header_size:
        follow = count + remainder / TRIANGLE_DTYPE.itemsize
        raise Damaged(f"its header declares {format_count(declared, 'triangle')}, but {follow:g} follow")
    else:
        raise Damaged(f"its {len(data)} bytes are neither text nor binary STL")
    bad = np.flatnonzero(~np.isfinite(V).all(axis=1))
    if len(bad):
        raise Damaged(f"triangles {first_few(np.unique(bad // 3))} have coordinates that are NaN or infinite")
    F = np.arange(len(V)).reshape(-1, 3)
    if len(V):
        V, _, _, F = igl.remove_duplicate_vertices(V, F, 0.0)
    return MeshFile(V, Polygons.from_triangles(F.astype(np.int64)), extras=extras)


def _parse_binary_extras(title: bytes, attributes: NDArray[np.uint16]) -> Extras:
    """Return the title of a binary file, and the colours in the two attribute bytes of each triangle.

    VisCAM and SolidView store blue in the lowest bits, and set the highest bit for triangles with a colour.
    Magics stores red in the lowest bits, clears the highest bit for triangles with a colour, and stores the
    colour of all other triangles in the title.
    """
    before_tag, is_magics, after_tag = title.partition(COLOUR_TAG)
    has_own_colour = (attributes & COLOUR_FLAG > 0) != bool(is_magics)
    text = b" ".join((before_tag if is_magics else title).replace(b"\0", b" ").split())
    lost = {
        "attribute bytes of its triangles": not is_magics and attributes.any() and not has_own_colour.any(),
        "MATERIAL= of its title": MATERIAL_TAG in after_tag,
    }
    extras = Extras(
        comments=(decode_utf8(text),) if text else (),
        unshared=tuple(what for what, is_there in lost.items() if is_there),
    )
    if not has_own_colour.any() and not is_magics:
        return extras
    body_colour = np.frombuffer(after_tag[:4].ljust(4, b"\xff") if is_magics else b"\xff" * 4, np.uint8) / 255
    colours = np.tile(body_colour, (len(attributes), 1))
    shift = np.array([0, 5, 10] if is_magics else [10, 5, 0], dtype=np.uint16)
    colours[has_own_colour, :3] = (attributes[has_own_colour, None] >> shift & MAX_LEVEL) / MAX_LEVEL
    return replace(extras, face_colours=colours if body_colour[3] < 1 else colours[:, :3])


def _parse_text(data: bytes) -> tuple[FloatArray, FaceLabels | None]:
    """Return the triangle corners of a text STL file, and the names of its solids if any has a name."""
    V: list[float] = []
    names, starts = list[str](), list[int]()
    inside, line, words = False, 0, [b""]
    for line, text in enumerate(data.splitlines(), 1):
        words = text.split()
        if not words:
            continue
        key = words[0].lower()
        if key == b"vertex" and inside:
            values = parse_numbers(words[1:4], 3)
            if not values:
                raise_damaged_line(line, text, "is not a vertex: it needs three numbers")
            V.extend(values)
        elif key in (b"outer", b"endloop"):
            if len(V) % 9 or inside == (key == b"outer"):
                raise_damaged_line(line, text, "is out of place: a loop has three vertices")
            inside = not inside
        elif key not in (b"solid", b"facet", b"endfacet", b"endsolid") or inside:
            raise_damaged_line(line, text, "is not understood")
        elif key == b"solid":
            names.append(decode_utf8(parse_name(text.strip())))
            starts.append(len(V) // 9)
    if inside or [word.lower() for word in words[:1]] != [b"endsolid"]:
        raise Damaged(f"it ends in line {line}, without endsolid")
    corners = np.array(V).reshape(-1, 3)
    sizes = np.diff([*starts, len(corners) // 3])
    parts = tuple(names), np.repeat(np.arange(len(names)), sizes)
    return corners, parts if any(names) else None
