"""OBJ, OFF, PLY and STL from bytes: what is damaged is refused with its line.

igl's readers end the process on many a damaged PLY or OBJ, and pass over lines they do not know.
"""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np

from ..errors import MeshError, MeshWarning, some, stack_level
from ..surface import FloatArray, IntArray
from .parsing import Damaged, Polygons, fan, indices, numbers, rows_of, shown, table, table_of_polygons
from .ply import parse_ply

FORMATS = (".obj", ".off", ".ply", ".stl")
OBJ_STATEMENTS = frozenset(
    b"vn vp l p o g s mg usemtl mtllib usemap maplib lod shadow_obj trace_obj bevel c_interp d_interp "
    b"cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con ctech stech call csh".split()
)
# 0 is no index; textures and normals may be left out
CORNER = re.compile(rb"(-?0*[1-9]\d{0,17})(?:/(-?0*[1-9]\d{0,17})?(?:/(?:-?\d{1,18})?)?)?")


@dataclass(frozen=True, eq=False)
class Parsed:
    """What a file holds, polygons split into fans of triangles.

    Attributes
    ----------
    V : (#V, 3) float64
    F : (#F, 3) int64
        Within `V`.
    TC : (#TC, 2) float64
        An OBJ's texture coordinates; no rows in the other formats.
    FTC : (#F, 3) int64
        Their indices at the corners as the file has them, -1 where it gives none.
    """

    V: FloatArray
    F: IntArray
    TC: FloatArray
    FTC: IntArray


def parse_file(path: str | os.PathLike[str]) -> Parsed:
    """What is in a file of one of the `FORMATS`; raises as `parse`, and `OSError`."""
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise MeshError(f"{path} is no mesh file that can be read: use {', '.join(FORMATS)}")
    return parse(path.read_bytes(), path.suffix.lower(), str(path))


def parse(data: bytes, suffix: str, name: str) -> Parsed:
    """The mesh in the bytes of a file.

    Parameters
    ----------
    data : bytes
    suffix : {".obj", ".off", ".ply", ".stl"}
    name : str
        What the messages call the file.

    Raises
    ------
    MeshError
        The file is damaged; with the place.

    Warns
    -----
    MeshWarning
        An OBJ has lines that are no statements of that format.
    """
    readers: dict[str, Callable[[bytes], Parsed]] = {
        ".obj": lambda data: _obj(data, name),
        ".off": _off,
        ".ply": lambda data: _untextured(*parse_ply(data)),
        ".stl": _stl,
    }
    try:
        return readers[suffix](data)
    except Damaged as damage:
        raise MeshError(f"{name} cannot be read as {suffix[1:].upper()}: {damage}") from None


def _untextured(V: FloatArray, F: IntArray) -> Parsed:
    return Parsed(V, F, np.empty((0, 2)), np.full(F.shape, -1))


def _refuse(line: int, words: Iterable[bytes], what: str) -> NoReturn:
    raise Damaged(f"line {line}, {shown(b' '.join(words))}, {what}")


