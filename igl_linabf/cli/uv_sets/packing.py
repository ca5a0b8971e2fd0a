"""The command `igl-linabf pack`."""

import argparse
from functools import partial

from ..._runtime import progress_part
from ...charts import Packing
from ...io import SUFFIXES
from ...uv import SCALES, pack
from ..arguments import choice, format_argument, shared_arguments, switch, value
from ..commands import Command, ExitCode, build_from_options
from ..jobs import PROGRESS
from ..outputs import check_outputs, make_writer, write_outputs
from .checking import read_mesh_with_coordinates


def _pack(options: argparse.Namespace) -> int:
    check_outputs(options.output, None, SUFFIXES)
    packing = build_from_options(Packing, options)
    mesh, TC, FTC = read_mesh_with_coordinates(options)
    asked = {"rotate": not options.no_rotate, "scale": options.scale}
    with progress_part("packing", PROGRESS["computing"]):
        packed = pack(mesh.V, mesh.F, TC, FTC, packing, **asked)
    write = partial(make_writer(options), mesh=mesh, TC=packed.TC, FTC=packed.FTC)
    write_outputs(options, str(packed), {"packed": packed}, write=write)
    return ExitCode.GOOD


PACK = Command(
    "pack",
    _pack,
    "repack the charts of a mesh's texture coordinates",
    {
        **shared_arguments("mesh", "output"),
        "format": format_argument(SUFFIXES, "obj"),
        **shared_arguments("resolution", "padding"),
        "texel-density": value("TEXELS", "texels per unit of length (default: fill the pages)", float),
        "pages": value("N", "number of pages, as UDIM tiles (default: 1, or as many as needed)", int),
        **shared_arguments("unseen"),
        "no-rotate": switch("move and scale charts, but do not rotate them"),
        "scale": choice(
            SCALES, "keep", "keep: relative sizes of the charts; even: the same texel density on all"
        ),
        **shared_arguments("force", "json", "quiet"),
    },
    "Repack charts without changing their shapes. Stacked charts stay stacked.",
    (
        "body.obj -o body_2k.obj --resolution 2048 --padding 8",
        "table.glb -o even.glb --scale even --no-rotate    # wood grain stays upright",
        "body.obj -o body.obj --texel-density 200 --resolution 1024 --pages 4 --quiet",
        "scan.glb -o scan_2k.glb --scale even --unseen 0.25    # fewer texels for cavities",
        "body.obj -o there/body.obj --force    # replaces there/body.mtl",
        "wall.glb -o wall.glb --resolution 2048x1024    # pages that are not square",
        "'props/*.obj' -o packed/ --format glb --json > figures.jsonl    # one line per mesh",
    ),
    each=True,
)
