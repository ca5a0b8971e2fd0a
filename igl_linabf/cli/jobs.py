"""One job a mesh: patterns of names, standard input, folders for the output."""

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
from .commands import STANDARD, Run, told

# Share of the progress bar at which each part of a job ends; a picture may follow what is written.
PROGRESS = {"reading": 0.1, "computing": 0.8, "baking": 0.9, "writing": 0.9}


def run_each(options: argparse.Namespace, run: Run) -> int:
    """Run a command on each mesh of `options.mesh`. Each has its errors; the worst exit code is the end's.

    The command finds one mesh in `options.mesh` and its files in `options.output` and `options.picture`.
    `options.title` is its name for the user, and `options.of` begins what is said of one among several.
    """
    names = _expanded(options.mesh)
    if getattr(options, "output", None) == Path(STANDARD) and options.json:
        raise ValueError("--json and -o - both write to standard output: leave one out")
    into = {
        kind: _places(getattr(options, kind), names, suffix)
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
            settled = options.settled if last else _not_settled
            mesh = stack.enter_context(_standard_input()) if name == STANDARD else Path(name)
            title = "standard input" if name == STANDARD else name
            called = {"title": title, "of": "" if len(names) == 1 else f"{title}: "}
            one = argparse.Namespace(**{**vars(options), **own, **called, "mesh": mesh, "settled": settled})
            code = max(code, told(partial(_in_one_bar, run=run), one))
    return code


def _in_one_bar(options: argparse.Namespace, run: Run) -> int:
    """Run with one progress bar over all that it does, which ends before anything is printed."""
    with reporting(False if options.quiet or options.json else None):
        return run(options)


def given_mesh(options: argparse.Namespace, partial: bool = False) -> MeshFile:
    """What the file of `options.mesh` holds; with `partial` texture coordinates of only some corners, too."""
    if options.mesh.is_dir():
        raise ValueError(f"{options.mesh} is a folder: give its files, or use igl-linabf batch")
    with progress_part("reading", PROGRESS["reading"]):
        return read_file(options.mesh, getattr(options, "surface", None), partial=partial)


def check_beside(
    options: argparse.Namespace, mesh: MeshFile, kinds: Sequence[str] = (), second: bool = False
) -> None:
    """Refuse before the work what would replace a file beside the output, or one of this run."""
    if options.output == Path(STANDARD):
        return
    pages = getattr(options, "pages", None) or 1
    beside = files_beside(options.output, mesh, kinds, pages, second)
    if options.picture in beside:
        raise ValueError(
            f"the picture and the texture would both be written to {options.picture}: name another"
        )
    check_free(beside, options.force)


def _not_settled() -> None:
    """More is to come: Ctrl-C still ends it."""


def _expanded(given: Sequence[str]) -> list[str]:
    """The files of patterns, in order; a name that is a file stays as it is."""
    names: list[str] = []
    for name in given:
        found = [name]
        if glob.has_magic(name) and not os.path.exists(name):
            found = sorted(path for path in glob.glob(name, recursive=True) if not os.path.isdir(path))
            if not found:
                raise ValueError(f"{name}: no file has such a name")
        names += found
    if names.count(STANDARD) > 1:
        raise ValueError("- is given twice: standard input holds one mesh")
    return names


def _places(given: Path, names: Sequence[str], suffix: str) -> list[Path]:
    """The file for each mesh: the given one, or one of the mesh's name in the given folder."""
    if not given.is_dir():
        if len(names) == 1:
            return [given]
        raise ValueError(
            f"{given} is no folder, and there are {len(names)} meshes: give a folder that exists, or use "
            "igl-linabf batch"
        )
    places = [given / f"{'stdin' if name == STANDARD else Path(name).stem}{suffix}" for name in names]
    for i, place in enumerate(places):
        if place in places[:i]:
            first = names[places.index(place)]
            raise ValueError(f"{first} and {names[i]} would both be written to {place}: use igl-linabf batch")
    return places


@contextlib.contextmanager
def _standard_input() -> Iterator[Path]:
    """A file with the mesh on standard input; what is in it tells its format."""
    data = sys.stdin.buffer.read()
    with TemporaryDirectory(prefix="igl_linabf-") as folder:
        path = Path(folder) / f"standard_input{detect_suffix(data)}"
        with undo_at_interrupt(lambda: path.unlink(missing_ok=True)):
            path.write_bytes(data)
            yield path
