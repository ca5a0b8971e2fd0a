"""Copy the data of meshes from other libraries to meshes with duplicated vertices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .._types import IntArray
from ..errors import MeshError
from ..io import Damaged, without_strips

if TYPE_CHECKING:
    import pyvista
    import trimesh

NON_SURFACE_CELLS = ("vertex", "line", "line3")  # meshio's cell types that are not surfaces


def check_sizes(V: ArrayLike, F: ArrayLike, points: int, faces: int) -> None:
    """Raise if the numbers of points and faces differ from the numbers of rows of V and F."""
    sizes = np.shape(V)[0], np.shape(F)[0]
    if sizes != (points, faces):
        raise MeshError(
            f"like has {points} vertices and {faces} triangles, V and F have {sizes[0]} and {sizes[1]}: pass "
            "the mesh that they come from"
        )


def triangulate_polydata(mesh: pyvista.PolyData) -> pyvista.PolyData:
    """Return the mesh with all faces triangulated, and with the data of its faces."""
    if mesh.n_strips:
        try:
            mesh = without_strips(mesh)
        except Damaged as damage:
            raise MeshError(f"the mesh cannot be read: {damage}") from None
    return mesh if mesh.is_all_triangles else mesh.triangulate()


def copy_trimesh_data(mesh: trimesh.Trimesh, like: trimesh.Trimesh, vertex: IntArray) -> None:
    """Copy colours, attributes and metadata to a mesh whose vertices are copies of `vertex`."""
    kind = like.visual.kind
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
