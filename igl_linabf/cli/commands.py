"""What a command is: its name, its arguments, and the function that runs it."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal, get_args

from ..flattening import METHODS, BoundaryName, Method

GOOD, NOT_VALID, ERROR = 0, 1, 2
STANDARD = "-"  # input or output

Argument = Mapping[str, Any]
"""What `argparse.ArgumentParser.add_argument` takes, the flags aside."""

MESHES: Argument = {
    "metavar": "MESH",
    "nargs": "+",
    "help": "files (OBJ, PLY, GLB, STL, ...), patterns of them in quotes, or - for standard input",
}
JSON: Argument = {
    "action": "store_true",
    "help": "print every figure as JSON, a line a mesh, instead of tables",
}
QUIET: Argument = {"action": "store_true", "help": "print no tables and show no progress"}
MESH: Argument = {
    "metavar": "MESH",
    "type": Path,
    "help": "OBJ, OFF, PLY, STL, GLB, glTF, 3MF, GIFTI, FreeSurfer or VTP file",
}
OUTPUT = (
    "OBJ, PLY, GLB, glTF, 3MF, VTP, GIFTI or FreeSurfer (.surf, .flat) file, or a folder that exists, or - "
    "for standard output"
)
METHOD: Argument = {"choices": sorted(METHODS), "default": "linabf"}
WEIGHT: Argument = {
    "metavar": "W",
    "type": float,
    "help": "of areas against angles, for the method isometric: 0 (angles) to 8 (areas); default: 1.5",
}
PICTURE: Argument = {"metavar": "OUT.png", "type": Path, "help": "checkerboard picture to write"}

BOUNDARY: Argument = {
    "choices": get_args(BoundaryName),
    "default": "free",
    "help": "shape of the map's boundary, for linabf and abf (circles: holes as well; default: free)",
}
CONES: Argument = {
    "metavar": "N",
    "help": "leave the curvature at so many vertices of each component, or at auto: as many as pay",
}
CORNERS: Argument = {
    "metavar": "VERTEX",
    "type": int,
    "nargs": 4,
    "help": "boundary vertices at the corners of the rectangle (default: where it turns most)",
}


Run = Callable[[argparse.Namespace], int]


@dataclass(frozen=True)
class Command:
    """One command of the command line.

    Attributes
    ----------
    name : what follows `igl-linabf`
    run : runs it and returns the exit code
    help : a line for the list of commands
    arguments : by name, in the order of the help
    description : what its own help begins with
    examples : command lines that end its help
    each : whether `run` is for one mesh, and is called for each of `options.mesh`
    """

    name: str
    run: Run
    help: str
    arguments: Mapping[str, Argument]
    description: str | None = None
    examples: tuple[str, ...] = ()
    each: bool = False


def count_of_cones(text: str | None) -> int | Literal["auto"] | None:
    """How many cones `--cones` asks for."""
    if text is None:
        return None
    if text == "auto":
        return "auto"
    if not text.isdecimal():
        raise ValueError(f"--cones is {text!r}: use auto, or a number")
    return int(text)


def method_with(name: str, asked: Mapping[str, Any]) -> Method:
    """The method with the options that were given; an error if one of them means nothing to it."""
    chosen = METHODS[name]
    known = {field.name for field in fields(chosen)}  # type: ignore[arg-type]
    given = {option: value for option, value in asked.items() if value not in ("auto", None)}
    for option in given:
        if option not in known:
            raise ValueError(f"--{option} means nothing to the method {name}: leave it out")
    return chosen(**given)
