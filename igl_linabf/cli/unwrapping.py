"""Define the command `igl-linabf unwrap`."""

import warnings
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from .._runtime import progress_part
from ..batch import (
    BakedPacking,
    bake_images,
    check_contents,
    check_target,
    get_material_labels,
    list_image_kinds,
    warn_of_missing_coordinates,
)
from ..charts import ChartOptions, Cones, resolve_method_of_charts, unwrap
from ..errors import MeshError, OutcomeWarning
from ..flattening import METHODS
from ..io import MeshFile, is_flat_format
from .arguments import (
    BAKE,
    CHARTS,
    EXTEND_SEAMS,
    KEEP_MATERIALS,
    PERIOD,
    SEAMS,
    STRICT,
    TEXCOORD,
    UNWRAP_PACKING,
    WELD,
    Option,
    Weight,
    build_method,
    read_rows,
    read_seams,
)
from .jobs import MESHES, OUTPUT, PICTURE, PROGRESS, REPORTS, ExitCode, Job, check_companion_files
from .outputs import make_writer, report_troubles, write_outputs

CONES = Option(
    "concentrate the curvature at N vertices, at an automatic number (auto), or at the vertices in a file, "
    "counted from 0: both sides of the seams through them match",
    "N",
)
CONE_ANGLES = Option(
    "quarter (turns), or a file of angle sums in degrees (default: the same scale at all cones)", "ANGLES"
)
METHOD = Option("method (default: isometric, but linabf with --cones)", choices=sorted(METHODS))


