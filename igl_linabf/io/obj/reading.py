"""Read OBJ: positions with colours, texture coordinates, normals, polygons, groups and materials.

NumPy parses all lines of the same form together. If this fails, the lines are parsed one by one to find the
damaged line.
"""

import contextlib
import os
import re
import warnings
from dataclasses import dataclass, replace

import numpy as np

from ..._runtime import advance
from ..._types import FloatArray, IntArray
from ...errors import MeshWarning, first_few, format_count, stack_level
from ...surface import Polygons
from ..materials import Material, read_library
from ..mesh_file import MeshFile
from ..parsing import (
    SPACE,
    Damaged,
    Extras,
    FaceLabels,
    decode_utf8,
    parse_name,
    parse_numbers,
    quote_line,
    raise_damaged_line,
)
from ..references import REMEDY, Folder
from .maps import attach_maps

STATEMENTS = frozenset(
    b"v vt vn f vp l p o g s mg usemtl mtllib usemap maplib lod shadow_obj trace_obj bevel c_interp d_interp "
    b"cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con ctech stech call csh".split()
)
LIBRARY_KEYWORD = b"mtllib"
LIBRARY_NAME_PATTERN = re.compile(r'"([^"]*)"|(\S.*?\.(?:mtl|map))(?=\s|$)|(\S+)', re.IGNORECASE)
NAMING_KEYWORDS = (b"o", b"g", b"usemtl", LIBRARY_KEYWORD)  # statements whose names may contain #
# OBJ statements without a counterpart in other formats; the keys are their descriptions in warnings.
OBJ_ONLY_STATEMENTS = {
    "polylines (l)": b"l",
    "points (p)": b"p",
    "free-form curves and surfaces": b"vp cstype deg bmat step curv curv2 surf parm trim hole scrv sp con",
    "display attributes": b"bevel c_interp d_interp lod shadow_obj trace_obj ctech stech",
    "texture maps (usemap)": b"usemap maplib",
    "calls of other files": b"call csh",
}
POLYPAINT_PREFIX = b"#MRGB"  # comment with ZBrush's vertex colours: mask, red, green and blue in eight digits
NO_LINES: IntArray = np.zeros(0, dtype=np.int64)
# A corner v/vt/vn of a face: v and vt are not 0; vt and vn are optional.
CORNER_PATTERN = re.compile(rb"(-?0*[1-9]\d{0,17})(?:/(-?0*[1-9]\d{0,17})?(?:/(-?\d{1,18})?)?)?")
# Columns of v, vt and vn in v, v/vt, v/vt/vn and v//vn, by their slashes; two adjacent slashes count as "!".
COLUMNS_OF_FORM = {b"": (0,), b"/": (0, 1), b"//": (0, 1, 2), b"!": (0, 2)}
MAX_LINE_FORMS = 50  # with more forms of face lines, the lines are parsed one by one
SEPARATORS_TO_SPACES = bytes.maketrans(b"/!", b"  ")
INVALID_VERTEX = "is not a vertex: it needs three numbers"
INVALID_TEXTURE = "is not a texture coordinate: it needs two numbers"
INVALID_NORMAL = "is not a normal: it needs three numbers"
INVALID_FACE = "is not a face: it needs at least three vertex indices, counted from 1"


@dataclass(frozen=True, eq=False)
class ObjText:
    """The lines of an OBJ file, which a new OBJ file reproduces.

    Attributes
    ----------
    lines : list of bytes
    faces : (#F,) int64
        The line of each face, counted from 0.
    """

    lines: list[bytes]
    faces: IntArray


