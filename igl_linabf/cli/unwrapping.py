"""`igl-linabf unwrap`."""

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
from ..charts import Atlas, Cones, Packing, Seams, texture_seams, unwrap
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
from .arguments import choice, format_of, shared, switch, three_numbers, value
from .commands import STANDARD, Command, method_with, options_as
from .jobs import PROGRESS, check_beside, given_mesh
from .outputs import check_outputs, hand_out, judged, written_from

# Texels along the side of a baked texture where none are asked for. Less shows texels on a screen; more makes
# files that take long to load. docs/baking.md has the time that it takes.
BAKED_RESOLUTION = 2048


def _unwrap(options: argparse.Namespace) -> int:
    check_outputs(options.output, options.picture, WITH_TWO_MAPS if options.texcoord else SUFFIXES)
    method = method_with(options.method, {"weight": options.weight})
    to = Path(f"map.{options.format}") if options.output == Path(STANDARD) else options.output
    mesh = given_mesh(options)
    if options.texcoord and mesh.FTC is None:
        raise MeshError(f"{options.mesh} has no texture coordinates at all corners: leave out --texcoord")
    _check_bake(options, mesh, to)
    check_beside(options, mesh, _kinds(options.bake, mesh), bool(options.texcoord))
    if options.bake and options.resolution is None:
        options.resolution = BAKED_RESOLUTION
    V, F = mesh.V, mesh.F
    asked = _asked(options, mesh)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OutcomeWarning)  # what is wrong is said below
        with progress_part("unwrapping", PROGRESS["computing"]):
            atlas = unwrap(V, F, method=method, **asked)
    if options.picture and not len(atlas.drawn):
        raise MeshError(f"no face of {options.mesh} has an area, and a picture would be empty: leave it out")
    pictured = V[atlas.origin], atlas.drawn, {options.method: atlas.flat}
    figures = {"good": atlas.good, "troubles": atlas.troubles, "atlas": atlas}
    with progress_part("baking", PROGRESS["baking"]):
        image = _baked(options, mesh, atlas, to) if options.bake else None
    TC = atlas.flat / atlas.scale if lies_flat(to) else atlas.TC  # as a surface it is as large as the mesh
    what = {"image": image, "texcoord": options.texcoord}
    write = partial(written_from(options), mesh=mesh, TC=TC, FTC=atlas.FTC, **what)
    hand_out(options, str(atlas), figures, pictured, write)
    return judged(options, atlas.good, atlas.troubles)


def _asked(options: argparse.Namespace, mesh: MeshFile) -> dict[str, Any]:
    """What `unwrap` is called with: seams, cones and packing, from the mesh's file and others."""
    seams: list[Any] = []
    if options.seams == "uv":
        if mesh.TC is None or mesh.FTC is None:
            raise MeshError(
                f"{options.mesh} has no texture coordinates at all corners: it has no seams of them"
            )
        seams = [texture_seams(mesh.F, mesh.FTC, mesh.V, mesh.TC, sides=True)]
    elif options.seams != "auto":
        seams = [_read_rows(options.seams, np.int64, "integers: write two vertices on each line")]
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
        raise ValueError("--cone-angles and --period are those of cones: give --cones, too")
    wanted = options_as(Seams, options, *seams)
    if options.keep_materials:
        if mesh.extras.materials is None:
            raise MeshError(f"{options.mesh} has no materials: leave out --keep-materials")
        if cones is not None:
            raise ValueError(
                "--keep-materials cuts, and --cones chooses its own seams: leave out one of them"
            )
        wanted = replace(wanted or Seams(), labels=mesh.extras.materials[1])
    return {
        "seams": wanted,
        "cones": cones,
        "packing": options_as(Packing, options),
        "weld": options.weld,
        "strict": options.strict,
    }


def _kinds(bake: str | None, mesh: MeshFile) -> list[str]:
    """The kinds of images that are written."""
    if bake == "texture":
        return [of.kind for look in mesh.extras.looks or () for of in look.maps]
    return [] if bake is None else [COLOUR]


def direction(text: str) -> list[float] | str:
    """Three numbers with commas between, or "back"."""
    return text if text == "back" else three_numbers(text, "three numbers, as 0,-1,0, or back")


