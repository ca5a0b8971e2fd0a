"""Write OBJ: a new file, or the one that was read with other texture coordinates."""

import os
import warnings
from collections.abc import Iterable, Iterator, Sequence
from itertools import count
from pathlib import Path

import numpy as np

from ..._types import IntArray
from ...errors import MeshWarning, stack_level
from ..materials import (
    COLOUR,
    FIRST_TILE,
    MOVE,
    MTL_WORDS,
    PLAIN,
    Material,
    library_text,
    unmoved_images,
    warn_of_images,
    warn_of_lost_images,
)
from ..mesh_file import MeshFile
from ..parsing import Named, as_bytes, name_of
from ..references import renamed
from .reading import LIBRARY, ObjText, library_names

# elements that may name texture coordinates, too: those of curves and surfaces are their control points
OF_OLD_TEXTURE = {b"l": "polylines (l)", b"surf": "free-form surfaces (surf)"}
FILES = {
    LIBRARY: None,
    b"maplib": None,
    b"shadow_obj": 0,
    b"trace_obj": 0,
    b"call": 1,
}  # many, one, the first


def obj_names(names: Sequence[str], taken: str = "") -> tuple[str, ...]:
    """The names in lines of OBJ: each on one line, without blanks around it, and no two alike."""
    made: dict[str, None] = {taken: None}
    for name in names:
        line = " ".join(part.strip() for part in name.splitlines()).strip()
        line = f"{line[:-1]}_" if line.endswith("\\") else line or "unnamed"
        numbered = (line if i == 1 else f"{line}.{i}" for i in count(1))
        made[next(word for word in numbered if word not in made)] = None
    return tuple(made)[1:]


def without_name(names: Sequence[str], word: str) -> str:
    """A word for faces that have none of these names."""
    while word in names:
        word += "_"
    return word


def materials_beside(mesh: MeshFile, path: Path) -> dict[Path, bytes]:
    """The library of the materials, and the image that they have: what the files beside an OBJ file hold."""
    if not has_library(mesh):
        return {}
    names, of = mesh.extras.materials or ((), np.full(len(mesh.polygons), -1))
    looks = mesh.extras.looks or [Material()] * len(names)
    materials = dict(zip(names, looks, strict=True))
    if (of < 0).any():
        materials[without_name(names, PLAIN)] = Material()
    library, images = library_of(path), mesh.images
    if images is None:
        return {library: as_bytes(library_text(materials))}
    files = {kind: image_files(path, kind, len(pages)) for kind, pages in images.maps.items()}
    warn_of_lost_images(unmoved_images(looks) if images.moved else sum(look.images for look in looks))
    named = {kind: [file.name for file in own] for kind, own in files.items()}
    made = {library: as_bytes(library_text(materials, named, images.moved))}
    for kind, own in files.items():
        made.update(zip(own, images.maps[kind], strict=True))
    return made


def library_of(path: Path) -> Path:
    """The library beside an OBJ file."""
    return path.with_suffix(".mtl")


def image_files(path: Path, kind: str, pages: int) -> tuple[Path, ...]:
    """The images of one kind beside an OBJ file, one a page, numbered as UDIM tiles if there are several."""
    word = MTL_WORDS.get(kind, kind)
    stem = path.stem if kind == COLOUR else f"{path.stem}_{word}"
    tiles = [""] if pages == 1 else [f".{FIRST_TILE + page}" for page in range(pages)]
    return tuple(path.with_name(f"{stem}{tile}.png") for tile in tiles)


def has_library(mesh: MeshFile) -> bool:
    """Whether an MTL file is written: that of an OBJ that was read stays as it is but for an image."""
    from_obj = isinstance(mesh.extras.source, ObjText)
    return mesh.images is not None or (mesh.extras.materials is not None and not from_obj)


