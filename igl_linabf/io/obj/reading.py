"""Read OBJ: positions with colours, texture coordinates, normals, polygons, groups and materials.

Lines of one form are read at once by numpy; only if that fails they are read one by one, so that the damaged
line can be named.
"""

import contextlib
import os
import re
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..._runtime import advance
from ..._types import FloatArray, IntArray
from ...errors import MeshWarning, some, stack_level
from ...surface import Polygons
from ..materials import Material, library
from ..mesh_file import MeshFile
from ..parsing import SPACE, Damaged, Extras, Named, as_text, name_of, numbers, printable, refuse
from ..references import named_file
from .maps import with_maps

STATEMENTS = frozenset(
    b"v vt vn f vp l p o g s mg usemtl mtllib usemap maplib lod shadow_obj trace_obj bevel c_interp d_interp "
    b"cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con ctech stech call csh".split()
)
LIBRARY = b"mtllib"
LIBRARY_NAME = re.compile(r'"([^"]*)"|(\S.*?\.(?:mtl|map))(?=\s|$)|(\S+)', re.IGNORECASE)
NAMED = (b"o", b"g", b"usemtl", LIBRARY)  # whose names may have a # in them
# what only OBJ has, by the words that a warning has for it
UNSHARED = {
    "polylines (l)": b"l",
    "points (p)": b"p",
    "free-form curves and surfaces": b"vp cstype deg bmat step curv curv2 surf parm trim hole scrv sp con",
    "display attributes": b"bevel c_interp d_interp lod shadow_obj trace_obj ctech stech",
    "texture maps (usemap)": b"usemap maplib",
    "calls of other files": b"call csh",
}
PAINT = b"#MRGB"  # ZBrush's colours of vertices, as comments: a mask, red, green and blue in eight digits
NO_LINES: IntArray = np.zeros(0, dtype=np.int64)
# 0 is no index; textures and normals may be left out
CORNER = re.compile(rb"(-?0*[1-9]\d{0,17})(?:/(-?0*[1-9]\d{0,17})?(?:/(-?\d{1,18})?)?)?")
FORMS = {b"": (0,), b"/": (0, 1), b"//": (0, 1, 2), b"!": (0, 2)}  # v, v/vt, v/vt/vn, v//vn without digits
# Forms of face lines (numbers of corners, with or without vt and vn) up to which the lines of a form are read
# at once. With fewer, common files are read line by line, which takes much longer; with more, many short
# tables are made. No result depends on it (tests/io/test_formats.py).
MOST_LINE_FORMS = 50
SEPARATED = bytes.maketrans(b"/!", b"  ")
NO_VERTEX = "is no vertex: it takes three numbers"
NO_TEXTURE = "is no texture coordinate: it takes two numbers"
NO_NORMAL = "is no normal: it takes three numbers"
NO_FACE = "is no face: it takes three vertex indices or more, from 1 on"


@dataclass(frozen=True, eq=False)
class ObjText:
    """The file itself.

    Attributes
    ----------
    lines : list of bytes
    faces : (#F,) int64
        The line of each face, from 0.
    """

    lines: list[bytes]
    faces: IntArray


