"""Add new images to a glTF description: baked colours, or old images moved to new texture coordinates."""

import copy
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ...charts import FIRST_UDIM_TILE
from ..materials import BLACK, COLOUR, ImageMap, Material
from ..mesh_file import Images
from .extensions import VARIANTS
from .images import (
    SAMPLER,
    TEXTURE_TRANSFORM,
    WRAP_MODES,
    drop_stale_uses,
    find_sampler,
    find_texture_uses,
    iterate_texture_uses,
)
from .scene import Filter

SHADING = "pbrMetallicRoughness"
SMOOTH = {"magFilter": Filter.LINEAR, "minFilter": Filter.LINEAR_MIPMAP_LINEAR}
Sampler = dict[str, Any] | None  # None: the texture has no sampler
Put = Callable[..., int]  # appends bytes to the buffer, and returns the number of their view


class MaterialPages:
    """The materials of a glTF description, each copied for the second and further pages of new images.

    Attributes
    ----------
    pages : dict of int to int
        The page of each material copy; all other materials belong to the first page.
    """

    def __init__(self, text: dict[str, Any]) -> None:
        self.materials: list[dict[str, Any]] = text.setdefault("materials", [])
        self.pages: dict[int, int] = {}
        self._copies: dict[tuple[int, int], int] = {}

    def choose_material(self, material: int, page: int) -> int:
        """Return the number of the material for a page: the material on page 0, otherwise a copy of it."""
        if page == 0:
            return material
        if (material, page) not in self._copies:
            material_copy = copy.deepcopy(self.materials[material])
            if "name" in material_copy:
                material_copy["name"] = f"{material_copy['name']}.{FIRST_UDIM_TILE + page}"
            self.pages[len(self.materials)] = page
            self._copies[material, page] = len(self.materials)
            self.materials.append(material_copy)
        return self._copies[material, page]

    def assign(self, primitive: dict[str, Any], page: int) -> None:
        """Assign the materials of a page to a primitive and its variants."""
        primitive["material"] = self.choose_material(primitive["material"], page)
        for mapping in primitive.get("extensions", {}).get(VARIANTS, {}).get("mappings", ()):
            if "material" in mapping:
                mapping["material"] = self.choose_material(mapping["material"], page)


def add_images(
    text: dict[str, Any], put: Put, images: Images, pages: Mapping[int, int], looks: Sequence[Material] = ()
) -> None:
    """Add images and refer to them in the materials; `looks` are the materials of a new description.

    A baked image becomes the texture of all materials, and is no longer multiplied by vertex colours.
    """
    if images.moved:
        _replace_images(text, put, images, pages, looks)
        return
    for material in text["materials"]:
        drop_stale_uses(material)
    _drop_unused_textures(text)
    textures = [_add_texture(text, _add_image(text, put, file, {}), SMOOTH) for file in images.maps[COLOUR]]
    for i, material in enumerate(text["materials"]):
        shading = material.get(SHADING, {})
        shading.pop("baseColorFactor", None)  # remove the factor, because viewers multiply the image by it
        material[SHADING] = {**shading, "metallicFactor": 0, COLOUR: {"index": textures[pages.get(i, 0)]}}
    for mesh in text["meshes"]:
        for primitive in mesh["primitives"]:
            # hide old colours from viewers, which ignore names that begin with an underscore
            if "COLOR_0" in primitive["attributes"]:
                primitive["attributes"]["_COLOR_0"] = primitive["attributes"].pop("COLOR_0")


def _replace_images(
    text: dict[str, Any], put: Put, images: Images, pages: Mapping[int, int], looks: Sequence[Material]
) -> None:
    """Replace the old images of the materials; their factors and samplers do not change."""
    uses: list[tuple[dict[str, Any], str, dict[str, Any], int, Sampler]] = []
    for i, material in enumerate(text["materials"]):
        page = pages.get(i, 0)
        for use in [use for use in iterate_texture_uses(material) if use.coordinates == 0]:
            info = use.holder.pop(use.key)
            if use.key in images.maps:
                uses.append((use.holder, use.key, _strip_placement(info), page, find_sampler(text, info)))
    for material, look in zip(text["materials"], looks, strict=False):
        for image_map in (image_map for image_map in look.maps if image_map.kind in images.maps):
            kind, holder = image_map.kind, material[SHADING] if image_map.kind == COLOUR else material
            uses.append((holder, kind, {}, look.page, _make_sampler(image_map)))
            if kind == "emissiveTexture" and look.emission == BLACK:
                material["emissiveFactor"] = [1.0, 1.0, 1.0]
    _drop_unused_textures(text)
    known: dict[bytes, int] = {}
    for holder, key, info, page, sampler in uses:
        # without clamping, which would damage pages outside the unit square
        if sampler is not None and images.pages > 1:
            sampler = {key_: value for key_, value in sampler.items() if key_ not in ("wrapS", "wrapT")}
        image = _add_image(text, put, images.maps[key][page], known)
        holder[key] = {**info, "index": _add_texture(text, image, sampler)}


def _make_sampler(image_map: ImageMap) -> dict[str, Any]:
    """Return the glTF sampler of an image from a material of another format."""
    modes = {name: code for code, name in WRAP_MODES.items()}
    wraps = {
        key: modes[wrap]
        for key, wrap in zip(("wrapS", "wrapT"), image_map.wrap, strict=True)
        if wrap in modes
    }
    return {**SMOOTH, **wraps}


def _strip_placement(info: dict[str, Any]) -> dict[str, Any]:
    """Return a texture reference without its index, set of coordinates and transform."""
    placed = ("index", "texCoord", "extensions", SAMPLER)
    kept = {key: value for key, value in info.items() if key not in placed}
    extensions = {
        name: value for name, value in info.get("extensions", {}).items() if name != TEXTURE_TRANSFORM
    }
    return {**kept, **({"extensions": extensions} if extensions else {})}


def _add_image(text: dict[str, Any], put: Put, file: bytes, image_of_file: dict[bytes, int]) -> int:
    """Add a PNG file as an image unless it has been added, and return the number of the image."""
    if file not in image_of_file:
        image_of_file[file] = _append_entry(
            text, "images", {"bufferView": put(file), "mimeType": "image/png"}
        )
    return image_of_file[file]


def _add_texture(text: dict[str, Any], image: int, sampler: Sampler) -> int:
    """Add a texture unless an equal one exists, and return its number."""
    texture = {"source": image}
    if sampler is not None:
        samplers = text.setdefault("samplers", [])
        known = samplers.index(sampler) if sampler in samplers else _append_entry(text, "samplers", sampler)
        texture["sampler"] = known
    textures = text.setdefault("textures", [])
    return textures.index(texture) if texture in textures else _append_entry(text, "textures", texture)


def _append_entry(text: dict[str, Any], name: str, entry: dict[str, Any]) -> int:
    """Append an entry to a list, and return its number."""
    listed = text.setdefault(name, [])
    listed.append(entry)
    return len(listed) - 1


def _drop_unused_textures(text: dict[str, Any]) -> None:
    if not find_texture_uses(text):
        for name in ("images", "samplers", "textures"):
            text.pop(name, None)
