"""The command `igl-linabf check`."""

import argparse
import warnings

from ..._runtime import progress_part
from ..._types import FloatArray
from ...errors import MeshError, MeshWarning, stack_level
from ...io import MeshFile, moves_textures
from ...surface import Faces
from ...uv import check_uv
from ..arguments import shared_arguments, value
from ..commands import Command
from ..jobs import PROGRESS, read_given_mesh
from ..outputs import report_troubles, write_outputs

LIMITS = ("max_stretch", "max_spread", "min_margin")


def _check(options: argparse.Namespace) -> int:
    mesh, TC, FTC = read_mesh_with_coordinates(options, partial=True)
    asked = {name: getattr(options, name) for name in LIMITS}
    if options.resolution is not None:
        asked["resolution"] = options.resolution
    with progress_part("checking", PROGRESS["computing"]):
        found = check_uv(mesh.V, mesh.F, TC, FTC, **asked)
    figures = {"good": found.good, "troubles": found.troubles, "check": found}
    write_outputs(options, str(found), figures)
    return report_troubles(options, found.good, found.troubles)


def read_mesh_with_coordinates(
    options: argparse.Namespace, partial: bool = False
) -> tuple[MeshFile, FloatArray, Faces]:
    """Read a mesh and its texture coordinates; with `partial`, corners without coordinates are -1."""
    mesh = read_given_mesh(options, partial)
    if mesh.TC is None or mesh.FTC is None:
        where = "" if partial else " at all corners"
        raise MeshError(f"{options.mesh} has no texture coordinates{where}: unwrap it")
    if moves_textures(mesh):
        warnings.warn(
            "materials transform the texture coordinates (KHR_texture_transform): the stored ones are used, "
            "and sizes in texels may differ; apply the transform first",
            MeshWarning,
            stacklevel=stack_level(),
        )
    return mesh, mesh.TC, mesh.FTC


CHECK = Command(
    "check",
    _check,
    "measure and judge the texture coordinates of a mesh; the exit code is for pipelines",
    {
        **shared_arguments("mesh", "resolution"),
        "max-stretch": value("L2", "largest L2 stretch, with all charts at one scale", float),
        "max-spread": value("RATIO", "largest ratio between the texels of two parts of the surface", float),
        "min-margin": value("TEXELS", "smallest distance between charts; half of it to the border", float),
        **shared_arguments("json", "quiet"),
    },
    "Check texture coordinates. Exit code 1: a face is flipped or has no coordinates, charts overlap by "
    "accident, or a limit is exceeded. Mirrored and stacked charts, which share their texture, are good.",
    (
        "body.glb",
        "body.obj --resolution 2048 --min-margin 8 --max-stretch 1.3 --max-spread 3 --quiet",
        "'props/*.glb' --json > figures.jsonl    # one line per mesh",
    ),
    each=True,
)
