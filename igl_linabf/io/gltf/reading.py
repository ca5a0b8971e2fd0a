"""Read the mesh of glTF and GLB files."""

from dataclasses import dataclass, replace
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..._types import FloatArray, IntArray
from ...errors import format_count
from ...surface import Polygons, has_distinct_corners
from ..materials import Material, encode_srgb, make_gltf_material, parse_gltf_material
from ..mesh_file import MeshFile
from ..parsing import Damaged, Extras, triangulate_strips
from .container import load_gltf
from .images import find_texture_images
from .ngons import EXTENSION, merge_fans, reverse_polygons
from .scene import Gltf, Mode, Placement, find_placements
from .unshared import list_unshared

COLOURS, NORMALS, TEXTURE, SECOND_TEXTURE = "COLOR_0", "NORMAL", "TEXCOORD_0", "TEXCOORD_1"
IDENTITY_PLACEMENT = Placement("", np.eye(4))


class Primitive(NamedTuple):
    """The faces of the mesh that belong to a primitive.

    Attributes
    ----------
    mesh, number : int
        The mesh of the primitive, and its number within this mesh.
    faces, corners : (#f,) int64 and (#c,) int64
        Faces and corners in the polygons of the whole file.
    vertex : (#c,) int64
        The primitive's vertex at each corner.
    mirrored : bool
        Whether the scene mirrors the primitive, which reverses the orientation of its faces.
    """

    mesh: int
    number: int
    faces: IntArray
    corners: IntArray
    vertex: IntArray
    mirrored: bool = False


@dataclass(frozen=True, eq=False)
class GltfFile:
    """The contents of a glTF file.

    Attributes
    ----------
    gltf : Gltf
    primitives : list of Primitive
    frames : (#meshes, 3, 3) float64
        The linear map from the space of each mesh to the space of the scene.
    """

    gltf: Gltf
    primitives: list[Primitive]
    frames: FloatArray


class _PrimitiveContent(NamedTuple):
    """The contents of a primitive.

    Attributes
    ----------
    V : (#v, 3) float64
        Vertices in the space of the scene.
    rows : (#v,) int64
        The row of each vertex in the accessors.
    polygons : Polygons
        Faces over these vertices.
    attributes : dict
        COLOURS, NORMALS and TEXTURE, each (#v, width) float64 or None.
    material : int
        -1 for a primitive without a material.
    """

    V: FloatArray
    rows: IntArray
    polygons: Polygons
    attributes: dict[str, FloatArray | None]
    material: int


def parse_gltf(path: Path, allow_outside: bool = False) -> MeshFile:
    """Read a glTF or GLB file. A mesh with several instances is read once, at its largest instance."""
    gltf = load_gltf(path, allow_outside)
    placement_of_mesh = find_placements(gltf)
    found = [
        (i, j, _read_primitive(gltf, primitive, placement_of_mesh.get(i, IDENTITY_PLACEMENT).matrix))
        for i, j, primitive in gltf.iterate_primitives()
    ]
    contents = [content for _, _, content in found]
    polygons = [content.polygons for content in contents]
    if not any(len(part.corners) for part in polygons):
        raise Damaged("it has no mesh of triangles")
    point, face, corner = (
        [0, *accumulate(sizes)]
        for sizes in (
            [len(part.V) for part in contents],
            [len(part) for part in polygons],
            [len(part.corners) for part in polygons],
        )
    )
    frames = np.array(
        [
            placement_of_mesh.get(i, IDENTITY_PLACEMENT).matrix[:3, :3]
            for i in range(len(gltf.get_entries("meshes")))
        ]
    )
    mirrored = np.linalg.det(frames) < 0
    primitives = [
        Primitive(
            i,
            j,
            np.arange(*face[k : k + 2]),
            np.arange(*corner[k : k + 2]),
            content.rows[content.polygons.corners],
            bool(mirrored[i]),
        )
        for k, (i, j, content) in enumerate(found)
    ]
    V = np.concatenate([part.V for part in contents])
    corner_vertices = np.concatenate(
        [part.corners + start for part, start in zip(polygons, point[:-1], strict=True)]
    )
    mesh = np.array([i for i, _, _ in found])
    used, merged = np.unique(
        _weld_vertices(V, np.repeat(mesh, np.diff(point)))[corner_vertices], return_inverse=True
    )
    mesh_file = MeshFile(
        V[used],
        Polygons(merged.ravel().astype(np.int64), np.concatenate([part.sizes for part in polygons])),
        extras=Extras(
            **_gather_colours_and_normals(contents, used, merged.ravel(), corner_vertices),
            **_read_materials(gltf, np.repeat([part.material for part in contents], np.diff(face))),
            parts=(_name_meshes(gltf, placement_of_mesh), np.repeat(mesh, np.diff(face))),
            units="meter",
            unshared=list_unshared(gltf.text, sum(part.times - 1 for part in placement_of_mesh.values())),
            source=GltfFile(gltf, primitives, frames),
        ),
    )
    TC, texture = _gather_texture(
        contents, np.repeat(np.arange(len(contents)), np.diff(point)), corner_vertices
    )
    return mesh_file if TC is None else replace(mesh_file, TC=TC, texture=texture)