def parse_obj(data: bytes, name: str) -> MeshFile:
    """The mesh in the bytes of an OBJ file; warns of lines that are not OBJ statements."""
    raw = _continued_lines(data.splitlines()) if b"\\" in data else data.splitlines()
    lines = _without_comments(data, raw)
    where = _by_statement(lines)
    advance("reading", 0.2)
    V, colours, further = _vertices(lines, where[b"v"])
    advance("reading", 0.4)
    TC = _statement_numbers(lines, where[b"vt"], (2, 1), NO_TEXTURE)[:, :2]
    TC = np.pad(TC, ((0, 0), (0, 2 - TC.shape[1])))
    normals = _statement_numbers(lines, where[b"vn"], (3,), NO_NORMAL)[:, :3]
    index, sizes = _faces(lines, where)
    advance("reading", 0.8)
    n = len(V)
    polygons = Polygons(index[:, 0], sizes)
    bad = polygons.outside(n)
    if len(bad):
        line = where[b"f"][bad[0]]
        refuse(int(line) + 1, raw[line], f"names a vertex outside the {n} of the file")
    unknown = sorted(line for key in where.keys() - STATEMENTS for line in where[key].tolist())
    if unknown and len(sizes):
        warnings.warn(
            f"lines {some(np.array(unknown) + 1)} of {name} are no statements of OBJ (the first: "
            f"{printable(raw[unknown[0]])}): they are skipped",
            MeshWarning,
            stacklevel=stack_level(),
        )
    own_normals = bool(len(normals)) and ((index[:, 2] >= 0) & (index[:, 2] < len(normals))).all()
    painted, comments = _comments(raw, where) if b"#" in data else ([], ())
    if colours is None:
        colours = _painted_colours(painted, n)
    extras = Extras(
        colours=colours,
        normals=normals if own_normals else None,
        normal=index[:, 2] if own_normals else None,
        parts=_names_of_faces(raw, where, b"o" if b"o" in where else b"g", where[b"f"]),
        materials=_names_of_faces(raw, where, b"usemtl", where[b"f"]),
        comments=comments,
        unshared=(
            *_unshared(lines, where, bool(len(normals)), bool(own_normals)),
            *(["numbers after the positions of its vertices"] * further),
        ),
        source=ObjText(raw, where[b"f"]),
    )
    return MeshFile(V, polygons, TC, index[:, 1], extras)


def _unshared(
    lines: list[bytes], where: dict[bytes, IntArray], has_normals: bool, own_normals: bool
) -> tuple[str, ...]:
    """What no other format takes."""
    found = [what for what, words in UNSHARED.items() if any(word in where for word in words.split())]
    if b"o" in where and b"g" in where:
        found.append("groups (g) under its objects")
    flat = [[b"s", b"off"], [b"s", b"0"]]
    smooth = any(lines[i].split() not in flat for key in (b"s", b"mg") for i in where.get(key, ()))
    if smooth and not own_normals:  # normals say what is smooth
        found.append("smoothing groups (s)")
    if has_normals and not own_normals:
        found.append("normals, which not all corners have")
    return tuple(found)


def _comments(raw: list[bytes], where: dict[bytes, IntArray]) -> tuple[list[bytes], tuple[str, ...]]:
    """Painted colours, and all other comments."""
    names = {i for key in NAMED for i in where.get(key, NO_LINES).tolist()}
    found = [
        line[line.index(b"#") :].strip() for i, line in enumerate(raw) if b"#" in line and i not in names
    ]
    painted = [line[len(PAINT) :].strip() for line in found if line.startswith(PAINT)]
    others = [line.lstrip(b"#").strip() for line in found if not line.startswith(PAINT)]
    return painted, tuple(as_text(line) for line in others if line)


def _painted_colours(painted: list[bytes], n: int) -> FloatArray | None:
    """ZBrush's colours, if there are as many as vertices."""
    try:
        values = np.frombuffer(bytes.fromhex(b"".join(painted).decode("latin-1")), dtype=np.uint8)
    except ValueError:
        return None
    return values.reshape(n, 4)[:, 1:] / 255 if n and len(values) == 4 * n else None


def library_names(line: bytes, folder: Path) -> list[str]:
    """The files that a `mtllib` or `maplib` line names: one whose name has blanks, or several."""
    whole = os.fsdecode(name_of(line))
    if named_file(whole, folder):
        return [whole]
    return [next(filter(None, match.groups()), "") for match in LIBRARY_NAME.finditer(whole)]


def with_looks(extras: Extras, path: Path) -> Extras:
    """With what the libraries say that an OBJ file names; one that is missing says nothing."""
    text = extras.source
    if extras.materials is None or not isinstance(text, ObjText):
        return extras
    known: dict[str, Material] = {}
    for line in text.lines:
        if line.split(None, 1)[:1] != [LIBRARY]:
            continue
        for name in library_names(line, path.parent):
            place = named_file(name, path.parent)
            if place is not None:
                with contextlib.suppress(OSError, Damaged):
                    own = {name: with_maps(look, place.parent) for name, look in library(place).items()}
                    known = own | known  # the first one counts
    if not known:
        return extras
    names = extras.materials[0]  # a comment may follow
    looks = [known.get(name) or known.get(name.partition(" #")[0].rstrip()) for name in names]
    return replace(extras, looks=tuple(look or Material() for look in looks))


