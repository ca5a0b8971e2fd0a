"""Definition of a command, and the conversion of its options and errors."""

import argparse
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from enum import IntEnum
from typing import Any, Literal, TypeVar

from ..errors import MeshError
from ..flattening import METHODS, Method
from .arguments import Argument

STDIO = "-"  # stands for standard input or output

Asked = TypeVar("Asked")
RunFunction = Callable[[argparse.Namespace], int]


class ExitCode(IntEnum):
    """Exit codes: all maps are valid, some are not, or an error occurred."""

    GOOD = 0
    NOT_VALID = 1
    ERROR = 2


@dataclass(frozen=True)
class Command:
    """A command of `igl-linabf`.

    Attributes
    ----------
    name : word after `igl-linabf`
    run : function that runs the command and returns the exit code
    help : line in the list of commands
    arguments : arguments by name, in the order of the help
    description : first paragraph of the command's help
    examples : command lines at the end of the command's help
    each : whether `run` takes one mesh, and is called for each of `options.mesh`
    """

    name: str
    run: RunFunction
    help: str
    arguments: Mapping[str, Argument]
    description: str | None = None
    examples: tuple[str, ...] = ()
    each: bool = False


def parse_auto_or_number(option: str, text: str | None) -> int | Literal["auto"] | None:
    """Convert the value of an option that is "auto", a number or missing."""
    if text is not None and text != "auto" and not text.isdecimal():
        raise ValueError(f"--{option} is {text!r}: use auto, or a number")
    return None if text is None else "auto" if text == "auto" else int(text)


def build_method(name: str, asked: Mapping[str, Any]) -> Method:
    """Return the method with the given options.

    Raises
    ------
    ValueError
        The method does not have one of the options.
    """
    chosen = METHODS[name]
    known = {field.name for field in fields(chosen)}  # type: ignore[arg-type]
    given = {option: value for option, value in asked.items() if value not in ("auto", None)}
    for option in given:
        if option not in known:
            raise ValueError(f"--{option} is not an option of the method {name}: leave it out")
    return chosen(**given)


def build_from_options(kind: Callable[..., Asked], options: argparse.Namespace) -> Asked | None:
    """Build a dataclass from the options that differ from its defaults; None if all are at their defaults."""
    names = [field.name for field in fields(kind) if hasattr(options, field.name)]  # type: ignore[arg-type]
    given = {name: value for name in names if (value := getattr(options, name)) != getattr(kind, name)}
    return kind(**given) if given else None


def run_and_report(run: RunFunction, options: argparse.Namespace) -> int:
    """Run a command and return its exit code; print an error as one line.

    `options.title` is the name of the mesh. Messages about one of several meshes start with
    `options.prefix`.
    """
    try:
        return int(run(options))
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        message = f"{place}{error.strerror or error}"
        _give_up_stdout()
    except MemoryError:
        message = f"{options.title}: not enough memory: decimate the mesh"
    except (MeshError, ImportError, ValueError) as error:
        message = str(error)
    begin = "" if message.startswith(options.title) else options.prefix
    print(f"igl-linabf: {begin}{message}", file=sys.stderr)
    return ExitCode.ERROR


def _give_up_stdout() -> None:
    """Redirect a broken stdout to the null device, so that the exiting process does not flush it again."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
