"""Write the output of a command: print its results, and rename its files after all of them are written."""

import contextlib
import json
import math
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from .._runtime import progress_part
from .._types import FloatArray, IntArray
from ..errors import MeshWarning, escape_control_characters, stack_level
from ..io import replacing, write_atomically
from .jobs import PROGRESS, STDIO, ExitCode, Job

OMITTED_FIELDS = {
    "FTC",
    "split",
    "outlines",
    "cut_lines",
    "sides",
}  # fields of results that are left out of JSON
INDEX_FIELDS = {"flipped", "repaired", "first"}  # arrays that are included in JSON
JSON_KEYS = {"n_splits": "splits", "distortion_increase": "cost"}  # fields with a different key in JSON


def make_writer(job: Job) -> Callable[..., AbstractContextManager[None]]:
    """Return a function that writes a mesh file.

    If the mesh is written to standard output, its references to files are relative to the current folder.
    """
    folder = Path.cwd() if job.output == STDIO else None
    return partial(write_atomically, force=job.force, folder=folder)


def report_troubles(job: Job, good: bool, troubles: Iterable[str]) -> ExitCode:
    """Print the problems of a map that has been written, and return the exit code."""
    for message in troubles:
        print(f"igl-linabf: {escape_control_characters(job.prefix + job.explain(message))}", file=sys.stderr)
    return ExitCode.GOOD if good else ExitCode.NOT_VALID


def write_outputs(
    job: Job,
    text: str,
    figures: Mapping[str, object],
    pictured: tuple[FloatArray, IntArray, Mapping[str, FloatArray]] | None = None,
    write: Callable[[str | Path], AbstractContextManager[None]] | None = None,
) -> None:
    """Write all files under temporary names, print text or figures, and only then rename the files.

    `write(path)` returns a context manager that writes a file, and renames it when the block ends.
    """
    picture = None if pictured is None else job.picture
    to_stdout = write is not None and job.output == STDIO
    with contextlib.ExitStack() as stack:
        if write is not None:
            with progress_part("writing", PROGRESS["writing"] if picture else 1.0):
                if to_stdout:
                    data = _write_to_bytes(job, write)
                else:
                    stack.enter_context(write(job.output_name))
        if pictured is not None and picture is not None:
            from ..plot import plot_compare

            path = stack.enter_context(replacing(picture))
            with progress_part("picture", 1.0):
                plot_compare(*pictured, off_screen=True, screenshot=path).close()
        try:
            if to_stdout:
                sys.stdout.flush()
                sys.stdout.buffer.write(data)
            if job.json:
                print(_to_json({"mesh": job.title, **figures}), flush=True)
            elif not job.quiet:
                text = job.explain(text)
                text = f"{escape_control_characters(job.title)}\n{text}\n" if job.prefix else text
                print(text, flush=True, file=sys.stderr if to_stdout else sys.stdout)
            sys.stdout.flush()
        except OSError as error:
            raise OSError(error.errno, error.strerror, "standard output") from None
        job.on_commit()


def _write_to_bytes(job: Job, write: Callable[[str | Path], AbstractContextManager[None]]) -> bytes:
    """Return the bytes of a file in the format requested for standard output."""
    with TemporaryDirectory(prefix="igl_linabf-") as folder:
        path = Path(folder) / job.output_name
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
        pairs = _list_fields(value)
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


def _list_fields(result: Any) -> Iterator[tuple[str, object]]:
    """Yield the JSON key and the value of each field of a result and of its `report`."""
    for field in fields(result):
        if field.name == "report":
            yield from _list_fields(result.report)
        elif field.name not in OMITTED_FIELDS:
            yield JSON_KEYS.get(field.name, field.name), getattr(result, field.name)