def _continued_lines(lines: list[bytes]) -> list[bytes]:
    """Lines that end with a backslash go on in the next one, of which an empty line is left."""
    made = [*lines, b""]
    for i in reversed(range(len(lines))):
        text = made[i].rstrip()
        if text.endswith(b"\\") and b"#" not in text:
            made[i], made[i + 1] = text[:-1] + b" " + made[i + 1], b""
    return made[:-1]


def _without_comments(data: bytes, lines: list[bytes]) -> list[bytes]:
    """The lines without comments, their words one space apart."""
    if b"#" in data:
        lines = [text.partition(b"#")[0] if b"#" in text else text for text in lines]
    if _has_loose_blanks(data):
        return [b" ".join(text.split()) for text in lines]
    return [*map(bytes.strip, lines)] if b"#" in data or data[:1] == b" " else lines


def _has_loose_blanks(data: bytes) -> bool:
    """Whether there are tabs, or spaces beside spaces or at the ends of lines."""
    if b"\t" in data:
        return True
    text = np.frombuffer(data, dtype=np.uint8)
    space, blank = text == SPACE, text <= SPACE
    return bool((space[1:] & blank[:-1]).any() or (blank[1:] & space[:-1]).any())


def _by_statement(lines: list[bytes]) -> dict[bytes, IntArray]:
    """The lines of each keyword, from 0."""
    head = np.array(lines, dtype="S3").view(np.uint8).reshape(-1, 3).T  # the first three bytes of each
    rest, where = head[0] > 0, dict[bytes, IntArray]()
    for key in (b"v", b"vt", b"vn", b"f"):
        found = np.logical_and.reduce([row == code for row, code in zip(head, key + b" ", strict=False)])
        where[key] = np.flatnonzero(found)
        rest &= ~found
    others: dict[bytes, list[int]] = {}
    for i in np.flatnonzero(rest).tolist():
        others.setdefault(lines[i].partition(b" ")[0], []).append(i)
    for key, own in others.items():
        where[key] = np.sort(np.append(where.get(key, NO_LINES), own))
    return where


def _vertices(lines: list[bytes], at: IntArray) -> tuple[FloatArray, FloatArray | None, bool]:
    """Positions, the colours that follow them in some files, and whether more follows that is not 1.

    Colours are from 0 to 1, or whole numbers to 255; vertices without are white.
    """
    table = _statement_numbers(lines, at, (7, 6, 4, 3), NO_VERTEX, 1.0)
    colours = table[:, 3:7] if table.shape[1] in (6, 7) else None
    if colours is not None and colours.max(initial=0) > 1 and not (colours % 1).any():
        colours = colours / 255
    further = table[:, 3:] if colours is None else table[:, 7:]
    return np.ascontiguousarray(table[:, :3]), colours, bool((further != 1).any())


def _statement_numbers(
    lines: list[bytes], at: IntArray, counts: tuple[int, ...], what: str, lacking: float = 0.0
) -> FloatArray:
    """The numbers of the lines, of which each has one of these counts or more, the largest first."""
    if not len(at):
        return np.empty((0, 3))
    rows = [lines[i].partition(b" ")[2] for i in at.tolist()]
    if any(row.strip() for row in rows):
        with contextlib.suppress(ValueError):
            table = np.loadtxt(rows, ndmin=2, comments=None)
            if len(table) == len(at) and table.shape[1] >= counts[-1]:
                return table
    values = []
    for row, i in zip(rows, at.tolist(), strict=True):
        words = row.split()
        values.append(next((v for k in counts if (v := numbers(words[:k], k))), []))
        if not values[-1]:
            refuse(i + 1, lines[i], what)
    filled = np.full((len(at), max(map(len, values))), lacking)
    for own, given in zip(filled, values, strict=True):
        own[: len(given)] = given
    return filled


