"""Find the textures that a glTF description uses, and remove textures of old texture coordinates."""

import base64
from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple
from urllib.parse import unquote

import numpy as np

from ...errors import MeshError
from ..materials import ImageMap
from ..parsing import Damaged
from .scene import Filter, Gltf

TEXTURE_TRANSFORM = "KHR_texture_transform"
# Key in a texture reference of a material. If the texture has been removed, its sampler is kept there.
SAMPLER = "sampler"
WRAP_MODES = {33071: "clamp", 33648: "mirror"}  # by glTF code; all other codes mean "repeat"


class TextureUse(NamedTuple):
    """A reference to a texture.

    Attributes
    ----------
    holder, key : dict and str
        `holder[key]` is the reference.
    coordinates : int
        The number of the set of texture coordinates that the texture uses.
    """

    holder: dict[str, Any]
    key: str
    coordinates: int


def iterate_texture_uses(value: Any, inside: bool = False) -> Iterator[TextureUse]:
    """Yield the references to textures in a JSON value; `inside` is True within property textures."""
    if isinstance(value, list):
        for inner in value:
            yield from iterate_texture_uses(inner, inside)
    if not isinstance(value, dict):
        return
    for key, inner in value.items():
        if key == "extras":
            continue
        is_use = isinstance(inner, dict) and type(inner.get("index")) is int
        if is_use and (inside or key.lower().endswith("texture")):
            transform = inner.get("extensions", {}).get(TEXTURE_TRANSFORM, {})
            coordinates = transform.get("texCoord", inner.get("texCoord", 0))
            if type(coordinates) is not int:
                raise Damaged(f"its {key}.texCoord is not an integer")
            yield TextureUse(value, key, coordinates)
        else:
            yield from iterate_texture_uses(inner, inside or key == "propertyTextures")


def find_texture_uses(text: dict[str, Any]) -> list[TextureUse]:
    """Return the references to textures in materials, primitives and extensions of a file."""
    primitives = [primitive for mesh in text.get("meshes", ()) for primitive in mesh.get("primitives", ())]
    holders = [
        text.get("materials", []),
        text.get("extensions", {}),
        [primitive_.get("extensions") for primitive_ in primitives],
    ]
    return [use for value in holders for use in iterate_texture_uses(value)]


def count_stale_textures(text: dict[str, Any], coordinates: int = 0) -> int:
    """Count the textures that use a set of texture coordinates, by default the set that is replaced."""
    return len(
        {use.holder[use.key]["index"] for use in find_texture_uses(text) if use.coordinates == coordinates}
    )


def drop_stale_images(text: dict[str, Any]) -> None:
    """Remove the textures and images that materials use only with the first set of texture coordinates.

    A reference to a removed texture gets the index -1 until it is replaced, and keeps the sampler.
    """
    old = [use for use in iterate_texture_uses(text.get("materials", [])) if use.coordinates == 0]
    ids = {(id(use.holder), use.key) for use in old}
    others = [use for use in find_texture_uses(text) if (id(use.holder), use.key) not in ids]
    for use in old:
        info = use.holder[use.key]
        info[SAMPLER] = find_sampler(text, info)
        info["index"] = -1
    textures = sorted({use.holder[use.key]["index"] for use in others})
    for use in others:
        use.holder[use.key]["index"] = textures.index(use.holder[use.key]["index"])
    kept = [text["textures"][i] for i in textures]
    sources = [
        source
        for texture in kept
        for source in (texture, *texture.get("extensions", {}).values())
        if "source" in source
    ]
    images = sorted({source["source"] for source in sources})
    for source in sources:
        source["source"] = images.index(source["source"])
    remaining = {"textures": kept, "images": [text["images"][i] for i in images]}
    for name, entries in remaining.items():
        text.pop(name, None)
        text |= {name: entries} if entries else {}


