"""Write OBJ: a new file, or the file that was read with new texture coordinates."""

import os
import warnings
from collections.abc import Iterable, Iterator, Sequence
from itertools import count
from pathlib import Path

import numpy as np

from ..._types import IntArray
from ...charts import FIRST_UDIM_TILE
from ...errors import MeshWarning, stack_level
from ..materials import (
    COLOUR,
    DEFAULT_MATERIAL,
    MOVE_HINT,
    MTL_KEYWORDS,
    Material,
    count_unmovable_materials,
    format_library,
    warn_of_lost_images,
    warn_of_stale_images,
)
from ..mesh_file import MeshFile
from ..parsing import FaceLabels, encode_utf8, parse_name
from ..references import Folder
from .reading import LIBRARY_KEYWORD, ObjText, parse_library_names

# OBJ statements, other than faces, that may refer to texture coordinates, and their descriptions.
MAPPED_ELEMENTS = {b"l": "polylines (l)", b"surf": "free-form surfaces (surf)"}
# OBJ statements that refer to several files (None), to one file (0), or to one file with arguments (1).
FILE_STATEMENTS = {LIBRARY_KEYWORD: None, b"maplib": None, b"shadow_obj": 0, b"trace_obj": 0, b"call": 1}


def make_obj_names(names: Sequence[str], taken: str = "") -> tuple[str, ...]:
    """Return distinct names that OBJ can store: on one line, without leading or trailing spaces."""
    unique: dict[str, None] = {taken: None}
    for name in names:
        line = " ".join(part.strip() for part in name.splitlines()).strip()
        line = f"{line[:-1]}_" if line.endswith("\\") else line or "unnamed"
        numbered = (line if i == 1 else f"{line}.{i}" for i in count(1))
        unique[next(candidate for candidate in numbered if candidate not in unique)] = None
    return tuple(unique)[1:]


def make_unused_name(names: Sequence[str], name_: str) -> str:
    """Return `name_`, with underscores appended until it is not in `names`."""
    while name_ in names:
        name_ += "_"
    return name_


def encode_material_files(mesh: MeshFile, path: Path) -> dict[Path, bytes]:
    """Return the contents of the files next to an OBJ file: the material library and its images."""
    if not has_library(mesh):
        return {}
    names, material = mesh.extras.materials or ((), np.full(len(mesh.polygons), -1))
    looks = mesh.extras.looks or [Material()] * len(names)
    materials = dict(zip(names, looks, strict=True))
    if (material < 0).any():
        materials[make_unused_name(names, DEFAULT_MATERIAL)] = Material()
    library, images = get_library_path(path), mesh.images
    if images is None:
        return {library: encode_utf8(format_library(materials))}
    files = {kind: get_image_paths(path, kind, len(pages)) for kind, pages in images.maps.items()}
    warn_of_lost_images(
        count_unmovable_materials(looks) if images.moved else sum(look.images for look in looks)
    )
    named = {kind: [file.name for file in paths] for kind, paths in files.items()}
    contents = {library: encode_utf8(format_library(materials, named, images.moved))}
    for kind, paths in files.items():
        contents.update(zip(paths, images.maps[kind], strict=True))
    return contents


def get_library_path(path: Path) -> Path:
    """Return the path of the material library next to an OBJ file."""
    return path.with_suffix(".mtl")


def get_image_paths(path: Path, kind: str, pages: int) -> tuple[Path, ...]:
    """Return the paths of the images of a kind next to an OBJ file; several pages get UDIM numbers."""
    word = MTL_KEYWORDS.get(kind, kind)
    stem = path.stem if kind == COLOUR else f"{path.stem}_{word}"
    tiles = [""] if pages == 1 else [f".{FIRST_UDIM_TILE + page}" for page in range(pages)]
    return tuple(path.with_name(f"{stem}{tile}.png") for tile in tiles)


