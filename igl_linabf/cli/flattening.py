"""The commands `igl-linabf flatten` and `igl-linabf cortex`."""

import argparse
import os
import warnings
from functools import partial
from pathlib import Path
from typing import Any

from .._runtime import progress_part
from ..cortex import HEMISPHERES, files_of, flatten_hemispheres, writing_hemispheres
from ..errors import MeshWarning
from ..flattening import flatten
from ..io import SUFFIXES, Patch, check_free, lies_flat, unit_square
from ..measures import RINGS, quality, table
from .arguments import choice, parse_axis, shared_arguments, value
from .commands import Command, ExitCode, build_method, parse_auto_or_number
from .jobs import PROGRESS, check_companion_files, read_given_mesh
from .outputs import check_outputs, make_writer, report_troubles, write_outputs


def _flatten(options: argparse.Namespace) -> int:
    check_outputs(options.output, options.picture, SUFFIXES)
    asked = {name: getattr(options, name) for name in ("layout", "solver", "guarantee", "weight")}
    asked["iterations"] = parse_auto_or_number("iterations", options.iterations)
    method = build_method(options.method, asked)
    units = options.units or ("mesh" if _is_in_mesh_units(options) else "square")
    if options.fit == "lengths" and units == "square":
        raise ValueError("--fit lengths sets a scale in the mesh's units: give --units mesh, too")
    mesh = read_given_mesh(options)
    check_companion_files(options, mesh)
    V, F = mesh.V, mesh.triangles
    shape = {name: getattr(options, name) for name in ("outer", "boundary", "corners", "up")}
    rings = RINGS if options.rings is None and options.fit == "lengths" else options.rings
    with progress_part("flattening", PROGRESS["computing"]), warnings.catch_warnings():
        if isinstance(mesh.extras.source, Patch):  # a patch leaves vertices out on purpose
            warnings.filterwarnings("ignore", "vertices .* belong to no face", MeshWarning)
        result = flatten(V, F, method, fit=options.fit, **shape)
        uv = unit_square(result.uv) if units == "square" else result.uv
        measured = quality(V, F, uv, rings)
    pictured = V, F, {options.method: result.uv}
    figures = {"quality": measured, "result": result}
    write = partial(make_writer(options), mesh=mesh, TC=uv)
    write_outputs(options, f"{measured}\n\n{result}", figures, pictured, write)
    if not result.outcome.good:
        return report_troubles(options, False, [result.message])
    if measured.flips <= len(result.flipped):
        return ExitCode.GOOD
    message = (
        f"{measured.flips} triangles flip by rounding when the map is scaled to the unit square: its scale "
        "varies too much: use --units mesh, or unwrap the mesh"
    )
    return report_troubles(options, False, [message])


def _is_in_mesh_units(options: argparse.Namespace) -> bool:
    """Return True if the map has the mesh's scale by default, as flat surfaces do."""
    return options.fit == "lengths" or lies_flat(options.output)


FLATTEN = Command(
    "flatten",
    _flatten,
    "flatten a disk, with or without holes; write it with texture coordinates, print the quality",
    {
        **shared_arguments("mesh", "output"),
        "surface": value(
            "SURFACE", "surface that a FreeSurfer patch was cut from (default: found beside the patch)", Path
        ),
        **shared_arguments("picture", "method"),
        "iterations": value("N", "number of iterations, or auto", default="auto"),
        "layout": choice(("auto", "boundary", "least-squares", "greedy"), "auto"),
        "outer": value("VERTEX", "a vertex of the outer boundary loop", int),
        **shared_arguments("boundary", "corners"),
        "up": value("AXIS", "direction in space that points up in the map: z, --up=-z, or 0,1,1", parse_axis),
        "solver": choice(("auto", "cholmod", "direct"), "auto"),
        "guarantee": choice(
            ("injective",), help="if triangles flip, run a last stage that leaves no triangle flipped"
        ),
        **shared_arguments("weight"),
        "fit": choice(
            ("area", "lengths"), "area", "quantity that the map's scale preserves, in the mesh's units"
        ),
        "rings": value("N", "measure the error of distances within N rings; FreeSurfer uses 7", int),
        **shared_arguments("units", "force", "json", "quiet"),
    },
    "Flatten a disk, with or without holes. Exit code 1: written, but with flipped triangles.",
    (
        "camelhead.off -o camelhead.obj --picture camelhead.png",
        "camelhead.off -o camelhead.obj --picture camelhead.png --force    # replaces an older picture",
        "camelhead.off -o camelhead.obj --method abf --units mesh",
        "camelhead.off -o camelhead.obj --method isometric --weight 3    # areas, too",
        "camelhead.off -o camelhead.obj --iterations 1 --layout least-squares --solver direct",
        "face.obj -o face.obj --boundary rectangle --corners 12 3 840 77    # found without --corners",
        "face.obj -o face.obj --up z    # the map of a head that stands, upright",
        "crown.obj -o flat.obj --outer 17 --guarantee injective    # vertex 17 is on the outer loop",
        "lh.full.patch.3d -o lh.full.flat.patch.3d --method isometric --fit lengths",
        "lh.cut.patch.3d --surface lh.mine -o flat.surf.gii --method isometric --rings 7    # in mm",
        "'heads/*.off' -o maps/ --json > figures.jsonl    # one line per mesh",
        "- -o - --quiet < head.obj > flat.obj",
    ),
    each=True,
)


