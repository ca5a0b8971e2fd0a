"""Read contents of a mesh file that `unwrap` uses: seams of texture coordinates, and materials.

Also warn of parts of the file that lack texture coordinates.
"""

import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np

from .._types import FloatArray, IntArray
from ..charts import ChartOptions, Packing, texture_seams, unwrap
from ..errors import MeshError, MeshWarning, first_few, format_count, stack_level
from ..flattening import Method
from ..io import MeshFile
from ..surface import Faces, Polygons


def find_texture_seams(mesh: MeshFile, charts: ChartOptions | None, method: Method) -> Any:
    """Return a mask of the sides of faces at seams of the texture coordinates, as `seams` of `unwrap`.

    Faces without texture coordinates get the seams of an automatic atlas.
    """
    if mesh.TC is None or mesh.FTC is None:
        raise MeshError(f"{mesh.path} has no texture coordinates: it has no texture seams")
    TC, FTC = (
        _unwrap_faces_without_texture(mesh, charts, method)
        if mesh.lacks_texture.any()
        else (mesh.TC, mesh.FTC)
    )
    return texture_seams(mesh.F, FTC, mesh.V, TC, sides=True)


def get_material_labels(mesh: MeshFile) -> IntArray:
    """Return the material of each face, as labels of `ChartOptions`."""
    if mesh.extras.materials is None:
        raise MeshError(f"{mesh.path} has no materials: leave out keep_materials")
    return mesh.extras.materials[1]


def warn_of_parts_without_texture(mesh: MeshFile, consequences: Iterable[str]) -> None:
    """Warn of the parts without texture coordinates, and state what is done with them."""
    listed, texts = mesh.list_parts_without_texture(), list(consequences)
    if not listed or not texts:
        return
    count = int(np.count_nonzero(mesh.lacks_texture))
    warnings.warn(
        f"{format_count(count, 'face')} without texture coordinates, in {first_few(listed)}: "
        f"{', '.join(texts)}",
        MeshWarning,
        stacklevel=stack_level(),
    )


def warn_of_missing_coordinates(mesh: MeshFile, bake: str | None, texcoord: int, seams: Any) -> None:
    """Warn of parts that lack the texture coordinates which the options of an atlas need."""
    if mesh.TC is None:
        return
    consequences = {
        "no image is baked for them": bake == "texture",
        "both sets get the new ones": texcoord == 1,
        "their seams are found automatically": seams == "uv",
    }
    warn_of_parts_without_texture(mesh, [text for text, is_asked in consequences.items() if is_asked])


def _unwrap_faces_without_texture(
    mesh: MeshFile, charts: ChartOptions | None, method: Method
) -> tuple[FloatArray, Faces]:
    """Return the texture coordinates of a mesh; faces without texture coordinates get an automatic atlas."""
    assert mesh.TC is not None and mesh.texture is not None
    corners, sizes = (
        mesh.polygons.select_corners(np.flatnonzero(mesh.lacks_texture)),
        mesh.polygons.sizes[mesh.lacks_texture],
    )
    bare = Polygons(mesh.polygons.corners[corners], sizes)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the whole mesh is unwrapped later, with the same warnings
        atlas = unwrap(
            mesh.V, bare.as_faces, charts=charts, method=method, packing=Packing(cut_below=0), progress=False
        )
    texture = mesh.texture.copy()
    texture[corners] = len(mesh.TC) + bare.parse_texture_indices(atlas.FTC).corners
    beside = np.ceil(mesh.TC.max(axis=0)) + 1  # moves the new charts to UDIM tiles without old charts
    return np.concatenate((mesh.TC, atlas.TC + beside)), mesh.polygons.reshape_like_faces(texture)
