"""Descriptions of options and arguments, including those shared by several commands."""

import argparse
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, get_args

from ..charts import ChartOptions, Packing
from ..flattening import METHODS, BoundaryName

AXES = ("x", "y", "z")

Argument = Mapping[str, Any]
"""Keywords of `argparse.ArgumentParser.add_argument`."""


def switch(help: str) -> Argument:
    """Describe an option without a value."""
    return {"action": "store_true", "help": help}


def choice(choices: Iterable[str], default: str | None = None, help: str | None = None) -> Argument:
    """Describe an argument that is one of several names; its help states the default."""
    text = help if default is None else f"{help or 'one of these'} (default: %(default)s)"
    return {"choices": tuple(choices), "default": default, "help": text}


def value(
    metavar: str, help: str, kind: Callable[[str], Any] | None = None, default: Any = None, **more: Any
) -> Argument:
    """Describe an argument that `kind` converts from text; its help states the default."""
    text = help if default is None else f"{help} (default: %(default){'g' if kind is float else 's'})"
    return {"metavar": metavar, "help": text, "type": kind, "default": default, **more}


def parse_texels(text: str) -> int | tuple[int, int]:
    """Convert "1024", or a width and a height such as "2048x1024"."""
    try:
        sides = tuple(int(word) for word in text.lower().split("x"))
    except ValueError:
        sides = ()
    if len(sides) not in (1, 2) or min(sides) < 1:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a number of texels: give 1024, or width and height, 2048x1024"
        )
    return sides[0] if len(sides) == 1 else (sides[0], sides[1])


def parse_axis(text: str) -> list[float]:
    """Convert a signed axis such as "x" or "-y", or three numbers separated by commas, to a vector."""
    name = text.lstrip("+-")
    if name in AXES and len(text) - len(name) <= 1:
        sign = -1.0 if text.startswith("-") else 1.0
        return [sign * (letter == name) for letter in AXES]
    return parse_vector(text, "x, y, z, --up=-z, or three numbers such as 0,-1,0")


def parse_vector(text: str, known: str) -> list[float]:
    """Convert three numbers separated by commas; the error message lists the `known` forms."""
    try:
        x, y, z = (float(number) for number in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a direction: give {known}") from None
    return [x, y, z]


def output_argument(help: str) -> Argument:
    """Describe the output of a command that writes one file per mesh."""
    return value("OUT", f"{help}, or a folder that exists, or - for standard output", Path, required=True)


def format_argument(suffixes: Iterable[str], default: str) -> Argument:
    """Describe the format of the files written to a folder or to standard output."""
    return choice((suffix[1:] for suffix in suffixes), default, "of files in a folder and of standard output")


SHARED: Mapping[str, Argument] = {
    "mesh": value(
        "MESH", "files (OBJ, PLY, GLB, STL, ...), patterns in quotes, or - for standard input", nargs="+"
    ),
    "output": output_argument("OBJ, PLY, GLB, glTF, 3MF, VTP, GIFTI or FreeSurfer (.surf, .flat) file"),
    "picture": value("OUT.png", "checkerboard picture to write", Path),
    "method": choice(sorted(METHODS), "linabf"),
    "weight": value(
        "W",
        "weight of areas against angles, for the method isometric: 0 (angles) to 8 (areas); default: 1.5",
        float,
    ),
    "boundary": choice(
        get_args(BoundaryName),
        "free",
        "shape of the map's boundary, for linabf and abf (circles: of holes, too)",
    ),
    "corners": value(
        "VERTEX",
        "boundary vertices at a rectangle's corners (default: where the boundary turns most)",
        int,
        nargs=4,
    ),
    "cones": value("N", "concentrate the curvature at N vertices of each component; auto: choose the number"),
    "trade": value(
        "TRADE", "larger: longer seams for less stretch; 0: shortest seams", float, ChartOptions.trade
    ),
    "keep-holes": switch("leave holes uncut"),
    "repair-overlaps": switch("move overlapping parts apart instead of splitting charts"),
    "resolution": value(
        "TEXELS",
        "texels along a page's side, or its width and height (2048x1024); distances between charts are then "
        "counted in texels",
        parse_texels,
    ),
    "padding": value("TEXELS", "distance between two charts, with --resolution", float, Packing.padding),
    "unseen": value(
        "SHARE",
        "share of the texel density for charts that no ray from outside reaches, such as cavities",
        float,
        Packing.unseen,
    ),
    "units": choice(
        ("square", "mesh"),
        help="scale of a flattened map: the unit square, or the mesh's units of length (default: square; "
        "mesh if the map is written as a surface: GIFTI, .surf, .flat)",
    ),
    "force": switch(
        "replace existing files that -o does not name: MTL and PNG files beside an OBJ, pictures, "
        "files in a folder"
    ),
    "json": switch("print all figures as JSON, one line per mesh, instead of tables"),
    "quiet": switch("print no tables and no progress"),
}


def shared_arguments(*names: str) -> Mapping[str, Argument]:
    """Return the named arguments, in the given order."""
    return {name: SHARED[name] for name in names}
