"""Bake the textures that `igl-linabf unwrap` and `batch` write with `--bake`."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, Literal, get_args

import igl
import numpy as np

from .._types import FloatArray
from ..charts import Atlas, Packing, parse_page_size, resolve_packing
from ..errors import MeshError
from ..io import (
    COLOUR,
    MTL_KEYWORDS,
    WITH_IMAGES,
    WITH_TWO_MAPS,
    MeshFile,
    find_object_frames,
    get_corner_colours,
    image_maps,
    is_direction_map,
    normalize_suffix,
    transform_to_object_space,
)
from ..surface import normalize_vectors
from ..textures import bake, bake_texture, check_image_memory

BAKED_RESOLUTION = 2048  # default side length of a baked texture, in texels

COLOUR_CHANNELS = 3  # assumed number of channels when the memory of images is estimated

LIGHT_KINDS = ("emissiveTexture",)  # images of emitted light, which is 0 where a face has no image

BakeName = Literal["colors", "colours", "texture", "normals", "position"]


@dataclass(frozen=True, kw_only=True)
class BakedPacking(Packing):
    """The packing of charts for a baked texture, with a default resolution."""

    bake: BakeName | None = None

    @classmethod
    def from_packing(cls, packing: Packing | None, bake: BakeName | None) -> BakedPacking:
        """Return a packing, by default the default one, with a texture to bake."""
        return cls(**{**vars(resolve_packing(packing)), "bake": bake})

    def __post_init__(self) -> None:
        if self.bake not in (None, *get_args(BakeName)):
            raise ValueError(f"bake is {self.bake!r}: use {', '.join(map(repr, get_args(BakeName)))}")
        if self.bake == "colours":
            object.__setattr__(self, "bake", "colors")
        if self.bake and self.resolution is None:
            object.__setattr__(self, "resolution", BAKED_RESOLUTION)
        super().__post_init__()


def list_image_kinds(kind: BakeName | None, mesh: MeshFile | None = None) -> list[str]:
    """Return the kinds of image maps that are baked for a mesh, or may be baked for any mesh."""
    if kind == "texture" and mesh is None:
        return list(MTL_KEYWORDS)
    if kind == "texture" and mesh is not None:
        return [of.kind for look in mesh.extras.looks or () for of in look.maps]
    return [] if kind is None else [COLOUR]


def check_target(output: str | PathLike[str], bake: BakeName | None, texcoord: int) -> None:
    """Raise an error if an output file cannot hold the baked image or the second texture coordinates."""
    suffix = normalize_suffix(output)
    if texcoord and suffix not in WITH_TWO_MAPS:
        known = " or ".join(WITH_TWO_MAPS)
        raise ValueError(f"{output} does not end in {known}, which second texture coordinates need")
    if bake and suffix not in WITH_IMAGES:
        known = " or ".join(WITH_IMAGES)
        raise ValueError(f"{output} does not end in {known}, which a baked texture needs")
    if bake and texcoord:
        raise ValueError("bake= is for the first texture coordinates: leave out texcoord=1, or bake=")


def check_contents(mesh: MeshFile, packing: BakedPacking, texcoord: int) -> None:
    """Raise an error if the mesh lacks what its baked texture or its second texture coordinates need.

    Called before the computation.
    """
    if texcoord and mesh.FTC is None:
        raise MeshError(f"{mesh.path} has no texture coordinates: leave out texcoord=1")
    kind = packing.bake
    if kind is None:
        return
    if kind == "colors" and get_corner_colours(mesh) is None:
        raise MeshError(
            f"{mesh.path} has no colours of vertices, faces or materials: bake normals or position"
        )
    if kind == "texture" and (mesh.TC is None or mesh.FTC is None):
        raise MeshError(f"{mesh.path} has no texture coordinates: it has no texture to move")
    size = parse_page_size(packing.resolution or BAKED_RESOLUTION)
    kinds = set(list_image_kinds(kind, mesh))
    check_image_memory(size, max(len(kinds), 1), COLOUR_CHANNELS)  # at least one page is written


def bake_images(packing: BakedPacking, mesh: MeshFile, atlas: Atlas, output: Path) -> Any:
    """Return the baked image, or a list with one image per page; for "texture", by kind in a dict."""
    if packing.bake is None:
        return None
    if packing.bake == "texture":
        return _rebake_textures(mesh, atlas, packing.resolution, output)
    image = _bake_values(packing.bake, mesh, atlas, packing.resolution, output)
    return list(image) if atlas.pages > 1 else image


def _bake_values(kind: str, mesh: MeshFile, atlas: Atlas, resolution: Any, output: Path) -> FloatArray:
    V, triangles = mesh.V, mesh.triangles
    if kind == "colors":
        colours = get_corner_colours(mesh)
        assert colours is not None  # ensured by `check_baking`
        return bake(V, mesh.F, atlas, colours[mesh.triangulation.place], resolution)
    if kind == "normals":
        normals = np.nan_to_num(igl.per_vertex_normals(V, triangles))[triangles]
        frames = find_object_frames(mesh, output)
        if frames is not None:
            normals = normalize_vectors(normals @ frames[mesh.triangulation.face])
        return normalize_vectors(bake(V, mesh.F, atlas, normals, resolution)) / 2 + 0.5
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
