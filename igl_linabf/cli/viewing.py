"""The command `igl-linabf view`."""

import argparse
from pathlib import Path

from ..io import check_free, read_mesh, replacing
from ..measures import MEASURES
from .arguments import choice, shared_arguments, value
from .commands import Command, ExitCode, parse_auto_or_number
from .outputs import check_outputs


def _view(options: argparse.Namespace) -> int:
    check_outputs(None, options.screenshot)
    check_free([options.screenshot] if options.screenshot else [], options.force)
    from ..plot import view

    V, F = read_mesh(options.mesh)
    settings = {"measure": options.measure, "frequency": options.frequency, "boundary": options.boundary}
    settings["cones"] = parse_auto_or_number("cones", options.cones)
    if options.screenshot is None:
        settings["save_as"] = options.mesh.stem  # in the current folder
        view(V, F, options.method, title=f"igl_linabf: {options.mesh.name}", **settings)
    else:
        with replacing(options.screenshot) as temporary:
            view(V, F, options.method, off_screen=True, screenshot=temporary, **settings)
            options.on_commit()
    return ExitCode.GOOD


VIEW = Command(
    "view",
    _view,
    "open a window with the surface and its flat map side by side",
    {
        "mesh": value("MESH", "OBJ, OFF, PLY, STL, GLB, glTF, 3MF, GIFTI, FreeSurfer or VTP file", Path),
        **shared_arguments("method", "boundary", "cones"),
        "measure": choice(MEASURES, help="distortion to show instead of the checkerboard"),
        "frequency": value("N", "checkerboard squares along the map", float, 30.0),
        "screenshot": value("OUT.png", "write a picture instead of opening a window", Path),
        **shared_arguments("force"),
    },
    "Show any surface beside its flat map. In the window, h lists the keys.",
    (
        "bunny.obj",
        "bunny.obj --method abf --frequency 60",
        "face.obj --boundary circle",
        "bunny.obj --cones auto    # the cones as spheres, both sides of a seam in one colour",
        "bunny.obj --measure area --screenshot bunny.png    # opens no window",
        "bunny.obj --screenshot bunny.png --force    # replaces an older one",
    ),
)
