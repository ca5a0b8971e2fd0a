"""Which module reads and writes which format, and what a format cannot keep."""

import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from errno import EEXIST
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import replacing
from .._types import FloatArray
from ..errors import MeshError, MeshWarning, some, stack_level
from .external import (
    FreeSurferFile,
    GiftiFile,
    ThreeMfFile,
    VtpFile,
    parse_3mf,
    parse_freesurfer,
    parse_gifti,
    parse_vtp,
    save_3mf,
    save_gifti,
    save_patch,
    save_surf,
    save_vtp,
)
from .gltf import GltfFile, are_moved, parse_gltf, save_gltf
from .materials import unknown_to_gltf
from .mesh_file import MeshFile
from .obj import ObjText, has_library, materials_beside, obj_names, parse_obj, save_obj, side_files
from .off import parse_off
from .parsing import Damaged, Extras, Named, as_bytes, plain_text
from .pictures import png
from .ply import PlyTables, parse_ply, save_ply
from .stl import parse_stl
from .vertex_splits import split_vertices

BYTES: dict[str, Callable[[bytes, str], MeshFile]] = {
    ".obj": lambda data, name: parse_obj(plain_text(data), name),
    ".off": lambda data, _: parse_off(plain_text(data)),
    ".ply": lambda data, _: parse_ply(plain_text(data)),
    ".stl": lambda data, _: parse_stl(data),
}
SURFACES = (".pial", ".white", ".inflated", ".smoothwm", ".orig", ".sphere", ".surf")  # of FreeSurfer
PATHS: dict[str, Callable[[Path], MeshFile]] = {
    ".glb": parse_gltf,
    ".gltf": parse_gltf,
    ".3mf": parse_3mf,
    ".gii": parse_gifti,
    ".gii.gz": parse_gifti,
    ".vtp": parse_vtp,
    **dict.fromkeys(SURFACES, parse_freesurfer),
}
FREESURFER = b"\xff\xff"  # and a third byte that says whether its faces are triangles
BEGINNINGS = {
    b"glTF": ".glb",
    b"{": ".gltf",
    b"PK": ".3mf",
    b"ply\n": ".ply",
    b"ply\r": ".ply",
    FREESURFER: ".surf",
    b"\x1f\x8b": ".gii.gz",
}
READERS = (*BYTES, *PATHS)
# whose files a writer writes again as they were
OWN: dict[str, type] = {".obj": ObjText, ".ply": PlyTables, ".glb": GltfFile, ".gltf": GltfFile}
# whose files a writer writes anew, with some of what only they have: `kept`
PARTLY: dict[str, type[ThreeMfFile | VtpFile | GiftiFile | FreeSurferFile]] = {
    ".3mf": ThreeMfFile,
    ".vtp": VtpFile,
    ".gii": GiftiFile,
    ".gii.gz": GiftiFile,
    ".surf": FreeSurferFile,
}
WRITERS: dict[str, Callable[[str, MeshFile, Path], None]] = {
    ".obj": save_obj,
    ".ply": save_ply,
    ".glb": save_gltf,
    ".gltf": save_gltf,
    ".3mf": save_3mf,
    ".vtp": save_vtp,
    ".gii": save_gifti,
    ".gii.gz": save_gifti,
    ".surf": save_surf,
    ".flat": save_patch,
}
WITH_IMAGES = (".glb", ".gltf", ".obj", ".3mf")
FLAT = (".gii", ".gii.gz", ".surf", ".flat")  # in which the map is the surface


def suffix_of(path: str | os.PathLike[str]) -> str:
    """What the name of a file ends in, in lower case: ".obj", ".gii.gz"."""
    ends = [end.lower() for end in Path(path).suffixes[-2:]]
    return "".join(ends) if ends[-1:] == [".gz"] else "".join(ends[-1:])


def lies_flat(path: str | os.PathLike[str]) -> bool:
    """Whether files of this name hold the flat map as a surface, which has a size."""
    return suffix_of(path) in FLAT


