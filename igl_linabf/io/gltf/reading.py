"""Read glTF and GLB."""

from dataclasses import dataclass, replace
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..._types import FloatArray, IntArray
from ...surface import Polygons, distinct_corners
from ..materials import Material, as_gltf, of_gltf, srgb
from ..mesh_file import MeshFile
from ..parsing import Damaged, Extras, triangles_of_strips
from .images import maps_of
from .ngons import EXTENSION, polygons_among, turned_over
from .particulars import unshared
from .scene import Gltf, Mode, Placement, load_gltf, placements

COLOURS, NORMALS, TEXTURE = "COLOR_0", "NORMAL", "TEXCOORD_0"
UNMOVED = Placement("", np.eye(4))


class Primitive(NamedTuple):
    """Where the faces of a primitive are.

    Attributes
    ----------
    mesh, number : int
        Its place in the file.
    faces, corners : (#f,) int64 and (#c,) int64
        Of the polygons.
    vertex : (#c,) int64
        Its own vertex at each corner.
    mirrored : bool
        Whether the scene mirrors it, so that its own faces run the other way round.
    """

    mesh: int
    number: int
    faces: IntArray
    corners: IntArray
    vertex: IntArray
    mirrored: bool = False


@dataclass(frozen=True, eq=False)
class GltfFile:
    """The file itself.

    Attributes
    ----------
    frames : (#meshes, 3, 3) float64
        From the space of each mesh to that of the scene, but for a translation.
    """

    gltf: Gltf
    primitives: list[Primitive]
    frames: FloatArray


class _Content(NamedTuple):
    """What a primitive holds.

    Attributes
    ----------
    V : (#v, 3) float64
        Where the scene has its vertices.
    polygons : Polygons
        By these vertices.
    attributes : dict
        COLOURS, NORMALS and TEXTURE, (#v, width) float64 each, or None.
    material : int
        -1 if it has none.
    """

    V: FloatArray
    polygons: Polygons
    attributes: dict[str, FloatArray | None]
    material: int


def parse_gltf(path: Path) -> MeshFile:
    """The mesh of a glTF or GLB file; each mesh once, where the first node shows it."""
    try:
        return _parse_gltf(load_gltf(path))
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
        raise Damaged(
            f"its description is not as glTF 2.0 has it ({type(error).__name__}: {error})"
        ) from None


def _parse_gltf(gltf: Gltf) -> MeshFile:
    shown = placements(gltf)
    found = [
        (i, j, _content(gltf, primitive, i, shown.get(i, UNMOVED).matrix))
        for i, j, primitive in gltf.primitives()
    ]
    held = [content for _, _, content in found]
    polygons = [content.polygons for content in held]
    if not any(len(of.corners) for of in polygons):
        raise Damaged("it has no mesh of triangles")
    point, face, corner = (
        [0, *accumulate(sizes)]
        for sizes in (
            [len(of.V) for of in held],
            [len(of) for of in polygons],
            [len(of.corners) for of in polygons],
        )
    )
    frames = np.array([shown.get(i, UNMOVED).matrix[:3, :3] for i in range(len(gltf.listed("meshes")))])
    mirrored = np.linalg.det(frames) < 0
    primitives = [
        Primitive(
            i,
            j,
            np.arange(*face[k : k + 2]),
            np.arange(*corner[k : k + 2]),
            content.polygons.corners,
            bool(mirrored[i]),
        )
        for k, (i, j, content) in enumerate(found)
    ]
    V = np.concatenate([of.V for of in held])
    flat = np.concatenate([of.corners + start for of, start in zip(polygons, point[:-1], strict=True)])
    mesh = np.array([i for i, _, _ in found])
    used, merged = np.unique(_welded(V, np.repeat(mesh, np.diff(point)))[flat], return_inverse=True)
    made = MeshFile(
        V[used],
        Polygons(merged.ravel().astype(np.int64), np.concatenate([of.sizes for of in polygons])),
        extras=Extras(
            **_colours_and_normals(held, used, merged.ravel(), flat),
            **_materials(gltf, np.repeat([of.material for of in held], np.diff(face))),
            parts=(_names(gltf, shown), np.repeat(mesh, np.diff(face))),
            units="meter",
            unshared=unshared(gltf.text, sum(of.times - 1 for of in shown.values())),
            source=GltfFile(gltf, primitives, frames),
        ),
    )
    maps = [of.attributes[TEXTURE] for of in held]
    has = [map_ is not None and map_.shape[1] == 2 for map_ in maps]
    if not any(has):
        return made
    map_ = np.concatenate(
        [
            np.zeros((len(of.V), 2)) if m is None or not ok else m
            for m, ok, of in zip(maps, has, held, strict=True)
        ]
    )
    TC, same = np.unique(map_, axis=0, return_inverse=True)
    texture = np.where(np.repeat(has, np.diff(point))[flat], same.ravel()[flat], -1)
    return replace(made, TC=TC * [1, -1] + [0, 1], texture=texture.astype(np.int64))


