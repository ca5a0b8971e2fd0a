"""Define the commands `igl-linabf flatten`, `compare`, `cortex` and `scroll`."""

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from .._runtime import progress_part, show_progress
from ..cortex import (
    HEMISPHERE_NAMES,
    CutSource,
    WallSource,
    flatten_hemispheres,
    list_output_paths,
    writing_hemispheres,
)
from ..errors import MeshWarning, format_count
from ..flattening import METHODS, Fit, compare, flatten
from ..io import (
    Patch,
    as_mesh_file,
    check_no_file_exists,
    check_target,
    is_flat_format,
    read_tifxyz,
    unit_square,
    write_atomically,
    writing_tifxyz,
)
from ..layouts import LayoutName
from ..linalg import SolverName, format_gigabytes
from ..measures import RINGS, format_pair_count, format_table, quality
from ..scrolls import FlatSegment, flatten_segment, memory_needed
from .arguments import (
    ALLOW_OUTSIDE,
    Boundary,
    Corners,
    MethodName,
    Option,
    Units,
    Weight,
    build_method,
    describe_output_option,
    parse_axis,
    parse_axis_or_word,
)
from .jobs import FORCE, MESHES, OUTPUT, PICTURE, PROGRESS, REPORTS, ExitCode, Job, check_companion_files
from .outputs import make_writer, report_troubles, write_outputs

SURFACE = Option("surface that a FreeSurfer patch was cut from (default: found beside the patch)", "SURFACE")
UP = Option("direction in space that points up in the map: z, --up=-z, or 0,1,1", "AXIS", parse_axis)
GUARANTEE = Option("if triangles flip, run a last stage that leaves no triangle flipped")
RINGS_OPTION = Option("measure the error of distances within N rings; FreeSurfer uses 7", "N")


def flatten_mesh(
    job: Annotated[Job, {**MESHES, **OUTPUT, **PICTURE, **REPORTS}],
    *,
    surface: Annotated[Path | None, SURFACE] = None,
    method: MethodName = "linabf",
    iterations: Annotated[Literal["auto"] | int, Option("number of iterations", "N")] = "auto",
    layout: Annotated[LayoutName, Option("layout of the map from its angles")] = "auto",
    outer: Annotated[int | None, Option("a vertex of the outer boundary loop", "VERTEX")] = None,
    boundary: Boundary = "free",
    corners: Corners = None,
    up: Annotated[list[float] | None, UP] = None,
    solver: Annotated[SolverName, Option("solver of the linear systems")] = "auto",
    guarantee: Annotated[Literal["injective"] | None, GUARANTEE] = None,
    weight: Weight = None,
    fit: Annotated[Fit, Option("quantity that the map's scale preserves, in the mesh's units")] = "area",
    rings: Annotated[int | None, RINGS_OPTION] = None,
    units: Units = None,
) -> ExitCode:
    """Flatten a disk, with or without holes; write it with texture coordinates, print the quality.

    Exit code 1: written, but with flipped triangles or overlaps.

    Examples
    --------
    camelhead.off -o camelhead.obj --picture camelhead.png
    heads/nefertiti.gltf -o flat.glb --allow-outside    # its images are in another folder
    camelhead.off -o camelhead.obj --picture camelhead.png --force    # replaces an older picture
    camelhead.off -o camelhead.obj --method abf --units mesh
    camelhead.off -o camelhead.obj --method isometric --weight 3    # areas, too
    camelhead.off -o camelhead.obj --iterations 1 --layout least-squares --solver direct
    face.obj -o face.obj --boundary rectangle --corners 12 3 840 77    # found without --corners
    face.obj -o face.obj --up z    # the map of a head that stands, upright
    crown.obj -o flat.obj --outer 17 --guarantee injective    # vertex 17 is on the outer loop
    lh.full.patch.3d -o lh.full.flat.patch.3d --method isometric --fit lengths
    lh.cut.patch.3d --surface lh.mine -o flat.surf.gii --method isometric --rings 7    # in mm
    'heads/*.off' -o maps/ --format glb --json > figures.jsonl    # one line per mesh
    - -o - --quiet < head.obj > flat.obj
    """
    options = {"iterations": iterations, "layout": layout, "solver": solver, "guarantee": guarantee}
    chosen = build_method(method, **options, weight=weight)
    in_lengths = fit == "lengths"
    if units is None:  # a map that is stored as a surface keeps the size of the mesh
        units = "mesh" if in_lengths or is_flat_format(job.output_name) else "square"
    if in_lengths and units == "square":
        raise ValueError("--fit lengths sets a scale in the mesh's units: give --units mesh, too")
    mesh = job.read_mesh(surface)
    check_companion_files(job, mesh)
    V, F = mesh.V, mesh.triangles
    with progress_part("flattening", PROGRESS["computing"]), warnings.catch_warnings():
        if isinstance(mesh.extras.source, Patch):  # vertices outside the patch belong to no face
            warnings.filterwarnings("ignore", "vertices .* belong to no face", MeshWarning)
        result = flatten(V, F, method=chosen, fit=fit, outer=outer, boundary=boundary, corners=corners, up=up)
        uv = unit_square(result.uv) if units == "square" else result.uv
        measured = quality(V, F, uv, RINGS if rings is None and in_lengths else rings)
    write = partial(make_writer(job), mesh=mesh, TC=uv)
    figures = {"quality": measured, "result": result}
    write_outputs(job, f"{measured}\n\n{result}", figures, (V, F, {method: result.uv}), write)
    troubles = [] if result.outcome.good else [result.message]
    if not troubles and measured.flips > len(result.flipped):
        troubles = [
            f"rounding flips {format_count(measured.flips, 'triangle')} when the map is scaled to the unit "
            "square, because its scale varies too much: use --units mesh, or unwrap the mesh"
        ]
    return report_troubles(job, not troubles, troubles)


