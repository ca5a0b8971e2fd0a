"""GIFTI and FreeSurfer, which nibabel owns, and VTP, which pyvista owns."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .._types import FloatArray
from ..errors import MeshError, some
from ..surface import Polygons, topology_of
from .mesh_file import MeshFile
from .one_index import flat_surface, split_vertices
from .packages import call_reader, checked_mesh_file, import_optional
from .parsing import Column, Damaged, Extras, polygons_of

POINTS, TRIANGLES = "NIFTI_INTENT_POINTSET", "NIFTI_INTENT_TRIANGLE"
PATCH = np.dtype([("vertex", ">i4"), ("place", ">f4", 3)])  # of FreeSurfer, which nibabel does not write


def parse_gifti(path: Path) -> MeshFile:
    """The surface of a GIFTI file."""
    image = call_reader(import_optional("nibabel").load, path)
    try:
        (points,) = image.get_arrays_from_intent(POINTS)
        (triangles,) = image.get_arrays_from_intent(TRIANGLES)
    except (AttributeError, ValueError):
        raise Damaged("it has not one array of points and one of triangles: is it a .surf.gii?") from None
    V = np.asarray(points.data, dtype=np.float64)
    F = np.asarray(triangles.data)
    if V.ndim != 2 or V.shape[1] != 3 or F.ndim != 2 or F.shape[1] != 3:
        raise Damaged(f"its arrays have the shapes {V.shape} and {F.shape}, not three columns")
    return checked_mesh_file(
        V, Polygons.of_triangles(F.astype(np.int64)), Extras(source=image, units="millimeter")
    )


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


def save_gifti(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write the flat map as a surface, as flat cortices are."""
    gifti = import_optional("nibabel.gifti")
    points, triangles = flat_surface(mesh)
    meta = {"GeometricType": "Flat"}
    source = mesh.extras.source
    if hasattr(source, "get_arrays_from_intent"):
        given = dict(source.get_arrays_from_intent(POINTS)[0].meta)
        meta = {**{key: given[key] for key in given if key.startswith("Anatomical")}, **meta}
    arrays = [
        gifti.GiftiDataArray(points.astype(np.float32), intent=POINTS, meta=gifti.GiftiMetaData(meta)),
        gifti.GiftiDataArray(triangles.astype(np.int32), intent=TRIANGLES),
    ]
    image = gifti.GiftiImage(darrays=arrays)
    Path(temporary).write_bytes(image.to_bytes())


def parse_freesurfer(path: Path) -> MeshFile:
    """The surface of a FreeSurfer file, lh.pial for example."""
    V, F = call_reader(import_optional("nibabel.freesurfer").read_geometry, path)
    polygons = Polygons.of_triangles(np.asarray(F, dtype=np.int64))
    return checked_mesh_file(np.asarray(V, dtype=np.float64), polygons, Extras(units="millimeter"))


def save_surf(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write the flat map as a surface."""
    points, triangles = flat_surface(mesh)
    import_optional("nibabel.freesurfer").write_geometry(
        temporary, points, triangles, create_stamp="igl_linabf"
    )


def save_patch(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write a flat patch: the vertices that have a place in the plane, by their numbers on the surface.

    Numbers count from 1, and are negative on the boundary. The triangles are those of the surface.
    """
    made = split_vertices(mesh)
    vertex, times = np.unique(made.vertex, return_counts=True)
    if (times > 1).any():
        raise MeshError(
            f"vertices {some(vertex[times > 1])} are on seams, and a patch has one place for each: write "
            ".surf or .gii, or flatten a disk"
        )
    used, F = np.unique(mesh.triangles, return_inverse=True)
    loops = topology_of(F.reshape(-1, 3), used).loops
    on_loop = np.isin(made.vertex, used[np.concatenate(loops)] if loops else ())
    rows = np.zeros(len(vertex), dtype=PATCH)
    rows["vertex"] = np.where(on_loop, -1, 1) * (made.vertex + 1)
    rows["place"][:, :2] = made.TC
    head = np.array([-1, len(rows)], dtype=">i4")
    Path(temporary).write_bytes(head.tobytes() + rows.tobytes())
