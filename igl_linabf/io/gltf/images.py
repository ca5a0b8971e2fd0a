"""Where a file of glTF names textures, and which of them were made for the old texture coordinates."""

import base64
from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple
from urllib.parse import unquote

import numpy as np

from ...errors import MeshError
from ..materials import ImageMap
from ..references import named_file
from .scene import Gltf

TRANSFORM = "KHR_texture_transform"
WRAPS = {33071: "clamp", 33648: "mirror"}  # glTF's numbers; all else repeats


class TextureUse(NamedTuple):
    """A place that names a texture.

    Attributes
    ----------
    holder, key : dict and str
        `holder[key]` is what names it.
    coordinates : int
        The number of the texture coordinates that go with it.
    """

    holder: dict[str, Any]
    key: str
    coordinates: int


def texture_uses(value: Any, inside: bool = False) -> Iterator[TextureUse]:
    """The uses of textures in a material, or in anything else; `inside`: of property textures."""
    if isinstance(value, list):
        for inner in value:
            yield from texture_uses(inner, inside)
    if not isinstance(value, dict):
        return
    for key, inner in value.items():
        if key == "extras":
            continue
        named = isinstance(inner, dict) and isinstance(inner.get("index"), int)
        if named and (inside or key.lower().endswith("texture")):
            moved = inner.get("extensions", {}).get(TRANSFORM, {})
            yield TextureUse(value, key, int(moved.get("texCoord", inner.get("texCoord", 0))))
        else:
            yield from texture_uses(inner, inside or key == "propertyTextures")


def all_uses(text: dict[str, Any]) -> list[TextureUse]:
    """Those of materials, of primitives, and of the whole file."""
    primitives = [primitive for mesh in text.get("meshes", ()) for primitive in mesh.get("primitives", ())]
    held = [
        text.get("materials", []),
        text.get("extensions", {}),
        [of.get("extensions") for of in primitives],
    ]
    return [use for value in held for use in texture_uses(value)]


def old_images(text: dict[str, Any], coordinates: int = 0) -> int:
    """How many textures go with the texture coordinates of this number, which are new."""
    return len({use.holder[use.key]["index"] for use in all_uses(text) if use.coordinates == coordinates})


def leave_out_old_images(text: dict[str, Any]) -> None:
    """Leave out textures, and images, that materials name for the first texture coordinates alone.

    What names them stays, with the number -1, until it is named anew or left out.
    """
    old = [use for use in texture_uses(text.get("materials", [])) if use.coordinates == 0]
    ids = {(id(use.holder), use.key) for use in old}
    others = [use for use in all_uses(text) if (id(use.holder), use.key) not in ids]
    for use in old:
        use.holder[use.key]["index"] = -1
    textures = sorted({use.holder[use.key]["index"] for use in others})
    for use in others:
        use.holder[use.key]["index"] = textures.index(use.holder[use.key]["index"])
    kept = [text["textures"][i] for i in textures]
    sources = [
        of for texture in kept for of in (texture, *texture.get("extensions", {}).values()) if "source" in of
    ]
    images = sorted({of["source"] for of in sources})
    for of in sources:
        of["source"] = images.index(of["source"])
    held = {"textures": kept, "images": [text["images"][i] for i in images]}
    for name, entries in held.items():
        text.pop(name, None)
        text |= {name: entries} if entries else {}


def maps_of(gltf: Gltf, material: dict[str, Any]) -> tuple[ImageMap, ...]:
    """The images of a material that go with the first texture coordinates."""
    return tuple(_map_of(gltf, use) for use in texture_uses(material) if use.coordinates == 0)


def _map_of(gltf: Gltf, use: TextureUse) -> ImageMap:
    info = use.holder[use.key]
    texture = gltf.listed("textures")[info["index"]]
    samplers = gltf.listed("samplers")
    sampler = samplers[texture["sampler"]] if "sampler" in texture else {}
    wrap = tuple(WRAPS.get(sampler.get(key, 0), "repeat") for key in ("wrapS", "wrapT"))
    moved = info.get("extensions", {}).get(TRANSFORM, {})
    (x, y), (across, down) = moved.get("offset", (0, 0)), moved.get("scale", (1, 1))
    cos, sin = np.cos(moved.get("rotation", 0)), np.sin(moved.get("rotation", 0))
    # u = a u + b v + x, v = c u + d v + y, v downwards: counterclockwise as one sees it, which is what
    # programs do, and not the listing in the extension's text
    a, b, c, d = cos * across, sin * down, -sin * across, cos * down
    upwards = ((float(a), float(-b), float(b + x)), (float(-c), float(d), float(1 - d - y)))
    return ImageMap(use.key, partial(_read, gltf, texture), (wrap[0], wrap[1]), upwards)


def _read(gltf: Gltf, texture: dict[str, Any]) -> bytes:
    """The file of a texture's image: the one that every program reads, or that of an extension."""
    sources = [texture, *texture.get("extensions", {}).values()]
    number = next((of["source"] for of in sources if "source" in of), None)
    if number is None:
        raise MeshError("a texture names no image: leave it out")
    image = gltf.listed("images")[number]
    if "bufferView" in image:
        return gltf.view(image["bufferView"])
    uri = str(image.get("uri", ""))
    if uri.startswith("data:"):
        return base64.b64decode(uri.partition(",")[2])
    file = named_file(unquote(uri), gltf.folder)
    if file is None:
        raise MeshError(f"the image {uri} is not in {gltf.folder}: put it there")
    return file.read_bytes()


def are_moved(text: dict[str, Any]) -> bool:
    """Whether images lie elsewhere on the first texture coordinates than these say."""
    uses = [use for use in all_uses(text) if use.coordinates == 0]
    moved = [use.holder[use.key].get("extensions", {}).get(TRANSFORM, {}) for use in uses]
    return any({"offset", "rotation", "scale"} & set(of) for of in moved)


def without_old_images(material: dict[str, Any]) -> None:
    """Leave out the images of a material that go with the first texture coordinates."""
    for use in list(texture_uses(material)):
        if use.coordinates == 0:
            del use.holder[use.key]