def parse_obj(data: bytes, name: str) -> MeshFile:
    """Parse the mesh from the bytes of an OBJ file; warn of lines that are not OBJ statements."""
    raw = _join_continued_lines(data.splitlines()) if b"\\" in data else data.splitlines()
    lines = _strip_comments(data, raw)
    where = _group_by_statement(lines)
    advance("reading", 0.2)
    V, colours, has_extra = _parse_vertices(lines, where[b"v"])
    advance("reading", 0.4)
    TC = _parse_statement_numbers(lines, where[b"vt"], (2, 1), INVALID_TEXTURE)[:, :2]
    TC = np.pad(TC, ((0, 0), (0, 2 - TC.shape[1])))
    normals = _parse_statement_numbers(lines, where[b"vn"], (3,), INVALID_NORMAL)[:, :3]
    index, sizes = _parse_faces(lines, where)
    advance("reading", 0.8)
    n = len(V)
    polygons = Polygons(index[:, 0], sizes)
    outside = polygons.find_out_of_range(n)
    if len(outside):
        line = where[b"f"][outside[0]]
        raise_damaged_line(
            int(line) + 1,
            raw[line],
            f"refers to a vertex outside the {format_count(n, 'vertex')} of the file",
        )
    unknown = sorted(line for key in where.keys() - STATEMENTS for line in where[key].tolist())
    if unknown and len(sizes):
        warnings.warn(
            f"lines {first_few(np.array(unknown) + 1)} of {name} are not OBJ statements (the first: "
            f"{quote_line(raw[unknown[0]])}): they are skipped",
            MeshWarning,
            stacklevel=stack_level(),
        )
    has_all_normals = bool(len(normals)) and ((index[:, 2] >= 0) & (index[:, 2] < len(normals))).all()
    painted, comments = _extract_comments(raw, where) if b"#" in data else ([], ())
    if colours is None:
        colours = _decode_polypaint(painted, n)
    extras = Extras(
        colours=colours,
        normals=normals if has_all_normals else None,
        normal=index[:, 2] if has_all_normals else None,
        parts=_label_faces(raw, where, b"o" if b"o" in where else b"g", where[b"f"]),
        materials=_label_faces(raw, where, b"usemtl", where[b"f"]),
        comments=comments,
        unshared=(
            *_list_unshared(lines, where, bool(len(normals)), bool(has_all_normals)),
            *(["numbers after the positions of its vertices"] * has_extra),
        ),
        source=ObjText(raw, where[b"f"]),
    )
    return MeshFile(V, polygons, TC, index[:, 1], extras)


def _list_unshared(
    lines: list[bytes], where: dict[bytes, IntArray], has_normals: bool, has_all_normals: bool
) -> tuple[str, ...]:
    """Describe, for warnings, the contents of an OBJ file that no other format can store."""
    found = [
        what for what, words in OBJ_ONLY_STATEMENTS.items() if any(word in where for word in words.split())
    ]
    if b"o" in where and b"g" in where:
        found.append("groups (g) within its objects")
    flat = [[b"s", b"off"], [b"s", b"0"]]
    smooth = any(lines[i].split() not in flat for key in (b"s", b"mg") for i in where.get(key, ()))
    if smooth and not has_all_normals:  # otherwise the normals imply the smoothing
        found.append("smoothing groups (s)")
    if has_normals and not has_all_normals:
        found.append("normals, which not all corners have")
    return tuple(found)


def _extract_comments(raw: list[bytes], where: dict[bytes, IntArray]) -> tuple[list[bytes], tuple[str, ...]]:
    """Return the comment lines with ZBrush's vertex colours, and all other comments."""
    names = {i for key in NAMING_KEYWORDS for i in where.get(key, NO_LINES).tolist()}
    found = [
        line[line.index(b"#") :].strip() for i, line in enumerate(raw) if b"#" in line and i not in names
    ]
    painted = [line[len(POLYPAINT_PREFIX) :].strip() for line in found if line.startswith(POLYPAINT_PREFIX)]
    others = [line.lstrip(b"#").strip() for line in found if not line.startswith(POLYPAINT_PREFIX)]
    return painted, tuple(decode_utf8(line) for line in others if line)


def _decode_polypaint(painted: list[bytes], n: int) -> FloatArray | None:
    """Return ZBrush's vertex colours; None if their number differs from the number of vertices."""
    try:
        values = np.frombuffer(bytes.fromhex(b"".join(painted).decode("latin-1")), dtype=np.uint8)
    except ValueError:
        return None
    return values.reshape(n, 4)[:, 1:] / 255 if n and len(values) == 4 * n else None


def parse_library_names(line: bytes, folder: Folder) -> list[str]:
    """Return the files that a `mtllib` or `maplib` line names: one name with spaces, or several names."""
    whole = os.fsdecode(parse_name(line))
    if folder.contains(whole):
        return [whole]
    return [next(filter(None, match.groups()), "") for match in LIBRARY_NAME_PATTERN.finditer(whole)]