def has_library(mesh: MeshFile) -> bool:
    """Return True if a new MTL file is written; a mesh from an OBJ file needs one only for new images."""
    from_obj = isinstance(mesh.extras.source, ObjText)
    return mesh.images is not None or (mesh.extras.materials is not None and not from_obj)


def save_obj(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write an OBJ file; for a mesh from an OBJ file, only the `vt` lines and the faces change."""
    assert mesh.TC is not None and mesh.texture is not None
    if isinstance(mesh.extras.source, ObjText):
        _rewrite_obj(temporary, mesh, mesh.extras.source, path)
        return
    extras = mesh.extras
    V = mesh.V if extras.colours is None else np.column_stack((mesh.V, extras.colours[:, :3]))
    names, material = extras.materials or ((), np.full(len(mesh.polygons), -1))
    words = (*names, make_unused_name(names, DEFAULT_MATERIAL)) if has_library(mesh) else ()
    columns, tables = [mesh.polygons.corners + 1, mesh.texture + 1], {"v": V, "vt": mesh.TC}
    if extras.normals is not None and extras.normal is not None:
        columns.append(extras.normal + 1)
        tables["vn"] = extras.normals
    corners = np.column_stack(columns)
    sizes, width, flat = mesh.polygons.sizes.tolist(), len(columns), corners.ravel().tolist()
    forms, bare_forms = (
        {k: f"f{f' {form}' * k}\n" for k in np.unique(mesh.polygons.sizes).tolist()}
        for form in ("/".join(["{}"] * width), "//".join(["{}"] * (width - 1)))
    )
    bare = set(np.flatnonzero(mesh.lacks_texture).tolist())
    materials = (words, np.where(material < 0, len(names), material)) if words else None
    headings = _make_headings(len(mesh.polygons), (("o", extras.parts), ("usemtl", materials)))
    with open(temporary, "w", encoding="utf-8", errors="surrogateescape", newline="\n") as file:
        file.writelines(f"# {line}\n" for line in ("igl_linabf", *extras.comments))
        if words:
            file.write(f"mtllib {get_library_path(path).name}\n")
        for keyword, rows in tables.items():
            file.writelines(f"{keyword} {' '.join(map(repr, row))}\n" for row in rows.tolist())
        start = 0
        for i, k in enumerate(sizes):
            if i in headings:
                file.write(headings[i])
            values = flat[start : start + k * width]
            if i in bare:
                del values[1::width]
            file.write((bare_forms if i in bare else forms)[k].format(*values))
            start += k * width


def _make_headings(n: int, labels: Iterable[tuple[str, FaceLabels | None]]) -> dict[int, str]:
    """Return the lines `o` and `usemtl` to write before each face with a new part or material."""
    headings: dict[int, str] = {}
    for keyword, names in labels:
        if names is None:
            continue
        words, index = names
        unnamed = make_unused_name(words, "none")
        new = np.flatnonzero(np.append(True, index[1:] != index[:-1])) if n else index
        for i in new.tolist():
            if index[i] >= 0 or i:
                headings[i] = (
                    headings.get(i, "") + f"{keyword} {words[index[i]] if index[i] >= 0 else unnamed}\n"
                )
    return headings


def _rewrite_obj(temporary: str, mesh: MeshFile, text: ObjText, path: Path) -> None:
    """Write the original lines with new texture coordinates."""
    assert mesh.TC is not None and mesh.texture is not None
    map_ = "".join(f"vt {u!r} {v!r}\n" for u, v in mesh.TC.tolist()).encode()
    faces = _rewrite_face_lines(text, mesh.texture + 1, mesh.polygons.sizes)
    first, waiting = (int(text.faces[0]) if len(text.faces) else -1), iter(faces)
    of_face = set(text.faces.tolist())
    if mesh.images is None:
        warn_of_stale_images(sum(look.images for look in mesh.extras.looks or ()), MOVE_HINT)
    new_library, stale = has_library(mesh), set[str]()
    names, material_of_face = mesh.extras.materials or ((), np.full(len(mesh.polygons), -1))
    on_pages = mesh.images is not None and mesh.images.pages > 1
    face_materials, current_material = iter(material_of_face.tolist()), None
    with open(temporary, "wb") as file:
        if new_library:
            file.write(encode_utf8(f"mtllib {get_library_path(path).name}\n"))
        for i, line in enumerate(text.lines):
            if i == first:
                file.write(map_)
                if new_library and material_of_face[0] < 0 and not on_pages:
                    file.write(encode_utf8(f"usemtl {make_unused_name(names, DEFAULT_MATERIAL)}\n"))
            if i in of_face:
                material = next(face_materials)
                if on_pages and material != current_material:
                    named = names[material] if material >= 0 else make_unused_name(names, DEFAULT_MATERIAL)
                    file.write(encode_utf8(f"usemtl {named}\n"))
                    current_material = material
                file.write(next(waiting))
                continue
            word = (line.split(None, 1)[:1] or [b""])[0]
            if on_pages and word == b"usemtl":
                continue
            if word == b"vt" or (word == LIBRARY_KEYWORD and new_library):
                continue
            if word in MAPPED_ELEMENTS:
                statement, mark, comment = line.partition(b"#")
                bare = [_strip_texture_index(w) for w in statement.split()]
                if bare != statement.split():
                    stale.add(MAPPED_ELEMENTS[word])
                    line = b" ".join([*bare, *[mark + comment] * bool(mark)])
            elif word in FILE_STATEMENTS and mesh.folder is not None:
                line = _relocate_file_names(line, word, mesh.folder, path.parent)
            file.write(line + b"\n")
    if stale:
        warnings.warn(
            f"the texture coordinates of {' and '.join(sorted(stale))} belong to the old map: they are left "
            "out",
            MeshWarning,
            stacklevel=stack_level(),
        )


def _rewrite_face_lines(text: ObjText, texture: IntArray, sizes: IntArray) -> Iterator[bytes]:
    index, start = texture.tolist(), 0
    for line, k in zip(text.faces.tolist(), sizes.tolist(), strict=True):
        statement, mark, comment = text.lines[line].partition(b"#")
        words = zip(statement.split()[1:], index[start : start + k], strict=True)
        yield (
            b" ".join(
                [
                    b"f",
                    *(_replace_texture_index(w, t) if t else _strip_texture_index(w) for w, t in words),
                    *[mark + comment] * bool(mark),
                ]
            )
            + b"\n"
        )
        start += k


def _replace_texture_index(word: bytes, texture: int) -> bytes:
    """Replace or insert vt in a face corner `v/vt/vn`."""
    vertex, *rest = word.split(b"/")
    if len(rest) == 2 and rest[1]:
        return b"%b/%d/%b" % (vertex, texture, rest[1])
    return b"%b/%d" % (vertex, texture)


def _strip_texture_index(word: bytes) -> bytes:
    """Remove vt from a face corner: return `v` or `v//vn` for `v/vt/vn`."""
    vertex, *rest = word.split(b"/")
    return vertex + b"//" + rest[1] if len(rest) == 2 and rest[1] else vertex


def _relocate_file_names(line: bytes, word: bytes, old: Folder, new: Path) -> bytes:
    """Make the file names in a statement relative to the folder `new`; return one line per file name."""
    if FILE_STATEMENTS[word] is None:
        names, arguments = parse_library_names(line, old), ""
    elif FILE_STATEMENTS[word] == 0:
        names, arguments = [os.fsdecode(parse_name(line))], ""
    else:
        name, blank, arguments = os.fsdecode(parse_name(line)).partition(" ")
        names, arguments = [name], blank + arguments
    relocated = [old.relocate_reference(name, new) for name in names]
    if relocated == names:
        return line
    return b"\n".join(word + b" " + os.fsencode(name + arguments) for name in relocated)
