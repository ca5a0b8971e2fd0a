"""Collect the colours, normals and images of a mesh file at the corners of its faces."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace

import igl
import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray
from ..errors import MeshWarning, first_few, stack_level
from ..surface import connected_labels, normalize_vectors
from ..textures import Picture
from .materials import COLOUR, WHITE, ImageMap, decode_srgb, encode_srgb
from .mesh_file import Extras, MeshFile
from .pictures import decode_image, measure_image

GLTF_SUFFIXES = (".glb", ".gltf")
DIRECTION_SUFFIXES = ("normaltexture", "anisotropytexture")  # glTF textures that store directions
BUMP_KEYWORDS = ("bump", "map_bump")  # MTL's keywords for height maps
UNIT_FACTOR = (1.0, 1.0, 1.0, 1.0)  # RGBA multiplier that leaves a colour unchanged


def get_stored_colours(mesh: MeshFile) -> FloatArray | None:
    """Return the stored colours of corners, faces or vertices, at the corners (#C, 3 or 4), or None.

    The colours of materials are ignored.
    """
    extras, polygons = mesh.extras, mesh.polygons
    if extras.corner_colours is not None:
        return extras.corner_colours
    if extras.face_colours is not None:
        return extras.face_colours[polygons.polygon_of_corner]
    return None if extras.colours is None else extras.colours[polygons.corners]


def get_corner_colours(mesh: MeshFile) -> FloatArray | None:
    """Return the colours at the corners of the faces, (#C, 3 or 4), from 0 to 1; None without colours.

    In glTF and 3MF, vertex colours are multiplied by material colours in linear RGB. In other formats,
    material colours are used only if corners, faces and vertices have no colours. A fourth column, alpha, is
    returned if any colour is transparent.
    """
    extras, polygons = mesh.extras, mesh.polygons
    n, looks, stored = len(polygons.corners), extras.looks or (), get_stored_colours(mesh)
    from_materials = stored is None
    if stored is None:
        if all(look.factor is None and look.colour == WHITE for look in looks):
            return None
        stored = np.ones((n, 4))
    colours = np.column_stack((stored[:, :3], stored[:, 3] if stored.shape[1] > 3 else np.ones(n)))
    multipliers = [
        look.factor or ((*decode_srgb(np.array(look.colour)), look.alpha) if from_materials else UNIT_FACTOR)
        for look in looks
    ]
    if extras.materials is not None and set(multipliers) - {UNIT_FACTOR}:
        # faces without a material have the index -1, which selects the last row: UNIT_FACTOR
        factor_of_corner = np.array([*multipliers, UNIT_FACTOR])[extras.materials[1]][
            polygons.polygon_of_corner
        ]
        colours = np.column_stack(
            (
                encode_srgb(decode_srgb(colours[:, :3]) * factor_of_corner[:, :3]),
                colours[:, 3] * factor_of_corner[:, 3],
            )
        )
    return colours if (colours[:, 3] < 1).any() else colours[:, :3]


def compute_corner_normals(mesh: MeshFile) -> FloatArray:
    """Return the normals at the corners of the triangles, (#T, 3, 3), as a viewer of the file computes them.

    If the file has no normals, return face normals for glTF, as its specification requires, and vertex
    normals for all other formats.
    """
    V, triangles, stored = mesh.V, mesh.triangles, mesh.extras.normals
    if stored is not None and mesh.extras.normal is not None:
        normals = stored[mesh.extras.normal[mesh.triangulation.place]]
    elif mesh.path is not None and mesh.path.suffix.lower() in GLTF_SUFFIXES:
        a, b, c = V[triangles.T]
        normals = np.repeat(np.cross(b - a, c - a)[:, None], 3, axis=1)
    else:
        normals = np.nan_to_num(igl.per_vertex_normals(V, triangles))[triangles]
    return normalize_vectors(normals)


def image_maps(mesh: MeshFile) -> dict[str, list[Picture | None]]:
    """Return the material images that use the mesh's texture coordinates, as input of `bake_texture`.

    Parameters
    ----------
    mesh : MeshFile
        A mesh from `read_file`.

    Returns
    -------
    dict
        For each kind of map, such as "baseColorTexture" or MTL's "map_Ks", a list with an image or None for
        each material.

    Raises
    ------
    MeshError
        An image is missing or cannot be read.

    Examples
    --------
    >>> import igl, igl_linabf, numpy as np, os, tempfile
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F)
    >>> path = os.path.join(tempfile.mkdtemp(), "ball.glb")
    >>> igl_linabf.io.write_textured(path, V, F, atlas.TC, atlas.FTC, np.ones((8, 8, 3)))
    >>> maps = image_maps(igl_linabf.io.read_file(path))
    >>> [(kind, len(images), images[0].pixels.shape) for kind, images in maps.items()]
    [('baseColorTexture', 1, (8, 8, 3))]
    """
    decoded: dict[bytes, FloatArray] = {}

    def decode_once(read: Callable[[], bytes], what: str) -> FloatArray:
        data = read()
        if data not in decoded:
            decoded[data] = decode_image(data, what)
        return decoded[data]

    looks = mesh.extras.looks or ()
    kinds = dict.fromkeys(image_map.kind for look in looks for image_map in look.maps)
    images: dict[str, list[Picture | None]] = {kind: [None] * len(looks) for kind in kinds}
    for i, look in enumerate(looks):
        for image_map in look.maps:
            what = _name_image(mesh, i, image_map)
            tiles = {page: decode_once(read, what) for page, read in image_map.tiles.items()}
            pixels = next(iter(tiles.values())) if tiles else decode_once(image_map.read, what)
            images[image_map.kind][i] = Picture(
                pixels, image_map.wrap, image_map.matrix, image_map.nearest, tiles
            )
    return images


def replace_values_that_are_not_finite(extras: Extras, name: str) -> Extras:
    """Replace colours that are not finite by white, and such normals by zero, and warn; `name` is a file."""

    def replace_rows(values: FloatArray | None, what: str, by: float, said: str) -> FloatArray | None:
        if values is None:
            return None
        with np.errstate(over="ignore", invalid="ignore"):
            finite = np.isfinite(np.linalg.norm(values, axis=1))
        if finite.all():
            return values
        bad = first_few(np.flatnonzero(~finite))
        message = f"the {what} {bad} of {name} are not finite: they are read as {said}"
        warnings.warn(message, MeshWarning, stacklevel=stack_level())
        return np.where(finite[:, None], values, by)

    return replace(
        extras,
        colours=replace_rows(extras.colours, "colours of vertices", 1.0, "white"),
        corner_colours=replace_rows(extras.corner_colours, "colours of corners", 1.0, "white"),
        face_colours=replace_rows(extras.face_colours, "colours of faces", 1.0, "white"),
        normals=replace_rows(extras.normals, "normals", 0.0, "zero"),
    )


def find_largest_image(mesh: MeshFile) -> tuple[str, tuple[int, int]] | None:
    """Return the name, and the width and height, of the largest image on the texture coordinates.

    Images of colours precede all other images. The result is None if there is no image.

    Raises
    ------
    MeshError
        An image is missing or cannot be read.
    """
    sizes: dict[str, tuple[int, int]] = {}
    maps = [(i, image_map) for i, look in enumerate(mesh.extras.looks or ()) for image_map in look.maps]
    for i, image_map in [pair for pair in maps if pair[1].kind == COLOUR] or maps:
        name = _name_image(mesh, i, image_map)
        read = next(iter(image_map.tiles.values()), image_map.read)
        sizes[name] = measure_image(read(), name)
    return max(sizes.items(), key=lambda pair: pair[1][0] * pair[1][1], default=None)


def _name_image(mesh: MeshFile, material: int, image_map: ImageMap) -> str:
    return f"{image_map.kind} of {mesh.materials[material]}"


def list_image_users(mesh: MeshFile) -> NDArray[np.str_] | None:
    """Return for each face, (#F,), the names of the materials in the same group as its material.

    Materials that share an image are in the same group. Materials without an image form one group.
    Return None if all faces belong to the same group.
    """
    if mesh.extras.materials is None:
        return None
    names, of_face = mesh.extras.materials
    looks = mesh.extras.looks or ()
    images = [{image_map.image for image_map in look.maps} or {None} for look in looks]
    first = {image: i for i, own in reversed([*enumerate(images)]) for image in own}
    pairs = [(i, first[image]) for i, own in enumerate(images) for image in own]
    group = connected_labels(np.array(pairs, dtype=np.int64).reshape(-1, 2), len(images))
    users = [
        ", ".join(name for name, other in zip(names, group, strict=True) if other == own) for own in group
    ]
    bare = next((users[i] for i, own in enumerate(images) if None in own), "no material")
    listed = np.array([*users, bare])[of_face]
    return listed if len(np.unique(listed)) > 1 else None


def is_direction_map(kind: str, images: Sequence[Picture | None]) -> bool:
    """Return True if images of this kind store directions in tangent space, for example normal maps.

    Colour images under MTL's keyword for bump maps count as normal maps. The MTL specification defines bump
    maps as grey height maps, but many programs store normal maps under the same keyword.
    """
    if kind.lower() in BUMP_KEYWORDS:
        pixels = [image.pixels for image in images if image is not None]
        return any(rows.shape[2] >= 3 and bool(np.ptp(rows[..., :3], axis=2).any()) for rows in pixels)
    return kind.lower().endswith(DIRECTION_SUFFIXES)
