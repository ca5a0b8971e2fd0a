"""Where a file of glTF names textures, and which of them were made for the old texture coordinates."""

from collections.abc import Iterator
from typing import Any, NamedTuple

TRANSFORM = "KHR_texture_transform"


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


def old_images(text: dict[str, Any]) -> int:
    """How many textures go with the first texture coordinates, which are new."""
    return len({use.holder[use.key]["index"] for use in all_uses(text) if use.coordinates == 0})


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
