"""Select the module that reads or writes each format, and warn of contents that a format cannot keep."""

import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from errno import EEXIST
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import replacing
from .._types import FloatArray
from ..charts import FIRST_UDIM_TILE
from ..errors import MeshError, MeshWarning, first_few, stack_level
from ..surface import normalize_vectors
from .colours import GLTF_SUFFIXES, compute_corner_normals
from .external import (
    PATCH_MAGIC,
    FreeSurferFile,
    GiftiFile,
    Patch,
    ThreeMfFile,
    VtpFile,
    average_surfaces,
    find_companion_surfaces,
    parse_3mf,
    parse_freesurfer,
    parse_gifti,
    parse_patch,
    parse_vtp,
    save_3mf,
    save_freesurfer,
    save_gifti,
    save_patch,
    save_vtp,
)
from .gltf import GltfFile, has_texture_transforms, parse_gltf, save_gltf
from .gltf import select_second_uv_set as select_second_gltf
from .materials import (
    COLOUR,
    DEFAULT_MATERIAL,
    MTL_KEYWORDS,
    TEXTURE_SUFFIX,
    Material,
    find_keys_unknown_to_gltf,
    has_image,
)
from .mesh_file import Images, MeshFile
from .obj import (
    ObjText,
    encode_material_files,
    get_image_paths,
    get_library_path,
    has_library,
    make_obj_names,
    make_unused_name,
    parse_obj,
    save_obj,
)
from .off import parse_off
from .parsing import Damaged, Extras, FaceLabels, check_regular_file, convert_to_utf8, encode_utf8
from .pictures import encode_png
from .ply import PlyTables, parse_ply, save_ply
from .ply import select_second_uv_set as select_second_ply
from .stl import parse_stl
from .vertex_splits import find_face_pages, split_vertices

BYTE_READERS: dict[str, Callable[[bytes, str], MeshFile]] = {
    ".obj": lambda data, name: parse_obj(convert_to_utf8(data), name),
    ".off": lambda data, _: parse_off(convert_to_utf8(data)),
    ".ply": lambda data, _: parse_ply(convert_to_utf8(data)),
    ".stl": lambda data, _: parse_stl(data),
}
FREESURFER_SUFFIXES = (".pial", ".white", ".inflated", ".smoothwm", ".orig", ".sphere", ".surf")
# Readers of formats with references to other files; they have the option `allow_outside`.
REFERRING_READERS: dict[str, Callable[[Path, bool], MeshFile]] = {
    ".glb": parse_gltf,
    ".gltf": parse_gltf,
    ".gii": parse_gifti,
    ".gii.gz": parse_gifti,
}
PATH_READERS: dict[str, Callable[[Path], MeshFile]] = {
    ".3mf": parse_3mf,
    ".vtp": parse_vtp,
    **dict.fromkeys(FREESURFER_SUFFIXES, parse_freesurfer),
}
FREESURFER_MAGIC = b"\xff\xff"  # the third byte distinguishes surfaces of triangles and of quads
PATCH_SUFFIXES = (".3d", ".flat")  # FreeSurfer patches
SUFFIX_OF_MAGIC = {
    PATCH_MAGIC: ".3d",
    b"glTF": ".glb",
    b"{": ".gltf",
    b"PK": ".3mf",
    b"ply\n": ".ply",
    b"ply\r": ".ply",
    FREESURFER_MAGIC: ".surf",
    b"\x1f\x8b": ".gii.gz",
}
READABLE_SUFFIXES = (*BYTE_READERS, *REFERRING_READERS, *PATH_READERS, *PATCH_SUFFIXES)
# Formats whose writer reproduces the file that was read.
LOSSLESS_SOURCES: dict[str, type] = {".obj": ObjText, ".ply": PlyTables, ".glb": GltfFile, ".gltf": GltfFile}
# Formats whose writer makes a new file, and copies the format-specific contents that `kept` lists.
PARTIAL_SOURCES: dict[str, type[ThreeMfFile | VtpFile | GiftiFile | FreeSurferFile]] = {
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
    ".surf": save_freesurfer,
    **dict.fromkeys(PATCH_SUFFIXES, save_patch),
}
WITH_IMAGES = (".glb", ".gltf", ".obj", ".3mf")
FLAT = (".gii", ".gii.gz", ".surf", *PATCH_SUFFIXES)  # formats that store the flat map as the surface
WITH_BARE_FACES = (".glb", ".gltf", ".obj")  # formats whose faces may lack texture coordinates
WITH_TWO_MAPS = (".glb", ".gltf", ".ply", ".obj")
ImageArgument = ArrayLike | Sequence[ArrayLike] | Mapping[str, ArrayLike | Sequence[ArrayLike]] | None


