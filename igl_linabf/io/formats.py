"""Which module reads and writes which format, and what a format cannot keep."""

import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path

from numpy.typing import ArrayLike

from .._runtime import replacing
from ..errors import MeshError, MeshWarning, stack_level
from .external import (
    PATCH_BEGINNING,
    Patch,
    mean_surface,
    parse_3mf,
    parse_freesurfer,
    parse_gifti,
    parse_patch,
    parse_vtp,
    save_3mf,
    save_gifti,
    save_patch,
    save_surf,
    save_vtp,
    surfaces_beside,
)
from .gltf import GltfFile, parse_gltf, save_gltf
from .mesh_file import MeshFile
from .obj import ObjText, materials_beside, parse_obj, save_obj
from .off import parse_off
from .parsing import Damaged, plain_text
from .pictures import png
from .ply import PlyTables, parse_ply, save_ply
from .stl import parse_stl

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
    ".vtp": parse_vtp,
    **dict.fromkeys(SURFACES, parse_freesurfer),
}
FREESURFER = b"\xff\xff"  # and a third byte that says whether its faces are triangles
PATCHES = (".3d", ".flat")  # of FreeSurfer, too
BEGINNINGS = {
    PATCH_BEGINNING: ".3d",
    b"glTF": ".glb",
    b"{": ".gltf",
    b"PK": ".3mf",
    b"ply\n": ".ply",
    b"ply\r": ".ply",
    FREESURFER: ".surf",
}
READERS = (*BYTES, *PATHS, *PATCHES)
# whose files a writer writes again as they were
OWN: dict[str, type] = {".obj": ObjText, ".ply": PlyTables, ".glb": GltfFile, ".gltf": GltfFile}
WRITERS: dict[str, Callable[[str, MeshFile, Path], None]] = {
    ".obj": save_obj,
    ".ply": save_ply,
    ".glb": save_gltf,
    ".gltf": save_gltf,
    ".3mf": save_3mf,
    ".vtp": save_vtp,
    ".gii": save_gifti,
    ".surf": save_surf,
    **dict.fromkeys(PATCHES, save_patch),
}
WITH_IMAGES = (".glb", ".gltf", ".obj", ".3mf")
FLAT = (".gii", ".surf", *PATCHES)  # in which the map is the surface


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


def parse_file(path: str | os.PathLike[str], surface: str | os.PathLike[str] | None = None) -> MeshFile:
    """The mesh in a file; its suffix, or for FreeSurfer its first bytes, says how to read it."""
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in READERS or suffix in PATCHES:
        with path.open("rb") as file:
            head = file.read(len(PATCH_BEGINNING))
        if head == PATCH_BEGINNING or suffix in PATCHES:
            return _parse_patch(path, surface)
        if not head.startswith(FREESURFER):
            raise MeshError(f"{path} is not a mesh file: use one that ends in {', '.join(READERS)}")
    if surface is not None:
        raise ValueError(f"{path} is no patch, and holds its surface itself: leave out the surface")
    if suffix in BYTES:
        return parse(path.read_bytes(), suffix, str(path))
    try:
        return PATHS.get(suffix, parse_freesurfer)(path)
    except Damaged as damage:
        raise MeshError(f"{path} cannot be read as {suffix[1:].upper() or 'FreeSurfer'}: {damage}") from None


def _parse_patch(path: Path, surface: str | os.PathLike[str] | None) -> MeshFile:
    """A patch on its surface, which is found beside it by FreeSurfer's names if it is not given."""
    hemisphere = path.name.partition(".")[0]
    given = surfaces_beside(path.parent, hemisphere) if surface is None else [Path(surface)]
    if not given:
        raise MeshError(
            f"{path} is a patch, which has vertices and no faces, and its surface is not beside it: give it "
            f"by surface=, or --surface ({hemisphere}.fiducial, {hemisphere}.smoothwm, ...)"
        )
    meshes = [replace(parse_file(one), path=one) for one in given]
    try:
        return parse_patch(path, mean_surface(meshes))
    except Damaged as damage:
        raise MeshError(f"{path} cannot be read as a patch: {damage}") from None


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


def warn_of_loss(mesh: MeshFile, suffix: str) -> None:
    """One warning of what the mesh has and a file of this format has not."""
    extras, source, lost = mesh.extras, mesh.extras.source, list[str]()
    if isinstance(source, OWN.get(suffix, ())):
        return
    if suffix in FLAT and mesh.path is not None and not isinstance(source, Patch):
        lost.append("the positions in space")
    if suffix in (".ply", ".vtp", *FLAT):
        lost += ["the names of its parts"] * bool(mesh.parts)
    if suffix in (".ply", ".vtp", ".3mf", *FLAT):
        lost += ["its materials"] * bool(mesh.materials)
    elif any(look.images for look in extras.looks or ()):
        lost.append("the images of its materials")
    elif mesh.materials and extras.looks is None:
        lost.append("what its materials are but their names")
    if extras.colours is not None and suffix in (".3mf", *FLAT):
        lost.append("colours")
    if extras.normals is not None and suffix in (".3mf", ".vtp", *FLAT):
        lost.append("normals")
    if suffix == ".3mf" and (mesh.polygons.sizes > 3).any():
        lost.append("polygons of more than three corners")
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
        own = next((own for own, kind in OWN.items() if isinstance(source, kind)), None)
        if own is not None:
            what += f": write {own[1:].upper()} to keep all of it"
        warnings.warn(what, MeshWarning, stacklevel=stack_level())


@contextmanager
def write_atomically(
    path: str | os.PathLike[str],
    mesh: MeshFile,
    TC: ArrayLike,
    FTC: ArrayLike | None = None,
    image: ArrayLike | None = None,
) -> Iterator[None]:
    """Write under temporary names; the files take their places when the block succeeds."""
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in WRITERS:
        raise MeshError(f"{path} has an unknown suffix: use {', '.join(WRITERS)}")
    if image is not None and suffix not in WITH_IMAGES:
        raise MeshError(f"{path} holds no image: write one of {', '.join(WITH_IMAGES)}")
    made = replace(mesh.textured(TC, FTC), image=None if image is None else png(image))
    warn_of_loss(made, suffix)
    beside = materials_beside(made, path) if suffix == ".obj" else {}
    with ExitStack() as stack:
        temporary = stack.enter_context(replacing(path))
        for own, data in beside.items():
            Path(stack.enter_context(replacing(path.with_suffix(own)))).write_bytes(data)
        WRITERS[suffix](temporary, made, path)
        yield
