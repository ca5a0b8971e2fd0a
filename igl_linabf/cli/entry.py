"""The command from its arguments to its exit code; errors and warnings in a line each."""

from __future__ import annotations

import contextlib
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence

from .commands import told
from .parser import command_parser


def main(arguments: Sequence[str] | None = None, *, settled: Callable[[], object] = lambda: None) -> int:
    """Run the command; returns 0, 1 for a map with flipped triangles, 2 for an error.

    `settled` is called after everything is printed and written, before the files are renamed to
    their final names.
    """
    options = command_parser().parse_args(arguments)
    options.settled = settled
    options.title, options.of = str(getattr(options, "mesh", "the batch")), ""
    with _warnings_in_a_line():
        return told(options.run, options)


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