def normalize_suffix(path: str | os.PathLike[str]) -> str:
    """Return the suffix of a file name in lower case, such as ".obj" or ".gii.gz"."""
    ends = [end.lower() for end in Path(path).suffixes[-2:]]
    return "".join(ends) if ends[-1:] == [".gz"] else "".join(ends[-1:])


def is_flat_format(path: str | os.PathLike[str]) -> bool:
    """Return True if the file format stores the flat map as the surface itself, so that its size matters."""
    return normalize_suffix(path) in FLAT


def detect_suffix(data: bytes) -> str:
    """Return the suffix of the format that begins with these bytes; ".obj" if they match no other format."""
    with suppress(Damaged):
        data = convert_to_utf8(data)
    first, triangles = data[:100].split(maxsplit=1)[:1], int.from_bytes(data[80:84], "little")
    if first and first[0].endswith(b"OFF"):
        return ".off"
    if data[:5].lower() == b"solid" or (len(data) >= 84 and len(data) == 84 + 50 * triangles):
        return ".stl"
    if data.lstrip().startswith(b"<"):
        return ".gii" if b"<GIFTI" in data else ".vtp"
    return next((suffix for begin, suffix in SUFFIX_OF_MAGIC.items() if data.startswith(begin)), ".obj")


@np.errstate(invalid="ignore")  # NumPy warns when it casts signalling NaN
def parse_file(
    path: str | os.PathLike[str], surface: str | os.PathLike[str] | None = None, allow_outside: bool = False
) -> MeshFile:
    """Read the mesh of a file with the reader for its suffix; FreeSurfer files may have any suffix."""
    path = Path(path)
    check_regular_file(path)
    suffix = normalize_suffix(path)
    if suffix not in READABLE_SUFFIXES or suffix in PATCH_SUFFIXES:
        with path.open("rb") as file:
            head = file.read(len(PATCH_MAGIC))
        if head == PATCH_MAGIC or suffix in PATCH_SUFFIXES:
            return _parse_freesurfer_patch(path, surface)
        if not head.startswith(FREESURFER_MAGIC):
            raise ValueError(
                f"{path} is not a mesh file: use one that ends in {', '.join(READABLE_SUFFIXES)}"
            )
    if surface is not None:
        raise ValueError(f"{path} is not a patch, and contains its own surface: leave out the surface")
    if suffix in BYTE_READERS:
        return parse_bytes(path.read_bytes(), suffix, str(path))
    refers, read = REFERRING_READERS.get(suffix), PATH_READERS.get(suffix, parse_freesurfer)
    try:
        return refers(path, allow_outside) if refers else read(path)
    except Damaged as damage:
        what = suffix[1:].upper() if refers or read is not parse_freesurfer else "FreeSurfer"
        raise MeshError(f"{path} cannot be read as {what}: {damage}") from None


def select_second_uv_set(mesh: MeshFile, path: Path) -> MeshFile:
    """Return a mesh with its second texture coordinates, if any, as `TC`, and its first as `first`."""
    source = mesh.extras.source
    if isinstance(source, GltfFile):
        found = select_second_gltf(mesh, source)
    elif isinstance(source, PlyTables):
        found = select_second_ply(mesh, source)
    else:
        second = f"; for OBJ, read {get_second_map_path(path).name}" * (path.suffix.lower() == ".obj")
        raise ValueError(f"{path} holds one set of texture coordinates: use GLB, glTF or PLY{second}")
    if found.TC is None or found.texture is None or (found.texture < 0).all():
        return replace(found, TC=None, texture=None)
    if mesh.TC is None or mesh.texture is None:
        raise MeshError(f"{path} has second texture coordinates, but no first ones: make them the first ones")
    return replace(found, first=(mesh.TC, np.maximum(mesh.texture, -1)))


