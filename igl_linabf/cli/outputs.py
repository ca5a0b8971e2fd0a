"""Files and text leave together: all checked before the work, all written before the first is renamed."""

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
from .commands import STANDARD, ExitCode
from .jobs import PROGRESS

MAPS = {"FTC", "split", "outlines", "sides"}  # of an atlas of polygons, and of a pattern
LISTED = {"flipped", "repaired", "first"}  # the arrays of indices that say where something is wrong


def check_outputs(mesh: Path | None, png: Path | None, suffixes: Sequence[str] = (".obj",)) -> None:
    """Check before the computation that its results can be written."""
    for path, known in ((mesh, suffixes), (png, (".png",))):
        if path is None or path == Path(STANDARD):
            continue
        if suffix_of(path) not in known:
            raise ValueError(f"{path} does not end in {' or '.join(known)}: give a file name that does")
        if not os.access(path.parent, os.W_OK):
            raise OSError(None, "the folder is missing or cannot be written to", str(path.parent))
    if png is not None:
        from .. import plot  # noqa: F401  # says how to get pyvista where it is missing


def written_from(options: argparse.Namespace) -> Callable[..., AbstractContextManager[None]]:
    """What writes a mesh file; on standard output, names of files are those from the present folder."""
    folder = Path.cwd() if options.output == Path(STANDARD) else None
    return partial(write_atomically, force=options.force, folder=folder)


def judged(options: argparse.Namespace, good: bool, troubles: Iterable[str]) -> int:
    """Say what is wrong with a map that is written; the exit code."""
    for message in troubles:
        print(f"igl-linabf: {options.of}{message}", file=sys.stderr)
    return ExitCode.GOOD if good else ExitCode.NOT_VALID


def hand_out(
    options: argparse.Namespace,
    text: str,
    figures: Mapping[str, object],
    pictured: tuple[FloatArray, IntArray, Mapping[str, FloatArray]] | None = None,
    write: Callable[[str | Path], AbstractContextManager[None]] | None = None,
) -> None:
    """Write all files under temporary names, print text or figures, and only then rename the files.

    `write` writes a file, which takes its place when the block ends that it begins.
    """
    picture = None if pictured is None else options.picture
    to_stdout = write is not None and options.output == Path(STANDARD)
    with contextlib.ExitStack() as stack:
        if write is not None:
            with progress_part("writing", PROGRESS["writing"] if picture else 1.0):
                if to_stdout:
                    data = _spooled(options, write)
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
                print(_as_json({"mesh": options.title, **figures}), flush=True)
            elif not options.quiet:
                text = f"{options.title}\n{text}\n" if options.of else text
                print(text, flush=True, file=sys.stderr if to_stdout else sys.stdout)
            sys.stdout.flush()
        except OSError as error:
            raise OSError(error.errno, error.strerror, "standard output") from None
        options.settled()


def _spooled(
    options: argparse.Namespace, write: Callable[[str | Path], AbstractContextManager[None]]
) -> bytes:
    """What goes to standard output, in the format that is asked for."""
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


def _as_json(figures: Mapping[str, object]) -> str:
    """One line; infinite and undefined numbers are null."""
    return json.dumps(_plain(figures), allow_nan=False)


def _plain(value: object) -> object:
    """A result as dictionaries, lists, texts and numbers, without the arrays of the map."""
    if is_dataclass(value) and not isinstance(value, type):
        pairs = (
            (field.name, getattr(value, field.name)) for field in fields(value) if field.name not in MAPS
        )
        return {k: _plain(v) for k, v in pairs if not isinstance(v, np.ndarray) or k in LISTED}
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    if isinstance(value, Enum):
        return _plain(value.value)
    if isinstance(value, np.generic):
        return _plain(value.item())
    return None if isinstance(value, float) and not math.isfinite(value) else value
