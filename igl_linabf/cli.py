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
from .charts import TRADE, texture_seams, unwrap
from .errors import MeshError, OutcomeWarning
from .flattening import METHODS, compare, flatten
from .io import SUFFIXES, read_mesh, read_texture, replacing, unit_square, write_mesh, write_obj
from .linalg import HOW_TO_GET, blas_of_cholmod, has_cholmod
from .measures import MEASURES, quality

GOOD, NOT_VALID, ERROR = 0, 1, 2
PICTURE = {"metavar": "OUT.png", "type": Path}
ARGUMENTS: dict[str, dict[str, Any]] = {
    "mesh": {"metavar": "MESH", "type": Path, "help": "OBJ, OFF, PLY or STL file"},
    "output": {
        "metavar": "OUT",
        "type": Path,
        "required": True,
        "help": "OBJ to write; of unwrap, PLY or GLB, too",
    },
    "picture": {**PICTURE, "help": "checkerboard picture to write"},
    "screenshot": {**PICTURE, "help": "write a picture, open no window"},
    "method": {"choices": sorted(METHODS), "default": "linabf"},
    "methods": {
        "default": "lscm,linabf,abf",
        "help": f"some of {', '.join(METHODS)}, with commas between (default: %(default)s)",
    },
    "repeat": {"metavar": "N", "type": int, "default": 3, "help": "timed runs of each (default: 3)"},
    "iterations": {"metavar": "N", "default": "auto", "help": "number of iterations, or auto"},
    "layout": {"choices": ("auto", "boundary", "least-squares", "greedy"), "default": "auto"},
    "outer": {"metavar": "VERTEX", "type": int, "help": "a vertex of the outer boundary loop"},
    "solver": {"choices": ("auto", "cholmod", "multigrid", "direct"), "default": "auto"},
    "guarantee": {
        "choices": ("injective",),
        "help": "a last step where triangles are flipped, without flips",
    },
    "units": {
        "choices": ("square", "mesh"),
        "default": "square",
        "help": "scale of the texture coordinates: into the unit square, or in the mesh's units of length",
    },
    "seams": {
        "default": "auto",
        "help": "auto, uv (those of the OBJ's texture coordinates), or a text file of vertex pairs from 0 on",
    },
    "trade": {"type": float, "default": TRADE, "help": "seam length against distortion: 0 short"},
    "holes": {"action": "store_true", "help": "leave holes uncut"},
    "bijective": {"action": "store_true", "help": "move overlaps apart instead of splitting"},
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
    "frequency": {"metavar": "N", "type": float, "default": 30.0, "help": "squares of the board"},
}


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, as all errors of the command are."""

    def error(self, message: str) -> NoReturn:
        self.exit(ERROR, f"igl-linabf: {message} (see {self.prog} --help)\n")


def main(arguments: Sequence[str] | None = None, *, settled: Callable[[], object] = lambda: None) -> int:
    """Run the command; returns 0, 1 for a map with flipped triangles, 2 for an error.

    `settled` is called when all is printed and written, before the files take their places.
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
            said = f"{options.mesh}: not enough memory: take a smaller mesh"
        except (MeshError, ImportError, ValueError) as error:
            said = str(error)
        print(f"igl-linabf: {said}", file=sys.stderr)
        return ERROR


def _give_up_stdout() -> None:
    """Where nothing more can be printed, do not try it again at the end of the process."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _parser() -> Parser:
    parser = Parser(prog="igl-linabf", description="Linear angle based parameterization of triangle meshes.")
    parser.add_argument("--version", action="version", version=metadata.version("igl-linabf"))
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for run, names, line, description in (
        (
            _flatten,
            "mesh output picture method iterations layout outer solver guarantee units",
            "flatten a disk or one with holes, write it with texture coordinates, print the map's quality",
            "Flatten a disk, or one with holes. Exit code 1: written, but with flipped triangles.",
        ),
        (
            _compare,
            "mesh methods picture repeat",
            "flatten it by several methods, and print their quality and time side by side",
            "Compare methods on a disk, or one with holes: distortion, flips, time over igl.lscm's.",
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
        (_doctor, "", "print what is installed and what the solvers use", None),
    ):
        command = commands.add_parser(run.__name__[1:], help=line, description=description)
        command.set_defaults(run=run)
        for name in names.split():
            flags = {"mesh": ["mesh"], "output": ["-o", "--output"]}.get(name, [f"--{name}"])
            command.add_argument(*flags, **ARGUMENTS[name])
    return parser


def _check_outputs(mesh: Path | None, png: Path | None, suffixes: Sequence[str] = (".obj",)) -> None:
    """Find out before the work whether its results can be written."""
    for path, known in ((mesh, suffixes), (png, (".png",))):
        if path is None:
            continue
        if path.suffix.lower() not in known:
            raise ValueError(f"{path} does not end in {' or '.join(known)}: give the name of such a file")
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
    """Write all files beside their places, print the text, and only then put the files there."""
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
            raise MeshError(f"{path} is no table of integers: write two vertices in each line") from None
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
            f"igl-linabf: brought into the unit square, {measured.flips} triangles are flipped by rounding: "
            "the map's scale varies too much; keep it with --units mesh, or unwrap the mesh",
            file=sys.stderr,
        )
        return NOT_VALID
    return GOOD


def _iterations(text: str) -> int | str:
    try:
        return text if text == "auto" else int(text)
    except ValueError:
        raise ValueError(f"--iterations is {text!r}: use 'auto' or an integer from 1 on") from None


def _doctor(options: argparse.Namespace) -> int:
    print(f"igl-linabf {metadata.version('igl-linabf')}, Python {platform.python_version()}")
    for name in ("libigl", "numpy", "scipy", "pyamg", "scikit-sparse", "pyvista"):
        try:
            print(f"  {name} {metadata.version(name)}")
        except metadata.PackageNotFoundError:
            print(f"  {name} not installed")
    if has_cholmod():
        print(f"CHOLMOD: yes, with {blas_of_cholmod() or 'an unknown BLAS'}")
    else:
        print(f"CHOLMOD: no; PyAMG and SuperLU are used. To get it, {HOW_TO_GET}")
    if find_spec("pyvista") is None:
        print("Pictures: no; pip install 'igl-linabf[viz]'")
    return GOOD


@contextlib.contextmanager
def _warnings_in_a_line() -> Iterator[None]:
    """Warnings of the library as one line on stderr each."""

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