def _parse_freesurfer_patch(path: Path, surface: str | os.PathLike[str] | None) -> MeshFile:
    """Read a patch on the given surface, or on the surface that FreeSurfer's file names associate with it."""
    hemisphere = path.name.partition(".")[0]
    paths = find_companion_surfaces(path.parent, hemisphere) if surface is None else [Path(surface)]
    if not paths:
        hemisphere = hemisphere if hemisphere in ("lh", "rh") else "lh"
        raise MeshError(
            f"{path} is a patch, which has vertices and no faces, and its surface is not beside it: pass it "
            f"as surface= ({hemisphere}.fiducial, {hemisphere}.smoothwm, ...)"
        )
    meshes = [replace(parse_file(path_), path=path_) for path_ in paths]
    try:
        return parse_patch(path, average_surfaces(meshes))
    except Damaged as damage:
        raise MeshError(f"{path} cannot be read as a patch: {damage}") from None


def parse_bytes(data: bytes, suffix: str, name: str) -> MeshFile:
    """Parse the mesh from the bytes of a file.

    Parameters
    ----------
    data : bytes
    suffix : {".obj", ".off", ".ply", ".stl"}
    name : str
        Name of the file in messages.

    Raises
    ------
    MeshError
        The file is damaged; the message names the place.

    Warns
    -----
    MeshWarning
        An OBJ file has lines that are not OBJ statements; they are skipped.
    """
    try:
        return BYTE_READERS[suffix](data, name)
    except Damaged as damage:
        raise MeshError(f"{name} cannot be read as {suffix[1:].upper()}: {damage}") from None


def _adapt_names(mesh: MeshFile, suffix: str) -> tuple[MeshFile, list[str]]:
    """Return the mesh with names that the format can store, and a description of the names that changed."""
    extras = mesh.extras
    if isinstance(extras.source, LOSSLESS_SOURCES.get(suffix, ())):
        return mesh, []

    def adapt_labels(labels: FaceLabels | None) -> FaceLabels | None:
        if labels is None:
            return None
        names, index = labels
        return (make_obj_names(names) if suffix == ".obj" else tuple(map(_escape_invalid_utf8, names))), index

    adapted = replace(extras, parts=adapt_labels(extras.parts), materials=adapt_labels(extras.materials))
    old_names, new_names = (
        [*(fields.parts or ((),))[0], *(fields.materials or ((),))[0]] for fields in (extras, adapted)
    )
    changed = [
        " ".join(_escape_invalid_utf8(name).split())
        for name, new_name in zip(old_names, new_names, strict=True)
        if name != new_name
    ]
    if changed:
        changed = [f"the exact names ({first_few(changed)})"]
    return replace(mesh, extras=adapted), changed


def _escape_invalid_utf8(name: str) -> str:
    """Return the name with escape codes such as \\xba for bytes that are not UTF-8."""
    return encode_utf8(name).decode("utf-8", "backslashreplace")


