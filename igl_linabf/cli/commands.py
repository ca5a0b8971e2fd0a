"""What a command is: its name, its arguments, and the function that runs it."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..flattening import METHODS

GOOD, NOT_VALID, ERROR = 0, 1, 2

Argument = Mapping[str, Any]
"""What `argparse.ArgumentParser.add_argument` takes, the flags aside."""

MESH: Argument = {"metavar": "MESH", "type": Path, "help": "OBJ, OFF, PLY or STL file"}
METHOD: Argument = {"choices": sorted(METHODS), "default": "linabf"}
PICTURE: Argument = {"metavar": "OUT.png", "type": Path, "help": "checkerboard picture to write"}


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
    """

    name: str
    run: Callable[[argparse.Namespace], int]
    help: str
    arguments: Mapping[str, Argument]
    description: str | None = None
