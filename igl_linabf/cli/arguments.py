"""Describe the options and arguments of commands; define and read the options that several commands share.

A command is a function. Its parameter `weight: Annotated[float, Option("weight of areas", "W")] = 1.5` is the
option `--weight W`, and the type converts the text. A parameter without a default is an argument. A parameter
`packing: Annotated[Packing, {"pages": Option(...)}]` is a `Packing` with options for some of its fields.
"""

import argparse
import reprlib
from argparse import ArgumentError, ArgumentTypeError
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from inspect import Parameter, signature
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
import shtab

from ..batch import BAKED_RESOLUTION, find_texture_seams
from ..charts import ChartOptions
from ..errors import MeshError
from ..flattening import METHODS, BoundaryName, Method
from ..io import MeshFile

AXES = ("x", "y", "z")
TYPE_NAMES = {int: "an integer", float: "a number"}

Command = Callable[..., int]


@dataclass(frozen=True)
class Option:
    """The description of a command line option or argument."""

    help: str  # the default value is appended unless the text contains "default"
    metavar: str | None = None
    parse: Callable[[str], Any] | None = None  # by default, try the types of the parameter in order
    choices: Sequence[Any] = ()  # by default, the values of a `Literal` type
    nargs: int | Literal["+"] | None = None
    flags: Sequence[str] = ()  # by default, the name of the parameter
    required: bool = False


def describe_output_option(help: str) -> Option:
    """Describe the required option `-o` of a command."""
    return Option(help, "OUT", flags=("-o", "--output"), required=True)


ALLOW_OUTSIDE = Option(
    "follow references, such as images and links, that lead out of the file's folder (not for files of "
    "strangers)"
)


def add_options(parser: argparse.ArgumentParser, command: Command) -> None:
    """Add the options and arguments of a command to its parser."""
    for name, option, annotation, default in _iterate_options(command):
        kinds = _list_types(annotation)
        positional = default is Parameter.empty and not option.required
        names = [name] if positional else option.flags or [write_flag(name)]
        settings: dict[str, Any] = {"help": option.help}
        if not positional:
            settings |= {"dest": name, "default": default, "required": option.required}
        if kinds == [bool]:
            parser.add_argument(*names, action="store_true", **settings)
            continue
        if default not in (None, Parameter.empty) and "default" not in option.help:
            settings["help"] += f" (default: {default:g})" if kinds == [float] else f" (default: {default})"
        words = get_args(kinds[0]) if [get_origin(kind) for kind in kinds] == [Literal] else None
        choices = option.choices or words
        settings |= {"metavar": option.metavar, "nargs": option.nargs, "choices": choices}
        convert = partial(_convert_text, name=names[-1], kinds=kinds)
        settings["type"] = type(choices[0]) if choices else option.parse or convert
        action = parser.add_argument(*names, **settings)
        if Path in kinds or positional:
            action.complete = shtab.FILE  # type: ignore[attr-defined]


def bind_options(command: Command, values: Mapping[str, Any]) -> dict[str, Any]:
    """Convert the values of a command's options to the arguments of the command's function.

    A dataclass parameter that may be None is None if all its options have their default values.
    """
    bound = {}
    for name, parameter in signature(command).parameters.items():
        kind, described = get_args(parameter.annotation)
        if isinstance(described, Option):
            bound[name] = values[name]
        else:
            given = {field: values[field] for field in described}
            (build,) = _list_types(kind)
            is_default = all(getattr(build, field, None) == value for field, value in given.items())
            bound[name] = None if kind != build and is_default else build(**given)
    return bound


def list_flags(command: Command) -> dict[str, tuple[str, bool]]:
    """Return the flag of each option of a command, and whether it takes a value, by the parameter's name."""
    return {
        name: (option.flags[-1] if option.flags else write_flag(name), _list_types(annotation) != [bool])
        for name, option, annotation, default in _iterate_options(command)
        if default is not Parameter.empty or option.required
    }


def write_flag(name: str) -> str:
    """Return the default flag of a parameter."""
    return f"--{name.replace('_', '-')}"


def _iterate_options(command: Command) -> Iterator[tuple[str, Option, Any, Any]]:
    """Yield the name, description, type and default of each option of a command."""
    for name, parameter in signature(command).parameters.items():
        kind, described = get_args(parameter.annotation)
        if isinstance(described, Option):
            yield name, described, kind, parameter.default
        else:
            (build,) = _list_types(kind)
            kinds, defaults = get_type_hints(build), signature(build).parameters
            yield from (
                (field, option, kinds[field], defaults[field].default) for field, option in described.items()
            )


