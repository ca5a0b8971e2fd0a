"""`igl-linabf unwrap`."""

from __future__ import annotations

import argparse
import sys
import warnings
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .._runtime import part
from .._types import IntArray
from ..charts import TRADE, texture_sides, unwrap
from ..errors import MeshError, OutcomeWarning
from ..io import SUFFIXES, written
from .baking import BAKE, RESOLUTION, baked, check_bake
from .commands import (
    GOOD,
    JSON,
    MESHES,
    METHOD,
    NOT_VALID,
    OUTPUT,
    PICTURE,
    QUIET,
    WEIGHT,
    Argument,
    Command,
    method_with,
)
from .jobs import COMPUTED, given_mesh
from .outputs import check_outputs, hand_out
from .packing import NAMES, PACKING

TRADED: Argument = {
    "type": float,
    "default": TRADE,
    "help": "larger: longer seams for less stretch; 0: shortest seams (default: %(default)s)",
}
HOLES: Argument = {"action": "store_true", "help": "leave holes uncut"}
BAKED = 0.9  # of the whole: the bar when the texture is baked
BIJECTIVE: Argument = {
    "action": "store_true",
    "help": "move overlapping parts apart instead of splitting charts",
}


def _unwrap(options: argparse.Namespace) -> int:
    check_outputs(options.output, options.picture, SUFFIXES)
    method = method_with(options.method, {"weight": options.weight})
    mesh = given_mesh(options)
    check_bake(options.bake, mesh, options.output, options.pages)
    if options.bake and options.resolution is None:
        options.resolution = RESOLUTION
    V, F = mesh.V, mesh.F
    seams: Any = None
    if options.seams == "uv":
        if mesh.TC is None or mesh.FTC is None:
            raise MeshError(
                f"{options.mesh} has no texture coordinates at all corners: it has no seams of them"
            )
        seams = texture_sides(V, F, mesh.TC, mesh.FTC)
    elif options.seams != "auto":
        seams = _pairs(options.seams)
    cones = options.cones
    if cones is not None and cones != "auto":
        cones = int(cones) if cones.isdecimal() else _vertices(cones)
    angles = options.cone_angles
    if angles is not None and angles != "quarter":
        angles = np.deg2rad(
            _table(angles, np.float64, "numbers: write one angle in degrees on each line").ravel()
        )
    names = ("trade", "holes", "bijective", "max_stretch", "complete", "hide", "weld", "strict", "period")
    settings = {name: getattr(options, name) for name in (*names, *NAMES)}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OutcomeWarning)  # what is wrong is said below
        with part("unwrapping", COMPUTED):
            atlas = unwrap(V, F, seams, method, cones=cones, cone_angles=angles, **settings)
    pictured = V[atlas.origin], atlas.triangles, {options.method: atlas.TC}
    figures = {"good": atlas.good, "troubles": atlas.troubles, "atlas": atlas}
    with part("baking", BAKED):
        image = baked(options.bake, mesh, atlas, options.resolution) if options.bake else None
    write = partial(written, mesh=mesh, TC=atlas.TC, FTC=atlas.FTC, image=image)
    hand_out(options, str(atlas), figures, pictured, write)
    for message in atlas.troubles:
        print(f"igl-linabf: {options.of}{message}", file=sys.stderr)
    return GOOD if atlas.good else NOT_VALID


def _pairs(path: str) -> IntArray:
    """The vertex pairs in a text file."""
    pairs: IntArray = _table(path, np.int64, "integers: write two vertices on each line")
    return pairs.reshape(-1, 2) if pairs.size == 0 else pairs


def direction(text: str) -> list[float]:
    """Three numbers with commas between."""
    numbers = [float(number) for number in text.split(",")]
    if len(numbers) != 3:
        raise argparse.ArgumentTypeError(f"{text!r} is no direction: give three numbers, as --hide=0,-1,0")
    return numbers


def _vertices(path: str) -> IntArray:
    """The vertices in a text file."""
    return np.asarray(_table(path, np.int64, "integers: write one vertex on each line").ravel())


def _table(path: str, kind: type, what: str) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numpy's, of an empty file
        try:
            return np.loadtxt(path, dtype=kind, ndmin=2)
        except ValueError:
            raise MeshError(f"{path} is no table of {what}") from None


UNWRAP = Command(
    "unwrap",
    _unwrap,
    "cut any surface into charts, flatten them without overlaps, pack them, and write the atlas",
    {
        "mesh": MESHES,
        "output": {
            "metavar": "OUT",
            "type": Path,
            "required": True,
            "help": OUTPUT,
        },
        "format": {
            "choices": [suffix[1:] for suffix in SUFFIXES],
            "default": "obj",
            "help": "of files in a folder and of standard output (default: %(default)s)",
        },
        "picture": PICTURE,
        "seams": {
            "default": "auto",
            "help": "auto, uv (seams of the file's texture coordinates), or a file of vertex pairs from 0",
        },
        "cones": {
            "metavar": "N",
            "help": "leave the curvature at so many vertices, at auto (as many as pay), or at those in a "
            "file, from 0: both sides of the seams through them match",
        },
        "cone-angles": {
            "metavar": "ANGLES",
            "help": "quarter (turns), or a file of their angle sums in degrees (default: of one scale)",
        },
        "period": {
            "type": float,
            "metavar": "SHARE",
            "help": "of a texture, as a share of the page's side: it goes on across seams of quarter turns",
        },
        "complete": {"action": "store_true", "help": "find the seams that the given ones leave missing"},
        "trade": TRADED,
        "max-stretch": {
            "type": float,
            "metavar": "L2",
            "help": "cut charts until their L2 stretch is at most this",
        },
        "hide": {
            "type": direction,
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
        **PACKING,
        "bake": BAKE,
        "method": METHOD,
        "json": JSON,
        "quiet": QUIET,
        "weight": WEIGHT,
    },
    "Unwrap any triangles. Exit code 1: written, but with flips, overlaps, or stretch beyond use.",
    (
        "bunny.obj -o bunny.glb --picture bunny.png",
        "bunny.obj -o bunny.glb --method isometric --weight 1.5    # even texels",
        "bunny.obj -o bunny.obj --trade 30 --max-stretch 1.2    # longer seams, less stretch",
        "bunny.obj -o bunny.obj --seams uv --method abf    # along the seams that the file has",
        "bunny.obj -o bunny.obj --seams pairs.txt --complete    # along the edges of pairs.txt, and more",
        "body.obj -o body.obj --hide 0,0,-1    # seams at the back",
        "body.obj -o body.obj --cones auto --cone-angles quarter    # both sides of each seam match",
        "body.obj -o body.obj --cones auto --cone-angles quarter --period 0.02    # 50 repeats go on",
        "body.obj -o body.obj --resolution 2048 --padding 8    # for a texture of this size",
        "body.obj -o body.obj --resolution 2048 --texel-density 400 --pages 4    # on up to four pages",
        "body.ply -o body.glb --bake colors    # with the texture in it",
        "body.ply -o body.obj --bake colors    # with body.mtl and body.png beside it",
        "scan.stl -o scan.ply --weld 1e-5 --holes",
        "part.obj -o part.obj --strict --bijective",
        "body.obj -o body.glb --resolution 1024 --padding 4 --bake normals",
        "city.obj -o city.obj --resolution 2048 --texel-density 64 --pages 4    # as UDIM tiles",
        "'scans/*.stl' -o maps/ --format glb --json > figures.jsonl    # one line a mesh",
        "- -o - --quiet < bunny.obj > atlas.obj",
    ),
    each=True,
)
