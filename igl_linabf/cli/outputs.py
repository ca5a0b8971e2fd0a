"""Output of a command: files are checked before the computation, and renamed only after all are written."""

import argparse
import contextlib
import json
import math
import os
import sys
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from .._runtime import progress_part
from .._types import FloatArray, IntArray
from ..errors import MeshWarning, stack_level
from ..io import replacing, suffix_of, write_atomically
from .commands import STDIO, ExitCode
from .jobs import PROGRESS

OMITTED_FIELDS = {"FTC", "split", "outlines", "sides"}  # fields of results that JSON leaves out
INDEX_FIELDS = {"flipped", "repaired", "first"}  # arrays that JSON includes


def check_outputs(mesh: Path | None, png: Path | None, suffixes: Sequence[str] = (".obj",)) -> None:
    """Raise if the output files have an unknown suffix or cannot be written."""
    for path, known in ((mesh, suffixes), (png, (".png",))):
        if path is None or path == Path(STDIO):
            continue
        if suffix_of(path) not in known:
            raise ValueError(f"{path} does not end in {' or '.join(known)}: give a file name that does")
        if not os.access(path.parent, os.W_OK):
            raise OSError(None, "the folder is missing or cannot be written to", str(path.parent))
    if png is not None:
        from .. import plot  # noqa: F401  # raises with instructions if pyvista is missing


def make_writer(options: argparse.Namespace) -> Callable[..., AbstractContextManager[None]]:
    """Return a function that writes a mesh file.

    On standard output, names of other files are relative to the current folder.
    """
    folder = Path.cwd() if options.output == Path(STDIO) else None
    return partial(write_atomically, force=options.force, folder=folder)


def report_troubles(options: argparse.Namespace, good: bool, troubles: Iterable[str]) -> int:
    """Print the troubles of a written map, and return the exit code."""
    for message in troubles:
        print(f"igl-linabf: {options.prefix}{message}", file=sys.stderr)
    return ExitCode.GOOD if good else ExitCode.NOT_VALID


def write_outputs(
    options: argparse.Namespace,
    text: str,
    figures: Mapping[str, object],
    pictured: tuple[FloatArray, IntArray, Mapping[str, FloatArray]] | None = None,
    write: Callable[[str | Path], AbstractContextManager[None]] | None = None,
) -> None:
    """Write all files under temporary names, print text or figures, and only then rename the files.

    `write(path)` returns a context manager that writes a file, and renames it when the block ends.
    """
    picture = None if pictured is None else options.picture
    to_stdout = write is not None and options.output == Path(STDIO)
    with contextlib.ExitStack() as stack:
        if write is not None:
            with progress_part("writing", PROGRESS["writing"] if picture else 1.0):
                if to_stdout:
                    data = _write_to_bytes(options, write)
                else:
                    stack.enter_context(write(options.output))
        if pictured is not None and picture is not None:
            from ..plot import plot_compare

            path = stack.enter_context(replacing(picture))
            with progress_part("picture", 1.0):
                plot_compare(*pictured, off_screen=True, screenshot=path).close()
        try:
            if to_stdout:
                sys.stdout.flush()
                sys.stdout.buffer.write(data)
            if options.json:
                print(_to_json({"mesh": options.title, **figures}), flush=True)
            elif not options.quiet:
                text = f"{options.title}\n{text}\n" if options.prefix else text
                print(text, flush=True, file=sys.stderr if to_stdout else sys.stdout)
            sys.stdout.flush()
        except OSError as error:
            raise OSError(error.errno, error.strerror, "standard output") from None
        options.on_commit()


def _write_to_bytes(
    options: argparse.Namespace, write: Callable[[str | Path], AbstractContextManager[None]]
) -> bytes:
    """Return the bytes for standard output, in the requested format."""
    with TemporaryDirectory(prefix="igl_linabf-") as folder:
        path = Path(folder) / f"map.{getattr(options, 'format', None) or 'obj'}"
        with write(path):
            pass
        beside = sorted(other.name for other in path.parent.iterdir() if other != path)
        if beside:
            warnings.warn(
                f"standard output holds one file: {', '.join(beside)} beside it are left out",
                MeshWarning,
                stacklevel=stack_level(),
            )
        return path.read_bytes()


def _to_json(figures: Mapping[str, object]) -> str:
    """Return one line of JSON; infinite and undefined numbers become null."""
    return json.dumps(_to_plain(figures), allow_nan=False)


def _to_plain(value: object) -> object:
    """Convert a result to dictionaries, lists, strings and numbers, without the arrays of the map."""
    if is_dataclass(value) and not isinstance(value, type):
        pairs = (
            (field.name, getattr(value, field.name))
            for field in fields(value)
            if field.name not in OMITTED_FIELDS
        )
        return {k: _to_plain(v) for k, v in pairs if not isinstance(v, np.ndarray) or k in INDEX_FIELDS}
    if isinstance(value, Mapping):
        return {str(k): _to_plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray):
        return _to_plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_to_plain(v) for v in value]
    if isinstance(value, Enum):
        return _to_plain(value.value)
    if isinstance(value, np.generic):
        return _to_plain(value.item())
    return None if isinstance(value, float) and not math.isfinite(value) else value