def detect_suffix(data: bytes) -> str:
    """What the name of a file with these first bytes ends in; OBJ has none of its own."""
    with suppress(Damaged):
        data = plain_text(data)
    first, triangles = data[:100].split(maxsplit=1)[:1], int.from_bytes(data[80:84], "little")
    if first and first[0].endswith(b"OFF"):
        return ".off"
    if data[:5].lower() == b"solid" or (len(data) >= 84 and len(data) == 84 + 50 * triangles):
        return ".stl"
    if data.lstrip().startswith(b"<"):
        return ".gii" if b"<GIFTI" in data else ".vtp"
    return next((suffix for begin, suffix in BEGINNINGS.items() if data.startswith(begin)), ".obj")


def parse_file(path: str | os.PathLike[str]) -> MeshFile:
    """The mesh in a file; its suffix, or for FreeSurfer its first bytes, says how to read it."""
    path = Path(path)
    suffix = suffix_of(path)
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


def parse(data: bytes, suffix: str, name: str) -> MeshFile:
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


def _with_names_for(mesh: MeshFile, suffix: str) -> tuple[MeshFile, list[str]]:
    """With names that files of this format can have, and what is to be said of those that change."""
    extras = mesh.extras
    if isinstance(extras.source, OWN.get(suffix, ())):
        return mesh, []

    def fit(named: Named | None) -> Named | None:
        if named is None:
            return None
        names, of = named
        return (obj_names(names) if suffix == ".obj" else tuple(map(_as_unicode, names))), of

    made = replace(extras, parts=fit(extras.parts), materials=fit(extras.materials))
    given, new = ([*(of.parts or ((),))[0], *(of.materials or ((),))[0]] for of in (extras, made))
    others = [
        " ".join(_as_unicode(name).split()) for name, own in zip(given, new, strict=True) if name != own
    ]
    if others:
        others = [f"names as they are ({some(others)})"]
    return replace(mesh, extras=made), others


def _as_unicode(name: str) -> str:
    """The name with codes like \\xba for bytes that are not UTF-8."""
    return as_bytes(name).decode("utf-8", "backslashreplace")


def warn_of_loss(mesh: MeshFile, suffix: str, changed: Sequence[str] = ()) -> None:
    """One warning of what the mesh has and a file of this format has not."""
    extras, source, lost = mesh.extras, mesh.extras.source, list[str]()
    if isinstance(source, OWN.get(suffix, ())):
        return
    if suffix in FLAT and mesh.path is not None:
        lost.append("the positions in space")
    if suffix in FLAT and len(split_vertices(mesh).vertex) > len(np.unique(mesh.polygons.corners)):
        lost.append("the numbers of vertices (each is there once for each of its texture coordinates)")
    if suffix in (".ply", ".vtp", *FLAT):
        lost += ["the names of its parts"] * bool(mesh.parts)
    if suffix == ".3mf" and mesh.image is not None:
        pass  # it shows them
    elif suffix in (".ply", ".vtp", ".3mf", *FLAT):
        lost += ["its materials"] * bool(mesh.materials)
    elif any(look.images for look in extras.looks or ()):
        lost.append("the images of its materials")
    elif mesh.materials and extras.looks is None:
        lost.append("what its materials are but their names")
    if suffix in (".glb", ".gltf") and (keys := unknown_to_gltf(extras.looks or ())):
        lost.append(f"{', '.join(keys)} of its materials")
    if mesh.image is None:
        lost += _lost_colours(extras, suffix)
    if extras.comments and suffix in (".3mf", ".vtp", *FLAT):
        lost.append("its comments")
    if extras.normals is not None and suffix in (".3mf", *FLAT):
        lost.append("normals")
    if suffix == ".3mf" and (mesh.polygons.sizes > 3).any():
        lost.append("polygons of more than three corners")
    if extras.units not in (None, "meter") and suffix in (".ply", ".vtp", ".obj"):
        lost.append(f"the unit of length ({extras.units})")
    partly = PARTLY.get(suffix)
    kept = source.kept if partly is not None and isinstance(source, partly) else ()
    lost += [*(what for what in extras.unshared if what not in kept), *changed]
    if lost:
        what = f"{suffix[1:].upper()} does not keep {', '.join(lost)}"
        if mesh.path is not None:
            what += f" of {mesh.path.name}"
        own = next((own for own, kind in OWN.items() if isinstance(source, kind)), None)
        if own is not None:
            what += f": write {own[1:].upper()} to keep all of it"
        warnings.warn(what, MeshWarning, stacklevel=stack_level())