def _list_types(annotation: Any) -> list[Any]:
    """Return the types that an annotation allows, without None; for a list, the type of its elements."""
    kinds = get_args(annotation) if get_origin(annotation) in (Union, UnionType) else [annotation]
    kinds = [kind for kind in kinds if kind is not NoneType]
    return [get_args(kind)[0] if get_origin(kind) is list else kind for kind in kinds]


def _convert_text(text: str, name: str, kinds: Sequence[Any]) -> Any:
    """Convert a text to the first of the types that accepts it; a `Literal` type accepts its values."""
    for kind in kinds:
        if text in get_args(kind):
            return text
        try:
            return kind(text)
        except (TypeError, ValueError):  # a `Literal` cannot be called
            continue
    known = [" or ".join(map(str, get_args(kind))) or TYPE_NAMES[kind] for kind in kinds]
    raise ArgumentError(None, f"{name} is {text!r}: use {', or '.join(known)}")


def parse_texels(text: str) -> int | tuple[int, int]:
    """Convert a text such as "1024" or "2048x1024" to a number of texels, or to a width and a height."""
    try:
        sides = tuple(int(word) for word in text.lower().split("x"))
    except ValueError:
        sides = ()
    if len(sides) not in (1, 2) or min(sides) < 1:
        raise ArgumentTypeError(
            f"{text!r} is not a number of texels: give 1024, or width and height, 2048x1024"
        )
    return sides[0] if len(sides) == 1 else (sides[0], sides[1])


def parse_axis(text: str) -> list[float]:
    """Convert a signed axis such as "x" or "-y", or three numbers separated by commas, to a vector."""
    name = text.lstrip("+-")
    if name in AXES and len(text) - len(name) <= 1:
        sign = -1.0 if text.startswith("-") else 1.0
        return [sign * (letter == name) for letter in AXES]
    try:
        x, y, z = (float(number) for number in text.split(","))
    except ValueError:
        raise ArgumentTypeError(
            f"{text!r} is not a direction: give x, y, z, -z as in --up=-z, or three numbers such as 0,-1,0"
        ) from None
    return [x, y, z]


def parse_factors(text: str) -> tuple[float, float]:
    """Convert two numbers separated by a comma, such as "1.03,1.05"."""
    try:
        across, along = (float(number) for number in text.split(","))
    except ValueError:
        raise ArgumentTypeError(
            f"{text!r} are not two factors: give two numbers, such as 1.03,1.05"
        ) from None
    return across, along


def parse_axis_or_word(text: str, words: Sequence[str]) -> list[float] | str:
    """Convert a direction to a vector; return any of the given words unchanged."""
    return text if text in words else parse_axis(text)


def build_method(name: str, **options: Any) -> Method:
    """Return the flattening method with the given options; None and "auto" stand for the defaults.

    Raises
    ------
    ValueError
        The method does not have one of the options.
    """
    method = METHODS[name]
    known = {field.name for field in fields(method)}  # type: ignore[arg-type]
    given = {option: value for option, value in options.items() if value not in ("auto", None)}
    for option in given:
        if option not in known:
            raise ValueError(f"--{option} is not an option of the method {name}: leave it out")
    return method(**given)


