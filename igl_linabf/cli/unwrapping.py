"""`igl-linabf unwrap`."""

from __future__ import annotations

import argparse
import sys
import warnings
from functools import partial
from pathlib import Path

import numpy as np

from .._types import BoolArray, IntArray
from ..charts import TRADE, texture_sides, unwrap
from ..errors import MeshError, OutcomeWarning
from ..io import SUFFIXES, read_mesh, read_texture, write_mesh
from .commands import GOOD, MESH, METHOD, NOT_VALID, PICTURE, Argument, Command
from .outputs import check_outputs, hand_out

TRADED: Argument = {
    "type": float,
    "default": TRADE,
    "help": "larger: longer seams for less stretch; 0: shortest seams (default: %(default)s)",
}
HOLES: Argument = {"action": "store_true", "help": "leave holes uncut"}
BIJECTIVE: Argument = {
    "action": "store_true",
    "help": "move overlapping parts apart instead of splitting charts",
}


def _unwrap(options: argparse.Namespace) -> int:
    check_outputs(options.output, options.picture, SUFFIXES)
    V, F = read_mesh(options.mesh)
    seams: IntArray | BoolArray | None = None
    if options.seams == "uv":
        seams = texture_sides(V, F, *read_texture(options.mesh))
    elif options.seams != "auto":
        seams = _pairs(options.seams)
    names = ("trade", "holes", "bijective", "max_stretch", "complete", "hide", "weld", "strict")
    settings = {name: getattr(options, name) for name in names}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OutcomeWarning)  # what is wrong is said below
        atlas = unwrap(V, F, seams, options.method, **settings)
    pictured = V[atlas.origin], atlas.FTC, {options.method: atlas.TC}
    hand_out(options, str(atlas), pictured, partial(write_mesh, V=V, F=F, TC=atlas.TC, FTC=atlas.FTC))
    for message in atlas.troubles:
        print(f"igl-linabf: {message}", file=sys.stderr)
    return GOOD if atlas.good else NOT_VALID


def _pairs(path: str) -> IntArray:
    """The vertex pairs in a text file."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numpy's, of an empty file: no seams
        try:
            pairs = np.loadtxt(path, dtype=np.int64, ndmin=2)
        except ValueError:
            raise MeshError(f"{path} is no table of integers: write two vertices on each line") from None
    return pairs.reshape(-1, 2) if pairs.size == 0 else pairs


def _direction(text: str) -> list[float]:
    """Three numbers with commas between."""
    numbers = [float(number) for number in text.split(",")]
    if len(numbers) != 3:
        raise argparse.ArgumentTypeError(f"{text!r} is no direction: give three numbers, as --hide=0,-1,0")
    return numbers


UNWRAP = Command(
    "unwrap",
    _unwrap,
    "cut any surface into charts, flatten them without overlaps, pack them, and write the atlas",
    {
        "mesh": MESH,
        "output": {
            "metavar": "OUT",
            "type": Path,
            "required": True,
            "help": "OBJ, PLY or GLB file to write",
        },
        "picture": PICTURE,
        "seams": {
            "default": "auto",
            "help": "auto, uv (seams of the OBJ's texture coordinates), or a file of vertex pairs from 0",
        },
        "complete": {"action": "store_true", "help": "find the seams that the given ones leave missing"},
        "trade": TRADED,
        "max-stretch": {
            "type": float,
            "metavar": "L2",
            "help": "cut charts until their L2 stretch is at most this",
        },
        "hide": {
            "type": _direction,
            "metavar": "X,Y,Z",
            "help": "where seams may lie: the direction in which the back or underside looks (--hide=0,-1,0)",
        },
        "holes": HOLES,
        "bijective": BIJECTIVE,
        "weld": {
            "type": float,
            "metavar": "DISTANCE",
            "help": "make vertices one that are this near; 0: those in one place (as is done for soups)",
        },
        "strict": {
            "action": "store_true",
            "help": "refuse a mesh that is no clean manifold, do not repair it",
        },
        "method": METHOD,
    },
    "Unwrap any triangles. Exit code 1: written, but with flips, overlaps, or stretch beyond use.",
)
