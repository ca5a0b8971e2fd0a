"""Files and text leave together: all checked before the work, all written before the first is renamed."""

from __future__ import annotations

import argparse
import contextlib
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from .._types import FloatArray, IntArray
from ..io import replacing


def check_outputs(mesh: Path | None, png: Path | None, suffixes: Sequence[str] = (".obj",)) -> None:
    """Check before the computation that its results can be written."""
    for path, known in ((mesh, suffixes), (png, (".png",))):
        if path is None:
            continue
        if path.suffix.lower() not in known:
            raise ValueError(f"{path} does not end in {' or '.join(known)}: give a file name that does")
        if not os.access(path.parent, os.W_OK):
            raise OSError(None, "the folder is missing or cannot be written to", str(path.parent))
    if png is not None:
        from .. import plot  # noqa: F401  # says how to get pyvista where it is missing


def hand_out(
    options: argparse.Namespace,
    text: str,
    pictured: tuple[FloatArray, IntArray, Mapping[str, FloatArray]],
    write: Callable[[str], None] | None = None,
) -> None:
    """Write all files under temporary names, print the text, and only then rename the files."""
    with contextlib.ExitStack() as stack:
        if write is not None:
            write(stack.enter_context(replacing(options.output)))
        if options.picture is not None:
            from ..plot import plot_compare

            path = stack.enter_context(replacing(options.picture))
            plot_compare(*pictured, off_screen=True, screenshot=path).close()
        try:
            print(text, flush=True)
        except OSError as error:
            raise OSError(error.errno, error.strerror, "standard output") from None
        options.settled()