def warn_of_loss(mesh: MeshFile, suffix: str, changed: Sequence[str] = ()) -> None:
    """Issue one warning that lists the contents of the mesh that a file of this format cannot store."""
    extras, source, lost = mesh.extras, mesh.extras.source, list[str]()
    if isinstance(source, LOSSLESS_SOURCES.get(suffix, ())):
        return
    if suffix in FLAT and mesh.path is not None and not isinstance(source, Patch):
        lost.append("the positions in space")
    if suffix in FLAT and len(split_vertices(mesh).vertex) > len(np.unique(mesh.polygons.corners)):
        lost.append("the vertex numbers (each vertex is written once for each of its texture coordinates)")
    if suffix in (".ply", ".vtp", *FLAT):
        lost += ["the names of its parts"] * bool(mesh.parts)
    if suffix == ".3mf" and mesh.images is not None:
        pass  # the new texture contains the colours of the materials
    elif suffix in (".ply", ".vtp", ".3mf", *FLAT):
        lost += ["its materials"] * bool(mesh.materials)
    elif mesh.images is not None and mesh.images.moved:
        nearest = any(image_map.nearest for look in extras.looks or () for image_map in look.maps)
        lost += ["the filter NEAREST of its images"] * (suffix == ".obj" and nearest)
    elif any(look.images for look in extras.looks or ()):
        lost.append("the images of its materials")
    elif mesh.materials and extras.looks is None:
        lost.append("its materials, except for their names")
    if suffix in GLTF_SUFFIXES and (keys := find_keys_unknown_to_gltf(extras.looks or ())):
        lost.append(f"{', '.join(keys)} of its materials")
    if mesh.images is None:
        lost += _list_lost_colours(extras, suffix)
    if extras.comments and suffix in (".3mf", ".vtp", *FLAT):
        lost.append("its comments")
    if extras.normals is not None and suffix in (".3mf", *FLAT):
        lost.append("normals")
    if suffix == ".3mf" and (mesh.polygons.sizes > 3).any():
        lost.append("polygons with more than three corners")
    if extras.units not in (None, "meter") and suffix in (".ply", ".vtp", ".obj"):
        lost.append(f"the unit of length ({extras.units})")
    partial = PARTIAL_SOURCES.get(suffix)
    kept = source.kept if partial is not None and isinstance(source, partial) else ()
    lost += [*(message for message in extras.unshared if message not in kept), *changed]
    if lost:
        message = f"{suffix[1:].upper()} does not keep {', '.join(lost)}"
        if mesh.path is not None:
            message += f" of {mesh.path.name}"
        lossless = next(
            (lossless for lossless, kind in LOSSLESS_SOURCES.items() if isinstance(source, kind)), None
        )
        if lossless is not None:
            message += f": write {lossless[1:].upper()} to keep all of it"
        warnings.warn(message, MeshWarning, stacklevel=stack_level())


def find_object_frames(mesh: MeshFile, path: str | os.PathLike[str]) -> FloatArray | None:
    """Return the linear maps from the spaces of the objects in a written file to the space of V.

    Returns
    -------
    (#F, 3, 3) float64 or None
        For each face, the linear map from the space of its object to the space of V; None if the format does
        not transform objects.
    """
    source = mesh.extras.source
    if not isinstance(source, GltfFile) or normalize_suffix(path) not in GLTF_SUFFIXES:
        return None
    assert mesh.extras.parts is not None  # every glTF file has parts
    return source.frames[mesh.extras.parts[1]]


def transform_to_object_space(mesh: MeshFile, path: str | os.PathLike[str]) -> tuple[FloatArray, FloatArray]:
    """Return V, and normals at triangle corners (#T, 3, 3), in the object spaces of a written file.

    Translations are ignored. An object mirrored by its node is reflected through a point, which matches the
    orientation of its faces.
    """
    V, normals, frames = mesh.V, compute_corner_normals(mesh), find_object_frames(mesh, path)
    if frames is None:
        return V, normals
    sign = np.where(np.linalg.det(frames) < 0, -1.0, 1.0)
    face = np.zeros(len(V), dtype=np.int64)
    face[mesh.polygons.corners] = mesh.polygons.polygon_of_corner
    inverse = np.linalg.pinv(frames) * sign[:, None, None]
    rotated = normals @ (frames * sign[:, None, None])[mesh.triangulation.face]
    return np.einsum("vij,vj->vi", inverse[face], V), normalize_vectors(rotated)


def has_transformed_textures(mesh: MeshFile, texcoord: int = 0) -> bool:
    """Return True if the file's materials transform the texture coordinates before the image lookup."""
    source = mesh.extras.source
    return isinstance(source, GltfFile) and has_texture_transforms(source.gltf.text, texcoord)


def _list_lost_colours(extras: Extras, suffix: str) -> list[str]:
    """Return descriptions of the colours that a format cannot store; call it only if no image shows them."""
    lost = list[str]()
    if extras.colours is not None and suffix in (".3mf", *FLAT):
        lost.append("colours")
    elif extras.colours is not None and suffix == ".obj" and (extras.colours[:, 3:] < 1).any():
        lost.append("the alpha of its colours")
    if suffix in GLTF_SUFFIXES and extras.colours is not None and extras.face_colours is not None:
        lost.append("the colours of its vertices, because a corner has one colour and faces have some, too")
    if extras.face_colours is not None and suffix not in (".ply", ".vtp", ".glb", ".gltf"):
        lost.append("the colours of its faces")
    if extras.corner_colours is not None and suffix not in GLTF_SUFFIXES:
        lost.append("the colours of its corners")
    return lost


