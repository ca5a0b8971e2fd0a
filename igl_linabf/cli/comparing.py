"""`igl-linabf compare`."""

import argparse

from .._runtime import progress_part
from ..flattening import METHODS, compare
from .arguments import shared, value
from .commands import Command, ExitCode
from .jobs import PROGRESS, given_mesh
from .outputs import check_outputs, hand_out


def _compare(options: argparse.Namespace) -> int:
    methods = [method.strip() for method in options.methods.split(",")]
    check_outputs(None, options.picture)
    mesh = given_mesh(options)
    V, F = mesh.V, mesh.triangles
    shape = {"boundary": options.boundary, "corners": options.corners}
    with progress_part("comparing", PROGRESS["computing"]):
        comparison = compare(V, F, methods, repeat=options.repeat, **shape)
    hand_out(options, str(comparison), {"comparison": comparison}, (V, F, comparison.maps))
    return ExitCode.GOOD


COMPARE = Command(
    "compare",
    _compare,
    "flatten a mesh by several methods, and print their quality and time side by side",
    {
        **shared("mesh"),
        "methods": value(
            "METHODS", f"some of {', '.join(METHODS)}, separated by commas", default="lscm,linabf,abf"
        ),
        **shared("boundary", "corners", "picture"),
        "repeat": value("N", "timed runs of each", int, 3),
        **shared("force", "json", "quiet"),
    },
    "Compare methods on a disk, with or without holes: distortion, flips, time relative to igl.lscm.",
    (
        "camelhead.off --methods lscm,linabf,abf --repeat 11",
        "camelhead.off --picture side_by_side.png --quiet --force    # also if it is there already",
        "camelhead.off --methods linabf,abf --boundary circle",
        "face.obj --boundary rectangle --corners 12 3 840 77",
        "'heads/*.off' --json > figures.jsonl    # one line a mesh",
    ),
    each=True,
)