def object_frames(mesh: MeshFile, path: str | os.PathLike[str]) -> FloatArray | None:
    """How the objects of a file, as it will be written, lie in the space of V.

    Returns
    -------
    (#F, 3, 3) float64 or None
        For each face, what takes vectors of its object to V's space; None if no object is turned or scaled.
    """
    source = mesh.extras.source
    if not isinstance(source, GltfFile) or suffix_of(path) not in (".glb", ".gltf"):
        return None
    assert mesh.extras.parts is not None  # as of every file of glTF
    return source.frames[mesh.extras.parts[1]]


def moves_textures(mesh: MeshFile) -> bool:
    """Whether materials of its file move the texture coordinates before images are looked up."""
    source = mesh.extras.source
    return isinstance(source, GltfFile) and are_moved(source.gltf.text)


def _lost_colours(extras: Extras, suffix: str) -> list[str]:
    """What of the colours a format does not keep; in an image, they are in it."""
    lost = list[str]()
    if extras.colours is not None and suffix in (".3mf", *FLAT):
        lost.append("colours")
    elif extras.colours is not None and suffix == ".obj" and (extras.colours[:, 3:] < 1).any():
        lost.append("the alpha of its colours")
    if suffix in (".glb", ".gltf") and extras.colours is not None and extras.face_colours is not None:
        lost.append("the colours of its vertices, as it has one at a corner, and its faces have some")
    if extras.face_colours is not None and suffix not in (".ply", ".vtp", ".glb", ".gltf"):
        lost.append("the colours of its faces")
    if extras.corner_colours is not None and suffix not in (".glb", ".gltf"):
        lost.append("the colours of its corners")
    return lost


def files_beside(path: Path, mesh: MeshFile, image: bool) -> tuple[Path, ...]:
    """What is written beside the file itself."""
    if path.suffix.lower() != ".obj":
        return ()
    return side_files(path)[: 2 if image else int(has_library(mesh))]


def check_free(paths: Iterable[Path], force: bool) -> None:
    """Raise where a file is there that nobody has asked to replace.

    Raises
    ------
    FileExistsError
    """
    for path in paths:
        if os.path.lexists(path) and not force:
            said = (
                "it is there already, and is not the file that was asked for: move it, write under another "
                "name, or replace it with --force (in Python, force=True)"
            )
            raise FileExistsError(EEXIST, said, str(path))


@contextmanager
def write_atomically(
    path: str | os.PathLike[str],
    mesh: MeshFile,
    TC: ArrayLike,
    FTC: ArrayLike | None = None,
    image: ArrayLike | None = None,
    *,
    force: bool = False,
    folder: Path | None = None,
) -> Iterator[None]:
    """Write under temporary names; the files take their places when the block succeeds.

    Names of other files lead to them from `folder`, by default that of `path`.
    """
    path = Path(path)
    suffix = suffix_of(path)
    if suffix not in WRITERS:
        raise MeshError(f"{path} has an unknown suffix: use {', '.join(WRITERS)}")
    if image is not None and suffix not in WITH_IMAGES:
        raise MeshError(f"{path} holds no image: write one of {', '.join(WITH_IMAGES)}")
    check_free(files_beside(path, mesh, image is not None), force)
    made, changed = _with_names_for(
        replace(mesh.textured(TC, FTC), image=None if image is None else png(image)), suffix
    )
    warn_of_loss(made, suffix, changed)
    beside = materials_beside(made, path) if suffix == ".obj" else {}
    with ExitStack() as stack:
        temporary = stack.enter_context(replacing(path))
        for own, data in beside.items():
            Path(stack.enter_context(replacing(own))).write_bytes(data)
        WRITERS[suffix](temporary, made, path if folder is None else folder / path.name)
        yield
