"""Read STL, text and binary."""

import warnings

import igl
import numpy as np

from .._types import FloatArray
from ..errors import MeshWarning, some, stack_level
from ..surface import Polygons
from .mesh_file import MeshFile
from .parsing import Damaged, numbers, plain_text, refuse

TRIANGLE = np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("more", "<u2")])
HEAD = np.dtype([("title", "S80"), ("triangles", "<u4")])


def parse_stl(data: bytes) -> MeshFile:
    """The mesh in the bytes of an STL file; corners at equal positions are one vertex."""
    head = HEAD.itemsize
    promised = int(np.frombuffer(data[:head].ljust(head, b"\0"), HEAD)["triangles"][0])
    follow, more = divmod(len(data) - head, TRIANGLE.itemsize)
    if follow == promised and (promised or not more):
        if more:
            said = f"{more} bytes follow face {promised - 1}, the last one of the STL file: they are skipped"
            warnings.warn(said, MeshWarning, stacklevel=stack_level())
        V = np.frombuffer(data, TRIANGLE, promised, head)["corner"].astype(np.float64).reshape(-1, 3)
    elif (text := plain_text(data)).lstrip()[:5].lower() == b"solid":
        V = _read_text(text)
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
    return MeshFile(V, Polygons.of_triangles(F.astype(np.int64)))


def _read_text(data: bytes) -> FloatArray:
    V: list[float] = []
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
    if inside or [word.lower() for word in words[:1]] != [b"endsolid"]:
        raise Damaged(f"it ends in line {line}, without endsolid")
    return np.array(V).reshape(-1, 3)
