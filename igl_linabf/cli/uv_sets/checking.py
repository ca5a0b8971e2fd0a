"""`igl-linabf check`."""

import argparse
import warnings

from ..._runtime import progress_part
from ..._types import FloatArray
from ...errors import MeshError, MeshWarning, stack_level
from ...io import MeshFile, moves_textures
from ...surface import Faces
from ...uv_sets import check_uv
from ..arguments import shared, value
from ..commands import Command
from ..jobs import PROGRESS, given_mesh
from ..outputs import hand_out, judged

LIMITS = ("max_stretch", "max_spread", "min_margin")


def _check(options: argparse.Namespace) -> int:
    mesh, TC, FTC = mesh_with_coordinates(options, partial=True)
    asked = {name: getattr(options, name) for name in LIMITS}
    if options.resolution is not None:
        asked["resolution"] = options.resolution
    with progress_part("checking", PROGRESS["computing"]):
        found = check_uv(mesh.V, mesh.F, TC, FTC, **asked)
    figures = {"good": found.good, "troubles": found.troubles, "check": found}
    hand_out(options, str(found), figures)
    return judged(options, found.good, found.troubles)


def mesh_with_coordinates(
    options: argparse.Namespace, partial: bool = False
) -> tuple[MeshFile, FloatArray, Faces]:
    """What the file holds, and its texture coordinates; with `partial`, -1 where a corner has none."""
    mesh = given_mesh(options, partial)
    if mesh.TC is None or mesh.FTC is None:
        where = "" if partial else " at all corners"
        raise MeshError(f"{options.mesh} has no texture coordinates{where}: unwrap it")
    if moves_textures(mesh):
        warnings.warn(
            "materials move the texture coordinates (KHR_texture_transform): they are taken as they are "
            "stored, and sizes in texels may be other ones; apply it before",
            MeshWarning,
            stacklevel=stack_level(),
        )
    return mesh, mesh.TC, mesh.FTC


CHECK = Command(
    "check",
    _check,
    "measure and judge the texture coordinates that a mesh has; the exit code is for pipelines",
    {
        **shared("mesh", "resolution"),
        "max-stretch": value("L2", "refuse more L2 stretch, of all charts at one scale", float),
        "max-spread": value("RATIO", "refuse more between the texels of two parts of the surface", float),
        "min-margin": value("TEXELS", "refuse less between charts, and half of it to the border", float),
        **shared("json", "quiet"),
    },
    "Check texture coordinates. Exit code 1: a face is flipped or has none, charts overlap by accident, or a "
    "limit is not kept. Mirrored charts are good, and so are charts that lie on each other to share their "
    "texture.",
    (
        "body.glb",
        "body.obj --resolution 2048 --min-margin 8 --max-stretch 1.3 --max-spread 3 --quiet",
        "'props/*.glb' --json > figures.jsonl    # one line a mesh",
    ),
    each=True,
)
