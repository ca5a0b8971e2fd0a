"""`igl-linabf pack`."""

import argparse
from functools import partial

from ..._runtime import progress_part
from ...charts import Packing
from ...io import SUFFIXES
from ...uv_sets import SCALES, pack
from ..arguments import choice, format_of, shared, switch, value
from ..commands import Command, ExitCode, options_as
from ..jobs import PROGRESS
from ..outputs import check_outputs, hand_out, written_from
from .checking import mesh_with_coordinates


def _pack(options: argparse.Namespace) -> int:
    check_outputs(options.output, None, SUFFIXES)
    packing = options_as(Packing, options)
    mesh, TC, FTC = mesh_with_coordinates(options)
    asked = {"rotate": not options.no_rotate, "scale": options.scale}
    with progress_part("packing", PROGRESS["computing"]):
        packed = pack(mesh.V, mesh.F, TC, FTC, packing, **asked)
    write = partial(written_from(options), mesh=mesh, TC=packed.TC, FTC=packed.FTC)
    hand_out(options, str(packed), {"packed": packed}, write=write)
    return ExitCode.GOOD


PACK = Command(
    "pack",
    _pack,
    "pack the charts of the texture coordinates that a mesh has anew",
    {
        **shared("mesh", "output"),
        "format": format_of(SUFFIXES, "obj"),
        **shared("resolution", "padding"),
        "texel-density": value(
            "TEXELS", "texels per unit of length (default: as many as the pages hold)", float
        ),
        "pages": value("N", "pages, as UDIM tiles (default: 1, or what it takes)", int),
        **shared("unseen"),
        "no-rotate": switch("move and scale charts, do not turn them"),
        "scale": choice(SCALES, "keep", "the charts' sizes relative to each other, or even texels on all"),
        **shared("force", "json", "quiet"),
    },
    "Pack charts anew, without changing their shapes. Charts that lie on each other stay so.",
    (
        "body.obj -o body_2k.obj --resolution 2048 --padding 8",
        "table.glb -o even.glb --scale even --no-rotate    # wood grain stays upright",
        "body.obj -o body.obj --texel-density 200 --resolution 1024 --pages 4 --quiet",
        "scan.glb -o scan_2k.glb --scale even --unseen 0.25    # fewer texels for cavities",
        "body.obj -o there/body.obj --force    # also where there/body.mtl is there already",
        "wall.glb -o wall.glb --resolution 2048x1024    # pages that are not square",
        "'props/*.obj' -o packed/ --format glb --json > figures.jsonl    # one line a mesh",
    ),
    each=True,
)