def compare_methods(
    job: Annotated[Job, {**MESHES, **PICTURE, **REPORTS}],
    *,
    methods: Annotated[
        str, Option(f"some of {', '.join(METHODS)}, separated by commas", "METHODS")
    ] = "lscm,linabf,abf",
    boundary: Boundary = "free",
    corners: Corners = None,
    repeat: Annotated[int, Option("number of timed runs of each method", "N")] = 3,
) -> ExitCode:
    """Flatten a disk by several methods, and print their quality and time side by side.

    The disk may have holes. Times are relative to igl.lscm.

    Examples
    --------
    camelhead.off --methods lscm,linabf,abf --repeat 11
    scene/head.gltf --allow-outside    # its buffer is in another folder
    camelhead.off --picture side_by_side.png --quiet --force    # replaces an older picture
    camelhead.off --methods linabf,abf --boundary circle
    face.obj --boundary rectangle --corners 12 3 840 77
    'heads/*.off' --json > figures.jsonl    # one line per mesh
    """
    names = [name.strip() for name in methods.split(",")]
    mesh = job.read_mesh()
    V, F = mesh.V, mesh.triangles
    with progress_part("comparing", PROGRESS["computing"]):
        comparison = compare(V, F, names, repeat=repeat, boundary=boundary, corners=corners)
    write_outputs(job, str(comparison), {"comparison": comparison}, (V, F, comparison.maps))
    return ExitCode.GOOD


SUBJECT = Option("folder of a subject, which contains surf/", "SUBJECT")
FOLDER = describe_output_option("folder for the files; created if it does not exist")
CUTS = Option("take the cuts from a template, or find them from the medial wall")
MEDIAL_WALL = Option("medial wall of the template, or from label/?h.cortex.label")
TEMPLATE = Option(
    "cuts of another subject: a FreeSurfer patch lh...; for rh, its rh... (default: fsaverage5)", "PATCH"
)
SPHERE = Option("registered sphere of that subject, lh.sphere.reg", "SPHERE")
MAX_ERROR = Option("largest error of distances with found cuts (default: 0.15)", "X")


def flatten_cortex(
    job: Annotated[Job, {"given": SUBJECT, "force": FORCE, **REPORTS}],
    *,
    output: Annotated[Path, FOLDER],
    hemi: Annotated[Literal["lh", "rh", "both"], Option("hemisphere")] = "both",
    cuts: Annotated[CutSource, CUTS] = "template",
    medial_wall: Annotated[WallSource, MEDIAL_WALL] = "template",
    template: Annotated[Path | None, TEMPLATE] = None,
    template_sphere: Annotated[Path | None, SPHERE] = None,
    max_distance_error: Annotated[float | None, MAX_ERROR] = None,
    method: Annotated[Literal["isometric", "linabf", "abf"], Option("method")] = "isometric",
    weight: Weight = None,
) -> ExitCode:
    """Cut the hemispheres of a FreeSurfer subject, and write them flat, as patches, GIFTI and pictures.

    Exit code 1: written, but with flips or overlaps.

    Examples
    --------
    $SUBJECTS_DIR/sub-01 -o flat/
    sub-01 -o sub-01/surf --hemi lh    # where pycortex finds the patch cortex.flat
    sub-01 -o flat/ --template lh.mine.patch.3d --template-sphere lh.sphere.reg
    sub-01 -o flat/ --medial-wall label --json > figures.json
    monkey -o flat/ --cuts found --medial-wall label --max-distance-error 0.12
    sub-01 -o flat/ --method isometric --weight 1 --quiet --force    # replaces the files in flat/
    """
    names = HEMISPHERE_NAMES if hemi == "both" else (hemi,)
    if (template is None) != (template_sphere is None):
        raise ValueError("--template and --template-sphere go together: give both, or neither")
    given = None if template is None or template_sphere is None else (template, template_sphere)
    if not os.access(output if output.exists() else output.parent, os.W_OK):
        raise OSError(None, "the folder is missing or cannot be written to", str(output))
    check_no_file_exists((path for name in names for path in list_output_paths(output, name)), job.force)
    flats = flatten_hemispheres(
        job.mesh,
        names,
        method=build_method(method, weight=weight),
        cuts=cuts,
        medial_wall=medial_wall,
        template=given,
        max_distance_error=max_distance_error,
    )
    text = [str(format_table({flat.hemisphere.name: flat.quality for flat in flats})), ""]
    figures: dict[str, Any] = {"good": all(flat.good for flat in flats)}
    for flat in flats:
        name = flat.hemisphere.name
        files = [str(path) for path in list_output_paths(output, name)]
        text += [f"{name}: left out are {flat.left_out}", *(f"  {file}" for file in files)]
        figures[name] = {"quality": flat.quality, "left out": flat.left_out, "files": files}
    write = partial(writing_hemispheres, flats=flats)
    write_outputs(replace(job, output=output), "\n".join(text), figures, write=write)
    troubles = [
        f"{flat.hemisphere.name}: {flat.result.message}; {format_pair_count(flat.quality.overlaps)} pairs of "
        "triangles overlap"
        for flat in flats
        if not flat.good
    ]
    return report_troubles(job, not troubles, troubles)


