"""Read and write materials, both as MTL libraries and as glTF descriptions."""

import re
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray
from ..errors import MeshWarning, format_count, stack_level
from .parsing import convert_to_utf8, decode_utf8, encode_utf8, parse_name, parse_numbers

SRGB = {
    "slope": 12.92,
    "end of line": 0.0031308,
    "scale": 1.055,
    "power": 2.4,
}  # parameters of the sRGB transfer function, IEC 61966-2-1
DEFAULT_MATERIAL = "igl_linabf"  # name of the material that is written for faces without a material
TEXTURE_SUFFIX = "Texture"  # suffix of glTF's names of image maps
COLOUR = "baseColorTexture"  # glTF's name for the colour map; maps unknown to glTF keep their MTL keyword
MTL_KEYWORDS = {COLOUR: "map_Kd", "normalTexture": "norm", "emissiveTexture": "map_Ke"}
KEYS_IN_GLTF = ("Kd", "d", "Tr", "Pm", "Pr", "Ke")  # MTL keywords with a counterpart in glTF
IMAGE_PATTERN = re.compile(r"(map_|bump|disp|decal|refl|norm)\w*(\s|$)", re.IGNORECASE)  # MTL keywords


class Colour(NamedTuple):
    """An RGB colour with components from 0 to 1."""

    red: float
    green: float
    blue: float