def list_companion_files(
    path: Path, mesh: MeshFile | None, kinds: Iterable[str] = (), pages: int = 1, second: bool = False
) -> tuple[Path, ...]:
    """Return the paths of the files that are written next to an OBJ file: MTL file, images, second map.

    If the mesh is not known, the paths for any mesh are returned.
    """
    if path.suffix.lower() != ".obj":
        return ()
    images = [file for kind in kinds for file in get_image_paths(path, kind, pages)]
    beside = [get_second_map_path(path)] if second else []
    return (
        *([get_library_path(path)] if images or mesh is None or has_library(mesh) else []),
        *images,
        *beside,
    )


def get_second_map_path(path: Path) -> Path:
    """Return the path of the file next to an OBJ file that stores the second texture coordinates."""
    return path.with_name(f"{path.stem}_texcoord1{path.suffix}")


def check_no_file_exists(paths: Iterable[Path], force: bool) -> None:
    """Raise `FileExistsError` if any of the files exists, unless `force` is set."""
    for path in paths:
        if os.path.lexists(path) and not force:
            message = (
                "it is there already, and is not the output file itself: move it, write under another name, "
                "or replace it with force=True"
            )
            raise FileExistsError(EEXIST, message, str(path))


@contextmanager
def write_atomically(
    path: str | os.PathLike[str],
    mesh: MeshFile,
    TC: ArrayLike,
    FTC: ArrayLike | None = None,
    image: ImageArgument = None,
    *,
    force: bool = False,
    folder: Path | None = None,
    texcoord: int = 0,
) -> Iterator[None]:
    """Write files under temporary names, and rename the files when the `with` block succeeds.

    References to other files are relative to `folder`, by default the folder of `path`.
    """
    if texcoord not in (0, 1):
        raise ValueError(f"texcoord is {texcoord!r}: pass 0, or 1 for second texture coordinates")
    path = Path(path)
    suffix = normalize_suffix(path)
    if suffix not in WRITERS:
        raise ValueError(f"{path} has an unknown suffix: use {', '.join(WRITERS)}")
    if image is not None and suffix not in WITH_IMAGES:
        raise ValueError(f"{path} cannot hold an image: write one of {', '.join(WITH_IMAGES)}")
    if texcoord and suffix not in WITH_TWO_MAPS:
        known = ", ".join(WITH_TWO_MAPS)
        raise ValueError(f"{path} holds one set of texture coordinates: write one of {known}")
    if texcoord and image is not None:
        raise ValueError("an image needs the first texture coordinates: leave out the image or texcoord=1")
    images = _select_images(encode_images(image), suffix)
    new = mesh.with_second_texture(TC, FTC) if texcoord else mesh.with_texture(TC, FTC)
    if new.lacks_texture.any() and suffix not in WITH_BARE_FACES:
        _warn_of_filled_corners(new, suffix)
        new = new.fill_missing_texture()
    rewritten = isinstance(mesh.extras.source, GltfFile) and suffix in GLTF_SUFFIXES
    prepared, changed = _adapt_names(split_materials_by_page(replace(new, images=images), rewritten), suffix)
    kinds = {} if images is None else images.maps
    pages = 1 if images is None else images.pages
    check_no_file_exists(list_companion_files(path, prepared, kinds, pages, bool(texcoord)), force)
    warn_of_loss(prepared, suffix, changed)
    beside = encode_material_files(prepared, path) if suffix == ".obj" else {}
    with ExitStack() as stack:
        temporary = stack.enter_context(replacing(path))
        for side_path, data in beside.items():
            Path(stack.enter_context(replacing(side_path))).write_bytes(data)
        named = path if folder is None else folder / path.name
        if suffix == ".obj" and prepared.first is not None:
            second = get_second_map_path(path)
            _warn_of_second_map(second)
            first = replace(prepared, TC=prepared.first[0], texture=prepared.first[1], first=None)
            with warnings.catch_warnings():  # no warning: images still match the first texture coordinates
                warnings.filterwarnings(
                    "ignore", "its materials have .* for the old texture coordinates", MeshWarning
                )
                WRITERS[suffix](stack.enter_context(replacing(second)), replace(prepared, first=None), named)
                WRITERS[suffix](temporary, first, named)
        else:
            WRITERS[suffix](temporary, prepared, named)
        yield