def load_materials(extras: Extras, folder: Folder) -> Extras:
    """Return the extras with the appearance of the materials from the MTL files of an OBJ file.

    Missing MTL files are ignored, and MTL files outside the folder are skipped with a warning.
    """
    text = extras.source
    if extras.materials is None or not isinstance(text, ObjText):
        return extras
    found: dict[str, Material] = {}
    statements = (line for line in text.lines if line.split(None, 1)[:1] == [LIBRARY_KEYWORD])
    libraries = [name for line in statements for name in parse_library_names(line, folder)]
    outside = [library for library in dict.fromkeys(libraries) if folder.is_outside(library)]
    if outside:
        warnings.warn(
            f"the material libraries {first_few(outside)} are outside the folder {folder.path}, and are not "
            f"read: {REMEDY}",
            MeshWarning,
            stacklevel=stack_level(),
        )
    for library in dict.fromkeys(libraries):
        library_path = None if library in outside else folder.find_file(library)
        if library_path is not None:
            with contextlib.suppress(OSError, Damaged):
                materials = {
                    name: attach_maps(look, folder.with_path(library_path.parent))
                    for name, look in read_library(library_path).items()
                }
                found = materials | found  # the first definition of a material takes precedence
    if not found:
        return extras
    names = extras.materials[0]  # after `usemtl`, a name may be followed by a comment
    looks = [found.get(name) or found.get(name.partition(" #")[0].rstrip()) for name in names]
    return replace(extras, looks=tuple(look or Material() for look in looks))


def _join_continued_lines(lines: list[bytes]) -> list[bytes]:
    """Append the next line to each line that ends with a backslash, and leave an empty line in its place."""
    joined = [*lines, b""]
    for i in reversed(range(len(lines))):
        text = joined[i].rstrip()
        if text.endswith(b"\\") and b"#" not in text:
            joined[i], joined[i + 1] = text[:-1] + b" " + joined[i + 1], b""
    return joined[:-1]


def _strip_comments(data: bytes, lines: list[bytes]) -> list[bytes]:
    """Return the lines without comments, with single spaces between words."""
    if b"#" in data:
        lines = [text.partition(b"#")[0] if b"#" in text else text for text in lines]
    if _has_loose_blanks(data):
        return [b" ".join(text.split()) for text in lines]
    return [*map(bytes.strip, lines)] if b"#" in data or data[:1] == b" " else lines


def _has_loose_blanks(data: bytes) -> bool:
    """Return True if there are tabs, several adjacent spaces, or spaces at the ends of lines."""
    if b"\t" in data:
        return True
    text = np.frombuffer(data, dtype=np.uint8)
    space, blank = text == SPACE, text <= SPACE
    return bool((space[1:] & blank[:-1]).any() or (blank[1:] & space[:-1]).any())


def _group_by_statement(lines: list[bytes]) -> dict[bytes, IntArray]:
    """Return, for each OBJ keyword, the indices of its lines, counted from 0."""
    head = np.array(lines, dtype="S3").view(np.uint8).reshape(-1, 3).T  # the first three bytes of each line
    rest, where = head[0] > 0, dict[bytes, IntArray]()
    for key in (b"v", b"vt", b"vn", b"f"):
        found = np.logical_and.reduce([row == code for row, code in zip(head, key + b" ", strict=False)])
        where[key] = np.flatnonzero(found)
        rest &= ~found
    others: dict[bytes, list[int]] = {}
    for i in np.flatnonzero(rest).tolist():
        others.setdefault(lines[i].partition(b" ")[0], []).append(i)
    for key, rows in others.items():
        where[key] = np.sort(np.append(where.get(key, NO_LINES), rows))
    return where


def _parse_vertices(lines: list[bytes], rows: IntArray) -> tuple[FloatArray, FloatArray | None, bool]:
    """Return positions, vertex colours or None, and whether any vertex weight differs from 1.

    Colours are stored from 0 to 1, or as integers up to 255; vertices without a colour are white.
    """
    table = _parse_statement_numbers(lines, rows, (7, 6, 4, 3), INVALID_VERTEX, 1.0)
    colours = table[:, 3:7] if table.shape[1] in (6, 7) else None
    if colours is not None and 1 < colours.max(initial=0) <= 255 and (colours == np.rint(colours)).all():
        colours = colours / 255
    extra = table[:, 3:] if colours is None else table[:, 7:]
    return np.ascontiguousarray(table[:, :3]), colours, bool((extra != 1).any())


def _parse_statement_numbers(
    lines: list[bytes], rows: IntArray, counts: tuple[int, ...], what: str, fill: float = 0.0
) -> FloatArray:
    """Return the numbers in the lines `rows`; `counts` lists the allowed numbers per line, largest first."""
    if not len(rows):
        return np.empty((0, 3))
    texts = [lines[i].partition(b" ")[2] for i in rows.tolist()]
    if any(row.strip() for row in texts):
        with contextlib.suppress(ValueError):
            table = np.loadtxt(texts, ndmin=2, comments=None)
            if len(table) == len(rows) and table.shape[1] >= counts[-1]:
                return table
    values = []
    for row, i in zip(texts, rows.tolist(), strict=True):
        words = row.split()
        values.append(next((v for k in counts if (v := parse_numbers(words[:k], k))), []))
        if not values[-1]:
            raise_damaged_line(i + 1, lines[i], what)
    filled = np.full((len(rows), max(map(len, values))), fill)
    for filled_row, row_values in zip(filled, values, strict=True):
        filled_row[: len(row_values)] = row_values
    return filled