def _read_rows(path: str, kind: type, what: str) -> Any:
    """The rows of a text file; of an empty one (0, 2)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numpy's, of an empty file
        try:
            table: Any = np.loadtxt(path, dtype=kind, ndmin=2, encoding="utf-8-sig")
        except FileNotFoundError:
            raise MeshError(f"there is no file {path}: name a table of {what}") from None
        except ValueError:
            raise MeshError(f"{path} is no table of {what}") from None
    return table if table.size else table.reshape(0, 2)


def _check_bake(options: argparse.Namespace, mesh: MeshFile, to: Path) -> None:
    """Refuse before the work what cannot be baked."""
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


def _baked(options: argparse.Namespace, mesh: MeshFile, atlas: Atlas, to: Path) -> Any:
    """The image from 0 to 1 for the file that is written, or one for each page; textures by their kinds."""
    if options.bake == "texture":
        return _moved_images(mesh, atlas, options.resolution, to)
    image = _shown(options.bake, mesh, atlas, options.resolution, to)
    return list(image) if atlas.pages > 1 else image


def _shown(kind: str, mesh: MeshFile, atlas: Atlas, resolution: Any, output: Path) -> FloatArray:
    V, triangles = mesh.V, mesh.triangles
    if kind == "colors":
        colours = corner_colours(mesh)
        assert colours is not None  # which has been checked
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


def _moved_images(mesh: MeshFile, atlas: Atlas, resolution: Any, output: Path) -> dict[str, Any]:
    """The images of the materials on the new map."""
    maps = image_maps(mesh)
    if not maps:
        raise MeshError(
            f"{mesh.path} has no images on its texture coordinates that can be moved, as materials in OBJ or "
            "glTF have them: bake colors or normals"
        )
    assert mesh.extras.materials is not None  # which have the images
    assert mesh.TC is not None  # which has been checked
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
        **shared("mesh", "output"),
        "format": format_of(SUFFIXES, "obj"),
        **shared("picture"),
        "seams": value(
            "SEAMS",
            "auto, uv (seams of the file's texture coordinates), or a file of vertex pairs from 0",
            default="auto",
        ),
        "cones": value(
            "N",
            "leave the curvature at so many vertices, at auto (as many as pay), or at those in a "
            "file, from 0: both sides of the seams through them match",
        ),
        "cone-angles": value(
            "ANGLES", "quarter (turns), or a file of their angle sums in degrees (default: of one scale)"
        ),
        "period": value(
            "SHARE",
            "of a texture, as a share of the page's side: it goes on across seams of quarter turns",
            float,
        ),
        "keep-materials": switch("cut where two materials meet: no chart has faces of both"),
        "complete": switch("find the seams that the given ones leave missing"),
        **shared("trade"),
        "max-stretch": value("L2", "cut charts until their L2 stretch is at most this", float),
        "hide": value(
            "X,Y,Z or back",
            "where seams may lie: the direction in which the back or underside looks (--hide=0,-1,0); "
            "or back: of a head or figure, the side without a face",
            direction,
        ),
        **shared("holes", "bijective"),
        "weld": value(
            "DISTANCE",
            "make vertices one that are this near; 0: those in one place (as is done for soups)",
            float,
        ),
        "strict": switch("refuse a mesh that is no clean manifold, do not repair it"),
        **shared("resolution", "padding"),
        "texel-density": value(
            "TEXELS", "texels per unit of length (default: as many as the pages hold)", float
        ),
        "pages": value("N", "pages, as UDIM tiles (default: 1, or what it takes)", int),
        **shared("unseen"),
        "bake": choice(
            ("colors", "texture", "normals", "position"),
            help=f"bake a texture of --resolution texels ({BAKED_RESOLUTION}) into a GLB, glTF or 3MF file, "
            "or beside an OBJ: the colours of vertices, faces and materials, the images of the old texture "
            "coordinates, normals in the object's space (127.5 (n + 1)), or positions in the bounding cube",
        ),
        "texcoord": value(
            "N",
            "1: write second texture coordinates, as of lightmaps; the first ones and their images stay",
            int,
            0,
            choices=(0, 1),
        ),
        **shared("method", "force", "json", "quiet", "weight"),
    },
    "Unwrap any triangles. Exit code 1: written, but with flips, overlaps, or stretch beyond use.",
    (
        "bunny.obj -o bunny.glb --picture bunny.png",
        "bunny.obj -o bunny.glb --method isometric --weight 1.5    # even texels",
        "bunny.obj -o bunny.obj --trade 30 --max-stretch 1.2    # longer seams, less stretch",
        "bunny.obj -o bunny.obj --seams uv --method abf    # along the seams that the file has",
        "bunny.obj -o bunny.obj --seams pairs.txt --complete    # along the edges of pairs.txt, and more",
        "house.obj -o house.glb --keep-materials    # no chart has faces of two materials",
        "body.obj -o body.obj --hide 0,0,-1    # seams at the back",
        "body.obj -o body.obj --cones auto --cone-angles quarter    # both sides of each seam match",
        "body.obj -o body.obj --cones auto --cone-angles quarter --period 0.02    # 50 repeats go on",
        "body.obj -o body.obj --resolution 2048 --padding 8    # for a texture of this size",
        "body.obj -o body.obj --resolution 2048 --texel-density 400 --pages 4    # on up to four pages",
        "body.ply -o body.glb --bake colors    # with the texture in it",
        "house.glb -o atlas.glb --bake texture --resolution 4096x2048    # its images, in one atlas",
        "house.glb -o house_lit.glb --texcoord 1 --resolution 1024    # a second map, for lightmaps",
        "body.ply -o body.obj --bake colors    # with body.mtl and body.png beside it",
        "body.ply -o body.obj --bake colors --force    # also where body.png is there already",
        "scan.stl -o scan.ply --weld 1e-5 --holes",
        "part.obj -o part.obj --strict --bijective",
        "body.obj -o body.glb --resolution 1024 --padding 4 --bake normals",
        "city.obj -o city.obj --resolution 2048 --texel-density 64 --pages 4    # as UDIM tiles",
        "scan.ply -o scan.glb --method isometric --unseen 0.25    # fewer texels for cavities",
        "'scans/*.stl' -o maps/ --format glb --json > figures.jsonl    # one line a mesh",
        "- -o - --quiet < bunny.obj > atlas.obj",
    ),
    each=True,
)