def select_second_uv_set(mesh: MeshFile, source: GltfFile) -> MeshFile:
    """Return a mesh with its second texture coordinates, and the images that use them."""
    gltf, n = source.gltf, len(mesh.polygons.corners)
    at_corners, has_any = np.zeros((n, 2)), np.zeros(n, dtype=bool)
    for place in source.primitives:
        attributes = gltf.text["meshes"][place.mesh]["primitives"][place.number]["attributes"]
        if SECOND_TEXTURE in attributes:
            at_corners[place.corners] = gltf.read_numbers(attributes[SECOND_TEXTURE], place.vertex)
            has_any[place.corners] = True
    TC, same = np.unique(at_corners[has_any], axis=0, return_inverse=True)
    texture = np.full(n, -1)
    texture[has_any] = same.ravel()
    looks = tuple(
        replace(look, maps=find_texture_images(gltf, material, 1))
        for look, material in zip(mesh.extras.looks or (), gltf.get_entries("materials"), strict=False)
    )
    extras = replace(mesh.extras, looks=looks or None)
    return replace(mesh, TC=TC * [1, -1] + [0, 1], texture=texture, extras=extras)


def _gather_texture(
    contents: list[_PrimitiveContent], of: IntArray, corner_vertices: IntArray
) -> tuple[FloatArray | None, IntArray]:
    """Return the texture coordinates of all primitives, and their row at each corner, -1 where missing.

    `of` is the primitive of each vertex. The coordinates are None if no primitive has any.
    """
    maps = [part.attributes[TEXTURE] for part in contents]
    has_map = np.array([map_ is not None for map_ in maps])
    if not has_map.any():
        return None, corner_vertices
    map_ = np.concatenate(
        [np.zeros((len(part.V), 2)) if m is None else m for m, part in zip(maps, contents, strict=True)]
    )
    TC, same = np.unique(map_, axis=0, return_inverse=True)
    texture = np.where(has_map[of][corner_vertices], same.ravel()[corner_vertices], -1)
    return TC * [1, -1] + [0, 1], texture.astype(np.int64)


def _read_primitive(gltf: Gltf, primitive: dict[str, Any], matrix: FloatArray) -> _PrimitiveContent:
    """Read the contents of a primitive, transformed by a matrix (4, 4)."""
    indices_of_attribute, linear = primitive["attributes"], matrix[:3, :3]
    polygons = _read_polygons(gltf, primitive, gltf.count_rows(indices_of_attribute["POSITION"]))
    rows, corners = np.unique(polygons.corners, return_inverse=True)  # primitives may share accessors
    polygons = Polygons(corners.ravel().astype(np.int64), polygons.sizes)
    local = gltf.read_numbers(indices_of_attribute["POSITION"], rows)
    if np.linalg.det(linear) < 0:
        polygons = reverse_polygons(polygons)
    attributes = {
        name: gltf.read_numbers(indices_of_attribute[name], rows) if name in indices_of_attribute else None
        for name in (TEXTURE, COLOURS, NORMALS)
    }
    if (normals := attributes[NORMALS]) is not None:
        attributes[NORMALS] = normals @ np.linalg.pinv(linear)
    with np.errstate(
        over="ignore", invalid="ignore"
    ):  # infinite positions are reported later, by `vertex_array`
        V = local @ linear.T + matrix[:3, 3]
    return _PrimitiveContent(V, rows, polygons, attributes, primitive.get("material", -1))


