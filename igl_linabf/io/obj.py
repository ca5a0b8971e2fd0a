"""Read and write OBJ with texture coordinates."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Sequence

import numpy as np

from .._types import FloatArray, IntArray
from ..errors import MeshWarning, some, stack_level
from .parsing import Column, Parsed, fan, indices, numbers, refuse, shown

STATEMENTS = frozenset(
    b"vn vp l p o g s mg usemtl mtllib usemap maplib lod shadow_obj trace_obj bevel c_interp d_interp "
    b"cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con ctech stech call csh".split()
)
# 0 is no index; textures and normals may be left out
CORNER = re.compile(rb"(-?0*[1-9]\d{0,17})(?:/(-?0*[1-9]\d{0,17})?(?:/(?:-?\d{1,18})?)?)?")


def parse_obj(data: bytes, name: str) -> Parsed:
    """The mesh in the bytes of an OBJ file; warns of lines that are not OBJ statements."""
    V: list[float] = []
    TC: list[float] = []
    vertices: list[int] = []
    textures: list[int] = []
    sizes: list[int] = []
    at: list[int] = []  # the line of each polygon
    unknown: list[int] = []
    lines = data.splitlines()
    for line, text in enumerate(lines, 1):
        if b"#" in text:
            text = text.partition(b"#")[0]
        words = text.split()
        if not words:
            continue
        key = words[0]
        if key == b"v":
            values = numbers(words[1:4], 3)
            if not values:
                refuse(line, text, "is no vertex: it takes three numbers")
            V.extend(values)
        elif key == b"f":
            corners, texture = _corners(words[1:], len(V) // 3, len(TC) // 2)
            if len(corners) < 3:
                refuse(line, text, "is no face: it takes three vertex indices or more, from 1 on")
            vertices.extend(corners)
            textures.extend(texture)
            sizes.append(len(corners))
            at.append(line)
        elif key == b"vt":
            values = numbers(words[1:3], 2) or [*numbers(words[1:], 1), 0.0]
            if len(values) < 2:
                refuse(line, text, "is no texture coordinate: it takes two numbers")
            TC.extend(values)
        elif key not in STATEMENTS:
            unknown.append(line)
    n = len(V) // 3
    number = np.array(sizes, dtype=np.int64)
    F, outside = fan(Column(np.array(vertices), number), n)
    if len(outside):
        line = at[outside[0]]
        refuse(line, lines[line - 1], f"names a vertex outside the {n} of the file")
    if unknown and len(F):
        text = lines[unknown[0] - 1].strip()
        warnings.warn(
            f"lines {some(unknown)} of {name} are no statements of OBJ (the first: {shown(text)}): "
            "they are skipped",
            MeshWarning,
            stacklevel=stack_level(),
        )
    FTC, _ = fan(Column(np.array(textures), number), len(TC))
    return Parsed(np.array(V).reshape(-1, 3), F, np.array(TC).reshape(-1, 2), FTC)


def _corners(words: list[bytes], n: int, m: int) -> tuple[list[int], list[int]]:
    """Vertex and texture indices, from 0, of corners `v`, `v/vt`, `v//vn`, `v/vt/vn`; empty if one is wrong.

    A texture index that is not given is -1, one before the first is -2.
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


def save_obj(path: str, V: FloatArray, F: IntArray, TC: FloatArray, FTC: IntArray) -> None:
    """Write triangles; rows of `TC` that are not finite are left out."""
    mapped = np.asarray(np.isfinite(TC).all(axis=1))
    corners = np.stack((F + 1, np.cumsum(mapped)[FTC]), axis=-1).reshape(-1, 6)
    save_polygons(path, V, TC[mapped], corners.tolist())


def save_polygons(path: str, V: FloatArray, TC: FloatArray, corners: Iterable[Sequence[int]]) -> None:
    """Write polygons: of each v, vt, v, vt, ... from 1 on."""
    with open(path, "w", encoding="ascii") as file:  # igl.writeOBJ says nothing of a full disk
        file.write("# igl_linabf\n")
        for keyword, rows in (("v", V), ("vt", TC)):
            file.writelines(f"{keyword} {' '.join(map(repr, row))}\n" for row in rows.tolist())
        file.writelines(f"f{' {}/{}' * (len(row) // 2)}\n".format(*row) for row in corners)
