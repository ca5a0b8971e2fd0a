"""Images that the lines of MTL files name, and their options."""

from dataclasses import replace
from functools import partial
from pathlib import Path

from ...errors import MeshError
from ..materials import MTL_WORDS, ImageMap, Material, names_image
from ..parsing import as_bytes, numbers
from ..references import named_file

KINDS = {word.lower(): kind for kind, word in MTL_WORDS.items()}
OPTIONS = {  # how many words follow an option at most; of those with three, numbers only
    **dict.fromkeys(("-blendu", "-blendv", "-bm", "-boost", "-cc", "-clamp", "-imfchan"), 1),
    **dict.fromkeys(("-texres", "-type"), 1),
    "-mm": 2,
    **dict.fromkeys(("-o", "-s", "-t"), 3),
}
OF_THE_MAP = ("-o", "-s", "-t", "-clamp", "-texres")  # they say how the image lies on the old coordinates


def with_maps(look: Material, folder: Path) -> Material:
    """With the images that its lines name, seen from the folder of the library."""
    found = {of.kind: of for line in look.lines if names_image(line) for of in _map_of(line, folder)}
    return replace(look, maps=tuple(found.values()))


def _map_of(line: str, folder: Path) -> list[ImageMap]:
    """The image that a line names; none of reflections, which do not lie on texture coordinates."""
    word, *rest = line.split()
    if word.lower() == "refl" or not rest:
        return []
    said: dict[str, list[str]] = {}
    while rest and rest[0].lower() in OPTIONS:
        option = rest.pop(0).lower()
        most, taken = OPTIONS[option], list[str]()
        while rest and len(taken) < most and (most == 1 or numbers([as_bytes(rest[0])], 1)):
            taken.append(rest.pop(0))
        said[option] = taken
    offset = _pair(said.get("-o", []), 0.0)
    scale = _pair(said.get("-s", []), 1.0)
    wrap = "clamp" if said.get("-clamp", ["off"])[:1] == ["on"] else "repeat"
    options = " ".join(" ".join([key, *words]) for key, words in said.items() if key not in OF_THE_MAP)
    name = " ".join(rest)
    kind = KINDS.get(word.lower(), word)
    return [
        ImageMap(
            kind,
            partial(_read, name, folder),
            (wrap, wrap),
            ((scale[0], 0.0, offset[0]), (0.0, scale[1], offset[1])),
            options,
        )
    ]


def _pair(words: list[str], default: float) -> tuple[float, float]:
    """Two numbers; a second one that is left out is the default."""
    values = [*map(float, words[:2]), default, default]
    return values[0], values[1]


def _read(name: str, folder: Path) -> bytes:
    file = named_file(name, folder)
    if file is None:
        raise MeshError(f"a material names the image {name}, which is not in {folder}: put it there")
    return file.read_bytes()
