"""Which module reads and writes which format, and what a format cannot keep."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from pathlib import Path

from ..errors import MeshError, MeshWarning, stack_level
from .gltf_reading import GltfFile, parse_gltf, save_glb
from .mesh_file import MeshFile
from .obj import ObjText, parse_obj
from .obj_writing import save_obj
from .off import parse_off
from .other_formats import parse_3mf, parse_freesurfer, parse_gifti, parse_vtp, save_gifti, save_vtp
from .parsing import Damaged, Parsed
from .ply import PlyTables, parse_ply
from .ply_writing import save_ply
from .stl import parse_stl

BYTES: dict[str, Callable[[bytes, str], Parsed]] = {
    ".obj": parse_obj,
    ".off": lambda data, _: parse_off(data),
    ".ply": lambda data, _: parse_ply(data),
    ".stl": lambda data, _: parse_stl(data),
}
PATHS: dict[str, Callable[[Path], Parsed]] = {
    ".glb": parse_gltf,
    ".gltf": parse_gltf,
    ".3mf": parse_3mf,
    ".gii": parse_gifti,
    ".vtp": parse_vtp,
    **dict.fromkeys((".pial", ".white", ".inflated", ".smoothwm", ".orig", ".sphere"), parse_freesurfer),
}
READERS = (*BYTES, *PATHS)
OWN: dict[str, tuple[type, ...]] = {  # whose files a writer writes again as they were
    ".obj": (ObjText,),
    ".ply": (PlyTables,),
    ".glb": (GltfFile,),
}
FREESURFER = b"\xff\xff"  # and a third byte that says whether its faces are triangles
WRITERS: dict[str, Callable[[str, MeshFile, Path], None]] = {
    ".obj": save_obj,
    ".ply": save_ply,
    ".glb": save_glb,
    ".vtp": save_vtp,
    ".gii": save_gifti,
}


def parsed(path: str | os.PathLike[str]) -> Parsed:
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix in BYTES:
        return parse(path.read_bytes(), suffix, str(path))
    read = PATHS.get(suffix)
    if read is None:
        with path.open("rb") as file:
            head = file.read(2)
        if head != FREESURFER:
            raise MeshError(f"{path} is not a mesh file: use one that ends in {', '.join(READERS)}")
        read = parse_freesurfer
    try:
        return read(path)
    except Damaged as damage:
        raise MeshError(f"{path} cannot be read as {suffix[1:].upper() or 'FreeSurfer'}: {damage}") from None


def parse(data: bytes, suffix: str, name: str) -> Parsed:
    """The mesh in the bytes of a file.

    Parameters
    ----------
    data : bytes
    suffix : {".obj", ".off", ".ply", ".stl"}
    name : str
        Name of the file in messages.

    Raises
    ------
    MeshError
        The file is damaged; the text says where.

    Warns
    -----
    MeshWarning
        An OBJ file has lines that are not OBJ statements; they are skipped.
    """
    try:
        return BYTES[suffix](data, name)
    except Damaged as damage:
        raise MeshError(f"{name} cannot be read as {suffix[1:].upper()}: {damage}") from None


def writer(path: Path) -> Callable[[str, MeshFile, Path], None]:
    suffix = path.suffix.lower()
    if suffix not in WRITERS:
        raise MeshError(f"{path} has an unknown suffix: use {', '.join(WRITERS)}")
    return WRITERS[suffix]


def warn_of_loss(mesh: MeshFile, suffix: str) -> None:
    """One warning of what the mesh has and a file of this format has not."""
    extras, source, lost = mesh.extras, mesh.extras.source, list[str]()
    if isinstance(source, OWN.get(suffix, ())):
        return
    if suffix == ".gii":
        lost += ["the positions in space"]
    if suffix in (".ply", ".vtp", ".gii"):
        lost += ["the names of its parts"] * bool(mesh.parts) + ["its materials"] * bool(mesh.materials)
    elif mesh.materials:
        lost.append("what its materials are but their names")
    if extras.colours is not None and suffix == ".gii":
        lost.append("colours")
    if extras.normals is not None and suffix in (".vtp", ".gii"):
        lost.append("normals")
    if extras.units not in (None, "meter") and suffix in (".ply", ".vtp", ".obj"):
        lost.append(f"the unit of length ({extras.units})")
    if isinstance(source, GltfFile):
        lost += [f"its {name}" for name in ("animations", "skins", "cameras") if source.gltf.text.get(name)]
    if isinstance(source, PlyTables):
        more = [of.name for of in source.elements if of.name not in ("vertex", "face")]
        lost += [f"the elements {', '.join(more)}"] * bool(more)
    if lost:
        what = f"{suffix[1:].upper()} does not keep {', '.join(lost)}"
        if mesh.path is not None:
            what += f" of {mesh.path.name}"
        for own, types in OWN.items():
            if isinstance(source, types):
                what += f": write {own[1:].upper()} to keep all of it"
        warnings.warn(what, MeshWarning, stacklevel=stack_level())