def _parse_faces(lines: list[bytes], where: dict[bytes, IntArray]) -> tuple[IntArray, IntArray]:
    """Return zero-based vertex, texture and normal indices of each corner, (#C, 3), and the sizes of faces.

    Missing indices are -1. Relative indices that point before the first `vt` or `vn` line are -2.
    """
    texts = [lines[i][2:] for i in where[b"f"].tolist()]
    index, sizes = _parse_faces_by_form(texts) or _parse_faces_by_line(texts, lines, where[b"f"])
    line = np.repeat(where[b"f"], sizes)
    for column, key in enumerate((b"v", b"vt", b"vn")):
        values = index[:, column]
        relative = np.flatnonzero(values < 0)
        values -= values >= 0
        if len(relative):  # relative to the number of elements before the line; index 0 gives -1
            so_far = np.searchsorted(where[key], line[relative])
            values[relative] = np.where(so_far + values[relative] < 0, -2, so_far + values[relative])
    return index, sizes


def _parse_faces_by_form(texts: list[bytes]) -> tuple[IntArray, IntArray] | None:
    """Parse together the face lines of each form, such as v//vn; return None if forms are many or invalid."""
    whole = b"\n".join(texts)
    if b"!" in whole:
        return None
    whole = whole.replace(b"//", b"!")
    forms = whole.translate(None, b"0123456789-").split(b"\n")
    texts = whole.translate(SEPARATORS_TO_SPACES).split(b"\n")
    form_index = {form: i for i, form in enumerate(dict.fromkeys(forms))}
    if len(form_index) > MAX_LINE_FORMS:
        return None
    form_of_line = np.array([form_index[form] for form in forms], dtype=np.int64)
    words = [form.split(b" ") for form in form_index]
    if any(len(set(row)) > 1 or row[0] not in COLUMNS_OF_FORM or len(row) < 3 for row in words):
        return None
    sizes = np.array([len(row) for row in words], dtype=np.int64)[form_of_line] if words else form_of_line
    index, starts = np.zeros((int(sizes.sum()), 3), dtype=np.int64), np.cumsum(sizes) - sizes
    for i, row in enumerate(words):
        rows, columns = np.flatnonzero(form_of_line == i), COLUMNS_OF_FORM[row[0]]
        form_texts = texts if len(words) == 1 else [texts[k] for k in rows.tolist()]
        try:
            table = np.loadtxt(form_texts, dtype=np.int64, ndmin=2, comments=None)
        except (ValueError, OverflowError):
            return None
        if table.shape != (len(rows), len(row) * len(columns)) or (table == 0).any():
            return None
        corners = (starts[rows, None] + np.arange(len(row))).ravel()
        index[corners[:, None], columns] = table.reshape(-1, len(columns))
    return index, sizes


def _parse_faces_by_line(texts: list[bytes], lines: list[bytes], rows: IntArray) -> tuple[IntArray, IntArray]:
    index: list[tuple[int, int, int]] = []
    sizes = []
    for text, line in zip(texts, rows.tolist(), strict=True):
        matches = [CORNER_PATTERN.fullmatch(word) for word in text.split()]
        if len(matches) < 3 or None in matches:
            raise_damaged_line(line + 1, lines[line], INVALID_FACE)
        index += [(int(m[1]), int(m[2] or 0), int(m[3] or 0)) for m in matches if m is not None]
        sizes.append(len(matches))
    return np.array(index, dtype=np.int64).reshape(-1, 3), np.array(sizes, dtype=np.int64)


def _label_faces(
    raw: list[bytes], where: dict[bytes, IntArray], key: bytes, faces: IntArray
) -> FaceLabels | None:
    """Return the distinct names after a keyword, and for each face the index of the name before it, or -1."""
    rows = where.get(key)
    if rows is None:
        return None
    names_in_order = [decode_utf8(parse_name(raw[i])) for i in rows.tolist()]
    names = {name: i for i, name in enumerate(dict.fromkeys(names_in_order))}
    label = np.array([-1, *(names[name] for name in names_in_order)], dtype=np.int64)
    return tuple(names), label[np.searchsorted(rows, faces)]