def _cortex(options: argparse.Namespace) -> int:
    names = HEMISPHERES if options.hemi == "both" else (options.hemi,)
    if (options.template is None) != (options.template_sphere is None):
        raise ValueError("--template and --template-sphere go together: give both, or neither")
    template = None if options.template is None else (options.template, options.template_sphere)
    folder = options.output
    if not os.access(folder if folder.exists() else folder.parent, os.W_OK):
        raise OSError(None, "the folder is missing or cannot be written to", str(folder))
    check_free((path for name in names for path in files_of(folder, name)), options.force)
    flats = flatten_hemispheres(
        options.subject,
        names,
        build_method(options.method, {"weight": options.weight}),
        cuts=options.cuts,
        medial_wall=options.medial_wall,
        template=template,
        max_distance_error=options.max_distance_error,
    )
    text = [str(table({flat.hemisphere.name: flat.quality for flat in flats})), ""]
    figures: dict[str, Any] = {"good": all(flat.good for flat in flats)}
    for flat in flats:
        name = flat.hemisphere.name
        files = [str(path) for path in files_of(folder, name)]
        text += [f"{name}: left out are {flat.left_out}", *(f"  {file}" for file in files)]
        figures[name] = {"quality": flat.quality, "left out": flat.left_out, "files": files}
    write_outputs(options, "\n".join(text), figures, write=partial(writing_hemispheres, flats=flats))
    troubles = [
        f"{flat.hemisphere.name}: {flat.result.message}; {flat.quality.overlaps} pairs of triangles overlap"
        for flat in flats
        if not flat.good
    ]
    return report_troubles(options, not troubles, troubles)


CORTEX = Command(
    "cortex",
    _cortex,
    "cut the hemispheres of a FreeSurfer subject, and write them flat, as patches, GIFTI and pictures",
    {
        "subject": value("SUBJECT", "folder of a subject, which contains surf/", Path),
        "folder": value("OUT", "folder for the files; created if it does not exist", Path, required=True),
        "hemi": choice(("lh", "rh", "both"), "both"),
        "cuts": choice(
            ("template", "found"),
            "template",
            "take the cuts from a template, or find them from the medial wall",
        ),
        "medial-wall": choice(
            ("template", "label"), "template", "medial wall of the template, or from label/?h.cortex.label"
        ),
        "template": value(
            "PATCH",
            "cuts of another subject: a FreeSurfer patch lh...; for rh, its rh... (default: fsaverage5)",
        ),
        "template-sphere": value("SPHERE", "registered sphere of that subject, lh.sphere.reg"),
        "max-distance-error": value("X", "largest error of distances with found cuts (default: 0.15)", float),
        "method": choice(("isometric", "linabf", "abf"), "isometric"),
        **shared_arguments("weight", "force", "json", "quiet"),
    },
    "Both hemispheres of a subject at once. Exit code 1: written, but with flips or overlaps.",
    (
        "$SUBJECTS_DIR/sub-01 -o flat/",
        "sub-01 -o sub-01/surf --hemi lh    # where pycortex finds the patch cortex.flat",
        "sub-01 -o flat/ --template lh.mine.patch.3d --template-sphere lh.sphere.reg",
        "sub-01 -o flat/ --medial-wall label --json > figures.json",
        "monkey -o flat/ --cuts found --medial-wall label --max-distance-error 0.12",
        "sub-01 -o flat/ --method isometric --weight 1 --quiet --force    # replaces the files in flat/",
    ),
)