MethodName = Annotated[str, Option("method", choices=sorted(METHODS))]
Weight = Annotated[
    float | None,
    Option("weight of areas against angles, 0 (angles) to 8 (areas), for isometric; default: 1.5", "W"),
]
Boundary = Annotated[BoundaryName, Option("shape of the boundary, for linabf and abf (circles: holes, too)")]
Corners = Annotated[
    list[int] | None, Option("vertices at the corners of a rectangle (default: found)", "VERTEX", nargs=4)
]
ConeCount = Annotated[
    Literal["auto"] | int | None,
    Option("concentrate the curvature at N vertices of each component; auto: choose the number", "N"),
]
Units = Annotated[
    Literal["square", "mesh"] | None,
    Option(
        "scale of a flattened map: the unit square, or the mesh's units of length (default: square; "
        "mesh if the map is written as a surface: GIFTI, .surf, .flat)"
    ),
]
CHARTS = {
    "trade": Option("larger: longer seams for less stretch; 0: shortest seams", "TRADE"),
    "max_stretch": Option("cut charts until their L2 stretch is at most L2", "L2"),
    "max_dirichlet": Option(
        "bound on the mean symmetric Dirichlet energy of the whole atlas, which is 4 for an isometry (4.1 is "
        "usual): the shortest seams found by a search over trade",
        "ENERGY",
    ),
    "max_charts": Option("bound on the number of charts, by a search over trade", "N"),
    "hide": Option(
        "where seams may lie: the direction in which the back or underside faces (--hide=0,-1,0); or back: "
        "the side of a head or figure that has no face",
        "X,Y,Z or back",
        partial(parse_axis_or_word, words=("back",)),
    ),
    "keep_holes": Option("leave holes uncut"),
    "repair_overlaps": Option("move overlapping parts apart instead of splitting charts"),
}
PACKING = {
    "resolution": Option(
        "texels along a page's side, or its width and height (2048x1024); distances between charts are then "
        "counted in texels",
        "TEXELS",
        parse_texels,
    ),
    "padding": Option(
        "distance between two charts, with --resolution; the distance to the page's border is half of it",
        "TEXELS",
    ),
    "texel_density": Option("texels per unit of length (default: fill the pages)", "TEXELS"),
    "pages": Option("number of pages, as UDIM tiles (default: 1, or as many as needed)", "N"),
    "unseen": Option(
        "share of the texel density for charts that no ray from outside reaches, such as cavities", "SHARE"
    ),
}
UNWRAP_PACKING = {
    **PACKING,
    "cut_below": Option(
        "cut charts further if they would fill less than this share of the page (default: 0.5, and 1 with "
        "--resolution); 0: never",
        "FILL",
    ),
}
SEAMS = Option(
    "auto, uv (seams of the file's texture coordinates), or a text file with the two vertices of an edge on "
    "each line, counted from 0",
    "SEAMS",
)
EXTEND_SEAMS = Option("add the seams that --seams lacks", flags=("--extend-seams",))
PERIOD = Option(
    "period of a texture, as a share of the page's side: it continues across seams of quarter turns", "SHARE"
)
KEEP_MATERIALS = Option("cut where two materials meet: no chart has faces of both")
WELD = Option(
    "merge vertices within this distance; 0: merge coincident vertices (default where most of the boundary "
    "lies on itself); no: merge nothing",
    "DISTANCE",
)
BAKE = Option(
    f"bake a texture of --resolution texels ({BAKED_RESOLUTION}) into a GLB, glTF or 3MF file, or beside an "
    "OBJ: the colours of vertices, faces and materials, the images of the old texture coordinates, normals "
    "in the object's space (127.5 (n + 1)), or positions in the bounding cube"
)
TEXCOORD = Option(
    "1: write second texture coordinates, such as for lightmaps; keep the first set and its images"
)
STRICT = Option("refuse a mesh that is not a clean manifold instead of repairing it")


def read_seams(
    seams: Literal["auto", "uv"] | Path, mesh: MeshFile, charts: ChartOptions | None, method: Any
) -> Any:
    """Return the seam edges from texture coordinates or a file; None for automatic seams."""
    if seams == "auto":
        return None
    if seams != "uv":
        what = "the two vertices of an edge, counted from 0 and separated by a space,"
        return read_rows(seams, np.int64, 2, what)
    return find_texture_seams(mesh, charts, method)


def read_rows(path: Path, kind: type, size: int, what: str) -> Any:
    """Return the rows of a text file, (n, size), as an array. Empty lines and text after # are skipped.

    Parameters
    ----------
    path : Path
    kind : type
        Type of the numbers.
    size : int
        Number of columns.
    what : str
        What each line contains, for the message of an error.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except FileNotFoundError:
        raise MeshError(f"there is no file {path}: name a file with {what} on each line") from None
    except UnicodeDecodeError:
        raise MeshError(f"{path} is not a text file in UTF-8: write {what} on each line") from None
    rows = []
    for number, line in enumerate(lines, 1):
        words = line.partition("#")[0].split()
        try:
            row = [kind(word) for word in words]
        except (ValueError, OverflowError):
            row = []
        if words and len(row) != size:
            raise MeshError(
                f"line {number} of {path} is {reprlib.repr(line.strip())}: write {what} on each line"
            )
        if words:
            rows.append(row)
    return np.array(rows, dtype=kind).reshape(-1, size)
