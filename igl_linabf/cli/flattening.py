"""`igl-linabf flatten`."""

import argparse
from functools import partial

from .._runtime import progress_part
from ..flattening import flatten
from ..io import SUFFIXES, lies_flat, unit_square
from ..measures import quality
from .arguments import axis, choice, shared, value
from .commands import Command, ExitCode, auto_or_number, method_with
from .jobs import PROGRESS, check_beside, given_mesh
from .outputs import check_outputs, hand_out, judged, written_from


def _flatten(options: argparse.Namespace) -> int:
    check_outputs(options.output, options.picture, SUFFIXES)
    asked = {name: getattr(options, name) for name in ("layout", "solver", "guarantee", "weight")}
    asked["iterations"] = auto_or_number("iterations", options.iterations)
    method = method_with(options.method, asked)
    mesh = given_mesh(options)
    check_beside(options, mesh)
    V, F = mesh.V, mesh.triangles
    shape = {name: getattr(options, name) for name in ("outer", "boundary", "corners", "up")}
    with progress_part("flattening", PROGRESS["computing"]):
        result = flatten(V, F, method, **shape)
        units = options.units or ("mesh" if lies_flat(options.output) else "square")
        uv = unit_square(result.uv) if units == "square" else result.uv
        measured = quality(V, F, uv)
    pictured = V, F, {options.method: result.uv}
    figures = {"quality": measured, "result": result}
    write = partial(written_from(options), mesh=mesh, TC=uv)
    hand_out(options, f"{measured}\n\n{result}", figures, pictured, write)
    if not result.outcome.good:
        return judged(options, False, [result.message])
    if measured.flips <= len(result.flipped):
        return ExitCode.GOOD
    message = (
        f"{measured.flips} triangles flip by rounding when the map is scaled to the unit square: its scale "
        "varies too much; use --units mesh, or unwrap the mesh"
    )
    return judged(options, False, [message])


FLATTEN = Command(
    "flatten",
    _flatten,
    "flatten a disk, with or without holes; write it with texture coordinates, print the quality",
    {
        **shared("mesh", "output", "picture", "method"),
        "iterations": value("N", "number of iterations, or auto", default="auto"),
        "layout": choice(("auto", "boundary", "least-squares", "greedy"), "auto"),
        "outer": value("VERTEX", "a vertex of the outer boundary loop", int),
        **shared("boundary", "corners"),
        "up": value("AXIS", "direction in space that points up in the map: z, --up=-z, or 0,1,1", axis),
        "solver": choice(("auto", "cholmod", "direct"), "auto"),
        "guarantee": choice(
            ("injective",), help="if triangles flip, run a last stage that leaves none flipped"
        ),
        **shared("weight"),
        **shared("units", "force", "json", "quiet"),
    },
    "Flatten a disk, with or without holes. Exit code 1: written, but with flipped triangles.",
    (
        "camelhead.off -o camelhead.obj --picture camelhead.png",
        "camelhead.off -o camelhead.obj --picture camelhead.png --force    # replaces an older picture, too",
        "camelhead.off -o camelhead.obj --method abf --units mesh",
        "camelhead.off -o camelhead.obj --method isometric --weight 3    # areas, too",
        "camelhead.off -o camelhead.obj --iterations 1 --layout least-squares --solver direct",
        "face.obj -o face.obj --boundary rectangle --corners 12 3 840 77    # found without --corners",
        "face.obj -o face.obj --up z    # the map of a head that stands, upright",
        "crown.obj -o flat.obj --outer 17 --guarantee injective    # vertex 17 is on the outer loop",
        "'heads/*.off' -o maps/ --json > figures.jsonl    # one line a mesh",
        "- -o - --quiet < head.obj > flat.obj",
    ),
    each=True,
)
