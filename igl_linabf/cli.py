"""The command `igl-linabf`."""

from __future__ import annotations

import argparse
import contextlib
import os
import platform
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from functools import partial
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from ._types import FloatArray, IntArray
from .batch_runs import batch
from .charts import TRADE, texture_seams, unwrap
from .errors import MeshError, OutcomeWarning
from .flattening import METHODS, compare, flatten
from .io import SUFFIXES, read_mesh, read_texture, replacing, unit_square, write_mesh, write_obj
from .linalg import HOW_TO_GET, blas_of_cholmod, has_cholmod
from .measures import MEASURES, quality

GOOD, NOT_VALID, ERROR = 0, 1, 2
SHELLS = ("bash", "zsh", "fish")
FLAGS = {"mesh": ["mesh"], "inputs": ["inputs"], "output": ["-o", "--output"], "folder": ["-o", "--output"]}
BATCH = "inputs folder workers scheduler how method format memory trade holes bijective retry"
PICTURE = {"metavar": "OUT.png", "type": Path}
ARGUMENTS: dict[str, dict[str, Any]] = {
    "mesh": {"metavar": "MESH", "type": Path, "help": "OBJ, OFF, PLY or STL file"},
    "output": {
        "metavar": "OUT",
        "type": Path,
        "required": True,
        "help": "OBJ file to write; unwrap also writes PLY and GLB",
    },
    "inputs": {"metavar": "IN", "nargs": "+", "help": "mesh files, folders of them, globs in quotes, URLs"},
    "folder": {
        "metavar": "OUT",
        "required": True,
        "help": "folder of the maps and of results.csv; a batch that was stopped goes on there",
    },
    "workers": {"metavar": "N", "type": int, "help": "processes on this machine (default: one a core)"},
    "scheduler": {"metavar": "ADDRESS", "help": "use the workers of this Dask scheduler instead"},
    "how": {
        "choices": ("unwrap", "flatten"),
        "default": "unwrap",
        "help": "with seams, or disks as they are (default: %(default)s)",
    },
    "format": {"choices": [suffix[1:] for suffix in SUFFIXES], "default": "obj", "help": "of the maps"},
    "memory": {"metavar": "SIZE", "help": "what one mesh may take, like 2GiB"},
    "retry": {"action": "store_true", "help": "do again what died, ran out of memory or failed before"},
    "picture": {**PICTURE, "help": "checkerboard picture to write"},
    "screenshot": {**PICTURE, "help": "write a picture instead of opening a window"},
    "method": {"choices": sorted(METHODS), "default": "linabf"},
    "methods": {
        "default": "lscm,linabf,abf",
        "help": f"some of {', '.join(METHODS)}, separated by commas (default: %(default)s)",
    },
    "repeat": {"metavar": "N", "type": int, "default": 3, "help": "timed runs of each method (default: 3)"},
    "iterations": {"metavar": "N", "default": "auto", "help": "number of iterations, or auto"},
    "layout": {"choices": ("auto", "boundary", "least-squares", "greedy"), "default": "auto"},
    "outer": {"metavar": "VERTEX", "type": int, "help": "a vertex of the outer boundary loop"},
    "solver": {"choices": ("auto", "cholmod", "multigrid", "direct"), "default": "auto"},
    "guarantee": {
        "choices": ("injective",),
        "help": "if triangles flip, run a last stage that leaves none flipped",
    },
    "units": {
        "choices": ("square", "mesh"),
        "default": "square",
        "help": "scale of the texture coordinates: the unit square, or the mesh's units of length",
    },
    "seams": {
        "default": "auto",
        "help": "auto, uv (seams of the OBJ's texture coordinates), or a text file of vertex pairs, from 0",
    },
    "trade": {
        "type": float,
        "default": TRADE,
        "help": "larger: longer seams for less stretch; 0: shortest seams (default: %(default)s)",
    },
    "holes": {"action": "store_true", "help": "leave holes uncut"},
    "bijective": {"action": "store_true", "help": "move overlapping parts apart instead of splitting charts"},
    "complete": {"action": "store_true", "help": "find the seams that the given ones leave missing"},
    "max-stretch": {
        "type": float,
        "metavar": "L2",
        "help": "cut charts until their L2 stretch is at most this",
    },
    "weld": {
        "type": float,
        "metavar": "DISTANCE",
        "help": "make vertices one that are this near; 0: those in one place (as is done for triangle soups)",
    },
    "strict": {"action": "store_true", "help": "refuse a mesh that is no clean manifold, do not repair it"},
    "measure": {"choices": MEASURES, "help": "distortion to show instead of the checkerboard"},
    "frequency": {
        "metavar": "N",
        "type": float,
        "default": 30.0,
        "help": "checkerboard squares along the map",
    },
}


