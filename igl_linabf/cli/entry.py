"""The command from its arguments to its exit code; errors and warnings in a line each."""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence

from ..errors import MeshError
from .commands import ERROR
from .parser import command_parser


def main(arguments: Sequence[str] | None = None, *, settled: Callable[[], object] = lambda: None) -> int:
    """Run the command; returns 0, 1 for a map with flipped triangles, 2 for an error.

    `settled` is called after everything is printed and written, before the files are renamed to
    their final names.
    """
    options = command_parser().parse_args(arguments)
    options.settled = settled
    with _warnings_in_a_line():
        try:
            return int(options.run(options))
        except OSError as error:
            place = f"{error.filename}: " if error.filename else ""
            said = f"{place}{error.strerror or error}"
            _give_up_stdout()
        except MemoryError:
            said = f"{getattr(options, 'mesh', 'the batch')}: not enough memory: decimate the mesh"
        except (MeshError, ImportError, ValueError) as error:
            said = str(error)
        print(f"igl-linabf: {said}", file=sys.stderr)
        return ERROR


def _give_up_stdout() -> None:
    """If stdout is broken, do not flush it again at the end of the process."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextlib.contextmanager
def _warnings_in_a_line() -> Iterator[None]:
    """Print each warning of the library as one line on stderr."""

    def show(message: Warning | str, *_: object, **__: object) -> None:
        print(f"igl-linabf: warning: {message}", file=sys.stderr)

    with warnings.catch_warnings():
        warnings.simplefilter("default")
        for internal in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
            warnings.simplefilter("ignore", internal)  # as Python does
        warnings.showwarning = show
        yield
