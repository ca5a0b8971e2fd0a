"""Run a command on each mesh: expand patterns, read standard input, name the output files."""

import argparse
import contextlib
import glob
import os
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from .._runtime import progress_part, reporting, undo_at_interrupt
from ..io import MeshFile, check_free, detect_suffix, files_beside, read_file
from .commands import STDIO, RunFunction, run_and_report

# Shares of the progress bar at the end of each step; a picture may be drawn after the map is written.
PROGRESS = {"reading": 0.1, "computing": 0.8, "baking": 0.9, "writing": 0.9}


def run_each(options: argparse.Namespace, run: RunFunction) -> int:
    """Run a command on each mesh of `options.mesh`, and return the worst exit code.

    An error in one mesh does not stop the run. The command finds one mesh in `options.mesh`, and the paths
    of its files in `options.output` and `options.picture`. `options.title` is the name of the mesh. Messages
    about one of several meshes start with `options.prefix`.
    """
    names = _expand_patterns(options.mesh)
    if getattr(options, "output", None) == Path(STDIO) and options.json:
        raise ValueError("--json and -o - both write to standard output: leave one out")
    into = {
        kind: _choose_output_paths(getattr(options, kind), names, suffix)
        for kind, suffix in (("output", f".{getattr(options, 'format', None) or 'obj'}"), ("picture", ".png"))
        if getattr(options, kind, None) is not None
    }
    asked = getattr(options, "output", None)
    places = (place for places in into.values() for place in places if place != asked)
    check_free(places, getattr(options, "force", False))
    code = 0
    with contextlib.ExitStack() as stack:
        for i, name in enumerate(names):
            last = i == len(names) - 1
            own = {kind: places[i] for kind, places in into.items()}
            on_commit = options.on_commit if last else _do_nothing
            mesh = stack.enter_context(_spool_standard_input()) if name == STDIO else Path(name)
            title = "standard input" if name == STDIO else name
            called = {"title": title, "prefix": "" if len(names) == 1 else f"{title}: "}
            one = argparse.Namespace(
                **{**vars(options), **own, **called, "mesh": mesh, "on_commit": on_commit}
            )
            code = max(code, run_and_report(partial(_run_with_progress, run=run), one))
    return code


def _run_with_progress(options: argparse.Namespace, run: RunFunction) -> int:
    """Run with a single progress bar, which ends before anything is printed."""
    with reporting(False if options.quiet or options.json else None):
        return run(options)


def read_given_mesh(options: argparse.Namespace, partial: bool = False) -> MeshFile:
    """Read the file `options.mesh`; with `partial`, some corners may lack texture coordinates."""
    if options.mesh.is_dir():
        raise ValueError(f"{options.mesh} is a folder: give its files, or use igl-linabf batch")
    with progress_part("reading", PROGRESS["reading"]):
        return read_file(options.mesh, getattr(options, "surface", None), partial=partial)


def check_companion_files(
    options: argparse.Namespace, mesh: MeshFile, kinds: Sequence[str] = (), second: bool = False
) -> None:
    """Raise if a file beside the output exists already, or is also the picture of this run.

    Called before the computation. `kinds` are the images to write; `second` means second texture coordinates.
    """
    if options.output == Path(STDIO):
        return
    pages = getattr(options, "pages", None) or 1
    beside = files_beside(options.output, mesh, kinds, pages, second)
    if options.picture in beside:
        raise ValueError(
            f"the picture and the texture would both be written to {options.picture}: name another"
        )
    check_free(beside, options.force)


def _do_nothing() -> None:
    """Leave Ctrl-C enabled, because more meshes follow."""


def _expand_patterns(given: Sequence[str]) -> list[str]:
    """Replace each pattern by the sorted names of its files; keep names that are files."""
    names: list[str] = []
    for name in given:
        found = [name]
        if glob.has_magic(name) and not os.path.exists(name):
            found = sorted(path for path in glob.glob(name, recursive=True) if not os.path.isdir(path))
            if not found:
                raise ValueError(f"{name}: no file matches this pattern")
        names += found
    if names.count(STDIO) > 1:
        raise ValueError("- is given twice: standard input holds one mesh")
    return names


def _choose_output_paths(given: Path, names: Sequence[str], suffix: str) -> list[Path]:
    """Return the output file of each mesh: the given one, or one named after the mesh in a given folder."""
    if not given.is_dir():
        if len(names) == 1:
            return [given]
        raise ValueError(
            f"{given} is not a folder, and there are {len(names)} meshes: give an existing folder, or use "
            "igl-linabf batch"
        )
    places = [given / f"{'stdin' if name == STDIO else Path(name).stem}{suffix}" for name in names]
    for i, place in enumerate(places):
        if place in places[:i]:
            first = names[places.index(place)]
            raise ValueError(f"{first} and {names[i]} would both be written to {place}: use igl-linabf batch")
    return places


@contextlib.contextmanager
def _spool_standard_input() -> Iterator[Path]:
    """Write standard input to a temporary file, with a suffix detected from the data."""
    data = sys.stdin.buffer.read()
    with TemporaryDirectory(prefix="igl_linabf-") as folder:
        path = Path(folder) / f"standard_input{detect_suffix(data)}"
        with undo_at_interrupt(lambda: path.unlink(missing_ok=True)):
            path.write_bytes(data)
            yield path