class Completion(argparse.Action):
    """Prints what makes the TAB key of a shell complete this command, and paths for the arguments `files`."""

    def __init__(self, *args: Any, files: Sequence[argparse.Action], **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.files = files

    def __call__(self, parser: argparse.ArgumentParser, *rest: Any) -> NoReturn:
        import shtab

        for argument in self.files:
            argument.complete = shtab.FILE  # type: ignore[attr-defined]
        print(shtab.complete(parser, shell=rest[1]))
        parser.exit()


class Parser(argparse.ArgumentParser):
    """Reports errors in one line, like all errors of the command."""

    def error(self, message: str) -> NoReturn:
        self.exit(ERROR, f"igl-linabf: {message} (see {self.prog} --help)\n")


def main(arguments: Sequence[str] | None = None, *, settled: Callable[[], object] = lambda: None) -> int:
    """Run the command; returns 0, 1 for a map with flipped triangles, 2 for an error.

    `settled` is called after everything is printed and written, before the files are renamed to
    their final names.
    """
    options = _parser().parse_args(arguments)
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


def _parser() -> Parser:
    files: list[argparse.Action] = []
    parser = Parser(prog="igl-linabf", description="Linear angle based parameterization of triangle meshes.")
    parser.add_argument("--version", action="version", version=f"igl-linabf {_version('igl-linabf')}")
    parser.add_argument(
        "--print-completion",
        action=Completion,
        choices=SHELLS,
        files=files,
        help="print a script with which the shell completes options and files at TAB, and exit",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for run, names, line, description in (
        (
            _flatten,
            "mesh output picture method iterations layout outer solver guarantee units",
            "flatten a disk, with or without holes; write it with texture coordinates, print the quality",
            "Flatten a disk, with or without holes. Exit code 1: written, but with flipped triangles.",
        ),
        (
            _compare,
            "mesh methods picture repeat",
            "flatten a mesh by several methods, and print their quality and time side by side",
            "Compare methods on a disk, with or without holes: distortion, flips, time relative to igl.lscm.",
        ),
        (
            _unwrap,
            "mesh output picture seams complete trade max-stretch holes bijective weld strict method",
            "cut any surface into charts, flatten them without overlaps, pack them, and write the atlas",
            "Unwrap any triangles. Exit code 1: written, but with flips, overlaps, or stretch beyond use.",
        ),
        (
            _view,
            "mesh method measure frequency screenshot",
            "open a window with the surface and its flat map side by side",
            "Show any surface beside its flat map. In the window, h lists the keys.",
        ),
        (
            _batch,
            BATCH,
            "unwrap many files on all cores or a cluster; started again, go on",
            "Unwrap many files, with Dask. Exit code 1: done, but not every mesh has a map without flips and "
            "overlaps; results.csv says which and why.",
        ),
        (_doctor, "", "print what is installed and what the solvers use", None),
    ):
        command = commands.add_parser(run.__name__[1:], help=line, description=description)
        command.set_defaults(run=run)
        for name in names.split():
            flags = FLAGS.get(name, [f"--{name}"])
            argument = command.add_argument(*flags, **ARGUMENTS[name])
            if argument.type is Path or name == "seams":
                files.append(argument)
    return parser


def _check_outputs(mesh: Path | None, png: Path | None, suffixes: Sequence[str] = (".obj",)) -> None:
    """Check before the computation that its results can be written."""
    for path, known in ((mesh, suffixes), (png, (".png",))):
        if path is None:
            continue
        if path.suffix.lower() not in known:
            raise ValueError(f"{path} does not end in {' or '.join(known)}: give a file name that does")
        if not os.access(path.parent, os.W_OK):
            raise OSError(None, "the folder is missing or cannot be written to", str(path.parent))
    if png is not None:
        from . import plot  # noqa: F401  # says how to get pyvista where it is missing


def _hand_out(
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
            from .plot import plot_compare

            path = stack.enter_context(replacing(options.picture))
            plot_compare(*pictured, off_screen=True, screenshot=path).close()
        try:
            print(text, flush=True)
        except OSError as error:
            raise OSError(error.errno, error.strerror, "standard output") from None
        options.settled()


def _compare(options: argparse.Namespace) -> int:
    methods = [method.strip() for method in options.methods.split(",")]
    _check_outputs(None, options.picture)
    V, F = read_mesh(options.mesh)
    comparison = compare(V, F, methods, repeat=options.repeat)
    _hand_out(options, str(comparison), (V, F, comparison.maps))
    return GOOD


def _unwrap(options: argparse.Namespace) -> int:
    _check_outputs(options.output, options.picture, SUFFIXES)
    V, F = read_mesh(options.mesh)
    seams = None
    if options.seams == "uv":
        seams = texture_seams(F, read_texture(options.mesh)[1])
    elif options.seams != "auto":
        seams = _pairs(options.seams)
    names = ("trade", "holes", "bijective", "max_stretch", "complete", "weld", "strict")
    settings = {name: getattr(options, name) for name in names}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OutcomeWarning)  # what is wrong is said below
        atlas = unwrap(V, F, seams, options.method, **settings)
    pictured = V[atlas.origin], atlas.FTC, {options.method: atlas.TC}
    _hand_out(options, str(atlas), pictured, partial(write_mesh, V=V, F=F, TC=atlas.TC, FTC=atlas.FTC))
    for message in atlas.troubles:
        print(f"igl-linabf: {message}", file=sys.stderr)
    return GOOD if atlas.good else NOT_VALID


def _view(options: argparse.Namespace) -> int:
    _check_outputs(None, options.screenshot)
    from .plot import view

    V, F = read_mesh(options.mesh)
    settings = {"measure": options.measure, "frequency": options.frequency}
    if options.screenshot is None:
        view(V, F, options.method, title=f"igl_linabf: {options.mesh.name}", **settings)
    else:
        with replacing(options.screenshot) as temporary:
            view(V, F, options.method, off_screen=True, screenshot=temporary, **settings)
            options.settled()
    return GOOD


def _pairs(path: str) -> IntArray:
    """The vertex pairs in a text file."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numpy's, of an empty file: no seams
        try:
            pairs = np.loadtxt(path, dtype=np.int64, ndmin=2)
        except ValueError:
            raise MeshError(f"{path} is no table of integers: write two vertices on each line") from None
    return pairs.reshape(-1, 2) if pairs.size == 0 else pairs


def _flatten(options: argparse.Namespace) -> int:
    _check_outputs(options.output, options.picture)
    asked = {name: getattr(options, name) for name in ("layout", "solver", "guarantee")}
    asked["iterations"] = _iterations(options.iterations)
    chosen = METHODS[options.method]
    known = {field.name for field in fields(chosen)}  # type: ignore[arg-type]
    for name, value in asked.items():
        if name not in known and value not in ("auto", None):
            raise ValueError(f"--{name} means nothing to the method {options.method}: leave it out")
    method = chosen(**{name: value for name, value in asked.items() if name in known})
    V, F = read_mesh(options.mesh)
    result = flatten(V, F, method, outer=options.outer)
    uv = unit_square(result.uv) if options.units == "square" else result.uv
    measured = quality(V, F, uv)
    pictured = V, F, {options.method: result.uv}
    _hand_out(options, f"{measured}\n\n{result}", pictured, partial(write_obj, V=V, F=F, uv=uv))
    if not result.outcome.good:
        print(f"igl-linabf: {result.message}", file=sys.stderr)
        return NOT_VALID
    if measured.flips > len(result.flipped):
        print(
            f"igl-linabf: {measured.flips} triangles flip by rounding when the map is scaled to the unit "
            "square: its scale varies too much; use --units mesh, or unwrap the mesh",
            file=sys.stderr,
        )
        return NOT_VALID
    return GOOD


def _iterations(text: str) -> int | str:
    try:
        return text if text == "auto" else int(text)
    except ValueError:
        raise ValueError(f"--iterations is {text!r}: use 'auto' or a positive integer") from None


def _batch(options: argparse.Namespace) -> int:
    chosen = {name: getattr(options, name) for name in BATCH.split() if name not in ("inputs", "folder")}
    done = batch(options.inputs, options.output, **chosen)
    print(done, flush=True)
    options.settled()
    return GOOD if done.good else NOT_VALID


def _doctor(options: argparse.Namespace) -> int:
    print(f"igl-linabf {_version('igl-linabf')}, Python {platform.python_version()}, {platform.platform()}")
    for name in ("libigl", "numpy", "scipy", "pyamg", "scikit-sparse", "pyvista"):
        print(f"  {name} {_version(name)}")
    if has_cholmod():
        print(f"CHOLMOD: yes, with {blas_of_cholmod() or 'an unknown BLAS'}")
    else:
        print(f"CHOLMOD: no; libigl's Cholesky and PyAMG's multigrid are used. To get it, {HOW_TO_GET}")
    if find_spec("pyvista") is None:
        print("Pictures: no; pip install 'igl-linabf[viz]'")
    return GOOD


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


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


if __name__ == "__main__":
    sys.exit(main())