def _content(gltf: Gltf, primitive: dict[str, Any], mesh: int, matrix: FloatArray) -> _Content:
    """What a primitive of a mesh holds, placed by a transform (4, 4)."""
    its, linear = primitive["attributes"], matrix[:3, :3]
    local = gltf.numbers(its["POSITION"])
    if local.ndim != 2 or local.shape[1] != 3:
        raise Damaged(f"the positions of its mesh {mesh} have not three columns")
    polygons = _polygons(gltf, primitive, len(local))
    if np.linalg.det(linear) < 0:
        polygons = turned_over(polygons)
    attributes: dict[str, FloatArray | None] = {}
    for name in (TEXTURE, COLOURS, NORMALS):
        values = gltf.numbers(its[name]) if name in its else None
        fits = values is not None and values.ndim == 2 and len(values) == len(local)
        attributes[name] = values if fits else None
    if (normals := attributes[NORMALS]) is not None:
        attributes[NORMALS] = normals @ np.linalg.pinv(linear)
    number = int(primitive.get("material", -1))
    material = number if number < len(gltf.listed("materials")) else -1
    with np.errstate(invalid="ignore"):  # infinite positions: whoever uses the mesh names their vertices
        V = local @ linear.T + matrix[:3, 3]
    return _Content(V, polygons, attributes, material)


def _colours_and_normals(
    held: list[_Content], used: IntArray, merged: IntArray, flat: IntArray
) -> dict[str, Any]:
    """Of `Extras`: colours at the vertices that are used, or at corners where copies differ; normals."""
    normals = _whole([of.attributes[NORMALS] for of in held])
    made: dict[str, Any] = {"normals": normals, "normal": None if normals is None else flat}
    colours = _colours([of.attributes[COLOURS] for of in held], [len(of.V) for of in held])
    if colours is None:
        return made
    colours = np.column_stack((srgb(colours[:, :3]), colours[:, 3:]))
    if (colours[used][merged] == colours[flat]).all():
        return {**made, "colours": colours[used]}
    return {**made, "corner_colours": colours[flat]}


def _materials(gltf: Gltf, of_face: IntArray) -> dict[str, Any]:
    """Of `Extras`: the materials and what they look like, if one has a name."""
    listed = gltf.listed("materials")
    plain = as_gltf(Material())  # texture coordinates are written with it where there is none
    while listed and listed[-1] == plain:
        listed.pop()
    if not listed:
        return {}
    of_face = np.where(of_face < len(listed), of_face, -1)
    names = tuple(str(material.get("name", f"material {i}")) for i, material in enumerate(listed))
    looks = tuple(replace(of_gltf(material), maps=maps_of(gltf, material)) for material in listed)
    return {"materials": (names, of_face), "looks": looks}


def _colours(rows: list[FloatArray | None], sizes: list[int]) -> FloatArray | None:
    """Of the vertices; those of primitives that have none are white, as glTF says."""
    if all(values is None for values in rows):
        return None
    width = max(values.shape[1] for values in rows if values is not None)
    made = [np.ones((n, width)) for n in sizes]
    for row, values in zip(made, rows, strict=True):
        if values is not None:
            row[:, : values.shape[1]] = values
    return np.concatenate(made)


def _names(gltf: Gltf, shown: dict[int, Placement]) -> tuple[str, ...]:
    """Of the meshes: those of the nodes that show them, or their own."""
    return tuple(
        shown.get(i, UNMOVED).name or str(mesh.get("name", f"mesh {i}"))
        for i, mesh in enumerate(gltf.listed("meshes"))
    )


def _whole(rows: list[FloatArray | None]) -> FloatArray | None:
    """An attribute, if all primitives have it in one width."""
    known = [values for values in rows if values is not None and values.ndim == 2]
    if len(known) < len(rows) or len({values.shape[1] for values in known}) > 1:
        return None
    return np.concatenate(known)


def _polygons(gltf: Gltf, primitive: dict[str, Any], n: int) -> Polygons:
    """The faces of a primitive, by its own vertices."""
    index = gltf.array(primitive["indices"]).astype(np.int64) if "indices" in primitive else np.arange(n)
    mode = primitive.get("mode", Mode.TRIANGLES)
    if mode == Mode.TRIANGLES:
        if len(index) % 3:
            raise Damaged(f"{len(index)} indices are no triangles")
        F = index.reshape(-1, 3)
    elif mode == Mode.TRIANGLE_STRIP:
        F, _ = triangles_of_strips(index, np.zeros_like(index))
        F = F[distinct_corners(F)]
    else:
        F = np.column_stack(
            (np.full(max(len(index) - 2, 0), index[0] if len(index) else 0), index[1:-1], index[2:])
        )
    if len(F) and int(F.max()) >= n:
        raise Damaged(f"triangles name vertices beyond the {n} of their mesh")
    return polygons_among(F) if EXTENSION in primitive.get("extensions", {}) else Polygons.of_triangles(F)


def _welded(V: FloatArray, mesh: IntArray) -> IntArray:
    """For each vertex the first of its mesh in the same place: glTF doubles them at creases and seams."""
    _, first, same = np.unique(
        np.column_stack((mesh, V + 0.0)), axis=0, return_index=True, return_inverse=True
    )
    return np.asarray(first[same.ravel()])
