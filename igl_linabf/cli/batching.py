"""Define the command `igl-linabf batch`."""

from typing import Annotated, Literal

from ..batch import BakedPacking, flatten_files
from ..charts import ChartOptions, Cones
from ..flattening import METHODS
from ..io import SUFFIXES
from .arguments import (
    ALLOW_OUTSIDE,
    BAKE,
    CHARTS,
    EXTEND_SEAMS,
    KEEP_MATERIALS,
    PERIOD,
    STRICT,
    TEXCOORD,
    UNWRAP_PACKING,
    WELD,
    Boundary,
    ConeCount,
    Option,
    Units,
    Weight,
    build_method,
    describe_output_option,
)
from .jobs import ExitCode

INPUTS = Option("mesh files, folders of them, globs in quotes, URLs", "IN", nargs="+")
OUTPUT = describe_output_option("folder for the maps and results.csv; an interrupted batch resumes there")
HOW = Option("unwrap: with seams; flatten: disks only; cortex: FreeSurfer subjects")
METHOD = Option(
    "method (default: isometric, but linabf with --cones and to flatten)", choices=sorted(METHODS)
)
SEAMS = Option("auto, or uv: the seams of the texture coordinates in each file", "SEAMS")
FORMAT = Option("file format of the maps", choices=[suffix[1:] for suffix in SUFFIXES])
CONE_ANGLES = Option("cone angles in quarter turns (default: those with the same scale at all cones)")


def run_batch(
    inputs: Annotated[list[str], INPUTS],
    *,
    output: Annotated[str, OUTPUT],
    workers: Annotated[int | None, Option("processes on this machine (default: one per core)", "N")] = None,
    scheduler: Annotated[
        str | None, Option("use the workers of this Dask scheduler instead", "ADDRESS")
    ] = None,
    how: Annotated[Literal["unwrap", "flatten", "cortex"], HOW] = "unwrap",
    method: Annotated[str | None, METHOD] = None,
    format: Annotated[str, FORMAT] = "obj",
    memory: Annotated[str | None, Option("memory limit of one mesh, such as 2GiB", "SIZE")] = None,
    seams: Annotated[Literal["auto", "uv"], SEAMS] = "auto",
    charts: Annotated[ChartOptions | None, {"extend": EXTEND_SEAMS, **CHARTS}],
    keep_materials: Annotated[bool, KEEP_MATERIALS] = False,
    weld: Annotated[Literal["no"] | float | None, WELD] = None,
    strict: Annotated[bool, STRICT] = False,
    weight: Weight = None,
    boundary: Boundary = "free",
    units: Units = None,
    cones: ConeCount = None,
    cone_angles: Annotated[Literal["quarter"] | None, CONE_ANGLES] = None,
    period: Annotated[float | None, PERIOD] = None,
    packing: Annotated[BakedPacking | None, {**UNWRAP_PACKING, "bake": BAKE}],
    texcoord: Annotated[Literal[0, 1], TEXCOORD] = 0,
    retry: Annotated[bool, Option("retry meshes that died, ran out of memory or failed before")] = False,
    force: Annotated[bool, Option("replace files in OUT that were not written by a batch")] = False,
    allow_outside: Annotated[bool, ALLOW_OUTSIDE] = False,
    dashboard: Annotated[
        bool, Option("serve Dask's dashboard, a web page about the workers, and print its address")
    ] = False,
) -> ExitCode:
    """Unwrap many files on all cores or a cluster, with Dask; a second run resumes an interrupted one.

    Exit code 1: finished, but some maps are missing or have flips or overlaps; results.csv lists the reasons.

    Examples
    --------
    scans/ -o maps/
    scans/ 'more/**/*.ply' -o maps/ --workers 4 --format glb --memory 4GiB
    heads/ -o maps/ --how flatten --method abf --boundary circle
    scans/ -o maps/ --how flatten --units mesh    # in the meshes' units of length
    props/ -o maps/ --format glb --allow-outside    # their images are in another folder
    bodies/ -o maps/ --cones auto --cone-angles quarter
    scans/ -o maps/ --resolution 1024 --padding 4    # charts at least 4 texels apart
    bodies/ -o maps/ --cones auto --cone-angles quarter --period 0.02
    props/ -o maps/ --seams uv --extend-seams --keep-materials    # along the seams in the files
    scans/ -o maps/ --weld 1e-5 --weight 3
    parts/ -o maps/ --strict
    scans/ -o maps/ --trade 30 --keep-holes --repair-overlaps
    scans/ -o maps/ --max-stretch 1.2 --hide back    # seams at the backs of heads
    scans/ -o maps/ --max-dirichlet 4.1 --max-charts 8    # by a search over trade
    scans/ -o maps/ --resolution 2048 --texel-density 64 --pages 4    # as UDIM tiles
    scans/ -o maps/ --cut-below 0    # no cuts for a fuller page
    scans/ -o maps/ --resolution 1024 --unseen 0.25    # fewer texels for cavities
    scans/ -o maps/ --format glb --bake colors    # with the texture in each file
    props/ -o atlases/ --format glb --bake texture --resolution 4096
    houses/ -o lit/ --format glb --texcoord 1 --resolution 1024    # second maps, for lightmaps
    $SUBJECTS_DIR -o flat/ --how cortex --workers 8    # a folder for each subject
    scans/ -o maps/ --retry    # meshes that died before
    scans/ -o maps/ --force    # replaces maps from other programs
    scans/ -o maps/ --dashboard    # with a web page about the workers
    scans/ -o maps/ --scheduler tcp://10.0.0.1:8786
    """
    if (cone_angles is not None or period is not None) and cones is None:
        raise ValueError("--cone-angles and --period need cones: give --cones, too")
    done = flatten_files(
        inputs,
        output,
        workers=workers,
        scheduler=scheduler,
        how=how,
        method=method if weight is None else build_method(method or "isometric", weight=weight),
        format=format,
        memory=memory,
        charts=charts,
        boundary=boundary,
        units=units,
        cones=None if cones is None else Cones(cones, angles=cone_angles, period=period),
        packing=packing,
        bake=None if packing is None else packing.bake,
        texcoord=texcoord,
        weld=False if weld == "no" else weld,
        strict=strict,
        seams=seams,
        keep_materials=keep_materials,
        retry=retry,
        force=force,
        allow_outside=allow_outside,
        dashboard=dashboard,
    )
    print(done, flush=True)
    return ExitCode.GOOD if done.good else ExitCode.NOT_VALID