def save_obj(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write the mesh; the lines that were read stay as they are, but for `vt` and the faces."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    if isinstance(mesh.extras.source, ObjText):
        _rewrite_lines(temporary, mesh, mesh.extras.source, path)
        return
    extras = mesh.extras
    V = mesh.V if extras.colours is None else np.column_stack((mesh.V, extras.colours[:, :3]))
    names, of = extras.materials or ((), np.full(len(mesh.polygons), -1))
    words = (*names, without_name(names, PLAIN)) if has_library(mesh) else ()
    columns, tables = [mesh.polygons.corners + 1, mesh.texture + 1], {"v": V, "vt": mesh.TC}
    if extras.normals is not None and extras.normal is not None:
        columns.append(extras.normal + 1)
        tables["vn"] = extras.normals
    corners = np.column_stack(columns)
    form = "/".join(["{}"] * len(columns))
    forms = {k: f"f{f' {form}' * k}\n" for k in np.unique(mesh.polygons.sizes).tolist()}
    sizes, width, flat = mesh.polygons.sizes.tolist(), len(columns), corners.ravel().tolist()
    materials = (words, np.where(of < 0, len(names), of)) if words else None
    heads = _heads(len(mesh.polygons), (("o", extras.parts), ("usemtl", materials)))
    with open(temporary, "w", encoding="utf-8", errors="surrogateescape", newline="\n") as file:
        file.writelines(f"# {line}\n" for line in ("igl_linabf", *extras.comments))
        if words:
            file.write(f"mtllib {library_of(path).name}\n")
        for keyword, rows in tables.items():
            file.writelines(f"{keyword} {' '.join(map(repr, row))}\n" for row in rows.tolist())
        start = 0
        for i, k in enumerate(sizes):
            if i in heads:
                file.write(heads[i])
            end = start + k * width
            file.write(forms[k].format(*flat[start:end]))
            start = end


def _heads(n: int, named: Iterable[tuple[str, Named | None]]) -> dict[int, str]:
    """What is written before which face: where the name of its part or material is another one."""
    heads: dict[int, str] = {}
    for keyword, names in named:
        if names is None:
            continue
        words, of = names
        none = without_name(words, "none")
        new = np.flatnonzero(np.append(True, of[1:] != of[:-1])) if n else of
        for i in new.tolist():
            if of[i] >= 0 or i:
                heads[i] = heads.get(i, "") + f"{keyword} {words[of[i]] if of[i] >= 0 else none}\n"
    return heads


def _rewrite_lines(temporary: str, mesh: MeshFile, text: ObjText, path: Path) -> None:
    """The lines as they were read, with other texture coordinates."""
    assert mesh.TC is not None and mesh.texture is not None
    map_ = "".join(f"vt {u!r} {v!r}\n" for u, v in mesh.TC.tolist()).encode()
    faces = _face_lines(text, mesh.texture + 1, mesh.polygons.sizes)
    first, waiting = (int(text.faces[0]) if len(text.faces) else -1), iter(faces)
    of_face = set(text.faces.tolist())
    if mesh.images is None:
        warn_of_images(sum(look.images for look in mesh.extras.looks or ()), MOVE)
    new_library, stale = has_library(mesh), set[str]()
    names, of = mesh.extras.materials or ((), np.full(len(mesh.polygons), -1))
    on_pages = mesh.images is not None and mesh.images.pages > 1
    numbers, now = iter(of.tolist()), None
    with open(temporary, "wb") as file:
        if new_library:
            file.write(as_bytes(f"mtllib {library_of(path).name}\n"))
        for i, line in enumerate(text.lines):
            if i == first:
                file.write(map_)
                if new_library and of[0] < 0 and not on_pages:
                    file.write(as_bytes(f"usemtl {without_name(names, PLAIN)}\n"))
            if i in of_face:
                material = next(numbers)
                if on_pages and material != now:
                    named = names[material] if material >= 0 else without_name(names, PLAIN)
                    file.write(as_bytes(f"usemtl {named}\n"))
                    now = material
                file.write(next(waiting))
                continue
            word = (line.split(None, 1)[:1] or [b""])[0]
            if on_pages and word == b"usemtl":
                continue
            if word == b"vt" or (word == LIBRARY and new_library):
                continue
            if word in OF_OLD_TEXTURE:
                own, mark, comment = line.partition(b"#")
                bare = [_without_texture(w) for w in own.split()]
                if bare != own.split():
                    stale.add(OF_OLD_TEXTURE[word])
                    line = b" ".join([*bare, *[mark + comment] * bool(mark)])
            elif word in FILES and mesh.path is not None:
                line = _files_from_new_folder(line, word, mesh.path.parent, path.parent)
            file.write(line + b"\n")
    if stale:
        warnings.warn(
            f"the texture coordinates of {' and '.join(sorted(stale))} were those of the old map: they are "
            "left out",
            MeshWarning,
            stacklevel=stack_level(),
        )


def _face_lines(text: ObjText, texture: IntArray, sizes: IntArray) -> Iterator[bytes]:
    index, start = texture.tolist(), 0
    for line, k in zip(text.faces.tolist(), sizes.tolist(), strict=True):
        own, mark, comment = text.lines[line].partition(b"#")
        words = zip(own.split()[1:], index[start : start + k], strict=True)
        yield b" ".join([b"f", *(_corner(w, t) for w, t in words), *[mark + comment] * bool(mark)]) + b"\n"
        start += k


def _corner(word: bytes, texture: int) -> bytes:
    """`v/vt/vn` with another vt."""
    vertex, *rest = word.split(b"/")
    if len(rest) == 2 and rest[1]:
        return b"%b/%d/%b" % (vertex, texture, rest[1])
    return b"%b/%d" % (vertex, texture)


def _without_texture(word: bytes) -> bytes:
    """`v`, or `v//vn`, of `v/vt/vn`."""
    vertex, *rest = word.split(b"/")
    return vertex + b"//" + rest[1] if len(rest) == 2 and rest[1] else vertex


def _files_from_new_folder(line: bytes, word: bytes, old: Path, new: Path) -> bytes:
    """A statement that names files, as seen from the folder of the new file: one line each."""
    if FILES[word] is None:
        names, more = library_names(line, old), ""
    elif FILES[word] == 0:
        names, more = [os.fsdecode(name_of(line))], ""
    else:
        name, blank, more = os.fsdecode(name_of(line)).partition(" ")
        names, more = [name], blank + more
    there = [renamed(name, old, new) for name in names]
    if there == names:
        return line
    return b"\n".join(word + b" " + os.fsencode(name + more) for name in there)
