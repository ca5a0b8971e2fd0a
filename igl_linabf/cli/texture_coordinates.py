"""Define the commands `igl-linabf check` and `pack`, for the texture coordinates of a mesh."""

import warnings
from dataclasses import replace
from functools import partial
from typing import Annotated, Any, Literal

from .._runtime import progress_part
from .._types import FloatArray
from ..batch import check_target, warn_of_parts_without_texture
from ..charts import Packing
from ..errors import MeshError, MeshWarning, escape_control_characters, stack_level
from ..io import MeshFile, find_largest_image, has_transformed_textures, list_image_users
from ..surface import Faces
from ..uv import CHECKED_RESOLUTION, ScaleName, check_uv, pack
from .arguments import PACKING, Option
from .jobs import MESHES, OUTPUT, PROGRESS, REPORTS, ExitCode, Job
from .outputs import make_writer, report_troubles, write_outputs

MAX_STRETCH = Option("largest L2 stretch, with all charts at one scale", "L2")
MAX_SPREAD = Option("largest ratio between the texels of two parts of the surface", "RATIO")
TEXCOORD = Option("1: use the second texture coordinates, such as for lightmaps; keep the first set")
TEXELS = replace(
    PACKING["resolution"],
    help="texels along a page's side, or its width and height (2048x1024), for densities and margins "
    f"(default: those of the file's largest image, or {CHECKED_RESOLUTION})",
)
MIN_MARGIN = Option("smallest distance between charts; half of it to the border", "TEXELS")


def check_coordinates(
    job: Annotated[Job, {**MESHES, **REPORTS}],
    *,
    resolution: Annotated[int | tuple[int, int] | None, TEXELS] = None,
    max_stretch: Annotated[float | None, MAX_STRETCH] = None,
    max_spread: Annotated[float | None, MAX_SPREAD] = None,
    min_margin: Annotated[float | None, MIN_MARGIN] = None,
    texcoord: Annotated[Literal[0, 1], TEXCOORD] = 0,
) -> ExitCode:
    """Measure and judge the texture coordinates of a mesh; the exit code is for pipelines.

    Exit code 1: a face is flipped or has no coordinates, charts overlap by accident, or a limit is exceeded.
    Mirrored and stacked charts, which share their texture, are good.

    Examples
    --------
    body.glb
    scene/body.gltf --allow-outside    # its buffer is in another folder
    body.obj --resolution 2048 --min-margin 8 --max-stretch 1.3 --max-spread 3 --quiet
    house_lit.glb --texcoord 1 --resolution 1024    # the map for its lightmap
    'props/*.glb' --json > figures.jsonl    # one line per mesh
    """
    mesh, TC, FTC = _read_mesh_with_coordinates(job, "they are not measured", texcoord)
    asked: dict[str, Any] = {"max_stretch": max_stretch, "max_spread": max_spread, "min_margin": min_margin}
    note = ""
    if resolution is None:
        resolution, note = _assume_resolution(mesh, texcoord)
    with progress_part("checking", PROGRESS["computing"]):
        found = check_uv(
            mesh.V, mesh.F, TC, FTC, labels=list_image_users(mesh), resolution=resolution, **asked
        )
    check = {**found.figures, "limits": found.report.limits, "flipped": found.flipped}
    check["sheets"] = found.report.sheets
    figures = {"good": found.good, "troubles": found.troubles, "check": check}
    write_outputs(job, f"{found}{note}", {**figures, "unmapped_parts": mesh.list_parts_without_texture()})
    return report_troubles(job, found.good, found.troubles)


def _assume_resolution(mesh: MeshFile, texcoord: int) -> tuple[tuple[int, int], str]:
    """Return the width and height of the largest image on the texture coordinates, and a note about it."""
    size, source = (CHECKED_RESOLUTION, CHECKED_RESOLUTION), "the file has no image on these coordinates"
    if not texcoord:  # images of second texture coordinates are not read
        try:
            found = find_largest_image(mesh)
        except (MeshError, OSError) as error:
            found, source = None, str(error)
        if found is not None:
            name, size = found
            source = f"the size of {name}"
    width, height = size
    return (
        size,
        f"\n\nTexels are counted at {width} x {height}, without --resolution: "
        f"{escape_control_characters(source)}.",
    )


SCALE = Option("keep: relative sizes of the charts; even: the same texel density on all")


def pack_charts(
    job: Annotated[Job, {**MESHES, **OUTPUT, **REPORTS}],
    *,
    packing: Annotated[Packing, PACKING],
    no_rotate: Annotated[bool, Option("move and scale charts, but do not rotate them")] = False,
    scale: Annotated[ScaleName, SCALE] = "keep",
    texcoord: Annotated[Literal[0, 1], TEXCOORD] = 0,
) -> ExitCode:
    """Repack the charts of a mesh's texture coordinates.

    Charts keep their shapes, and stacked charts stay stacked. Images are not moved; igl-linabf unwrap --seams
    uv --bake texture bakes them for an atlas with the same seams.

    Examples
    --------
    body.obj -o body_2k.obj --resolution 2048 --padding 8
    props/table.gltf -o table.glb --allow-outside    # its images are in another folder
    table.glb -o even.glb --scale even --no-rotate    # wood grain stays upright
    body.obj -o body.obj --texel-density 200 --resolution 1024 --pages 4 --quiet
    scan.glb -o scan_2k.glb --scale even --unseen 0.25    # fewer texels for cavities
    body.obj -o there/body.obj --force    # replaces there/body.mtl
    house_lit.glb -o house_lit.glb --texcoord 1 --resolution 512    # the map for its lightmap
    wall.glb -o wall.glb --resolution 2048x1024    # pages that are not square
    'props/*.obj' -o packed/ --format glb --json > figures.jsonl    # one line per mesh
    """
    if texcoord:
        check_target(job.output_name, None, texcoord)
    mesh, TC, FTC = _read_mesh_with_coordinates(job, "they are left as they are", texcoord)
    options: dict[str, Any] = {"rotate": not no_rotate, "scale": scale, "labels": list_image_users(mesh)}
    with progress_part("packing", PROGRESS["computing"]):
        packed = pack(mesh.V, mesh.F, TC, FTC, packing, **options)
    write = partial(make_writer(job), mesh=mesh, TC=packed.TC, FTC=packed.FTC, texcoord=texcoord)
    figures = {"packed": packed, "unmapped_parts": mesh.list_parts_without_texture()}
    write_outputs(job, str(packed), figures, write=write)
    return ExitCode.GOOD


def _read_mesh_with_coordinates(job: Job, bare: str, texcoord: int) -> tuple[MeshFile, FloatArray, Faces]:
    """Read a mesh and its texture coordinates; `bare` is a text about faces without texture coordinates."""
    mesh = job.read_mesh(texcoord=texcoord)
    if mesh.TC is None or mesh.FTC is None:
        which, hint = ("second ", " with --texcoord 1") if texcoord else ("", "")
        raise MeshError(f"{job.title} has no {which}texture coordinates: unwrap it{hint}")
    warn_of_parts_without_texture(mesh, [bare])
    if has_transformed_textures(mesh, texcoord):
        warnings.warn(
            "materials transform the texture coordinates (KHR_texture_transform): the stored ones are used, "
            "and sizes in texels may differ; apply the transform first",
            MeshWarning,
            stacklevel=stack_level(),
        )
    return mesh, mesh.TC, mesh.FTC
