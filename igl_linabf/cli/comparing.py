"""The command `igl-linabf compare`."""

import argparse

from .._runtime import progress_part
from ..flattening import METHODS, compare
from .arguments import shared_arguments, value
from .commands import Command, ExitCode
from .jobs import PROGRESS, read_given_mesh
from .outputs import check_outputs, write_outputs


def _compare(options: argparse.Namespace) -> int:
    methods = [method.strip() for method in options.methods.split(",")]
    check_outputs(None, options.picture)
    mesh = read_given_mesh(options)
    V, F = mesh.V, mesh.triangles
    shape = {"boundary": options.boundary, "corners": options.corners}
    with progress_part("comparing", PROGRESS["computing"]):
        comparison = compare(V, F, methods, repeat=options.repeat, **shape)
    write_outputs(options, str(comparison), {"comparison": comparison}, (V, F, comparison.maps))
    return ExitCode.GOOD


COMPARE = Command(
    "compare",
    _compare,
    "flatten a mesh by several methods, and print their quality and time side by side",
    {
        **shared_arguments("mesh"),
        "methods": value(
            "METHODS", f"some of {', '.join(METHODS)}, separated by commas", default="lscm,linabf,abf"
        ),
        **shared_arguments("boundary", "corners", "picture"),
        "repeat": value("N", "number of timed runs of each method", int, 3),
        **shared_arguments("force", "json", "quiet"),
    },
    "Compare methods on a disk, with or without holes: distortion, flips, time relative to igl.lscm.",
    (
        "camelhead.off --methods lscm,linabf,abf --repeat 11",
        "camelhead.off --picture side_by_side.png --quiet --force    # replaces an older picture",
        "camelhead.off --methods linabf,abf --boundary circle",
        "face.obj --boundary rectangle --corners 12 3 840 77",
        "'heads/*.off' --json > figures.jsonl    # one line per mesh",
    ),
    each=True,
)
