"""What goes wrong is one sentence on stderr, and an exit code."""

from __future__ import annotations

import argparse
import os
import sys

from ..errors import MeshError
from .commands import ERROR, Run


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
    return ERROR


def _give_up_stdout() -> None:
    """If stdout is broken, do not flush it again at the end of the process."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