SEGMENT = Option("folder in the tifxyz format", "SEGMENT")
SCROLL_FORCE = Option("replace an existing segment and mesh")
SCROLL_FOLDER = describe_output_option("folder of the flat segment")
OBJ = Option("also write the flattened mesh, with texture coordinates in voxels", "OUT.obj")
PIECES = Option("flatten the N largest pieces, side by side", "N")
SCROLL_UP = Option(
    "direction that points up in the flat segment: axis (of the scroll, z), rows (of the given grid), or a "
    "direction in the volume, such as --up=-z",
    "DIRECTION",
    partial(parse_axis_or_word, words=("axis", "rows")),
)


def flatten_scroll(
    job: Annotated[Job, {"given": SEGMENT, "allow_outside": ALLOW_OUTSIDE, "force": SCROLL_FORCE, **REPORTS}],
    *,
    output: Annotated[Path, SCROLL_FOLDER],
    method: MethodName = "isometric",
    up: Annotated[list[float] | str, SCROLL_UP] = "axis",
    pieces: Annotated[int, PIECES] = 1,
    obj: Annotated[Path | None, OBJ] = None,
) -> ExitCode:
    """Flatten a segment of a scroll, and write it as a grid at true scale.

    Holes are not cut. Exit code 1: written, but with flips or overlaps.

    Examples
    --------
    segment -o segment_flat
    segment -o segment_flat --obj segment_flat.obj --method linabf
    segment -o segment_flat --up rows --pieces 3 --force
    segment -o segment_flat --allow-outside    # its files are links to another folder
    segment -o segment_flat --json > figures.json
    segment -o segment_flat --quiet
    """
    check_target(output, job.force)
    if not os.access(output.resolve().parent, os.W_OK):
        raise OSError(None, "the folder is missing or cannot be written to", str(output.parent))
    if obj is not None:
        if obj.suffix.lower() != ".obj":
            raise ValueError(f"{obj} does not end in .obj: give a file name that does")
        check_no_file_exists([obj], job.force)
    silent = job.quiet or job.json
    with show_progress(False if silent else None):
        with progress_part("reading", PROGRESS["reading"]):
            segment = read_tifxyz(job.mesh, allow_outside=job.allow_outside)
        if not silent:
            needed = format_gigabytes(memory_needed(segment))
            print(
                f"{format_count(int(segment.valid.sum()), 'point')}, which take about {needed} of memory",
                file=sys.stderr,
            )
        with progress_part("flattening", PROGRESS["computing"]):
            flat = flatten_segment(segment, method=method, up=up, pieces=pieces)
        report = flat.report
        good = not (report.flips or report.overlaps)
        write = partial(_writing_scroll, flat=flat, obj=obj, force=job.force)
        write_outputs(replace(job, output=output), str(report), {"good": good, "report": report}, write=write)
    return report_troubles(job, good, ())


@contextmanager
def _writing_scroll(path: Path, flat: FlatSegment, obj: Path | None, force: bool) -> Iterator[None]:
    """Write a flat segment under temporary names, and rename its files when the `with` block succeeds."""
    with ExitStack() as stack:
        if obj is not None:
            stack.enter_context(write_atomically(obj, as_mesh_file(flat.V, flat.F), flat.uv, None))
        stack.enter_context(writing_tifxyz(path, flat.segment, force=force))
        yield