def _gather_colours_and_normals(
    contents: list[_PrimitiveContent], used: IntArray, merged: IntArray, flat: IntArray
) -> dict[str, Any]:
    """Return the colours and normals of all primitives as fields of `Extras`.

    Colours are per vertex, or per corner if merged vertices have different colours.
    """
    normals = _concatenate_if_complete([part.attributes[NORMALS] for part in contents])
    gathered: dict[str, Any] = {"normals": normals, "normal": None if normals is None else flat}
    colours = _stack_colours(
        [part.attributes[COLOURS] for part in contents], [len(part.V) for part in contents]
    )
    if colours is None:
        return gathered
    colours = np.column_stack((encode_srgb(colours[:, :3]), colours[:, 3:]))
    if (colours[used][merged] == colours[flat]).all():
        return {**gathered, "colours": colours[used]}
    return {**gathered, "corner_colours": colours[flat]}


def _read_materials(gltf: Gltf, of_face: IntArray) -> dict[str, Any]:
    """Return the names and the appearance of the materials as fields of `Extras`."""
    listed = gltf.get_entries("materials")
    plain = make_gltf_material(Material())  # `save_new_gltf` appends this material for faces without one
    while listed and listed[-1] == plain:
        listed.pop()
    if not listed:
        return {}
    of_face = np.where(of_face < len(listed), of_face, -1)
    names = tuple(str(material.get("name", f"material {i}")) for i, material in enumerate(listed))
    looks = tuple(
        replace(parse_gltf_material(material), maps=find_texture_images(gltf, material))
        for material in listed
    )
    return {"materials": (names, of_face), "looks": looks}


def _stack_colours(rows: list[FloatArray | None], sizes: list[int]) -> FloatArray | None:
    """Return the colours of all vertices; primitives without colours are white, as glTF specifies."""
    if all(values is None for values in rows):
        return None
    width = max(values.shape[1] for values in rows if values is not None)
    filled = [np.ones((n, width)) for n in sizes]
    for row, values in zip(filled, rows, strict=True):
        if values is not None:
            row[:, : values.shape[1]] = values
    return np.concatenate(filled)


def _name_meshes(gltf: Gltf, placement_of_mesh: dict[int, Placement]) -> tuple[str, ...]:
    """Return the name of each mesh: the name of its node, or otherwise its own name."""
    return tuple(
        placement_of_mesh.get(i, IDENTITY_PLACEMENT).name or str(mesh.get("name", f"mesh {i}"))
        for i, mesh in enumerate(gltf.get_entries("meshes"))
    )


def _concatenate_if_complete(rows: list[FloatArray | None]) -> FloatArray | None:
    """Return an attribute of all primitives; None unless all primitives have it with the same width."""
    known = [values for values in rows if values is not None]
    if len(known) < len(rows) or len({values.shape[1] for values in known}) > 1:
        return None
    return np.concatenate(known)


def _read_polygons(gltf: Gltf, primitive: dict[str, Any], n: int) -> Polygons:
    """Return the faces of a primitive over its own vertices."""
    index = gltf.read_array(primitive["indices"]).astype(np.int64) if "indices" in primitive else np.arange(n)
    if len(index) and int(index.max()) >= n:
        raise Damaged(f"triangles refer to vertices beyond the {format_count(n, 'vertex')} of their mesh")
    mode = primitive.get("mode", Mode.TRIANGLES)
    if mode == Mode.TRIANGLES:
        if len(index) % 3:
            raise Damaged(f"{len(index)} indices do not form triangles")
        F = index.reshape(-1, 3)
    elif mode == Mode.TRIANGLE_STRIP:
        F, _ = triangulate_strips(index, np.zeros_like(index))
        F = F[has_distinct_corners(F)]
    else:
        F = np.column_stack(
            (np.full(max(len(index) - 2, 0), index[0] if len(index) else 0), index[1:-1], index[2:])
        )
    return merge_fans(F) if EXTENSION in primitive.get("extensions", {}) else Polygons.from_triangles(F)


def _weld_vertices(V: FloatArray, mesh: IntArray) -> IntArray:
    """Return for each vertex the first vertex of its mesh at the same position.

    glTF duplicates vertices at creases and seams.
    """
    _, first, same = np.unique(
        np.column_stack((mesh, V + 0.0)), axis=0, return_index=True, return_inverse=True
    )
    return np.asarray(first[same.ravel()])
