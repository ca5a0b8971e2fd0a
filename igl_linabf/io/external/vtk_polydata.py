"""VTP, the polygons of VTK, by pyvista."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..._types import FloatArray, IntArray
from ..materials import bytes_of_colours
from ..mesh_file import MeshFile
from ..parsing import Column, Damaged, Extras, polygons_of, triangles_of_strips
from ..vertex_splits import split_vertices
from .optional_packages import call_reader, checked_mesh_file, import_optional

# VTK's numbers of what an array may be, and how many there are: scalars, vectors, normals, ..., tangents
NORMALS, TEXTURE, TANGENTS, ATTRIBUTES = 2, 3, 10, 11
NEW_TEXTURE = "Texture Coordinates"


@dataclass(frozen=True, eq=False)
class VtpFile:
    """The file itself, of pyvista."""

    mesh: Any
    kept: tuple[str, ...]


def parse_vtp(path: Path) -> MeshFile:
    """The polygons of a VTK file."""
    pyvista = import_optional("pyvista")
    mesh = call_reader(_read_polydata, path)
    more = "its lines and points" if mesh.n_lines or mesh.n_verts else ""
    if mesh.n_strips:
        mesh = without_strips(mesh)
    if mesh.n_points == 0 or mesh.GetNumberOfPolys() == 0:
        raise Damaged("it has no polygons")
    corners, sizes = _cells(pyvista, mesh.GetPolys())
    polygons = polygons_of(Column(corners, sizes))
    if (polygons.sizes < 3).any():
        raise Damaged("it has polygons of less than three corners")
    texture = _texture(mesh.GetPointData())
    normals = mesh.point_data.active_normals
    arrays = _arrays(mesh)
    tangents = "its tangents" if _named(mesh.GetPointData(), TANGENTS) else ""
    extras = Extras(
        colours=_colours(mesh.point_data, 0, mesh.n_points),
        face_colours=_colours(mesh.cell_data, mesh.n_verts + mesh.n_lines, len(polygons)),
        normals=None if normals is None else np.asarray(normals, dtype=np.float64),
        normal=None if normals is None else corners,
        unshared=tuple(filter(None, (arrays, more, tangents))),
        source=VtpFile(mesh, (arrays,)),
    )
    made = checked_mesh_file(np.asarray(mesh.points, dtype=np.float64), polygons, extras)
    if texture is None:
        return made
    TC = np.asarray(mesh.point_data[texture], dtype=np.float64)[:, :2]
    map_, same = np.unique(TC, axis=0, return_inverse=True)
    return replace(made, TC=map_, texture=same.ravel().astype(np.int64)[polygons.corners])


def _read_polydata(path: str) -> Any:
    """What VTK reads. It prints what is damaged and goes on without: the first of its errors is raised."""
    pyvista, readers = (import_optional(name) for name in ("pyvista", "vtkmodules.vtkIOXML"))
    with pyvista.vtk_verbosity("off"), pyvista.VtkErrorCatcher(send_to_logging=False) as caught:
        reader = readers.vtkXMLPolyDataReader()
        reader.SetFileName(path)
        reader.Update()
    errors = [event.alert for event in caught.events if event.kind.upper() != "WARNING"]
    if errors:
        raise Damaged(errors[0].splitlines()[0])
    return pyvista.wrap(reader.GetOutput())


def _cells(pyvista: Any, cells: Any) -> tuple[IntArray, IntArray]:
    """The points of VTK's cells, cell after cell, and how many each has."""
    offsets, corners = (
        np.asarray(pyvista.convert_array(array), dtype=np.int64)
        for array in (cells.GetOffsetsArray(), cells.GetConnectivityArray())
    )
    return corners, np.diff(offsets)


def without_strips(mesh: Any) -> Any:
    """The same with the triangles of its strips, whose data are those of their strip.

    VTK's own filter leaves data of cells behind that nobody has written.
    """
    pyvista = import_optional("pyvista")
    (corners, sizes), (of_strips, lengths) = (
        _cells(pyvista, cells) for cells in (mesh.GetPolys(), mesh.GetStrips())
    )
    if (lengths < 3).any() or of_strips.max(initial=0) >= mesh.n_points:
        raise Damaged("it has triangle strips of less than three points, or of points that are not there")
    triangles, strip = triangles_of_strips(of_strips, np.repeat(np.arange(len(lengths)), lengths))
    faces = np.insert(corners, np.cumsum(sizes) - sizes, sizes)
    faces = np.concatenate((faces, np.insert(triangles, 0, 3, axis=1).ravel()))
    more = {"verts": mesh.verts} if mesh.n_verts else {}
    if mesh.n_lines:
        more["lines"] = mesh.lines
    made = pyvista.PolyData(mesh.points, faces, **more)
    made.GetPointData().ShallowCopy(mesh.GetPointData())
    made.GetFieldData().ShallowCopy(mesh.GetFieldData())
    before = mesh.n_verts + mesh.n_lines + len(sizes)
    rows = np.concatenate((np.arange(before), before + strip))
    for name, values in mesh.cell_data.items():
        made.cell_data[name] = np.asarray(values)[rows]
    _mark(mesh.GetCellData(), made.GetCellData())
    return made


