"""What meshes of other libraries have beside points and faces, on a mesh with doubled vertices."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .._types import IntArray
from ..errors import MeshError

if TYPE_CHECKING:
    import pyvista
    import trimesh

CELLS_OF_NO_SURFACE = ("vertex", "line", "line3")  # of meshio


def check_alike(V: ArrayLike, F: ArrayLike, points: int, faces: int) -> None:
    """Raise where data of so many points and faces is not that of V and F."""
    given = np.shape(V)[0], np.shape(F)[0]
    if given != (points, faces):
        raise MeshError(
            f"like has {points} vertices and {faces} triangles, V and F have {given[0]} and {given[1]}: pass "
            "the mesh that they come from"
        )


def of_triangles(mesh: pyvista.PolyData) -> pyvista.PolyData:
    """The mesh, or its triangles, with their data."""
    return mesh if mesh.is_all_triangles else mesh.triangulate()


def keep_data_of_trimesh(mesh: trimesh.Trimesh, like: trimesh.Trimesh, vertex: IntArray) -> None:
    """Colours and attributes at vertices that are copies of others; faces are the same."""
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


def keep_data_of_pyvista(mesh: pyvista.PolyData, like: pyvista.PolyData, vertex: IntArray) -> None:
    """Arrays of points that are copies of others, of cells and of fields; which ones are active stays.

    The old texture coordinates, and the tangents made of them, are left out.
    """
    first = like.n_verts + like.n_lines  # cells of points and lines come before
    made_of_the_map = (like.GetPointData().GetTCoords(), like.GetPointData().GetTangents())
    old_names = {array.GetName() for array in made_of_the_map if array is not None}
    for name, values in like.point_data.items():
        if name not in old_names:
            mesh.point_data[name] = np.asarray(values)[vertex]
    for name, values in like.cell_data.items():
        mesh.cell_data[name] = np.asarray(values)[first : first + mesh.n_cells]
    for name, values in like.field_data.items():
        mesh.field_data[name] = values
    pairs: tuple[tuple[Any, Any], ...] = (
        (like.GetPointData(), mesh.GetPointData()),
        (like.GetCellData(), mesh.GetCellData()),
    )
    for old, new in pairs:
        for attribute in range(old.NUM_ATTRIBUTES):
            array = old.GetAbstractAttribute(attribute)
            if array is not None and new.HasArray(array.GetName()):
                new.SetActiveAttribute(array.GetName(), attribute)
