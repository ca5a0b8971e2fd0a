"""Copy the data of meshes from other libraries to meshes with duplicated vertices."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .._types import IntArray
from ..errors import MeshError, MeshWarning, format_count, stack_level
from ..io import Damaged, triangulate_strip_cells

if TYPE_CHECKING:
    import meshio
    import open3d
    import pyvista
    import trimesh

NON_SURFACE_CELLS = ("vertex", "line", "line3")  # meshio cell types that are not surfaces
IMAGE_FIELDS = (
    "image",
    "baseColorTexture",
    "emissiveTexture",
    "metallicRoughnessTexture",
    "normalTexture",
    "occlusionTexture",
)  # attributes of trimesh materials that hold images


def check_sizes(V: ArrayLike, F: ArrayLike, points: int, faces: int) -> None:
    """Raise a `MeshError` unless V and F have the given numbers of points and faces."""
    sizes = np.shape(V)[0], np.shape(F)[0]
    if sizes != (points, faces):
        raise MeshError(
            f"like has {format_count(points, 'vertex')} and {format_count(faces, 'triangle')}, V and F "
            f"have {sizes[0]} and {sizes[1]}: pass "
            "the mesh that they come from"
        )


def triangulate_polydata(mesh: pyvista.PolyData) -> pyvista.PolyData:
    """Triangulate all faces of a mesh; the triangles get the data of their faces."""
    if mesh.n_strips:
        try:
            mesh = triangulate_strip_cells(mesh)
        except Damaged as damage:
            raise MeshError(f"the mesh cannot be read: {damage}") from None
    return mesh if mesh.is_all_triangles else mesh.triangulate()


def copy_trimesh_data(mesh: trimesh.Trimesh, like: trimesh.Trimesh, vertex: IntArray) -> None:
    """Copy normals, materials, colours and other data to a mesh with copies of the vertices `vertex`."""
    mesh.vertex_normals = np.asarray(like.vertex_normals)[vertex]
    kind = like.visual.kind
    if kind == "texture":
        _copy_materials(mesh, like)
    if kind == "vertex":
        mesh.visual.vertex_attributes["color"] = like.visual.vertex_colors[vertex]
    elif kind == "face":
        mesh.face_attributes["color"] = np.array(like.visual.face_colors)
    elif kind == "texture" and like.visual.vertex_attributes.get("color") is not None:
        mesh.visual.vertex_attributes["color"] = like.visual.vertex_attributes["color"][vertex]
    for name, values in like.vertex_attributes.items():
        mesh.vertex_attributes[name] = np.asarray(values)[vertex]
    mesh.face_attributes.update(like.face_attributes)
    mesh.metadata.update(like.metadata)


def _copy_materials(mesh: trimesh.Trimesh, like: trimesh.Trimesh) -> None:
    """Copy materials; their images are copied only if the texture coordinates are unchanged."""
    old, new = like.visual, mesh.visual
    new.face_materials = None if old.face_materials is None else np.array(old.face_materials)
    same = old.uv is not None and np.array_equal(old.uv[like.faces], new.uv[mesh.faces])
    several = isinstance(old.material, Iterable)  # a MultiMaterial
    materials = list(old.material) if several else [old.material]
    copies = [_copy_material(material, same) for material in materials]
    new.material = type(old.material)(copies) if several else copies[0]
    images = sum(getattr(material, name, None) is not None for material in materials for name in IMAGE_FIELDS)
    if images and not same:
        _warn_of_images(images)


def _copy_material(material: Any, with_images: bool) -> Any:
    """Copy a trimesh material, with or without its images."""
    made = material.copy()
    for name in () if with_images else IMAGE_FIELDS:
        if getattr(made, name, None) is not None:
            setattr(made, name, None)
    return made


def _warn_of_images(count: int) -> None:
    """Warn that `count` images are left out because they belong to old texture coordinates."""
    warnings.warn(
        f"like has {format_count(count, 'image')} for its old texture coordinates, and the result has none: "
        "bake_texture moves images to new ones",
        MeshWarning,
        stacklevel=stack_level(),
    )


def copy_open3d_data(mesh: open3d.geometry.TriangleMesh, like: open3d.geometry.TriangleMesh) -> None:
    """Copy colours, normals and the materials of triangles to a mesh with the same vertices and triangles."""
    mesh.vertex_colors, mesh.vertex_normals = like.vertex_colors, like.vertex_normals
    mesh.triangle_normals = like.triangle_normals
    if like.has_triangle_material_ids():
        mesh.triangle_material_ids = like.triangle_material_ids
    if len(like.textures):
        _warn_of_images(len(like.textures))


def copy_meshio_sets(
    like: meshio.Mesh, blocks: list[int], vertex: IntArray
) -> tuple[dict[str, IntArray], dict[str, list[IntArray]]]:
    """Renumber the point sets and cell sets of a mesh whose vertices are duplicated and blocks are merged.

    `blocks` are the numbers of the blocks of triangles, and `vertex` has the original vertex of each copy.
    """
    points = {name: np.flatnonzero(np.isin(vertex, rows)) for name, rows in like.point_sets.items()}
    start = np.cumsum([0, *(len(like.cells[i].data) for i in blocks)])
    cells = {
        name: [
            np.concatenate(
                [
                    np.asarray([] if rows[i] is None else rows[i], dtype=np.int64) + first
                    for i, first in zip(blocks, start[:-1], strict=True)
                ]
            )
        ]
        for name, rows in like.cell_sets.items()
    }
    return points, cells
