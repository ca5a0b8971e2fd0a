"""VTP, the polygons of VTK, by pyvista."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..._types import FloatArray
from ..mesh_file import MeshFile
from ..parsing import Column, Damaged, Extras, polygons_of
from ..vertex_splits import split_vertices
from .optional_packages import call_reader, checked_mesh_file, import_optional


def parse_vtp(path: Path) -> MeshFile:
    """The polygons of a VTK file."""
    pyvista = import_optional("pyvista")
    mesh = call_reader(pyvista.read, path)
    if not isinstance(mesh, pyvista.PolyData):
        raise Damaged(f"it holds a {type(mesh).__name__}, no polygons")
    if mesh.n_strips:
        mesh = mesh.triangulate()
    if mesh.n_points == 0 or mesh.GetNumberOfPolys() == 0:
        raise Damaged("it has no polygons")
    cells = mesh.GetPolys()
    offsets = np.asarray(pyvista.convert_array(cells.GetOffsetsArray()), dtype=np.int64)
    corners = np.asarray(pyvista.convert_array(cells.GetConnectivityArray()), dtype=np.int64)
    polygons = polygons_of(Column(corners, np.diff(offsets)))
    if (polygons.sizes < 3).any():
        raise Damaged("it has polygons of less than three corners")
    TC = mesh.active_texture_coordinates
    normals = mesh.point_data.active_normals
    extras = Extras(
        colours=_colours(mesh),
        normals=None if normals is None else np.asarray(normals, dtype=np.float64),
        normal=None if normals is None else corners,
        source=mesh,
    )
    made = checked_mesh_file(np.asarray(mesh.points, dtype=np.float64), polygons, extras)
    if TC is None:
        return made
    map_, same = np.unique(np.asarray(TC, dtype=np.float64)[:, :2], axis=0, return_inverse=True)
    return replace(made, TC=map_, texture=same.ravel().astype(np.int64)[polygons.corners])


def _colours(mesh: Any) -> FloatArray | None:
    """The first array of bytes at the points with three or four columns, as VTK has colours."""
    for values in mesh.point_data.values():
        if values.dtype == np.uint8 and values.ndim == 2 and values.shape[1] in (3, 4):
            return np.asarray(values, dtype=np.float64) / 255
    return None


def save_vtp(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write polygons with texture coordinates at the points; all arrays that were read stay."""
    pyvista, made = import_optional("pyvista"), split_vertices(mesh)
    rows, source = made.vertex, mesh.extras.source
    faces = np.insert(made.corners, mesh.polygons.starts, mesh.polygons.sizes)
    written = pyvista.PolyData(mesh.V[rows], faces)
    if isinstance(source, pyvista.PolyData):
        first = source.n_verts + source.n_lines  # cells of points and lines come before
        for name, values in source.point_data.items():
            written.point_data[name] = np.asarray(values)[rows]
        for name, values in source.cell_data.items():
            written.cell_data[name] = np.asarray(values)[first : first + len(mesh.polygons)]
        for name, values in source.field_data.items():
            written.field_data[name] = values
    elif mesh.extras.colours is not None:
        written.point_data["RGB"] = np.round(np.clip(mesh.extras.colours[rows], 0, 1) * 255).astype(np.uint8)
    written.active_texture_coordinates = made.TC
    written.save(temporary)
