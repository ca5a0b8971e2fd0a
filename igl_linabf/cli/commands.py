"""What a command is: its name, its arguments, and the function that runs it; its errors are one sentence."""

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

STANDARD = "-"  # input or output

Asked = TypeVar("Asked")
Run = Callable[[argparse.Namespace], int]


class ExitCode(IntEnum):
    """What the command's end tells a shell: all maps are valid; some are not; there is none."""

    GOOD = 0
    NOT_VALID = 1
    ERROR = 2


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


def auto_or_number(option: str, text: str | None) -> int | Literal["auto"] | None:
    """What an option asks for, if it asks."""
    if text is not None and text != "auto" and not text.isdecimal():
        raise ValueError(f"--{option} is {text!r}: use auto, or a number")
    return None if text is None else "auto" if text == "auto" else int(text)


def method_with(name: str, asked: Mapping[str, Any]) -> Method:
    """The method with the options that were given; an error if one of them means nothing to it."""
    chosen = METHODS[name]
    known = {field.name for field in fields(chosen)}  # type: ignore[arg-type]
    given = {option: value for option, value in asked.items() if value not in ("auto", None)}
    for option in given:
        if option not in known:
            raise ValueError(f"--{option} means nothing to the method {name}: leave it out")
    return chosen(**given)


def options_as(kind: Callable[..., Asked], options: argparse.Namespace, *first: object) -> Asked | None:
    """The dataclass of those of its fields that were given as options; None if there are none of them."""
    names = [field.name for field in fields(kind) if hasattr(options, field.name)]  # type: ignore[arg-type]
    given = {name: value for name in names if (value := getattr(options, name)) != getattr(kind, name)}
    return kind(*first, **given) if given or first else None


def told(run: Run, options: argparse.Namespace) -> int:
    """Run; an error is a line that names the mesh if it is one among several.

    `options.title` is the mesh's name for the user, `options.of` begins what is said of one of several.
    """
    try:
        return int(run(options))
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        said = f"{place}{error.strerror or error}"
        _give_up_stdout()
    except MemoryError:
        said = f"{options.title}: not enough memory: decimate the mesh"
    except (MeshError, ImportError, ValueError) as error:
        said = str(error)
    begin = "" if said.startswith(options.title) else options.of
    print(f"igl-linabf: {begin}{said}", file=sys.stderr)
    return ExitCode.ERROR


def _give_up_stdout() -> None:
    """If stdout is broken, do not flush it again at the end of the process."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