def unwrap_mesh(
    job: Annotated[Job, {**MESHES, **OUTPUT, **PICTURE, **REPORTS}],
    *,
    seams: Annotated[Literal["auto", "uv"] | Path, SEAMS] = "auto",
    cones: Annotated[Literal["auto"] | int | Path | None, CONES] = None,
    cone_angles: Annotated[Literal["quarter"] | Path | None, CONE_ANGLES] = None,
    period: Annotated[float | None, PERIOD] = None,
    keep_materials: Annotated[bool, KEEP_MATERIALS] = False,
    charts: Annotated[ChartOptions | None, {"extend": EXTEND_SEAMS, **CHARTS}],
    weld: Annotated[Literal["no"] | float | None, WELD] = None,
    strict: Annotated[bool, STRICT] = False,
    packing: Annotated[BakedPacking, {**UNWRAP_PACKING, "bake": BAKE}],
    texcoord: Annotated[Literal[0, 1], TEXCOORD] = 0,
    method: Annotated[str | None, METHOD] = None,
    weight: Weight = None,
) -> ExitCode:
    """Cut any surface into charts, flatten them without overlaps, pack them, and write the atlas.

    Exit code 1: written, but with flips, overlaps, or excessive stretch.

    Examples
    --------
    bunny.obj -o bunny.glb --picture bunny.png
    props/chair.gltf -o chair.glb --allow-outside    # its images are in another folder
    bunny.obj -o bunny.glb --weight 4    # areas are even, angles less so
    bunny.obj -o bunny.glb --method linabf    # angles are exact, areas less so
    bunny.obj -o bunny.obj --trade 30 --max-stretch 1.2    # longer seams, less stretch
    bunny.obj -o bunny.obj --max-dirichlet 4.1    # the shortest seams found for this bound
    bunny.obj -o bunny.obj --max-charts 2
    bunny.obj -o bunny.obj --seams uv --method abf    # along the seams in the file
    bunny.obj -o bunny.obj --seams pairs.txt --extend-seams    # along the edges of pairs.txt, and more
    house.obj -o house.glb --keep-materials    # no chart has faces of two materials
    body.obj -o body.obj --hide 0,0,-1    # seams at the back
    body.obj -o body.obj --cones auto --cone-angles quarter    # both sides of each seam match
    body.obj -o body.obj --cones auto --cone-angles quarter --period 0.02    # 50 repeats in a row
    body.obj -o body.obj --resolution 2048 --padding 8    # for a texture of this size
    body.obj -o body.obj --resolution 2048 --texel-density 400 --pages 4    # on up to four pages
    body.ply -o body.glb --bake colors    # with the texture in it
    house.glb -o atlas.glb --bake texture --resolution 4096x2048    # its images, in one atlas
    house.glb -o house_lit.glb --texcoord 1 --resolution 1024    # a second map, for lightmaps
    body.ply -o body.obj --bake colors    # with body.mtl and body.png beside it
    body.ply -o body.obj --bake colors --force    # replaces body.mtl and body.png
    scan.stl -o scan.ply --weld 1e-5 --keep-holes
    part.obj -o part.obj --strict --repair-overlaps
    body.obj -o body.glb --resolution 1024 --padding 4 --bake normals
    city.obj -o city.obj --resolution 2048 --texel-density 64 --pages 4    # as UDIM tiles
    bunny.obj -o bunny.obj --cut-below 0    # no cuts for a fuller page
    scan.ply -o scan.glb --unseen 0.25    # fewer texels for cavities
    'scans/*.stl' -o maps/ --format glb --json > figures.jsonl    # one line per mesh
    - -o - --quiet < bunny.obj > atlas.obj
    """
    check_target(job.output_name, packing.bake, texcoord)
    mesh = job.read_mesh()
    check_contents(mesh, packing, texcoord)
    check_companion_files(job, mesh, list_image_kinds(packing.bake, mesh), packing.pages or 1, bool(texcoord))
    given_cones = _read_cones(cones, cone_angles, period)
    chosen = build_method(method or resolve_method_of_charts(None, given_cones).name, weight=weight)
    given_seams = read_seams(seams, mesh, charts, chosen)
    warn_of_missing_coordinates(mesh, packing.bake, texcoord, seams)
    if keep_materials:
        charts = replace(charts or ChartOptions(), labels=_get_material_labels(mesh, given_cones))
    with warnings.catch_warnings(), progress_part("unwrapping", PROGRESS["computing"]):
        warnings.simplefilter("ignore", OutcomeWarning)  # `report_troubles` reports the problems
        atlas = unwrap(
            mesh.V,
            mesh.F,
            given_seams,
            charts=charts,
            method=chosen,
            cones=given_cones,
            packing=packing,
            weld=False if weld == "no" else weld,
            strict=strict,
        )
    if job.picture and not len(atlas.drawn):
        raise MeshError(f"no face of {job.title} has an area, and a picture would be empty: leave it out")
    with progress_part("baking", PROGRESS["baking"]):
        image = bake_images(packing, mesh, atlas, job.output_name)
    TC = (
        atlas.flat / atlas.report.scale if is_flat_format(job.output_name) else atlas.TC
    )  # a map that is stored as a surface keeps the size of the mesh
    pictured = mesh.V[atlas.origin], atlas.drawn, {chosen.name: atlas.flat}
    figures = {"good": atlas.good, "troubles": atlas.troubles, "atlas": atlas}
    figures |= {"unmapped_parts": mesh.list_parts_without_texture()} if mesh.TC is not None else {}
    write = partial(make_writer(job), mesh=mesh, TC=TC, FTC=atlas.FTC, image=image, texcoord=texcoord)
    write_outputs(job, str(atlas), figures, pictured, write)
    return report_troubles(job, atlas.good, atlas.troubles)


def _read_cones(cones: Any, angles: Any, period: float | None) -> Cones | None:
    """Return the cones. Their vertices and their angles (in degrees) may be read from files."""
    if cones is None:
        if angles is not None or period is not None:
            raise ValueError("--cone-angles and --period need cones: give --cones, too")
        return None
    if isinstance(cones, Path):
        cones = read_rows(cones, np.int64, 1, "a vertex, counted from 0,").ravel()
    if isinstance(angles, Path):
        angles = np.deg2rad(read_rows(angles, np.float64, 1, "an angle in degrees").ravel())
    return Cones(cones, angles=angles, period=period)


def _get_material_labels(mesh: MeshFile, cones: Cones | None) -> Any:
    """Return the material of each face as a chart label."""
    if cones is not None:
        raise ValueError(
            "--keep-materials adds cuts, and --cones chooses its own seams: leave out one of them"
        )
    return get_material_labels(mesh)