def _obj(data: bytes, name: str) -> Parsed:
    V: list[float] = []
    TC: list[float] = []
    polygons, textures = Polygons(), Polygons()
    at: list[int] = []  # the line of each polygon
    unknown: list[int] = []
    lines = data.splitlines()
    for line, text in enumerate(lines, 1):
        words = text.split()
        if not words or words[0][:1] == b"#":
            continue
        if b"#" in text:
            words = text.partition(b"#")[0].split()
        key = words[0]
        if key == b"v":
            values = numbers(words[1:4], 3)
            if not values:
                _refuse(line, words, "is no vertex: it takes three numbers")
            V.extend(values)
        elif key == b"f":
            corners, texture = _corners(words[1:], len(V) // 3, len(TC) // 2)
            if len(corners) < 3:
                _refuse(line, words, "is no face: it takes three vertex indices or more, from 1 on")
            polygons.add(corners)
            textures.add(texture)
            at.append(line)
        elif key == b"vt":
            values = numbers(words[1:3], 2) or [*numbers(words[1:], 1), 0.0]
            if len(values) < 2:
                _refuse(line, words, "is no texture coordinate: it takes two numbers")
            TC.extend(values)
        elif key not in OBJ_STATEMENTS:
            unknown.append(line)
    F, of = fan(*polygons.arrays())
    n = len(V) // 3
    outside = np.flatnonzero(((F < 0) | (n <= F)).any(axis=1))
    if len(outside):
        line = at[of[outside[0]]]
        _refuse(line, lines[line - 1].split(), f"names a vertex outside the {n} of the file")
    if unknown and len(F):
        warnings.warn(
            f"lines {some(unknown)} of {name} are no statements of OBJ (the first: "
            f"{shown(lines[unknown[0] - 1].strip())}): they are passed over",
            MeshWarning,
            stacklevel=stack_level(),
        )
    return Parsed(np.array(V).reshape(-1, 3), F, np.array(TC).reshape(-1, 2), fan(*textures.arrays())[0])


def _corners(words: list[bytes], n: int, m: int) -> tuple[list[int], list[int]]:
    """Vertices and textures of corners `v`, `v/vt`, `v//vn` or `v/vt/vn`, from 0 on; none where one is wrong.

    A texture that is not given is -1, one before the first -2.
    """
    plain = indices(words, len(words))
    if plain and min(plain) > 0:
        return [i - 1 for i in plain], [-1] * len(plain)
    vertices, textures = [], []
    for word in words:
        match = CORNER.fullmatch(word)
        if match is None:
            return [], []
        i, t = int(match[1]), int(match[2] or 0)
        # negative ones count back from the last one so far
        vertices.append(i - 1 if i > 0 else n + i)
        textures.append(t - 1 if t >= 0 else m + t if m + t >= 0 else -2)
    return vertices, textures


def _off(data: bytes) -> Parsed:
    rows, at = rows_of(data, b"#")
    head = rows[0].split() if rows else [b""]
    if not re.fullmatch(rb"(ST)?C?N?OFF", head[0]):
        raise Damaged("it does not begin with OFF, COFF, NOFF or STOFF (text, in three dimensions)")
    first = 1 if len(head) == 1 else 0  # the row of the counts, which may follow at once
    words = rows[first].split()[1 - first :][:2] if first < len(rows) else []
    counts = indices(words, 2)
    if not counts:
        raise Damaged(f"after {head[0].decode()} the numbers of vertices and faces are missing")
    n, m = counts
    rows, at = rows[first + 1 :], at[first + 1 :]
    if len(rows) != n + m:
        raise Damaged(f"its head promises {n} vertices and {m} faces, and {len(rows)} lines follow")
    V = table(rows[:n], 3)
    if V is None:
        V = np.array([_off_vertex(text, line) for text, line in zip(rows[:n], at, strict=False)])
    made = table_of_polygons(rows[n:], exact=False)
    if made is None:
        polygons = Polygons()
        for text, line in zip(rows[n:], at[n:], strict=True):
            words = text.split()
            (size,) = indices(words[:1], 1) or [0]
            polygon = indices(words[1 : 1 + size], size)
            if len(polygon) < 3:
                _refuse(line, words, "is no face: it takes a number from 3 on and as many vertex indices")
            polygons.add(polygon)
        made = polygons.arrays()
    F, of = fan(*made)
    outside = np.flatnonzero(((F < 0) | (n <= F)).any(axis=1))
    if len(outside):
        i = n + of[outside[0]]
        _refuse(at[i], rows[i].split(), f"names a vertex outside 0..{n - 1}")
    return _untextured(V, F)


def _off_vertex(text: bytes, line: int) -> list[float]:
    values = numbers(text.split()[:3], 3)
    if not values:
        _refuse(line, text.split(), "is no vertex: it takes three numbers")
    return values


def _stl(data: bytes) -> Parsed:
    promised = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + 50 * promised:
        rows = np.frombuffer(
            data, [("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("more", "<u2")], offset=84
        )
        V = rows["corner"].astype(np.float64).reshape(-1, 3)
    elif data.lstrip()[:5].lower() == b"solid":
        V = _stl_text(data)
    elif len(data) >= 84:
        follow = (len(data) - 84) / 50
        raise Damaged(f"its head promises {promised} triangles, and {follow:g} follow")
    else:
        raise Damaged(f"its {len(data)} bytes are neither the text nor the binary form")
    bad = np.flatnonzero(~np.isfinite(V).all(axis=1))
    if len(bad):
        raise Damaged(f"triangles {some(np.unique(bad // 3))} have coordinates that are NaN or infinite")
    return _untextured(V, np.arange(len(V)).reshape(-1, 3))


def _stl_text(data: bytes) -> FloatArray:
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
                _refuse(line, words, "is no vertex: it takes three numbers")
            V.extend(values)
        elif key in (b"outer", b"endloop") and (len(V) % 9 or inside == (key == b"outer")):
            _refuse(line, words, "is out of place: three vertices make a loop")
        elif key in (b"outer", b"endloop"):
            inside = key == b"outer"
        elif key not in (b"solid", b"facet", b"endfacet", b"endsolid") or inside:
            _refuse(line, words, "is not understood")
    if inside or words[:1] != [b"endsolid"]:
        raise Damaged(f"it ends in line {line}, without endsolid")
    return np.array(V).reshape(-1, 3)
