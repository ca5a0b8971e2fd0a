"""What a command is: its name, its arguments, and the function that runs it."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal

from ..flattening import METHODS, Method
from .arguments import Argument

GOOD, NOT_VALID, ERROR = 0, 1, 2
STANDARD = "-"  # input or output

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
