"""The command `igl-linabf unwrap`."""

import argparse
import warnings
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import igl
import numpy as np

from .._runtime import progress_part
from .._types import FloatArray
from ..charts import Atlas, ChartOptions, Cones, Packing, texture_seams, unwrap
from ..errors import MeshError, OutcomeWarning
from ..io import (
    COLOUR,
    SUFFIXES,
    WITH_IMAGES,
    WITH_TWO_MAPS,
    MeshFile,
    corner_colours,
    image_maps,
    lies_flat,
    object_frames,
    object_space,
    tells_directions,
)
from ..surface import unit_vectors
from ..textures import bake, bake_texture
from .arguments import choice, format_argument, parse_vector, shared_arguments, switch, value
from .commands import STDIO, Command, build_from_options, build_method
from .jobs import PROGRESS, check_companion_files, read_given_mesh
from .outputs import check_outputs, make_writer, report_troubles, write_outputs

BAKED_RESOLUTION = 2048  # default texels along the side of a baked texture


def _unwrap(options: argparse.Namespace) -> int:
    check_outputs(options.output, options.picture, WITH_TWO_MAPS if options.texcoord else SUFFIXES)
    method = build_method(options.method, {"weight": options.weight})
    to = Path(f"map.{options.format}") if options.output == Path(STDIO) else options.output
    mesh = read_given_mesh(options)
    if options.texcoord and mesh.FTC is None:
        raise MeshError(f"{options.mesh} has no texture coordinates at all corners: leave out --texcoord")
    _check_baking(options, mesh, to)
    check_companion_files(options, mesh, _list_image_kinds(options.bake, mesh), bool(options.texcoord))
    if options.bake and options.resolution is None:
        options.resolution = BAKED_RESOLUTION
    V, F = mesh.V, mesh.F
    asked = _build_arguments(options, mesh)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OutcomeWarning)  # reported below
        with progress_part("unwrapping", PROGRESS["computing"]):
            atlas = unwrap(V, F, method=method, **asked)
    if options.picture and not len(atlas.drawn):
        raise MeshError(f"no face of {options.mesh} has an area, and a picture would be empty: leave it out")
    pictured = V[atlas.origin], atlas.drawn, {options.method: atlas.flat}
    figures = {"good": atlas.good, "troubles": atlas.troubles, "atlas": atlas}
    with progress_part("baking", PROGRESS["baking"]):
        image = _bake_images(options, mesh, atlas, to) if options.bake else None
    TC = atlas.flat / atlas.scale if lies_flat(to) else atlas.TC  # flat surfaces have the size of the mesh
    what = {"image": image, "texcoord": options.texcoord}
    write = partial(make_writer(options), mesh=mesh, TC=TC, FTC=atlas.FTC, **what)
    write_outputs(options, str(atlas), figures, pictured, write)
    return report_troubles(options, atlas.good, atlas.troubles)


def _build_arguments(options: argparse.Namespace, mesh: MeshFile) -> dict[str, Any]:
    """Return the arguments of `unwrap`, read from the options and from the files that they name."""
    seams: Any = None
    if options.seams == "uv":
        if mesh.TC is None or mesh.FTC is None:
            raise MeshError(
                f"{options.mesh} has no texture coordinates at all corners: it has no texture seams"
            )
        seams = texture_seams(mesh.F, mesh.FTC, mesh.V, mesh.TC, sides=True)
    elif options.seams != "auto":
        seams = _read_rows(options.seams, np.int64, "integers: write two vertices on each line")
    cones = options.cones
    if cones is not None and cones != "auto":
        lines = "integers: write one vertex on each line"
        cones = int(cones) if cones.isdecimal() else _read_rows(cones, np.int64, lines).ravel()
    angles = options.cone_angles
    if angles is not None and angles != "quarter":
        lines = "numbers: write one angle in degrees on each line"
        angles = np.deg2rad(_read_rows(angles, np.float64, lines).ravel())
    if cones is not None:
        cones = Cones(cones, angles=angles, period=options.period)
    elif angles is not None or options.period is not None:
        raise ValueError("--cone-angles and --period need cones: give --cones, too")
    charts = build_from_options(ChartOptions, options)
    if options.keep_materials:
        if mesh.extras.materials is None:
            raise MeshError(f"{options.mesh} has no materials: leave out --keep-materials")
        if cones is not None:
            raise ValueError(
                "--keep-materials adds cuts, and --cones chooses its own seams: leave out one of them"
            )
        charts = replace(charts or ChartOptions(), labels=mesh.extras.materials[1])
    return {
        "seams": seams,
        "charts": charts,
        "cones": cones,
        "packing": build_from_options(Packing, options),
        "weld": options.weld,
        "strict": options.strict,
    }


