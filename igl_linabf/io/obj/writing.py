"""Write OBJ: a new file, or the one that was read with other texture coordinates."""

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from ..._types import IntArray
from ..materials import PLAIN, Material, library_text, warn_of_images
from ..mesh_file import MeshFile
from ..parsing import Named
from .reading import LIBRARY, ObjText

LINE = b"l"  # a polyline may name texture coordinates, too


def materials_beside(mesh: MeshFile, path: Path) -> dict[str, bytes]:
    """The library of the materials, and the image that they have, by the suffixes of their files."""
    if not _has_library(mesh):
        return {}
    names, of = mesh.extras.materials or ((), np.full(len(mesh.polygons), -1))
    materials = dict(zip(names, mesh.extras.looks or [Material()] * len(names), strict=True))
    if (of < 0).any():
        materials[PLAIN] = Material()
    if mesh.image is None:
        return {".mtl": library_text(materials).encode()}
    return {".mtl": library_text(materials, path.with_suffix(".png").name).encode(), ".png": mesh.image}


def _has_library(mesh: MeshFile) -> bool:
    """Whether an MTL file is written: that of an OBJ that was read stays as it is but for an image."""
    from_obj = isinstance(mesh.extras.source, ObjText)
    return mesh.image is not None or (mesh.extras.materials is not None and not from_obj)


def save_obj(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write the mesh; the lines that were read stay as they are, but for `vt` and the faces."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    if isinstance(mesh.extras.source, ObjText):
        _rewrite_lines(temporary, mesh, mesh.extras.source, path)
        return
    extras = mesh.extras
    V = mesh.V if extras.colours is None else np.column_stack((mesh.V, extras.colours[:, :3]))
    names, of = extras.materials or ((), np.full(len(mesh.polygons), -1))
    words = (*names, PLAIN) if _has_library(mesh) else ()
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
    with open(temporary, "w", encoding="utf-8", newline="\n") as file:  # igl.writeOBJ misses a full disk
        file.write("# igl_linabf\n")
        if words:
            file.write(f"mtllib {path.with_suffix('.mtl').name}\n")
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
        new = np.flatnonzero(np.append(True, of[1:] != of[:-1])) if n else of
        for i in new.tolist():
            if of[i] >= 0 or i:
                heads[i] = heads.get(i, "") + f"{keyword} {words[of[i]] if of[i] >= 0 else 'none'}\n"
    return heads


def _rewrite_lines(temporary: str, mesh: MeshFile, text: ObjText, path: Path) -> None:
    """The lines as they were read, with other texture coordinates."""
    assert mesh.TC is not None and mesh.texture is not None
    map_ = "".join(f"vt {u!r} {v!r}\n" for u, v in mesh.TC.tolist()).encode()
    faces = _face_lines(text, mesh.texture + 1, mesh.polygons.sizes)
    first, waiting = (int(text.faces[0]) if len(text.faces) else -1), iter(faces)
    of_face = set(text.faces.tolist())
    if mesh.image is None:
        warn_of_images(sum(look.images for look in mesh.extras.looks or ()))
    new_library = f"mtllib {path.with_suffix('.mtl').name}\n".encode() if _has_library(mesh) else b""
    with open(temporary, "wb") as file:
        file.write(new_library)
        for i, line in enumerate(text.lines):
            if i == first:
                file.write(map_)
                if new_library and (mesh.extras.materials is None or mesh.extras.materials[1][0] < 0):
                    file.write(f"usemtl {PLAIN}\n".encode())
            if i in of_face:
                file.write(next(waiting))
                continue
            word = line.split(None, 1)[:1]
            if word == [b"vt"]:
                continue
            if word == [LINE]:
                line = b" ".join(w.partition(b"/")[0] for w in line.split())
            elif word == [LIBRARY] and new_library:
                continue
            elif word == [LIBRARY] and mesh.path is not None:
                line = _library_from_new_folder(line, mesh.path.parent, path.parent)
            file.write(line + b"\n")


def _face_lines(text: ObjText, texture: IntArray, sizes: IntArray) -> Iterator[bytes]:
    index, start = texture.tolist(), 0
    for line, k in zip(text.faces.tolist(), sizes.tolist(), strict=True):
        words = text.lines[line].partition(b"#")[0].split()[1:]
        yield (
            b"f "
            + b" ".join(_corner(w, t) for w, t in zip(words, index[start : start + k], strict=True))
            + b"\n"
        )
        start += k


def _corner(word: bytes, texture: int) -> bytes:
    """`v/vt/vn` with another vt."""
    vertex, *rest = word.split(b"/")
    if len(rest) == 2 and rest[1]:
        return b"%b/%d/%b" % (vertex, texture, rest[1])
    return b"%b/%d" % (vertex, texture)


def _library_from_new_folder(line: bytes, old: Path, new: Path) -> bytes:
    """A library of materials, as seen from the folder of the new file."""
    name = os.fsdecode(line.split(None, 1)[1].strip()) if len(line.split(None, 1)) > 1 else ""
    if not name or not (old / name).is_file() or old.resolve() == new.resolve():
        return line
    try:
        return b"mtllib " + os.fsencode(os.path.relpath(old / name, new).replace(os.sep, "/"))
    except ValueError:  # on another drive
        return b"mtllib " + os.fsencode((old / name).resolve().as_posix())