def _faces(lines: list[bytes], at: dict[bytes, IntArray]) -> tuple[IntArray, IntArray]:
    """Vertex, texture and normal indices from 0 at the corners, (#C, 3), and the sizes of the faces.

    An index that is not given is -1; a texture or normal before the first is -2.
    """
    texts = [lines[i][2:] for i in at[b"f"].tolist()]
    index, sizes = _faces_by_form(texts) or _faces_line_by_line(texts, lines, at[b"f"])
    line = np.repeat(at[b"f"], sizes)
    for column, key in enumerate((b"v", b"vt", b"vn")):
        values = index[:, column]
        back = np.flatnonzero(values < 0)
        values -= values >= 0
        if len(back):  # counted back from the last one so far; -1 is what is not given
            so_far = np.searchsorted(at[key], line[back])
            values[back] = np.where(so_far + values[back] < 0, -2, so_far + values[back])
    return index, sizes


def _faces_by_form(texts: list[bytes]) -> tuple[IntArray, IntArray] | None:
    """The faces, if there are only a few forms of lines; None if one of them is damaged."""
    whole = b"\n".join(texts)
    if b"!" in whole:
        return None
    whole = whole.replace(b"//", b"!")
    forms = whole.translate(None, b"0123456789-").split(b"\n")
    texts = whole.translate(SEPARATED).split(b"\n")
    different = {form: i for i, form in enumerate(dict.fromkeys(forms))}
    if len(different) > MOST_LINE_FORMS:
        return None
    of = np.array([different[form] for form in forms], dtype=np.int64)
    words = [form.split(b" ") for form in different]
    if any(len(set(row)) > 1 or row[0] not in FORMS or len(row) < 3 for row in words):
        return None
    sizes = np.array([len(row) for row in words], dtype=np.int64)[of] if words else of
    index, starts = np.zeros((int(sizes.sum()), 3), dtype=np.int64), np.cumsum(sizes) - sizes
    for i, row in enumerate(words):
        rows, columns = np.flatnonzero(of == i), FORMS[row[0]]
        own = texts if len(words) == 1 else [texts[k] for k in rows.tolist()]
        try:
            table = np.loadtxt(own, dtype=np.int64, ndmin=2, comments=None)
        except (ValueError, OverflowError):
            return None
        if table.shape != (len(rows), len(row) * len(columns)) or (table == 0).any():
            return None
        corners = (starts[rows, None] + np.arange(len(row))).ravel()
        index[corners[:, None], columns] = table.reshape(-1, len(columns))
    return index, sizes


def _faces_line_by_line(texts: list[bytes], lines: list[bytes], at: IntArray) -> tuple[IntArray, IntArray]:
    index: list[tuple[int, int, int]] = []
    sizes = []
    for text, line in zip(texts, at.tolist(), strict=True):
        matches = [CORNER.fullmatch(word) for word in text.split()]
        if len(matches) < 3 or None in matches:
            refuse(line + 1, lines[line], NO_FACE)
        index += [(int(m[1]), int(m[2] or 0), int(m[3] or 0)) for m in matches if m is not None]
        sizes.append(len(matches))
    return np.array(index, dtype=np.int64).reshape(-1, 3), np.array(sizes, dtype=np.int64)


def _names_of_faces(
    raw: list[bytes], where: dict[bytes, IntArray], key: bytes, faces: IntArray
) -> Named | None:
    """Names that statements before the faces give them, and the name's number of each face; -1: none.

    Bytes that are not UTF-8 stay what they are, as in Python's names of files.
    """
    at = where.get(key)
    if at is None:
        return None
    given = [as_text(name_of(raw[i])) for i in at.tolist()]
    names = {name: i for i, name in enumerate(dict.fromkeys(given))}
    number = np.array([-1, *(names[name] for name in given)], dtype=np.int64)
    return tuple(names), number[np.searchsorted(at, faces)]