def _warn_of_filled_corners(mesh: MeshFile, suffix: str) -> None:
    warnings.warn(
        f"{suffix[1:].upper()} has texture coordinates at all corners: "
        f"{', '.join(mesh.list_parts_without_texture())} without coordinates get 0, 1; write GLB or OBJ to "
        "leave them out",
        MeshWarning,
        stacklevel=stack_level(),
    )


def _warn_of_second_map(second: Path) -> None:
    warnings.warn(
        f"OBJ holds one set of texture coordinates: the second set is in {second.name}, on the same vertices "
        "and faces",
        MeshWarning,
        stacklevel=stack_level(),
    )


def encode_images(image: ImageArgument) -> Images | None:
    """Encode images as PNG: a single image, one image per page, or a dict of images by kind of map."""
    if image is None:
        return None
    if isinstance(image, Mapping):
        return Images({kind: _encode_pages(pages) for kind, pages in image.items()}, moved=True)
    return Images({COLOUR: _encode_pages(image)})


def _encode_pages(image: Any) -> tuple[bytes, ...]:
    several = isinstance(image, list | tuple) and len(image) > 0 and np.ndim(image[0]) > 1
    if isinstance(image, np.ndarray) and image.ndim == 4:
        several = True
    return tuple(encode_png(page) for page in image) if several else (encode_png(image),)


def _select_images(images: Images | None, suffix: str) -> Images | None:
    """Return the images that the format can store, and warn of images that it cannot store."""
    if images is None:
        return None
    if suffix == ".3mf" and images.pages > 1:
        raise ValueError(
            f"3MF files are written with one texture, and the atlas has {images.pages} pages: write GLB or "
            "OBJ, or use one page"
        )
    accepts: dict[str, Callable[[str], bool]] = {
        ".3mf": lambda kind: kind == COLOUR,
        ".obj": lambda kind: kind in MTL_KEYWORDS or (has_image(kind) and not kind.endswith(TEXTURE_SUFFIX)),
    }
    kept = {kind: pages for kind, pages in images.maps.items() if accepts.get(suffix, _is_gltf_kind)(kind)}
    lost = sorted(set(images.maps) - set(kept))
    if lost:
        warnings.warn(
            f"{suffix[1:].upper()} cannot store the maps {', '.join(lost)}: they are left out",
            MeshWarning,
            stacklevel=stack_level(),
        )
    return replace(images, maps=kept)


def _is_gltf_kind(kind: str) -> bool:
    return kind.endswith(TEXTURE_SUFFIX)


def split_materials_by_page(mesh: MeshFile, unchanged: bool) -> MeshFile:
    """Return the mesh with one material for each page of its images.

    With `unchanged`, return the mesh itself, because the writer splits the materials.
    """
    images, extras = mesh.images, mesh.extras
    if images is None or images.pages == 1 or unchanged:
        return mesh
    names, material = extras.materials or ((), np.full(len(mesh.polygons), -1))
    looks = list(extras.looks or [Material()] * len(names))
    if (material < 0).any():
        names, looks = (*names, make_unused_name(names, DEFAULT_MATERIAL)), [*looks, Material()]
        material = np.where(material < 0, len(names) - 1, material)
    pairs, index = np.unique(np.column_stack((material, find_face_pages(mesh))), axis=0, return_inverse=True)
    page_names = tuple(
        f"{names[i]}.{FIRST_UDIM_TILE + page}" if page else names[i] for i, page in pairs.tolist()
    )
    page_looks = tuple(replace(looks[i], page=page) for i, page in pairs.tolist())
    return replace(mesh, extras=replace(extras, materials=(page_names, index.ravel()), looks=page_looks))
