"""Read STL, text and binary."""

import warnings
from dataclasses import replace

import igl
import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray
from ..errors import MeshWarning, some, stack_level
from ..surface import Polygons
from .mesh_file import MeshFile
from .parsing import Damaged, Extras, Named, as_text, name_of, numbers, plain_text, refuse

COLOUR = b"COLOR="  # in the title: Magics' colour of the whole, red, green, blue and alpha in a byte each
MATERIAL = b"MATERIAL="  # and how it shines
VALID, LEVELS = (
    0x8000,
    31,
)  # the bit that says whether a triangle has a colour, and the steps of each of three
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("more", "<u2")])
HEAD = np.dtype([("title", "S80"), ("triangles", "<u4")])


def parse_stl(data: bytes) -> MeshFile:
    """The mesh in the bytes of an STL file; corners at equal positions are one vertex."""
    head, extras = HEAD.itemsize, Extras()
    promised = int(np.frombuffer(data[:head].ljust(head, b"\0"), HEAD)["triangles"][0])
    follow, more = divmod(len(data) - head, TRIANGLE.itemsize)
    if follow == promised and (promised or not more):
        if more:
            said = f"{more} bytes follow face {promised - 1}, the last one of the STL file: they are skipped"
            warnings.warn(said, MeshWarning, stacklevel=stack_level())
        table = np.frombuffer(data, TRIANGLE, promised, head)
        V = table["corner"].astype(np.float64).reshape(-1, 3)
        extras = _of_bytes(data[: head - 4], table["more"])
    elif (text := plain_text(data)).lstrip()[:5].lower() == b"solid":
        V, parts = _read_text(text)
        extras = Extras(parts=parts)
    elif len(data) >= head:
        raise Damaged(
            f"its head promises {promised} triangles, and {follow + more / TRIANGLE.itemsize:g} follow"
        )
    else:
        raise Damaged(f"its {len(data)} bytes are neither the text nor the binary form")
    bad = np.flatnonzero(~np.isfinite(V).all(axis=1))
    if len(bad):
        raise Damaged(f"triangles {some(np.unique(bad // 3))} have coordinates that are NaN or infinite")
    F = np.arange(len(V)).reshape(-1, 3)
    if len(V):
        V, _, _, F = igl.remove_duplicate_vertices(V, F, 0.0)
    return MeshFile(V, Polygons.of_triangles(F.astype(np.int64)), extras=extras)


def _of_bytes(title: bytes, more: NDArray[np.uint16]) -> Extras:
    """The title of a binary file, and the colours in two bytes of each triangle, as programs write them.

    VisCAM and SolidView have blue in the lowest bits, and the highest bit set where there is a colour. Magics
    has red there, the bit set where there is none, and a colour of the whole in the title.
    """
    said, magics, rest = title.partition(COLOUR)
    own = (more & VALID > 0) != bool(magics)
    text = b" ".join((said if magics else title).replace(b"\0", b" ").split())
    lost = {
        "attribute bytes of its triangles": not magics and more.any() and not own.any(),
        "MATERIAL= of its title": MATERIAL in rest,
    }
    extras = Extras(
        comments=(as_text(text),) if text else (),
        unshared=tuple(what for what, is_there in lost.items() if is_there),
    )
    if not own.any() and not magics:
        return extras
    whole = np.frombuffer(rest[:4].ljust(4, b"\xff") if magics else b"\xff" * 4, np.uint8) / 255
    colours = np.tile(whole, (len(more), 1))
    shift = np.array([0, 5, 10] if magics else [10, 5, 0], dtype=np.uint16)
    colours[own, :3] = (more[own, None] >> shift & LEVELS) / LEVELS
    return replace(extras, face_colours=colours if whole[3] < 1 else colours[:, :3])


def _read_text(data: bytes) -> tuple[FloatArray, Named | None]:
    """The corners, and the names of the solids, if they have any."""
    V: list[float] = []
    names, starts = list[str](), list[int]()
    inside, line, words = False, 0, [b""]
    for line, text in enumerate(data.splitlines(), 1):
        words = text.split()
        if not words:
            continue
        key = words[0].lower()
        if key == b"vertex" and inside:
            values = numbers(words[1:4], 3)
            if not values:
                refuse(line, text, "is no vertex: it takes three numbers")
            V.extend(values)
        elif key in (b"outer", b"endloop"):
            if len(V) % 9 or inside == (key == b"outer"):
                refuse(line, text, "is out of place: three vertices make a loop")
            inside = not inside
        elif key not in (b"solid", b"facet", b"endfacet", b"endsolid") or inside:
            refuse(line, text, "is not understood")
        elif key == b"solid":
            names.append(as_text(name_of(text.strip())))
            starts.append(len(V) // 9)
    if inside or [word.lower() for word in words[:1]] != [b"endsolid"]:
        raise Damaged(f"it ends in line {line}, without endsolid")
    corners = np.array(V).reshape(-1, 3)
    sizes = np.diff([*starts, len(corners) // 3])
    parts = tuple(names), np.repeat(np.arange(len(names)), sizes)
    return corners, parts if any(names) else None