def _arrays(mesh: Any) -> str:
    """The arrays that are nothing but numbers, as a warning names them."""
    points = mesh.GetPointData()
    taken = {_named(points, NORMALS), _texture(points), _named(points, TANGENTS)}
    taken |= {_colour_array(mesh.point_data), _colour_array(mesh.cell_data)}
    held = (*mesh.point_data.items(), *mesh.cell_data.items(), *mesh.field_data.items())
    names = [name for name, _ in held if name not in taken]
    return f"the arrays {', '.join(names)}" if names else ""


def _named(data: Any, attribute: int) -> str | None:
    """The array of VTK that is this attribute."""
    array = data.GetAbstractAttribute(attribute)
    return None if array is None else str(array.GetName())


def _texture(points: Any) -> str | None:
    """The array of texture coordinates; one number a point is no place in an image."""
    name = _named(points, TEXTURE)
    return name if name is not None and points.GetArray(name).GetNumberOfComponents() > 1 else None


def _colour_array(arrays: Any) -> str | None:
    """The first array of bytes with three or four columns, as VTK has colours."""
    for name, values in arrays.items():
        if values.dtype == np.uint8 and values.ndim == 2 and values.shape[1] in (3, 4):
            return str(name)
    return None


def _colours(arrays: Any, first: int, count: int) -> FloatArray | None:
    """The colours of some rows."""
    name = _colour_array(arrays)
    return None if name is None else np.asarray(arrays[name], dtype=np.float64)[first : first + count] / 255


def save_vtp(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write polygons with texture coordinates at the points; all arrays that were read stay."""
    pyvista, source, extras = import_optional("pyvista"), mesh.extras.source, mesh.extras
    made = split_vertices(mesh, normals=not isinstance(source, VtpFile))
    rows = made.vertex
    faces = np.insert(made.corners, mesh.polygons.starts, mesh.polygons.sizes)
    written = pyvista.PolyData(mesh.V[rows], faces)
    name = NEW_TEXTURE
    if isinstance(source, VtpFile):
        name = _texture(source.mesh.GetPointData()) or NEW_TEXTURE
        keep_data_of_polydata(written, source.mesh, rows)
    else:
        if extras.colours is not None:
            written.point_data["RGB"] = bytes_of_colours(extras.colours[rows])
        if extras.face_colours is not None:
            written.cell_data["RGB"] = bytes_of_colours(extras.face_colours)
        if made.normals is not None:
            written.point_data["Normals"] = made.normals
            written.GetPointData().SetActiveAttribute("Normals", NORMALS)
    written.point_data[name] = made.TC
    written.GetPointData().SetActiveAttribute(name, TEXTURE)
    written.save(temporary)


def keep_data_of_polydata(written: Any, given: Any, rows: IntArray) -> None:
    """Arrays of points that are copies of rows, of cells and of fields; which ones are active stays.

    The old texture coordinates, and the tangents made of them, are left out.
    """
    first = given.n_verts + given.n_lines  # cells of points and lines come before
    points = given.GetPointData()
    made_of_the_map = {_texture(points), _named(points, TANGENTS)}
    for name, values in given.point_data.items():
        if name not in made_of_the_map:
            written.point_data[name] = np.asarray(values)[rows]
    for name, values in given.cell_data.items():
        written.cell_data[name] = np.asarray(values)[first : first + written.n_cells]
    for name, values in given.field_data.items():
        written.field_data[name] = values
    _mark(given.GetPointData(), written.GetPointData())
    _mark(given.GetCellData(), written.GetCellData())


def _mark(given: Any, written: Any) -> None:
    """Say again which arrays are scalars, normals and so on."""
    for attribute in range(ATTRIBUTES):
        name = _named(given, attribute)
        if name is not None and written.HasArray(name):
            written.SetActiveAttribute(name, attribute)
