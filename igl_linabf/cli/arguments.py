"""What options and arguments look like, and those that several commands share."""

import argparse
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, get_args

from ..charts import Packing, Seams
from ..flattening import METHODS, BoundaryName

AXES = ("x", "y", "z")

Argument = Mapping[str, Any]
"""What `argparse.ArgumentParser.add_argument` takes, the flags aside."""


def switch(help: str) -> Argument:
    """An option without a value."""
    return {"action": "store_true", "help": help}


def choice(choices: Iterable[str], default: str | None = None, help: str | None = None) -> Argument:
    """One of some names; help tells the default."""
    told = help if default is None else f"{help or 'one of these'} (default: %(default)s)"
    return {"choices": tuple(choices), "default": default, "help": told}


def value(
    metavar: str, help: str, kind: Callable[[str], Any] | None = None, default: Any = None, **more: Any
) -> Argument:
    """What `kind` makes of the text; without it, the text. Help tells the default."""
    told = help if default is None else f"{help} (default: %(default){'g' if kind is float else 's'})"
    return {"metavar": metavar, "help": told, "type": kind, "default": default, **more}


def texels(text: str) -> int | tuple[int, int]:
    """1024, or width and height as 2048x1024."""
    try:
        sides = tuple(int(word) for word in text.lower().split("x"))
    except ValueError:
        sides = ()
    if len(sides) not in (1, 2) or min(sides) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} are no texels: give 1024, or width and height, 2048x1024")
    return sides[0] if len(sides) == 1 else (sides[0], sides[1])


def axis(text: str) -> list[float]:
    """x, -y, or any direction as three numbers with commas between."""
    name = text.lstrip("+-")
    if name in AXES and len(text) - len(name) <= 1:
        sign = -1.0 if text.startswith("-") else 1.0
        return [sign * (letter == name) for letter in AXES]
    return three_numbers(text, "x, y, z, --up=-z, or three numbers, as 0,-1,0")


def three_numbers(text: str, known: str) -> list[float]:
    """Three numbers with commas between; the error says what is `known`."""
    try:
        x, y, z = (float(number) for number in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no direction: give {known}") from None
    return [x, y, z]


def written_to(help: str) -> Argument:
    """Where a command that writes one file a mesh writes."""
    return value("OUT", f"{help}, or a folder that exists, or - for standard output", Path, required=True)


def format_of(suffixes: Iterable[str], default: str) -> Argument:
    """The format of what is written to a folder or to standard output."""
    return choice((suffix[1:] for suffix in suffixes), default, "of files in a folder and of standard output")


SHARED: Mapping[str, Argument] = {
    "mesh": value(
        "MESH", "files (OBJ, PLY, GLB, STL, ...), patterns in quotes, or - for standard input", nargs="+"
    ),
    "output": written_to("OBJ, PLY, GLB, glTF, 3MF, VTP, GIFTI or FreeSurfer (.surf, .flat) file"),
    "picture": value("OUT.png", "checkerboard picture to write", Path),
    "method": choice(sorted(METHODS), "linabf"),
    "weight": value(
        "W", "of areas against angles, for the method isometric: 0 (angles) to 8 (areas); default: 1.5", float
    ),
    "boundary": choice(
        get_args(BoundaryName), "free", "the map's boundary, for linabf and abf (circles: holes as well)"
    ),
    "corners": value(
        "VERTEX", "boundary vertices at a rectangle's corners (default: where it turns most)", int, nargs=4
    ),
    "cones": value(
        "N", "leave the curvature at so many vertices of each component, or at auto: as many as pay"
    ),
    "trade": value("TRADE", "larger: longer seams for less stretch; 0: shortest seams", float, Seams.trade),
    "holes": switch("leave holes uncut"),
    "bijective": switch("move overlapping parts apart instead of splitting charts"),
    "resolution": value(
        "TEXELS",
        "texels along a page's side, or its width and height (2048x1024); distances between charts are then "
        "counted in texels",
        texels,
    ),
    "padding": value("TEXELS", "between two charts, with --resolution", float, Packing.padding),
    "unseen": value(
        "SHARE",
        "of the texel density, for charts that no ray from outside reaches, as of cavities",
        float,
        Packing.unseen,
    ),
    "units": choice(
        ("square", "mesh"),
        help="scale of a flattened map: the unit square, or the mesh's units of length (default: square; "
        "mesh where the map is written as a surface: GIFTI, .surf, .flat)",
    ),
    "force": switch(
        "replace files that are there already and that -o does not name: MTL and PNG beside OBJ, pictures, "
        "files in a folder"
    ),
    "json": switch("print every figure as JSON, a line a mesh, instead of tables"),
    "quiet": switch("print no tables and show no progress"),
}


def shared(*names: str) -> Mapping[str, Argument]:
    """These arguments, in this order."""
    return {name: SHARED[name] for name in names}
