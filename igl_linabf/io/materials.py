"""What materials look like, in the two ways that formats say it: MTL beside OBJ, and glTF's own."""

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray
from ..errors import MeshWarning, stack_level
from .parsing import as_bytes, as_text, name_of, numbers, plain_text

SRGB = {"slope": 12.92, "end of line": 0.0031308, "scale": 1.055, "power": 2.4}  # IEC 61966-2-1
PLAIN = "igl_linabf"  # the material of faces that have none
TEXTURE = "Texture"  # what names of images end with in glTF
COLOUR = "baseColorTexture"  # maps are named as glTF names them, and others by their words in MTL
MTL_WORDS = {COLOUR: "map_Kd", "normalTexture": "norm", "emissiveTexture": "map_Ke"}
SHARED_WITH_GLTF = ("Kd", "d", "Tr", "Pm", "Pr", "Ke")  # what is read of MTL
FIRST_TILE = 1001  # of UDIM
IMAGES = ("map_", "bump", "disp", "decal", "refl", "norm")  # what lines of MTL with images begin with


class Colour(NamedTuple):
    """Red, green and blue, from 0 to 1."""

    red: float
    green: float
    blue: float


WHITE, BLACK = Colour(1.0, 1.0, 1.0), Colour(0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class ImageMap:
    """An image of a material, on the first texture coordinates.

    Attributes
    ----------
    kind : str
        "baseColorTexture", ...: glTF's name, or else the word of MTL.
    read : callable
        Returns the bytes of the image's file.
    wrap : (str, str)
        How it goes on in u and in v: "repeat", "clamp" or "mirror".
    matrix : ((3,), (3,)) of float
        Makes of texture coordinates (u, v, 1), v upwards, those of the image.
    options : str
        MTL's options that also hold for other texture coordinates.
    """

    kind: str
    read: Callable[[], bytes]
    wrap: tuple[str, str] = ("repeat", "repeat")
    matrix: tuple[tuple[float, ...], ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    options: str = ""


@dataclass(frozen=True)
class Material:
    """A material's look.

    Attributes
    ----------
    colour, emission : Colour
        sRGB.
    alpha : float
        1 is opaque.
    metallic, roughness : float or None
        From 0 to 1; None if the file does not say.
    images : bool
        Whether it has images, which fit to the texture coordinates that were read.
    maps : tuple of ImageMap
        Those of its images that can be moved to other texture coordinates.
    lines : tuple of str
        Its lines in the MTL file that it comes from.
    factor : (red, green, blue, alpha) or None
        By what other colours are multiplied, proportional to light, where the format says so: glTF, 3MF.
    page : int
        Of the new images, where it is the material of one page.
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


def bytes_of_colours(colours: FloatArray) -> NDArray[np.uint8]:
    """Colours from 0 to 1 as whole numbers to 255."""
    return np.round(np.clip(colours, 0, 1) * 255).astype(np.uint8)


def srgb(light: FloatArray) -> FloatArray:
    """Colours as most formats have them, from ones proportional to light."""
    rgb = np.clip(light, 0, 1)
    slope, end, scale, power = SRGB.values()
    curve = scale * rgb ** (1 / power) - (scale - 1)
    return np.asarray(np.where(rgb <= end, rgb * slope, curve))


def linear(colours: FloatArray) -> FloatArray:
    """Colours as glTF stores them, proportional to light."""
    rgb = np.clip(colours, 0, 1)
    slope, end, scale, power = SRGB.values()
    curve = ((rgb + scale - 1) / scale) ** power
    return np.asarray(np.where(rgb <= end * slope, rgb / slope, curve))


def library(path: Path) -> dict[str, Material]:
    """The materials of an MTL file by name; what it says that is not understood stays in their lines."""
    lines: dict[str, list[str]] = {}
    now: list[str] = []
    for line in map(bytes.strip, plain_text(path.read_bytes()).splitlines()):
        if line.split(None, 1)[:1] == [b"newmtl"]:
            now = lines.setdefault(as_text(name_of(line)), [])
        elif line and not line.startswith(b"#"):
            now.append(as_text(line))
    return {name: _of_lines(tuple(its)) for name, its in lines.items()}


def _of_lines(lines: tuple[str, ...]) -> Material:
    said: dict[str, list[float]] = {}
    for line in lines:
        key, *words = line.split()
        said[key] = numbers([*map(as_bytes, words[:3])], min(len(words), 3))

    def colour(key: str, default: Colour) -> Colour:
        values = said.get(key) or list(default)
        return Colour(*values) if len(values) == 3 else Colour(values[0], values[-1], values[-1])

    def number(key: str) -> float | None:
        values = said.get(key)
        return values[0] if values else None

    alpha, clear = number("d"), number("Tr")
    return Material(
        colour=colour("Kd", WHITE),
        alpha=1.0 - (clear or 0.0) if alpha is None else alpha,
        metallic=number("Pm"),
        roughness=number("Pr"),
        emission=colour("Ke", BLACK),
        images=any(names_image(line) for line in lines),
        lines=lines,
    )


def names_image(line: str) -> bool:
    """Whether a line of MTL names an image."""
    return line.lower().startswith(IMAGES)


def library_text(
    materials: Mapping[str, Material], images: Mapping[str, Sequence[str]] | None = None, moved: bool = False
) -> str:
    """An MTL file; with the names of images, one a page.

    If they are `moved`, they take the places of the materials' own; else the one of COLOUR is the texture of
    all of them.
    """
    said = ["# igl_linabf"]
    for name, look in materials.items():
        said += ["", f"newmtl {name}"]
        kept = look.lines or _lines_of(look)
        if images is not None:
            kept = tuple(line for line in kept if not names_image(line))
        if images is not None and moved:
            kept += tuple(
                " ".join([MTL_WORDS.get(of.kind, of.kind), *of.options.split(), images[of.kind][look.page]])
                for of in look.maps
                if of.kind in images
            )
        elif images is not None:  # the image is their colour
            kept = tuple(line for line in kept if line.split()[0] != "Kd")
            kept = (*kept, "Kd 1 1 1", f"map_Kd {images[COLOUR][look.page]}")
        said += kept
    return "\n".join([*said, ""])


def _lines_of(look: Material) -> tuple[str, ...]:
    said = [f"Kd {' '.join(f'{c:.6g}' for c in look.colour)}", f"d {look.alpha:.6g}"]
    said += [f"{key} {v:.6g}" for key, v in (("Pm", look.metallic), ("Pr", look.roughness)) if v is not None]
    if look.emission != BLACK:
        said.append(f"Ke {' '.join(f'{c:.6g}' for c in look.emission)}")
    return tuple(said)


def of_gltf(material: Mapping[str, Any]) -> Material:
    """A material of glTF."""
    shading: Mapping[str, Any] = material.get("pbrMetallicRoughness", {})
    factor = [float(v) for v in shading.get("baseColorFactor", (1, 1, 1, 1))]
    return Material(
        colour=Colour(*srgb(np.array(factor[:3])).tolist()),
        alpha=factor[3] if material.get("alphaMode", "OPAQUE") != "OPAQUE" else 1.0,
        metallic=float(shading.get("metallicFactor", 1.0)),
        roughness=float(shading.get("roughnessFactor", 1.0)),
        emission=Colour(*srgb(np.array(material.get("emissiveFactor", BLACK), dtype=float)).tolist()),
        images=any(key.endswith(TEXTURE) for of in (material, shading) for key in of),
        factor=tuple(factor),
    )


def unknown_to_gltf(looks: Iterable[Material]) -> list[str]:
    """What lines of MTL say that glTF has no word for; images are told apart."""
    keys = {line.split()[0]: None for look in looks for line in look.lines if not names_image(line)}
    return [key for key in keys if key not in SHARED_WITH_GLTF]


MOVE = "--bake texture (in Python, bake_texture) moves them"
BAKED = "the baked one takes their place"


def warn_of_images(count: int, remedy: str = "bake them anew") -> None:
    """Images that were made for what is no longer there, and what helps, or was done."""
    if count:
        warnings.warn(
            f"{count} images of its materials were made for the old texture coordinates: {remedy}",
            MeshWarning,
            stacklevel=stack_level(),
        )


def unmoved_images(looks: Sequence[Material]) -> int:
    """How many of the materials have images, none of which can be moved."""
    return sum(look.images and not look.maps for look in looks)


def warn_of_lost_images(count: int) -> None:
    """Images for the old texture coordinates give way to one for the new ones."""
    if count:
        warnings.warn(
            f"the images of {count} materials were made for the old texture coordinates: the new library "
            "leaves them out",
            MeshWarning,
            stacklevel=stack_level(),
        )


def as_gltf(look: Material, name: str | None = None) -> dict[str, Any]:
    """The material as glTF describes it."""
    shading: dict[str, Any] = {"metallicFactor": look.metallic or 0}
    if look.colour != WHITE or look.alpha != 1:
        shading["baseColorFactor"] = [*linear(np.array(look.colour)).tolist(), look.alpha]
    if look.roughness is not None:
        shading["roughnessFactor"] = look.roughness
    made = {"pbrMetallicRoughness": shading, "doubleSided": True}
    if look.emission != BLACK:
        made["emissiveFactor"] = linear(np.array(look.emission)).tolist()
    if look.alpha < 1:
        made["alphaMode"] = "BLEND"
    return made if name is None else {"name": name, **made}
