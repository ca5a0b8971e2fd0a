"""Parse the image statements of MTL files with their options."""

from dataclasses import replace
from functools import partial

from ...errors import MeshError
from ..materials import MTL_KEYWORDS, ImageMap, Material, has_image
from ..parsing import encode_utf8, parse_numbers
from ..references import Folder

KIND_OF_KEYWORD = {word.lower(): kind for kind, word in MTL_KEYWORDS.items()}
OPTION_LENGTHS = {  # maximum number of arguments of each MTL option; several arguments are always numbers
    **dict.fromkeys(("-blendu", "-blendv", "-bm", "-boost", "-cc", "-clamp", "-imfchan"), 1),
    **dict.fromkeys(("-texres", "-type"), 1),
    "-mm": 2,
    **dict.fromkeys(("-o", "-s", "-t"), 3),
}
PLACEMENT_OPTIONS = ("-o", "-s", "-t", "-clamp", "-texres")  # invalid for new texture coordinates


def attach_maps(look: Material, folder: Folder) -> Material:
    """Return the material with the images that its MTL lines refer to; `folder` contains the MTL file."""
    found = {
        image_map.kind: image_map
        for line in look.lines
        if has_image(line)
        for image_map in _parse_map_line(line, folder)
    }
    return replace(look, maps=tuple(found.values()))


def _parse_map_line(line: str, folder: Folder) -> list[ImageMap]:
    """Return the image of an MTL line in a list; [] for reflections, which use no texture coordinates."""
    word, *rest = line.split()
    if word.lower() == "refl" or not rest:
        return []
    options_given: dict[str, list[str]] = {}
    while rest and rest[0].lower() in OPTION_LENGTHS:
        option = rest.pop(0).lower()
        max_words, words_taken = OPTION_LENGTHS[option], list[str]()
        while (
            rest
            and len(words_taken) < max_words
            and (max_words == 1 or parse_numbers([encode_utf8(rest[0])], 1))
        ):
            words_taken.append(rest.pop(0))
        options_given[option] = words_taken
    offset = _parse_pair(options_given.get("-o", []), 0.0)
    scale = _parse_pair(options_given.get("-s", []), 1.0)
    wrap = "clamp" if options_given.get("-clamp", ["off"])[:1] == ["on"] else "repeat"
    options = " ".join(
        " ".join([key, *words]) for key, words in options_given.items() if key not in PLACEMENT_OPTIONS
    )
    name = " ".join(rest)
    kind = KIND_OF_KEYWORD.get(word.lower(), word)
    tiles = {page: file.read_bytes for page, file in folder.find_tiles(name).items()}
    return [
        ImageMap(
            kind,
            partial(_read_image, name, folder),
            name,
            (wrap, wrap),
            ((scale[0], 0.0, offset[0]), (0.0, scale[1], offset[1])),
            options,
            tiles=tiles,
        )
    ]


def _parse_pair(words: list[str], default: float) -> tuple[float, float]:
    """Return two numbers; missing numbers are replaced by the default."""
    values = [*map(float, words[:2]), default, default]
    return values[0], values[1]


def _read_image(name: str, folder: Folder) -> bytes:
    file = folder.find_file(name)
    if file is None:
        raise MeshError(f"a material refers to the image {name}, which is not in {folder.path}: put it there")
    return file.read_bytes()