def _list_image_kinds(bake: str | None, mesh: MeshFile) -> list[str]:
    """Return the kinds of images to write."""
    if bake == "texture":
        return [of.kind for look in mesh.extras.looks or () for of in look.maps]
    return [] if bake is None else [COLOUR]


def parse_direction(text: str) -> list[float] | str:
    """Convert three numbers separated by commas; keep "back"."""
    return text if text == "back" else parse_vector(text, "three numbers such as 0,-1,0, or back")


def _read_rows(path: str, kind: type, what: str) -> Any:
    """Read the rows of a text file; an empty file gives shape (0, 2)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # NumPy warns of an empty file
        try:
            table: Any = np.loadtxt(path, dtype=kind, ndmin=2, encoding="utf-8-sig")
        except FileNotFoundError:
            raise MeshError(f"there is no file {path}: name a table of {what}") from None
        except ValueError:
            raise MeshError(f"{path} is not a table of {what}") from None
    return table if table.size else table.reshape(0, 2)


def _check_baking(options: argparse.Namespace, mesh: MeshFile, to: Path) -> None:
    """Raise if the requested texture cannot be baked. Called before the computation."""
    kind = options.bake
    if kind is None:
        return
    if to.suffix.lower() not in WITH_IMAGES:
        known = " or ".join(WITH_IMAGES)
        raise ValueError(f"--bake needs a file with a texture: give an output that ends in {known}")
    if options.texcoord:
        raise ValueError("--bake is for the first texture coordinates: leave out --texcoord, or --bake")
    if kind == "colors" and corner_colours(mesh) is None:
        raise MeshError(
            f"{mesh.path} has no colours of vertices, faces or materials: bake normals or position"
        )
    if kind == "texture" and (mesh.TC is None or mesh.FTC is None):
        raise MeshError(f"{mesh.path} has no texture coordinates at all corners: it has no texture to move")


def _bake_images(options: argparse.Namespace, mesh: MeshFile, atlas: Atlas, to: Path) -> Any:
    """Return the image (values from 0 to 1) or one image per page; for textures, a dictionary by kind."""
    if options.bake == "texture":
        return _rebake_textures(mesh, atlas, options.resolution, to)
    image = _bake_values(options.bake, mesh, atlas, options.resolution, to)
    return list(image) if atlas.pages > 1 else image


def _bake_values(kind: str, mesh: MeshFile, atlas: Atlas, resolution: Any, output: Path) -> FloatArray:
    V, triangles = mesh.V, mesh.triangles
    if kind == "colors":
        colours = corner_colours(mesh)
        assert colours is not None  # checked before
        return bake(V, mesh.F, atlas, colours[mesh.split.place], resolution)
    if kind == "normals":
        normals = np.nan_to_num(igl.per_vertex_normals(V, triangles))[triangles]
        frames = object_frames(mesh, output)
        if frames is not None:
            normals = unit_vectors(normals @ frames[mesh.split.face])
        return unit_vectors(bake(V, mesh.F, atlas, normals, resolution)) / 2 + 0.5
    used = V[np.unique(triangles)]
    low, size = used.min(axis=0), np.ptp(used, axis=0).max()
    return bake(V, mesh.F, atlas, (V - low) / (size if size > 0 else 1.0), resolution)


def _rebake_textures(mesh: MeshFile, atlas: Atlas, resolution: Any, output: Path) -> dict[str, Any]:
    """Return the images of the materials, baked for the new map."""
    maps = image_maps(mesh)
    if not maps:
        raise MeshError(
            f"{mesh.path} has no images on its texture coordinates that can be moved, such as in materials "
            "in OBJ or glTF: bake colors or normals"
        )
    assert mesh.extras.materials is not None  # they hold the images
    assert mesh.TC is not None  # checked before
    made: dict[str, Any] = {}
    V, directions = object_space(mesh, output)
    for kind, images in maps.items():
        normals = directions if tells_directions(kind, images) else None
        image = bake_texture(
            V,
            mesh.F,
            atlas,
            mesh.TC,
            mesh.FTC,
            images,
            resolution,
            labels=mesh.extras.materials[1],
            normals=normals,
        )
        made[kind] = list(image) if atlas.pages > 1 else image
    return made


UNWRAP = Command(
    "unwrap",
    _unwrap,
    "cut any surface into charts, flatten them without overlaps, pack them, and write the atlas",
    {
        **shared_arguments("mesh", "output"),
        "format": format_argument(SUFFIXES, "obj"),
        **shared_arguments("picture"),
        "seams": value(
            "SEAMS",
            "auto, uv (seams of the file's texture coordinates), or a file of vertex pairs from 0",
            default="auto",
        ),
        "cones": value(
            "N",
            "concentrate the curvature at N vertices, at an automatic number (auto), or at the vertices in a "
            "file, counted from 0: both sides of the seams through them match",
        ),
        "cone-angles": value(
            "ANGLES",
            "quarter (turns), or a file of angle sums in degrees (default: the same scale at all cones)",
        ),
        "period": value(
            "SHARE",
            "period of a texture, as a share of the page's side: it continues across seams of quarter turns",
            float,
        ),
        "keep-materials": switch("cut where two materials meet: no chart has faces of both"),
        "extend-seams": {**switch("add the seams that --seams lacks"), "dest": "extend"},
        **shared_arguments("trade"),
        "max-stretch": value("L2", "cut charts until their L2 stretch is at most L2", float),
        "hide": value(
            "X,Y,Z or back",
            "where seams may lie: the direction in which the back or underside faces (--hide=0,-1,0); "
            "or back: the side of a head or figure that has no face",
            parse_direction,
        ),
        **shared_arguments("keep-holes", "repair-overlaps"),
        "weld": value(
            "DISTANCE",
            "merge vertices within this distance; 0: merge coincident vertices (default for triangle soups)",
            float,
        ),
        "strict": switch("refuse a mesh that is not a clean manifold instead of repairing it"),
        **shared_arguments("resolution", "padding"),
        "texel-density": value("TEXELS", "texels per unit of length (default: fill the pages)", float),
        "pages": value("N", "number of pages, as UDIM tiles (default: 1, or as many as needed)", int),
        **shared_arguments("unseen"),
        "bake": choice(
            ("colors", "texture", "normals", "position"),
            help=f"bake a texture of --resolution texels ({BAKED_RESOLUTION}) into a GLB, glTF or 3MF file, "
            "or beside an OBJ: the colours of vertices, faces and materials, the images of the old texture "
            "coordinates, normals in the object's space (127.5 (n + 1)), or positions in the bounding cube",
        ),
        "texcoord": value(
            "N",
            "1: write second texture coordinates, such as for lightmaps; keep the first set and its images",
            int,
            0,
            choices=(0, 1),
        ),
        **shared_arguments("method", "force", "json", "quiet", "weight"),
    },
    "Unwrap any triangles. Exit code 1: written, but with flips, overlaps, or excessive stretch.",
    (
        "bunny.obj -o bunny.glb --picture bunny.png",
        "bunny.obj -o bunny.glb --method isometric --weight 1.5    # even texels",
        "bunny.obj -o bunny.obj --trade 30 --max-stretch 1.2    # longer seams, less stretch",
        "bunny.obj -o bunny.obj --seams uv --method abf    # along the seams in the file",
        "bunny.obj -o bunny.obj --seams pairs.txt --extend-seams    # along the edges of pairs.txt, and more",
        "house.obj -o house.glb --keep-materials    # no chart has faces of two materials",
        "body.obj -o body.obj --hide 0,0,-1    # seams at the back",
        "body.obj -o body.obj --cones auto --cone-angles quarter    # both sides of each seam match",
        "body.obj -o body.obj --cones auto --cone-angles quarter --period 0.02    # 50 repeats in a row",
        "body.obj -o body.obj --resolution 2048 --padding 8    # for a texture of this size",
        "body.obj -o body.obj --resolution 2048 --texel-density 400 --pages 4    # on up to four pages",
        "body.ply -o body.glb --bake colors    # with the texture in it",
        "house.glb -o atlas.glb --bake texture --resolution 4096x2048    # its images, in one atlas",
        "house.glb -o house_lit.glb --texcoord 1 --resolution 1024    # a second map, for lightmaps",
        "body.ply -o body.obj --bake colors    # with body.mtl and body.png beside it",
        "body.ply -o body.obj --bake colors --force    # replaces body.mtl and body.png",
        "scan.stl -o scan.ply --weld 1e-5 --keep-holes",
        "part.obj -o part.obj --strict --repair-overlaps",
        "body.obj -o body.glb --resolution 1024 --padding 4 --bake normals",
        "city.obj -o city.obj --resolution 2048 --texel-density 64 --pages 4    # as UDIM tiles",
        "scan.ply -o scan.glb --method isometric --unseen 0.25    # fewer texels for cavities",
        "'scans/*.stl' -o maps/ --format glb --json > figures.jsonl    # one line per mesh",
        "- -o - --quiet < bunny.obj > atlas.obj",
    ),
    each=True,
)