def find_sampler(text: dict[str, Any], info: dict[str, Any]) -> dict[str, Any] | None:
    """Return the sampler of a texture reference, even if the texture has been removed; None without one."""
    if info["index"] < 0:
        return info.get(SAMPLER)
    number = text["textures"][info["index"]].get("sampler")
    return None if number is None else text["samplers"][number]


def find_texture_images(gltf: Gltf, material: dict[str, Any], coordinates: int = 0) -> tuple[ImageMap, ...]:
    """Return the images of a material that use the given set of texture coordinates."""
    uses = [use for use in iterate_texture_uses(material) if use.coordinates == coordinates]
    return tuple(_make_image_map(gltf, use) for use in uses)


def _make_image_map(gltf: Gltf, use: TextureUse) -> ImageMap:
    info = use.holder[use.key]
    texture = gltf.get_entries("textures")[info["index"]]
    sampler = find_sampler(gltf.text, info) or {}
    wrap = tuple(WRAP_MODES.get(sampler.get(key, 0), "repeat") for key in ("wrapS", "wrapT"))
    transform = info.get("extensions", {}).get(TEXTURE_TRANSFORM, {})
    (x, y), (across, down) = transform.get("offset", (0, 0)), transform.get("scale", (1, 1))
    cos, sin = np.cos(transform.get("rotation", 0)), np.sin(transform.get("rotation", 0))
    # u' = a u + b v + x, v' = c u + d v + y, v downwards. The rotation is counterclockwise on screen, as in
    # existing programs, but unlike the code listing in the specification of KHR_texture_transform.
    a, b, c, d = cos * across, sin * down, -sin * across, cos * down
    upwards = ((float(a), float(-b), float(b + x)), (float(-c), float(d), float(1 - d - y)))
    nearest = sampler.get("magFilter") == Filter.NEAREST
    number, tiles = _find_image(texture), {}
    read = partial(_read_image, gltf, number)
    if number is not None:
        uri = str(gltf.text["images"][number].get("uri", "data:"))
        files = {} if uri.startswith("data:") else gltf.folder.find_tiles(unquote(uri))
        tiles = {page: file.read_bytes for page, file in files.items()}
    return ImageMap(use.key, read, str(number), (wrap[0], wrap[1]), upwards, nearest=nearest, tiles=tiles)


def _find_image(texture: dict[str, Any]) -> int | None:
    """Return the index of a texture's image: of glTF 2.0, otherwise of an extension, or None."""
    sources = [texture, *texture.get("extensions", {}).values()]
    return next((source["source"] for source in sources if "source" in source), None)


def _read_image(gltf: Gltf, number: int | None) -> bytes:
    """Return the bytes of the image file of an entry of `images`, given the number of the entry."""
    if number is None:
        raise MeshError("a texture has no image: remove it")
    image = gltf.get_entries("images")[number]
    if "bufferView" in image:
        return gltf.read_view(image["bufferView"])
    uri = str(image.get("uri", ""))
    if uri.startswith("data:"):
        try:
            return base64.b64decode(uri.partition(",")[2])
        except ValueError:
            raise MeshError(f"the image {number} is not valid base64: embed it again") from None
    file = gltf.folder.find_file(unquote(uri))
    if file is None:
        raise MeshError(f"the image {uri} is not in {gltf.folder.path}: put it there")
    return file.read_bytes()


def has_texture_transforms(text: dict[str, Any], coordinates: int = 0) -> bool:
    """Return True if a transform changes the given set of texture coordinates before the image lookup."""
    uses = [use for use in find_texture_uses(text) if use.coordinates == coordinates]
    transforms = [use.holder[use.key].get("extensions", {}).get(TEXTURE_TRANSFORM, {}) for use in uses]
    return any({"offset", "rotation", "scale"} & set(transform) for transform in transforms)


def drop_stale_uses(material: dict[str, Any]) -> None:
    """Remove a material's references to textures that use the first texture coordinates."""
    for use in list(iterate_texture_uses(material)):
        if use.coordinates == 0:
            del use.holder[use.key]