WHITE, BLACK = Colour(1.0, 1.0, 1.0), Colour(0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class ImageMap:
    """An image of a material that uses the first texture coordinates.

    Attributes
    ----------
    kind : str
        glTF's name, such as "baseColorTexture", or the MTL keyword of a map that glTF does not define.
    read : callable
        Returns the bytes of the image file.
    image : str
        The name or number of the image in the file; equal for the same image.
    wrap : (str, str)
        Wrap mode in u and in v: "repeat", "clamp" or "mirror".
    matrix : ((3,), (3,)) of float
        Maps texture coordinates (u, v, 1), v upwards, to image coordinates.
    options : str
        MTL options that do not depend on the texture coordinates.
    nearest : bool
        Whether a lookup returns the nearest pixel instead of interpolating.
    tiles : mapping of int to callable
        For an image that consists of UDIM tiles, a function like `read` for each page.
    """

    kind: str
    read: Callable[[], bytes]
    image: str
    wrap: tuple[str, str] = ("repeat", "repeat")
    matrix: tuple[tuple[float, ...], ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    options: str = ""
    nearest: bool = False
    tiles: Mapping[int, Callable[[], bytes]] = field(default_factory=dict)


@dataclass(frozen=True)
class Material:
    """The appearance of a material.

    Attributes
    ----------
    colour, emission : Colour
        sRGB.
    alpha : float
        1 is opaque.
    metallic, roughness : float or None
        From 0 to 1; None if the file does not specify them.
    images : bool
        Whether the material has images for the old texture coordinates.
    maps : tuple of ImageMap
        The images that can be moved to other texture coordinates.
    lines : tuple of str
        The lines of the material in its MTL file.
    factor : (red, green, blue, alpha) or None
        In glTF and 3MF, the multiplier of vertex and image colours in linear RGB; otherwise None.
    page : int
        The page of the new images that this material uses.
    """

    colour: Colour = WHITE
    alpha: float = 1.0
    metallic: float | None = None
    roughness: float | None = None
    emission: Colour = BLACK
    images: bool = False
    lines: tuple[str, ...] = ()
    factor: tuple[float, ...] | None = None
    maps: tuple[ImageMap, ...] = ()
    page: int = 0


def quantise_colours(colours: FloatArray) -> NDArray[np.uint8]:
    """Convert colour components from the range 0 to 1 to bytes."""
    return np.round(np.clip(colours, 0, 1) * 255).astype(np.uint8)


def encode_srgb(light: FloatArray) -> FloatArray:
    """Convert linear RGB colours to sRGB."""
    rgb = np.clip(light, 0, 1)
    slope, end, scale, power = SRGB.values()
    curve = scale * rgb ** (1 / power) - (scale - 1)
    return np.asarray(np.where(rgb <= end, rgb * slope, curve))


def decode_srgb(colours: FloatArray) -> FloatArray:
    """Convert sRGB colours to linear RGB, as stored in glTF."""
    rgb = np.clip(colours, 0, 1)
    slope, end, scale, power = SRGB.values()
    curve = ((rgb + scale - 1) / scale) ** power
    return np.asarray(np.where(rgb <= end * slope, rgb / slope, curve))


def read_library(path: Path) -> dict[str, Material]:
    """Read the materials of an MTL file by name; unsupported statements are kept in their `lines`."""
    lines: dict[str, list[str]] = {}
    current: list[str] = []
    for line in map(bytes.strip, convert_to_utf8(path.read_bytes()).splitlines()):
        if line.split(None, 1)[:1] == [b"newmtl"]:
            current = lines.setdefault(decode_utf8(parse_name(line)), [])
        elif line and not line.startswith(b"#"):
            current.append(decode_utf8(line))
    return {name: _parse_material(tuple(its_lines)) for name, its_lines in lines.items()}


def _parse_material(lines: tuple[str, ...]) -> Material:
    values_of_key: dict[str, list[float]] = {}
    for line in lines:
        key, *words = line.split()
        values = parse_numbers([*map(encode_utf8, words[:3])], min(len(words), 3))
        values_of_key[key] = values if np.isfinite(values).all() else []

    def parse_colour(key: str, default: Colour) -> Colour:
        values = values_of_key.get(key) or list(default)
        return Colour(*values) if len(values) == 3 else Colour(values[0], values[-1], values[-1])

    def parse_number(key: str) -> float | None:
        values = values_of_key.get(key)
        return values[0] if values else None

    alpha, transparency = parse_number("d"), parse_number("Tr")
    return Material(
        colour=parse_colour("Kd", WHITE),
        alpha=1.0 - (transparency or 0.0) if alpha is None else alpha,
        metallic=parse_number("Pm"),
        roughness=parse_number("Pr"),
        emission=parse_colour("Ke", BLACK),
        images=any(has_image(line) for line in lines),
        lines=lines,
    )


def has_image(line: str) -> bool:
    """Return True if a line of an MTL file refers to an image."""
    return bool(IMAGE_PATTERN.match(line))


def format_library(
    materials: Mapping[str, Material], images: Mapping[str, Sequence[str]] | None = None, moved: bool = False
) -> str:
    """Return the text of an MTL file that refers to the given images, by kind of map and page.

    With `moved`, the given images replace the images of the materials. Otherwise the image of kind COLOUR
    becomes the texture of all materials.
    """
    text = ["# igl_linabf"]
    for name, look in materials.items():
        text += ["", f"newmtl {name}"]
        body = look.lines or _format_material(look)
        if images is not None:
            body = tuple(line for line in body if not has_image(line))
        if images is not None and moved:
            body += tuple(
                " ".join(
                    [
                        MTL_KEYWORDS.get(image_map.kind, image_map.kind),
                        *image_map.options.split(),
                        *_format_wrap(image_map, len(images[image_map.kind])),
                        images[image_map.kind][look.page],
                    ]
                )
                for image_map in look.maps
                if image_map.kind in images
            )
        elif images is not None:  # the image replaces the diffuse colour
            body = tuple(line for line in body if line.split()[0] != "Kd")
            body = (*body, "Kd 1 1 1", f"map_Kd {images[COLOUR][look.page]}")
        text += body
    return "\n".join([*text, ""])


def _format_wrap(image_map: ImageMap, pages: int) -> list[str]:
    """Return the MTL option that clamps an image, but no option if pages lie outside the unit square."""
    return ["-clamp", "on"] if image_map.wrap == ("clamp", "clamp") and pages == 1 else []


def _format_material(look: Material) -> tuple[str, ...]:
    lines = [f"Kd {' '.join(f'{c:.6g}' for c in look.colour)}", f"d {look.alpha:.6g}"]
    lines += [f"{key} {v:.6g}" for key, v in (("Pm", look.metallic), ("Pr", look.roughness)) if v is not None]
    if look.emission != BLACK:
        lines.append(f"Ke {' '.join(f'{c:.6g}' for c in look.emission)}")
    return tuple(lines)


def parse_gltf_material(material: Mapping[str, Any]) -> Material:
    """Return the material that a glTF description defines."""
    shading: Mapping[str, Any] = material.get("pbrMetallicRoughness", {})
    factor = [float(v) for v in shading.get("baseColorFactor", (1, 1, 1, 1))]
    return Material(
        colour=Colour(*encode_srgb(np.array(factor[:3])).tolist()),
        alpha=factor[3] if material.get("alphaMode", "OPAQUE") != "OPAQUE" else 1.0,
        metallic=float(shading.get("metallicFactor", 1.0)),
        roughness=float(shading.get("roughnessFactor", 1.0)),
        emission=Colour(*encode_srgb(np.array(material.get("emissiveFactor", BLACK), dtype=float)).tolist()),
        images=any(key.endswith(TEXTURE_SUFFIX) for holder in (material, shading) for key in holder),
        factor=tuple(factor),
    )


def find_keys_unknown_to_gltf(looks: Iterable[Material]) -> list[str]:
    """Return the MTL keywords of the materials without a counterpart in glTF, except for image keywords."""
    keys = {line.split()[0]: None for look in looks for line in look.lines if not has_image(line)}
    return [key for key in keys if key not in KEYS_IN_GLTF]


MOVE_HINT = "unwrap --bake texture moves them, along the same seams with --seams uv (in Python, bake_texture)"
REPLACED_HINT = "the baked image replaces them"


def warn_of_stale_images(count: int, remedy: str = "bake them again") -> None:
    """Warn that `count` images were made for the old texture coordinates, and state the remedy."""
    if count:
        warnings.warn(
            f"its materials have {format_count(count, 'image')} for the old texture coordinates: {remedy}",
            MeshWarning,
            stacklevel=stack_level(),
        )


def count_unmovable_materials(looks: Sequence[Material]) -> int:
    """Return the number of materials that have images, but no image that can be moved."""
    return sum(look.images and not look.maps for look in looks)


def warn_of_lost_images(count: int) -> None:
    """Warn that the new MTL file omits the images of `count` materials, made for the old coordinates."""
    if count:
        warnings.warn(
            f"the images of {format_count(count, 'material')} were made for the old texture coordinates: "
            "the new library "
            "leaves them out",
            MeshWarning,
            stacklevel=stack_level(),
        )


def make_gltf_material(look: Material, name: str | None = None) -> dict[str, Any]:
    """Return the glTF description of a material."""
    shading: dict[str, Any] = {"metallicFactor": look.metallic or 0}
    if look.colour != WHITE or look.alpha != 1:
        shading["baseColorFactor"] = [*decode_srgb(np.array(look.colour)).tolist(), look.alpha]
    if look.roughness is not None:
        shading["roughnessFactor"] = look.roughness
    material = {"pbrMetallicRoughness": shading, "doubleSided": True}
    if look.emission != BLACK:
        material["emissiveFactor"] = decode_srgb(np.array(look.emission)).tolist()
    if look.alpha < 1:
        material["alphaMode"] = "BLEND"
    return material if name is None else {"name": name, **material}
