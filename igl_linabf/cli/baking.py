"""Bake the textures that `igl-linabf unwrap --bake` writes."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import igl
import numpy as np

from .._types import FloatArray
from ..charts import Atlas, Packing, page_size
from ..errors import MeshError
from ..io import (
    COLOUR,
    WITH_IMAGES,
    MeshFile,
    corner_colours,
    find_object_frames,
    image_maps,
    is_direction_map,
    transform_to_object_space,
)
from ..surface import unit_vectors
from ..textures import bake, bake_texture, check_image_memory

BAKED_RESOLUTION = 2048  # default side length of a baked texture, in texels

COLOUR_CHANNELS = 3  # assumed number of channels when the memory of images is estimated

LIGHT_KINDS = ("emissiveTexture",)  # images of emitted light, which is 0 where a face has no image

BakeName = Literal["colors", "texture", "normals", "position"]


@dataclass(frozen=True, kw_only=True)
class BakedPacking(Packing):
    """The packing of charts for a baked texture, with a default resolution."""

    bake: BakeName | None = None

    def __post_init__(self) -> None:
        if self.bake and self.resolution is None:
            object.__setattr__(self, "resolution", BAKED_RESOLUTION)
        super().__post_init__()


def list_image_kinds(kind: BakeName | None, mesh: MeshFile) -> list[str]:
    """Return the kinds of image maps that `--bake` writes."""
    if kind == "texture":
        return [of.kind for look in mesh.extras.looks or () for of in look.maps]
    return [] if kind is None else [COLOUR]


def check_baking(packing: BakedPacking, mesh: MeshFile, output: Path, texcoord: int) -> None:
    """Raise an error if the requested texture cannot be baked. Called before the computation."""
    kind = packing.bake
    if output.suffix.lower() not in WITH_IMAGES:
        known = " or ".join(WITH_IMAGES)
        raise ValueError(f"--bake needs a file with a texture: give an output that ends in {known}")
    if texcoord:
        raise ValueError("--bake is for the first texture coordinates: leave out --texcoord, or --bake")
    if kind == "colors" and corner_colours(mesh) is None:
        raise MeshError(
            f"{mesh.path} has no colours of vertices, faces or materials: bake normals or position"
        )
    if kind == "texture" and (mesh.TC is None or mesh.FTC is None):
        raise MeshError(f"{mesh.path} has no texture coordinates: it has no texture to move")
    size = page_size(packing.resolution or BAKED_RESOLUTION)
    kinds = set(list_image_kinds(kind, mesh))
    check_image_memory(size, max(len(kinds), 1), COLOUR_CHANNELS)  # at least one page is written


def bake_images(packing: BakedPacking, mesh: MeshFile, atlas: Atlas, output: Path) -> Any:
    """Return the baked image or a list with one image per page; for `--bake texture`, by kind in a dict."""
    if packing.bake is None:
        return None
    if packing.bake == "texture":
        return _rebake_textures(mesh, atlas, packing.resolution, output)
    image = _bake_values(packing.bake, mesh, atlas, packing.resolution, output)
    return list(image) if atlas.pages > 1 else image


def _bake_values(kind: str, mesh: MeshFile, atlas: Atlas, resolution: Any, output: Path) -> FloatArray:
    V, triangles = mesh.V, mesh.triangles
    if kind == "colors":
        colours = corner_colours(mesh)
        assert colours is not None  # ensured by `check_baking`
        return bake(V, mesh.F, atlas, colours[mesh.split.place], resolution)
    if kind == "normals":
        normals = np.nan_to_num(igl.per_vertex_normals(V, triangles))[triangles]
        frames = find_object_frames(mesh, output)
        if frames is not None:
            normals = unit_vectors(normals @ frames[mesh.split.face])
        return unit_vectors(bake(V, mesh.F, atlas, normals, resolution)) / 2 + 0.5
    used = V[np.unique(triangles)]
    low, size = used.min(axis=0), np.ptp(used, axis=0).max()
    return bake(V, mesh.F, atlas, (V - low) / (size if size > 0 else 1.0), resolution)


def _rebake_textures(mesh: MeshFile, atlas: Atlas, resolution: Any, output: Path) -> dict[str, Any]:
    """Return the images of the materials, baked for the new texture coordinates."""
    maps = image_maps(mesh)
    if not maps:
        raise MeshError(
            f"{mesh.path} has no images on its texture coordinates that can be moved, such as in materials "
            "in OBJ or glTF: bake colors or normals"
        )
    assert mesh.extras.materials is not None  # because image maps belong to materials
    assert mesh.TC is not None  # ensured by `check_baking`
    made: dict[str, Any] = {}
    V, directions = transform_to_object_space(mesh, output)
    for kind, images in maps.items():
        normals = directions if is_direction_map(kind, images) else None
        image = bake_texture(
            V,
            mesh.F,
            atlas,
            mesh.TC,
            mesh.FTC,
            images,
            resolution,
            labels=mesh.extras.materials[1],
            normals=normals,
            bare=0.0 if kind in LIGHT_KINDS else 1.0,
        )
        made[kind] = list(image) if atlas.pages > 1 else image
    return made
